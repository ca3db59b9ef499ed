//! Labels of the vertices of a surface of FreeSurfer (`.annot`).
//!
//! ```text
//! V, V times: vertex, code       code = red + 256 green + 65536 blue of the label; i32, big endian
//! 1                              a table follows
//! -2, rows, text, n, n times: index, text, red, green, blue, transparency      version 2
//! n, text, n times: text, red, green, blue, transparency                       version 1
//! ```
//!
//! A text is its length as i32 and so many bytes, the last of them 0. The first one is the file of the table.

use std::collections::HashMap;
use std::path::Path;

use super::bytes::Bytes;
use crate::counted::counted;
use crate::error::Result;
use crate::mesh::io::text::decode;

/// Tables of FreeSurfer have up to 15,000 rows.
const MOST_ROWS: usize = 1 << 16;

/// Labels with their names and colors.
#[derive(Clone, Debug, PartialEq)]
pub struct Annotation {
    /// The row of the table for each vertex; -1 where the table does not have the code of the vertex.
    pub labels: Vec<i32>,
    /// The name of each row; empty if the table skips it.
    pub names: Vec<String>,
    /// RGB in [0, 1] of each row; black if the table skips it.
    pub colors: Vec<[f64; 3]>,
}

/// Reads an annotation.
///
/// # Errors
/// The file is malformed or has no table.
pub fn read_annotation(path: &Path, bytes: &[u8]) -> Result<Annotation> {
    // There is no magic number.
    let mut bytes = Bytes::new(path, bytes);
    let codes = codes(&mut bytes)?;
    let table = table(&mut bytes)?;
    bytes.finish()?;
    // Of rows with the same code, FreeSurfer takes the first.
    let mut rows = HashMap::new();
    for (row, entry) in (0..).zip(&table) {
        if let Some((_, rgb)) = entry {
            rows.entry(code(*rgb)).or_insert(row);
        }
    }
    let labels = codes.iter().map(|code| rows.get(code).copied().unwrap_or(-1)).collect();
    let (names, colors) = table
        .into_iter()
        .map(Option::unwrap_or_default)
        .map(|(name, rgb)| (name, rgb.map(|channel| f64::from(channel) / 255.0)))
        .unzip();
    Ok(Annotation { labels, names, colors })
}

/// What stands for a color in an annotation.
pub fn code([red, green, blue]: [u8; 3]) -> i32 {
    i32::from(red) | i32::from(green) << 8 | i32::from(blue) << 16
}

/// The code of each vertex.
fn codes(bytes: &mut Bytes) -> Result<Vec<i32>> {
    let vertices = bytes.count("vertices")?;
    let pairs = bytes.records::<8>(vertices, "vertices")?;
    let mut codes = vec![None; vertices];
    for pair in pairs {
        let (numbers, _) = pair.as_chunks::<4>();
        let [v, code] = [numbers[0], numbers[1]].map(i32::from_be_bytes);
        let place = usize::try_from(v).ok().and_then(|v| codes.get_mut(v));
        let Some(place) = place else {
            let vertices = counted(vertices, "vertex", "vertices");
            return Err(bytes.error(format!("has a label of vertex {v}, but {vertices}")));
        };
        if place.replace(code).is_some() {
            return Err(bytes.error(format!("has two labels of vertex {v}")));
        }
    }
    // As many different ones as there are vertices: all of them.
    Ok(codes.into_iter().flatten().collect())
}

/// A name and a color.
type Entry = (String, [u8; 3]);

/// The names and colors; `None` for rows that are skipped.
fn table(bytes: &mut Bytes) -> Result<Vec<Option<Entry>>> {
    if bytes.is_empty() || bytes.int("the mark of the table")? != 1 {
        return Err(bytes.error("has no table of labels"));
    }
    let (rows, entries) = match bytes.int("the version of the table")? {
        -2 => {
            let rows = bytes.count("rows of the table")?;
            text(bytes)?;
            (rows, Some(bytes.count("labels")?))
        }
        rows @ 1.. => {
            text(bytes)?;
            (usize::try_from(rows).unwrap_or(usize::MAX), None)
        }
        version => {
            return Err(bytes.error(format!("has a table of the unknown version {version}")));
        }
    };
    if rows > MOST_ROWS {
        return Err(
            bytes.error(format!("has a table of {rows} rows; at most {MOST_ROWS} are supported"))
        );
    }
    let mut table = vec![None; rows];
    for entry in 0..entries.unwrap_or(rows) {
        let row = if entries.is_some() { bytes.count("a row")? } else { entry };
        let name = text(bytes)?;
        let mut rgb = [0; 3];
        for channel in &mut rgb {
            let value = bytes.int("a color")?;
            *channel = u8::try_from(value)
                .map_err(|_| bytes.error(format!("has the color {value}, not 0 to 255")))?;
        }
        bytes.int("a color")?;
        let Some(place) = table.get_mut(row) else {
            return Err(bytes.error(format!("has row {row} in a table of {rows}")));
        };
        *place = Some((name, rgb));
    }
    Ok(table)
}

fn text(bytes: &mut Bytes) -> Result<String> {
    let length = bytes.count("characters")?;
    let text = bytes.take(length, "a name")?;
    Ok(decode(text.split(|&b| b == 0).next().unwrap_or_default()))
}
