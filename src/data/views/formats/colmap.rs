//! COLMAP models as text:
//!
//! ```text
//! cameras.txt   CAMERA_ID MODEL WIDTH HEIGHT PARAMETERS...
//! images.txt    IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME     and a line of points after each
//! ```
//!
//! The quaternion and t are those of R x + t. **The center of the first pixel is (1/2, 1/2)**, so 1/2 is subtracted from
//! the principal point. Reference: J. Schönberger, J.-M. Frahm, *Structure-from-motion revisited*, CVPR 2016, and the
//! manual of COLMAP.

use std::collections::HashMap;
use std::path::Path;

use nalgebra::{Quaternion, UnitQuaternion};

use super::numbers::numbers;
use crate::data::views::view::{View, camera};
use crate::error::{Error, Result};
use crate::file;

/// Models, the number of their focal lengths, and that of the lens parameters after the principal point.
const MODELS: [(&str, usize, usize); 9] = [
    ("SIMPLE_PINHOLE", 1, 0),
    ("PINHOLE", 2, 0),
    ("SIMPLE_RADIAL", 1, 1),
    ("RADIAL", 1, 2),
    ("OPENCV", 2, 4),
    ("FULL_OPENCV", 2, 8),
    ("SIMPLE_RADIAL_FISHEYE", 1, 1),
    ("RADIAL_FISHEYE", 1, 2),
    ("OPENCV_FISHEYE", 2, 4),
];

/// Image size and K of a camera.
type Intrinsics = ([u32; 2], [f64; 9]);

/// The views of the model in a folder.
pub fn read(folder: &Path) -> Result<Vec<View>> {
    let cameras = cameras(&folder.join("cameras.txt"))?;
    let path = &folder.join("images.txt");
    let text = text(path)?;
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.starts_with('#'));
    let mut views = Vec::new();
    while let Some((i, line)) = lines.next() {
        if line.trim().is_empty() {
            continue;
        }
        let wrong = |message: &str| Error::malformed_line(path, i + 1, message);
        let needs = "needs IMAGE_ID, QW QX QY QZ, TX TY TZ, CAMERA_ID and NAME";
        let mut words = line.split_whitespace();
        let id = words.next().and_then(|word| word.parse::<u64>().ok());
        let (q, t) = (numbers::<4>(&mut words), numbers::<3>(&mut words));
        let (Some(_), Some(q), Some(t), Some(of)) = (id, q, t, words.next()) else {
            return Err(wrong(needs));
        };
        let Some(name) = after_words(line, 9) else { return Err(wrong(needs)) };
        let Some(&(size, k)) = cameras.get(of) else {
            return Err(wrong(&format!("camera {of} is not in cameras.txt")));
        };
        let q = Quaternion::new(q[0], q[1], q[2], q[3]);
        let Some(q) = UnitQuaternion::try_new(q, 1e-6) else {
            return Err(wrong("the quaternion is zero"));
        };
        let r = q.to_rotation_matrix();
        let rows = std::array::from_fn(|i| r[(i / 3, i % 3)]);
        let camera = camera(path, name, k, rows, t)?;
        views.push(View {
            image: name.to_owned(),
            mask: None,
            background: None,
            size: Some(size),
            camera,
        });
        lines.next();
    }
    Ok(views)
}

/// What follows the first n words of a line, if anything does: names may have blanks.
fn after_words(line: &str, n: usize) -> Option<&str> {
    let mut rest = line.trim();
    for _ in 0..n {
        rest = rest.split_once(char::is_whitespace)?.1.trim_start();
    }
    Some(rest)
}

fn cameras(path: &Path) -> Result<HashMap<String, Intrinsics>> {
    let mut cameras = HashMap::new();
    for (i, line) in text(path)?.lines().enumerate() {
        if line.starts_with('#') || line.trim().is_empty() {
            continue;
        }
        let wrong = |message: &str| Error::malformed_line(path, i + 1, message);
        let words: Vec<&str> = line.split_whitespace().collect();
        let [id, name, width, height, parameters @ ..] = &words[..] else {
            return Err(wrong("needs CAMERA_ID, MODEL, WIDTH, HEIGHT and parameters"));
        };
        let (Ok(width), Ok(height)) = (width.parse(), height.parse()) else {
            return Err(wrong("the width and the height must be numbers of pixels"));
        };
        let undistort = "undistort the images with `colmap image_undistorter`";
        let Some((_, focal, lens)) = MODELS.iter().find(|(model, ..)| model == name) else {
            let message = format!("the camera model {name} has lens distortion; {undistort}");
            return Err(wrong(&message));
        };
        let values: Option<Vec<f64>> = parameters.iter().map(|word| word.parse().ok()).collect();
        let Some(values) = values.filter(|values| values.len() == focal + 2 + lens) else {
            let message = format!("the camera model {name} needs {} parameters", focal + 2 + lens);
            return Err(wrong(&message));
        };
        if name.ends_with("FISHEYE") || values[focal + 2..].iter().any(|&x| x != 0.0) {
            let message = format!("camera {id} ({name}) has lens distortion; {undistort}");
            return Err(wrong(&message));
        }
        let (fx, fy) = (values[0], values[focal - 1]);
        let [cx, cy] = [values[*focal] - 0.5, values[focal + 1] - 0.5];
        let k = [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0];
        cameras.insert((*id).to_owned(), ([width, height], k));
    }
    Ok(cameras)
}

fn text(path: &Path) -> Result<String> {
    let bytes = file::read(path)?;
    String::from_utf8(bytes).map_err(|_| Error::malformed(path, "is not text"))
}
