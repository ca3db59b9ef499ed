//! Images of calibrated cameras as data on a known surface: what their pixels say of each vertex.
//!
//! `formats` reads files of cameras, `picture` their images and masks, `selection` decides which pixels count,
//! `statistics` sums them at the vertices, and `coverage` reports who saw what. The model of these data is
//! [`Radiance`](super::Radiance). [`synthetic`] makes photographs of surfaces whose regions are known, by cameras
//! [`around`](fn@around) them.

mod around;
mod coverage;
mod formats;
mod mask_rule;
mod options;
mod picture;
mod selection;
mod statistics;
pub mod synthetic;
mod view;

use std::borrow::Borrow;
use std::path::{Path, PathBuf};

use super::Data;
use super::pixels::Evidence;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::mesh::geometry::barycentric_areas;
use crate::sweep;

pub use around::{Ball, CamerasAround, around};
pub use coverage::Coverage;
#[cfg(feature = "experiments")]
pub use formats::to_toml;
pub use mask_rule::MaskRule;
pub use options::{PixelWeights, ViewOptions};
pub use picture::Picture;
pub use view::View;

use coverage::Seen;
use picture::PictureFiles;
use statistics::{Sums, ViewStatistics};
use synthetic::Photograph;

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

/// The views of a file, whose images exist.
pub struct ViewFolder {
    /// The format of the file.
    pub format: &'static str,
    /// The views, in the order of the file.
    pub views: Vec<View>,
    /// What was left out of the file, one sentence each.
    pub warnings: Vec<String>,
    files: Vec<PictureFiles>,
}

impl ViewFolder {
    /// Reads the views of a file, or of the folder of a COLMAP model, and finds their images: next to the file, or in the
    /// folder `images`.
    ///
    /// # Errors
    /// A file that cannot be read, impossible cameras, images that do not exist.
    pub fn open(path: &Path, images: Option<&Path>) -> Result<Self> {
        let file = formats::read(path)?;
        let files = picture::locate(path, &file, images)?;
        let formats::ViewFile { format, views, warnings } = file;
        Ok(ViewFolder { format, views, warnings, files })
    }

    /// Width and height of the image of view i in pixels, without reading it whole.
    ///
    /// # Errors
    /// The file of the views does not have it, and the image cannot be read.
    pub fn size(&self, i: usize) -> Result<[u32; 2]> {
        self.views[i].size.map_or_else(|| picture::size(&self.files[i].image), Ok)
    }

    /// The image of view i.
    ///
    /// # Errors
    /// A file that cannot be decoded, or is not of the size of the camera.
    pub fn picture(&self, i: usize) -> Result<Picture> {
        Picture::read(&self.files[i], &self.views[i])
    }

    /// What is behind the surface in view i, whose image is given, if the file of the views names it.
    ///
    /// # Errors
    /// A file that cannot be decoded, or is of another size than the image.
    pub fn background(&self, i: usize, image: &Picture) -> Result<Option<Picture>> {
        Picture::read_background(&self.files[i], image)
    }
}

/// The cameras of a file, all with the sizes of their images: those in the file, or else those of the images, which are
/// found as by [`ViewFolder::open`]; and what was left out of the file.
///
/// # Errors
/// A file that cannot be read, impossible cameras, and images without a size in the file that cannot be read either.
pub fn cameras(path: &Path, images: Option<&Path>) -> Result<(Vec<View>, Vec<String>)> {
    let mut file = formats::read(path)?;
    if file.views.iter().any(|view| view.size.is_none()) {
        let files = picture::locate(path, &file, images)?;
        for (view, PictureFiles { image, .. }) in file.views.iter_mut().zip(files) {
            if view.size.is_none() {
                view.size = Some(picture::size(&image)?);
            }
        }
    }
    Ok((file.views, file.warnings))
}

/// The files of views: those of the cameras, then the image, the mask and the background of each view.
///
/// # Errors
/// Those of [`ViewFolder::open`].
pub fn files(path: &Path, images: Option<&Path>) -> Result<Vec<PathBuf>> {
    let folder = ViewFolder::open(path, images)?;
    let mut files = formats::files(path);
    files.extend(
        folder
            .files
            .into_iter()
            .flat_map(|it| std::iter::once(it.image).chain(it.mask).chain(it.background)),
    );
    Ok(files)
}

/// Reads the views of a file and their images, and sums their pixels at the vertices of a mesh, which is in the units of
/// the cameras.
///
/// # Errors
/// Files that cannot be read, impossible cameras, images that do not fit them, and views that see nothing of the mesh.
pub fn read(path: &Path, mesh: &Mesh, options: &ViewOptions) -> Result<Viewed> {
    let folder = ViewFolder::open(path, options.images.as_deref())?;
    let picture = |i: usize| {
        let picture = folder.picture(i)?;
        check_samples(&picture, options.samples)
            .map_err(|error| error.of_file(&folder.files[i].image))?;
        Ok(picture)
    };
    let ViewFolder { format, views, warnings, .. } = &folder;
    let mut viewed =
        summed(mesh, views, picture, options, format).map_err(|error| error.of_file(path))?;
    viewed.coverage.warnings.splice(0..0, warnings.iter().cloned());
    Ok(viewed)
}

/// The same for pictures in memory, one per view.
///
/// # Errors
/// Views that see nothing of the mesh.
///
/// # Panics
/// The numbers of views and pictures differ.
pub fn of_pictures(
    views: &[View],
    pictures: &[&Picture],
    mesh: &Mesh,
    options: &ViewOptions,
) -> Result<Viewed> {
    assert_eq!(views.len(), pictures.len());
    let picture = |i: usize| {
        check_samples(pictures[i], options.samples)?;
        Ok(pictures[i])
    };
    summed(mesh, views, picture, options, "pictures")
}

/// The same for photographs in memory, one per view, as they are stored in 8 bits.
///
/// # Errors
/// Views that see nothing of the mesh.
///
/// # Panics
/// The numbers of views and photographs differ.
pub fn of_photographs(
    views: &[View],
    photographs: &[Photograph],
    mesh: &Mesh,
    options: &ViewOptions,
) -> Result<Viewed> {
    assert_eq!(views.len(), photographs.len());
    let picture = |i: usize| {
        let Photograph { width, height, .. } = photographs[i];
        let picture = Picture::of_bytes(width, height, photographs[i].bytes());
        check_samples(&picture, options.samples)?;
        Ok(picture)
    };
    summed(mesh, views, picture, options, "synthetic")
}

/// The sums over the pictures of views.
fn summed<P: Borrow<Picture>>(
    mesh: &Mesh,
    views: &[View],
    picture: impl Fn(usize) -> Result<P> + Sync,
    options: &ViewOptions,
    format: &'static str,
) -> Result<Viewed> {
    let (mesh, _) = mesh.without_degenerate_faces();
    let mut total = Total::new(&mesh);
    let views: Vec<(usize, &View)> = views.iter().enumerate().collect();
    // A few views at a time are in memory. They are added in their order, whatever the number of threads.
    for group in views.chunks(2 * sweep::threads()) {
        let statistics = sweep::results(group.to_vec(), |(i, view)| -> Result<_> {
            Ok(statistics::of_view(&mesh, &view.camera, picture(i)?.borrow(), options))
        });
        for ((_, view), statistics) in group.iter().zip(statistics) {
            total.add(view, &statistics?, options.weights);
        }
    }
    let Total { sums, seen } = total;
    let areas = barycentric_areas(&mesh);
    let coverage = seen.coverage(format, &areas)?;
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
