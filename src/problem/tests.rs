//! Bounds, smoothing and gaps: statements on the energies that hold for any mesh and any labels.

use rand::RngExt;
use strum::IntoEnumIterator;

use super::*;
use crate::mesh::Mesh;
use crate::operator::{Adjoint, Stencil};
use crate::samples::{
    assert_within, bumpy, known_optimum_in, observed_order, random_dual, random_dual_in,
    random_labels, random_problem, random_rows, rng, shape, zoo,
};

/// Both modes, each with an eps far below, near and far above the gradients.
fn smoothings(k: &Stencil) -> Vec<Smoothing> {
    [SmoothingMode::Paper, SmoothingMode::Intrinsic]
        .into_iter()
        .flat_map(|mode| {
            let epsilon = Smoothing::default_for(k, mode).epsilon;
            [1e-4, 1.0, 1e4].map(|factor| Smoothing::new(mode, factor * epsilon).unwrap())
        })
        .collect()
}

/// Each with every relaxation.
fn in_all_relaxations<T: Clone>(
    of: impl IntoIterator<Item = T>,
) -> impl Iterator<Item = (T, Relaxation)> {
    of.into_iter().flat_map(|one| Relaxation::iter().map(move |other| (one.clone(), other)))
}

#[test]
fn every_dual_field_bounds_every_energy() {
    let mut rng = rng(41);
    for ((name, mesh), relaxation) in in_all_relaxations(zoo()) {
        for lambda in [0.0, 0.01, 1.0, 100.0] {
            let lambda = lambda * mesh.area().sqrt();
            let problem = random_problem::<4>(&mesh, lambda, 42).in_relaxation(relaxation);
            let mut least = f64::INFINITY;
            let mut greatest = f64::NEG_INFINITY;
            for _ in 0..20 {
                let u = random_labels::<4>(mesh.vertices.len(), 4, &mut rng);
                let q = random_dual_in::<4>(relaxation, mesh.faces.len(), lambda, &mut rng);
                least = least.min(problem.energy(&u));
                greatest = greatest.max(problem.dual_bound(&q));
            }
            assert!(
                greatest <= least,
                "{name}, {relaxation:?}, lambda {lambda}: {greatest} {least}"
            );
        }
    }
}

/// The bound is attained: the constructed pair has no gap, and no other pair is better.
#[test]
fn the_constructed_optimum_has_no_gap() {
    let mut rng = rng(43);
    for ((name, mesh), relaxation) in in_all_relaxations(zoo()) {
        let scale = mesh.area().sqrt();
        for lambda in [0.01, 1.0, 10.0] {
            let known = known_optimum_in::<4>(relaxation, &mesh, 3, lambda * scale, 1.0, 44);
            let problem = &known.problem;
            let size = problem.spread();
            assert_within(problem.energy(&known.u), known.energy, 1e-12, size);
            assert_within(problem.dual_bound(&known.q), known.energy, 1e-12, size);
            for _ in 0..5 {
                let u = random_labels::<4>(mesh.vertices.len(), 3, &mut rng);
                let faces = mesh.faces.len();
                let q = random_dual_in::<4>(relaxation, faces, problem.lambda, &mut rng);
                assert!(problem.energy(&u) >= known.energy - 1e-12 * size, "{name}");
                assert!(problem.dual_bound(&q) <= known.energy + 1e-12 * size, "{name}");
            }
        }
    }
}

/// E_eps(U + h W) = E_eps(U) + h <f + K^T q, W> + O(h^2): the remainder has order 2 in h.
#[test]
fn the_dual_of_the_smoothing_gives_the_gradient_of_the_smoothed_energy() {
    let mut rng = rng(45);
    let meshes = [shape("sphere:2"), bumpy(7), bumpy(7).scaled(1e-4), bumpy(7).scaled(1e4)];
    for (mesh, relaxation) in in_all_relaxations(meshes) {
        let lambda = 0.5 * mesh.area().sqrt();
        let problem = random_problem::<3>(&mesh, lambda, 46).in_relaxation(relaxation);
        let n = mesh.vertices.len();
        // The sum of the rows of U is constant, and that of K U is zero.
        let mut rows = || {
            let rows = random_rows::<3>(n, &mut rng).into_iter();
            rows.map(|u| Row(u.0.map(|x| x - u.0.iter().sum::<f64>() / 3.0))).collect()
        };
        let (u, w): (Vec<Row<3>>, Vec<Row<3>>) = (rows(), rows());
        for smoothing in smoothings(&problem.k) {
            let k = &problem.k;
            let excess = |j: usize| k.at(&u, j).norm() / smoothing.radius(k.area(j));
            if relaxation == Relaxation::Envelope && (0..k.faces()).any(|j| excess(j) > 100.0) {
                // So far outside the set, the projection onto it ends early.
                continue;
            }
            let mut q = vec![Tangent::ZERO; k.faces()];
            problem.smoothed_dual(&u, smoothing, &mut q);
            let allowed = lambda * (1.0 + 1e-14);
            with_set!(relaxation, set => assert!(q.iter().all(|&q| set.gauge(q) <= allowed)));
            let slope: f64 = (0..n).map(|v| (problem.f[v] + k.adjoint().at(&q, v)).dot(w[v])).sum();
            let at = |h: f64| {
                let moved: Vec<Row<3>> = u.iter().zip(&w).map(|(&u, &w)| u + w * h).collect();
                problem.smoothed_energy(&moved, smoothing)
            };
            let start = at(0.0);
            let steps = [4e-4, 2e-4, 1e-4, 5e-5];
            let remainders = steps.map(|h| (at(h) - start - h * slope).abs());
            let order = observed_order(&steps, &remainders);
            assert!((order - 2.0).abs() < 0.1, "{smoothing:?}: order {order}, {remainders:?}");
        }
    }
}

/// E <= E_eps <= E + lambda sqrt(eps) area (intrinsic), or <= E + lambda F sqrt(eps) / 2 (paper).
#[test]
fn the_bias_of_the_smoothing_is_bounded() {
    let mut rng = rng(47);
    for (name, mesh) in zoo() {
        let lambda = 0.3 * mesh.area().sqrt();
        let problem = random_problem::<3>(&mesh, lambda, 48);
        let labels = random_labels::<3>(mesh.vertices.len(), 3, &mut rng);
        let constant = vec![Row([0.2, 0.3, 0.5]); mesh.vertices.len()];
        for smoothing in smoothings(&problem.k) {
            let root = smoothing.epsilon.sqrt();
            let bias = match smoothing.mode {
                SmoothingMode::Intrinsic => lambda * root * mesh.area(),
                SmoothingMode::Paper => lambda * root * mesh.faces.len() as f64 / 2.0,
            };
            for u in [&labels, &constant] {
                let (energy, smoothed) = (problem.energy(u), problem.smoothed_energy(u, smoothing));
                let slack = 1e-12 * (energy.abs() + bias);
                assert!(energy <= smoothed + slack, "{name}");
                assert!(smoothed <= energy + bias + slack, "{name}");
            }
            // A constant U attains the bias.
            let smoothed = problem.smoothed_energy(&constant, smoothing);
            let data = problem.data_term(&constant);
            assert_within(smoothed - data, bias, 1e-9, bias + data.abs());
        }
    }
}

/// (lambda/2) sum_j sqrt( sum_p (ua^2 G - 2 ua ub F + ub^2 E) + eps ), as printed in equations (7) and (9).
#[test]
fn the_paper_mode_is_the_printed_formula() {
    let mut rng = rng(49);
    for mesh in [shape("sphere:2"), shape("torus:16x10"), bumpy(6), bumpy(6).scaled(1e-4)] {
        let lambda = 0.7 * mesh.area().sqrt();
        let problem = random_problem::<3>(&mesh, lambda, 50);
        let u = random_labels::<3>(mesh.vertices.len(), 3, &mut rng);
        for smoothing in smoothings(&problem.k) {
            if smoothing.mode == SmoothingMode::Intrinsic {
                continue;
            }
            let printed: f64 = (0..mesh.faces.len())
                .map(|j| {
                    let xi = printed_radicand(&mesh, &u, j);
                    0.5 * (xi + smoothing.epsilon).sqrt()
                })
                .sum();
            let expected = problem.data_term(&u) + lambda * printed;
            assert_within(problem.smoothed_energy(&u, smoothing), expected, 1e-12, expected);
        }
    }
}

fn printed_radicand(mesh: &Mesh, u: &[Row<3>], j: usize) -> f64 {
    let x = mesh.corners(j);
    let (a, b) = (x[1] - x[0], x[2] - x[0]);
    let (e, f, g) = (a.dot(&a), a.dot(&b), b.dot(&b));
    let [u1, u2, u3] = mesh.faces[j].map(|k| u[k as usize]);
    (0..3)
        .map(|p| {
            let (ua, ub) = (u2.0[p] - u1.0[p], u3.0[p] - u1.0[p]);
            ua * ua * g - 2.0 * ua * ub * f + ub * ub * e
        })
        .sum()
}

/// The default eps follows the units of the mesh: in both modes the bias scales with a length.
#[test]
fn the_default_smoothing_follows_the_scale() {
    let mesh = shape("sphere:2");
    let u = random_labels::<3>(mesh.vertices.len(), 3, &mut rng(51));
    for mode in SmoothingMode::iter() {
        let bias = |mesh: &Mesh| {
            let problem = Problem::new(Stencil::new(mesh), vec![Row::ZERO; u.len()], 1.0);
            let smoothing = Smoothing::default_for(&problem.k, mode);
            problem.smoothed_energy(&u, smoothing) - problem.energy(&u)
        };
        for c in [1e-4, 1e4] {
            assert_within(bias(&mesh.clone().scaled(c)), c * bias(&mesh), 1e-9, c * bias(&mesh));
        }
    }
}

#[test]
fn an_epsilon_must_be_a_positive_number() {
    for epsilon in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let message = Smoothing::new(SmoothingMode::Paper, epsilon).unwrap_err().to_string();
        assert!(message.contains("positive") && !message.contains('\n'), "{message}");
    }
}

/// Two regions: U = (u, 1 - u) has E(U) = sum f_2 + sum (f_1 - f_2) u + sqrt(2) lambda sum A_j |grad u|.
#[test]
fn two_regions_give_chan_vese_with_root_two_lambda() {
    let mut rng = rng(52);
    for (_, mesh) in zoo() {
        let lambda = 0.4 * mesh.area().sqrt();
        let problem = random_problem::<2>(&mesh, lambda, 53);
        let u: Vec<f64> = mesh.vertices.iter().map(|_| rng.random()).collect();
        let pair: Vec<Row<2>> = u.iter().map(|&u| Row([u, 1.0 - u])).collect();
        let data: f64 = problem.f.iter().zip(&u).map(|(f, u)| f.0[1] + (f.0[0] - f.0[1]) * u).sum();
        let scalar: Vec<Row<2>> = u.iter().map(|&u| Row([u, 0.0])).collect();
        let variation: f64 = (0..mesh.faces.len()).map(|j| problem.k.at(&scalar, j).norm()).sum();
        let expected = data + 2.0_f64.sqrt() * lambda * variation;
        assert_within(problem.energy(&pair), expected, 1e-12, expected.abs() + mesh.area());
    }
}

/// Scaling the mesh by c, with the same pointwise costs, equals lambda -> lambda / c: E_c = c^2 E.
#[test]
fn scaling_the_mesh_is_equivalent_to_scaling_lambda() {
    let mesh = bumpy(8);
    let u = random_labels::<3>(mesh.vertices.len(), 3, &mut rng(54));
    let s = random_rows::<3>(mesh.vertices.len(), &mut rng(55));
    for mass in crate::operator::Mass::iter() {
        let energy = |mesh: &Mesh, lambda: f64| {
            Problem::new(Stencil::new(mesh), mass.on(mesh).integrate(&s), lambda).energy(&u)
        };
        for c in [1e-4, 0.5, 1e4] {
            let expected = c * c * energy(&mesh, 0.2 / c);
            assert_within(energy(&mesh.clone().scaled(c), 0.2), expected, 1e-12, expected);
        }
    }
}

#[test]
fn nan_in_is_nan_out() {
    let mesh = bumpy(4);
    let mut problem = random_problem::<3>(&mesh, 0.1, 56);
    let n = mesh.vertices.len();
    let zero = vec![Tangent::<3>::ZERO; mesh.faces.len()];
    let good = vec![Row([0.2, 0.3, 0.5]); n];
    for p in 0..3 {
        let mut u = good.clone();
        u[7].0[p] = f64::NAN;
        assert!(problem.energy(&u).is_nan());
        for smoothing in smoothings(&problem.k) {
            assert!(problem.smoothed_energy(&u, smoothing).is_nan());
        }
        let mut q = zero.clone();
        q[5].0[0].0[p] = f64::NAN;
        assert!(problem.dual_bound(&q).is_nan());
    }
    problem.f[3].0[1] = f64::NAN;
    assert!(problem.energy(&good).is_nan() && problem.dual_bound(&zero).is_nan());
    assert!(problem.spread().is_nan());
    for gap in [relative_gap, label_gap] {
        assert!(gap(f64::NAN, 1.0).is_nan() && gap(1.0, f64::NAN).is_nan());
    }
}

/// A constant at each vertex adds a constant to every energy and bound; quantities measured from B do not change.
#[test]
fn constants_change_only_the_baseline() {
    let mut rng = rng(57);
    for (name, mesh) in zoo() {
        let n = mesh.vertices.len();
        let problem = random_problem::<3>(&mesh, 0.1 * mesh.area().sqrt(), 58);
        let constants: Vec<f64> = (0..n).map(|_| rng.random_range(-1e3..1e3)).collect();
        let raised = |c: f64| {
            let f = problem.f.iter().zip(&constants);
            let f = f.map(|(&f, x)| f + Row([c * x; 3])).collect();
            Problem::new(Stencil::new(&mesh), f, problem.lambda)
        };
        let (same, other) = (raised(0.0), raised(1.0));
        assert_eq!((same.baseline, &same.f), (0.0, &problem.f));
        let sum: f64 = constants.iter().sum();
        assert_within(other.baseline, sum, 1e-12, 1e3 * n as f64);
        let u = random_labels::<3>(n, 3, &mut rng);
        let q = random_dual::<3>(mesh.faces.len(), problem.lambda, &mut rng);
        // Costs lose three digits when about a thousand is added.
        let size = 1e3 * n as f64 + problem.spread();
        assert_within(other.energy(&u), problem.energy(&u), 1e-14, size);
        assert_within(other.dual_bound(&q), problem.dual_bound(&q), 1e-14, size);
        assert!(other.f.iter().all(|f| f.min() == 0.0), "{name}");
        assert_eq!(problem.dual_bound(&vec![Tangent::<3>::ZERO; mesh.faces.len()]), 0.0);
    }
}

#[test]
fn gaps_are_relative_to_the_baseline() {
    assert_eq!(relative_gap(2.0, 1.0), 0.5);
    assert_eq!(relative_gap(2.0, 0.0), 1.0);
    assert_eq!(relative_gap(0.0, 0.0), 0.0);
    assert_eq!(relative_gap(1e-20, 0.0), 1.0);
    // A bound above the energy gives a negative gap.
    assert_eq!(relative_gap(1.0, 2.0), -1.0);
    assert_eq!(label_gap(3.0, 2.0), 0.5);
    assert_eq!(label_gap(3.0, 0.0), f64::INFINITY);
    assert_eq!(label_gap(0.0, 0.0), 0.0);
    assert_eq!(label_gap(f64::INFINITY, 1.0), f64::INFINITY);
}

/// The tolerance for rounding depends neither on costs of unused labels nor on their spread.
#[test]
fn a_bound_is_clamped_only_within_rounding() {
    let mesh = bumpy(6);
    for huge in [1.0, 1e20] {
        let mut f = random_problem::<3>(&mesh, 0.05, 59).f;
        f[4] = Row([huge, 0.0, huge]);
        let problem = Problem::new(Stencil::new(&mesh), f, 0.05);
        assert_eq!(problem.clamped_bound(1.0, 1.0 + 1e-15), 1.0);
        assert_eq!(problem.clamped_bound(1.0, 1.0 + 1e-9), 1.0 + 1e-9);
        assert_eq!(problem.clamped_bound(1.0, 0.5), 0.5);
    }
}

#[test]
fn the_spread_ignores_padding_regions_and_forbidden_labels() {
    let mesh = shape("grid:1x1");
    let f = vec![
        Row([1.0, -2.0, FORBIDDEN_COST]),
        Row([3.0, 4.0, FORBIDDEN_COST]),
        Row([FORBIDDEN_COST, 0.5, FORBIDDEN_COST]),
        Row([2.0, 2.0, FORBIDDEN_COST]),
    ];
    let problem = Problem::new(Stencil::new(&mesh), f, 1.0);
    assert_eq!((problem.spread(), problem.baseline), (3.0 + 1.0, -2.0 + 3.0 + 0.5 + 2.0));
    assert_eq!(problem.f[2], Row([FORBIDDEN_COST, 0.0, FORBIDDEN_COST]));
}

#[test]
fn rounding_takes_the_first_largest_entry() {
    let u = [Row([0.2, 0.5, 0.3]), Row([0.4, 0.2, 0.4]), Row([0.0, 0.0, 1.0])];
    assert_eq!(rounded(&u), [1, 0, 2].map(Row::one_hot));
}

/// Padding regions and forbidden labels stay forbidden, however much the others cost.
#[test]
fn forbidden_costs_stay_forbidden() {
    let mesh = shape("grid:2x2");
    for cost in [-1e289, -1.0, 0.0, 1e289] {
        let f = vec![Row([cost, 2.0 * cost, FORBIDDEN_COST]); mesh.vertices.len()];
        let problem = Problem::new(Stencil::new(&mesh), f, 1.0);
        assert!(problem.f.iter().all(|f| f.0[2] == FORBIDDEN_COST && f.min() == 0.0), "{cost:e}");
    }
}

/// The default radii of both modes agree on meshes whose faces have equal areas.
#[test]
fn the_default_smoothings_agree_on_equal_faces() {
    let mesh = shape("grid:7x7").scaled(3.0);
    let k = Stencil::new(&mesh);
    let radius = |mode| Smoothing::default_for(&k, mode).radius(mesh.face_area(0));
    assert_within(
        radius(SmoothingMode::Paper),
        radius(SmoothingMode::Intrinsic),
        1e-12,
        radius(SmoothingMode::Paper),
    );
}
