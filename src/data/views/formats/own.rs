//! The file of views of this program, in TOML:
//!
//! ```text
//! [[view]]
//! image = "a.png"                # relative to this file
//! mask = "a_mask.png"            # optional: bright where the pixels count
//! background = "a_empty.png"     # optional: what is behind the surface, for reconstructions
//! width = 640                    # optional, checked against the image
//! height = 480
//! K = [525.0, 0.0, 319.5, 0.0, 525.0, 239.5, 0.0, 0.0, 1.0]
//! R = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
//! t = [0.0, 0.0, 3.0]
//! ```
//!
//! Matrices are row by row. Numbers are written with all their digits, so that a file gives back the same cameras.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::data::views::view::{View, camera};
use crate::error::{Error, Result};

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Document {
    view: Vec<Entry>,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    image: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    mask: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    background: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    width: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    height: Option<u32>,
    #[serde(rename = "K")]
    k: [f64; 9],
    #[serde(rename = "R")]
    r: [f64; 9],
    t: [f64; 3],
}

/// The views of a text.
pub fn read(path: &Path, text: &str) -> Result<Vec<View>> {
    let document: Document = toml::from_str(text).map_err(|error| {
        let start = error.span().map_or(0, |span| span.start.min(text.len()));
        let line = 1 + text.as_bytes()[..start].iter().filter(|&&byte| byte == b'\n').count();
        Error::malformed_line(path, line, error.message().replace('\n', " "))
    })?;
    let view = |entry: Entry| {
        let Entry { image, mask, background, width, height, k, r, t } = entry;
        let camera = camera(path, &image, k, r, t)?;
        let size = match (width, height) {
            (Some(width), Some(height)) => Some([width, height]),
            (None, None) => None,
            _ => {
                let message = format!("the view {image} needs both width and height, or neither");
                return Err(Error::malformed(path, message));
            }
        };
        Ok(View { image, mask, background, size, camera })
    };
    document.view.into_iter().map(view).collect()
}

/// The text of a file of these views.
pub fn write(views: &[View]) -> String {
    let entry = |view: &View| {
        let View { image, mask, background, size, camera } = view.clone();
        let ([width, height], (k, r, t)) =
            (size.map_or([None; 2], |n| n.map(Some)), camera.numbers());
        Entry { image, mask, background, width, height, k, r, t }
    };
    let document = Document { view: views.iter().map(entry).collect() };
    toml::to_string(&document).expect("names and numbers can be written")
}
