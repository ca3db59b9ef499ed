//! Radiance in several views: every region has one color, and its costs are summed over the pixels that see it.
//!
//! ```text
//! s_p(x_k) = r_k ( |c_k - mu_p|^2 + v_k )        mu_p = int u_p r c / int u_p r
//! ```
//!
//! with the statistics r, c, v of the pixels, see `pixels.rs`.
//!
//! Reference: Delaunoy et al., ICCV 2009, section 3.2; the index of the camera belongs inside both sums of mu_p.

use std::borrow::Cow;

use rand_pcg::Pcg64;

use super::constant::Mean;
use super::pixels::{Evidence, Pixels};
use super::{Cost, Data, DataModel, Initial, PiecewiseConstant, Scale, Weights};
use crate::error::Result;
use crate::mesh::coarsen::Coarsening;
use crate::mesh::order::Order;
use crate::sweep::sum;

/// The likelihood of the pixels.
#[derive(Clone)]
pub struct Radiance<'a> {
    pixels: Pixels<'a>,
}

impl<'a> Radiance<'a> {
    /// The model of pixels with these means at the vertices, which are borrowed. Panics if the lengths differ.
    pub fn new(means: &'a Data, evidence: &'a Evidence) -> Self {
        Radiance { pixels: Pixels::new(means, evidence) }
    }

    fn constant(&self) -> PiecewiseConstant<'_> {
        PiecewiseConstant::new(&self.pixels.means)
    }
}

impl DataModel for Radiance<'_> {
    type Parameters = Mean;

    type Datum = [f64];

    const VALUE_NAME: &'static str = PiecewiseConstant::VALUE_NAME;

    fn value(mu: &Mean) -> &[f64] {
        &mu.mean
    }

    fn vertices(&self) -> usize {
        self.pixels.means.len()
    }

    fn at(&self, k: usize) -> Option<&[f64]> {
        self.pixels.means.known(k)
    }

    fn in_order(&self, order: &Order) -> Cow<'_, Self> {
        let pixels = self.pixels.in_order(order);
        pixels.map_or(Cow::Borrowed(self), |pixels| Cow::Owned(Radiance { pixels }))
    }

    /// The restricted statistics, with exactly the restricted costs.
    fn restricted(&self, level: &Coarsening, weights: &[f64], coarse: &[f64]) -> Self {
        Radiance { pixels: self.pixels.restricted(level, weights, coarse) }
    }

    /// The variance of the means, the standard deviation, and the widest range of a coordinate.
    fn scale(&self, weights: &[f64]) -> Scale {
        self.constant().scale(&self.pixels.evidence_of(weights))
    }

    fn start(
        &self,
        initial: Initial,
        m: usize,
        weights: &[f64],
        rng: &mut Pcg64,
    ) -> Result<Vec<Mean>> {
        self.constant().start(initial, m, &self.pixels.evidence_of(weights), rng)
    }

    fn check(&self, mu: &[Mean]) -> Result<()> {
        self.constant().check(mu)
    }

    fn cost<'a>(&'a self, mu: &'a [Mean]) -> Cost<'a> {
        assert!(mu.iter().all(|mu| mu.mean.len() == self.pixels.means.dimension));
        Box::new(move |k, s| {
            let (r, c, v) = self.pixels.at(k);
            let distance =
                |mu: &Mean| -> f64 { c.iter().zip(&mu.mean).map(|(c, mu)| (c - mu).powi(2)).sum() };
            s.iter_mut().zip(mu).for_each(|(s, mu)| *s = r * (distance(mu) + v));
        })
    }

    fn fit(&self, weights: Weights<'_>, mu: &mut [Mean]) -> Result<f64> {
        let n = weights.vertices();
        let masses = self.pixels.means.masses(weights, mu.len());
        let mut change = 0.0;
        for (p, mu) in mu.iter_mut().enumerate().filter(|&(p, _)| masses[p].is_some()) {
            let mass = |k: usize| weights.at(k)[p] * self.pixels.evidence.density[k];
            let total = sum(n, mass);
            if total <= 0.0 {
                continue;
            }
            for (i, mu) in mu.mean.iter_mut().enumerate() {
                let moment = |k: usize| mass(k) * self.pixels.means.at(k)[i];
                let mean = sum(n, |k| if self.is_known(k) { moment(k) } else { 0.0 }) / total;
                change = f64::max(change, (mean - *mu).abs());
                *mu = mean;
            }
        }
        Ok(change)
    }

    fn distance(a: &Mean, b: &Mean) -> f64 {
        PiecewiseConstant::distance(a, b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Row;
    use crate::mesh::Mesh;
    use crate::operator::Mass;
    use crate::samples::{bumpy, fitted_energy, random_data, rng, to_fit, with_isolated_vertices};
    use crate::transfer::restrict;
    use rand::RngExt;

    fn means<const P: usize>(means: [&[f64]; P]) -> Vec<Mean> {
        means.map(|mean| Mean { mean: mean.to_vec() }).to_vec()
    }

    /// Every fifth vertex is unseen.
    fn random(mesh: &Mesh, seed: u64) -> (Data, Evidence) {
        let mut rng = rng(seed);
        let mut data = random_data(mesh.vertices.len(), 2, seed);
        data.values.chunks_mut(2).step_by(5).for_each(|row| row.fill(f64::NAN));
        let mut numbers = || (0..data.len()).map(|_| rng.random()).collect::<Vec<f64>>();
        let (mut density, mut variance) = (numbers(), numbers());
        density.iter_mut().step_by(5).for_each(|r| *r = 0.0);
        variance.iter_mut().step_by(5).for_each(|v| *v = 0.0);
        (data, Evidence { density, variance })
    }

    /// Evidence of density 1 without variance is piecewise constant data.
    #[test]
    fn uniform_evidence_is_piecewise_constant_data() {
        let mesh = bumpy(6);
        let data = random_data(mesh.vertices.len(), 2, 5);
        let n = data.len();
        let evidence = Evidence { density: vec![1.0; n], variance: vec![0.0; n] };
        let (pixels, constant) = (Radiance::new(&data, &evidence), PiecewiseConstant::new(&data));
        let mu = means([&[0.2, 0.9], &[0.5, 0.1]]);
        assert_eq!(pixels.costs::<2>(&mu), constant.costs::<2>(&mu));
        let weights = Mass::Barycentric.weights(&mesh);
        let u: Vec<f64> = weights.iter().flat_map(|w| [0.3 * w, 0.7 * w]).collect();
        let fitted = |fit: &dyn Fn(&mut [Mean])| {
            let mut mu = mu.clone();
            fit(&mut mu);
            mu
        };
        let a = fitted(&|mu| drop(pixels.fit(Weights::new(&u, 2), mu)));
        let b = fitted(&|mu| drop(constant.fit(Weights::new(&u, 2), mu)));
        assert!(a.iter().zip(&b).all(|(a, b)| PiecewiseConstant::distance(a, b) <= 1e-15));
    }

    /// Moving one coordinate of one mean by d increases the energy by exactly d^2 times the evidence of the region.
    #[test]
    fn the_fit_is_the_minimizer() {
        for (mesh, _, u, mass) in to_fit(121) {
            let (data, evidence) = random(&mesh, 9);
            let model = Radiance::new(&data, &evidence);
            let quadrature = mass.on(&mesh);
            let energy = |mu: &[Mean]| fitted_energy(&model, &quadrature, &u, mu);
            let mut mu = means([&[0.5; 2]; 3]);
            let before = energy(&mu);
            let weights = quadrature.integrate(&u);
            model.fit(Weights::of(&weights), &mut mu).unwrap();
            let minimum = energy(&mu);
            assert!(minimum < before);
            for p in 0..3 {
                let region: f64 =
                    weights.iter().zip(&evidence.density).map(|(w, r)| w.0[p] * r).sum();
                for (i, d) in [(0, 1e-2), (1, -0.3)] {
                    let mut moved = mu.clone();
                    moved[p].mean[i] += d;
                    let rise = energy(&moved) - minimum;
                    assert!((rise - d * d * region).abs() <= 1e-12 * before, "{mass:?}, {d}");
                }
            }
            assert_eq!(model.fit(Weights::of(&weights), &mut mu).unwrap(), 0.0);
        }
    }

    /// The costs of the coarse data are exactly the restricted costs.
    #[test]
    fn statistics_restrict_by_sums() {
        let mesh = with_isolated_vertices(bumpy(12));
        let (data, evidence) = random(&mesh, 7);
        let model = Radiance::new(&data, &evidence);
        let weights = Mass::Barycentric.weights(&mesh);
        let level = mesh.coarsened();
        let coarse = level.restricted(&weights, |k| model.is_known(k));
        let restricted = model.restricted(&level, &weights, &coarse);
        let mu = means([&[0.2, 0.9], &[0.5, 0.1], &[1.4, 0.3]]);
        let costs = |model: &Radiance, weights: &[f64]| -> Vec<Row<3>> {
            model.costs::<3>(&mu).iter().zip(weights).map(|(&s, &w)| s * w).collect()
        };
        let exact = restrict(&level, &costs(&model, &weights));
        for (f, exact) in costs(&restricted, &coarse).into_iter().zip(exact) {
            assert!((0..3).all(|p| (f.0[p] - exact.0[p]).abs() <= 1e-14), "{f:?} {exact:?}");
        }
    }
}
