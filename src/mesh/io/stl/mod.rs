//! STL, ascii and binary: triangles without connectivity.
//!
//! ```text
//! binary: 80 bytes of anything, F as u32, then F times: normal, 3 corners (12 f32), 2 bytes; little endian
//! ascii:  solid NAME { facet normal N outer loop { vertex x y z } x3 endloop endfacet } endsolid NAME
//!         a name ends with its line; all other words are separated by any blanks
//! ```
//!
//! Corners at exactly the same position are welded; vertices are numbered in order of first appearance. Normals are
//! skipped, since they follow from the corners. Many binary files also begin with `solid`, so the length decides: a
//! binary file has 84 + 50 F bytes, perhaps followed by zero bytes or blanks.
//!
//! We use our own reader: that of the crate relies on `solid`, rounds ascii coordinates to 32 bits, distinguishes 0
//! from -0, and does not report the line of an error.
//!
//! Reference: 3D Systems, *StereoLithography Interface Specification*, 1989.

mod write;

use std::collections::HashMap;
use std::path::Path;

use nalgebra::Point3;

use super::check_coordinate;
use super::text::{Text, quote};
use crate::counted::counted;
use crate::error::{Error, Result};
use crate::mesh::Mesh;

pub use self::write::{origin, write};

const HEADER_SIZE: usize = 80;
const COUNT_SIZE: usize = 4;
const TRIANGLE_SIZE: usize = 50;

pub fn recognizes(bytes: &[u8]) -> bool {
    begins_with_solid(bytes) || declared_length(bytes) == Some(bytes.len())
}

fn begins_with_solid(bytes: &[u8]) -> bool {
    let mut text = Text::new(Path::new(""), bytes);
    text.next_line() && text.token().is_some_and(|token| token.eq_ignore_ascii_case(b"solid"))
}

/// The length in bytes of a binary file with the number of triangles that this one declares.
fn declared_length(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER_SIZE..)?.first_chunk::<COUNT_SIZE>()?;
    let triangles = usize::try_from(u32::from_le_bytes(*count)).ok()?;
    triangles.checked_mul(TRIANGLE_SIZE)?.checked_add(HEADER_SIZE + COUNT_SIZE)
}

pub fn parse(path: &Path, bytes: &[u8]) -> Result<Mesh> {
    let exact = declared_length(bytes) == Some(bytes.len());
    // Text has no zero bytes; a binary header of 80 bytes that begins with "solid" nearly always does.
    let head = &bytes[..bytes.len().min(HEADER_SIZE + COUNT_SIZE)];
    if !exact && begins_with_solid(bytes) && !head.contains(&0) {
        parse_ascii(path, bytes)
    } else {
        parse_binary(path, bytes)
    }
}

/// The mesh of the triangles read so far.
#[derive(Default)]
struct Welder {
    vertices: Vec<Point3<f64>>,
    faces: Vec<[u32; 3]>,
    index_of: HashMap<[u64; 3], u32>,
}

impl Welder {
    fn add(&mut self, corners: [[f64; 3]; 3]) {
        let face = corners.map(|x| {
            // -0 + 0 = 0, so that both zeros have the same bits.
            let position = x.map(|x| (x + 0.0).to_bits());
            *self.index_of.entry(position).or_insert_with(|| {
                self.vertices.push(Point3::from(x));
                // Each three corners take 50 bytes, so memory runs out long before the indices.
                u32::try_from(self.vertices.len() - 1).expect("fewer than 2^32 vertices")
            })
        });
        self.faces.push(face);
    }

    fn finish(self) -> Mesh {
        Mesh::new(self.vertices, self.faces)
    }
}

fn parse_binary(path: &Path, bytes: &[u8]) -> Result<Mesh> {
    let length = declared_length(bytes)
        .ok_or_else(|| Error::malformed(path, "is neither ascii nor binary STL"))?;
    let Some(triangles) = bytes.get(HEADER_SIZE + COUNT_SIZE..length) else {
        let (declared, has) = (
            (length - HEADER_SIZE - COUNT_SIZE) / TRIANGLE_SIZE,
            (bytes.len() - HEADER_SIZE - COUNT_SIZE) / TRIANGLE_SIZE,
        );
        return Err(Error::malformed(
            path,
            format!(
                "declares {} but has {has}; it is truncated, or is not an STL file",
                counted(declared, "triangle", "triangles")
            ),
        ));
    };
    let rest = &bytes[length..];
    if !rest.iter().all(|&b| b == 0 || b.is_ascii_whitespace()) {
        return Err(Error::malformed(
            path,
            format!(
                "{} the last triangle that the header declares; the header is wrong",
                counted(rest.len(), "byte follows", "bytes follow")
            ),
        ));
    }
    let mut welder = Welder::default();
    let (triangles, _) = triangles.as_chunks::<TRIANGLE_SIZE>();
    for (j, triangle) in triangles.iter().enumerate() {
        let (floats, _) = triangle.as_chunks::<4>();
        let mut corners = [[0.0; 3]; 3];
        for (x, bytes) in corners.as_flattened_mut().iter_mut().zip(&floats[3..]) {
            *x = check_coordinate(f64::from(f32::from_le_bytes(*bytes)))
                .map_err(|message| Error::malformed(path, format!("triangle {j}: {message}")))?;
        }
        welder.add(corners);
    }
    Ok(welder.finish())
}

fn parse_ascii(path: &Path, bytes: &[u8]) -> Result<Mesh> {
    let mut text = Text::new(path, bytes);
    let mut welder = Welder::default();
    while text.seek_token() {
        expect(&mut text, "solid")?;
        text.rest_of_line();
        loop {
            let keyword = next(&mut text, "endsolid")?;
            if keyword.eq_ignore_ascii_case(b"endsolid") {
                text.rest_of_line();
                break;
            }
            if !keyword.eq_ignore_ascii_case(b"facet") {
                return Err(
                    text.error(format!("expected facet or endsolid, not {}", quote(keyword)))
                );
            }
            skip_normal(&mut text)?;
            expect(&mut text, "loop")?;
            let mut corners = [[0.0; 3]; 3];
            for corner in &mut corners {
                expect(&mut text, "vertex")?;
                for x in corner {
                    seek(&mut text, "a coordinate")?;
                    *x = text.coordinate()?;
                }
            }
            expect(&mut text, "endloop")?;
            expect(&mut text, "endfacet")?;
            welder.add(corners);
        }
    }
    Ok(welder.finish())
}

/// Skips to after `outer`, which may follow a valid, an invalid or no normal.
fn skip_normal(text: &mut Text) -> Result<()> {
    const NORMAL_WORDS: usize = 4;
    for _ in 0..NORMAL_WORDS {
        if next(text, "outer")?.eq_ignore_ascii_case(b"outer") {
            return Ok(());
        }
    }
    expect(text, "outer")
}

/// Moves to the next word on any line: some programs put several parts of a facet on one line.
fn seek(text: &mut Text, expected: &str) -> Result<()> {
    match text.seek_token() {
        true => Ok(()),
        false => Err(text.error(format!("the file ends where {expected} is expected"))),
    }
}

fn next<'a>(text: &mut Text<'a>, expected: &str) -> Result<&'a [u8]> {
    seek(text, expected)?;
    Ok(text.token().unwrap_or_default())
}

fn expect(text: &mut Text, keyword: &str) -> Result<()> {
    let word = next(text, keyword)?;
    match word.eq_ignore_ascii_case(keyword.as_bytes()) {
        true => Ok(()),
        false => Err(text.error(format!("expected {keyword}, not {}", quote(word)))),
    }
}
