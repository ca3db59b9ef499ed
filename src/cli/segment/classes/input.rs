//! The numbers of the classes: `.npy`, `.npz` or `.csv`, one row per vertex or face, or `.gii` and files of FreeSurfer, one
//! row per vertex.

use std::path::Path;

use ndarray::{Array2, Axis, Ix1, Ix2};

use crate::classes::ClassCosts;
use crate::classes::costs::{self, Found};
use crate::counted::counted;
use crate::domain::Element;
use crate::mesh::Mesh;
use crate::mesh::io::{self, Scalars};
use crate::npz::Archive;
use crate::regions::REGIONS;
use crate::{Error, Result, file, npy};

use super::arguments::{ClassArguments, Given};
use super::list;
use crate::cli::memory::Memory;
use crate::cli::note;

/// The costs, and what is worth saying about them.
pub struct Input {
    /// On the mesh of the file.
    pub costs: ClassCosts,
    /// The path.
    pub name: String,
    /// The number of rows where nothing is known.
    pub unknown: usize,
    pub notes: Vec<String>,
    pub warnings: Vec<String>,
}

impl Input {
    /// Reads the file.
    ///
    /// # Errors
    /// It cannot be read or is malformed, has another number of rows than the mesh has vertices or faces, or its
    /// numbers are no probabilities, scores or labels.
    pub fn read(
        mesh: &Mesh,
        given: &Given,
        arguments: &ClassArguments,
        memory: &Memory,
    ) -> Result<Self> {
        let path = given.path();
        let numbers = match given {
            Given::Property(_, name) => property(path, name)?,
            _ => numbers(path, given.what(), memory)?,
        };
        let of = element(path, numbers.nrows(), mesh, arguments.on())?;
        let found = found(&numbers, given, arguments).map_err(|error| error.of_file(path))?;
        let Found { s, unknown, divided } = found;
        let [one, many] = of.nouns();
        let mut notes = Vec::new();
        if divided > 0 {
            notes.push(format!(
                "the {} of {} do not sum to 1 and were divided by their sum",
                given.what(),
                counted(divided, one, many)
            ));
        }
        let mut warnings = Vec::new();
        if let Given::Labels(_) = given {
            let is_there = |label: &i64| numbers.iter().any(|&x| x == *label as f64);
            let absent = arguments.unknown().iter().filter(|label| !is_there(label));
            warnings.extend(
                absent.map(|label| format!("no row has the label {label}, which --unknown names")),
            );
        }
        if unknown > 0 {
            warnings.push(format!(
                "nothing is known of {}; where they are connected to known ones, they take the labels of their neighbors",
                counted(unknown, one, many)
            ));
        }
        let name = path.display().to_string();
        Ok(Input { costs: ClassCosts { s, of }, name, unknown, notes, warnings })
    }
}

fn found(numbers: &Array2<f64>, given: &Given, arguments: &ClassArguments) -> Result<Found> {
    match given {
        Given::Probabilities(_) | Given::Property(..) => {
            costs::of_probabilities(numbers, given.floor(arguments).expect("they have one"))
        }
        Given::Scores(_) => {
            costs::of_scores(numbers, given.floor(arguments).expect("they have one"))
        }
        Given::Labels(_) => {
            let labels = labels(numbers, arguments.unknown())?;
            let largest = (REGIONS.end() - 1) as i64;
            if let Some(row) = labels.iter().position(|label| label.is_some_and(|p| p > largest)) {
                let label = numbers[[row, 0]];
                return Err(Error::unsuitable(format!(
                    "the label in row {row} is {label}: classes are numbered from 0 to {largest}; --unknown {label} marks such \
                     rows as unknown"
                )));
            }
            let m = match arguments.list() {
                Some(path) => list::count(path)?,
                None => {
                    labels.iter().flatten().max().map_or(0, |largest| largest + 1).max(2) as usize
                }
            };
            costs::of_labels(&labels, m, given.confidence(arguments).expect("they have one"))
        }
    }
}

/// One label per row; `None` where it is unknown.
fn labels(numbers: &Array2<f64>, unknown: &[i64]) -> Result<Vec<Option<i64>>> {
    if numbers.ncols() != 1 {
        return Err(Error::unsuitable(format!(
            "has {}; labels have one number per row, class probabilities are given by --probabilities",
            counted(numbers.ncols(), "column", "columns")
        )));
    }
    let label = |(row, &x): (usize, &f64)| {
        if x.is_nan() {
            return Ok(None);
        }
        if x.fract() != 0.0 || x.abs() > 1e15 {
            return Err(Error::unsuitable(format!(
                "the label in row {row} is {x}: labels are integers"
            )));
        }
        let label = x as i64;
        Ok((label != -1 && !unknown.contains(&label)).then_some(label))
    };
    numbers.column(0).iter().enumerate().map(label).collect()
}

/// What the rows are those of.
pub fn element(path: &Path, rows: usize, mesh: &Mesh, on: Option<Element>) -> Result<Element> {
    let [vertices, faces] = [Element::Vertices, Element::Faces].map(|element| element.count(mesh));
    match (rows == vertices, rows == faces, on) {
        (true, true, Some(on)) => Ok(on),
        (true, true, None) => Err(Error::malformed(
            path,
            format!(
                "has {rows} rows, and the mesh has as many vertices as faces; say which with --on vertices or --on faces"
            ),
        )),
        (true, ..) => Ok(Element::Vertices),
        (_, true, _) => Ok(Element::Faces),
        _ => Err(Error::malformed(
            path,
            format!(
                "has {}, but the mesh has {} and {} (a polygon counts as its triangles); supply one row per vertex or per face",
                counted(rows, "row", "rows"),
                counted(vertices, "vertex", "vertices"),
                counted(faces, "face", "faces")
            ),
        )),
    }
}

/// The properties of a PLY mesh, or the arrays of a VTK mesh, whose names match a pattern.
fn property(path: &Path, pattern: &str) -> Result<Array2<f64>> {
    if !path.is_file() {
        let message =
            "--property needs a PLY or VTK mesh; give the numbers as a file with --probabilities";
        return Err(Error::malformed(path, message));
    }
    let Scalars { numbers, names, .. } = io::read_scalars(
        path,
        &file::read(path)?,
        &|element, name| match pattern.split_once(':') {
            Some((of, pattern)) => of == element && matches(pattern, name),
            None => matches(pattern, name),
        },
    )?;
    let properties = if names.len() == 1 { "property" } else { "properties" };
    note(&format!("read from the {properties} {}", names.join(", ")));
    Ok(numbers)
}

/// Whether a name matches a pattern in which * stands for any characters.
fn matches(pattern: &str, name: &str) -> bool {
    let mut parts = pattern.split('*');
    let first = parts.next().expect("a split has a part");
    let Some(mut rest) = name.strip_prefix(first) else { return false };
    let parts: Vec<&str> = parts.collect();
    let Some((last, middle)) = parts.split_last() else { return rest.is_empty() };
    for part in middle {
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    rest.ends_with(last)
}

/// The numbers in a file; entries may be NaN or infinite.
pub fn numbers(path: &Path, what: &str, memory: &Memory) -> Result<Array2<f64>> {
    if let Some(array) = memory.array(path) {
        return Ok(array.clone());
    }
    let extension = path.extension().map(|extension| extension.to_ascii_lowercase());
    match extension.as_ref().and_then(|extension| extension.to_str()) {
        Some("npy") => array(path, &file::read(path)?),
        Some("npz") => {
            let mut archive = Archive::open(path)?;
            let names = archive.names();
            let name = match &names[..] {
                [only] => only.clone(),
                [] => return Err(Error::malformed(path, "has no arrays")),
                _ if archive.has(what) => what.to_owned(),
                _ => {
                    let message = format!(
                        "has the arrays {}; name one of them {what}, or save it alone",
                        names.join(", ")
                    );
                    return Err(Error::malformed(path, message));
                }
            };
            archive.entry(&name, array)
        }
        Some("csv") => table(path),
        _ if io::names_values(path) => io::read_values(path),
        _ => {
            let message =
                "has an unknown format; supply .npy, .npz or .csv, .gii, or a file of FreeSurfer";
            Err(Error::malformed(path, message))
        }
    }
}

/// One or two axes.
fn array(path: &Path, bytes: &[u8]) -> Result<Array2<f64>> {
    match npy::axes(path, bytes)? {
        1 => Ok(npy::numbers::<Ix1>(path, bytes)?.insert_axis(Axis(1))),
        _ => npy::numbers::<Ix2>(path, bytes),
    }
}

/// Numbers separated by commas; the first line may be a header. Empty cells and nan are NaN.
fn table(path: &Path) -> Result<Array2<f64>> {
    let bytes = file::read(path)?;
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .trim(csv::Trim::All)
        .flexible(true)
        .from_reader(&bytes[..]);
    let (mut numbers, mut columns, mut rows) = (Vec::new(), 0, 0);
    let mut is_indexed = false;
    for (index, record) in reader.records().enumerate() {
        let record = record.map_err(|error| Error::malformed(path, error.to_string()))?;
        let line = record.position().map_or(0, csv::Position::line) as usize;
        let number = |cell: &str| match cell.to_ascii_lowercase().as_str() {
            "" | "na" | "n/a" | "null" | "none" => Some(f64::NAN),
            cell => cell.parse::<f64>().ok(),
        };
        if index == 0 && record.iter().all(|cell| number(cell).is_none()) && !is_split(&record) {
            is_indexed = record.len() > 1 && names_rows(&record[0]);
            continue;
        }
        if rows == 0 {
            columns = record.len();
        }
        if record.len() != columns {
            let message = format!("has {} cells; the first row has {columns}", record.len());
            return Err(Error::malformed_line(path, line, message));
        }
        for cell in &record {
            numbers.push(number(cell).ok_or_else(|| {
                let hint = if is_split(&record) { "; separate numbers by commas" } else { "" };
                Error::malformed_line(path, line, format!("`{cell}` is not a number{hint}"))
            })?);
        }
        rows += 1;
    }
    if rows == 0 {
        return Err(Error::malformed(path, "has no rows"));
    }
    let table = Array2::from_shape_vec((rows, columns), numbers).expect("rows of equal length");
    without_index(path, table, is_indexed)
}

/// Whether a row looks as if its numbers were separated by something other than commas.
fn is_split(record: &csv::StringRecord) -> bool {
    let separators = |cell: &str| cell.contains([';', '\t']) || cell.trim().contains(' ');
    record.iter().any(|cell| separators(cell) && cell.contains(|c: char| c.is_ascii_digit()))
}

/// Whether this is the name of a column that counts the rows.
fn names_rows(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    ["face", "vertex", "index", "id", "row"].contains(&name.as_str())
}

/// The table without a first column that counts the rows, which its header must name.
fn without_index(path: &Path, table: Array2<f64>, is_indexed: bool) -> Result<Array2<f64>> {
    let counts = table.column(0).iter().enumerate().all(|(row, &x)| x == row as f64);
    match (is_indexed, counts) {
        (true, true) => Ok(table.slice_move(ndarray::s![.., 1..])),
        (true, false) => {
            let message =
                "has a first column that names the rows, which must be 0, 1, 2, ... in this order";
            Err(Error::malformed(path, message))
        }
        (false, true) if table.ncols() > 2 && table.nrows() > 2 => {
            let message = "has a first column that counts the rows; leave it out, or name it face or vertex in a header";
            Err(Error::malformed(path, message))
        }
        _ => Ok(table),
    }
}
