//! The first baseline: one over-relaxed Chambolle-Pock step as two handwritten loops for 4 regions, without operators,
//! `Row` or threads. The face loop scatters K^T q while q is still in registers.

use meshseg::mesh::Mesh;
use meshseg::operator::bounds::{diagonal_above, of_faces, row_bound};
use meshseg::operator::{Operator, Stencil};
use meshseg::problem::Problem;

const RHO: f64 = 1.9;
const STEP_RATIO: f64 = 1.5;

pub struct HandFused {
    corners: Vec<[u32; 3]>,
    /// c1, c2, c3.
    weights: Vec<[f64; 3]>,
    sigma: Vec<f64>,
    tau: Vec<f64>,
    f: Vec<[f64; 4]>,
    u: Vec<[f64; 4]>,
    u_bar: Vec<[f64; 4]>,
    /// K^T q.
    kq: Vec<[f64; 4]>,
    q: Vec<[[f64; 4]; 2]>,
    lambda: f64,
}

impl HandFused {
    pub fn new(mesh: &Mesh, problem: &Problem<Stencil, 4>) -> Self {
        let omega = STEP_RATIO * problem.lambda;
        let faces = 0..problem.k.faces();
        let sigma = of_faces(&problem.k, |columns| omega / row_bound(columns).sqrt());
        let tau = diagonal_above(&problem.k, |j| sigma[j]).into_iter().map(f64::recip).collect();
        let weights = faces
            .map(|j| {
                let [_, [c1, c2], [_, c3]] = problem.k.face(j).columns;
                [c1, c2, c3]
            })
            .collect();
        let u: Vec<[f64; 4]> =
            problem.f.iter().map(|f| std::array::from_fn(|p| f64::from(p == f.argmin()))).collect();
        HandFused {
            corners: mesh.faces.clone(),
            weights,
            sigma,
            tau,
            f: problem.f.iter().map(|f| f.0).collect(),
            u_bar: u.clone(),
            kq: vec![[0.0; 4]; u.len()],
            q: vec![[[0.0; 4]; 2]; mesh.faces.len()],
            u,
            lambda: problem.lambda,
        }
    }

    pub fn u(&self) -> &[[f64; 4]] {
        &self.u
    }

    pub fn step(&mut self) {
        let vertices = self.u.iter_mut().zip(&mut self.u_bar).zip(&mut self.kq);
        for (((u, u_bar), kq), (f, &tau)) in vertices.zip(self.f.iter().zip(&self.tau)) {
            let mut v = [0.0; 4];
            for p in 0..4 {
                v[p] = u[p] - tau * (f[p] + kq[p]);
            }
            let x = project_simplex(v);
            for p in 0..4 {
                u_bar[p] = 2.0 * x[p] - u[p];
                u[p] += RHO * (x[p] - u[p]);
            }
            *kq = [0.0; 4];
        }
        let faces = self.q.iter_mut().zip(&self.corners).zip(&self.weights).zip(&self.sigma);
        for (((q, corners), &[c1, c2, c3]), &sigma) in faces {
            let [a, b, c] = corners.map(|v| v as usize);
            let (u1, u2, u3) = (self.u_bar[a], self.u_bar[b], self.u_bar[c]);
            let mut y = [[0.0; 4]; 2];
            let mut squared = 0.0;
            for p in 0..4 {
                let (ua, ub) = (u2[p] - u1[p], u3[p] - u1[p]);
                y[0][p] = q[0][p] + sigma * (c1 * ua);
                y[1][p] = q[1][p] + sigma * (c2 * ua + c3 * ub);
                squared += y[0][p] * y[0][p] + y[1][p] * y[1][p];
            }
            let norm = squared.sqrt();
            let scale = if norm > self.lambda { self.lambda / norm } else { 1.0 };
            for p in 0..4 {
                let q1 = q[0][p] + RHO * (scale * y[0][p] - q[0][p]);
                let q2 = q[1][p] + RHO * (scale * y[1][p] - q[1][p]);
                (q[0][p], q[1][p]) = (q1, q2);
                let (to_b, to_c) = (c1 * q1 + c2 * q2, c3 * q2);
                self.kq[a][p] -= to_b + to_c;
                self.kq[b][p] += to_b;
                self.kq[c][p] += to_c;
            }
        }
    }
}

/// Sorts with a network of five exchanges, then theta = max_k (S_k - 1) / k.
fn project_simplex(v: [f64; 4]) -> [f64; 4] {
    let order = |a: f64, b: f64| if a < b { (b, a) } else { (a, b) };
    let (a, b) = order(v[0], v[1]);
    let (c, d) = order(v[2], v[3]);
    let (a, c) = order(a, c);
    let (b, d) = order(b, d);
    let (b, c) = order(b, c);
    let mut theta = a - 1.0;
    for candidate in [(a + b - 1.0) / 2.0, (a + b + c - 1.0) / 3.0, (a + b + c + d - 1.0) / 4.0] {
        theta = if candidate > theta { candidate } else { theta };
    }
    v.map(|x| if x > theta { x - theta } else { 0.0 })
}
