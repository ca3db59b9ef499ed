//! A true lower bound on all energies, for a U that was computed elsewhere: from the best dual field available.
//!
//! ```text
//! offered    a given q, each q_j projected onto the set of the relaxation
//! smoothed   q_j = lambda (K U)_j / sqrt( |(K U)_j|^2 + eps_j^2 )
//! steps      D after a number of our own steps from (U, 0), including the bound of `constant.rs`; their U is discarded
//! ```
//!
//! Bounds are D - B, like all bounds of a problem.

use crate::domain::Domain;
use crate::error::Result;
use crate::field::{Row, Tangent};
use crate::operator::{Operator, Stencil};
use crate::problem::{Problem, Smoothing};
use crate::request::Observer;
use crate::run::{Run, Stop};
use crate::solver::{Method, Setup};

/// Number of our own steps by which a bound is found if no dual field is given.
pub const DUAL_STEPS: u64 = 100;

/// D of a given field, one tangent per face, made feasible.
pub fn offered<const M: usize>(problem: &Problem<Stencil, M>, mut q: Vec<Tangent<M>>) -> f64 {
    problem.make_feasible(&mut q);
    problem.dual_bound(&q)
}

/// D of the gradient of the smoothed total variation at U, V rows.
pub fn smoothed<const M: usize>(
    problem: &Problem<Stencil, M>,
    u: &[Row<M>],
    smoothing: Smoothing,
) -> f64 {
    let mut q = vec![Tangent::ZERO; problem.k.faces()];
    problem.smoothed_dual(u, smoothing, &mut q);
    problem.dual_bound(&q)
}

/// D after the given number of steps of the default solver from V rows of the simplex. `observe` is called without
/// samples and may end the steps early.
///
/// Fails if the solver cannot be built, which its default settings do not cause.
pub fn steps<const M: usize>(
    domain: Domain<'_>,
    problem: &Problem<Stencil, M>,
    u: &[Row<M>],
    steps: u64,
    observe: Observer<'_>,
) -> Result<f64> {
    let setup = Setup { domain, problem, start: u.to_vec(), dual_start: None };
    let mut solver = Method::default().build(setup)?;
    let mut run = Run::new(u);
    let stop = Stop { iterations: Some(steps), ..Stop::default() };
    run.advance(&mut *solver, problem, &stop, &mut |_| observe(None));
    Ok(run.bound())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::SmoothingMode;
    use crate::relaxation::Relaxation;
    use crate::run::FIRST_INTERVAL;
    use crate::samples::{
        assert_within, bumpy, known_optimum, known_optimum_in, random_labels, random_problem,
        random_tangents, rng, zoo,
    };
    use std::ops::ControlFlow;
    use strum::IntoEnumIterator;

    /// No offered field exceeds a known minimum, however long its vectors are, and the optimal field attains it.
    #[test]
    fn offered_fields_are_projected_onto_the_set() {
        let mut rng = rng(821);
        for ((name, mesh), relaxation) in
            zoo().into_iter().flat_map(|one| Relaxation::iter().map(move |it| (one.clone(), it)))
        {
            let lambda = 0.1 * mesh.area().sqrt();
            let known = known_optimum_in::<3>(relaxation, &mesh, 3, lambda, 1.0, 822);
            let (problem, size) = (&known.problem, known.problem.spread());
            assert_within(offered(problem, known.q.clone()), known.energy, 1e-12, size);
            // What all regions have in common does not count.
            let shift = random_tangents::<1>(1, &mut rng)[0];
            let common = Tangent(shift.0.map(|x| Row([x.0[0] * problem.lambda; 3])));
            if relaxation == Relaxation::Envelope {
                let q = known.q.iter().map(|&q| q + common).collect();
                assert_within(offered(problem, q), known.energy, 1e-12, size);
            }
            for longer in [1.01, 3.0, 1e3] {
                let q = known.q.iter().map(|&q| q * longer).collect();
                assert!(offered(problem, q) <= known.energy + 1e-12 * size, "{name}");
                let any = random_tangents::<3>(mesh.faces.len(), &mut rng);
                let q = any.iter().map(|&q| q * (longer * problem.lambda)).collect();
                assert!(offered(problem, q) <= known.energy + 1e-12 * size, "{name}");
            }
        }
    }

    /// The bound of q_j = lambda (K U)_j / sqrt( |(K U)_j|^2 + eps_j^2 ), eps_j = A_j sqrt(eps) or sqrt(eps) / 2.
    #[test]
    fn the_smoothed_field_is_the_gradient_of_the_smoothed_variation() {
        let mut rng = rng(823);
        for (name, mesh) in zoo() {
            let known = known_optimum::<3>(&mesh, 3, 0.1 * mesh.area().sqrt(), 1.0, 824);
            let Problem { k, lambda, .. } = &known.problem;
            let u = random_labels::<3>(mesh.vertices.len(), 3, &mut rng);
            for mode in [SmoothingMode::Paper, SmoothingMode::Intrinsic] {
                let smoothing = Smoothing::default_for(k, mode);
                let root = smoothing.epsilon.sqrt();
                let q = |j: usize| {
                    let radius = match mode {
                        SmoothingMode::Paper => 0.5 * root,
                        SmoothingMode::Intrinsic => root * mesh.face_area(j),
                    };
                    let ku = k.at(&u, j);
                    ku * (lambda / ku.norm().hypot(radius))
                };
                let q: Vec<Tangent<3>> = (0..k.faces()).map(q).collect();
                let bound = smoothed(&known.problem, &u, smoothing);
                let size = known.problem.spread();
                assert_within(bound, known.problem.dual_bound(&q), 1e-12, size);
                assert!(bound <= known.energy + 1e-12 * size, "{name}");
            }
        }
    }

    /// Bounds increase with the number of steps and never exceed the minimum; zero steps give B.
    #[test]
    fn steps_improve_the_bound_from_below() {
        for (name, mesh) in zoo() {
            let known = known_optimum::<3>(&mesh, 3, 0.1 * mesh.area().sqrt(), 1.0, 825);
            let start = vec![Row([1.0 / 3.0; 3]); mesh.vertices.len()];
            let bound = |n: u64| {
                let mut go = |_: Option<&_>| ControlFlow::Continue(());
                steps((&mesh).into(), &known.problem, &start, n, &mut go).unwrap()
            };
            let bounds = [0, 5, 20, 400].map(bound);
            assert_eq!(bounds[0], 0.0, "{name}");
            assert!(bounds[1] < bounds[2] && bounds[2] <= bounds[3], "{name}: {bounds:?}");
            let size = known.problem.spread();
            assert!(bounds[3] <= known.energy + 1e-12 * size, "{name}: {bounds:?}");
            assert!(bounds[3] >= 0.9 * known.energy, "{name}: {bounds:?} {}", known.energy);
        }
    }

    /// The bound is that of exactly the given number of steps of the default solver from this U. The observer gets no
    /// samples and can end the steps.
    #[test]
    fn steps_are_those_of_the_default_solver_from_the_given_u() {
        let mesh = bumpy(9);
        let problem = random_problem::<3>(&mesh, 0.05, 826);
        let start = random_labels::<3>(mesh.vertices.len(), 3, &mut rng(827));
        let of_run = |iterations: u64| {
            let start_of = start.clone();
            let setup = Setup {
                domain: (&mesh).into(),
                problem: &problem,
                start: start_of,
                dual_start: None,
            };
            let mut solver = Method::default().build(setup).unwrap();
            let mut run = Run::new(&start);
            let stop = Stop { iterations: Some(iterations), ..Stop::default() };
            run.advance(&mut *solver, &problem, &stop, &mut |_| ControlFlow::Continue(()));
            run.bound()
        };
        for n in [3, 20, 70] {
            let (mut calls, mut samples) = (0, 0);
            let mut observe = |sample: Option<&_>| {
                calls += 1;
                samples += u32::from(sample.is_some());
                ControlFlow::Continue(())
            };
            assert_eq!(
                steps((&mesh).into(), &problem, &start, n, &mut observe).unwrap(),
                of_run(n)
            );
            assert!((calls > 0 || n < FIRST_INTERVAL) && samples == 0, "{calls} {samples}");
        }
        let mut calls = 0;
        let mut observe = |_: Option<&_>| {
            calls += 1;
            ControlFlow::Break(())
        };
        let interrupted = steps((&mesh).into(), &problem, &start, 70, &mut observe).unwrap();
        assert_eq!((interrupted, calls), (of_run(FIRST_INTERVAL), 1));
    }
}
