//! The alternation on coarser meshes, where it is cheap.
//!
//! With the prolongation P, a coarse vertex has the weight (P^T w)_c, summed over the known finer vertices, and the
//! data that the model restricts to it.
//!
//! A level on which regions end empty, or two regions have the same parameters, passes nothing on: such regions would
//! not separate again on finer levels, which show more detail. The next level starts as if it were the first.

use std::time::Instant;

use super::alternation::{AlternationOutcome, JointProblem};
use super::estimate::Estimate;
use super::merging::are_distinct;
use crate::coarse::{self, Hierarchy, LevelRecord, Pair, Record};
use crate::error::Result;
use crate::field::Tangent;
use crate::operator::Quadrature;
use crate::seeds::Seeds;
use crate::solve::Observer;
use crate::start::cheapest_labels;

/// Alternates on one level after the other, starting with the initial parameters. Returns what the finest alternation
/// starts with, the pair U and q if there is one, and the work it took; its parameters are those of `estimate`.
pub fn start<const M: usize>(
    finest: &JointProblem<'_>,
    estimate: &mut dyn Estimate,
    observe: Observer<'_>,
) -> Result<(Option<Pair<M>>, Record)> {
    let request = finest.request;
    let begin = Instant::now();
    let hierarchy = Hierarchy::new(finest.mesh);
    let mut weights: Vec<Vec<f64>> = vec![request.mass.weights(finest.mesh)];
    let mut seeds: Vec<Seeds> = vec![finest.seeds.clone()];
    for (l, level) in hierarchy.levels.iter().enumerate() {
        weights.push(estimate.restrict(level, &weights[l]));
        seeds.push(seeds[l].restricted(level));
    }
    let mut levels = Vec::new();
    let pair = hierarchy.climb((request.lambda, request.relaxation), |l, pair| {
        let (mesh, weights) = (&hierarchy.levels[l].mesh, &weights[l + 1]);
        let mass = Quadrature::Lumped(weights.clone());
        let scale = estimate.scale(weights);
        let (seeds, is_finest) = (&seeds[l + 1], false);
        let joint = JointProblem { mesh, mass: &mass, scale, seeds, is_finest, ..*finest };
        let spent = begin.elapsed();
        let stop = coarse::level_stop(request, spent);
        let problem = joint.problem::<M>(estimate)?;
        let AlternationOutcome { mut solver, run, status, .. } =
            joint.alternate(estimate, problem, pair, spent, &stop, &mut |_| observe(None))?;
        levels.push(LevelRecord::of(mesh, run.iterations()));
        let m = estimate.regions();
        let used = |p: usize| run.best_u().iter().any(|u| u.argmax() == p);
        let distance = |a: usize, b: usize| estimate.distance(a, b);
        let pair = if are_distinct(m, distance, scale.distance) && (0..m).all(used) {
            coarse::final_pair(solver.iterate(), status)
        } else {
            estimate.reset();
            let u = cheapest_labels(&joint.problem::<M>(estimate)?.f);
            Some(Pair { u, q: vec![Tangent::ZERO; mesh.faces.len()] })
        };
        estimate.refine();
        Ok(pair)
    })?;
    Ok((pair, Record { spent: begin.elapsed(), levels }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::constant::Mean;
    use crate::data::{Data, DataModel, Initial, PiecewiseConstant};
    use crate::mesh::Mesh;
    use crate::operator::Mass;
    use crate::run::Stop;
    use crate::samples::{bumpy, disjoint, rng, shape};
    use crate::segment::Alternation;
    use crate::segment::estimate::ModelEstimate;
    use crate::solve::Request;
    use rand::RngExt;
    use std::borrow::Cow;
    use std::ops::ControlFlow;

    /// The weight of an unknown vertex goes to no coarse vertex.
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
        let model = PiecewiseConstant::new(&data);
        let estimate: &mut dyn Estimate =
            &mut ModelEstimate::new(Cow::Borrowed(&model), Vec::new());
        let coarse = estimate.restrict(&mesh.coarsened(), &weights);
        let known: f64 = data.known_area(&weights).iter().sum();
        assert!((coarse.iter().sum::<f64>() - known).abs() <= 1e-14);
    }

    /// A level passes on its means, labels and field, unless it lost a region or two regions have the same mean. In
    /// that case the next level starts with the given means, the labels of the nearest means, and a zero field.
    #[test]
    fn only_levels_that_keep_all_regions_pass_them_on() {
        let part = shape("sphere:3");
        let n = part.vertices.len();
        let parts = disjoint([0, 1, 2].map(|_| part.clone()));
        let sphere = shape("sphere:4");
        let alternation = Alternation {
            labels: None,
            seeds: Seeds::default(),
            regions: 3,
            initial: Initial::KMeans,
            seed: 0,
            every: 10,
        };
        let started = |mesh: &Mesh, lambda: f64, values: Vec<f64>, given: [f64; 3]| {
            let request = Request {
                lambda,
                relaxation: Default::default(),
                mass: Mass::Barycentric,
                method: crate::solver::Method::default(),
                stop: Stop { relative_gap: Some(1e-4), ..Stop::default() },
                coarse_to_fine: true,
                keep_dual: false,
                rounding: Default::default(),
                label_gap: None,
            };
            let data = Data::new(1, values).unwrap();
            let model = &PiecewiseConstant::new(&data);
            let (alternation, request) = (&alternation, &request);
            let mass = &request.mass.on(mesh);
            let scale = model.scale(&request.mass.weights(mesh));
            let seeds = &alternation.seeds;
            let finest =
                JointProblem { mesh, mass, scale, seeds, alternation, request, is_finest: true };
            let given = given.map(|x| Mean { mean: vec![x] }).to_vec();
            let mut estimate = ModelEstimate::new(Cow::Borrowed(model), given);
            let mut go = |sample: Option<&crate::run::Sample>| {
                assert!(sample.is_none());
                ControlFlow::Continue(())
            };
            let (pair, record) = start::<4>(&finest, &mut estimate, &mut go).unwrap();
            let mu = estimate.into_parameters();
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
        // Three parts, but the third mean is the nearest one of no value: only two regions are used.
        let given = [0.1, 0.6, 5.0];
        let (means, labels, zero_field) = started(&parts, 1e-3, each([0.0, 0.5, 1.0]), given);
        assert!(means == given && zero_field, "{means:?}");
        assert_eq!(labels, [0, 1, 1].map(|p| vec![p; n]).concat());
        // Only one region is left where cuts are expensive.
        let heights = sphere.vertices.iter().map(|x| x.z).collect();
        let given = [-0.8, 0.0, 0.7];
        let (means, labels, zero_field) = started(&sphere, 100.0, heights, given);
        assert!(means == given && zero_field, "{means:?}");
        assert!((0..3).all(|p| labels.contains(&p)));
        // Two equal means, both used.
        let given = [0.001, 0.012, 0.9];
        let (means, labels, zero_field) = started(&parts, 0.0, each([0.0, 0.01, 1.0]), given);
        assert!(means == given && labels == thirds && zero_field, "{means:?}");
    }
}
