//! The argument of `render --views`: viewpoints of pictures, or cameras of photographs.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::data::views::CamerasAround;
use crate::render::Views;

/// Where a mesh is seen from.
#[derive(Clone)]
pub enum Viewpoints {
    /// Those of a picture.
    Named(Views),
    /// `sphere:N` or `sphere:N:WxH`.
    Sphere(CamerasAround),
    /// The cameras of a file.
    File(PathBuf),
}

impl FromStr for Viewpoints {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some(sphere) = text.strip_prefix("sphere:") {
            let cameras = sphere
                .parse()
                .map_err(|error| format!("must be sphere:N or sphere:N:WxH: {error}"));
            return cameras.map(Viewpoints::Sphere);
        }
        match text.parse() {
            Ok(views) => Ok(Viewpoints::Named(views)),
            Err(_) if Path::new(text).exists() => Ok(Viewpoints::File(text.into())),
            Err(error) => Err(format!("{error}; or cameras: sphere:N, or a file that exists")),
        }
    }
}
