//! The surface on its way: its mesh, its labels and colors, and the dual field that certified them last.

use super::coloring::Coloring;
use super::images::Image;
use super::labels::{self, Labels};
use super::lit::Light;
use super::statistics::{Moments, Sums, fit, statistics};
use crate::error::Result;
use crate::mesh::Mesh;
use crate::run::Stop;
use crate::solve::Observer;

/// A surface with regions.
#[derive(Clone)]
pub struct Surface {
    /// X and its faces.
    pub mesh: Mesh,
    /// U and mu.
    pub coloring: Coloring,
    /// q of the last solve on these faces; empty if there was none.
    pub q: Vec<f64>,
    /// The light, if colors are albedos.
    pub light: Option<Light>,
    /// Whether mu is estimated; the white of silhouettes is not.
    pub fits_colors: bool,
}

/// Which pixels determine the colors of the regions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Evidence {
    /// All of them.
    All,
    /// Those that are nearer to a region than to the background.
    Nearer,
}

impl Surface {
    /// What the images say of each vertex.
    pub fn statistics(&self, images: &[Image], samples: usize) -> Vec<Sums> {
        let shading = self.light.map(|light| light.shading(&self.mesh));
        statistics(images, &self.mesh, shading.as_deref(), samples, &self.coloring.mu)
    }

    /// Improves U for given mu, then fits mu to this U by the given pixels, if there are any.
    ///
    /// # Errors
    /// Costs beyond double precision.
    pub fn segment(
        &mut self,
        sums: &[Sums],
        sigma: f64,
        lambda: f64,
        evidence: Option<Evidence>,
        stop: &Stop,
        observe: Observer<'_>,
    ) -> Result<()> {
        let m = self.coloring.regions();
        if m > 1 {
            let f = costs(sums, &self.coloring.mu, sigma);
            let (usable, dropped) = self.mesh.without_degenerate_faces();
            if dropped > 0 {
                self.q.clear();
            }
            let (u, q) = (std::mem::take(&mut self.coloring.u), std::mem::take(&mut self.q));
            let mut labels = Labels { u, q };
            labels::improve(&usable, &f, m, lambda, &mut labels, stop, observe)?;
            (self.coloring.u, self.q) = (labels.u, labels.q);
        }
        if let Some(evidence) = evidence.filter(|_| self.fits_colors) {
            fit(&mut self.coloring, sums, |sums| -> &Moments {
                match evidence {
                    Evidence::All => &sums.all,
                    Evidence::Nearer => &sums.nearer,
                }
            });
        }
        Ok(())
    }
}

/// f, V x m integrated costs.
pub fn costs(sums: &[Sums], mu: &[[f64; 3]], sigma: f64) -> Vec<f64> {
    sums.iter().flat_map(|sums| mu.iter().map(move |&mu| sigma * sums.cost(mu))).collect()
}
