//! Piecewise constant data: every region has one value.
//!
//! ```text
//! s_p(x) = |C(x) - mu_p|^2,     mu_p = int u_p C / int u_p
//! ```
//!
//! Delaunoy et al., ICCV 2009, section 3.2; the Chan-Vese model for m = 2.

use super::{Data, DataModel, RegionParameters};
use crate::field::Row;
use crate::sweep::{collect, sum};

pub struct PiecewiseConstant<'a> {
    data: &'a Data,
    /// mu_p in R^d, one per region.
    mu: Vec<Vec<f64>>,
}

impl<'a> PiecewiseConstant<'a> {
    /// Starts with the given means.
    pub fn new(data: &'a Data, mu: Vec<Vec<f64>>) -> Self {
        assert!(mu.iter().all(|mu| mu.len() == data.dimension));
        PiecewiseConstant { data, mu }
    }
}

impl<const M: usize> DataModel<M> for PiecewiseConstant<'_> {
    fn costs(&self) -> Vec<Row<M>> {
        let cost = |k: usize, mu: &[f64]| -> f64 {
            self.data.at(k).iter().zip(mu).map(|(c, mu)| (c - mu).powi(2)).sum()
        };
        let known = |k: usize| self.data.is_known(k);
        let row = |k: usize| Row::from_fn(|p| self.mu.get(p).map_or(0.0, |mu| cost(k, mu)));
        collect(self.data.len(), |k| if known(k) { row(k) } else { Row::ZERO })
    }

    fn fit(&mut self, weights: &[Row<M>]) -> f64 {
        let n = weights.len();
        let known = |k: usize| self.data.is_known(k);
        let total = sum(n, |k| weights[k].0.iter().sum());
        let mut change = 0.0;
        for (p, mu) in self.mu.iter_mut().enumerate() {
            let mass = sum(n, |k| if known(k) { weights[k].0[p] } else { 0.0 });
            if mass <= f64::EPSILON * total {
                continue;
            }
            for (i, mu) in mu.iter_mut().enumerate() {
                let moment = |k: usize| weights[k].0[p] * self.data.at(k)[i];
                let mean = sum(n, |k| if known(k) { moment(k) } else { 0.0 }) / mass;
                change = f64::max(change, (mean - *mu).abs());
                *mu = mean;
            }
        }
        change
    }

    fn parameters(&self) -> Vec<RegionParameters> {
        self.mu.iter().map(|mu| RegionParameters { mean: mu.clone() }).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::operator::Mass;
    use crate::samples::{bumpy, needles, random_labels, rng, shape};
    use rand::RngExt;

    fn random_data(n: usize, dimension: usize) -> Data {
        let mut rng = rng(121);
        Data::new(dimension, (0..n * dimension).map(|_| rng.random()).collect()).unwrap()
    }

    #[test]
    fn costs_are_squared_distances() {
        let data = Data::new(2, vec![0.0, 1.0, 3.0, 5.0]).unwrap();
        let model = PiecewiseConstant::new(&data, vec![vec![0.0, 0.0], vec![3.0, 1.0]]);
        assert_eq!(DataModel::<2>::costs(&model), [Row([1.0, 9.0]), Row([34.0, 16.0])]);
    }

    /// The fitted means minimize sum <u, M s>, for each quadrature: moving one coordinate of one mean by
    /// d raises it by exactly d^2 times the mass of the region.
    #[test]
    fn the_fit_is_the_minimizer() {
        for mesh in [shape("sphere:2"), bumpy(6).scaled(1e-3), needles(4, 1e-4)] {
            let n = mesh.vertices.len();
            let data = random_data(n, 2);
            let u = random_labels::<3>(n, 3, &mut rng(122));
            for mass in Mass::NAMES.map(|(_, mass)| mass) {
                let energy = |mu: &[Vec<f64>]| -> f64 {
                    let model = PiecewiseConstant::new(&data, mu.to_vec());
                    let f = mass.on(&mesh).integrate(&DataModel::<3>::costs(&model));
                    u.iter().zip(&f).map(|(u, &f)| u.dot(f)).sum()
                };
                let mut model = PiecewiseConstant::new(&data, vec![vec![0.5; 2]; 3]);
                let before = energy(&model.mu);
                let weights = mass.on(&mesh).integrate(&u);
                DataModel::<3>::fit(&mut model, &weights);
                let least = energy(&model.mu);
                assert!(least < before);
                for p in 0..3 {
                    let region: f64 = weights.iter().map(|w| w.0[p]).sum();
                    for (i, d) in [(0, 1e-2), (1, -1e-2), (0, -0.3), (1, 0.3)] {
                        let mut mu = model.mu.clone();
                        mu[p][i] += d;
                        let rise = energy(&mu) - least;
                        assert!((rise - d * d * region).abs() <= 1e-12 * before, "{mass:?}, {d}");
                    }
                }
                assert_eq!(DataModel::<3>::fit(&mut model, &weights), 0.0);
            }
        }
    }

    /// Of what is not known, neither costs nor means take notice.
    #[test]
    fn unknown_vertices_count_for_nothing() {
        let data = Data::new(2, vec![0.0, 1.0, f64::NAN, 7.0, 4.0, 3.0]).unwrap();
        let mut model = PiecewiseConstant::new(&data, vec![vec![0.0, 0.0], vec![3.0, 1.0]]);
        assert_eq!(DataModel::<2>::costs(&model)[1], Row::ZERO);
        DataModel::<2>::fit(&mut model, &[Row([0.5, 0.0]), Row([9.0, 9.0]), Row([0.5, 2.0])]);
        assert_eq!(model.mu, [[2.0, 2.0], [4.0, 3.0]]);
        assert!(data.is_known(0) && !data.is_known(1));
        assert_eq!(data.variance(&[1.0, 5.0, 1.0]), 5.0);
    }

    #[test]
    fn an_empty_region_keeps_its_parameters() {
        let data = random_data(5, 2);
        let mut model = PiecewiseConstant::new(&data, vec![vec![0.1; 2], vec![7.0, -3.0]]);
        let change = DataModel::<2>::fit(&mut model, &[Row([0.2, 0.0]); 5]);
        let means: Vec<Vec<f64>> =
            DataModel::<2>::parameters(&model).into_iter().map(|p| p.mean).collect();
        assert_eq!(means[1], [7.0, -3.0]);
        let moved = f64::max((means[0][0] - 0.1).abs(), (means[0][1] - 0.1).abs());
        assert_eq!(change, moved);
        assert!(change > 0.0);
    }

    /// Regions beyond those of the model are padding; their costs are the business of `regions.rs`.
    #[test]
    fn padded_regions_have_no_parameters() {
        let data = random_data(4, 1);
        let mut model = PiecewiseConstant::new(&data, vec![vec![0.5]; 9]);
        let u = random_labels::<12>(4, 9, &mut rng(123));
        DataModel::<12>::fit(&mut model, &u);
        assert_eq!(DataModel::<12>::parameters(&model).len(), 9);
        assert!(DataModel::<12>::costs(&model).iter().all(|s| s.0[9..] == [0.0; 3]));
    }
}
