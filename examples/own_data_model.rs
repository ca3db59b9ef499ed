//! Implements your own data model: `cargo run --release --no-default-features --example own_data_model`.
//!
//! The data are directions on a surface, here its normals, and each region has one mean direction:
//!
//! ```text
//! s_p(x) = 1 - <n(x), mu_p>,     mu_p = int u_p n / | int u_p n |
//! ```
//!
//! The sides of a rounded cube are the six regions. I. S. Dhillon, D. S. Modha, *Concept decompositions for large
//! sparse text data using clustering*, Machine Learning 42, 2001.

use std::borrow::Cow;
use std::ops::ControlFlow;

use meshseg::data::{Cost, DataModel, Initial, Scale, Weights};
use meshseg::mesh::coarsen::Coarsening;
use meshseg::mesh::order::Order;
use meshseg::mesh::source;
use meshseg::operator::Mass;
use meshseg::run::Stop;
use meshseg::seeds::Seeds;
use meshseg::segment::{Alternation, segment};
use meshseg::solve::Request;
use meshseg::solver::Method;
use nalgebra::Vector3;
use rand::RngExt;
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

#[derive(Clone)]
struct Directions {
    /// n at each vertex; shorter than 1 on coarser meshes, where it is a mean.
    n: Vec<Vector3<f64>>,
}

/// mu_p.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Direction {
    direction: [f64; 3],
}

impl DataModel for Directions {
    type Parameters = Direction;

    type Datum = Vector3<f64>;

    const VALUE_NAME: &'static str = "direction";

    fn value(mu: &Direction) -> &[f64] {
        &mu.direction
    }

    fn vertices(&self) -> usize {
        self.n.len()
    }

    fn at(&self, k: usize) -> Option<&Vector3<f64>> {
        Some(&self.n[k])
    }

    fn in_order(&self, order: &Order) -> Cow<'_, Self> {
        Cow::Owned(Directions { n: order.applied(self.n.clone()) })
    }

    /// P^T (w n) / P^T w: the costs are linear in n, so that the costs of the means are the restricted costs.
    fn restricted(&self, level: &Coarsening, weights: &[f64], coarse: &[f64]) -> Self {
        let mut n = vec![Vector3::zeros(); coarse.len()];
        for (v, parents) in level.parents.iter().enumerate() {
            for (&c, share) in parents.corners.iter().zip(parents.weights) {
                n[c as usize] += share * weights[v] * self.n[v];
            }
        }
        n.iter_mut().zip(coarse).filter(|(_, w)| **w > 0.0).for_each(|(n, w)| *n /= *w);
        Directions { n }
    }

    /// Costs lie between 0 and 2 for all data.
    fn scale(&self, _: &[f64]) -> Scale {
        Scale { cost: 0.5, distance: 1.0, change: 1.0 }
    }

    /// The normal of a random vertex, then repeatedly the normal that is farthest from those chosen before.
    fn start(
        &self,
        _: Initial,
        m: usize,
        _: &[f64],
        rng: &mut Pcg64,
    ) -> meshseg::Result<Vec<Direction>> {
        let mut mu: Vec<Vector3<f64>> = vec![self.n[rng.random_range(0..self.n.len())]];
        while mu.len() < m {
            let nearest = |n: &Vector3<f64>| mu.iter().map(|mu| n.dot(mu)).fold(-1.0, f64::max);
            let next = self.n.iter().min_by(|a, b| nearest(a).total_cmp(&nearest(b)));
            mu.push(*next.expect("there are vertices"));
        }
        Ok(mu.into_iter().map(|n| Direction { direction: n.into() }).collect())
    }

    fn check(&self, _: &[Direction]) -> meshseg::Result<()> {
        Ok(())
    }

    fn cost<'a>(&'a self, mu: &'a [Direction]) -> Cost<'a> {
        Box::new(move |k, s| {
            for (s, mu) in s.iter_mut().zip(mu) {
                *s = 1.0 - self.n[k].dot(&Vector3::from(mu.direction));
            }
        })
    }

    fn fit(&self, weights: Weights<'_>, mu: &mut [Direction]) -> meshseg::Result<f64> {
        let mut change = 0.0;
        for (p, mu) in mu.iter_mut().enumerate() {
            let sum: Vector3<f64> =
                self.n.iter().enumerate().map(|(k, n)| *n * weights.at(k)[p]).sum();
            if let Some(direction) = sum.try_normalize(1e-12) {
                let next = Direction { direction: direction.into() };
                change = f64::max(change, Self::distance(mu, &next));
                *mu = next;
            }
        }
        Ok(change)
    }

    fn distance(a: &Direction, b: &Direction) -> f64 {
        (Vector3::from(a.direction) - Vector3::from(b.direction)).norm()
    }
}

fn main() -> meshseg::Result<()> {
    // Deforms a sphere into a rounded cube.
    let mut mesh = source("sphere:5")?;
    for x in &mut mesh.vertices {
        let norm = x.iter().map(|c| c.powi(8)).sum::<f64>().powf(1.0 / 8.0);
        *x /= norm;
    }
    let mut n = vec![Vector3::zeros(); mesh.vertices.len()];
    for (j, face) in mesh.faces.iter().enumerate() {
        face.iter().for_each(|&v| n[v as usize] += mesh.area_vector(j));
    }
    let model = Directions { n: n.into_iter().map(|n| n.normalize()).collect() };

    let alternation = Alternation {
        regions: 6,
        initial: Initial::KMeans,
        seed: 1,
        every: 10,
        labels: None,
        seeds: Seeds::default(),
    };
    let request = Request {
        lambda: 0.05,
        relaxation: Default::default(),
        mass: Mass::Barycentric,
        method: Method::default(),
        stop: Stop { relative_gap: Some(1e-3), iterations: Some(5000), ..Stop::default() },
        coarse_to_fine: true,
        keep_dual: false,
        rounding: Default::default(),
        label_gap: None,
    };
    let mut go_on = |_: Option<&_>| ControlFlow::Continue(());
    let segmentation = segment(&mesh, &model, &alternation, &request, &mut go_on)?;
    for Direction { direction } in &segmentation.parameters {
        println!("{direction:6.3?}");
        // Each direction is close to an axis.
        assert!(direction.iter().any(|x| x.abs() > 0.99));
    }
    let summary = &segmentation.solution.summary;
    println!("{}: relative gap {:.1e}", summary.status_sentence, summary.relative_gap);
    assert!(summary.relative_gap <= 1e-3 && summary.empty_regions.is_empty());
    Ok(())
}

#[test]
fn it_runs() {
    main().unwrap();
}
