//! GIFTI 1.0: surfaces (`.surf.gii`), numbers at their vertices (`.func.gii`, `.shape.gii`, `.time.gii`), and labels
//! (`.label.gii`).
//!
//! ```text
//! <GIFTI Version="1.0" NumberOfDataArrays="n">
//!   <MetaData>...</MetaData>                                                              skipped
//!   <LabelTable> <Label Key="1" Red="1" Green="0" Blue="0" Alpha="1">name</Label> ... </LabelTable>
//!   <DataArray Intent="NIFTI_INTENT_POINTSET" ...>   V x 3 positions                      a surface has one
//!   <DataArray Intent="NIFTI_INTENT_TRIANGLE" ...>   F x 3 vertices, from 0               and one of these
//!   <DataArray ...>                                  V numbers, or V x d                  any other intent
//! </GIFTI>
//! ```
//!
//! All encodings but external files, both byte orders, both orders of indices, all types of integers and floats, see
//! `array.rs`. Positions are those of the file: `CoordinateSystemTransformMatrix` is not applied, as in nibabel and
//! FreeSurfer.
//!
//! Reference: John Harwell et al., *GIFTI Surface Data Format, version 1.0*, 2011.

mod array;
mod number;
mod write;

use std::collections::HashMap;
use std::path::Path;

use nalgebra::Point3;
use ndarray::Array2;

use self::array::{Array, Budget};
use super::check_coordinate;
use super::text::{BYTE_ORDER_MARK, quote};
use super::xml::{Tag, Xml};
use crate::counted::counted;
use crate::error::{Error, Result};
use crate::mesh::Mesh;

use self::write::UNKNOWN;

pub use self::write::write_labels;

const POINTS: &str = "NIFTI_INTENT_POINTSET";
const TRIANGLES: &str = "NIFTI_INTENT_TRIANGLE";
const LABELS: &str = "NIFTI_INTENT_LABEL";

/// The numbers at the vertices of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct GiftiArrays {
    /// One row per vertex, one column per array, or d for an array of V x d numbers. NaN and infinity are kept.
    pub values: Array2<f64>,
    /// Whether all of them are keys of labels.
    pub are_labels: bool,
    /// The labels in the order of the file.
    pub table: Vec<GiftiLabel>,
}

/// A row of the table of labels.
#[derive(Clone, Debug, PartialEq)]
pub struct GiftiLabel {
    /// What stands for it in arrays of labels.
    pub key: i32,
    /// Without blanks around it.
    pub name: String,
    /// Red, green, blue and opacity in [0, 1], if the file has them.
    pub color: Option<[f64; 4]>,
}

/// Whether the first element is that of GIFTI.
pub fn recognizes(bytes: &[u8]) -> bool {
    /// The declarations before it are not longer.
    const BEGINNING: usize = 4096;
    let text = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes).trim_ascii_start();
    let beginning = &text[..text.len().min(BEGINNING)];
    text.starts_with(b"<") && beginning.windows(6).any(|window| window == b"<GIFTI")
}

/// Reads a surface.
///
/// # Errors
/// The file is malformed, has not one array of points and one of triangles, or numbers are in another file.
pub fn parse(path: &Path, bytes: &[u8]) -> Result<Mesh> {
    let Content { arrays, others, .. } =
        Content::read(path, bytes, |intent| intent == POINTS || intent == TRIANGLES)?;
    let (mut points, mut triangles) = (None, None);
    for array in arrays {
        let place = if array.intent == POINTS { &mut points } else { &mut triangles };
        if array.columns != 3 {
            let (of, columns) = (&array.intent, counted(array.columns, "column", "columns"));
            return Err(Error::malformed(path, format!("{of} has {columns}; it must have 3")));
        }
        if let Some(first) = place.replace(array) {
            let message = format!("has several arrays {}; keep one", first.intent);
            return Err(Error::malformed(path, message));
        }
    }
    let (Some(points), Some(triangles)) = (points, triangles) else {
        return Err(Error::malformed(
            path,
            match others {
                true => "holds no surface, but numbers at vertices; give a .surf.gii as mesh",
                false => "has no surface: it needs an array of points and one of triangles",
            },
        ));
    };
    mesh(path, &points, &triangles)
}

fn mesh(path: &Path, points: &Array, triangles: &Array) -> Result<Mesh> {
    let wrong = |message: String| Error::malformed(path, message);
    let (positions, _) = points.values.as_chunks::<3>();
    for (v, x) in positions.iter().enumerate() {
        for &x in x {
            check_coordinate(x).map_err(|message| wrong(format!("vertex {v}: {message}")))?;
        }
    }
    let (corners, _) = triangles.values.as_chunks::<3>();
    let mut faces = Vec::with_capacity(corners.len());
    for (j, corners) in corners.iter().enumerate() {
        let mut face = [0; 3];
        for (v, &x) in face.iter_mut().zip(corners) {
            *v = vertex(x, points.rows).ok_or_else(|| {
                let vertices = counted(points.rows, "vertex", "vertices");
                wrong(format!("face {j}: refers to vertex {x}, but the file has {vertices}"))
            })?;
        }
        faces.push(face);
    }
    Ok(Mesh::new(positions.iter().map(|&x| Point3::from(x)).collect(), faces))
}

/// The index of one of so many vertices.
fn vertex(x: f64, vertices: usize) -> Option<u32> {
    let is_index = x.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&x);
    // Exact, since it is a whole number within the range.
    let v = is_index.then_some(x as u32)?;
    usize::try_from(v).ok().filter(|&v| v < vertices).map(|_| v)
}

/// Reads the numbers at vertices: all arrays but points and triangles.
///
/// # Errors
/// The file is malformed, has no such array or some of different lengths, or numbers are in another file.
pub fn read_arrays(path: &Path, bytes: &[u8]) -> Result<GiftiArrays> {
    let wrong = |message: String| Error::malformed(path, message);
    let Content { mut arrays, table, .. } =
        Content::read(path, bytes, |intent| intent != POINTS && intent != TRIANGLES)?;
    let Some(first) = arrays.first() else {
        return Err(wrong("has no numbers at vertices".to_owned()));
    };
    let rows = first.rows;
    if let Some(other) = arrays.iter().find(|array| array.rows != rows) {
        let other = counted(other.rows, "row", "rows");
        return Err(wrong(format!("has arrays of different lengths: {rows} and {other}")));
    }
    let are_labels = arrays.iter().all(|array| array.intent == LABELS);
    let columns = arrays.iter().map(|array| array.columns).sum();
    let values = match arrays.len() {
        1 => arrays.pop().map_or(Vec::new(), |array| array.values),
        _ => (0..rows)
            .flat_map(|v| {
                arrays.iter().flat_map(move |a| &a.values[v * a.columns..(v + 1) * a.columns])
            })
            .copied()
            .collect(),
    };
    let values = Array2::from_shape_vec((rows, columns), values)
        .map_err(|error| wrong(error.to_string()))?;
    Ok(GiftiArrays { values, are_labels, table })
}

impl GiftiArrays {
    /// The values. Labels with a table are the rows of this, `???` not counted, and -1 where it does not have the key:
    /// keys are any numbers, such as colors.
    pub fn known(self) -> Array2<f64> {
        let GiftiArrays { mut values, are_labels, table } = self;
        if are_labels && !table.is_empty() {
            let named = table.iter().filter(|label| label.name != UNKNOWN);
            let rows: HashMap<i32, i32> = named.map(|label| label.key).zip(0..).collect();
            // What is not an i32 differs from what `as` makes of it.
            let key = |x: f64| Some(x as i32).filter(|&key| f64::from(key) == x);
            let row =
                |x: f64| key(x).and_then(|key| rows.get(&key)).map_or(-1.0, |&row| f64::from(row));
            values.mapv_inplace(row);
        }
        values
    }
}

/// The wanted content of a file.
struct Content {
    arrays: Vec<Array>,
    table: Vec<GiftiLabel>,
    /// Whether there are arrays that were not wanted.
    others: bool,
}

impl Content {
    fn read(path: &Path, bytes: &[u8], wanted: impl Fn(&str) -> bool) -> Result<Self> {
        let mut xml = Xml::new(path, bytes);
        let mut budget = Budget::of(bytes.len());
        let mut content = Content { arrays: Vec::new(), table: Vec::new(), others: false };
        match xml.child()? {
            Some(root) if root.name == b"GIFTI" => {}
            Some(root) => {
                let root = quote(root.name);
                return Err(xml.error(format!("expected GIFTI, not {root}; this is not GIFTI")));
            }
            None => return Err(xml.error("this is not GIFTI")),
        }
        while let Some(tag) = xml.child()? {
            match tag.name {
                b"LabelTable" => content.table.append(&mut table(&mut xml)?),
                b"DataArray" if wanted(&tag.get("Intent").unwrap_or_default()) => {
                    content.arrays.push(array::read(&mut xml, &tag, &mut budget)?);
                }
                name => {
                    content.others |= name == b"DataArray";
                    xml.skip()?;
                }
            }
        }
        xml.finish()?;
        Ok(content)
    }
}

fn table(xml: &mut Xml) -> Result<Vec<GiftiLabel>> {
    let mut table = Vec::new();
    while let Some(tag) = xml.child()? {
        if tag.name != b"Label" {
            xml.skip()?;
            continue;
        }
        // Files before version 1.0 call it an index.
        let key = tag.get("Key").or_else(|| tag.get("Index"));
        let key = key.and_then(|key| key.parse().ok());
        let key = key.ok_or_else(|| xml.error("a label has no valid Key"))?;
        table.push(GiftiLabel { key, color: color(&tag), name: array::name(xml)? });
    }
    Ok(table)
}

fn color(tag: &Tag) -> Option<[f64; 4]> {
    let channel =
        |name| tag.get(name)?.parse::<f64>().ok().filter(|channel| (0.0..=1.0).contains(channel));
    let [red, green, blue] = [channel("Red")?, channel("Green")?, channel("Blue")?];
    Some([red, green, blue, channel("Alpha").unwrap_or(1.0)])
}
