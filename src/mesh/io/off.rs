//! OFF, the Object File Format of Geomview.
//!
//! ```text
//! [ST][C][N]OFF                                    # what each vertex has besides its position
//! V F [E]                                          # may follow on the line of the keyword, even without a blank
//! x y z [nx ny nz] [r g b [a]] [s t]               # V vertices
//! n i_1 ... i_n [r g b [a]]                        # F polygons; indices from 0
//! ```
//!
//! Colors are floats in [0, 1] or up to 255. (A face may have a single number, an index into a color map in another
//! file: it is left out with a warning.) Many programs write vertex colors without declaring them in the keyword: 3 or
//! 4 numbers after a position are read as a color. Positions and lists of indices may continue on the next line; other
//! values end with their line. Positions and indices must be valid; other invalid parts are left out.
//!
//! Reference: Geomview manual, section "OFF: Object File Format".

use std::io::{self, Write};
use std::path::Path;

use nalgebra::Point3;

use super::colors::Colors;
use super::occurrences::Occurrences;
use super::polygon::Polygons;
use super::text::{Text, parse_float, quote};
use super::{
    INVALID_TEXTURE, TOO_FEW_CORNERS, check_coordinate, check_faces, coordinates, fan, known,
    uv_of_vertices, valid_uv, warn_untextured,
};
use crate::counted::counted;
use crate::error::Result;
use crate::mesh::Mesh;

/// The values of a vertex besides its position, declared by the keyword of the file.
#[derive(Clone, Copy, Default, Debug, PartialEq)]
struct VertexFormat {
    texture: bool,
    color: bool,
    normal: bool,
}

impl VertexFormat {
    /// Parses `OFF` and its prefixes. Their order is `STCN`, but some programs write `NC`.
    fn parse(keyword: &[u8]) -> Option<Self> {
        let mut prefix = keyword.strip_suffix(b"OFF")?;
        let mut format = VertexFormat::default();
        if let Some(rest) = prefix.strip_prefix(b"ST") {
            format.texture = true;
            prefix = rest;
        }
        for letter in prefix {
            match letter {
                b'C' if !format.color => format.color = true,
                b'N' if !format.normal => format.normal = true,
                _ => return None,
            }
        }
        Some(format)
    }
}

/// The keyword and the count after it: some programs write the first count without a blank, `OFF8 6 12`.
fn split(token: &[u8]) -> (&[u8], &[u8]) {
    const KEYWORD: &[u8] = b"OFF";
    let end = token.windows(KEYWORD.len()).position(|window| window == KEYWORD);
    let (keyword, count) = token.split_at(end.map_or(token.len(), |end| end + KEYWORD.len()));
    if count.iter().all(u8::is_ascii_digit) { (keyword, count) } else { (token, b"") }
}

/// Whether the first token is the keyword.
pub fn recognizes(bytes: &[u8]) -> bool {
    let mut text = Text::new(Path::new(""), bytes).with_comments();
    text.next_line() && text.token().and_then(|token| VertexFormat::parse(split(token).0)).is_some()
}

pub fn parse(path: &Path, bytes: &[u8]) -> Result<Mesh> {
    let mut text = Text::new(path, bytes).with_comments();
    text.next_line();
    let (keyword, glued) = split(text.token().unwrap_or_default());
    let format = VertexFormat::parse(keyword).ok_or_else(|| {
        let dimensions = keyword.ends_with(b"nOFF") || keyword.ends_with(b"4OFF");
        text.error(if dimensions {
            format!("the keyword is {}; only three dimensions are supported", quote(keyword))
        } else {
            format!("expected OFF, not {}; this is not an OFF file", quote(keyword))
        })
    })?;
    let (vertex_count, face_count) = counts(&mut text, glued)?;
    let vertices = Vertices::read(&mut text, format, vertex_count)?;
    let mut faces = Faces::read(&mut text, vertex_count, face_count)?;
    if text.seek_token() {
        return Err(text.error(
            "the file continues after the declared vertices and faces; correct the counts",
        ));
    }
    check_faces(path, &faces.corners)?;
    faces.too_few.warn(path, TOO_FEW_CORNERS);
    faces.color_indices.warn(
        path,
        "face colors that are indices into a color map are left out; write them as r g b",
    );
    faces.unexpected.warn(
        path,
        "values after the corners of faces that are not a color of 3 or 4 numbers are left out",
    );
    vertices.invalid_uv.warn(path, INVALID_TEXTURE);
    vertices.unexpected.warn(
        path,
        "values after positions that are neither those of the keyword nor a color of 3 or 4 numbers are left out",
    );
    faces.polygons.triangulate::<u32>(path, &vertices.positions, &mut faces.corners, None);
    let uv = format.texture.then(|| uv_of_vertices(&faces.corners, &vertices.uv));
    Ok(Mesh {
        uv: uv.and_then(|uv| warn_untextured(path, uv)),
        colors: vertices.colors.finish(path, vertex_count, "vertices"),
        face_colors: faces.colors.finish(path, faces.corners.len(), "faces"),
        vertices: vertices.positions,
        faces: faces.corners,
        materials: None,
    })
}

struct Vertices {
    positions: Vec<Point3<f64>>,
    colors: Colors,
    uv: Vec<[f64; 2]>,
    /// Vertices with unexpected values, and with invalid texture coordinates.
    unexpected: Occurrences,
    invalid_uv: Occurrences,
}

impl Vertices {
    fn read(text: &mut Text, format: VertexFormat, count: usize) -> Result<Self> {
        let mut vertices = Vertices {
            positions: Vec::with_capacity(room(text, count)),
            colors: Colors::new(None),
            uv: Vec::new(),
            unexpected: Occurrences::default(),
            invalid_uv: Occurrences::default(),
        };
        let mut values = Vec::new();
        for k in 0..count {
            let mut x = [0.0; 3];
            for x in &mut x {
                let token = expect_token(text, k, count, "vertices")?;
                *x = check_coordinate(text.number_of(token, "a coordinate")?)
                    .map_err(|message| text.error(message))?;
            }
            vertices.positions.push(Point3::from(x));
            values.clear();
            while let Some(token) = text.token() {
                values.push(parse_float(token).unwrap_or(f64::NAN));
            }
            vertices.extras(text, format, &values);
        }
        Ok(vertices)
    }

    /// Reads the values after the latest position on its line.
    fn extras(&mut self, text: &Text, format: VertexFormat, values: &[f64]) {
        let location = || format!("line {}", text.line());
        let k = self.positions.len() - 1;
        let mut rest = values;
        let mut complete = true;
        if format.normal {
            complete &= rest.len() >= 3;
            rest = rest.get(3..).unwrap_or_default();
        }
        if format.texture {
            let (before, t) = match rest.split_last_chunk() {
                Some((before, &t)) => (before, valid_uv(t, &mut self.invalid_uv, location)),
                None => {
                    complete = false;
                    (rest, [f64::NAN; 2])
                }
            };
            self.uv.push(t);
            rest = before;
        }
        match *rest {
            [] => complete &= !format.color,
            // The other declared formats have no color.
            [r, g, b] | [r, g, b, _] if format.color || !(format.normal || format.texture) => {
                complete &= [r, g, b].iter().all(|c| c.is_finite());
                self.colors.set(k, [r, g, b], location);
            }
            _ => complete = false,
        }
        if !complete {
            self.unexpected.add(location);
        }
    }
}

struct Faces {
    corners: Vec<[u32; 3]>,
    polygons: Polygons,
    colors: Colors,
    too_few: Occurrences,
    /// Faces whose color is an index into a color map, and those with other values after their corners.
    color_indices: Occurrences,
    unexpected: Occurrences,
}

impl Faces {
    fn read(text: &mut Text, vertices: usize, count: usize) -> Result<Self> {
        let mut faces = Faces {
            corners: Vec::with_capacity(room(text, count)),
            polygons: Polygons::default(),
            colors: Colors::new(None),
            too_few: Occurrences::default(),
            color_indices: Occurrences::default(),
            unexpected: Occurrences::default(),
        };
        let mut polygon = Vec::new();
        for j in 0..count {
            let token = expect_token(text, j, count, "faces")?;
            let n = text.integer_of(token, "a number of corners")?;
            if n < 0 {
                return Err(
                    text.error(format!("a face has {n} corners; the number must not be negative"))
                );
            }
            polygon.clear();
            for _ in 0..n {
                if !text.seek_token() {
                    return Err(
                        text.error("a vertex index is missing; the file ends within a face")
                    );
                }
                let k = text.integer("a vertex index")?;
                if !(0..vertices as i64).contains(&k) {
                    return Err(text.error(format!(
                        "refers to vertex {k}, but the file has {}, counted from 0",
                        counted(vertices, "vertex", "vertices")
                    )));
                }
                polygon.push(k as u32);
            }
            let mut values = [f64::NAN; 5];
            let mut given = 0;
            while let Some(token) = text.token() {
                values[given.min(4)] = parse_float(token).unwrap_or(f64::NAN);
                given += 1;
            }
            if polygon.len() < 3 {
                faces.too_few.add(|| format!("line {}", text.line()));
                continue;
            }
            let first = faces.corners.len();
            faces.polygons.add(first, polygon.len());
            faces.corners.extend(fan(&polygon));
            let location = || format!("line {}", text.line());
            match (given, values) {
                (0, _) => {}
                (1, [index, ..]) if index.fract() == 0.0 => faces.color_indices.add(location),
                (3 | 4, [r, g, b, ..]) => {
                    for triangle in first..faces.corners.len() {
                        faces.colors.set(triangle, [r, g, b], location);
                    }
                }
                _ => faces.unexpected.add(location),
            }
        }
        Ok(faces)
    }
}

/// V and F; the number of edges after them is ignored and may be missing. `glued` is the first count, if it follows the
/// keyword without a blank, or empty.
fn counts(text: &mut Text, glued: &[u8]) -> Result<(usize, usize)> {
    let first = match text.token() {
        Some(second) if !glued.is_empty() => return checked_counts(text, glued, second),
        _ if !glued.is_empty() => return Err(text.error("the number of faces is missing")),
        Some(b"BINARY") => {
            return Err(text.error("binary OFF is not supported; write it as text, or as PLY"));
        }
        Some(token) => token,
        None if text.next_line() => text.expect_token("the number of vertices")?,
        None => return Err(text.error("the file ends before the number of vertices")),
    };
    let second = text.expect_token("the number of faces")?;
    checked_counts(text, first, second)
}

fn checked_counts(text: &mut Text, first: &[u8], second: &[u8]) -> Result<(usize, usize)> {
    let count = |token: &[u8]| {
        std::str::from_utf8(token)
            .ok()
            .and_then(|token| token.parse::<usize>().ok())
            .ok_or_else(|| text.error(format!("{} is not a valid count", quote(token))))
    };
    let (vertices, faces) = (count(first)?, count(second)?);
    if u32::try_from(vertices).is_err() {
        return Err(
            text.error(format!("{vertices} vertices are too many; at most 2^32 - 1 are possible"))
        );
    }
    if text.token().is_some() {
        text.expect_end_of_line()?;
    }
    Ok((vertices, faces))
}

/// The number of lines for which memory is reserved at once.
fn room(text: &Text, count: usize) -> usize {
    const SHORTEST_LINE: usize = 6;
    count.min(text.remaining() / SHORTEST_LINE + 1)
}

/// The next token, on this line or a later one.
fn expect_token<'a>(
    text: &mut Text<'a>,
    read: usize,
    count: usize,
    what: &str,
) -> Result<&'a [u8]> {
    if !text.seek_token() {
        return Err(text.error(format!("the file ends after {read} of {count} {what}")));
    }
    text.expect_token("a value")
}

/// Writes the mesh, with numbers in the fewest digits that are read back to the same bits.
pub fn write(out: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    let keyword = if mesh.colors.is_some() { "COFF" } else { "OFF" };
    writeln!(out, "{keyword}\n{} {} 0", mesh.vertices.len(), mesh.faces.len())?;
    for (k, x) in mesh.vertices.iter().enumerate() {
        let [x, y, z] = coordinates(x);
        write!(out, "{x} {y} {z}")?;
        if let Some(colors) = &mesh.colors {
            let [r, g, b] = known(colors[k]);
            // With a decimal point, or a reader may take 1 for 1/255.
            write!(out, " {r:?} {g:?} {b:?} 1.0")?;
        }
        writeln!(out)?;
    }
    for (j, [a, b, c]) in mesh.faces.iter().enumerate() {
        write!(out, "3 {a} {b} {c}")?;
        let color = mesh.face_colors.as_ref().map(|colors| colors[j]);
        if let Some([r, g, b]) = color.filter(|color| !color[0].is_nan()) {
            write!(out, " {r:?} {g:?} {b:?}")?;
        }
        writeln!(out)?;
    }
    Ok(())
}
