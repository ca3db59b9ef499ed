//! OFF, the Object File Format of Geomview.
//!
//! ```text
//! [ST][C][N]OFF                                    # what each vertex has besides its position
//! V F [E]                                          # may stand on the line of the keyword
//! x y z [nx ny nz] [r g b [a]] [s t]               # V lines
//! n i_1 ... i_n [color]                            # F polygons; indices from 0; their colors are skipped
//! ```
//!
//! Vertex colors are floats in [0, 1] or integers up to 255: the latter if any component is above 1.
//!
//! Reference: Geomview manual, section "OFF: Object File Format".

use std::io::{self, Write};
use std::path::Path;

use nalgebra::Point3;

use super::text::{Text, quote};
use super::{check_color, check_texture, coordinates, fan, uv_of_vertices};
use crate::error::{Error, Result};
use crate::mesh::Mesh;

/// What a vertex line holds, after the keyword of the file.
#[derive(Clone, Copy, Default, Debug, PartialEq)]
struct Layout {
    texture: bool,
    color: bool,
    normal: bool,
}

impl Layout {
    /// Of `OFF` and its prefixes. They come as `STCN`, but some programs write `NC`.
    fn parse(keyword: &[u8]) -> Option<Self> {
        let mut prefix = keyword.strip_suffix(b"OFF")?;
        let mut layout = Layout::default();
        if let Some(rest) = prefix.strip_prefix(b"ST") {
            layout.texture = true;
            prefix = rest;
        }
        for letter in prefix {
            match letter {
                b'C' if !layout.color => layout.color = true,
                b'N' if !layout.normal => layout.normal = true,
                _ => return None,
            }
        }
        Some(layout)
    }
}

/// Whether the first token is the keyword.
pub fn recognizes(bytes: &[u8]) -> bool {
    let mut text = Text::new(Path::new(""), bytes).with_comments();
    text.next_line() && text.token().and_then(Layout::parse).is_some()
}

pub fn parse(path: &Path, bytes: &[u8]) -> Result<Mesh> {
    let mut text = Text::new(path, bytes).with_comments();
    text.next_line();
    let keyword = text.token().unwrap_or_default();
    let layout = Layout::parse(keyword).ok_or_else(|| {
        let dimensions = keyword.ends_with(b"nOFF") || keyword.ends_with(b"4OFF");
        text.error(if dimensions {
            format!("{}: only three dimensions are supported", quote(keyword))
        } else {
            format!("expected OFF, not {}; this is no OFF file", quote(keyword))
        })
    })?;
    let (vertex_count, face_count) = counts(&mut text)?;

    let mut positions = Vec::with_capacity(room(&text, vertex_count));
    let mut colors: Vec<[f64; 3]> = Vec::new();
    let mut uv: Vec<[f64; 2]> = Vec::new();
    let mut values = Vec::new();
    for k in 0..vertex_count {
        expect_line(&mut text, k, vertex_count, "vertices")?;
        positions.push(Point3::new(text.coordinate()?, text.coordinate()?, text.coordinate()?));
        values.clear();
        if layout.normal {
            for _ in 0..3 {
                text.expect_token("a normal")?;
            }
        }
        while let Some(token) = text.token() {
            values.push(text.number_of(token, "a value")?);
        }
        let mut rest = values.as_slice();
        if layout.texture {
            let Some((before, &[s, t])) = rest.split_last_chunk() else {
                return Err(text.error("a texture coordinate is missing"));
            };
            uv.push(texture(s, t).map_err(|message| text.error(message))?);
            rest = before;
        }
        match (layout.color, rest) {
            (true, &[r, g, b] | &[r, g, b, _]) => colors.push([r, g, b]),
            (true, _) => return Err(text.error("expected a color of 3 or 4 components")),
            (false, []) => {}
            (false, _) => {
                return Err(text.error(format!(
                    "{} values too many; with vertex colors the keyword is COFF",
                    rest.len()
                )));
            }
        }
    }

    let mut faces = Vec::with_capacity(room(&text, face_count));
    let mut polygon = Vec::new();
    for j in 0..face_count {
        expect_line(&mut text, j, face_count, "faces")?;
        let n = text.integer("a number of corners")?;
        if n < 3 {
            return Err(text.error(format!("a face needs 3 corners, this one has {n}")));
        }
        polygon.clear();
        for _ in 0..n {
            let k = text.integer("a vertex index")?;
            if !(0..vertex_count as i64).contains(&k) {
                return Err(text.error(format!(
                    "refers to vertex {k}, but the file has {vertex_count} vertices, counted from 0"
                )));
            }
            polygon.push(k as u32);
        }
        faces.extend(fan(&polygon));
    }
    if text.next_line() {
        return Err(text.error("more lines than the vertices and faces declared"));
    }
    Ok(Mesh {
        uv: layout.texture.then(|| uv_of_vertices(&faces, &uv)),
        colors: if layout.color { Some(normalize(path, colors)?) } else { None },
        vertices: positions,
        faces,
        ..Mesh::default()
    })
}

/// V and F; the number of edges after them says nothing and may be missing.
fn counts(text: &mut Text) -> Result<(usize, usize)> {
    let first = match text.token() {
        Some(b"BINARY") => {
            return Err(text.error("binary OFF is not supported; write it as text, or as PLY"));
        }
        Some(token) => token,
        None if text.next_line() => text.expect_token("the number of vertices")?,
        None => return Err(text.error("the file ends before the number of vertices")),
    };
    let second = text.expect_token("the number of faces")?;
    let count = |token: &[u8]| {
        std::str::from_utf8(token)
            .ok()
            .and_then(|token| token.parse::<usize>().ok())
            .ok_or_else(|| text.error(format!("{} is no number of elements", quote(token))))
    };
    let (vertices, faces) = (count(first)?, count(second)?);
    if u32::try_from(vertices).is_err() {
        return Err(text.error(format!("{vertices} vertices; at most 2^32 - 1 are possible")));
    }
    if text.token().is_some() {
        text.expect_end_of_line()?;
    }
    Ok((vertices, faces))
}

/// For how many lines memory may be taken at once.
fn room(text: &Text, count: usize) -> usize {
    const SHORTEST_LINE: usize = 6;
    count.min(text.remaining() / SHORTEST_LINE + 1)
}

fn expect_line(text: &mut Text, read: usize, count: usize, what: &str) -> Result<()> {
    if text.next_line() {
        Ok(())
    } else {
        Err(text.error(format!("the file ends after {read} of {count} {what}")))
    }
}

fn texture(s: f64, t: f64) -> std::result::Result<[f64; 2], String> {
    Ok([check_texture(s)?, check_texture(t)?])
}

/// Colors in [0, 1] from either convention.
fn normalize(path: &Path, mut colors: Vec<[f64; 3]>) -> Result<Vec<[f64; 3]>> {
    let components = colors.as_flattened_mut();
    let bytes = components.iter().any(|&c| check_color(c).is_err() && c > 1.0);
    let full = if bytes { 255.0 } else { 1.0 };
    for c in components {
        *c = check_color(*c / full).map_err(|message| Error::malformed(path, message))?;
    }
    Ok(colors)
}

/// Numbers are written with the fewest digits that read back to the same bits.
pub fn write(out: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    let keyword = if mesh.colors.is_some() { "COFF" } else { "OFF" };
    writeln!(out, "{keyword}\n{} {} 0", mesh.vertices.len(), mesh.faces.len())?;
    for (k, x) in mesh.vertices.iter().enumerate() {
        let [x, y, z] = coordinates(x);
        write!(out, "{x} {y} {z}")?;
        if let Some(colors) = &mesh.colors {
            let [r, g, b] = colors[k];
            write!(out, " {r} {g} {b} 1")?;
        }
        writeln!(out)?;
    }
    for [a, b, c] in &mesh.faces {
        writeln!(out, "3 {a} {b} {c}")?;
    }
    Ok(())
}
