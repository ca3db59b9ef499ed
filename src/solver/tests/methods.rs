//! Properties of particular methods: feasibility, momentum, fixed points, restarts, the consistent metric.

use strum::IntoEnumIterator;

use super::{
    CONSISTENT, after, all_variants, exact, run, solver, solver_from, uniform, variants_of,
};
use crate::field::Row;
use crate::mesh::Mesh;
use crate::operator::{Adjoint, Operator};
use crate::problem::FORBIDDEN_COST;
use crate::relaxation::{DualSet, Relaxation, with_set};
use crate::run::Status;
use crate::samples::{
    bumpy, disjoint, known_optimum, needles, random_labels, random_problem, rng, shape,
};

/// However many steps are made at once, the rows of U end in the simplex and the dual field in its balls.
#[test]
fn iterates_are_feasible() {
    let meshes = [bumpy(8), needles(4, 1e-6), shape("sphere:2").scaled(1e4)];
    let in_all = |mesh: Mesh| Relaxation::iter().map(move |relaxation| (mesh.clone(), relaxation));
    for (mesh, relaxation) in meshes.into_iter().flat_map(in_all) {
        let problem = random_problem::<7>(&mesh, 0.02 * mesh.area().sqrt(), 81);
        let problem = problem.in_relaxation(relaxation);
        let start = random_labels(mesh.vertices.len(), 7, &mut rng(82));
        for variant in all_variants() {
            let mut solver = solver(variant, &mesh, &problem, start.clone());
            for steps in [1, 7, 2, 16, 3, 25] {
                // After `go_on` returns false, one more step is made.
                let mut left = steps;
                let mut go_on = || {
                    left -= 1;
                    left > 0
                };
                let made = solver.advance(&problem, 20, &mut go_on);
                assert!((1..=20).contains(&made), "{variant:?}: {made}");
                let iterate = solver.iterate();
                for u in iterate.u {
                    assert!(u.min() >= 0.0, "{variant:?}: {u:?}");
                    assert!((u.0.iter().sum::<f64>() - 1.0).abs() <= 1e-12, "{variant:?}");
                }
                let bound = problem.lambda * (1.0 + 1e-14);
                let largest = with_set!(relaxation, set => {
                    iterate.q.iter().map(|&q| set.gauge(q)).fold(0.0, f64::max)
                });
                assert!(largest <= bound, "{variant:?}, {relaxation:?}: {largest}");
            }
        }
    }
}

/// Without momentum FISTA is projected gradient: equal bits, in every metric that both have.
#[test]
fn fista_without_momentum_is_projected_gradient() {
    let mesh = bumpy(9);
    let problem = random_problem::<4>(&mesh, 0.05, 83);
    let start = random_labels::<4>(mesh.vertices.len(), 4, &mut rng(84));
    for metric in ["mass-metric=barycentric", "mass-metric=voronoi", "mass-metric=none"] {
        for mode in ["epsilon-mode=intrinsic", "epsilon-mode=paper"] {
            let options: &[&str] = &[metric, mode, "restart=always"];
            let mut fista = solver(("fista", options), &mesh, &problem, start.clone());
            let mut plain =
                solver(("projected-gradient", &options[..2]), &mesh, &problem, start.clone());
            assert_eq!(
                after(&mut *fista, &problem, 50),
                after(&mut *plain, &problem, 50),
                "{metric}"
            );
        }
    }
}

/// Projected gradient with tau = 1/L never increases E_eps.
#[test]
fn projected_gradient_descends() {
    for mesh in [bumpy(8), needles(4, 1e-3), shape("sphere:2").scaled(1e-4)] {
        let problem = random_problem::<3>(&mesh, 0.05 * mesh.area().sqrt(), 85);
        for variant in variants_of("projected-gradient") {
            let mut solver = solver(variant, &mesh, &problem, uniform(mesh.vertices.len(), 3));
            let smoothing = solver.smoothing().unwrap();
            let mut before = problem.smoothed_energy(solver.iterate().u, smoothing);
            let first = before;
            for _ in 0..200 {
                solver.advance(&problem, 1, &mut || true);
                let now = problem.smoothed_energy(solver.iterate().u, smoothing);
                assert!(now <= before + 1e-13 * problem.spread(), "{variant:?}: {before} {now}");
                before = now;
            }
            assert!(before < first);
        }
    }
}

/// With the consistent mass matrix the pointwise projection is not that of the metric: the method settles above the
/// minimum of the same E_eps, which it reaches with lumped masses.
#[test]
fn the_consistent_metric_misses_the_minimizer() {
    let mesh = bumpy(10);
    let problem = random_problem::<3>(&mesh, 0.02, 86);
    let settle = |variant| {
        let mut solver = solver(variant, &mesh, &problem, uniform(mesh.vertices.len(), 3));
        let smoothing = solver.smoothing().unwrap();
        [20_000, 20_000].map(|steps| {
            let (u, _) = after(&mut *solver, &problem, steps);
            problem.smoothed_energy(&u, smoothing)
        })
    };
    let [_, lumped] = settle(("projected-gradient", &["epsilon=1"]));
    let [earlier, consistent] =
        settle(("projected-gradient", &["epsilon=1", "mass-metric=consistent"]));
    let missed = consistent - lumped;
    assert!(missed > 1e-4 * lumped.abs(), "{consistent} {lumped}");
    // The iterates are almost stationary: more iterations would not help.
    assert!((earlier - consistent).abs() < 0.01 * missed, "{earlier} {consistent} {lumped}");
}

/// Started at the known optimal labels, an exact method certifies them, and the best energy is the optimum from the
/// first sample on.
#[test]
fn the_optimum_is_certified_from_its_labels() {
    let mesh = shape("torus:12x8");
    let known = known_optimum::<3>(&mesh, 3, 0.05, 1.0, 87);
    for variant in exact() {
        let mut solver = solver(variant, &mesh, &known.problem, known.u.clone());
        let (run, _) = run(&mut *solver, &known.problem, 1e-9, 50_000);
        assert!(run.trace.len() > 2);
        assert!((run.energy() - known.energy).abs() <= 1e-12 * known.problem.spread());
    }
}

/// Started at a saddle point, q included, an exact method stays there.
#[test]
fn a_saddle_point_is_a_fixed_point() {
    for mesh in [shape("torus:12x8"), bumpy(7).scaled(1e4), needles(4, 1e-4).scaled(1e-4)] {
        let lambda = 0.05 * mesh.area().sqrt();
        let known = known_optimum::<3>(&mesh, 3, lambda, 1.0, 89);
        for variant in exact() {
            let start = (known.u.clone(), Some(known.q.clone()));
            let mut solver = solver_from(variant, &mesh, &known.problem, start);
            let (u, q) = after(&mut *solver, &known.problem, 25);
            for (u, w) in u.into_iter().zip(&known.u) {
                assert!((u - *w).max_abs() <= 1e-8, "{variant:?}: {u:?} {w:?}");
            }
            assert!(q.into_iter().zip(&known.q).all(|(q, r)| (q - *r).norm() <= 1e-8 * lambda));
        }
    }
}

/// f and lambda may change during a run: an exact method that is restarted, or follows them, converges to the new
/// optimum.
#[test]
fn costs_may_change_during_a_run() {
    let mesh = bumpy(8);
    let mut before = known_optimum::<3>(&mesh, 3, 0.1, 7.0, 90).problem;
    let known = known_optimum::<3>(&mesh, 3, 0.02, 1.0, 91);
    for (variant, follows) in exact().flat_map(|variant| [(variant, false), (variant, true)]) {
        let first = random_problem::<3>(&mesh, 0.1, 92);
        (before.f, before.lambda) = (first.f, first.lambda);
        let start = uniform(mesh.vertices.len(), 3);
        let mut solver = solver(variant, &mesh, &before, start);
        after(&mut *solver, &before, 40);
        (before.f, before.lambda) = (known.problem.f.clone(), known.problem.lambda);
        match follows {
            true => solver.follow(&before),
            false => solver.restart(&before),
        }
        let (run, status) = run(&mut *solver, &before, 1e-6, 100_000);
        assert_eq!(status, Status::Converged, "{variant:?}: {:?}", run.trace.last());
        assert!((run.energy() - known.energy).abs() <= 1.1e-6 * known.energy.abs());
    }
}

/// Gauss-Seidel and Cholesky reach the same optimum, whatever the step lengths.
#[test]
fn any_inner_solve_and_any_steps_reach_the_same_optimum() {
    let mesh = disjoint([bumpy(6), needles(3, 1e-3).scaled(10.0)]);
    let known = known_optimum::<4>(&mesh, 4, 0.3, 1.0, 93);
    for inner in ["inner=gauss-seidel", "inner=cholesky"] {
        for steps in ["reach=0.5", "reach=1", "reach=20", "step-ratio=0.1", "rho=1", "rho=1.95"] {
            for balance in ["balance=adaptive", "balance=fixed"] {
                let options: &[&str] = &[inner, steps, balance];
                let start = uniform(mesh.vertices.len(), 4);
                let mut solver =
                    solver(("douglas-rachford", options), &mesh, &known.problem, start);
                let (run, status) = run(&mut *solver, &known.problem, 1e-6, 50_000);
                assert_eq!(status, Status::Converged, "{options:?}: {:?}", run.trace.last());
                assert!((run.energy() - known.energy).abs() <= 1.1e-6 * known.energy.abs());
            }
        }
    }
}

/// Beck, Teboulle 2009: with t_1 = 1 and t_{n+1} = (1 + sqrt(1 + 4 t_n^2)) / 2,
/// Y^{n+1} = U^n + (t_n - 1) / t_{n+1} (U^n - U^{n-1}), and U^n is the projected gradient step from Y^n, which is the
/// first step of a method that starts there.
#[test]
fn the_momentum_is_that_of_the_paper() {
    let mesh = bumpy(6);
    let problem = random_problem::<3>(&mesh, 0.05, 94);
    let variant: (&str, &[&str]) = ("fista", &["restart=never", "epsilon=0.04"]);
    let start = uniform(mesh.vertices.len(), 3);
    let mut fista = solver(variant, &mesh, &problem, start.clone());
    let (mut y, mut before, mut t) = (start.clone(), start, 1.0_f64);
    for n in 1..=12 {
        let mut gradient = solver(variant, &mesh, &problem, y.clone());
        gradient.advance(&problem, 1, &mut || true);
        let u = gradient.iterate().u.to_vec();
        let next = 0.5 * (1.0 + (1.0 + 4.0 * t * t).sqrt());
        let momentum = (t - 1.0) / next;
        y = u.iter().zip(&before).map(|(&u, &b)| u + (u - b) * momentum).collect();
        (before, t) = (u, next);
        fista.advance(&problem, 1, &mut || true);
        for (u, expected) in fista.iterate().u.iter().zip(&before) {
            assert!((*u - *expected).max_abs() <= 1e-13, "step {n}");
        }
    }
}

/// O'Donoghue, Candès 2015: momentum is dropped, t = 1 again, where <Y^n - U^{n+1}, U^{n+1} - U^n> > 0, and nowhere
/// else.
#[test]
fn momentum_is_dropped_where_it_leads_uphill() {
    let mesh = bumpy(6);
    let problem = random_problem::<3>(&mesh, 0.05, 95);
    let options = ["mass-metric=none", "epsilon=0.04", "restart=adaptive"];
    let start = uniform(mesh.vertices.len(), 3);
    let mut fista = solver(("fista", &options), &mesh, &problem, start.clone());
    let (mut y, mut before, mut t, mut dropped) = (start.clone(), start, 1.0_f64, 0);
    for n in 1..=150 {
        let mut gradient = solver(("fista", &options), &mesh, &problem, y.clone());
        gradient.advance(&problem, 1, &mut || true);
        let u = gradient.iterate().u.to_vec();
        let uphill: f64 =
            y.iter().zip(&u).zip(&before).map(|((&y, &u), &b)| (y - u).dot(u - b)).sum();
        let next = if uphill > 0.0 { 1.0 } else { 0.5 * (1.0 + (1.0 + 4.0 * t * t).sqrt()) };
        let momentum = if uphill > 0.0 { 0.0 } else { (t - 1.0) / next };
        dropped += usize::from(uphill > 0.0);
        y = u.iter().zip(&before).map(|(&u, &b)| u + (u - b) * momentum).collect();
        (before, t) = (u, next);
        fista.advance(&problem, 1, &mut || true);
        for (u, expected) in fista.iterate().u.iter().zip(&before) {
            assert!((*u - *expected).max_abs() <= 1e-10, "step {n}");
        }
    }
    assert!((1..50).contains(&dropped), "{dropped}");
}

/// After a restart with other costs, a method continues like a new one that starts from the same pair.
#[test]
fn a_restarted_method_is_like_a_new_one() {
    let mesh = bumpy(9);
    let first = random_problem::<3>(&mesh, 0.1, 96);
    for variant in [
        ("chambolle-pock", &[] as &[&str]),
        ("chambolle-pock", &["engine=rows"]),
        ("fista", &[]),
        ("fista", &["restart=never"]),
        ("projected-gradient", &[]),
    ] {
        let mut problem = random_problem::<3>(&mesh, 0.1, 96);
        let mut old = solver(variant, &mesh, &first, uniform(mesh.vertices.len(), 3));
        let pair = after(&mut *old, &problem, 150);
        // With costs a hundredth as large, the initial omega differs.
        problem.set_costs(first.f.iter().map(|f| Row([f.0[1], f.0[2], f.0[0]]) * 0.01).collect());
        old.restart(&problem);
        let mut new = solver_from(variant, &mesh, &problem, (pair.0, Some(pair.1)));
        for steps in [1, 9, 120, 30] {
            let (u, q) = after(&mut *old, &problem, steps);
            let (w, r) = after(&mut *new, &problem, steps);
            let difference = u.iter().zip(&w).map(|(&u, &w)| (u - w).max_abs()).fold(0.0, f64::max);
            assert!(difference <= 1e-9, "{variant:?}: {difference}");
            let difference = q.iter().zip(&r).map(|(&q, &r)| (q - r).norm()).fold(0.0, f64::max);
            assert!(difference <= 1e-9 * problem.lambda, "{variant:?}: {difference}");
        }
    }
}

/// Continuation starts with a larger eps and ends with the requested one.
#[test]
fn continuation_ends_at_the_requested_epsilon() {
    let mesh = bumpy(6);
    let problem = random_problem::<3>(&mesh, 0.05, 88);
    let variant: (&str, &[&str]) = ("fista", &["continuation=16", "epsilon=0.04"]);
    let mut solver = solver(variant, &mesh, &problem, uniform(mesh.vertices.len(), 3));
    let mut epsilons = Vec::new();
    for _ in 0..20 {
        epsilons.push(solver.smoothing().unwrap().epsilon);
        solver.advance(&problem, 1, &mut || true);
    }
    assert!(epsilons.windows(2).all(|pair| pair[1] <= pair[0]));
    assert!((epsilons[0] / 0.04 - 256.0).abs() < 1e-9 && epsilons[19] == 0.04);
}

/// The curvature, and therefore the step length, changes with eps: each step of a continuation is the first step of a
/// method with the current eps.
#[test]
fn continuation_takes_the_steps_of_its_epsilon() {
    let mesh = bumpy(6);
    let problem = random_problem::<3>(&mesh, 0.05, 97);
    for metric in ["mass-metric=local", "mass-metric=barycentric"] {
        for mode in ["epsilon-mode=intrinsic", "epsilon-mode=paper"] {
            let options = [metric, mode, "restart=always", "epsilon=0.04", "continuation=7"];
            let start = uniform(mesh.vertices.len(), 3);
            let mut continued = solver(("fista", &options), &mesh, &problem, start);
            for n in 1..=10 {
                let epsilon = format!("epsilon={}", continued.smoothing().unwrap().epsilon);
                let here = continued.iterate().u.to_vec();
                let options = [metric, mode, "restart=always", &epsilon];
                let mut fixed = solver(("fista", &options), &mesh, &problem, here);
                let (u, _) = after(&mut *continued, &problem, 1);
                let (w, _) = after(&mut *fixed, &problem, 1);
                let difference =
                    u.iter().zip(&w).map(|(&u, &w)| (u - w).max_abs()).fold(0.0, f64::max);
                assert!(difference <= 1e-12, "{metric}, {mode}, step {n}: {difference}");
            }
        }
    }
}

/// M^-1 has entries of both signs, so that a label forbidden at one vertex would look cheap or expensive at others.
/// They move as if its gradient were zero, and the vertex itself does not take the label.
#[test]
fn the_consistent_metric_ignores_forbidden_labels() {
    let mesh = bumpy(8);
    let n = mesh.vertices.len();
    let start = || {
        let mut start = uniform::<3>(n, 3);
        start[40] = Row([0.5, 0.0, 0.5]);
        start
    };
    let mut forbidding = random_problem::<3>(&mesh, 0.05, 98);
    let mut without = random_problem::<3>(&mesh, 0.05, 98);
    forbidding.f[40].0[1] = FORBIDDEN_COST;
    let mut solver = solver(CONSISTENT, &mesh, &forbidding, start());
    let (u, q) = after(&mut *solver, &forbidding, 1);
    without.f[40].0[1] = -without.k.adjoint().at(&q, 40).0[1];
    let mut free = super::solver(CONSISTENT, &mesh, &without, start());
    let (w, _) = after(&mut *free, &without, 1);
    for v in (0..n).filter(|&v| v != 40) {
        assert!((u[v] - w[v]).max_abs() <= 1e-13, "{v}: {:?} {:?}", u[v], w[v]);
    }
    assert!(u[40].0[1] == 0.0 && (u[40].0.iter().sum::<f64>() - 1.0).abs() <= 1e-14);
    assert!((0..n).any(|v| (u[v] - start()[v]).max_abs() > 1e-6));
}
