//! The alternation on coarser meshes, where it is cheap.
//!
//! A coarse vertex has the weight and the mean of the data that P gives it, so that for any parameters
//!
//! ```text
//! w_coarse = P^T w,   C_coarse = P^T (w C) / w_coarse
//! w_coarse |C_coarse - mu_p|^2 = ( P^T w |C - mu_p|^2 )_coarse - the variance that was averaged away
//! ```
//!
//! which is the same for every region: the restricted costs, up to a constant that no label changes.
//!
//! A level on which regions end empty, or with one mean, has nothing to pass on: they would not part again on finer ones,
//! where there is more to see. The next one starts as if it were the first.

use std::time::Instant;

use super::unions::are_apart;
use super::{Asked, Found, Level, State, alternate};
use crate::coarse::{self, Hierarchy, LevelRecord, Pair, Record};
use crate::data::Data;
use crate::error::Result;
use crate::field::{Row, Tangent};
use crate::mesh::Mesh;
use crate::mesh::coarsen::Coarsening;
use crate::solve::Observer;

/// Where the finest alternation starts, and what that took.
pub fn start<const M: usize>(
    finest: &Mesh,
    data: &Data,
    given: Vec<Vec<f64>>,
    asked: &Asked<'_>,
    observe: Observer<'_>,
) -> Result<(Vec<Vec<f64>>, Option<Pair<M>>, Record)> {
    let Asked { alternation, request, .. } = asked;
    let begin = Instant::now();
    let hierarchy = Hierarchy::new(finest);
    let mut weighted: Vec<(Vec<f64>, Data)> = Vec::new();
    for level in &hierarchy.levels {
        let next = match weighted.last() {
            Some((weights, data)) => restrict(level, weights, data),
            None => restrict(level, &request.mass.weights(finest), data),
        };
        weighted.push(next);
    }
    let mut levels = Vec::new();
    let mut means = given.clone();
    let pair = hierarchy.climb(request.lambda, |l, pair| {
        let (mesh, (weights, data)) = (&hierarchy.levels[l].mesh, &weighted[l]);
        let integrate = |s: &[Row<M>]| s.iter().zip(weights).map(|(&s, &w)| s * w).collect();
        let level = Level { mesh, data, integrate: &integrate };
        let spent = begin.elapsed();
        let stop = coarse::stop(request, spent);
        let asked = Asked { alternation, request, stop, unite: false };
        let problem = level.problem(&means, &asked)?;
        let state = State { problem, means: means.clone(), pair };
        let Found { mut solver, run, status, parameters, .. } =
            alternate(&level, state, spent, &asked, &mut |_| observe(None))?;
        levels.push(LevelRecord::of(mesh, run.iterations()));
        let used = |p: usize| run.best_u().iter().any(|u| u.argmax() == p);
        let deviation = data.robust_variance(weights).sqrt();
        if are_apart(&parameters, deviation) && (0..parameters.len()).all(used) {
            means = parameters.into_iter().map(|region| region.mean).collect();
            return Ok(coarse::reached(solver.iterate(), status));
        }
        means = given.clone();
        let f = level.problem(&means, &asked)?.f;
        let u = f.iter().map(|f| Row::one_hot(f.argmin())).collect();
        Ok(Some(Pair { u, q: vec![Tangent::ZERO; mesh.faces.len()] }))
    })?;
    Ok((means, pair, Record { spent: begin.elapsed(), levels }))
}

/// P^T w where something is known, and the means of the data with these weights; a vertex without weight has none.
pub fn restrict(level: &Coarsening, weights: &[f64], data: &Data) -> (Vec<f64>, Data) {
    let d = data.dimension;
    let n = level.mesh.vertices.len();
    let (mut weight, mut sums) = (vec![0.0; n], vec![0.0; n * d]);
    for (v, parents) in level.parents.iter().enumerate().filter(|&(v, _)| data.is_known(v)) {
        for (&c, share) in parents.corners.iter().zip(parents.weights) {
            let (c, w) = (c as usize, share * weights[v]);
            weight[c] += w;
            for (sum, x) in sums[c * d..(c + 1) * d].iter_mut().zip(data.at(v)) {
                *sum += w * x;
            }
        }
    }
    for (mean, &w) in sums.chunks_mut(d).zip(&weight) {
        if w > 0.0 {
            mean.iter_mut().for_each(|x| *x /= w);
        }
    }
    (weight, Data { dimension: d, values: sums })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{DataModel, PiecewiseConstant};
    use crate::operator::Mass;
    use crate::run::Stop;
    use crate::samples::{bumpy, disjoint, rng, shape, with_isolated_vertices};
    use crate::segment::{Alternation, Initial};
    use crate::solve::Request;
    use rand::RngExt;
    use std::ops::ControlFlow;

    /// A vertex of which nothing is known has no weight in any mean.
    #[test]
    fn unknown_data_are_in_no_mean() {
        let mesh = bumpy(12);
        let mut rng = rng(42);
        let values = mesh.vertices.iter().map(|_| match rng.random_range(0..3) {
            0 => f64::NAN,
            _ => 0.25,
        });
        let data = Data::new(1, values.collect()).unwrap();
        let weights = crate::operator::Mass::Barycentric.weights(&mesh);
        let (coarse, means) = restrict(&mesh.coarsened(), &weights, &data);
        let mean =
            |(w, x): (&f64, &f64)| if *w > 0.0 { (x - 0.25).abs() <= 1e-15 } else { *x == 0.0 };
        assert!(coarse.iter().zip(&means.values).all(mean));
        let known: f64 = data.known_area(&weights).iter().sum();
        assert!((coarse.iter().sum::<f64>() - known).abs() <= 1e-14);
    }

    /// The costs of the means are the restricted costs, less what is the same for every region.
    #[test]
    fn means_have_the_restricted_costs_up_to_a_constant() {
        let mesh = with_isolated_vertices(bumpy(12));
        let mut rng = rng(41);
        let n = mesh.vertices.len();
        let data = Data::new(2, (0..2 * n).map(|_| rng.random()).collect()).unwrap();
        let weights = crate::operator::Mass::Barycentric.weights(&mesh);
        let level = mesh.coarsened();
        let (coarse_weights, means) = restrict(&level, &weights, &data);
        let mu = vec![vec![0.2, 0.9], vec![0.5, 0.1], vec![1.4, 0.3]];
        let costs = |data: &Data, weights: &[f64]| -> Vec<Row<3>> {
            let s = DataModel::<3>::costs(&PiecewiseConstant::new(data, mu.clone()));
            s.iter().zip(weights).map(|(&s, &w)| s * w).collect()
        };
        let exact = crate::transfer::restrict(&level, &costs(&data, &weights));
        for (f, exact) in costs(&means, &coarse_weights).into_iter().zip(exact) {
            let constant = exact - f;
            assert!(constant.min() >= -1e-15);
            assert!(constant.max() - constant.min() <= 1e-14);
        }
    }

    /// What a level found is where the next one starts; nothing is, where it lost a region or two have one mean: then the
    /// means are those that were given, the labels the nearest of them, and no field goes with these.
    #[test]
    fn only_levels_that_keep_all_regions_pass_them_on() {
        let part = shape("sphere:3");
        let n = part.vertices.len();
        let parts = disjoint([0, 1, 2].map(|_| part.clone()));
        let sphere = shape("sphere:4");
        let alternation = Alternation { regions: 3, initial: Initial::KMeans, seed: 0, every: 10 };
        let started = |mesh: &Mesh, lambda: f64, values: Vec<f64>, given: [f64; 3]| {
            let request = Request {
                lambda,
                mass: Mass::Barycentric,
                method: crate::solver::Method::default(),
                stop: Stop { relative_gap: Some(1e-4), ..Stop::default() },
                coarse_to_fine: true,
                keep_dual: false,
            };
            let stop = request.stop.clone();
            let asked = Asked { alternation: &alternation, request: &request, stop, unite: true };
            let data = Data::new(1, values).unwrap();
            let given = given.map(|x| vec![x]).to_vec();
            let mut go = |sample: Option<&crate::run::Sample>| {
                assert!(sample.is_none());
                ControlFlow::Continue(())
            };
            let (means, pair, record) = start::<4>(mesh, &data, given, &asked, &mut go).unwrap();
            assert_eq!(record.levels.len(), 1);
            let Pair { u, q } = pair.unwrap();
            let labels: Vec<usize> = u.iter().map(|u| u.argmax()).collect();
            (means.concat(), labels, q.iter().all(|q| q.norm() == 0.0))
        };
        let each = |values: [f64; 3]| values.map(|x| vec![x; n]).concat();
        let thirds = [0, 1, 2].map(|p| vec![p; n]).concat();
        let (means, labels, _) = started(&parts, 1e-3, each([0.0, 0.5, 1.0]), [0.1, 0.6, 0.9]);
        let near = means.iter().zip([0.0, 0.5, 1.0]).all(|(a, b)| (a - b).abs() <= 1e-9);
        assert!(near && labels == thirds, "{means:?}");
        // Three parts of one region each, the third of which is taken by none of the means: two regions stay.
        let given = [0.1, 0.6, 5.0];
        let (means, labels, without_field) = started(&parts, 1e-3, each([0.0, 0.5, 1.0]), given);
        assert!(means == given && without_field, "{means:?}");
        assert_eq!(labels, [0, 1, 1].map(|p| vec![p; n]).concat());
        // All become one where cuts are dear.
        let heights = sphere.vertices.iter().map(|x| x.z).collect();
        let given = [-0.8, 0.0, 0.7];
        let (means, labels, without_field) = started(&sphere, 100.0, heights, given);
        assert!(means == given && without_field, "{means:?}");
        assert!((0..3).all(|p| labels.contains(&p)));
        // Two means that are one, both of them used.
        let given = [0.001, 0.012, 0.9];
        let (means, labels, without_field) = started(&parts, 0.0, each([0.0, 0.01, 1.0]), given);
        assert!(means == given && labels == thirds && without_field, "{means:?}");
    }
}
