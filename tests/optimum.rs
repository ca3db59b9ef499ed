//! Compares the exact solvers with the exact optimum, which an interior-point method computes from a second-order cone
//! program whose matrices are assembled here, from the vertices alone:
//!
//!     min sum_k <u_k, f_k> + sum_j t_j    u_k in the simplex,  lambda |(K U)_j| <= t_j
//!
//! In the relaxation `separate` there is a cone for each face and region. In `envelope` (K U)_j is divided into flows
//! between regions, sqrt(2) lambda (K U)_jp = sum_b w_pb with w_pb = -w_bp, whose lengths are added up; with a metric
//! on the labels, they count d(p, b) times.

use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};
use std::ops::ControlFlow;

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SecondOrderConeT,
    SolverStatus, SupportedConeT, ZeroConeT,
};
use meshseg::mesh::{Mesh, Shape};
use meshseg::names::Named;
use meshseg::operator::Mass;
use meshseg::relaxation::{LabelMetric, Relaxation};
use meshseg::run::{Status, Stop};
use meshseg::solve::{Request, Solution, solve};
use meshseg::solver::{Method, Options};
use meshseg::start::Start;
use nalgebra::Vector3;
use ndarray::Array2;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const GAP: f64 = 1e-5;

const EXACT: [&str; 2] = ["chambolle-pock", "douglas-rachford"];

/// A lower and an upper bound of E* for pointwise costs s with barycentric masses: the program's dual and
/// primal solutions, evaluated here. The program is stated for area 1 and costs up to 1,
/// which suits its tolerances, and the result scaled back: E = area cost E'.
fn exact_optimum(mesh: &Mesh, s: &Array2<f64>, lambda: f64, relaxation: Relaxation) -> [f64; 2] {
    let (n, m) = s.dim();
    let faces: Vec<Face> = (0..mesh.faces.len()).map(|j| Face::new(mesh, j)).collect();
    let area: f64 = faces.iter().map(|face| face.area).sum();
    let cost = s.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let pairs: Vec<(usize, usize)> = (0..m).flat_map(|a| (0..a).map(move |b| (a, b))).collect();
    let has_flows = matches!(relaxation, Relaxation::Envelope | Relaxation::Metric(_));
    // Cones of a face, their dimension, and the factor of (K U)_j in them.
    let (cones_of_face, dimension, factor) = match relaxation {
        Relaxation::Frobenius => (1, 1 + 2 * m, 1.0),
        Relaxation::Separate => (m, 3, FRAC_1_SQRT_2),
        Relaxation::Envelope | Relaxation::Metric(_) => (pairs.len(), 3, SQRT_2),
    };
    let cone_count = faces.len() * cones_of_face;
    let mut objective = vec![0.0; n * m + cone_count];
    for face in &faces {
        for k in face.corners {
            for p in 0..m {
                objective[k * m + p] += face.area / 3.0 * s[[k, p]] / (area * cost);
            }
        }
    }
    objective[n * m..].fill(1.0);
    let d = |&(a, b): &(usize, usize)| relaxation.label_metric().distance(a, b);
    if has_flows {
        objective[n * m..]
            .chunks_mut(pairs.len())
            .for_each(|t| t.iter_mut().zip(&pairs).for_each(|(t, pair)| *t = d(pair)));
    }
    let weight = factor * lambda / (cost * area.sqrt());
    if has_flows {
        objective.resize(n * m + 3 * cone_count, 0.0);
    }

    // A x + s = b with s in the cones: rows sum to 1; u >= 0; (t_j, lambda (K U)_j) in second-order cones.
    let (mut rows, mut columns, mut values) = (Vec::new(), Vec::new(), Vec::new());
    let mut entry = |row: usize, column: usize, value: f64| {
        rows.push(row);
        columns.push(column);
        values.push(value);
    };
    for k in 0..n {
        for p in 0..m {
            entry(k, k * m + p, 1.0);
            entry(n + k * m + p, k * m + p, -1.0);
        }
    }
    let mut row = n + n * m;
    for (j, face) in faces.iter().enumerate() {
        for p in 0..m {
            if relaxation == Relaxation::Separate || relaxation == Relaxation::Frobenius && p == 0 {
                entry(row, n * m + j * cones_of_face + p, -1.0);
                row += 1;
            }
            for axis in 0..2 {
                for (k, column) in face.corners.into_iter().zip(face.columns) {
                    entry(row, k * m + p, -weight * column[axis] / area.sqrt());
                }
                if has_flows {
                    for (i, &(a, b)) in pairs.iter().enumerate() {
                        let flow = n * m + cone_count + 2 * (j * pairs.len() + i) + axis;
                        if a == p || b == p {
                            entry(row, flow, if a == p { 1.0 } else { -1.0 });
                        }
                    }
                }
                row += 1;
            }
        }
    }
    let mut cones: Vec<SupportedConeT<f64>> = vec![ZeroConeT(n), NonnegativeConeT(n * m)];
    if has_flows {
        cones.push(ZeroConeT(2 * m * faces.len()));
        for i in 0..cone_count {
            entry(row, n * m + i, -1.0);
            for axis in 0..2 {
                entry(row + 1 + axis, n * m + cone_count + 2 * i + axis, -1.0);
            }
            row += 3;
        }
    }
    cones.extend((0..cone_count).map(|_| SecondOrderConeT(dimension)));
    let mut b = vec![0.0; row];
    b[..n].fill(1.0);
    let unknowns = objective.len();
    let a = CscMatrix::new_from_triplets(row, unknowns, rows, columns, values);
    let settings = DefaultSettingsBuilder::default()
        .tol_gap_abs(1e-11)
        .tol_gap_rel(1e-11)
        .tol_feas(1e-11)
        .verbose(false)
        .build()
        .unwrap();
    let quadratic = CscMatrix::zeros((unknowns, unknowns));
    let mut solver = DefaultSolver::new(&quadratic, &objective, &a, &b, &cones, settings).unwrap();
    solver.solve();
    let solution = &solver.solution;
    assert!(matches!(solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved));

    // Its solution, made exactly feasible: rows in the simplex, and q_j = -lambda z_j in the set. The flows of `envelope` are
    // not made so: their energy is that of the program, up to its tolerance.
    let mut u = Array2::from_shape_vec((n, m), solution.x[..n * m].to_vec()).unwrap();
    for mut row in u.outer_iter_mut() {
        row.mapv_inplace(|x| x.max(0.0));
        let sum = row.sum();
        row /= sum;
    }
    let mut g = Array2::from_shape_fn((n, m), |(k, p)| objective[k * m + p]);
    let mut high = (&u * &g).sum();
    let rows_of_face = match relaxation {
        Relaxation::Frobenius => 1 + 2 * m,
        Relaxation::Separate => 3 * m,
        Relaxation::Envelope | Relaxation::Metric(_) => 2 * m,
    };
    for (face, z) in faces.iter().zip(solution.z[n + n * m..].chunks(rows_of_face)) {
        // z_jp and the lengths of those that are together in a cone.
        let z: Vec<[f64; 2]> = match relaxation {
            Relaxation::Frobenius => z[1..].chunks(2).map(|z| [z[0], z[1]]).collect(),
            Relaxation::Separate => z.chunks(3).map(|z| [z[1], z[2]]).collect(),
            Relaxation::Envelope | Relaxation::Metric(_) => {
                z.chunks(2).map(|z| [z[0], z[1]]).collect()
            }
        };
        let length = |[x, y]: [f64; 2]| x.hypot(y);
        let all = z.iter().map(|&z| length(z).powi(2)).sum::<f64>().sqrt();
        let difference =
            |pair: &(usize, usize)| length([0, 1].map(|i| z[pair.0][i] - z[pair.1][i])) / d(pair);
        let diameter = pairs.iter().map(difference).fold(0.0, f64::max);
        let mut squares = vec![0.0; m];
        for (p, &z) in z.iter().enumerate() {
            let norm = match relaxation {
                Relaxation::Frobenius => all,
                Relaxation::Separate => length(z),
                Relaxation::Envelope | Relaxation::Metric(_) => diameter,
            };
            let scale = weight / norm.max(1.0) / area.sqrt();
            for axis in 0..2 {
                let ku: f64 = (0..3).map(|i| face.columns[i][axis] * u[[face.corners[i], p]]).sum();
                squares[p] += ku * ku;
                for (k, column) in face.corners.into_iter().zip(face.columns) {
                    g[[k, p]] -= scale * z[axis] * column[axis];
                }
            }
        }
        let variation = match relaxation {
            Relaxation::Frobenius => squares.iter().sum::<f64>().sqrt(),
            Relaxation::Separate => squares.iter().map(|x| x.sqrt()).sum(),
            Relaxation::Envelope | Relaxation::Metric(_) => 0.0,
        };
        high += weight / area.sqrt() * variation;
    }
    if has_flows {
        high = solution.obj_val * (1.0 + 1e-9 * solution.obj_val.signum());
    }
    let low: f64 = g.outer_iter().map(|g| g.fold(f64::INFINITY, |a, &b| a.min(b))).sum();
    assert!(high - low <= 1e-6 * low.abs(), "{:?}: {low} to {high}", solution.status);
    [low * area * cost, high * area * cost]
}

/// One face mapped to the plane by Gram-Schmidt, with its third corner at the origin.
struct Face {
    corners: [usize; 3],
    area: f64,
    /// A grad phi_k of the three corners.
    columns: [[f64; 2]; 3],
}

impl Face {
    fn new(mesh: &Mesh, j: usize) -> Self {
        let x = mesh.faces[j].map(|k| mesh.vertices[k as usize]);
        let (a, b): (Vector3<f64>, Vector3<f64>) = (x[0] - x[2], x[1] - x[2]);
        let length = a.norm();
        let along = a.dot(&b) / length;
        let height = (b - a * (along / length)).norm();
        // <A grad, (length, 0)> = A u_0 and <A grad, (along, height)> = A u_1, for u_2 = 0.
        let first = [0.5 * height, -0.5 * along];
        let second = [0.0, 0.5 * length];
        let third = [-first[0], -first[1] - second[1]];
        Face {
            corners: mesh.faces[j].map(|k| k as usize),
            area: 0.5 * length * height,
            columns: [first, second, third],
        }
    }
}

fn certified(
    solver: &str,
    mesh: &Mesh,
    s: &Array2<f64>,
    lambda: f64,
    relaxation: Relaxation,
) -> Solution {
    let stop = Stop { relative_gap: Some(GAP), iterations: Some(20_000), ..Stop::default() };
    let request = Request {
        lambda,
        relaxation,
        mass: Mass::Barycentric,
        method: Method::named(solver).unwrap(),
        stop,
        coarse_to_fine: false,
        keep_dual: false,
        rounding: Default::default(),
        label_gap: None,
    };
    solve(mesh, s, &Start::Uniform, &request, &mut |_| ControlFlow::Continue(())).unwrap()
}

/// Solves for every lambda, given in units of cost times the square root of the area.
fn check(name: &str, mesh: &Mesh, s: &Array2<f64>, lambdas: &[f64]) {
    check_in(Relaxation::Frobenius, name, mesh, s, lambdas);
}

fn check_in(relaxation: Relaxation, name: &str, mesh: &Mesh, s: &Array2<f64>, lambdas: &[f64]) {
    for relative in lambdas {
        let lambda = relative * mesh.area().sqrt();
        let [low, high] = exact_optimum(mesh, s, lambda, relaxation);
        for solver in EXACT {
            let solution = certified(solver, mesh, s, lambda, relaxation);
            let summary = &solution.summary;
            println!(
                "{name:24} m = {}  F = {:4}  lambda = {relative:<6} {:6} of {solver:16}, E* = {high:+.9e}",
                s.ncols(),
                mesh.faces.len(),
                summary.iterations
            );
            // Rounding errors of sums over the mesh.
            let slack = 1e-12 * high.abs();
            assert_eq!(summary.status, Status::Converged, "{solver}, {name}, lambda {relative}");
            assert!(summary.dual_bound <= high + slack, "{} {high}", summary.dual_bound);
            assert!(summary.energy >= low - slack, "{} {low}", summary.energy);
            assert!(summary.energy - low <= 3e-5 * low.abs(), "{} {low}", summary.energy);
            assert!(summary.rounded_energy >= low - slack);
            for row in solution.u.outer_iter() {
                assert!((row.sum() - 1.0).abs() <= 1e-12 && row.iter().all(|&u| u >= 0.0));
            }
        }
    }
}

fn shape(text: &str) -> Mesh {
    text.parse::<Shape>().unwrap().mesh()
}

/// Costs drawn from `low` to 1.
fn noise(mesh: &Mesh, m: usize, low: f64, seed: u64) -> Array2<f64> {
    let mut rng = Pcg64::seed_from_u64(seed);
    Array2::from_shape_simple_fn((mesh.vertices.len(), m), || rng.random_range(low..1.0))
}

/// Waves over the mesh, different for each region.
fn smooth(mesh: &Mesh, m: usize) -> Array2<f64> {
    let size = mesh.area().sqrt();
    Array2::from_shape_fn((mesh.vertices.len(), m), |(k, p)| {
        let x = mesh.vertices[k] / size;
        let p = p as f64;
        0.6 + 0.4 * (3.0 * x.x + 2.0 * p).sin() * (4.0 * x.y + 2.0 * x.z - p).cos()
    })
}

const LAMBDAS: [f64; 5] = [0.0, 0.003, 0.03, 0.3, 100.0];

#[test]
fn closed_surfaces() {
    let sphere = shape("sphere:2");
    check("sphere, noise", &sphere, &noise(&sphere, 3, 0.0, 1), &LAMBDAS);
    let torus = shape("torus:24x12");
    check("torus, smooth", &torus, &smooth(&torus, 5), &[0.01, 0.1]);
    let fine = shape("torus:40x25");
    check("torus, noise", &fine, &noise(&fine, 2, 0.0, 2), &[0.01]);
}

#[test]
fn open_surfaces() {
    let grid = shape("grid:16x12");
    check("grid, smooth", &grid, &smooth(&grid, 4), &LAMBDAS);
    check("grid, noise", &grid, &noise(&grid, 7, 0.0, 3), &[0.01, 0.1]);
}

/// The other relaxations are tighter, and with two regions the same.
#[test]
fn all_relaxations() {
    let (sphere, grid) = (shape("sphere:1"), shape("grid:7x6"));
    for relaxation in [Relaxation::Separate, Relaxation::Envelope] {
        let name = relaxation.name();
        let lambdas = [0.003, 0.03, 0.3];
        check_in(relaxation, name, &sphere, &noise(&sphere, 3, 0.0, 11), &lambdas);
        check_in(relaxation, name, &grid, &noise(&grid, 6, 0.0, 12), &lambdas);
        check_in(relaxation, name, &grid, &smooth(&grid, 5), &[0.01, 0.1]);
        let two = noise(&grid, 2, 0.0, 13);
        check_in(relaxation, name, &grid, &two, &[0.03]);
        let lambda = 0.03 * grid.area().sqrt();
        let [low, high] = exact_optimum(&grid, &two, lambda, Relaxation::Frobenius);
        let [same, other] = exact_optimum(&grid, &two, lambda, relaxation);
        assert!((low - same).abs() <= 1e-6 * low.abs() && (high - other).abs() <= 1e-6 * low.abs());
    }
    let s = noise(&grid, 6, 0.0, 12);
    let optimum = |relaxation| exact_optimum(&grid, &s, 0.03 * grid.area().sqrt(), relaxation)[0];
    let [frobenius, separate, envelope] =
        [Relaxation::Frobenius, Relaxation::Separate, Relaxation::Envelope].map(optimum);
    assert!(separate > frobenius * (1.0 + 1e-4) && envelope > separate * (1.0 + 1e-5));
}

/// A metric on four labels that no labels in the plane have, one on a line, one with a label between all others, and
/// that of Potts by its numbers.
#[test]
fn metrics_on_labels() {
    let (sphere, grid) = (shape("sphere:1"), shape("grid:7x6"));
    let metric = |m: usize, d: &dyn Fn(usize, usize) -> f64| {
        let d = |(a, b): (usize, usize)| if a == b { 0.0 } else { d(a.min(b), a.max(b)) };
        Relaxation::Metric(LabelMetric::new(&Array2::from_shape_fn((m, m), d)).unwrap())
    };
    let uneven =
        metric(4, &|a, b| [[0.0, 1.0, 2.0, 0.7], [0.0, 0.0, 1.5, 1.2], [0.0, 0.0, 0.0, 2.3]][a][b]);
    check_in(uneven, "four labels", &sphere, &noise(&sphere, 4, 0.0, 14), &[0.003, 0.03, 0.3]);
    check_in(uneven, "four labels, smooth", &grid, &smooth(&grid, 4), &[0.01, 0.1]);
    let line = metric(5, &|a, b| (b - a) as f64);
    check_in(line, "a line", &grid, &noise(&grid, 5, 0.0, 15), &[0.003, 0.03, 0.1]);
    let star = metric(5, &|a, _| if a == 0 { 0.5 } else { 1.0 });
    check_in(star, "a star", &grid, &noise(&grid, 5, 0.0, 16), &[0.003, 0.03, 0.1]);
    check_in(star, "a star, smooth", &sphere, &smooth(&sphere, 5), &[0.01, 0.1]);
    let s = noise(&grid, 4, 0.0, 17);
    let lambda = 0.03 * grid.area().sqrt();
    let summaries = [metric(4, &|_, _| 1.0), Relaxation::Envelope]
        .map(|relaxation| certified("chambolle-pock", &grid, &s, lambda, relaxation).summary);
    assert!((summaries[0].energy - summaries[1].energy).abs() <= 1e-9 * summaries[1].energy);
    assert!(
        (summaries[0].dual_bound - summaries[1].dual_bound).abs() <= 1e-9 * summaries[1].energy
    );
}

#[test]
fn several_components() {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for (i, size) in [1.0, 0.1, 0.5, 0.02].into_iter().enumerate() {
        let part = shape("sphere:1").scaled(size);
        let shift = vertices.len() as u32;
        vertices.extend(part.vertices.iter().map(|x| x + Vector3::x() * (3.0 * i as f64)));
        faces.extend(part.faces.iter().map(|face| face.map(|k| k + shift)));
    }
    let mesh = Mesh::new(vertices, faces);
    check("components, noise", &mesh, &noise(&mesh, 3, 0.0, 4), &LAMBDAS);
}

/// A grid whose lines form pairs at a distance of 1e-4 of a cell, in both directions.
#[test]
fn needles() {
    let mut mesh = shape("grid:14x14");
    for x in mesh.vertices.iter_mut().flat_map(|x| x.coords.as_mut_slice()[..2].iter_mut()) {
        let line = (*x * 14.0).round();
        *x = if line % 2.0 == 0.0 { line / 14.0 } else { (line - 1.0 + 1e-4) / 14.0 };
    }
    check("needles, noise", &mesh, &noise(&mesh, 3, 0.0, 5), &[0.0, 0.003, 0.03, 0.3]);
    check("needles, smooth", &mesh, &smooth(&mesh, 2), &[0.01, 0.1, 100.0]);
}

#[test]
fn any_unit_of_length() {
    for c in [1e-4, 1e4] {
        let mesh = shape("sphere:2").scaled(c);
        check(&format!("sphere times {c:e}"), &mesh, &smooth(&mesh, 3), &LAMBDAS);
    }
}

#[test]
fn negative_costs_and_ties() {
    let mesh = shape("sphere:2");
    check("negative, noise", &mesh, &(noise(&mesh, 6, 0.0, 6) - 2.0), &[0.003, 0.1, 100.0]);
    let mut ties = noise(&mesh, 4, 0.2, 7);
    for mut row in ties.outer_iter_mut() {
        row[2] = row[0];
        row[3] = row[1];
    }
    check("ties", &mesh, &ties, &LAMBDAS);
    let equal = Array2::from_elem((mesh.vertices.len(), 3), 0.5);
    check("all equal", &mesh, &equal, &[0.0, 0.1]);
}

/// So flat that step lengths along and across differ by 1000; every lambda is so large that one region takes all.
#[test]
fn flattened() {
    let mut mesh = shape("torus:60x40");
    mesh.vertices.iter_mut().for_each(|x| x.z *= 1e-3);
    let half = Array2::from_shape_fn((mesh.vertices.len(), 2), |(k, p)| {
        f64::from((mesh.vertices[k].x > 0.1) == (p == 0))
    });
    check("flattened", &mesh, &half, &[1.0, 100.0]);
}

/// Regions that are too expensive change nothing, whatever their number and indices.
#[test]
fn every_number_of_regions() {
    let mesh = shape("torus:12x8");
    let three = noise(&mesh, 3, 0.0, 8);
    let lambda = 0.03 * mesh.area().sqrt();
    let [low, high] = exact_optimum(&mesh, &three, lambda, Relaxation::Frobenius);
    for m in 2..=64 {
        let s = Array2::from_shape_fn((mesh.vertices.len(), m), |(k, p)| match p * 3 / m {
            region if p == (region * m).div_ceil(3) => three[[k, region]],
            _ => 5.0,
        });
        for solver in EXACT {
            let summary = certified(solver, &mesh, &s, lambda, Relaxation::Frobenius).summary;
            assert_eq!(summary.status, Status::Converged, "{solver}, {m} regions");
            assert_eq!(summary.regions, m);
            if m > 2 {
                assert!(
                    summary.dual_bound <= high && summary.energy >= low,
                    "{solver}, {m} regions"
                );
                assert!(summary.energy - low <= 3e-5 * low, "{solver}, {m} regions");
            }
        }
    }
}

/// Every compiled row length is tested, in both precisions of the engine.
#[test]
fn the_engine_makes_the_steps_of_the_rows_for_every_number_of_regions() {
    let mesh = shape("torus:20x12");
    let lambda = 0.03 * mesh.area().sqrt();
    for m in 2..=64 {
        let s = noise(&mesh, m, 0.3, 9);
        let run = |options: &[&str]| {
            let request = Request {
                lambda,
                relaxation: Default::default(),
                mass: Mass::Barycentric,
                method: Method::parse("chambolle-pock", &Options::parse(options).unwrap()).unwrap(),
                stop: Stop { iterations: Some(50), ..Stop::default() },
                coarse_to_fine: false,
                keep_dual: false,
                rounding: Default::default(),
                label_gap: None,
            };
            solve(&mesh, &s, &Start::Uniform, &request, &mut |_| ControlFlow::Continue(()))
                .unwrap()
                .trace
        };
        let rows = run(&["engine=rows"]);
        for (precision, tolerance) in [("f64", 1e-10), ("f32", 1e-5)] {
            let fused = run(&["engine=fused", &format!("precision={precision}")]);
            assert_eq!(fused.len(), rows.len());
            for (a, b) in fused.iter().zip(&rows) {
                let difference =
                    f64::max((a.energy - b.energy).abs(), (a.dual_bound - b.dual_bound).abs());
                assert!(
                    difference <= tolerance * b.energy,
                    "{m} regions, {precision}, step {}: {difference:e}",
                    b.iteration
                );
            }
        }
    }
}
