//! The argument of `render --views`: viewpoints of pictures, or cameras of photographs.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use meshseg::render::Views;

/// The largest number of cameras around a mesh.
const MAX_CAMERAS: usize = 1000;
/// The largest number of pixels of a view that `segment` reads.
const MAX_PIXELS: u64 = 1 << 26;
const DEFAULT_SIZE: [u32; 2] = [640, 480];

/// Where a mesh is seen from.
#[derive(Clone)]
pub enum Viewpoints {
    /// Those of a picture.
    Named(Views),
    /// `sphere:N:WxH`: N cameras around the mesh, with images of W x H pixels.
    Sphere { cameras: usize, size: [u32; 2] },
    /// The cameras of a file.
    File(PathBuf),
}

impl FromStr for Viewpoints {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some(sphere) = text.strip_prefix("sphere:") {
            return self::sphere(sphere);
        }
        match text.parse() {
            Ok(views) => Ok(Viewpoints::Named(views)),
            Err(_) if Path::new(text).exists() => Ok(Viewpoints::File(text.into())),
            Err(error) => Err(format!("{error}; or cameras: sphere:N, or a file that exists")),
        }
    }
}

/// `N` or `N:WxH`.
fn sphere(text: &str) -> Result<Viewpoints, String> {
    let (cameras, size) = match text.split_once(':') {
        None => (text, Some(DEFAULT_SIZE)),
        Some((cameras, size)) => {
            let numbers = size.split_once('x').and_then(|(width, height)| {
                Some([width.parse::<u32>().ok()?, height.parse::<u32>().ok()?])
            });
            let possible = |[width, height]: &[u32; 2]| {
                (1..=MAX_PIXELS).contains(&(u64::from(*width) * u64::from(*height)))
            };
            (cameras, numbers.filter(possible))
        }
    };
    let cameras = cameras.parse().ok().filter(|cameras| (1..=MAX_CAMERAS).contains(cameras));
    match (cameras, size) {
        (Some(cameras), Some(size)) => Ok(Viewpoints::Sphere { cameras, size }),
        (None, _) => Err(format!(
            "must be sphere:N or sphere:N:WxH, with a number N of cameras from 1 to {MAX_CAMERAS}"
        )),
        (_, None) => Err(format!(
            "the size of the images must be WxH, such as 640x480, of 1 to {MAX_PIXELS} pixels"
        )),
    }
}
