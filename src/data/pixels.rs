//! The pixels that see a surface, as statistics at its vertices: the data of `radiance.rs` and `lambertian.rs`.
//!
//! ```text
//! r_k = sigma W_k / a_k,   c_k = C_k / W_k,   v_k = Q_k / W_k - |c_k|^2        sigma = A / sum_k W_k
//! ```
//!
//! With the sums W, Q, C of `views/statistics.rs`, and a_k the barycentric area, a_k r_k (|c_k - mu|^2 + v_k) is the sum
//! over all pixels of the squared distances of their colors to mu, each pixel distributed over the corners of the face
//! that it sees. sigma makes the density r of the evidence 1 on average, so that costs have the size of those of
//! `constant.rs`, which has r = 1 and v = 0. Vertices that no pixel sees are unknown.

use std::borrow::Cow;

use super::Data;
use crate::mesh::coarsen::Coarsening;
use crate::mesh::order::Order;

/// What the pixels say of each vertex beyond the mean of their colors.
#[derive(Clone, Debug)]
pub struct Evidence {
    /// r, V numbers: pixels per area, relative to their mean over the surface; 0 where no pixel sees the vertex.
    pub density: Vec<f64>,
    /// v, V numbers: the variance of the colors of the pixels.
    pub variance: Vec<f64>,
}

/// The statistics r, c, v at the vertices.
#[derive(Clone)]
pub(super) struct Pixels<'a> {
    /// c.
    pub means: Cow<'a, Data>,
    pub evidence: Cow<'a, Evidence>,
}

impl<'a> Pixels<'a> {
    /// Those with these means, which are borrowed. Panics if the lengths differ.
    pub fn new(means: &'a Data, evidence: &'a Evidence) -> Self {
        assert!(evidence.density.len() == means.len() && evidence.variance.len() == means.len());
        Pixels { means: Cow::Borrowed(means), evidence: Cow::Borrowed(evidence) }
    }

    /// Data at the vertices as pixels of density 1 without variance.
    pub fn of_vertices(means: &'a Data) -> Self {
        let known = |k| if means.is_known(k) { 1.0 } else { 0.0 };
        let density = (0..means.len()).map(known).collect();
        let evidence = Evidence { density, variance: vec![0.0; means.len()] };
        Pixels { means: Cow::Borrowed(means), evidence: Cow::Owned(evidence) }
    }

    /// r_k, c_k and v_k.
    #[inline(always)]
    pub fn at(&self, k: usize) -> (f64, &[f64], f64) {
        (self.evidence.density[k], self.means.at(k), self.evidence.variance[k])
    }

    /// a r, for vertex weights a.
    pub fn evidence_of(&self, weights: &[f64]) -> Vec<f64> {
        weights.iter().zip(&self.evidence.density).map(|(a, r)| a * r).collect()
    }

    /// The same with the vertices in the given order, if it differs.
    pub fn in_order(&self, order: &Order) -> Option<Pixels<'static>> {
        let (means, index) = (self.means.in_order(order)?, order.vertices()?);
        let ordered = |values: &[f64]| index.iter().map(|&k| values[k as usize]).collect();
        let Evidence { density, variance } = &*self.evidence;
        let evidence = Evidence { density: ordered(density), variance: ordered(variance) };
        Some(Pixels { means: Cow::Owned(means), evidence: Cow::Owned(evidence) })
    }

    /// Statistics restrict by sums, so that the costs are exactly the restricted ones:
    ///
    /// ```text
    /// w_coarse (r, r c, r (v + |c|^2))_coarse = P^T ( w (r, r c, r (v + |c|^2)) )
    /// ```
    pub fn restricted(
        &self,
        level: &Coarsening,
        weights: &[f64],
        coarse: &[f64],
    ) -> Pixels<'static> {
        let d = self.means.dimension;
        let mut means = vec![0.0; coarse.len() * d];
        let (mut density, mut variance) = (vec![0.0; coarse.len()], vec![0.0; coarse.len()]);
        for (k, parents) in level.parents.iter().enumerate() {
            let Some(mean) = self.means.known(k) else { continue };
            let second = self.evidence.variance[k] + squared_norm(mean);
            for (&c, share) in parents.corners.iter().zip(parents.weights) {
                let (c, w) = (c as usize, share * weights[k] * self.evidence.density[k]);
                density[c] += w;
                variance[c] += w * second;
                let sums = means[c * d..(c + 1) * d].iter_mut();
                sums.zip(mean).for_each(|(sum, x)| *sum += w * x);
            }
        }
        for (c, mean) in means.chunks_mut(d).enumerate() {
            let w = density[c];
            if w > 0.0 {
                mean.iter_mut().for_each(|x| *x /= w);
                variance[c] = variance[c] / w - squared_norm(mean);
                density[c] = w / coarse[c];
            }
        }
        Pixels {
            means: Cow::Owned(Data { dimension: d, values: means }),
            evidence: Cow::Owned(Evidence { density, variance }),
        }
    }
}

pub(super) fn squared_norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum()
}
