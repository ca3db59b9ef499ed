//! Evaluations are true of their U, also with rounding errors, forbidden labels or rows outside the simplex.

use std::ops::ControlFlow;

use super::*;
use crate::mesh::dual::Dual;
use crate::mesh::geometry::barycentric_areas;
use crate::problem::SmoothingMode;
use crate::run::{Sample, Stop};
use crate::samples::{Known, known_optimum, random_labels, random_rows, rng, shape};
use crate::seeds::Seeds;
use crate::solve::{Request, solve_on_faces};
use crate::solver::Method;

const LAMBDA: f64 = 0.05;

fn go(_: Option<&Sample>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn question() -> Question<'static> {
    Question {
        lambda: LAMBDA,
        relaxation: Default::default(),
        mass: Mass::Barycentric,
        smoothing: None,
        q: None,
        dual_steps: 20,
    }
}

fn found(mesh: &Mesh, s: &Array2<f64>, u: &Array2<f64>, question: Question<'_>) -> Evaluation {
    evaluate(mesh, s, u, question, &mut go).unwrap()
}

/// A torus with random costs and random labels.
fn example(seed: u64) -> (Mesh, Array2<f64>, Array2<f64>) {
    let mesh = shape("torus:12x8");
    let n = mesh.vertices.len();
    let s = regions::array(&random_rows::<3>(n, &mut rng(seed)), 3);
    let u = regions::array(&random_labels::<3>(n, 3, &mut rng(seed + 1)), 3);
    (mesh, s, u)
}

/// A torus with costs whose minimum energy is known.
fn exact(seed: u64) -> (Mesh, Vec<f64>, Known<3>) {
    let mesh = shape("torus:12x8");
    let (areas, known) = (barycentric_areas(&mesh), known_optimum(&mesh, 3, LAMBDA, 1.0, seed));
    (mesh, areas, known)
}

/// The pointwise costs, the optimal labels and their dual field.
fn arrays(areas: &[f64], Known { problem, u, q, .. }: &Known<3>) -> [Array2<f64>; 3] {
    let s = Array2::from_shape_fn((areas.len(), 3), |(v, p)| problem.f[v].0[p] / areas[v]);
    let q = Array2::from_shape_fn((2 * q.len(), 3), |(row, p)| q[row / 2].0[row % 2].0[p]);
    [s, regions::array(u, 3), q]
}

/// Powers of two far from 1 change the exponents of the scores, and no bit else, with a given q and without one.
#[test]
fn costs_of_any_size_have_the_same_scores() {
    let (mesh, areas, known) = exact(827);
    let [s, u, q] = arrays(&areas, &known);
    let smoothing = Smoothing { mode: SmoothingMode::Intrinsic, epsilon: 0.01 };
    for with_q in [true, false] {
        let scores = |factor: f64| {
            let q = q.mapv(|x| factor * x);
            let question = Question {
                lambda: factor * LAMBDA,
                smoothing: Some(smoothing),
                q: with_q.then_some(&q),
                ..question()
            };
            found(&mesh, &s.mapv(|x| factor * x), &u, question)
        };
        let expected = scores(1.0);
        for exponent in [-990, -540, 540, 990] {
            let (factor, found) = (f64::from(exponent).exp2(), scores(f64::from(exponent).exp2()));
            for (a, b) in [
                (found.energy, expected.energy),
                (found.data_term, expected.data_term),
                (found.dual_bound, expected.dual_bound),
                (found.baseline, expected.baseline),
                (found.rounded_energy, expected.rounded_energy),
                (found.gap.unwrap(), expected.gap.unwrap()),
                (found.smoothed_energy.unwrap(), expected.smoothed_energy.unwrap()),
                (found.lambda, expected.lambda),
            ] {
                assert_eq!(a, factor * b, "2^{exponent}");
            }
            assert_eq!(found.total_variation, expected.total_variation);
            assert_eq!(found.relative_gap, expected.relative_gap);
            assert_eq!(found.certificate, expected.certificate);
        }
    }
}

/// Where D = E* = E, rounding decides which of the two is larger. Neither the gap of the labels nor that of a U
/// slightly above them becomes negative.
#[test]
fn rounding_does_not_make_gaps_negative() {
    let (mut zero_gaps, mut zero_label_gaps) = (0, 0);
    for seed in 900..916 {
        let (mesh, areas, known) = exact(seed);
        let [s, u, q] = arrays(&areas, &known);
        let question = Question { q: Some(&q), ..question() };
        let least = found(&mesh, &s, &u, question);
        let gaps = [least.gap.unwrap(), least.relative_gap.unwrap(), least.rounded_relative_gap];
        assert!(gaps.iter().all(|gap| (0.0..1e-12).contains(gap)), "{seed}: {gaps:?}");
        zero_gaps += u32::from(least.gap == Some(0.0));
        let above = found(&mesh, &s, &u.mapv(|u| 0.999 * u + 0.001 / 3.0), question);
        assert!(above.gap.unwrap() > 0.0, "{seed}");
        let gap = above.rounded_relative_gap;
        assert!((0.0..1e-12).contains(&gap), "{seed}: {gap}");
        zero_label_gaps += u32::from(gap == 0.0);
    }
    assert!(zero_gaps >= 4 && zero_label_gaps >= 4, "{zero_gaps} {zero_label_gaps}");
}

/// The data term is sum_k <u_k, f_k>, whatever the rows of U sum to and whatever constant is added to the costs.
#[test]
fn the_data_term_is_that_of_the_given_rows() {
    let (mesh, s, u) = example(918);
    let areas = barycentric_areas(&mesh);
    for (factor, constant) in [(1.0, 0.0), (1.0, 7.0), (1.5, 0.0), (1.5, 7.0), (-0.5, -3.0)] {
        let (s, u) = (s.mapv(|s| s + constant), u.mapv(|u| factor * u));
        let terms =
            (u.outer_iter().zip(s.outer_iter()).zip(&areas)).map(|((u, s), a)| a * u.dot(&s));
        let (expected, size) =
            terms.fold((0.0, 0.0), |(sum, size), x: f64| (sum + x, size + x.abs()));
        let scored = found(&mesh, &s, &u, question());
        assert!((scored.data_term - expected).abs() <= 1e-13 * size, "{factor} {constant}");
        let energy = expected + LAMBDA * scored.total_variation;
        assert!((scored.energy - energy).abs() <= 1e-13 * size, "{factor} {constant}");
    }
}

/// The energy of an infeasible U is computed, but has no gap: rows that do not sum to one, and negative entries. The
/// padding of a row does not count as entries.
#[test]
fn only_feasible_labels_have_a_gap() {
    let (mesh, s, _) = example(920);
    let row = |row: [f64; 3]| {
        let u = Array2::from_shape_fn(s.dim(), |(_, p)| row[p]);
        found(&mesh, &s, &u, question())
    };
    let inside = row([0.25, 0.25, 0.5]);
    assert!(inside.feasible && inside.gap.is_some() && inside.relative_gap.is_some());
    assert_eq!((inside.smallest_entry, inside.largest_row_sum_error), (0.25, 0.0));
    for (outside, error, smallest) in [
        ([0.25, 0.25, 0.25], 0.25, 0.25),
        ([0.5, 0.5, 0.25], 0.25, 0.25),
        ([1.25, 0.0, -0.25], 0.0, -0.25),
    ] {
        let found = row(outside);
        assert!(!found.feasible && found.gap.is_none() && found.relative_gap.is_none());
        assert_eq!((found.largest_row_sum_error, found.smallest_entry), (error, smallest));
    }
    // Rounding errors are accepted.
    assert!(row([0.25 + 1e-10, 0.25, 0.5]).feasible && row([1.0, 1e-10, -1e-10]).feasible);
    // The largest of three negative entries wins, not the zero of a padding region.
    let (negative, first) = (row([-1.0, -2.0, -2.0]), row([1.0, 0.0, 0.0]));
    assert_eq!(negative.rounded_energy, first.rounded_energy);
}

/// Our own steps start from the projection of U onto the simplex.
#[test]
fn steps_start_on_the_simplex() {
    let (mesh, s, u) = example(930);
    let outside = &u * 3.0 - 1.0;
    let order = Order::as_it_is();
    let f = vec![Row::<3>::ZERO; u.nrows()];
    let nearest = regions::array(&Start::Given(outside.clone()).rows(3, &f, &order), 3);
    let bound = |u| found(&mesh, &s, u, question()).dual_bound;
    assert_eq!(bound(&outside), bound(&nearest));
    assert_ne!(bound(&outside), bound(&u.mapv(|_| 1.0 / 3.0)));
}

/// The best available bound is taken and named. A zero field and zero steps give B; at the minimum, a smoothing gives
/// more than B, but less than the optimal field or many steps.
#[test]
fn the_best_bound_is_taken() {
    let (mesh, areas, known) = exact(931);
    let [s, u, q] = arrays(&areas, &known);
    let of = |question: Question<'_>| {
        let found = found(&mesh, &s, &u, question);
        (found.dual_bound - found.baseline, found.certificate)
    };
    let nothing = Array2::zeros(q.dim());
    let smoothing = Some(Smoothing::new(SmoothingMode::Intrinsic, 1e-3).unwrap());
    let steps = |dual_steps| Question { dual_steps, ..question() };
    let zero = Question { q: Some(&nothing), ..question() };
    assert_eq!(of(zero), (0.0, Certificate::Offered));
    assert_eq!(of(steps(0)), (0.0, Certificate::Steps));
    let (smoothed, certificate) = of(Question { smoothing, ..zero });
    assert!(smoothed > 0.0 && certificate == Certificate::Smoothed);
    assert_eq!(of(Question { smoothing, ..steps(0) }), (smoothed, certificate));
    for question in [Question { q: Some(&q), ..question() }, steps(3000)] {
        let (best, certificate) = of(question);
        assert!(best > smoothed, "{best} {smoothed}");
        assert_eq!(of(Question { smoothing, ..question }), (best, certificate));
    }
}

/// Mass at a forbidden label costs nothing if it is within rounding of zero, and is refused otherwise.
#[test]
fn forbidden_labels_are_rounded_away_or_refused() {
    let (mesh, mut s, _) = example(940);
    s[[17, 1]] = f64::INFINITY;
    let mut u = Array2::from_shape_fn(s.dim(), |(_, p)| f64::from(u8::from(p == 0)));
    let clean = found(&mesh, &s, &u, question());
    assert!(clean.warnings[0].contains("1 cost is +inf"), "{:?}", clean.warnings);
    for off in [1e-10, -1e-10] {
        u[[17, 1]] = off;
        let found = found(&mesh, &s, &u, question());
        assert_eq!((found.energy, found.rounded_energy), (clean.energy, clean.rounded_energy));
        assert!(found.feasible && found.gap.is_some());
    }
    for off in [1e-6, -1e-6, 1.0] {
        u[[17, 1]] = off;
        let error = evaluate(&mesh, &s, &u, question(), &mut go).unwrap_err().to_string();
        assert!(error.contains("row 17, column 1"), "{error}");
    }
}

#[test]
fn invalid_inputs_are_refused() {
    let (mesh, s, u) = example(950);
    let refused = |s: &Array2<f64>, u: &Array2<f64>, question: Question<'_>, word: &str| {
        let error = evaluate(&mesh, s, u, question, &mut go).unwrap_err().to_string();
        assert!(error.contains(word) && !error.contains('\n'), "{error}");
    };
    for lambda in [-1.0, f64::NAN, f64::INFINITY] {
        refused(&s, &u, Question { lambda, ..question() }, "lambda");
    }
    refused(&s, &u, Question { lambda: 1e300, ..question() }, "range of double precision");
    let short = |array: &Array2<f64>| array.slice(ndarray::s![1.., ..]).to_owned();
    refused(&s, &short(&u), question(), "U has 95 x 3 entries, but the costs have 96 x 3");
    refused(&short(&s), &short(&u), question(), "vertices");
    let narrow = |array: &Array2<f64>| array.slice(ndarray::s![.., ..1]).to_owned();
    refused(&narrow(&s), &narrow(&u), question(), "regions");
    let mut wrong = u.clone();
    wrong[[5, 2]] = f64::NAN;
    refused(&s, &wrong, question(), "row 5, column 2");
    let mut q = Array2::zeros((2 * mesh.faces.len(), 3));
    refused(&s, &u, Question { q: Some(&short(&q)), ..question() }, "two rows for each");
    q[[7, 1]] = f64::INFINITY;
    refused(&s, &u, Question { q: Some(&q), ..question() }, "row 7, column 1");
}

/// Faces without area are left out, and a warning counts them.
#[test]
fn faces_left_out_are_reported() {
    let (mesh, s, u) = example(960);
    let mut flat = mesh.clone();
    flat.faces.extend([[0, 0, 1], [2, 3, 3]]);
    let (found, whole) = (found(&flat, &s, &u, question()), found(&mesh, &s, &u, question()));
    assert_eq!(found.warnings, ["2 faces without area were left out"]);
    assert_eq!((found.faces, whole.faces), (mesh.faces.len() + 2, mesh.faces.len()));
    assert_eq!((found.energy, found.area), (whole.energy, whole.area));
    assert!(whole.warnings.is_empty());
}

/// On faces, energy and bound are those of the solver for labels of faces; there is no dual field to offer.
#[test]
fn labels_of_faces_are_scored() {
    let mesh = shape("torus:12x8");
    let s = regions::array(&random_rows::<3>(mesh.faces.len(), &mut rng(861)), 3);
    let (relaxation, dual_steps) = (Relaxation::Separate, 1000);
    let question = Question { relaxation, dual_steps, ..question() };
    let request = Request {
        lambda: question.lambda,
        relaxation: question.relaxation,
        mass: question.mass,
        method: Method::default(),
        stop: Stop { relative_gap: Some(1e-7), ..Stop::default() },
        coarse_to_fine: false,
        keep_dual: false,
        rounding: Default::default(),
        label_gap: None,
    };
    let seeds = Seeds::default();
    let solved =
        solve_on_faces(&mesh, None, &s, &seeds, &Start::Argmin, &request, &mut go).unwrap();
    let found = evaluate_on_faces(&mesh, None, &s, &solved.u, question, &mut go).unwrap();
    let (energy, size) = (solved.summary.energy, solved.summary.energy.abs());
    assert!((found.energy - energy).abs() <= 1e-12 * size, "{} {energy}", found.energy);
    let bound = found.dual_bound;
    assert!(bound <= energy && bound >= energy - 1e-4 * size, "{bound} {energy}");
    assert_eq!((found.vertices, found.faces), (96, 192));
    assert!((found.area - mesh.area()).abs() <= 1e-14);
    // A cut of labels costs sqrt(2) times its length.
    let labels =
        Array2::from_shape_fn((192, 3), |(j, p)| f64::from(u8::from(p == usize::from(j < 77))));
    let cut = evaluate_on_faces(&mesh, None, &s, &labels, question, &mut go).unwrap();
    let dual = Dual::new(&mesh);
    let apart = |[j, k]: [u32; 2]| (j < 77) != (k < 77);
    let pairs = dual.pairs.iter().zip(&dual.weights).filter(|(pair, _)| apart(**pair));
    let length: f64 = pairs.map(|(_, w)| w).sum();
    assert!((cut.total_variation - std::f64::consts::SQRT_2 * length).abs() <= 1e-12);
    let q = Array2::zeros((2 * dual.pairs.len(), 3));
    let offered = Question { q: Some(&q), ..question };
    let message = evaluate_on_faces(&mesh, None, &s, &labels, offered, &mut go).err().unwrap();
    assert!(message.to_string().contains("leave q out"), "{message}");
    let wrong = evaluate_on_faces(&mesh, None, &s, &Array2::zeros((96, 3)), question, &mut go);
    assert!(wrong.err().unwrap().to_string().contains("F x m"));
}
