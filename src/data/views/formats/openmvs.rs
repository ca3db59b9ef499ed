//! The interface files of OpenMVS (`.mvs`, `MVSI`), versions 1 to 7, little-endian:
//!
//! ```text
//! "MVSI", u32 version, u32 0
//! platforms   name; cameras: name, [band: > 3], u32 width, height, K, R, C; poses: R, C
//! images      name, [mask: > 4], u32 platform, camera, pose, [u32 number: > 2], [3 f32, views of (u32, u32, 5 f32): > 6]
//! ```
//!
//! and points, which are not read. Lists and texts begin with a u64 count; matrices are 9 f64 row by row. A camera at C_c,
//! R_c on a platform at C_p, R_p has R = R_c R_p and the center R_p^T C_c + C_p. Pixel centers have integer coordinates.
//! Reference: D. Cernea, OpenMVS, `libs/MVS/Interface.h`.

use std::path::Path;

use nalgebra::{Matrix3, Vector3};

use crate::counted::counted;
use crate::data::views::view::{View, camera};
use crate::error::{Error, Result};

/// The pose of an image that was not registered.
const NO_POSE: u32 = u32::MAX;

const NEWEST_VERSION: u32 = 7;

struct Camera {
    size: [u32; 2],
    k: [f64; 9],
    r: [f64; 9],
    c: [f64; 3],
}

struct Platform {
    cameras: Vec<Camera>,
    poses: Vec<([f64; 9], [f64; 3])>,
}

/// The views with a pose, and a warning about others.
pub fn read(path: &Path, bytes: &[u8]) -> Result<(Vec<View>, Vec<String>)> {
    let cut_off = || Error::malformed(path, "is cut off; copy or export it again");
    let mut rest = Bytes(&bytes[4..]);
    let version = rest.u32().ok_or_else(cut_off)?;
    if !(1..=NEWEST_VERSION).contains(&version) {
        let message = format!(
            "has version {version} of the OpenMVS interface; versions 1 to {NEWEST_VERSION} can be read"
        );
        return Err(Error::malformed(path, message));
    }
    let platforms = rest.u32().and_then(|_| rest.list(|rest| platform(rest, version)));
    let platforms = platforms.ok_or_else(cut_off)?;
    let images = rest.list(|rest| image(rest, version)).ok_or_else(cut_off)?;
    let (mut views, mut without_pose) = (Vec::new(), 0);
    for Image { name, mask, at: [of, number, pose] } in images {
        if pose == NO_POSE {
            without_pose += 1;
            continue;
        }
        let platform = platforms.get(of as usize);
        let found = platform.and_then(|platform| {
            Some((platform.cameras.get(number as usize)?, platform.poses.get(pose as usize)?))
        });
        let Some((on_platform, &(r, c))) = found else {
            let message =
                format!("the image {name} refers to a camera or a pose that does not exist");
            return Err(Error::malformed(path, message));
        };
        let &Camera { size, k, r: on_r, c: on_c } = on_platform;
        if size.contains(&0) {
            let message = format!(
                "the camera of {name} has no image size, so that its K is not in pixels; export the scene with sizes"
            );
            return Err(Error::malformed(path, message));
        }
        let [on_r, r] = [on_r, r].map(|r| Matrix3::from_row_slice(&r));
        let center = r.transpose() * Vector3::from(on_c) + Vector3::from(c);
        let r = on_r * r;
        let t = -(r * center);
        let rows: [f64; 9] = std::array::from_fn(|i| r[(i / 3, i % 3)]);
        let camera = camera(path, &name, k, rows, t.into())?;
        views.push(View { image: name, mask, background: None, size: Some(size), camera });
    }
    let warning = (without_pose > 0).then(|| {
        format!(
            "{}: {} no pose and {} left out",
            path.display(),
            counted(without_pose, "image has", "images have"),
            if without_pose == 1 { "is" } else { "are" }
        )
    });
    Ok((views, warning.into_iter().collect()))
}

fn platform(rest: &mut Bytes, version: u32) -> Option<Platform> {
    rest.text()?;
    let camera = |rest: &mut Bytes| {
        rest.text()?;
        if version > 3 {
            rest.text()?;
        }
        let size = [rest.u32()?, rest.u32()?];
        Some(Camera { size, k: rest.numbers()?, r: rest.numbers()?, c: rest.numbers()? })
    };
    let cameras = rest.list(camera)?;
    let poses = rest.list(|rest| Some((rest.numbers()?, rest.numbers()?)))?;
    Some(Platform { cameras, poses })
}

struct Image {
    name: String,
    mask: Option<String>,
    /// Platform, camera, pose.
    at: [u32; 3],
}

fn image(rest: &mut Bytes, version: u32) -> Option<Image> {
    let name = rest.text()?;
    let mask = if version > 4 { Some(rest.text()?).filter(|mask| !mask.is_empty()) } else { None };
    let at = [rest.u32()?, rest.u32()?, rest.u32()?];
    if version > 2 {
        rest.u32()?;
    }
    if version > 6 {
        rest.take(12)?;
        rest.list(|rest| rest.take(28).map(drop))?;
    }
    Some(Image { name, mask, at })
}

/// What is left to read; every method is `None` at the end.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn u32(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(self.take(4)?.try_into().ok()?))
    }

    fn count(&mut self) -> Option<usize> {
        usize::try_from(u64::from_le_bytes(self.take(8)?.try_into().ok()?)).ok()
    }

    fn numbers<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = f64::from_le_bytes(self.take(8)?.try_into().ok()?);
        }
        Some(numbers)
    }

    fn text(&mut self) -> Option<String> {
        let count = self.count()?;
        Some(String::from_utf8_lossy(self.take(count)?).into_owned())
    }

    /// Each item takes bytes, so that a count that is too large ends with the file.
    fn list<T>(&mut self, item: impl Fn(&mut Self) -> Option<T>) -> Option<Vec<T>> {
        let count = self.count()?;
        let mut items = Vec::new();
        for _ in 0..count {
            items.push(item(self)?);
        }
        Some(items)
    }
}
