//! Files of VTK in XML: `PolyData` (.vtp) and `UnstructuredGrid` (.vtu), in one piece or several.
//!
//! ```text
//! <VTKFile type="PolyData" byte_order="LittleEndian" header_type="UInt64" compressor="vtkZLibDataCompressor">
//!   <PolyData> <Piece NumberOfPoints="V" NumberOfPolys="F">
//!     <Points> <DataArray type="Float32" NumberOfComponents="3" format="ascii|binary|appended" offset="0"/>
//!     <Polys>  <DataArray Name="connectivity"/> <DataArray Name="offsets"/>
//!     <PointData> <CellData> arrays of V and F rows
//!   <AppendedData encoding="raw|base64"> _...
//! ```
//!
//! The data of several pieces follow one another. Cells of PolyData are in the order of VTK: vertices, lines, polygons,
//! strips. Reference: *VTK File Formats*, <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>.

use std::borrow::Cow;
use std::path::Path;

use super::grid::{Array, Cell, Grid};
use super::numbers::Numbers;
use super::payload::{Appended, Coding};
use crate::error::{Error, Result};
use crate::mesh::io::scalar::Scalar;
use crate::mesh::io::xml::{Tag, Xml};

type Said<T> = std::result::Result<T, String>;

/// Whether this is such a file.
pub fn recognizes(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(1024)];
    start.windows(8).any(|window| window == b"<VTKFile")
}

/// # Errors
/// The content is not a valid file of this kind.
pub fn parse(path: &Path, bytes: &[u8]) -> Result<Grid> {
    let wrong = |message: String| Error::malformed(path, message);
    let (text, appended) = Appended::split(bytes).map_err(wrong)?;
    let mut xml = Xml::new(path, &text);
    let root = xml.child()?.filter(|tag| tag.name == b"VTKFile");
    let root = root.ok_or_else(|| wrong("does not begin with VTKFile".into()))?;
    let kind = root.get("type").unwrap_or_default();
    if !["PolyData", "UnstructuredGrid"].contains(&&kind[..]) {
        return Err(wrong(format!(
            "is a file of the kind {}; only PolyData and UnstructuredGrid have faces",
            shown(&kind)
        )));
    }
    let reader = Reader { coding: coding(&root).map_err(wrong)?, appended };
    let mut grid = Grid::default();
    while let Some(tag) = xml.child()? {
        if tag.name != kind.as_bytes() {
            xml.skip()?;
            continue;
        }
        while let Some(tag) = xml.child()? {
            if tag.name != b"Piece" {
                xml.skip()?;
                continue;
            }
            let piece = Piece::read(tag, &mut xml)?;
            reader.piece(&piece, &kind, &mut grid).map_err(wrong)?;
        }
    }
    Ok(grid)
}

fn shown(text: &str) -> String {
    format!("`{}`", text.chars().take(40).collect::<String>().escape_debug())
}

fn coding(root: &Tag<'_>) -> Said<Coding> {
    Ok(Coding {
        little: root.get("byte_order").as_deref() != Some("BigEndian"),
        wide: match root.get("header_type").as_deref() {
            None | Some("UInt32") => false,
            Some("UInt64") => true,
            Some(_) => return Err("has an unknown header_type".into()),
        },
        compressed: match root.get("compressor").as_deref() {
            None | Some("") => false,
            Some("vtkZLibDataCompressor") => true,
            Some(name) => {
                let name = shown(name);
                return Err(format!(
                    "is compressed by {name}; write it with zlib, or without compression"
                ));
            }
        },
    })
}

/// An array as it is listed, with its text.
struct Listed<'a> {
    tag: Tag<'a>,
    text: Cow<'a, [u8]>,
}

/// A piece: its counts, and the arrays of its sections.
struct Piece<'a> {
    tag: Tag<'a>,
    sections: Vec<(&'a [u8], Vec<Listed<'a>>)>,
}

impl<'a> Piece<'a> {
    fn read(tag: Tag<'a>, xml: &mut Xml<'a>) -> Result<Self> {
        let mut sections = Vec::new();
        while let Some(section) = xml.child()? {
            let mut arrays = Vec::new();
            while let Some(tag) = xml.child()? {
                if tag.name == b"DataArray" {
                    arrays.push(Listed { tag, text: xml.text()? });
                } else {
                    xml.skip()?;
                }
            }
            sections.push((section.name, arrays));
        }
        Ok(Piece { tag, sections })
    }

    /// The arrays of a section, if it is there.
    fn arrays(&self, name: &str) -> Option<&[Listed<'a>]> {
        let found = self.sections.iter().find(|(section, _)| *section == name.as_bytes());
        found.map(|(_, arrays)| &arrays[..])
    }

    /// A number of points or cells; 0 if there is none.
    fn count(&self, name: &str) -> Said<usize> {
        let Some(text) = self.tag.get(name) else { return Ok(0) };
        text.parse().map_err(|_| format!("{name} is not a number"))
    }
}

struct Reader<'a> {
    coding: Coding,
    appended: Option<Appended<'a>>,
}

impl Reader<'_> {
    fn piece(&self, piece: &Piece<'_>, kind: &str, grid: &mut Grid) -> Said<()> {
        let (points, cells) = (grid.points.len() / 3, grid.cells.len());
        let v = piece.count("NumberOfPoints")?;
        if v > 0 {
            let position = piece.arrays("Points").and_then(|arrays| arrays.first());
            let numbers = self.numbers(position.ok_or("has no Points")?, Some((v, 3)))?;
            grid.points.extend(numbers.floats());
        }
        let shift = i64::try_from(points).map_err(|_| "has too many points")?;
        if kind == "PolyData" {
            let parts = [
                ("Verts", Cell::Thin),
                ("Lines", Cell::Thin),
                ("Polys", Cell::Polygon),
                ("Strips", Cell::Strip),
            ];
            for (name, cell) in parts {
                let n = piece.count(&format!("NumberOf{name}"))?;
                let Some(arrays) = piece.arrays(name).filter(|_| n > 0) else { continue };
                let (corners, ends) = self.cells(arrays, n, shift)?;
                grid.add(std::iter::repeat_n(cell, n), corners, ends.into_iter())?;
            }
        } else {
            let n = piece.count("NumberOfCells")?;
            if let Some(arrays) = piece.arrays("Cells").filter(|_| n > 0) {
                let (corners, ends) = self.cells(arrays, n, shift)?;
                let types = self.integers(arrays, "types", Some(n))?;
                let types = types.into_iter().map(Cell::of_type).collect::<Said<Vec<_>>>()?;
                grid.add(types.into_iter(), corners, ends.into_iter())?;
            }
        }
        let rows = [(grid.points.len() / 3 - points, points), (grid.cells.len() - cells, cells)];
        self.data(piece.arrays("PointData"), rows[0], &mut grid.of_points)?;
        self.data(piece.arrays("CellData"), rows[1], &mut grid.of_cells)
    }

    /// The corners of n cells, from `shift` on, and where those of each end.
    fn cells(&self, arrays: &[Listed<'_>], n: usize, shift: i64) -> Said<(Vec<i64>, Vec<i64>)> {
        let mut corners = self.integers(arrays, "connectivity", None)?;
        corners.iter_mut().filter(|v| **v >= 0).for_each(|v| *v = v.saturating_add(shift));
        Ok((corners, self.integers(arrays, "offsets", Some(n))?))
    }

    fn integers(&self, arrays: &[Listed<'_>], name: &str, count: Option<usize>) -> Said<Vec<i64>> {
        let found = arrays.iter().find(|array| array.tag.get("Name").as_deref() == Some(name));
        let array = found.ok_or_else(|| format!("has cells without {name}"))?;
        self.numbers(array, count.map(|n| (n, 1)))?.integers(name)
    }

    /// Adds the arrays with numbers of a piece, whose rows are preceded by others.
    fn data(
        &self,
        arrays: Option<&[Listed<'_>]>,
        (rows, before): (usize, usize),
        all: &mut Vec<Array>,
    ) -> Said<()> {
        for listed in arrays.into_iter().flatten() {
            let name = listed.tag.get("Name").unwrap_or_default();
            let components = match listed.tag.get("NumberOfComponents") {
                None => 1,
                Some(text) => {
                    text.parse().ok().filter(|n| (1..=1024).contains(n)).ok_or_else(|| {
                        format!("the array {} has no usable number of components", shown(&name))
                    })?
                }
            };
            let scalar = scalar(listed)?;
            let numbers = self.numbers(listed, Some((rows, components)))?;
            match all.iter_mut().find(|array| array.name == name && array.components == components)
            {
                None if before == 0 => {
                    all.push(Array { name, components, numbers, full: scalar.full() });
                }
                Some(array) if array.numbers.len() == before * components => {
                    array.numbers.extend(numbers);
                }
                // Not of all pieces.
                _ => {}
            }
        }
        all.retain(|array| array.numbers.len() == (before + rows) * array.components);
        Ok(())
    }

    /// The numbers of an array; `shape` are its rows and components, if they are known.
    fn numbers(&self, array: &Listed<'_>, shape: Option<(usize, usize)>) -> Said<Numbers> {
        let scalar = scalar(array)?;
        let product = |(rows, columns): (usize, usize)| rows.checked_mul(columns);
        let wanted = match shape.map(product) {
            Some(None) => return Err("has too many numbers".into()),
            wanted => wanted.flatten(),
        };
        let numbers = self.unchecked(array, scalar).and_then(|numbers| match wanted {
            Some(wanted) if numbers.len() != wanted => {
                Err(format!("it has {} numbers; it needs {wanted}", numbers.len()))
            }
            _ => Ok(numbers),
        });
        let name = array.tag.get("Name").unwrap_or_else(|| "of points".into());
        numbers.map_err(|message| format!("the array {}: {message}", shown(&name)))
    }

    fn unchecked(&self, array: &Listed<'_>, scalar: Scalar) -> Said<Numbers> {
        match array.tag.get("format").as_deref() {
            None | Some("ascii") => {
                let text = str::from_utf8(&array.text).map_err(|_| "is not text")?;
                scalar.of_words(text.split_ascii_whitespace())
            }
            Some("binary") => self.of_bytes(scalar, &self.coding.base64(&array.text)?),
            Some("appended") => {
                let offset = array.tag.get("offset").and_then(|text| text.parse().ok());
                let found = self.appended.as_ref().zip(offset);
                let (appended, offset) = found.ok_or("is appended, but there are no such data")?;
                self.of_bytes(scalar, &appended.at(offset, &self.coding)?)
            }
            Some(_) => Err("has an unknown format".into()),
        }
    }

    fn of_bytes(&self, scalar: Scalar, bytes: &[u8]) -> Said<Numbers> {
        if !bytes.len().is_multiple_of(scalar.size()) {
            let (n, size) = (bytes.len(), scalar.size());
            return Err(format!("its {n} bytes are not numbers of {size} bytes"));
        }
        Ok(scalar.of_bytes(bytes, self.coding.little))
    }
}

fn scalar(array: &Listed<'_>) -> Said<Scalar> {
    let name = array.tag.get("type").unwrap_or_default();
    Scalar::of_xml(&name).ok_or_else(|| format!("an array has the type {}", shown(&name)))
}
