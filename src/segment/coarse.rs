//! The alternation on coarser meshes, where it is cheap.
//!
//! A coarse vertex has the weight P^T w of what is known, and the data that the model makes of the finer ones.
//!
//! A level on which regions end empty, or two with the same parameters, has nothing to pass on: they would not part again
//! on finer ones, where there is more to see. The next one starts as if it were the first.

use std::time::Instant;

use super::alternation::{Found, Level};
use super::unions::are_apart;
use crate::coarse::{self, Hierarchy, LevelRecord, Pair, Record};
use crate::data::DataModel;
use crate::error::Result;
use crate::field::{Row, Tangent};
use crate::mesh::coarsen::Coarsening;
use crate::solve::Observer;
use crate::start::cheapest;

/// Where the finest alternation starts: mu, and U and q if they are known, and what that took.
type Start<P, const M: usize> = (Vec<P>, Option<Pair<M>>, Record);

/// Alternates on one level after the other, from `given` on.
pub fn start<D: DataModel, const M: usize>(
    finest: &Level<'_, D, M>,
    given: Vec<D::Parameters>,
    observe: Observer<'_>,
) -> Result<Start<D::Parameters, M>> {
    let request = finest.request;
    let begin = Instant::now();
    let hierarchy = Hierarchy::new(finest.mesh);
    let mut weighted: Vec<(Vec<f64>, D)> = Vec::new();
    for level in &hierarchy.levels {
        let next = match weighted.last() {
            Some((weights, model)) => restrict(level, weights, model),
            None => restrict(level, &request.mass.weights(finest.mesh), finest.model),
        };
        weighted.push(next);
    }
    let mut levels = Vec::new();
    let mut mu = given.clone();
    let pair = hierarchy.climb(request.lambda, |l, pair| {
        let (mesh, (weights, model)) = (&hierarchy.levels[l].mesh, &weighted[l]);
        let integrate = |s: &[Row<M>]| s.iter().zip(weights).map(|(&s, &w)| s * w).collect();
        let scale = model.scale(weights);
        let level = Level { mesh, model, integrate: &integrate, scale, unite: false, ..*finest };
        let spent = begin.elapsed();
        let stop = coarse::stop(request, spent);
        let problem = level.problem(&mu)?;
        let Found { mut solver, run, status, mu: found, .. } =
            level.alternate(problem, mu.clone(), pair, spent, &stop, &mut |_| observe(None))?;
        levels.push(LevelRecord::of(mesh, run.iterations()));
        let used = |p: usize| run.best_u().iter().any(|u| u.argmax() == p);
        let distance = |a: usize, b: usize| D::distance(&found[a], &found[b]);
        if are_apart(found.len(), distance, scale.distance) && (0..found.len()).all(used) {
            mu = found;
            return Ok(coarse::reached(solver.iterate(), status));
        }
        mu = given.clone();
        let u = cheapest(&level.problem(&mu)?.f);
        Ok(Some(Pair { u, q: vec![Tangent::ZERO; mesh.faces.len()] }))
    })?;
    Ok((mu, pair, Record { spent: begin.elapsed(), levels }))
}

/// P^T w over what is known, and the data that have these weights.
pub fn restrict<D: DataModel>(level: &Coarsening, weights: &[f64], model: &D) -> (Vec<f64>, D) {
    let coarse = level.restricted(weights, |v| model.is_known(v));
    let model = model.restricted(level, weights, &coarse);
    (coarse, model)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::constant::Mean;
    use crate::data::{Data, Initial, PiecewiseConstant};
    use crate::mesh::Mesh;
    use crate::operator::Mass;
    use crate::run::Stop;
    use crate::samples::{bumpy, disjoint, rng, shape};
    use crate::segment::Alternation;
    use crate::solve::Request;
    use rand::RngExt;
    use std::ops::ControlFlow;

    /// A vertex of which nothing is known gives its weight to none.
    #[test]
    fn unknown_data_have_no_weight() {
        let mesh = bumpy(12);
        let mut rng = rng(42);
        let values = mesh.vertices.iter().map(|_| match rng.random_range(0..3) {
            0 => f64::NAN,
            _ => 0.25,
        });
        let data = Data::new(1, values.collect()).unwrap();
        let weights = Mass::Barycentric.weights(&mesh);
        let (coarse, _) = restrict(&mesh.coarsened(), &weights, &PiecewiseConstant::new(&data));
        let known: f64 = data.known_area(&weights).iter().sum();
        assert!((coarse.iter().sum::<f64>() - known).abs() <= 1e-14);
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
            let data = Data::new(1, values).unwrap();
            let model = &PiecewiseConstant::new(&data);
            let (alternation, request) = (&alternation, &request);
            let mass = request.mass.on(mesh);
            let integrate = &|s: &[Row<4>]| mass.integrate(s);
            let scale = model.scale(&request.mass.weights(mesh));
            let finest = Level { mesh, model, integrate, scale, alternation, request, unite: true };
            let given = given.map(|x| Mean { mean: vec![x] }).to_vec();
            let mut go = |sample: Option<&crate::run::Sample>| {
                assert!(sample.is_none());
                ControlFlow::Continue(())
            };
            let (mu, pair, record) = start(&finest, given, &mut go).unwrap();
            let means: Vec<f64> = mu.into_iter().flat_map(|mu| mu.mean).collect();
            assert_eq!(record.levels.len(), 1);
            let Pair { u, q } = pair.unwrap();
            let labels: Vec<usize> = u.iter().map(|u| u.argmax()).collect();
            (means, labels, q.iter().all(|q| q.norm() == 0.0))
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
