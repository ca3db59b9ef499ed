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

/// Whether one of the first lines with content defines a vertex.
pub fn recognizes(bytes: &[u8]) -> bool {
    const LINES: usize = 100;
    let mut text = Text::new(Path::new(""), bytes).with_comments();
    (0..LINES).any(|_| text.next_line() && text.token() == Some(b"v"))
}

pub fn parse(path: &Path, bytes: &[u8]) -> Result<Mesh> {
    let mut text = Text::new(path, bytes).with_comments().with_continued_lines();
    let mut vertices = Vec::new();
    let mut colors = Vec::new();
    let mut textures = Vec::new();
    let mut faces = Faces::default();
    while text.next_line() {
        match text.token() {
            Some(b"v") => {
                vertices.push(position(&mut text)?);
                colors.extend(color(&mut text)?);
            }
            Some(b"vt") => textures.push(texture(&mut text)?),
            Some(b"f" | b"fo") => faces.read(&mut text, vertices.len(), textures.len())?,
            Some(keyword) if !keyword[0].is_ascii_alphabetic() => {
                return Err(text.error(format!(
                    "expected a statement such as v or f, not {}",
                    quote(keyword)
                )));
            }
            _ => {}
        }
    }
    let uv = faces.uv(path, vertices.len(), &textures)?;
    let all_colored = colors.len() == vertices.len();
    if !all_colored && !colors.is_empty() {
        warn_incomplete(path, "vertices have colors");
    }
    Ok(Mesh {
        colors: (all_colored && !colors.is_empty()).then_some(colors),
        vertices,
        faces: faces.corners,
        uv,
        ..Mesh::default()
    })
}

fn warn_incomplete(path: &Path, what: &str) {
    tracing::warn!("{}: only some {what}; they are ignored", path.display());
}

fn position(text: &mut Text) -> Result<Point3<f64>> {
    Ok(Point3::new(text.coordinate()?, text.coordinate()?, text.coordinate()?))
}

/// What follows a position: nothing, a weight, a color, or a color with its opacity.
fn color(text: &mut Text) -> Result<Option<[f64; 3]>> {
    let mut values = [0.0; 4];
    let mut count = 0;
    while let Some(token) = text.token() {
        let value = text.number_of(token, "a weight or a color component")?;
        *values.get_mut(count).ok_or_else(|| text.error("a vertex has at most 7 values"))? = value;
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

/// The triangles so far.
#[derive(Default)]
struct Faces {
    corners: Vec<[u32; 3]>,
    /// Indices of texture coordinates, for as long as every face had them.
    textures: Vec<[u32; 3]>,
    some_textured: bool,
    vertex_references: References,
    texture_references: References,
    /// The polygon that is being read.
    polygon: Vec<u32>,
    polygon_textures: Vec<u32>,
}

impl Faces {
    /// One polygon, after that many vertices and texture coordinates.
    fn read(&mut self, text: &mut Text, vertices: usize, textures: usize) -> Result<()> {
        self.polygon.clear();
        self.polygon_textures.clear();
        while let Some(token) = text.token() {
            let mut indices = token.split(|&b| b == b'/');
            let vertex = indices.next().unwrap_or_default();
            let k = self.vertex_references.resolve(text, vertex, vertices, "vertex")?;
            self.polygon.push(k);
            if let Some(index) = indices.next().filter(|index| !index.is_empty()) {
                let t = self.texture_references.resolve(text, index, textures, "vt")?;
                self.polygon_textures.push(t);
            }
        }
        let n = self.polygon.len();
        if n < 3 {
            return Err(text.error(format!("a face needs 3 corners, this one has {n}")));
        }
        if self.polygon_textures.len() == n {
            self.some_textured = true;
            if self.textures.len() == self.corners.len() {
                self.textures.extend(fan(&self.polygon_textures));
            }
        }
        self.corners.extend(fan(&self.polygon));
        Ok(())
    }

    /// Texture coordinates per face corner, if every face has them. Checks all references.
    fn uv(
        &self,
        path: &Path,
        vertices: usize,
        textures: &[[f64; 2]],
    ) -> Result<Option<Vec<[[f64; 2]; 3]>>> {
        self.vertex_references.check(path, vertices, "vertex", "vertices")?;
        self.texture_references.check(path, textures.len(), "vt", "vt lines")?;
        let all_textured = self.textures.len() == self.corners.len();
        if self.some_textured && !all_textured {
            warn_incomplete(path, "faces have texture coordinates");
        }
        Ok(all_textured.then(|| uv_of_vertices(&self.textures, textures)))
    }
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
            text.error(format!("expected a {what} index, a whole number, not {}", quote(token)))
        })?;
        let from_zero = match index {
            1.. => index - 1,
            0 => return Err(text.error(format!("a {what} index is 0; indices count from 1"))),
            _ => index.saturating_add(defined as i64),
        };
        let resolved =
            u32::try_from(from_zero).ok().filter(|&k| k < u32::MAX).ok_or_else(|| {
                text.error(format!("refers to {what} {index}, but {defined} are defined here"))
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
            write!(out, " {}/{}", u64::from(k) + 1, index_of[&t.map(f64::to_bits)])?;
        }
        writeln!(out)?;
    }
    Ok(())
}
