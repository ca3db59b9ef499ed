//! Colors of sculpting programs, in comments of an OBJ file: `#MRGB` and 8 hexadecimal digits a vertex (mask, red,
//! green, blue), many vertices a line, in the order of the vertices.

use std::path::Path;

use crate::mesh::io::occurrences::{Occurrences, warn};

pub const KEYWORD: &[u8] = b"#MRGB";

#[derive(Default)]
pub struct Sculpted {
    colors: Vec<[f64; 3]>,
    wrong: Occurrences,
}

impl Sculpted {
    /// What follows the beginning on one line.
    pub fn read(&mut self, remark: &[u8], place: impl FnOnce() -> String) {
        let digits: Vec<u8> =
            remark.iter().copied().filter(|digit| !digit.is_ascii_whitespace()).collect();
        let (entries, rest) = digits.as_chunks::<8>();
        if !rest.is_empty() || !digits.iter().all(u8::is_ascii_hexdigit) {
            self.wrong.add(place);
            return;
        }
        let value = |digit: u8| f64::from(char::from(digit).to_digit(16).unwrap_or_default());
        self.colors.extend(entries.iter().map(|entry| {
            [2, 4, 6].map(|i| (16.0 * value(entry[i]) + value(entry[i + 1])) / 255.0)
        }));
    }

    /// Of that many vertices: NaN where the comments end early.
    pub fn finish(mut self, path: &Path, vertices: usize) -> Option<Vec<[f64; 3]>> {
        if !self.wrong.is_empty() {
            self.wrong.warn(
                path,
                "the colors in #MRGB comments are left out, some are not 8 hexadecimal digits",
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
                    "has {colors} colors in #MRGB comments for {vertices} vertices; vertices without one count as unknown"
                ),
            );
        }
        self.colors.resize(vertices, [f64::NAN; 3]);
        Some(self.colors)
    }
}
