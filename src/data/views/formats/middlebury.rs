//! The camera files of the Middlebury multi-view benchmark, `*_par.txt`: the number of views, then a line per view,
//!
//! ```text
//! NAME k11 k12 k13 k21 .. k33 r11 .. r33 t1 t2 t3
//! ```
//!
//! with the projection K [R t] and the origin at the upper left. They have no image sizes. Reference: S. Seitz, B.
//! Curless, J. Diebel, D. Scharstein, R. Szeliski, *A comparison and evaluation of multi-view stereo reconstruction
//! algorithms*, CVPR 2006.

use std::path::Path;

use super::numbers::numbers;
use crate::data::views::view::{View, camera};
use crate::error::{Error, Result};

/// The views of a text whose first line declares their number.
pub fn read(path: &Path, text: &str, count: usize) -> Result<Vec<View>> {
    let mut views = Vec::new();
    for (i, line) in text.lines().enumerate().skip(1) {
        let mut words = line.split_whitespace();
        let Some(image) = words.next() else { continue };
        let (k, r, t) = (numbers(&mut words), numbers(&mut words), numbers(&mut words));
        let (Some(k), Some(r), Some(t), None) = (k, r, t, words.next()) else {
            return Err(Error::malformed_line(
                path,
                i + 1,
                "needs the name of an image and 21 finite numbers: K, R (row by row) and t",
            ));
        };
        let camera = camera(path, image, k, r, t)?;
        views.push(View {
            image: image.to_owned(),
            mask: None,
            background: None,
            size: None,
            camera,
        });
    }
    if views.len() != count {
        return Err(Error::malformed(
            path,
            format!("declares {count} views but has {}; the file may be cut off", views.len()),
        ));
    }
    Ok(views)
}
