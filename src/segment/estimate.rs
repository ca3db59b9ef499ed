//! A data model and the parameters of its regions, whatever their type: all that the alternation knows of them.
//!
//! The alternation is thus compiled once for each number of regions, and not again for each model, in the library or
//! outside it.

use std::borrow::Cow;

use rand_pcg::Pcg64;

use crate::data::{Cost, DataModel, Initial, Scale, Weights, rows};
use crate::error::Result;
use crate::field::Row;
use crate::mesh::coarsen::Coarsening;
use crate::units::Unit;

/// A [`DataModel`] on the current mesh, the given one or a coarser one, and mu.
pub trait Estimate: Sync {
    /// Whether the datum of vertex k is known.
    fn is_known(&self, k: usize) -> bool;

    /// Number of vertices.
    fn vertices(&self) -> usize;

    /// [`DataModel::different`].
    fn different(&self, most: usize) -> usize;

    /// [`DataModel::scale`].
    fn scale(&self, weights: &[f64]) -> Scale;

    /// [`DataModel::VALUE_NAME`].
    fn value_name(&self) -> &'static str;

    /// m; 0 before the start.
    fn regions(&self) -> usize;

    /// Sets mu by [`DataModel::start`].
    ///
    /// # Errors
    /// As those of [`DataModel::fit`].
    fn start(&mut self, initial: Initial, m: usize, weights: &[f64], rng: &mut Pcg64)
    -> Result<()>;

    /// Sets mu to the initial parameters.
    fn reset(&mut self);

    /// [`DataModel::cost`], in the unit of cost.
    fn cost(&self) -> Cost<'_>;

    /// Sets the unit of cost, which is 1 at first.
    fn set_unit(&mut self, unit: Unit);

    /// [`DataModel::fit`].
    ///
    /// # Errors
    /// Those of [`DataModel::fit`].
    fn fit(&mut self, weights: Weights<'_>) -> Result<f64>;

    /// The change that [`DataModel::fit`] would make to mu, which stays as it is.
    ///
    /// # Errors
    /// Those of [`DataModel::fit`].
    fn change(&self, weights: Weights<'_>) -> Result<f64>;

    /// The distance between regions a and b.
    fn distance(&self, a: usize, b: usize) -> f64;

    /// Restricts the model to a coarser mesh by [`DataModel::restricted`].
    fn coarsen(&mut self, level: &Coarsening, weights: &[f64], coarse: &[f64]);

    /// Returns from a coarser mesh to the next finer one.
    fn refine(&mut self);

    /// The same model without parameters.
    fn without_parameters(&self) -> Box<dyn Estimate + '_>;
}

impl dyn Estimate + '_ {
    /// s_p(x_k), one row per vertex; 0 at unknown vertices and for padding regions.
    pub fn costs<const M: usize>(&self) -> Vec<Row<M>> {
        rows(self.vertices(), self.regions(), |k| self.is_known(k), &*self.cost())
    }

    /// Restricts the model, and the vertex weights w, to a coarser mesh; returns P^T w over the known vertices.
    pub fn restrict(&mut self, level: &Coarsening, weights: &[f64]) -> Vec<f64> {
        let coarse = level.restricted(weights, |v| self.is_known(v));
        self.coarsen(level, weights, &coarse);
        coarse
    }
}

/// The [`Estimate`] for one type of data model.
pub struct ModelEstimate<'a, D: DataModel> {
    /// The model on the finest mesh and on coarser ones, down to the current mesh.
    models: Vec<Cow<'a, D>>,
    initial: Vec<D::Parameters>,
    mu: Vec<D::Parameters>,
    /// `None` if it is 1.
    unit: Option<Unit>,
}

impl<'a, D: DataModel> ModelEstimate<'a, D> {
    /// With these initial parameters; there are none before the start.
    pub fn new(model: Cow<'a, D>, initial: Vec<D::Parameters>) -> Self {
        ModelEstimate { models: vec![model], mu: initial.clone(), initial, unit: None }
    }

    /// mu.
    pub fn into_parameters(self) -> Vec<D::Parameters> {
        self.mu
    }

    fn model(&self) -> &D {
        self.models.last().expect("the finest is never removed")
    }
}

impl<D: DataModel> Estimate for ModelEstimate<'_, D> {
    fn is_known(&self, k: usize) -> bool {
        self.model().is_known(k)
    }

    fn vertices(&self) -> usize {
        self.model().vertices()
    }

    fn different(&self, most: usize) -> usize {
        self.model().different(most)
    }

    fn scale(&self, weights: &[f64]) -> Scale {
        self.model().scale(weights)
    }

    fn value_name(&self) -> &'static str {
        D::VALUE_NAME
    }

    fn regions(&self) -> usize {
        self.mu.len()
    }

    fn start(
        &mut self,
        initial: Initial,
        m: usize,
        weights: &[f64],
        rng: &mut Pcg64,
    ) -> Result<()> {
        self.initial = self.model().start(initial, m, weights, rng)?;
        self.reset();
        Ok(())
    }

    fn reset(&mut self) {
        self.mu.clone_from(&self.initial);
    }

    fn cost(&self) -> Cost<'_> {
        let cost = self.model().cost(&self.mu);
        let Some(unit) = self.unit else { return cost };
        Box::new(move |k, row| {
            cost(k, row);
            row.iter_mut().for_each(|s| *s = unit.of_number(*s));
        })
    }

    fn set_unit(&mut self, unit: Unit) {
        self.unit = Some(unit);
    }

    fn fit(&mut self, weights: Weights<'_>) -> Result<f64> {
        let ModelEstimate { models, mu, .. } = self;
        models.last().expect("the finest is never removed").fit(weights, mu)
    }

    fn change(&self, weights: Weights<'_>) -> Result<f64> {
        self.model().fit(weights, &mut self.mu.clone())
    }

    fn distance(&self, a: usize, b: usize) -> f64 {
        D::distance(&self.mu[a], &self.mu[b])
    }

    fn coarsen(&mut self, level: &Coarsening, weights: &[f64], coarse: &[f64]) {
        let restricted = self.model().restricted(level, weights, coarse);
        self.models.push(Cow::Owned(restricted));
    }

    fn refine(&mut self) {
        assert!(self.models.len() > 1, "the mesh is the finest");
        self.models.pop();
    }

    fn without_parameters(&self) -> Box<dyn Estimate + '_> {
        let unit = self.unit;
        Box::new(ModelEstimate {
            unit,
            ..ModelEstimate::new(Cow::Borrowed(self.model()), Vec::new())
        })
    }
}
