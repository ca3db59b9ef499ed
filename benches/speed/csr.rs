//! The second baseline: a straightforward implementation, with K and K^T in compressed sparse rows, stored products,
//! and a parallel loop for each line of the method. In single or double precision.

use meshseg::operator::bounds::{diagonal_above, of_faces, row_bound};
use meshseg::operator::{Matrix, Operator};
use meshseg::problem::Problem;
use rayon::prelude::*;

const RHO: f64 = 1.9;
const STEP_RATIO: f64 = 1.5;

pub trait Float:
    Copy
    + Send
    + Sync
    + PartialOrd
    + Into<f64>
    + std::ops::Add<Output = Self>
    + std::ops::Sub<Output = Self>
    + std::ops::Mul<Output = Self>
    + std::ops::Div<Output = Self>
{
    fn of(x: f64) -> Self;
    fn sqrt(self) -> Self;
}

impl Float for f32 {
    fn of(x: f64) -> Self {
        x as f32
    }
    fn sqrt(self) -> Self {
        self.sqrt()
    }
}

impl Float for f64 {
    fn of(x: f64) -> Self {
        x
    }
    fn sqrt(self) -> Self {
        self.sqrt()
    }
}

struct Compressed<T> {
    start: Vec<u32>,
    index: Vec<u32>,
    value: Vec<T>,
}

impl<T: Float> Compressed<T> {
    fn new(matrix: &sprs::CsMat<f64>) -> Self {
        Compressed {
            start: matrix.proper_indptr().iter().map(|&i| i as u32).collect(),
            index: matrix.indices().iter().map(|&i| i as u32).collect(),
            value: matrix.data().iter().map(|&x| T::of(x)).collect(),
        }
    }

    /// y <- A x, x and y with M columns.
    fn times<const M: usize>(&self, x: &[[T; M]], y: &mut [[T; M]]) {
        y.par_iter_mut().with_min_len(4096).enumerate().for_each(|(row, y)| {
            let mut sum = [T::of(0.0); M];
            for i in self.start[row] as usize..self.start[row + 1] as usize {
                let (x, value) = (&x[self.index[i] as usize], self.value[i]);
                for p in 0..M {
                    sum[p] = sum[p] + value * x[p];
                }
            }
            *y = sum;
        });
    }
}

pub struct Csr<T, const M: usize> {
    k: Compressed<T>,
    k_transposed: Compressed<T>,
    sigma: Vec<T>,
    tau: Vec<T>,
    f: Vec<[T; M]>,
    u: Vec<[T; M]>,
    u_bar: Vec<[T; M]>,
    ku: Vec<[T; M]>,
    kq: Vec<[T; M]>,
    q: Vec<[T; M]>,
    lambda: T,
}

impl<T: Float, const M: usize> Csr<T, M> {
    pub fn new(problem: &Problem<Matrix, M>) -> Self {
        let omega = STEP_RATIO * problem.lambda;
        let sigma = of_faces(&problem.k, |columns| omega / row_bound(columns).sqrt());
        let tau = diagonal_above(&problem.k, |j| sigma[j]);
        let rows = |row: &meshseg::field::Row<M>| row.0.map(T::of);
        let u: Vec<[T; M]> =
            problem.f.iter().map(|f| rows(&meshseg::field::Row::one_hot(f.argmin()))).collect();
        Csr {
            k: Compressed::new(problem.k.csr()),
            k_transposed: Compressed::new(&problem.k.csr().transpose_view().to_csr()),
            sigma: sigma.into_iter().map(T::of).collect(),
            tau: tau.into_iter().map(|x| T::of(1.0 / x)).collect(),
            f: problem.f.iter().map(rows).collect(),
            u_bar: u.clone(),
            kq: vec![[T::of(0.0); M]; u.len()],
            ku: vec![[T::of(0.0); M]; 2 * problem.k.faces()],
            q: vec![[T::of(0.0); M]; 2 * problem.k.faces()],
            u,
            lambda: T::of(problem.lambda),
        }
    }

    pub fn u(&self) -> impl Iterator<Item = [f64; M]> {
        self.u.iter().map(|u| u.map(Into::into))
    }

    pub fn step(&mut self) {
        let (rho, one, two, zero) = (T::of(RHO), T::of(1.0), T::of(2.0), T::of(0.0));
        self.k_transposed.times(&self.q, &mut self.kq);
        (&mut self.u, &mut self.u_bar, &self.kq, &self.f, &self.tau)
            .into_par_iter()
            .with_min_len(4096)
            .for_each(|(u, u_bar, kq, f, &tau)| {
                let mut v = *u;
                for p in 0..M {
                    v[p] = u[p] - tau * (f[p] + kq[p]);
                }
                let mut sorted = v;
                sorted.sort_unstable_by(|a, b| b.partial_cmp(a).expect("not NaN"));
                let (mut sum, mut theta) = (sorted[0] - one, sorted[0] - one);
                for (k, &entry) in sorted.iter().enumerate().skip(1) {
                    sum = sum + entry;
                    let candidate = sum / T::of((k + 1) as f64);
                    theta = if candidate > theta { candidate } else { theta };
                }
                for p in 0..M {
                    let x = if v[p] > theta { v[p] - theta } else { zero };
                    u_bar[p] = two * x - u[p];
                    u[p] = u[p] + rho * (x - u[p]);
                }
            });
        self.k.times(&self.u_bar, &mut self.ku);
        let lambda = self.lambda;
        self.q
            .par_chunks_exact_mut(2)
            .zip(self.ku.par_chunks_exact(2))
            .zip(&self.sigma)
            .with_min_len(4096)
            .for_each(|((q, ku), &sigma)| {
                let mut y = [[zero; M]; 2];
                let mut squared = zero;
                for i in 0..2 {
                    for p in 0..M {
                        y[i][p] = q[i][p] + sigma * ku[i][p];
                        squared = squared + y[i][p] * y[i][p];
                    }
                }
                let norm = squared.sqrt();
                let scale = if norm > lambda { lambda / norm } else { one };
                for i in 0..2 {
                    for p in 0..M {
                        q[i][p] = q[i][p] + rho * (scale * y[i][p] - q[i][p]);
                    }
                }
            });
    }
}
