//! The largest sum of <q_p, g_p> over points q_p of the plane with |q_a - q_b| <= d(a, b) for a metric d, where the
//! vectors g_p sum to zero: what it costs to transport g along flows t_ab between regions.
//!
//! ```text
//! max { sum <q_p, g_p> :  |q_a - q_b| <= d(a, b) }  =  min { sum_ab d(a, b) |t_ab| :  sum_b t_pb = g_p,  t_ba = -t_ab }
//! ```
//!
//! A primal-dual interior-point method: Newton's method for the perturbed optimality conditions, with a multiplier z_ab
//! > 0 for each pair, in which t_ab = 2 z_ab (q_a - q_b):
//!
//! ```text
//! 2 sum_b z_pb (q_p - q_b) = g_p          z_ab ( d(a, b)^2 - |q_a - q_b|^2 ) = mu -> 0
//! ```
//!
//! What is missing to g flows by way of one region, so that every iterate gives an upper bound, and every q a lower
//! one. S. Mehrotra, *On the implementation of a primal-dual interior point method*, SIAM J. Optimization 2, 1992.
//!
//! A region with g_p = 0 takes part only if it is near: a q_p in the center of the smallest circle around all other
//! points, whose radius is at most their diameter over sqrt(3) by Jung's theorem, is no farther from them than that.

use std::iter::repeat;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::label_metric::LabelMetric;
use crate::field::Tangent;

type Vector = [f64; 2];

/// The method ends when upper and lower bound are so near, in units of the upper one.
const ACCURACY: f64 = 1e-13;

/// The largest number of steps; 10 to 15 are needed for up to 20 regions.
const MAX_STEPS: usize = 60;

/// The smallest share of mu that a step aims at.
const CENTERING: f64 = 0.01;

/// How often a step is halved that leaves the set by rounding.
const MAX_HALVINGS: usize = 20;

/// The share of the way to the border of the set that a step takes.
const WAY: f64 = 0.99;

/// The sum, from above; exact up to about 1e-13 of itself, or 1e-10 where some distances are sums of others, so that
/// several transports cost the same.
pub fn support<const M: usize>(g: Tangent<M>, metric: LabelMetric) -> f64 {
    let Tangent([gx, gy]) = g;
    let (mut regions, mut vectors) = ([0_u8; M], [[0.0; 2]; M]);
    let mut n = 0;
    for p in 0..M {
        // NaN takes part.
        if gx.0[p] != 0.0 || gy.0[p] != 0.0 {
            (regions[n], vectors[n]) = (p as u8, [gx.0[p], gy.0[p]]);
            n += 1;
        }
    }
    of_regions(&regions[..n], &vectors[..n], metric)
}

/// The same for the vectors of some regions; those of the others are zero.
pub fn of_regions(regions: &[u8], vectors: &[Vector], metric: LabelMetric) -> f64 {
    let size: f64 = vectors.iter().map(|&g| norm(g)).sum();
    if regions.len() < 2 || !size.is_finite() || size == 0.0 {
        // NaN stays NaN, and infinity infinite.
        return 0.5 * size * metric.largest();
    }
    let regions = taking_part(regions, metric);
    let [a, b] = [regions[0], regions[1]].map(usize::from);
    if let ([_, _], [g, h]) = (&regions[..], vectors) {
        return metric.apart(a, b) * f64::max(norm(*g), norm(*h));
    }
    let mut transport = Transport::new(&regions, vectors, size, metric);
    size * metric.largest() * transport.least()
}

/// The regions with vectors, and those that a flow may pass on its way.
fn taking_part(regions: &[u8], metric: LabelMetric) -> Vec<u8> {
    let mut all = regions.to_vec();
    let mut left: Vec<u8> = (0..metric.labels() as u8).filter(|p| !all.contains(p)).collect();
    loop {
        let d = |&a: &u8, &b: &u8| metric.distance(a.into(), b.into());
        let pairs = all.iter().flat_map(|a| all.iter().map(move |b| d(a, b)));
        let diameter = pairs.fold(0.0, f64::max);
        let is_near = |c: &u8| all.iter().any(|a| d(a, c) * 3.0_f64.sqrt() < diameter);
        let (near, far): (Vec<u8>, Vec<u8>) = left.iter().partition(|c| is_near(c));
        if near.is_empty() {
            return all;
        }
        all.extend(near);
        left = far;
    }
}

/// The problem with |g| and d scaled to at most 1, and an iterate.
#[derive(Clone)]
struct Transport {
    /// Number of regions.
    n: usize,
    g: Vec<Vector>,
    pairs: Vec<Pair>,
    /// d(a, b).
    d: DMatrix<f64>,
    q: Vec<Vector>,
}

#[derive(Clone)]
struct Pair {
    ends: [usize; 2],
    /// d(a, b)^2.
    square: f64,
    /// z_ab.
    multiplier: f64,
}

impl Transport {
    fn new(regions: &[u8], vectors: &[Vector], size: f64, metric: LabelMetric) -> Self {
        let n = regions.len();
        let scaled = vectors.iter().map(|g| g.map(|x| x / size)).chain(repeat([0.0; 2]));
        let mut all: Vec<(u8, Vector)> = regions.iter().copied().zip(scaled).collect();
        // The last point stays in the origin, and the others are eliminated in this order: those of long vectors are
        // ends of the stiffest pairs, whose entries would cancel those of the others.
        all.sort_by(|a, b| norm(a.1).total_cmp(&norm(b.1)));
        let (regions, g): (Vec<u8>, Vec<Vector>) = all.into_iter().unzip();
        let d = DMatrix::from_fn(n, n, |a, b| {
            metric.distance(regions[a].into(), regions[b].into()) / metric.largest()
        });
        let ends = (0..n).flat_map(|a| (0..a).map(move |b| [a, b]));
        let pair = |ends: [usize; 2]| {
            let square = d[(ends[0], ends[1])].powi(2);
            Pair { ends, square, multiplier: 1.0 / (n as f64 * square) }
        };
        let pairs = ends.map(pair).collect();
        Transport { n, g, pairs, d, q: vec![[0.0; 2]; n] }
    }

    /// The least cost, from above.
    fn least(&mut self) -> f64 {
        let mut least = f64::INFINITY;
        for _ in 0..MAX_STEPS {
            let missing = self.missing();
            let upper = self.cost(&missing);
            least = least.min(upper);
            let lower: f64 = self.q.iter().zip(&self.g).map(|(&q, &g)| dot(q, g)).sum();
            if upper - lower <= ACCURACY * upper || !self.advance(&missing) {
                break;
            }
        }
        least
    }

    /// q_a - q_b.
    fn difference(&self, [a, b]: [usize; 2]) -> Vector {
        minus(self.q[a], self.q[b])
    }

    /// g_p - sum_b t_pb.
    fn missing(&self) -> Vec<Vector> {
        let mut missing = self.g.clone();
        for pair in &self.pairs {
            let x = self.difference(pair.ends);
            spread(&mut missing, pair.ends, x.map(|x| -2.0 * pair.multiplier * x));
        }
        missing
    }

    /// sum d(a, b) |t_ab|, and what is missing by way of the region where that costs least.
    fn cost(&self, missing: &[Vector]) -> f64 {
        let flow = |pair: &Pair| {
            2.0 * pair.multiplier * norm(self.difference(pair.ends)) * pair.square.sqrt()
        };
        let way = |by: usize| -> f64 {
            missing.iter().enumerate().map(|(p, &r)| self.d[(p, by)] * norm(r)).sum()
        };
        let ways = (0..self.n).map(way).fold(f64::INFINITY, f64::min);
        self.pairs.iter().map(flow).sum::<f64>() + ways
    }

    fn slack(&self, pair: &Pair) -> f64 {
        let x = self.difference(pair.ends);
        pair.square - dot(x, x)
    }

    /// Mehrotra's predictor and corrector; whether the step could be made.
    fn advance(&mut self, missing: &[Vector]) -> bool {
        let Some(factor) = self.matrix().cholesky() else { return false };
        let mean = |products: &mut dyn Iterator<Item = f64>| {
            products.sum::<f64>() / self.pairs.len() as f64
        };
        let mu = mean(&mut self.pairs.iter().map(|pair| pair.multiplier * self.slack(pair)));
        let predicted = self.step(&factor, missing, &|_, _| (0.0, [0.0; 2]));
        let Some(way) = self.way(&predicted, 1.0) else { return false };
        let left = mean(&mut self.pairs.iter().zip(&predicted.pairs).map(|(pair, (dx, dz))| {
            let x = plus(self.difference(pair.ends), dx.map(|x| way * x));
            (pair.multiplier + way * dz) * (pair.square - dot(x, x))
        }));
        let aim = mu * (left / mu).powi(3).clamp(CENTERING, 1.0);
        // The terms of second order that the prediction left out.
        let corrected = self.step(&factor, missing, &|i, x| {
            let ((dx, dz), z) = (predicted.pairs[i], self.pairs[i].multiplier);
            let products = 2.0 * dz * dot(x, dx) + z * dot(dx, dx);
            (aim + way * way * products, dx.map(|dx| 2.0 * way * way * dz * dx))
        });
        let Some(mut way) = self.way(&corrected, WAY) else { return false };
        for _ in 0..MAX_HALVINGS {
            let next = self.moved(&corrected, way);
            if next.pairs.iter().all(|pair| next.slack(pair) > 0.0 && pair.multiplier > 0.0) {
                *self = next;
                return true;
            }
            // By rounding.
            way *= 0.5;
        }
        false
    }

    /// Of the linear equations for the points but the last.
    fn matrix(&self) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(2 * (self.n - 1), 2 * (self.n - 1));
        for pair in &self.pairs {
            let (x, z) = (self.difference(pair.ends), pair.multiplier);
            let stiffness = 4.0 * z / self.slack(pair);
            let ends = [(pair.ends[0], 1.0), (pair.ends[1], -1.0)];
            for (i, k) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let entry = stiffness * x[i] * x[k] + if i == k { 2.0 * z } else { 0.0 };
                for (p, sign_p) in ends.into_iter().filter(|end| end.0 < self.n - 1) {
                    for (r, sign_r) in ends.into_iter().filter(|end| end.0 < self.n - 1) {
                        matrix[(2 * p + i, 2 * r + k)] += sign_p * sign_r * entry;
                    }
                }
            }
        }
        matrix
    }

    /// The solution of the linear equations. For each pair, `aim` has what the product of multiplier and slack is to
    /// become, and a flow that is there besides.
    fn step(
        &self,
        factor: &Cholesky<f64, Dyn>,
        missing: &[Vector],
        aim: &dyn Fn(usize, Vector) -> (f64, Vector),
    ) -> Step {
        let unknowns = 2 * (self.n - 1);
        let mut right = missing.to_vec();
        for (i, pair) in self.pairs.iter().enumerate() {
            let x = self.difference(pair.ends);
            let (product, flow) = aim(i, x);
            let pull = 2.0 * (product / self.slack(pair) - pair.multiplier);
            spread(&mut right, pair.ends, [0, 1].map(|i| -pull * x[i] - flow[i]));
        }
        let right = DVector::from_iterator(unknowns, right.into_iter().flatten().take(unknowns));
        let solved = factor.solve(&right);
        let mut points: Vec<Vector> = solved.as_slice().chunks(2).map(|q| [q[0], q[1]]).collect();
        points.push([0.0; 2]);
        let change = |(i, pair): (usize, &Pair)| {
            let x = self.difference(pair.ends);
            let dx = minus(points[pair.ends[0]], points[pair.ends[1]]);
            let slack = self.slack(pair);
            let z = pair.multiplier;
            (dx, (aim(i, x).0 - z * slack + 2.0 * z * dot(x, dx)) / slack)
        };
        let pairs = self.pairs.iter().enumerate().map(change).collect();
        Step { points, pairs }
    }

    /// The largest share of a step, up to 1, that takes no more than a share of the way to the border; `None` if the
    /// step is none.
    fn way(&self, step: &Step, share: f64) -> Option<f64> {
        let mut way: f64 = 1.0;
        for (pair, &(dx, dz)) in self.pairs.iter().zip(&step.pairs) {
            let (a, b) = (dot(dx, dx), dot(self.difference(pair.ends), dx));
            let slack = self.slack(pair);
            // |x + way dx|^2 = d^2, without cancellation.
            let root = (b * b + a * slack).sqrt();
            let out = if b > 0.0 { slack / (root + b) } else { (root - b) / a };
            if a > 0.0 {
                way = way.min(share * out);
            }
            if dz < 0.0 {
                way = way.min(share * -pair.multiplier / dz);
            }
            if !(a + dz).is_finite() {
                return None;
            }
        }
        Some(way)
    }

    /// The iterate after a share of a step.
    fn moved(&self, step: &Step, way: f64) -> Self {
        let mut next = self.clone();
        for (pair, (_, dz)) in next.pairs.iter_mut().zip(&step.pairs) {
            pair.multiplier += way * dz;
        }
        for (q, dq) in next.q.iter_mut().zip(&step.points) {
            *q = plus(*q, dq.map(|x| way * x));
        }
        next
    }
}

/// A change of an iterate.
struct Step {
    /// Of each q_p.
    points: Vec<Vector>,
    /// Of q_a - q_b and z_ab of each pair.
    pairs: Vec<(Vector, f64)>,
}

/// Adds a vector at the first end of a pair, and subtracts it at the second.
fn spread(field: &mut [Vector], [a, b]: [usize; 2], vector: Vector) {
    for i in 0..2 {
        field[a][i] += vector[i];
        field[b][i] -= vector[i];
    }
}

fn plus(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1]]
}

fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn norm(a: Vector) -> f64 {
    dot(a, a).sqrt()
}
