//! Surfaces of FreeSurfer, binary or as text.
//!
//! ```text
//! binary: ff ff fe, comment, line end, comment (mostly empty), line end, V and F as i32,
//!         V times x y z as f32, F times three vertices as i32, from 0; big endian; tags, which are skipped
//! text:   #!ascii version of NAME
//!         V F
//!         x y z 0                  # V vertices; the last number, which says what is hidden, is skipped
//!         i_1 i_2 i_3 0            # F faces
//! ```
//!
//! Positions are those of the file, mostly in the "surface RAS" space.

use std::path::Path;

use nalgebra::Point3;

use super::bytes::Bytes;
use crate::counted::counted;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::mesh::io::check_coordinate;
use crate::mesh::io::text::Text;

const TRIANGLES: &[u8] = b"\xff\xff\xfe";
const TEXT: &[u8] = b"#!ascii";

/// Of old surfaces of quadrangles; the first also of numbers at vertices.
const REFUSED: [&[u8]; 2] = [b"\xff\xff\xff", b"\xff\xff\xfd"];

/// Whether the file is a surface, or one of those that [`parse`] refuses with an explanation.
pub fn recognizes(bytes: &[u8]) -> bool {
    [TRIANGLES, TEXT].into_iter().chain(REFUSED).any(|magic| bytes.starts_with(magic))
}

/// Reads a surface.
///
/// # Errors
/// The file is malformed, or is not a surface of triangles.
pub fn parse(path: &Path, bytes: &[u8]) -> Result<Mesh> {
    if bytes.starts_with(TEXT) {
        return parse_text(path, bytes);
    }
    if let Some(bytes) = Bytes::behind(path, bytes, TRIANGLES) {
        return parse_binary(bytes);
    }
    let message = match REFUSED.iter().any(|magic| bytes.starts_with(magic)) {
        true => {
            "holds numbers at vertices, or quadrangles, which are not supported; name a surface of triangles \
             (mris_convert makes one of quadrangles)"
        }
        false => "is not a surface of FreeSurfer",
    };
    Err(Error::malformed(path, message))
}

fn parse_binary(mut bytes: Bytes) -> Result<Mesh> {
    bytes.line()?;
    bytes.line()?;
    let (vertices, faces) = (bytes.count("vertices")?, bytes.count("faces")?);
    let positions = bytes.records::<12>(vertices, "vertices")?;
    let corners = bytes.records::<12>(faces, "faces")?;
    let mut mesh = Surface::with_capacity(vertices, faces);
    for position in positions {
        let (x, _) = position.as_chunks::<4>();
        mesh.add_vertex([x[0], x[1], x[2]].map(|x| f64::from(f32::from_be_bytes(x))))
            .map_err(|message| bytes.error(message))?;
    }
    for face in corners {
        let (v, _) = face.as_chunks::<4>();
        mesh.add_face([v[0], v[1], v[2]].map(|v| i64::from(i32::from_be_bytes(v))))
            .map_err(|message| bytes.error(message))?;
    }
    Ok(mesh.finish())
}

fn parse_text(path: &Path, bytes: &[u8]) -> Result<Mesh> {
    /// The shortest line, `0 0 0 0` or `0 0 0`.
    const SHORTEST_LINE: usize = 6;
    let mut text = Text::new(path, bytes);
    text.next_line();
    text.rest_of_line();
    let [vertices, faces] = {
        seek(&mut text, "the number of vertices")?;
        [count(&mut text, "the number of vertices")?, count(&mut text, "the number of faces")?]
    };
    let room = text.remaining() / SHORTEST_LINE + 1;
    let mut mesh = Surface::with_capacity(vertices.min(room), faces.min(room));
    for v in 0..vertices {
        seek(&mut text, &format!("vertex {v} of {vertices}"))?;
        let x = [text.coordinate()?, text.coordinate()?, text.coordinate()?];
        mesh.add_vertex(x).map_err(|message| text.error(message))?;
        text.rest_of_line();
    }
    for j in 0..faces {
        seek(&mut text, &format!("face {j} of {faces}"))?;
        let mut corner = || text.integer("a vertex");
        let face = [corner()?, corner()?, corner()?];
        mesh.add_face(face).map_err(|message| text.error(message))?;
        text.rest_of_line();
    }
    match text.seek_token() {
        true => Err(text.error("the file continues after the declared vertices and faces")),
        false => Ok(mesh.finish()),
    }
}

fn seek(text: &mut Text, expected: &str) -> Result<()> {
    match text.seek_token() {
        true => Ok(()),
        false => Err(text.error(format!("the file ends where {expected} is expected"))),
    }
}

fn count(text: &mut Text, what: &str) -> Result<usize> {
    let n = text.integer(what)?;
    usize::try_from(n).map_err(|_| text.error(format!("{n} is not {what}")))
}

/// What was read so far.
struct Surface {
    vertices: Vec<Point3<f64>>,
    faces: Vec<[u32; 3]>,
}

impl Surface {
    fn with_capacity(vertices: usize, faces: usize) -> Self {
        Surface { vertices: Vec::with_capacity(vertices), faces: Vec::with_capacity(faces) }
    }

    fn add_vertex(&mut self, x: [f64; 3]) -> std::result::Result<(), String> {
        for x in x {
            check_coordinate(x)
                .map_err(|message| format!("vertex {}: {message}", self.vertices.len()))?;
        }
        self.vertices.push(Point3::from(x));
        Ok(())
    }

    fn add_face(&mut self, corners: [i64; 3]) -> std::result::Result<(), String> {
        let mut face = [0; 3];
        for (v, corner) in face.iter_mut().zip(corners) {
            let index = u32::try_from(corner).ok();
            *v = index.filter(|&v| (v as usize) < self.vertices.len()).ok_or_else(|| {
                let vertices = counted(self.vertices.len(), "vertex", "vertices");
                let j = self.faces.len();
                format!("face {j}: refers to vertex {corner}, but the file has {vertices}")
            })?;
        }
        self.faces.push(face);
        Ok(())
    }

    fn finish(self) -> Mesh {
        Mesh::new(self.vertices, self.faces)
    }
}
