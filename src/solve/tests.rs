//! The order of the vertices in the file does not matter, summaries are consistent, and bad numbers are refused.

use std::ops::ControlFlow;

use ndarray::Axis;

use super::*;
use crate::operator::Mass;
use crate::problem::{Smoothing, SmoothingMode};
use crate::relaxation::Relaxation;
use crate::run::{Sample, Stop};
use crate::samples::{random_rows, rng, shape, shuffled, with_isolated_vertices};
use crate::solver::Method;
use crate::sweep::with_threads;

fn solved(mesh: &Mesh, s: &Array2<f64>, start: &Start) -> Solution {
    let request = Request {
        lambda: 0.02,
        relaxation: Default::default(),
        mass: Mass::Barycentric,
        method: Method::default(),
        coarse_to_fine: false,
        keep_dual: false,
        rounding: crate::rounding::Rounding::Argmax,
        label_gap: None,
        stop: Stop { iterations: Some(40), ..Stop::default() },
    };
    solve(mesh, s, start, &request, &mut |_| ControlFlow::Continue(())).unwrap()
}

fn as_it_is() -> Order {
    Order::of(&shape("grid:1x1"))
}

/// Powers of two from 1e-301 to 1e301 change the exponents of energies, bounds and q, and no bit else, in every method
/// and relaxation: no square under- or overflows on the way.
#[test]
fn costs_of_any_size_have_the_same_solution() {
    let mesh = shape("torus:12x8");
    let s = regions::array(&random_rows::<3>(mesh.vertices.len(), &mut rng(157)), 3);
    let relaxations = [Relaxation::Frobenius, Relaxation::Separate, Relaxation::Envelope];
    for (method, relaxation) in
        Method::all().into_iter().flat_map(|method| relaxations.map(|it| (method.clone(), it)))
    {
        let name = method.name();
        let request = Request {
            lambda: 0.02,
            relaxation,
            mass: Mass::Barycentric,
            method,
            coarse_to_fine: false,
            keep_dual: true,
            rounding: Default::default(),
            label_gap: None,
            stop: Stop { iterations: Some(30), ..Stop::default() },
        };
        let mut seen = Vec::new();
        let mut solved = |factor: f64| {
            let request = Request { lambda: factor * request.lambda, ..request.clone() };
            let mut observe = |sample: Option<&Sample>| {
                seen.extend(sample.map(|sample| sample.energy / factor));
                ControlFlow::Continue(())
            };
            let s = s.mapv(|x| factor * x);
            let found = solve(&mesh, &s, &Start::Argmin, &request, &mut observe).unwrap();
            (found, std::mem::take(&mut seen))
        };
        let (expected, energies) = solved(1.0);
        for exponent in [-1000, -997, -540, -300, 301, 540, 1000] {
            let factor = f64::from(exponent).exp2();
            let (found, found_energies) = solved(factor);
            assert_eq!(found.u, expected.u, "{name}, 2^{exponent}");
            assert_eq!(found.labels, expected.labels, "{name}, 2^{exponent}");
            assert_eq!(found.q.unwrap(), expected.q.as_ref().unwrap() * factor, "{name}");
            assert_eq!(found_energies, energies, "{name}, 2^{exponent}");
            let (a, b) = (found.summary, &expected.summary);
            assert_eq!(a.status, b.status, "{name}, 2^{exponent}");
            assert_eq!(a.lambda, factor * b.lambda);
            for (a, b) in [
                (a.energy, b.energy),
                (a.dual_bound, b.dual_bound),
                (a.baseline, b.baseline),
                (a.gap, b.gap),
                (a.rounded_energy, b.rounded_energy),
            ] {
                assert_eq!(a, factor * b, "{name}, 2^{exponent}");
            }
            assert_eq!(a.relative_gap, b.relative_gap);
            assert_eq!(
                a.rounding.unwrap().label_bound,
                factor * b.rounding.as_ref().unwrap().label_bound
            );
            let (a, b) = (found.trace.last().unwrap(), expected.trace.last().unwrap());
            assert_eq!(a.dual_bound, factor * b.dual_bound);
            assert_eq!(a.smoothed_energy, b.smoothed_energy.map(|energy| factor * energy));
        }
    }
}

/// The rows in the order of another numbering of the vertices.
fn moved(array: &Array2<f64>, before: &[u32]) -> Array2<f64> {
    array.select(Axis(0), &before.iter().map(|&k| k as usize).collect::<Vec<_>>())
}

#[test]
fn a_shuffled_mesh_gives_the_same_solution_in_its_own_order() {
    let tidy = with_isolated_vertices(shape("grid:60x40"));
    let s = regions::array(&random_rows::<3>(tidy.vertices.len(), &mut rng(151)), 3);
    let given = solved(&tidy, &s, &Start::Random { seed: 3 }).u;
    let (mesh, before) = shuffled(&tidy, &mut rng(152));
    assert!(Order::of(&tidy).indices().is_none() && Order::of(&mesh).indices().is_some());
    let starts = [
        (Start::Argmin, Start::Argmin),
        (Start::Uniform, Start::Uniform),
        (Start::Given(moved(&given, &before)), Start::Given(given)),
    ];
    for (start, tidy_start) in starts {
        let expected = solved(&tidy, &s, &tidy_start);
        let solution = solved(&mesh, &moved(&s, &before), &start);
        let difference = (&solution.u - &moved(&expected.u, &before)).mapv(f64::abs);
        assert!(difference.iter().all(|&x| x <= 1e-11), "{start:?}");
        for (k, &label) in solution.labels.iter().enumerate() {
            let row = solution.u.row(k);
            assert!(row.iter().all(|&u| u <= row[label as usize]));
        }
        let (a, b) = (&solution.summary, &expected.summary);
        assert!((a.energy - b.energy).abs() <= 1e-12 * b.energy);
        assert!((a.rounded_energy - b.rounded_energy).abs() <= 1e-9 * b.energy);
        assert_eq!((a.faces, a.vertices), (mesh.faces.len(), mesh.vertices.len()));
    }
}

#[test]
fn without_steps_the_start_is_returned() {
    let (mesh, _) = shuffled(&shape("torus:60x40"), &mut rng(153));
    let s = regions::array(&random_rows::<3>(mesh.vertices.len(), &mut rng(154)), 3);
    let request = Request {
        lambda: 0.02,
        relaxation: Default::default(),
        mass: Mass::Voronoi,
        method: Method::default(),
        coarse_to_fine: false,
        keep_dual: false,
        rounding: crate::rounding::Rounding::Argmax,
        label_gap: None,
        stop: Stop { iterations: Some(0), ..Stop::default() },
    };
    let start = |start: &Start| {
        solve(&mesh, &s, start, &request, &mut |_| ControlFlow::Continue(())).unwrap()
    };
    let drawn = start(&Start::Random { seed: 5 }).u;
    let again = start(&Start::Given(drawn.clone())).u;
    assert!((again - &drawn).iter().all(|x| x.abs() <= 1e-15));
    let rows = Start::Random { seed: 5 }.rows::<3>(3, &vec![Row::ZERO; drawn.nrows()], &as_it_is());
    assert_eq!(regions::array(&rows, 3), drawn);
    let cheapest = start(&Start::Argmin).labels;
    for (k, &label) in cheapest.iter().enumerate() {
        assert!(s.row(k).iter().all(|&cost| cost >= s[[k, label as usize]]));
    }
}

#[test]
fn renumbering_gives_the_same_bits_with_any_number_of_threads() {
    let (mesh, _) = shuffled(&shape("torus:60x40"), &mut rng(155));
    let s = regions::array(&random_rows::<4>(mesh.vertices.len(), &mut rng(156)), 4);
    let bits = |threads| {
        let solution = with_threads(Some(threads), || solved(&mesh, &s, &Start::Argmin)).unwrap();
        solution.u.mapv(f64::to_bits)
    };
    assert_eq!(bits(1), bits(3));
}

/// At all scales of double precision, with and without faces of zero area in front.
#[test]
fn check_mesh_and_model_mesh_refuse_the_same_meshes() {
    let mut refused = 0;
    for exponent in (-320..=308).step_by(2) {
        let mesh = shape("torus:12x8").scaled(10_f64.powi(exponent));
        let mut flat_first = mesh.clone();
        flat_first.faces.insert(0, [0, 0, 1]);
        let mut flat = mesh.clone();
        flat.faces = vec![[0, 0, 1]; 3];
        for mesh in [mesh, flat_first, flat] {
            let full = model_mesh(&mesh).map(drop).map_err(|error| error.to_string());
            let quick = check_mesh(&mesh).map_err(|error| error.to_string());
            assert_eq!(quick, full, "1e{exponent}");
            match model_mesh(&mesh) {
                Ok((model, _)) => assert!(model.area().is_normal(), "1e{exponent}"),
                Err(error) => assert_eq!(
                    error.to_string(),
                    "the mesh has no face with an area; check its coordinates and faces"
                ),
            }
            refused += usize::from(quick.is_err());
        }
    }
    // All flat meshes, and the others at extreme scales only.
    assert!((400..800).contains(&refused), "{refused}");
}

/// Every number of a summary follows from the returned U and q, in the order of the file, which differs from that of
/// the model and includes faces without area.
#[test]
fn a_summary_follows_from_u_and_q() {
    let (mut mesh, _) = shuffled(&shape("torus:40x25"), &mut rng(871));
    let [a, b, _] = mesh.faces[3];
    mesh.faces.insert(3, [a, b, b]);
    mesh.faces.insert(700, [b, b, a]);
    let mesh = with_isolated_vertices(mesh);
    let s = regions::array(&random_rows::<3>(mesh.vertices.len(), &mut rng(872)), 3);
    let stop = Stop { iterations: Some(40), ..Stop::default() };
    let request = Request {
        lambda: 0.02,
        relaxation: Default::default(),
        mass: Mass::Barycentric,
        method: Method::default(),
        coarse_to_fine: false,
        keep_dual: true,
        rounding: crate::rounding::Rounding::Argmax,
        label_gap: None,
        stop,
    };
    let mut go = |_: Option<&Sample>| ControlFlow::Continue(());
    let Solution { summary, u, q, labels, .. } =
        solve(&mesh, &s, &Start::Uniform, &request, &mut go).unwrap();
    let smoothing = Smoothing::new(SmoothingMode::Intrinsic, 1e-3).unwrap();
    let question = crate::evaluate::Question {
        lambda: 0.02,
        relaxation: Default::default(),
        mass: Mass::Barycentric,
        smoothing: Some(smoothing),
        q: q.as_ref(),
        dual_steps: 0,
    };
    let found = crate::evaluate::evaluate(&mesh, &s, &u, question, &mut go).unwrap();
    let near = |a: f64, b: f64| assert!((a - b).abs() <= 1e-11 * b.abs(), "{a} {b}");
    near(summary.energy, found.energy);
    near(summary.dual_bound, found.dual_bound);
    near(summary.baseline, found.baseline);
    near(summary.rounded_energy, found.rounded_energy);
    let Summary { energy, dual_bound, baseline, rounded_energy, .. } = summary;
    assert!(baseline < dual_bound && dual_bound < energy && energy < rounded_energy);
    near(summary.gap, energy - dual_bound);
    near(summary.relative_gap, (energy - dual_bound) / (energy - baseline));
    near(summary.rounded_relative_gap, (rounded_energy - dual_bound) / (dual_bound - baseline));
    near(found.relative_gap.unwrap(), summary.relative_gap);
    near(found.energy, found.data_term + 0.02 * found.total_variation);
    assert_eq!((summary.faces, summary.vertices), (mesh.faces.len(), mesh.vertices.len()));
    assert_eq!((found.faces, found.vertices), (summary.faces, summary.vertices));
    // E <= E_eps <= E + lambda sqrt(eps) area, and a useless q still gives B.
    let bias = 0.02 * 1e-3_f64.sqrt() * mesh.area();
    let excess = found.smoothed_energy.unwrap() - energy;
    assert!(0.0 < excess && excess <= bias, "{excess} {bias}");
    let wrong = q.as_ref().map(|q| q * -1.0);
    let question = crate::evaluate::Question { q: wrong.as_ref(), smoothing: None, ..question };
    let useless = crate::evaluate::evaluate(&mesh, &s, &u, question, &mut go).unwrap();
    assert_eq!(useless.dual_bound, useless.baseline);
    // A U with a negative entry is infeasible and has no gap, even if its rows sum to one.
    let mut outside = u.clone();
    outside[[7, 0]] += 1e-3 + outside[[7, 1]];
    outside[[7, 1]] = -1e-3;
    let infeasible = crate::evaluate::evaluate(&mesh, &s, &outside, question, &mut go).unwrap();
    assert!(!infeasible.feasible && infeasible.gap.is_none() && infeasible.relative_gap.is_none());
    assert!(infeasible.largest_row_sum_error <= 1e-12 && infeasible.smallest_entry == -1e-3);
    near(found.rounded_relative_gap, summary.rounded_relative_gap);
    let largest = |row: ndarray::ArrayView1<'_, f64>| row.iter().fold(0.0, |a, &b| f64::max(a, b));
    assert!(u.outer_iter().zip(&labels).all(|(row, &label)| row[label as usize] == largest(row)));
}

/// A bound above the energy of the labels is false, even if the energy of U is larger.
#[test]
fn labels_below_the_bound_are_a_contradiction() {
    let mesh = shape("grid:6x6");
    let f = vec![Row([0.0, 1.0, 1.0]); mesh.vertices.len()];
    let problem = Problem::new(Stencil::new(&mesh), f, 0.1);
    let u = vec![Row([0.5, 0.3, 0.2]); mesh.vertices.len()];
    let request = Request {
        lambda: 0.1,
        relaxation: Default::default(),
        mass: Mass::Barycentric,
        method: Method::default(),
        coarse_to_fine: false,
        keep_dual: false,
        rounding: crate::rounding::Rounding::Argmax,
        label_gap: None,
        stop: Stop::default(),
    };
    for (bound, status) in [(0.0, Status::Converged), (1.0, Status::Contradicted)] {
        let mut run = Run::new(&u);
        let certificate = crate::run::Certificate::Offered;
        let reached = crate::run::Reached {
            iteration: 1,
            seconds: 0.0,
            u: &u,
            dual_bound: bound,
            certificate,
            smoothed_energy: None,
        };
        run.record(&problem, &reached);
        assert!(!run.is_contradicted());
        let solution = conclude(
            (&mesh).into(),
            &problem,
            3,
            &request,
            Ended { run, status: Status::Converged, warnings: Vec::new() },
            &mut |_| ControlFlow::Continue(()),
        );
        assert_eq!(solution.summary.status, status);
    }
}

/// A bound that only rounding puts above the energy of the labels neither contradicts it nor gives the labels a gap.
#[test]
fn the_bound_is_clamped_for_labels() {
    let mesh = shape("grid:6x6");
    let mut f = vec![Row([0.0, 1.0, 1.0]); mesh.vertices.len()];
    f[0] = Row([2.0, 0.0, 1.0]);
    let problem = Problem::new(Stencil::new(&mesh), f, 0.1);
    let u = vec![Row([0.5, 0.3, 0.2]); mesh.vertices.len()];
    let request = Request {
        lambda: 0.1,
        relaxation: Default::default(),
        mass: Mass::Barycentric,
        method: Method::default(),
        coarse_to_fine: false,
        keep_dual: false,
        rounding: crate::rounding::Rounding::Argmax,
        label_gap: None,
        stop: Stop::default(),
    };
    let mut run = Run::new(&u);
    let reached = crate::run::Reached {
        iteration: 1,
        seconds: 0.0,
        u: &u,
        dual_bound: 2.0 * (1.0 + 4.0 * f64::EPSILON),
        certificate: crate::run::Certificate::Offered,
        smoothed_energy: None,
    };
    run.record(&problem, &reached);
    let summary = conclude(
        (&mesh).into(),
        &problem,
        3,
        &request,
        Ended { run, status: Status::Stalled, warnings: Vec::new() },
        &mut |_| ControlFlow::Continue(()),
    )
    .summary;
    assert_eq!(summary.rounded_energy - summary.baseline, 2.0);
    assert!(summary.dual_bound > summary.rounded_energy && summary.gap > 0.0);
    assert_eq!((summary.rounded_relative_gap, summary.status), (0.0, Status::Stalled));
}

/// A solution on a welded mesh is returned for the vertices of the file, each with the row it was merged onto.
#[test]
fn a_welded_solution_is_spread_to_all_vertices() {
    let whole = shape("torus:12x8");
    let mut mesh = whole.clone();
    // The first ten faces get corners of their own.
    for face in &mut mesh.faces[..10] {
        for corner in face {
            mesh.vertices.push(mesh.vertices[*corner as usize]);
            *corner = mesh.vertices.len() as u32 - 1;
        }
    }
    let weld = crate::mesh::Weld::exact(&mesh).unwrap();
    assert_eq!((weld.mesh.vertices.len(), weld.merged), (96, 30));
    let s = regions::array(&random_rows::<3>(96, &mut rng(157)), 3);
    let welded = solved(&weld.mesh, &s, &Start::Argmin);
    let (u, labels) = (welded.u.clone(), welded.labels.clone());
    let spread = welded.spread(&mesh, &weld);
    let Summary { vertices, faces, .. } = spread.summary;
    assert_eq!((vertices, faces), (126, mesh.faces.len()));
    assert_eq!((spread.u.nrows(), spread.labels.len()), (126, 126));
    for (v, &k) in weld.of.iter().enumerate() {
        assert_eq!(spread.u.row(v), u.row(k as usize));
        assert_eq!(spread.labels[v], labels[k as usize]);
    }
}

/// Costs, and lambda times lengths, from 1e290 on are refused, and total differences below 1e-290. Forbidden labels do
/// not count, and costs that do not differ at all are accepted.
#[test]
fn numbers_out_of_range_are_refused() {
    let mesh = shape("grid:6x6");
    let n = mesh.vertices.len();
    let check = |cost: f64, other: f64, lambda: f64| {
        let mut f = vec![Row([0.0, 1.0, other]); n];
        f.iter_mut().for_each(|f| f.0[1] *= cost);
        check_range(&Problem::new(Stencil::new(&mesh), f, lambda))
            .map_err(|error| error.to_string())
    };
    assert_eq!(check(1.0, FORBIDDEN_COST, 0.1), Ok(()));
    assert_eq!(check(1e289, FORBIDDEN_COST, 0.1), Ok(()));
    assert!(
        check(2e290, FORBIDDEN_COST, 0.1)
            .unwrap_err()
            .contains("scale the costs, lambda or the mesh down")
    );
    assert_eq!(check(1.0, 0.0, 1e287), Ok(()));
    assert!(
        check(1.0, 0.0, 1e290).unwrap_err().contains("scale the costs, lambda or the mesh down")
    );
    // 49 vertices.
    assert_eq!(check(3e-292, 0.0, 0.1), Ok(()));
    assert!(check(1e-292, 0.0, 0.1).unwrap_err().contains("scale the costs or the mesh up"));
    assert_eq!(check(0.0, 0.0, 0.1), Ok(()));
}

/// NaN and infinities are found at their position in any memory layout.
#[test]
fn invalid_numbers_are_found_in_any_memory_layout() {
    let mut rows = Array2::<f64>::zeros((5, 3));
    let mut columns = Array2::<f64>::zeros((3, 5)).reversed_axes();
    assert!(rows.as_slice().is_some() && columns.as_slice().is_none());
    for array in [&mut rows, &mut columns] {
        assert!(check_finite("numbers", array).is_ok());
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            array[[3, 1]] = x;
            let message = check_finite("numbers", array).unwrap_err().to_string();
            assert!(message.contains("the numbers have") && message.contains("row 3, column 1"));
        }
    }
}
