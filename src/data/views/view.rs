//! A view as files describe it: an image, its camera, and a mask.

use std::path::Path;

use nalgebra::{Matrix3, Vector3};

use crate::error::Result;
use crate::optics::pinhole::Pinhole;

/// An image and its camera.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// The file of the image, as it is named in the file of the views.
    pub image: String,
    /// The file of an image that is bright where the pixels count.
    pub mask: Option<String>,
    /// The file of an image of what is behind the surface.
    pub background: Option<String>,
    /// Width and height of the image in pixels, if the file has them.
    pub size: Option<[u32; 2]>,
    /// From the units of the mesh to pixels.
    pub camera: Pinhole,
}

/// A camera of the file `path`, K and R row by row; errors name the image.
pub fn camera(path: &Path, image: &str, k: [f64; 9], r: [f64; 9], t: [f64; 3]) -> Result<Pinhole> {
    let matrix = |numbers: [f64; 9]| Matrix3::from_row_slice(&numbers);
    Pinhole::new(matrix(k), matrix(r), Vector3::from(t)).map_err(|error| {
        crate::error::Error::malformed(path, format!("the camera of {image}: {error}"))
    })
}
