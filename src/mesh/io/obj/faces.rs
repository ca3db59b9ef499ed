//! The faces of an OBJ file: polygons, whose corners may have texture coordinates.

use std::path::Path;

use nalgebra::Point3;

use crate::counted::counted;
use crate::error::{Error, Result};
use crate::mesh::io::occurrences::{Occurrences, warn};
use crate::mesh::io::polygon::Polygons;
use crate::mesh::io::text::{Text, parse_integer, quote};
use crate::mesh::io::{TOO_FEW_CORNERS, check_faces, fan, warn_untextured};

/// A corner without texture coordinates.
const NO_TEXTURE: u32 = u32::MAX;

/// The triangles read so far.
#[derive(Default)]
pub struct Faces {
    corners: Vec<[u32; 3]>,
    /// Indices of texture coordinates; empty until the first face that has some, then for every face.
    textures: Vec<[u32; 3]>,
    polygons: Polygons,
    vertex_references: References,
    invalid_textures: Occurrences,
    too_few: Occurrences,
    /// The polygon being read.
    polygon: Vec<u32>,
    polygon_textures: Vec<u32>,
}

/// The triangles, and the texture coordinates of their corners.
type Finished = (Vec<[u32; 3]>, Option<Vec<[[f64; 2]; 3]>>);

impl Faces {
    pub fn count(&self) -> usize {
        self.corners.len()
    }

    /// Reads one polygon, after the given numbers of vertices and texture coordinates.
    pub fn read(&mut self, text: &mut Text, vertices: usize, textures: usize) -> Result<()> {
        self.polygon.clear();
        self.polygon_textures.clear();
        let mut textured = false;
        while let Some(token) = text.token() {
            let mut indices = token.split(|&b| b == b'/');
            let vertex = indices.next().unwrap_or_default();
            self.polygon.push(self.vertex_references.resolve(text, vertex, vertices)?);
            let texture = match indices.next() {
                None | Some(b"") => NO_TEXTURE,
                Some(index) => match resolved(index, textures) {
                    Ok(t) => {
                        textured = true;
                        t
                    }
                    Err(_) => {
                        self.invalid_textures.add(|| format!("line {}", text.line()));
                        NO_TEXTURE
                    }
                },
            };
            self.polygon_textures.push(texture);
        }
        let n = self.polygon.len();
        if n < 3 {
            self.too_few.add(|| format!("line {}", text.line()));
            return Ok(());
        }
        if textured || !self.textures.is_empty() {
            self.textures.resize(self.corners.len(), [NO_TEXTURE; 3]);
            self.textures.extend(fan(&self.polygon_textures));
        }
        self.polygons.add(self.corners.len(), n);
        self.corners.extend(fan(&self.polygon));
        Ok(())
    }

    /// Checks all references.
    pub fn finish(
        mut self,
        path: &Path,
        vertices: &[Point3<f64>],
        textures: &[[f64; 2]],
    ) -> Result<Finished> {
        self.vertex_references.check(path, vertices.len())?;
        check_faces(path, &self.corners)?;
        self.too_few.warn(path, TOO_FEW_CORNERS);
        if textures.is_empty() {
            if !self.textures.is_empty() || !self.invalid_textures.is_empty() {
                warn(
                    path,
                    "faces refer to texture coordinates, but the file has none; the references are ignored",
                );
            }
            self.textures.clear();
        } else {
            self.invalid_textures.warn(
                path,
                "references to texture coordinates that are not valid indices are unknown",
            );
        }
        let textured = !self.textures.is_empty();
        if textured {
            self.textures.resize(self.corners.len(), [NO_TEXTURE; 3]);
        }
        self.polygons.triangulate(
            path,
            vertices,
            &mut self.corners,
            textured.then_some(self.textures.as_mut_slice()),
        );
        let mut missing = 0;
        let uv = textured.then(|| {
            let mut coordinates = |t: u32| match textures.get(t as usize) {
                Some(&t) => t,
                None => {
                    missing += usize::from(t != NO_TEXTURE);
                    [f64::NAN; 2]
                }
            };
            self.textures.iter().map(|face| face.map(&mut coordinates)).collect::<Vec<_>>()
        });
        if missing > 0 {
            warn(
                path,
                &format!(
                    "{} to texture coordinates beyond the {} in the file and have none",
                    counted(missing, "corner of a face refers", "corners of faces refer"),
                    textures.len()
                ),
            );
        }
        let uv = uv.and_then(|uv| warn_untextured(path, uv));
        Ok((self.corners, uv))
    }
}

/// The largest referenced index and its line: the vertex may follow later in the file.
#[derive(Default)]
struct References {
    largest: Option<u32>,
    line: usize,
}

/// Why an index is invalid.
enum InvalidIndex {
    NotANumber,
    Zero,
    Outside(i64),
}

/// The index from 0 that a token denotes after `defined` vertices.
#[inline]
fn resolved(token: &[u8], defined: usize) -> std::result::Result<u32, InvalidIndex> {
    let index = parse_integer(token).ok_or(InvalidIndex::NotANumber)?;
    let from_zero = match index {
        1.. => index - 1,
        0 => return Err(InvalidIndex::Zero),
        _ => index.saturating_add(defined as i64),
    };
    u32::try_from(from_zero).ok().filter(|&k| k < NO_TEXTURE).ok_or(InvalidIndex::Outside(index))
}

impl References {
    #[inline]
    fn resolve(&mut self, text: &Text, token: &[u8], defined: usize) -> Result<u32> {
        let k = resolved(token, defined).map_err(|wrong| {
            text.error(match wrong {
                InvalidIndex::NotANumber => {
                    format!("expected a vertex index, a whole number, not {}", quote(token))
                }
                InvalidIndex::Zero => "a vertex index is 0, but indices count from 1".to_owned(),
                InvalidIndex::Outside(index) => {
                    format!(
                        "refers to vertex {index}, but only {} here",
                        counted(defined, "vertex is defined", "vertices are defined")
                    )
                }
            })
        })?;
        if self.largest.is_none_or(|largest| largest < k) {
            self.largest = Some(k);
            self.line = text.line();
        }
        Ok(k)
    }

    fn check(&self, path: &Path, defined: usize) -> Result<()> {
        match self.largest {
            Some(largest) if largest as usize >= defined => Err(Error::malformed_line(
                path,
                self.line,
                format!(
                    "refers to vertex {}, but the file has {}",
                    u64::from(largest) + 1,
                    counted(defined, "vertex", "vertices")
                ),
            )),
            _ => Ok(()),
        }
    }
}
