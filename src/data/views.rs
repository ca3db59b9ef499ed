//! Images of calibrated cameras as data on a known surface: what their pixels say of each vertex.
//!
//! `formats` reads files of cameras, `picture` their images and masks, `selection` decides which pixels count,
//! `statistics` sums them at the vertices, and `coverage` reports who saw what. The model of these data is
//! [`Radiance`](super::Radiance).

mod coverage;
mod formats;
mod options;
mod picture;
mod selection;
mod statistics;
mod view;

use std::path::Path;

use super::Data;
use super::pixels::Evidence;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::mesh::geometry::barycentric_areas;
use crate::sweep;

pub use coverage::Coverage;
pub use options::{PixelWeights, ViewOptions};

use coverage::Seen;
use picture::{Picture, PictureFiles};
use statistics::{Sums, ViewStatistics};
use view::View;

/// At most this many samples of a view are in memory.
const MAX_SAMPLES: usize = 1 << 28;

/// Data from views.
pub struct Viewed {
    /// The mean color of the pixels of each vertex, in [0, 1]; NaN where no pixel sees it.
    pub means: Data,
    /// The rest of what the pixels say.
    pub evidence: Evidence,
    /// Who saw what.
    pub coverage: Coverage,
}

/// Reads the views of a file and their images, and sums their pixels at the vertices of a mesh, which is in the units of
/// the cameras.
///
/// # Errors
/// Files that cannot be read, impossible cameras, images that do not fit them, and views that see nothing of the mesh.
pub fn read(path: &Path, mesh: &Mesh, options: &ViewOptions) -> Result<Viewed> {
    let file = formats::read(path)?;
    let pictures = picture::locate(path, &file, options.images.as_deref())?;
    let (mesh, _) = mesh.without_degenerate_faces();
    let mut total = Total::new(&mesh);
    let views: Vec<(&View, &PictureFiles)> = file.views.iter().zip(&pictures).collect();
    // A few views at a time are in memory. They are added in their order, whatever the number of threads.
    for group in views.chunks(2 * sweep::threads()) {
        let statistics = sweep::results(group.to_vec(), |(view, files)| -> Result<_> {
            let picture = Picture::read(files, view)?;
            check_samples(&picture, options.samples)
                .map_err(|error| error.of_file(&files.image))?;
            Ok(statistics::of_view(&mesh, &view.camera, &picture, options))
        });
        for ((view, _), statistics) in group.iter().zip(statistics) {
            total.add(view, &statistics?, options.weights);
        }
    }
    let Total { sums, mut seen } = total;
    seen.warnings.splice(0..0, file.warnings);
    let areas = barycentric_areas(&mesh);
    let coverage = seen.coverage(file.format, &areas).map_err(|error| error.of_file(path))?;
    let (means, evidence) = evidence(&sums, &areas, options.weights)?;
    Ok(Viewed { means, evidence, coverage })
}

/// Checks that the z-buffer fits into memory: it has 12 bytes per sample.
fn check_samples(picture: &Picture, s: usize) -> Result<()> {
    let Picture { width, height, .. } = *picture;
    if width * height * s * s <= MAX_SAMPLES {
        return Ok(());
    }
    Err(Error::unsuitable(format!(
        "{width} x {height} pixels of {s} x {s} samples are too many; lower --samples, or shrink the image and K"
    )))
}

/// The sums over all views.
struct Total {
    sums: Vec<Sums>,
    seen: Seen,
}

impl Total {
    fn new(mesh: &Mesh) -> Self {
        Total { sums: vec![[0.0; 5]; mesh.vertices.len()], seen: Seen::new(mesh.vertices.len()) }
    }

    fn add(&mut self, view: &View, statistics: &ViewStatistics, weights: PixelWeights) {
        let omega = match weights {
            PixelWeights::Angle => 1.0 / view.camera.pixels_per_unit(),
            PixelWeights::Pixel | PixelWeights::Unit => 1.0,
        };
        sweep::sweep((&mut self.sums[..], &statistics.sums[..]), |_, (total, of_view)| {
            total.iter_mut().zip(of_view).for_each(|(total, x)| *total += omega * x);
        });
        self.seen.add(&view.image, statistics);
    }
}

/// The means, and their evidence, from the sums over all views; at least one vertex is seen.
fn evidence(sums: &[Sums], areas: &[f64], weights: PixelWeights) -> Result<(Data, Evidence)> {
    let weight = |k: usize| match weights {
        PixelWeights::Unit if sums[k][0] > 0.0 => areas[k],
        _ => sums[k][0],
    };
    let n = sums.len();
    let sigma = sweep::sum(n, |k| areas[k]) / sweep::sum(n, weight);
    let (mut density, mut variance) = (vec![0.0; n], vec![0.0; n]);
    let mut means = vec![f64::NAN; 3 * n];
    for (k, mean) in means.chunks_mut(3).enumerate() {
        let [w, q, c @ ..] = sums[k];
        if w > 0.0 {
            mean.iter_mut().zip(c).for_each(|(mean, c)| *mean = c / w);
            variance[k] = q / w - mean.iter().map(|x| x * x).sum::<f64>();
            density[k] = sigma * weight(k) / areas[k];
        }
    }
    Ok((Data::new(3, means)?, Evidence { density, variance }))
}

#[cfg(test)]
mod tests;
