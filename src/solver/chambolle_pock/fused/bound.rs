//! D(q) of a part in double precision, where the state is in single: q is made feasible, K^T q summed anew.
//!
//! ```text
//! D(q) = sum_k min_p ( f_k + (K^T q)_k )_p,   |q_j| <= lambda
//! ```

use pulp::{Simd, WithSimd};

use super::lanes::{Real, WIDEST, width};
use super::part::{Part, Units};
use crate::field::Row;
use crate::operator::Stencil;
use crate::problem::Problem;

/// K^T q in double precision by place, ghosts included: kept from one look to the next.
#[derive(Default)]
pub struct Scratch<const M: usize>(Vec<Row<M>>);

/// min_p ( f_k + (K^T q)_k )_p of the own vertices of a part. A vertex sums its faces in the order of all parts.
pub struct Bounds<'a, K, T, const M: usize> {
    pub part: &'a Part<T>,
    pub problem: &'a Problem<K, M>,
    pub stencil: &'a Stencil,
    pub units: Units,
    pub scratch: &'a mut Scratch<M>,
    pub bounds: &'a mut [f64],
}

impl<K, T: Real, const M: usize> WithSimd for Bounds<'_, K, T, M> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Bounds { part, problem, stencil, units, scratch: Scratch(kq), bounds } = self;
        let (width, lambda) = (width::<T, S>(), problem.lambda);
        let unit = 1.0 / units.q;
        kq.clear();
        kq.resize(part.tau.len(), Row::ZERO);
        let blocks = part.layout.faces.chunks(width).zip(part.q.chunks_exact(2 * M * width));
        for ((faces, q), corners) in blocks.zip(part.layout.corners.chunks_exact(3 * width)) {
            let mut y = [[[0.0; WIDEST]; M]; 2];
            let mut squares = [0.0; WIDEST];
            for (y, q) in y.as_flattened_mut().iter_mut().zip(q.chunks_exact(width)) {
                for o in 0..width {
                    y[o] = q[o].to_f64() * unit;
                    squares[o] += y[o] * y[o];
                }
            }
            // y = Proj_{|.|<=lambda}( y )
            let mut scale = [1.0; WIDEST];
            for o in 0..width {
                let norm = squares[o].sqrt();
                let outside = norm > lambda;
                scale[o] = if outside { lambda } else { 1.0 } / if outside { norm } else { 1.0 };
            }
            for (o, &j) in faces.iter().enumerate() {
                let lane = part.layout.lanes.order[o];
                let [c1, c2, c3] = stencil.weights()[j as usize].map(|c| c * scale[lane]);
                let [q1, q2] = [0, 1].map(|axis| Row::<M>::from_fn(|p| y[axis][p][lane]));
                let second = q1 * c1 + q2 * c2;
                let third = q2 * c3;
                kq[corners[o] as usize] += (second + third) * -1.0;
                kq[corners[width + o] as usize] += second;
                kq[corners[2 * width + o] as usize] += third;
            }
        }
        let own = &kq[part.layout.own_from()..];
        let f = &problem.f[part.layout.range.clone()];
        for ((bound, &kq), &f) in bounds.iter_mut().zip(own).zip(f) {
            *bound = (f + kq).min();
        }
    }
}
