//! Wavefront OBJ, the polygonal part.
//!
//! ```text
//! v  x y z [w] | v x y z r g b [a]     a vertex, maybe with a color in [0, 1]
//! vt u [v [w]]                         a texture coordinate
//! f  v[/[vt][/vn]] ...                 a polygon; indices count from 1, or back from the latest by -1, -2, ...
//! ```
//!
//! Normals, groups, materials, points, lines and free-form surfaces are skipped. A texture coordinate
//! belongs to the corner of a face, so seams split no vertex. Colors and texture coordinates count only if
//! every vertex (every face) has them. The reader is our own because those of the ecosystem renumber the
//! vertices and split them at seams, which breaks per-vertex labels and the total variation.
//!
//! Reference: Wavefront Technologies, *Advanced Visualizer Manual*, appendix B1, "Object Files".

use std::collections::HashMap;
use std::io::{self, Write};
use std::path::Path;

use nalgebra::Point3;

use super::text::{Text, parse_integer, quote};
use super::{check_color, check_texture, coordinates, fan, uv_of_vertices};
use crate::error::{Error, Result};
use crate::mesh::Mesh;

/// A corner without a texture coordinate.
const NONE: u32 = u32::MAX;

/// Whether one of the first lines with content defines a vertex.
pub fn recognizes(bytes: &[u8]) -> bool {
    const LINES: usize = 100;
    let mut text = Text::new(Path::new(""), bytes).with_comments();
    (0..LINES).any(|_| text.next_line() && text.token() == Some(b"v"))
}

pub fn parse(path: &Path, bytes: &[u8]) -> Result<Mesh> {
    let mut text = Text::new(path, bytes)
        .with_comments()
        .with_continued_lines();
    let mut vertices = Vec::new();
    let mut colors = Vec::new();
    let mut textures = Vec::new();
    let mut faces = Vec::new();
    let mut texture_faces: Vec<[u32; 3]> = Vec::new();
    let mut corners = Vec::new();
    let mut texture_corners = Vec::new();
    let mut some_textured = false;
    let mut vertex_range = References::default();
    let mut texture_range = References::default();

    while text.next_line() {
        match text.token() {
            Some(b"v") => {
                vertices.push(position(&mut text)?);
                colors.extend(color(&mut text)?);
            }
            Some(b"vt") => textures.push(texture(&mut text)?),
            Some(b"f" | b"fo") => {
                corners.clear();
                texture_corners.clear();
                while let Some(token) = text.token() {
                    let mut indices = token.split(|&b| b == b'/');
                    let vertex = indices.next().unwrap_or_default();
                    corners.push(vertex_range.resolve(&text, vertex, vertices.len(), "vertex")?);
                    texture_corners.push(match indices.next() {
                        None | Some(b"") => NONE,
                        Some(index) => texture_range.resolve(&text, index, textures.len(), "vt")?,
                    });
                }
                if corners.len() < 3 {
                    let n = corners.len();
                    return Err(text.error(format!("a face needs 3 corners, this one has {n}")));
                }
                // Once a face comes without, the others' texture coordinates do not count either.
                let complete = !texture_corners.contains(&NONE);
                some_textured |= complete;
                if complete && texture_faces.len() == faces.len() {
                    texture_faces.extend(fan(&texture_corners));
                }
                faces.extend(fan(&corners));
            }
            Some(keyword) if !keyword[0].is_ascii_alphabetic() => {
                return Err(text.error(format!(
                    "expected a statement such as v or f, not {}",
                    quote(keyword)
                )));
            }
            _ => {}
        }
    }

    vertex_range.check(path, vertices.len(), "vertex", "vertices")?;
    texture_range.check(path, textures.len(), "vt", "vt lines")?;
    let all_textured = texture_faces.len() == faces.len();
    if some_textured && !all_textured {
        tracing::warn!(
            "{}: only some faces have texture coordinates; they are ignored",
            path.display()
        );
    }
    if !colors.is_empty() && colors.len() < vertices.len() {
        tracing::warn!(
            "{}: only some vertices have colors; they are ignored",
            path.display()
        );
    }
    Ok(Mesh {
        colors: (!colors.is_empty() && colors.len() == vertices.len()).then_some(colors),
        uv: all_textured.then(|| uv_of_vertices(&texture_faces, &textures)),
        vertices,
        faces,
    })
}

fn position(text: &mut Text) -> Result<Point3<f64>> {
    Ok(Point3::new(
        text.coordinate()?,
        text.coordinate()?,
        text.coordinate()?,
    ))
}

/// What follows a position: nothing, a weight, a color, or a color with its opacity.
fn color(text: &mut Text) -> Result<Option<[f64; 3]>> {
    let mut values = [0.0; 4];
    let mut count = 0;
    while let Some(token) = text.token() {
        let value = text.number_of(token, "a weight or a color component")?;
        *values
            .get_mut(count)
            .ok_or_else(|| text.error("a vertex has at most 7 values"))? = value;
        count += 1;
    }
    match count {
        0 | 1 => Ok(None),
        2 => Err(text.error("a color component is missing")),
        _ => {
            let mut color = [0.0; 3];
            for (c, &value) in color.iter_mut().zip(&values) {
                *c = check_color(value).map_err(|message| text.error(message))?;
            }
            Ok(Some(color))
        }
    }
}

fn texture(text: &mut Text) -> Result<[f64; 2]> {
    let u = text.number("a texture coordinate")?;
    let v = match text.token() {
        Some(token) => text.number_of(token, "a texture coordinate")?,
        None => 0.0,
    };
    for t in [u, v] {
        check_texture(t).map_err(|message| text.error(message))?;
    }
    Ok([u, v])
}

/// The largest index that was referred to, and where: the vertex may follow later in the file.
#[derive(Default)]
struct References {
    largest: Option<u32>,
    line: usize,
}

impl References {
    /// An index from 0 of what a token means when `defined` vertices came before it.
    #[inline]
    fn resolve(&mut self, text: &Text, token: &[u8], defined: usize, what: &str) -> Result<u32> {
        let index = parse_integer(token).ok_or_else(|| {
            text.error(format!(
                "expected a {what} index, a whole number, not {}",
                quote(token)
            ))
        })?;
        let from_zero = match index {
            1.. => index - 1,
            0 => return Err(text.error(format!("a {what} index is 0; indices count from 1"))),
            _ => index.saturating_add(defined as i64),
        };
        let resolved = u32::try_from(from_zero)
            .ok()
            .filter(|&k| k != NONE)
            .ok_or_else(|| {
                text.error(format!(
                    "refers to {what} {index}, but {defined} are defined here"
                ))
            })?;
        if self.largest.is_none_or(|largest| largest < resolved) {
            self.largest = Some(resolved);
            self.line = text.line();
        }
        Ok(resolved)
    }

    fn check(&self, path: &Path, defined: usize, what: &str, all: &str) -> Result<()> {
        match self.largest {
            Some(largest) if largest as usize >= defined => Err(Error::malformed_line(
                path,
                self.line,
                format!(
                    "refers to {what} {}, but the file has {defined} {all}",
                    u64::from(largest) + 1
                ),
            )),
            _ => Ok(()),
        }
    }
}

/// Numbers are written with the fewest digits that read back to the same bits.
pub fn write(out: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    for (k, x) in mesh.vertices.iter().enumerate() {
        let [x, y, z] = coordinates(x);
        write!(out, "v {x} {y} {z}")?;
        if let Some(colors) = &mesh.colors {
            let [r, g, b] = colors[k];
            write!(out, " {r} {g} {b}")?;
        }
        writeln!(out)?;
    }
    let Some(uv) = &mesh.uv else {
        for face in &mesh.faces {
            let [a, b, c] = face.map(|k| u64::from(k) + 1);
            writeln!(out, "f {a} {b} {c}")?;
        }
        return Ok(());
    };
    let mut index_of = HashMap::new();
    for &[u, v] in uv.iter().flatten() {
        let next = index_of.len() + 1;
        if let std::collections::hash_map::Entry::Vacant(entry) =
            index_of.entry([u.to_bits(), v.to_bits()])
        {
            entry.insert(next);
            writeln!(out, "vt {u} {v}")?;
        }
    }
    for (face, uv) in mesh.faces.iter().zip(uv) {
        write!(out, "f")?;
        for (&k, t) in face.iter().zip(uv) {
            write!(
                out,
                " {}/{}",
                u64::from(k) + 1,
                index_of[&t.map(f64::to_bits)]
            )?;
        }
        writeln!(out)?;
    }
    Ok(())
}
