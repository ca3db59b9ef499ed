//! Wavefront OBJ: its polygons, colors and materials.
//!
//! ```text
//! v  x y z [w] | v x y z r g b [a]     a vertex, maybe with a color in [0, 1] or up to 255
//! vt u [v [w]]                         a texture coordinate
//! f  v[/[vt][/vn]] ...                 a polygon; indices count from 1, or back from the latest by -1, -2, ...
//! mtllib FILE ...                      where materials are described
//! usemtl NAME                          the material of the faces that follow
//! #MRGB MMRRGGBBMMRRGGBB...            colors of vertices in their order, as sculpting programs write them
//! ```
//!
//! Normals, groups, points, lines and free-form surfaces are skipped. Texture coordinates belong to the corners of
//! faces, so seams split no vertex. Positions and faces must be valid; other invalid parts are left out with a warning.
//! We use our own reader because existing crates renumber vertices and split them at seams, which breaks per-vertex
//! labels and the total variation.
//!
//! Reference: Wavefront Technologies, *Advanced Visualizer Manual*, appendix B1, "Object Files".

mod faces;
mod mrgb;
mod mtl;
mod painting;
mod write;

use std::path::Path;

use nalgebra::Point3;

use self::faces::Faces;
use self::mrgb::MrgbColors;
use self::painting::Painting;
use super::colors::Colors;
use super::occurrences::Occurrences;
use super::text::{Text, parse_float, quote};
use super::{INVALID_TEXTURE, valid_uv};
use crate::error::Result;
use crate::mesh::Mesh;

pub use self::mtl::write as write_materials;
pub use self::write::write;

/// Whether one of the first nonempty lines defines a vertex.
pub fn recognizes(bytes: &[u8]) -> bool {
    const LINES_SEARCHED: usize = 100;
    let mut text = Text::new(Path::new(""), bytes).with_comments();
    (0..LINES_SEARCHED).any(|_| text.next_line() && text.token() == Some(b"v"))
}

/// `folder` contains the files of materials, if they may be read.
pub fn parse(path: &Path, folder: Option<&Path>, bytes: &[u8]) -> Result<Mesh> {
    let mut text =
        Text::new(path, bytes).with_comments().with_continued_lines().with_remarks(mrgb::KEYWORD);
    let mut vertices = Vec::new();
    let mut colors = Colors::new(None);
    let mut unexpected = Occurrences::default();
    let mut mrgb = MrgbColors::default();
    let mut textures = Vec::new();
    let mut invalid_uv = Occurrences::default();
    let mut faces = Faces::default();
    let mut painting = Painting::default();
    while text.next_line() {
        match text.token() {
            Some(b"v") => {
                let x = Point3::new(text.coordinate()?, text.coordinate()?, text.coordinate()?);
                match after_position(&mut text) {
                    AfterPosition::Nothing => {}
                    AfterPosition::Color(color) => {
                        colors.set(vertices.len(), color, || format!("line {}", text.line()));
                    }
                    AfterPosition::Unexpected => unexpected.add(|| format!("line {}", text.line())),
                }
                vertices.push(x);
            }
            Some(b"vt") => {
                let t = texture(&mut text);
                let location = || format!("line {}", text.line());
                textures.push(valid_uv(t, &mut invalid_uv, location));
            }
            Some(b"f" | b"fo") => faces.read(&mut text, vertices.len(), textures.len())?,
            Some(b"mtllib") => painting.library(text.rest_of_line()),
            Some(b"usemtl") => painting.begin(text.rest_of_line(), faces.count()),
            Some(keyword) if !keyword[0].is_ascii_alphabetic() => {
                return Err(text.error(format!(
                    "expected a statement such as v or f, not {}",
                    quote(keyword)
                )));
            }
            Some(_) => {}
            None => {
                if let Some(remark) = text.remark() {
                    mrgb.read(remark, || format!("line {}", text.line()));
                }
            }
        }
    }
    let (faces, uv) = faces.finish(path, &vertices, &textures)?;
    unexpected
        .warn(path, "values after positions that are neither a weight nor a color are left out");
    invalid_uv.warn(path, INVALID_TEXTURE);
    let colors = match colors.is_empty() {
        true => mrgb.finish(path, vertices.len()),
        false => colors.finish(path, vertices.len(), "vertices"),
    };
    let materials = painting.finish(path, folder, faces.len());
    Ok(Mesh { vertices, faces, colors, uv, materials, ..Mesh::default() })
}

enum AfterPosition {
    /// At most a weight.
    Nothing,
    Color([f64; 3]),
    Unexpected,
}

/// Reads what follows a position: nothing, a weight, a color, or a color with opacity.
fn after_position(text: &mut Text) -> AfterPosition {
    let mut values = [0.0; 4];
    let mut count = 0;
    let mut numbers = true;
    while let Some(token) = text.token() {
        let value = parse_float(token);
        numbers &= value.is_some();
        if let (Some(slot), Some(value)) = (values.get_mut(count), value) {
            *slot = value;
        }
        count += 1;
    }
    match (count, values) {
        (0, _) => AfterPosition::Nothing,
        (1, _) if numbers => AfterPosition::Nothing,
        (3 | 4, [r, g, b, _]) if numbers => AfterPosition::Color([r, g, b]),
        _ => AfterPosition::Unexpected,
    }
}

/// u and v; NaN if not a number.
fn texture(text: &mut Text) -> [f64; 2] {
    let u = text.token().and_then(parse_float).unwrap_or(f64::NAN);
    [u, text.token().map_or(Some(0.0), parse_float).unwrap_or(f64::NAN)]
}
