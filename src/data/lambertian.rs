//! Albedo: every region reflects one share of the light in each channel, and a distant light shines on the surface.
//!
//! ```text
//! s_p(x_k) = r_k ( |c_k - h_k rho_p|^2 + v_k ),     h_k = alpha + max(0, N_k.L),   |L| = 1
//! rho_p = int u_p r h c / int u_p r h^2
//! ```
//!
//! with the statistics r, c, v of the pixels, see `pixels.rs`, the normals N, the light L and the ambient light alpha,
//! which are the same for all regions. h is the shading at the vertices: within a face, where it is linear, costs differ
//! from those of its pixels by the variance of h times |rho|^2, of second order in the size of the face. L and alpha are
//! given or estimated, see `lambertian/light.rs`. Where h = 0 no pixel tells the regions apart, and the cuts decide.
//! Shadows that one part of the surface casts on another are not modeled.
//!
//! Reference: Delaunoy et al., ICCV 2009, section 3.2 (Lambertian reflection); the index of the camera belongs inside
//! both sums of rho_p.

mod light;

#[cfg(test)]
mod tests;

use std::borrow::Cow;

use nalgebra::Vector3;
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

use super::pixels::{Evidence, Pixels};
use super::values::check_values;
use super::{Cost, Data, DataModel, Initial, PiecewiseConstant, Scale, Weights};
use crate::error::{Error, Result};
use crate::mesh::coarsen::Coarsening;
use crate::mesh::order::Order;
use crate::sweep::{collect, sum};

/// Albedos are at most this multiple of the largest datum: a brighter region is one of which only dim light is seen.
const MAX_ALBEDO: f64 = 1.5;

/// Vertices whose shading is below this fraction of the largest have no part in the clusters of initial albedos.
const MIN_CLUSTERED_SHADING: f64 = 0.2;

/// The light, as far as it is given; the rest is estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Illumination {
    /// L, the direction towards the light, of length 1.
    pub light: Option<Vector3<f64>>,
    /// alpha, at least 0: ambient light, relative to the light that falls on a face perpendicularly.
    pub ambient: Option<f64>,
}

/// The parameters of a region.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Albedo {
    /// rho_p: d numbers, in the units of the data; the color of the region where h = 1.
    pub albedo: Vec<f64>,
    /// L; the same for all regions. 0 if the colors show no light.
    pub light: [f64; 3],
    /// alpha; the same for all regions, 1 if L = 0.
    pub ambient: f64,
}

/// The likelihood of the pixels of a lit surface.
#[derive(Clone)]
pub struct Lambertian<'a> {
    pixels: Pixels<'a>,
    /// N; on a coarse mesh the mean of the normals, which is shorter than 1.
    normals: Cow<'a, [Vector3<f64>]>,
    given: Illumination,
}

impl<'a> Lambertian<'a> {
    /// The model of these colors of V vertices, which are means of pixels or have no other evidence, with V outward
    /// normals of length 1, or 0 where a vertex has none. Panics if the lengths differ.
    ///
    /// # Errors
    /// No datum is above 0: a surface in the dark.
    pub fn new(
        means: &'a Data,
        evidence: Option<&'a Evidence>,
        normals: &'a [Vector3<f64>],
        given: Illumination,
    ) -> Result<Self> {
        assert_eq!(normals.len(), means.len());
        if !means.values.iter().any(|&c| c > 0.0) {
            return Err(Error::unsuitable(
                "the model albedo describes colors, but no datum is above 0; choose another --model",
            ));
        }
        let pixels = match evidence {
            Some(evidence) => Pixels::new(means, evidence),
            None => Pixels::of_vertices(means),
        };
        Ok(Lambertian { pixels, normals: Cow::Borrowed(normals), given })
    }

    fn means(&self) -> &Data {
        &self.pixels.means
    }

    /// h at all vertices.
    fn shading(&self, mu: &Albedo) -> Vec<f64> {
        let (light, ambient) = (Vector3::from(mu.light), mu.ambient);
        collect(self.normals.len(), |k| ambient + self.normals[k].dot(&light).max(0.0))
    }

    /// sum_k <(M U)_k, s(x_k)>, without the variances, which no parameter changes.
    fn costs_of(&self, weights: Weights<'_>, mu: &[Albedo]) -> f64 {
        let h = self.shading(&mu[0]);
        sum(weights.vertices(), |k| {
            if !self.is_known(k) {
                return 0.0;
            }
            let (r, c, _) = self.pixels.at(k);
            let of_region = |(u, mu): (&f64, &Albedo)| u * squared_distance(c, h[k], &mu.albedo);
            r * weights.at(k).iter().zip(mu).map(of_region).sum::<f64>()
        })
    }
}

/// |c - h rho|^2
#[inline(always)]
fn squared_distance(c: &[f64], h: f64, rho: &[f64]) -> f64 {
    c.iter().zip(rho).map(|(c, rho)| (c - h * rho).powi(2)).sum()
}

impl DataModel for Lambertian<'_> {
    type Parameters = Albedo;

    type Datum = [f64];

    const VALUE_NAME: &'static str = "albedo";

    fn value(mu: &Albedo) -> &[f64] {
        &mu.albedo
    }

    fn vertices(&self) -> usize {
        self.means().len()
    }

    fn at(&self, k: usize) -> Option<&[f64]> {
        self.pixels.means.known(k)
    }

    fn in_order(&self, order: &Order) -> Cow<'_, Self> {
        let (Some(pixels), Some(index)) = (self.pixels.in_order(order), order.vertices()) else {
            return Cow::Borrowed(self);
        };
        let normals = index.iter().map(|&k| self.normals[k as usize]).collect();
        Cow::Owned(Lambertian { pixels, normals: Cow::Owned(normals), given: self.given })
    }

    /// The restricted statistics, and the means of the normals: exact for int u_p r h c where the light reaches all of
    /// the vertices that a coarse one stands for.
    fn restricted(&self, level: &Coarsening, weights: &[f64], coarse: &[f64]) -> Self {
        let mut normals = vec![Vector3::zeros(); coarse.len()];
        let mut masses = vec![0.0; coarse.len()];
        for (k, parents) in level.parents.iter().enumerate().filter(|&(k, _)| self.is_known(k)) {
            for (&c, share) in parents.corners.iter().zip(parents.weights) {
                let w = share * weights[k] * self.pixels.evidence.density[k];
                normals[c as usize] += w * self.normals[k];
                masses[c as usize] += w;
            }
        }
        for (normal, mass) in normals.iter_mut().zip(masses) {
            if mass > 0.0 {
                *normal /= mass;
            }
        }
        Lambertian {
            pixels: self.pixels.restricted(level, weights, coarse),
            normals: Cow::Owned(normals),
            given: self.given,
        }
    }

    /// The variance of the colors, the standard deviation, and the widest range of a channel.
    fn scale(&self, weights: &[f64]) -> Scale {
        PiecewiseConstant::new(self.means()).scale(&self.pixels.evidence_of(weights))
    }

    /// The light that explains a surface of one region best, and clusters of the colors divided by their shading, weighed
    /// by its square.
    fn start(
        &self,
        initial: Initial,
        m: usize,
        weights: &[f64],
        rng: &mut Pcg64,
    ) -> Result<Vec<Albedo>> {
        let lit = self.initial_light(weights);
        let h = self.shading(&lit);
        if !(0..h.len()).any(|k| self.is_known(k) && h[k] > 0.0) {
            return Err(Error::unsuitable(
                "no light falls on vertices with known data; give another --light, or some --ambient",
            ));
        }
        let dark = MIN_CLUSTERED_SHADING * h.iter().copied().fold(0.0, f64::max);
        let Data { dimension: d, values } = self.means();
        let is_lit = |k: usize| self.is_known(k) && h[k] > dark;
        let divided = values.chunks(*d).enumerate().flat_map(|(k, c)| {
            let h = if is_lit(k) { h[k] } else { f64::NAN };
            c.iter().map(move |c| c / h)
        });
        let mut area = self.pixels.evidence_of(weights);
        area.iter_mut().zip(&h).for_each(|(area, h)| *area *= h * h);
        let divided = Data::new(*d, divided.collect())?;
        let clusters = PiecewiseConstant::new(&divided).start(initial, m, &area, rng)?;
        Ok(clusters.into_iter().map(|mean| Albedo { albedo: mean.mean, ..lit.clone() }).collect())
    }

    fn check(&self, mu: &[Albedo]) -> Result<()> {
        check_values(self.means().dimension, mu.iter().map(|mu| &mu.albedo[..]))?;
        for (p, mu) in mu.iter().enumerate() {
            check_values(3, std::iter::once(&mu.light[..])).map_err(|_| {
                Error::unsuitable(format!("region {p} has a light that is not finite"))
            })?;
            if !(mu.ambient >= 0.0 && mu.ambient.is_finite()) {
                let message = format!("region {p} has the ambient light {:?}", mu.ambient);
                return Err(Error::unsuitable(message));
            }
        }
        match mu.iter().position(|one| (one.light, one.ambient) != (mu[0].light, mu[0].ambient)) {
            None => Ok(()),
            Some(p) => Err(Error::unsuitable(format!(
                "region {p} has another light than region 0; they are lit by the same"
            ))),
        }
    }

    fn cost<'a>(&'a self, mu: &'a [Albedo]) -> Cost<'a> {
        assert!(mu.iter().all(|mu| mu.albedo.len() == self.means().dimension));
        let h = self.shading(&mu[0]);
        Box::new(move |k, s| {
            let (r, c, v) = self.pixels.at(k);
            let cost = |mu: &Albedo| r * (squared_distance(c, h[k], &mu.albedo) + v);
            s.iter_mut().zip(mu).for_each(|(s, mu)| *s = cost(mu));
        })
    }

    fn fit(&self, weights: Weights<'_>, mu: &mut [Albedo]) -> Result<f64> {
        let before = mu.to_vec();
        self.fit_all(weights, mu);
        // What changes in the color of a vertex that faces the light.
        let change = |(a, b): (&Albedo, &Albedo)| {
            let [bright_a, bright_b] = [a, b].map(|mu| mu.ambient + Vector3::from(mu.light).norm());
            let albedo = a.albedo.iter().zip(&b.albedo);
            let color =
                albedo.map(|(a, b)| (bright_a * a - bright_b * b).abs()).fold(0.0, f64::max);
            let turned = (Vector3::from(a.light) - Vector3::from(b.light)).norm();
            let brightest = b.albedo.iter().copied().fold(0.0, f64::max);
            f64::max(color, turned * brightest)
        };
        Ok(before.iter().zip(&*mu).map(change).fold(0.0, f64::max))
    }

    /// (alpha + |L| / 2) |rho_a - rho_b|, the distance of their colors in half of the light; it does not change when L and
    /// alpha are scaled and rho inversely.
    fn distance(a: &Albedo, b: &Albedo) -> f64 {
        let h = a.ambient + Vector3::from(a.light).norm() / 2.0;
        h * squared_distance(&a.albedo, 1.0, &b.albedo).sqrt()
    }
}
