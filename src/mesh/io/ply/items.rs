//! Single properties of an element, and error messages about them.

use super::header::{Element, Kind, Property};
use super::values::Values;
use crate::counted::counted;
use crate::error::{Error, Result};
use crate::mesh::io::colors::Colors;
use crate::mesh::io::scalar::Scalar;

pub fn skip_property(property: &Property, values: &mut impl Values) -> Result<()> {
    match property.kind {
        Kind::Scalar(scalar) => values.skip(scalar, 1),
        Kind::List { count, item } => {
            let n = list_length(values, count)?;
            values.skip(item, n)
        }
    }
}

pub fn list_length(values: &mut impl Values, count: Scalar) -> Result<u64> {
    let n = values.integer(count)?;
    u64::try_from(n)
        .map_err(|_| values.error(format!("a list has {n} items; the number must not be negative")))
}

/// The property names of colors.
const COLOR_NAMES: [[&str; 3]; 3] =
    [["red", "green", "blue"], ["r", "g", "b"], ["diffuse_red", "diffuse_green", "diffuse_blue"]];

/// The indices of the color properties of an element, and a collector for its colors.
pub fn colors_of(element: &Element) -> Option<([usize; 3], Colors)> {
    let found = element.first_complete(&COLOR_NAMES)?;
    let [r, g, b] = found.map(|(_, scalar)| scalar.full_intensity());
    let full = if r == g && g == b { r } else { None };
    Some((found.map(|(at, _)| at), Colors::new(full)))
}

/// A valid vertex index, or a message if it is not.
pub fn vertex_index(k: i64, vertices: usize) -> std::result::Result<u32, String> {
    u32::try_from(k).ok().filter(|&k| (k as usize) < vertices).ok_or_else(|| {
        format!(
            "refers to vertex {k}, but the file has {}, counted from 0",
            counted(vertices, "vertex", "vertices")
        )
    })
}

/// Prefixes a message with the element it is about, and its position.
pub fn wrong(values: &impl Values, what: &str, j: usize) -> impl Fn(String) -> Error {
    move |message| values.error(format!("{what} {j}: {message}"))
}
