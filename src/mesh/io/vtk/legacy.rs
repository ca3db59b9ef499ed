//! Legacy files of VTK (.vtk), as text or big endian bytes: POLYDATA and UNSTRUCTURED_GRID, of versions 1 to 5.
//!
//! ```text
//! # vtk DataFile Version 4.2
//! a title
//! ASCII|BINARY
//! DATASET POLYDATA|UNSTRUCTURED_GRID
//! POINTS V float                  3 V numbers
//! POLYGONS F size                 n i_1 ... i_n for each polygon; from version 5 on OFFSETS and CONNECTIVITY
//! CELLS F size, CELL_TYPES F      of an unstructured grid
//! POINT_DATA V, CELL_DATA F       SCALARS, COLOR_SCALARS, VECTORS, NORMALS, TEXTURE_COORDINATES, FIELD, ...
//! ```
//!
//! Reference: *VTK File Formats*, <https://docs.vtk.org/en/latest/vtk_file_formats/vtk_legacy_file_format.html>.

use std::path::Path;

use super::grid::{Array, Cell, Grid};
use super::numbers::Numbers;
use crate::error::{Error, Result};
use crate::mesh::io::scalar::Scalar;

type Said<T> = std::result::Result<T, String>;

/// Whether this is such a file.
pub fn recognizes(bytes: &[u8]) -> bool {
    bytes.starts_with(b"# vtk DataFile")
}

/// # Errors
/// The content is not a valid file of this kind.
pub fn parse(path: &Path, bytes: &[u8]) -> Result<Grid> {
    let mut cursor = Cursor { bytes, at: 0, is_text: true };
    read(&mut cursor).map_err(|message| {
        let line = 1 + bytes[..cursor.at].iter().filter(|&&b| b == b'\n').count();
        match cursor.is_text {
            true => Error::malformed_line(path, line, message),
            false => Error::malformed(path, message),
        }
    })
}

/// A position in a file in which lines of words and bytes alternate.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    is_text: bool,
}

fn read(cursor: &mut Cursor<'_>) -> Said<Grid> {
    if !recognizes(cursor.bytes) {
        return Err("does not begin with `# vtk DataFile`".into());
    }
    cursor.line();
    cursor.line();
    cursor.is_text = match cursor.line().trim_ascii() {
        b"ASCII" => true,
        b"BINARY" => false,
        _ => return Err("is neither ASCII nor BINARY".into()),
    };
    let mut grid = Grid::default();
    let (mut types, mut cells) = (None, None);
    // The arrays that follow are those of points, or of cells, and their number of rows.
    let mut data: Option<(bool, usize)> = None;
    while let Some(keyword) = cursor.keyword() {
        match keyword.to_ascii_uppercase().as_str() {
            "DATASET" => {
                let kind = cursor.word()?;
                if !["POLYDATA", "UNSTRUCTURED_GRID"].contains(&kind.to_ascii_uppercase().as_str())
                {
                    return Err(format!(
                        "is a {}; only POLYDATA and UNSTRUCTURED_GRID have faces",
                        shown(&kind)
                    ));
                }
            }
            "POINTS" => {
                let n = cursor.count()?;
                let scalar = cursor.scalar()?;
                grid.points = cursor.numbers(scalar, n, 3)?.floats();
            }
            "VERTICES" | "LINES" => {
                let (corners, ends) = cursor.cells()?;
                grid.add(std::iter::repeat(Cell::Thin), corners, ends.into_iter())?;
            }
            "POLYGONS" => {
                let (corners, ends) = cursor.cells()?;
                grid.add(std::iter::repeat(Cell::Polygon), corners, ends.into_iter())?;
            }
            "TRIANGLE_STRIPS" => {
                let (corners, ends) = cursor.cells()?;
                grid.add(std::iter::repeat(Cell::Strip), corners, ends.into_iter())?;
            }
            "CELLS" => cells = Some(cursor.cells()?),
            "CELL_TYPES" => {
                let n = cursor.count()?;
                let numbers = cursor.numbers(Scalar::I32, n, 1)?.integers("CELL_TYPES")?;
                types = Some(numbers.into_iter().map(Cell::of_type).collect::<Said<Vec<_>>>()?);
            }
            "POINT_DATA" => data = Some((true, cursor.count()?)),
            "CELL_DATA" => data = Some((false, cursor.count()?)),
            "METADATA" => cursor.skip_paragraph(),
            keyword => {
                let (of_points, rows) = data.unwrap_or((true, usize::MAX));
                let found = cursor.arrays(keyword, rows)?;
                match data {
                    Some(_) if of_points => grid.of_points.extend(found),
                    Some(_) => grid.of_cells.extend(found),
                    None => {}
                }
            }
        }
    }
    match (cells, types) {
        (None, None) => {}
        (Some((corners, ends)), Some(types)) if types.len() == ends.len() => {
            grid.add(types.into_iter(), corners, ends.into_iter())?;
        }
        _ => return Err("has not one CELL_TYPES for each of its CELLS".into()),
    }
    let (points, cells) = (grid.points.len() / 3, grid.cells.len());
    grid.of_points.retain(|array| array.numbers.len() == points * array.components);
    grid.of_cells.retain(|array| array.numbers.len() == cells * array.components);
    Ok(grid)
}

fn shown(word: &str) -> String {
    format!("`{}`", word.chars().take(40).collect::<String>().escape_debug())
}

impl<'a> Cursor<'a> {
    /// The rest of the line.
    fn line(&mut self) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        let end = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.at += (end + 1).min(rest.len());
        &rest[..end]
    }

    fn skip_blanks(&mut self) {
        let rest = &self.bytes[self.at..];
        self.at += rest.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(rest.len());
    }

    /// The next word; none at the end.
    fn token(&mut self) -> Option<&'a [u8]> {
        self.skip_blanks();
        let rest = &self.bytes[self.at..];
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.at += end;
        Some(&rest[..end]).filter(|word| !word.is_empty())
    }

    fn keyword(&mut self) -> Option<String> {
        self.token().map(|word| String::from_utf8_lossy(word).into_owned())
    }

    fn word(&mut self) -> Said<String> {
        self.keyword().ok_or_else(|| "the file ends too early".into())
    }

    fn count(&mut self) -> Said<usize> {
        let word = self.word()?;
        word.parse().map_err(|_| format!("{} is not a count", shown(&word)))
    }

    fn scalar(&mut self) -> Said<Scalar> {
        let word = self.word()?;
        Scalar::of_legacy(&word).ok_or_else(|| format!("{} is not a type of numbers", shown(&word)))
    }

    /// rows x columns numbers, which begin on the next line.
    fn numbers(&mut self, scalar: Scalar, rows: usize, columns: usize) -> Said<Numbers> {
        let n = rows.checked_mul(columns).ok_or("declares too many numbers")?;
        if self.is_text {
            // A number has a digit and a blank.
            if n > self.bytes.len() {
                return Err(format!("declares {n} numbers, more than the file has bytes"));
            }
            let word = |_| self.token().map(|word| str::from_utf8(word).unwrap_or("\u{fffd}"));
            let numbers = scalar.of_words((0..n).map_while(word))?;
            return match numbers.len() == n {
                true => Ok(numbers),
                false => Err(format!("declares {n} numbers, of which some are missing")),
            };
        }
        self.line();
        let size = n.checked_mul(scalar.size());
        let end = size.and_then(|size| self.at.checked_add(size));
        let bytes = end.and_then(|end| self.bytes.get(self.at..end));
        let bytes =
            bytes.ok_or_else(|| format!("declares {n} numbers, of which some are missing"))?;
        self.at += bytes.len();
        Ok(scalar.of_bytes(bytes, false))
    }

    /// The corners of cells, and where those of each end.
    fn cells(&mut self) -> Said<(Vec<i64>, Vec<i64>)> {
        let (n, size) = (self.count()?, self.count()?);
        let before = self.at;
        if self.keyword().is_some_and(|word| word.eq_ignore_ascii_case("OFFSETS")) {
            let scalar = self.scalar()?;
            let offsets = self.numbers(scalar, n, 1)?.integers("OFFSETS")?;
            if !self.word()?.eq_ignore_ascii_case("CONNECTIVITY") {
                return Err("has OFFSETS without CONNECTIVITY".into());
            }
            let scalar = self.scalar()?;
            let corners = self.numbers(scalar, size, 1)?.integers("CONNECTIVITY")?;
            let first = offsets.first().is_none_or(|first| *first == 0);
            return match first {
                true => Ok((corners, offsets.into_iter().skip(1).collect())),
                false => Err("the first of its OFFSETS is not 0".into()),
            };
        }
        self.at = before;
        let numbers = self.numbers(Scalar::I32, size, 1)?.integers("cells")?;
        let (mut corners, mut ends) = (Vec::with_capacity(numbers.len()), Vec::new());
        let mut rest = &numbers[..];
        while let Some((&k, behind)) = rest.split_first() {
            let cell = usize::try_from(k).ok().and_then(|k| behind.split_at_checked(k));
            let (cell, behind) =
                cell.ok_or_else(|| format!("a cell has {k} corners, of which some are missing"))?;
            corners.extend(cell);
            ends.push(i64::try_from(corners.len()).map_err(|_| "has too many corners")?);
            rest = behind;
        }
        match ends.len() == n {
            true => Ok((corners, ends)),
            false => Err(format!("declares {n} cells, but has {}", ends.len())),
        }
    }

    /// Skips this line and all to behind the next empty one.
    fn skip_paragraph(&mut self) {
        self.line();
        while self.at < self.bytes.len() && !self.line().trim_ascii().is_empty() {}
    }

    /// The arrays of an attribute with the given number of rows.
    fn arrays(&mut self, keyword: &str, rows: usize) -> Said<Vec<Array>> {
        let name = decoded(&self.word()?);
        let known = |rows: usize| match rows {
            usize::MAX => Err(format!("{keyword} comes before POINT_DATA and CELL_DATA")),
            rows => Ok(rows),
        };
        let one = |name, components, numbers, full| match components {
            0 => Err(format!("{keyword} has no components")),
            _ => Ok(vec![Array { name, components, numbers, full }]),
        };
        match keyword {
            "SCALARS" => {
                let scalar = self.scalar()?;
                // The number of components may be missing.
                let rest = String::from_utf8_lossy(self.line()).trim().to_owned();
                let components = match &rest[..] {
                    "" => 1,
                    n => n
                        .parse()
                        .map_err(|_| format!("{} is not a number of components", shown(n)))?,
                };
                let before = self.at;
                match self.word()?.eq_ignore_ascii_case("LOOKUP_TABLE") {
                    true => drop(self.word()?),
                    // One line is ended already.
                    false => self.at = before.saturating_sub(1),
                }
                one(
                    name,
                    components,
                    self.numbers(scalar, known(rows)?, components)?,
                    scalar.full(),
                )
            }
            "COLOR_SCALARS" => {
                let components = self.count()?;
                let (scalar, full) =
                    if self.is_text { (Scalar::F32, Some(1.0)) } else { (Scalar::U8, Some(255.0)) };
                let numbers = self.numbers(scalar, known(rows)?, components)?;
                // Colors by what they are, not by their name.
                one("rgb".into(), components, numbers, full)
            }
            "VECTORS" | "NORMALS" => {
                let scalar = self.scalar()?;
                one(name, 3, self.numbers(scalar, known(rows)?, 3)?, None)
            }
            "TENSORS" => {
                let scalar = self.scalar()?;
                one(name, 9, self.numbers(scalar, known(rows)?, 9)?, None)
            }
            "TEXTURE_COORDINATES" => {
                let components = self.count()?;
                let scalar = self.scalar()?;
                one("uv".into(), components, self.numbers(scalar, known(rows)?, components)?, None)
            }
            "GLOBAL_IDS" | "PEDIGREE_IDS" => {
                let scalar = self.scalar()?;
                one(name, 1, self.numbers(scalar, known(rows)?, 1)?, None)
            }
            "LOOKUP_TABLE" => {
                let n = self.count()?;
                let scalar = if self.is_text { Scalar::F32 } else { Scalar::U8 };
                self.numbers(scalar, n, 4).map(|_| Vec::new())
            }
            "FIELD" => self.fields(),
            _ => Err(format!("{} is not a keyword of a legacy file of VTK", shown(keyword))),
        }
    }

    fn fields(&mut self) -> Said<Vec<Array>> {
        let mut n = self.count()?;
        let mut found = Vec::new();
        while found.len() < n {
            let name = self.word()?;
            if name.eq_ignore_ascii_case("METADATA") {
                self.skip_paragraph();
                continue;
            }
            let (components, rows) = (self.count()?, self.count()?);
            if components == 0 {
                return Err(format!("the array {} has no components", shown(&name)));
            }
            let kind = self.word()?;
            if self.is_text && kind.eq_ignore_ascii_case("string") {
                self.line();
                let lines = rows.checked_mul(components).ok_or("declares too many texts")?;
                for _ in 0..lines.min(self.bytes.len()) {
                    self.line();
                }
                n -= 1;
                continue;
            }
            let Some(scalar) = Scalar::of_legacy(&kind) else {
                return Err(format!(
                    "the array {} has the type {}, which cannot be read",
                    shown(&name),
                    shown(&kind)
                ));
            };
            let numbers = self.numbers(scalar, rows, components)?;
            found.push(Array { name: decoded(&name), components, numbers, full: scalar.full() });
        }
        Ok(found)
    }
}

/// A name in which blanks and others are written as %20.
fn decoded(name: &str) -> String {
    let bytes = name.as_bytes();
    let (mut plain, mut at) = (Vec::new(), 0);
    while at < bytes.len() {
        let code = bytes.get(at + 1..at + 3).and_then(|code| str::from_utf8(code).ok());
        match code.and_then(|code| u8::from_str_radix(code, 16).ok()) {
            Some(byte) if bytes[at] == b'%' => {
                plain.push(byte);
                at += 3;
            }
            _ => {
                plain.push(bytes[at]);
                at += 1;
            }
        }
    }
    String::from_utf8_lossy(&plain).into_owned()
}
