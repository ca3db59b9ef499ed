//! Meshes, random fields and problems of known optimum that the tests of several modules share.

use std::f64::consts::SQRT_2;

use nalgebra::{DMatrix, Point3, Rotation2, Rotation3, Vector2, Vector3};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use strum::IntoEnumIterator;

use crate::data::{Data, DataModel};
use crate::field::{Row, Tangent};
use crate::mesh::{Mesh, Shape};
use crate::operator::mass::Quadrature;
use crate::operator::{Adjoint, Mass, Operator, Stencil};
use crate::problem::{FORBIDDEN_COST, Problem};
use crate::relaxation::{DualSet, Relaxation, Separate, with_set};

pub fn rng(seed: u64) -> Pcg64 {
    Pcg64::seed_from_u64(seed)
}

/// A generated surface from its text form, such as `sphere:2`.
pub fn shape(text: &str) -> Mesh {
    text.parse::<Shape>().unwrap().mesh()
}

/// The disjoint union of several meshes.
pub fn disjoint(parts: impl IntoIterator<Item = Mesh>) -> Mesh {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for part in parts {
        let shift = vertices.len() as u32;
        vertices.extend(part.vertices);
        faces.extend(part.faces.into_iter().map(|face| face.map(|k| k + shift)));
    }
    Mesh::new(vertices, faces)
}

/// The mesh with the orientation of every third face reversed.
pub fn flipped(mut mesh: Mesh) -> Mesh {
    mesh.faces.iter_mut().step_by(3).for_each(|face| face.swap(1, 2));
    mesh
}

/// Faces around one edge, and two fans that meet in one vertex.
pub fn non_manifold() -> Mesh {
    let mut rng = rng(17);
    let points = (0..12).map(|_| Point3::from(random_vector(&mut rng))).collect();
    let book = [[0, 1, 2], [0, 1, 3], [1, 0, 4], [0, 1, 5]];
    let fans = [[2, 6, 7], [2, 7, 8], [2, 9, 10], [2, 10, 11]];
    Mesh::new(points, book.into_iter().chain(fans).collect())
}

/// The same mesh with vertices and faces in random order, and the previous index of each vertex.
pub fn shuffled(mesh: &Mesh, rng: &mut Pcg64) -> (Mesh, Vec<u32>) {
    let mut previous: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    previous.shuffle(rng);
    let mut current = vec![0; previous.len()];
    previous.iter().enumerate().for_each(|(v, &k)| current[k as usize] = v as u32);
    let vertices = previous.iter().map(|&k| mesh.vertices[k as usize]).collect();
    let mut faces: Vec<[u32; 3]> =
        mesh.faces.iter().map(|face| face.map(|k| current[k as usize])).collect();
    faces.shuffle(rng);
    (Mesh::new(vertices, faces), previous)
}

/// A bumpy grid whose faces are each divided at a point close to an edge, at `aspect` times the height of the face.
pub fn needles(cells: u32, aspect: f64) -> Mesh {
    let mut mesh = bumpy(cells);
    for [a, b, c] in std::mem::take(&mut mesh.faces) {
        let [x, y, z] = [a, b, c].map(|k| mesh.vertices[k as usize].coords);
        let k = mesh.vertices.len() as u32;
        mesh.vertices.push(Point3::from(0.5 * (1.0 - aspect) * (x + y) + aspect * z));
        mesh.faces.extend([[a, b, k], [b, c, k], [c, a, k]]);
    }
    mesh
}

/// A square grid, its vertices displaced at random in space.
pub fn bumpy(cells: u32) -> Mesh {
    let mut mesh = shape(&format!("grid:{cells}x{cells}"));
    let mut rng = rng(u64::from(cells));
    for x in &mut mesh.vertices {
        *x += random_vector(&mut rng) * (0.3 / f64::from(cells));
    }
    mesh
}

/// Vertices and faces drawn at random: self-intersecting, non-manifold, with isolated vertices.
pub fn soup(vertices: u32, faces: usize, seed: u64) -> Mesh {
    let mut rng = rng(seed);
    let points = (0..vertices).map(|_| Point3::from(random_vector(&mut rng))).collect();
    let mut corner = || rng.random_range(0..vertices);
    let triples = (0..faces).map(|_| [corner(), corner(), corner()]).collect();
    Mesh::new(points, triples).without_degenerate_faces().0.into_owned()
}

/// The same mesh with a first and a last vertex, far away, that no face refers to.
pub fn with_isolated_vertices(mut mesh: Mesh) -> Mesh {
    mesh.vertices.insert(0, Point3::new(9.0, 9.0, 9.0));
    mesh.faces.iter_mut().flatten().for_each(|k| *k += 1);
    mesh.vertices.push(Point3::new(-9.0, 0.0, 1.0));
    mesh
}

/// Named meshes of all kinds: closed, open, disconnected, non-manifold, degenerate, tiny and huge.
pub fn zoo() -> Vec<(&'static str, Mesh)> {
    let sphere = shape("sphere:2");
    let mut moved = shape("torus:9x7");
    moved.vertices.iter_mut().for_each(|x| *x += Vector3::new(5.0, 0.0, 0.0));
    vec![
        ("sphere", sphere.clone()),
        ("torus", shape("torus:16x10")),
        ("grid", shape("grid:9x7")),
        ("bumpy", bumpy(9)),
        ("components", disjoint([sphere.clone(), moved, shape("grid:3x3").scaled(0.1)])),
        ("flipped", flipped(sphere.clone())),
        ("non-manifold", non_manifold()),
        ("needles", needles(5, 1e-6)),
        ("small", bumpy(8).scaled(1e-4)),
        ("large", sphere.clone().scaled(1e4)),
        ("soup", soup(40, 120, 5)),
        ("isolated", with_isolated_vertices(sphere)),
    ]
}

/// Entries from -1 to 1.
pub fn random_vector(rng: &mut Pcg64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0))
}

pub fn random_rotation(rng: &mut Pcg64) -> Rotation3<f64> {
    Rotation3::new(3.0 * random_vector(rng))
}

/// Entries from -1 to 1.
pub fn random_rows<const M: usize>(n: usize, rng: &mut Pcg64) -> Vec<Row<M>> {
    (0..n).map(|_| Row::from_fn(|_| rng.random_range(-1.0..1.0))).collect()
}

/// Entries from -1 to 1.
pub fn random_tangents<const M: usize>(n: usize, rng: &mut Pcg64) -> Vec<Tangent<M>> {
    let rows = random_rows::<M>(2 * n, rng);
    rows.chunks(2).map(|pair| Tangent([pair[0], pair[1]])).collect()
}

/// Tangents in the ball |q_j| <= lambda, many of them on its boundary.
pub fn random_dual<const M: usize>(n: usize, lambda: f64, rng: &mut Pcg64) -> Vec<Tangent<M>> {
    random_dual_in(Relaxation::Frobenius, n, lambda, rng)
}

/// The same for the set of a relaxation.
pub fn random_dual_in<const M: usize>(
    relaxation: Relaxation,
    n: usize,
    lambda: f64,
    rng: &mut Pcg64,
) -> Vec<Tangent<M>> {
    let tangents = random_tangents(n, rng).into_iter();
    with_set!(relaxation, set => tangents.map(|q| set.project(q * lambda, lambda)).collect())
}

/// Entries from 0 to 1.
pub fn random_data(n: usize, dimension: usize, seed: u64) -> Data {
    let mut rng = rng(seed);
    Data::new(dimension, (0..n * dimension).map(|_| rng.random()).collect()).unwrap()
}

/// Data, labels, meshes of several scales and quadratures, to fit the parameters of regions to.
pub fn to_fit(seed: u64) -> impl Iterator<Item = (Mesh, Data, Vec<Row<3>>, Mass)> {
    let meshes = [shape("sphere:2"), bumpy(6).scaled(1e-3), needles(4, 1e-4)];
    meshes.into_iter().flat_map(move |mesh| {
        let n = mesh.vertices.len();
        let (data, u) = (random_data(n, 2, seed), random_labels(n, 3, &mut rng(seed + 1)));
        Mass::iter().map(move |mass| (mesh.clone(), data.clone(), u.clone(), mass))
    })
}

/// sum <u, M s>, which the parameters are fitted to.
pub fn fitted_energy<D: DataModel>(
    model: &D,
    quadrature: &Quadrature<'_>,
    u: &[Row<3>],
    mu: &[D::Parameters],
) -> f64 {
    let f = quadrature.integrate(&model.costs::<3>(mu));
    u.iter().zip(&f).map(|(u, &f)| u.dot(f)).sum()
}

/// Rows in the simplex of the first m regions: in its interior, on its edges and at its vertices.
pub fn random_labels<const M: usize>(n: usize, m: usize, rng: &mut Pcg64) -> Vec<Row<M>> {
    (0..n)
        .map(|_| match rng.random_range(0..3) {
            0 => Row::one_hot(rng.random_range(0..m)),
            1 => {
                let share = rng.random::<f64>();
                let (a, b) = (rng.random_range(0..m), rng.random_range(0..m));
                Row::one_hot(a) * share + Row::one_hot(b) * (1.0 - share)
            }
            _ => {
                let row = Row::from_fn(|p| if p < m { rng.random::<f64>() } else { 0.0 });
                row * (1.0 / row.0.iter().sum::<f64>())
            }
        })
        .collect()
}

/// A problem with random integrated costs, each at most a vertex's share of the area in absolute value.
pub fn random_problem<const M: usize>(mesh: &Mesh, lambda: f64, seed: u64) -> Problem<Stencil, M> {
    let share = mesh.area() / mesh.vertices.len() as f64;
    let f = random_rows(mesh.vertices.len(), &mut rng(seed));
    let f = f.into_iter().map(|f: Row<M>| f * share).collect();
    Problem::new(Stencil::new(mesh), f, lambda)
}

/// A problem of known optimum, by construction.
pub struct Known<const M: usize> {
    pub problem: Problem<Stencil, M>,
    /// A minimizer.
    pub u: Vec<Row<M>>,
    /// A maximizer of the dual.
    pub q: Vec<Tangent<M>>,
    /// E* - B.
    pub energy: f64,
}

/// For labels u, here the Voronoi cells of m vertices, take q_j = lambda (K u)_j / |(K u)_j| where that is defined and
/// any q_j of the ball elsewhere. Then f = -K^T q + theta + nu with nu >= 0 and <nu, u> = 0 makes u a minimizer with
/// energy sum theta. Theta and nu are of the size of `cost` times a vertex's share of the area.
pub fn known_optimum<const M: usize>(
    mesh: &Mesh,
    m: usize,
    lambda: f64,
    cost: f64,
    seed: u64,
) -> Known<M> {
    known_optimum_in(Relaxation::Frobenius, mesh, m, lambda, cost, seed)
}

/// The same in another relaxation, with q_j that attains max <q_j, (K u)_j> in its set.
pub fn known_optimum_in<const M: usize>(
    relaxation: Relaxation,
    mesh: &Mesh,
    m: usize,
    lambda: f64,
    cost: f64,
    seed: u64,
) -> Known<M> {
    let mut rng = rng(seed);
    let n = mesh.vertices.len();
    let k = Stencil::new(mesh);
    let seeds: Vec<usize> = (0..m).map(|_| rng.random_range(0..n)).collect();
    let u: Vec<Row<M>> = (mesh.vertices.iter())
        .map(|x| {
            let distance = |p: usize| (x - mesh.vertices[seeds[p]]).norm_squared();
            let nearest = (0..m).min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
            Row::one_hot(nearest.unwrap())
        })
        .collect();
    let q: Vec<Tangent<M>> = (0..mesh.faces.len())
        .map(|j| {
            let ku = k.at(&u, j);
            let any = random_tangents::<M>(1, &mut rng)[0] * (0.1 * lambda);
            let active = any.0.map(|row| Row::from_fn(|p| if p < m { row.0[p] } else { 0.0 }));
            let (norm, any) = (ku.norm(), Tangent(active));
            match relaxation {
                Relaxation::Frobenius if norm > 0.0 => ku * (lambda / norm),
                Relaxation::Envelope if norm > 0.0 => farthest_apart(ku, SQRT_2 * lambda),
                Relaxation::Separate => {
                    let is_active = |p: usize| f64::hypot(ku.0[0].0[p], ku.0[1].0[p]) > 0.0;
                    // Far outside the set in the direction of (K u)_jp.
                    let far = Separate.project(ku * (1e20 * lambda / norm.max(1e-300)), lambda);
                    let choose = |axis: usize| {
                        move |p: usize| if is_active(p) { far } else { any }.0[axis].0[p]
                    };
                    Tangent([Row::from_fn(choose(0)), Row::from_fn(choose(1))])
                }
                _ => any,
            }
        })
        .collect();
    let share = cost * mesh.area() / n as f64;
    let mut energy = 0.0;
    let f = (0..n)
        .map(|v| {
            let theta = share * rng.random_range(-1.0..1.0);
            energy += theta;
            let balance = -k.adjoint().at(&q, v);
            Row::from_fn(|p| {
                let nu = if u[v].0[p] == 0.0 { share * rng.random::<f64>() } else { 0.0 };
                if p < m { balance.0[p] + theta + nu } else { FORBIDDEN_COST }
            })
        })
        .collect();
    let problem = Problem::new(k, f, lambda).in_relaxation(relaxation);
    let energy = energy - problem.baseline;
    Known { problem, u, q, energy }
}

/// Points of the plane, at most `limit` from each other, for which sum <q_p, g_p> is largest, for two or three vectors g_p != 0
/// that sum to zero: an equilateral triangle, or, if two of the g_p form an angle of at most 60 degrees, the third in the
/// origin and the two in their directions.
fn farthest_apart<const M: usize>(g: Tangent<M>, limit: f64) -> Tangent<M> {
    let at = |p: usize| Vector2::new(g.0[0].0[p], g.0[1].0[p]);
    let mut active: Vec<usize> = (0..M).filter(|&p| at(p).norm() > 0.0).collect();
    active.sort_by(|&a, &b| at(a).norm().total_cmp(&at(b).norm()));
    let longest = active.pop().expect("there are two or three");
    let (a, b) = (active[0], active[active.len() - 1]);
    let mut q = [Vector2::zeros(); M];
    if at(a).normalize().dot(&at(b).normalize()) >= 0.5 {
        active.into_iter().for_each(|p| q[p] = at(p).normalize() * limit);
    } else {
        // In the order of the directions of the g_p, a third of a turn apart: sum <q_p, g_p> = <R e, sum R_p^T g_p>.
        let third = (at(a).perp(&at(b))).signum() * 2.0 * std::f64::consts::FRAC_PI_3;
        let turns = [(a, 0.0), (b, third), (longest, -third)];
        let turned = |p: usize, angle: f64| Rotation2::new(angle) * at(p);
        let sum: Vector2<f64> = turns.iter().map(|&(p, angle)| turned(p, -angle)).sum();
        for (p, angle) in turns {
            q[p] = Rotation2::new(angle) * sum.normalize() * (limit / 3.0_f64.sqrt());
        }
    }
    Tangent([Row::from_fn(|p| q[p].x), Row::from_fn(|p| q[p].y)])
}

/// The largest eigenvalue of D^-1/2 K^T diag(w) K D^-1/2, restricted to vertices with faces.
pub fn largest_curvature(k: &Stencil, w: impl Fn(usize) -> f64, d: impl Fn(usize) -> f64) -> f64 {
    let n = k.vertices();
    let mut normal = DMatrix::<f64>::zeros(n, n);
    for j in 0..k.faces() {
        let face = k.face(j);
        for (&a, [ax, ay]) in face.corners.iter().zip(face.columns) {
            for (&b, [bx, by]) in face.corners.iter().zip(face.columns) {
                normal[(a, b)] += w(j) * (ax * bx + ay * by);
            }
        }
    }
    let root = |v: usize| if normal[(v, v)] > 0.0 { d(v).sqrt() } else { 1.0 };
    DMatrix::from_fn(n, n, |a, b| normal[(a, b)] / (root(a) * root(b)))
        .symmetric_eigenvalues()
        .max()
}

/// Asserts |a - b| <= relative * |size|.
#[track_caller]
pub fn assert_within(a: f64, b: f64, relative: f64, size: f64) {
    assert!(
        (a - b).abs() <= relative * size.abs(),
        "{a:e} is not {b:e} within {relative:e} of {size:e}"
    );
}

/// The slope of log error over log step: the exponent p of error ~ h^p, by least squares.
pub fn observed_order(steps: &[f64], errors: &[f64]) -> f64 {
    let n = steps.len() as f64;
    let (x, y): (Vec<f64>, Vec<f64>) =
        steps.iter().zip(errors).map(|(h, e)| (h.ln(), e.ln())).unzip();
    let (mean_x, mean_y) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let covariance: f64 = x.iter().zip(&y).map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    let variance: f64 = x.iter().map(|x| (x - mean_x).powi(2)).sum();
    covariance / variance
}
