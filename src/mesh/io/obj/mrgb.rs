//! Vertex colors in comments of an OBJ file, as sculpting programs write them: `#MRGB` followed by 8 hexadecimal digits
//! per vertex (mask, red, green, blue), many vertices per line, in the order of the vertices.

use std::path::Path;

use crate::counted::counted;
use crate::mesh::io::occurrences::{Occurrences, warn};

pub const KEYWORD: &[u8] = b"#MRGB";

#[derive(Default)]
pub struct MrgbColors {
    colors: Vec<[f64; 3]>,
    invalid: Occurrences,
}

impl MrgbColors {
    /// Reads the colors after the keyword on one line.
    pub fn read(&mut self, remark: &[u8], location: impl FnOnce() -> String) {
        let digits: Vec<u8> =
            remark.iter().copied().filter(|digit| !digit.is_ascii_whitespace()).collect();
        let (entries, rest) = digits.as_chunks::<8>();
        if !rest.is_empty() || !digits.iter().all(u8::is_ascii_hexdigit) {
            self.invalid.add(location);
            return;
        }
        let value = |digit: u8| f64::from(char::from(digit).to_digit(16).unwrap_or_default());
        self.colors.extend(entries.iter().map(|entry| {
            [2, 4, 6].map(|i| (16.0 * value(entry[i]) + value(entry[i + 1])) / 255.0)
        }));
    }

    /// The colors of the given number of vertices; NaN after the end of the comments.
    pub fn finish(mut self, path: &Path, vertices: usize) -> Option<Vec<[f64; 3]>> {
        if !self.invalid.is_empty() {
            self.invalid.warn(
                path,
                "the colors in #MRGB comments are left out because some do not have 8 hexadecimal digits",
            );
            return None;
        }
        if self.colors.is_empty() {
            return None;
        }
        let colors = self.colors.len();
        if colors != vertices {
            warn(
                path,
                &format!(
                    "has {} in #MRGB comments for {}; vertices without a color are unknown",
                    counted(colors, "color", "colors"),
                    counted(vertices, "vertex", "vertices")
                ),
            );
        }
        self.colors.resize(vertices, [f64::NAN; 3]);
        Some(self.colors)
    }
}
