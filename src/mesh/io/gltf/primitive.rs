//! The triangles of a primitive.
//!
//! ```text
//! 4  triangles  (c_3i, c_3i+1, c_3i+2)
//! 5  strip      (c_i, c_i+1, c_i+2) for even i, (c_i, c_i+2, c_i+1) for odd i
//! 6  fan        (c_0, c_i, c_i+1), i >= 1
//! ```
//!
//! Modes 0 to 3 are points and lines.
//!
//! Reference: Khronos Group, *glTF 2.0 Specification*, section 3.7.2.1, "Overview" of meshes.

use crate::mesh::io::rules::fan;

/// How corners make faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mode {
    /// Points or lines: no faces.
    Thin,
    Triangles,
    Strip,
    Fan,
}

impl Mode {
    pub fn of(code: u32) -> Option<Self> {
        match code {
            0..=3 => Some(Mode::Thin),
            4 => Some(Mode::Triangles),
            5 => Some(Mode::Strip),
            6 => Some(Mode::Fan),
            _ => None,
        }
    }

    /// The faces of the corners; a message if triangles are incomplete.
    pub fn faces(self, corners: &[u32]) -> Result<Vec<[u32; 3]>, String> {
        match self {
            Mode::Thin => Ok(Vec::new()),
            Mode::Triangles => match corners.as_chunks::<3>() {
                (faces, []) => Ok(faces.to_vec()),
                _ => {
                    Err(format!("the number of corners, {}, is not a multiple of 3", corners.len()))
                }
            },
            Mode::Strip => Ok(strip(corners)),
            Mode::Fan => Ok(fan(corners).collect()),
        }
    }
}

/// A repeated index is a stitch between strips.
fn strip(corners: &[u32]) -> Vec<[u32; 3]> {
    let turned = corners.windows(3).enumerate().map(|(i, corners)| match i % 2 {
        0 => [corners[0], corners[1], corners[2]],
        _ => [corners[0], corners[2], corners[1]],
    });
    turned.filter(|[a, b, c]| a != b && b != c && c != a).collect()
}
