//! `--pairs`: how much cuts between each two labels weigh.
//!
//! ```text
//! a,b,weight             0,1,3        a table (.csv) with this header, one pair per line, the others weigh 1;
//! roof,ground,3          1,0,1        or all weights, a row and a column per label (.csv or .npy)
//! wall,2,0.5             3,1,0
//! ```

use std::path::Path;

use ndarray::Array2;

use crate::experiment::did_you_mean;
use crate::relaxation::{LabelMetric, Relaxation};
use crate::{Error, Result, file};

use super::memory::Memory;

/// The labels whose pairs are weighted.
#[derive(Clone, Copy)]
pub struct Labels<'a> {
    /// m.
    pub count: usize,
    /// Their names; empty if they have none.
    pub names: &'a [&'a str],
}

/// The relaxation in which pairs of m labels weigh what a file says, if there is one.
///
/// # Errors
/// The file cannot be read or is malformed, or its weights are no metric on the labels.
pub fn relaxation(
    path: Option<&Path>,
    labels: Labels<'_>,
    memory: &Memory,
) -> Result<Option<Relaxation>> {
    let Some(path) = path else { return Ok(None) };
    let is_array = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("npy"));
    let d = match is_array || memory.array(path).is_some() {
        true => memory.matrix(path)?.into_owned(),
        false => table(path, labels)?,
    };
    let (rows, columns) = d.dim();
    if (rows, columns) != (labels.count, labels.count) {
        let m = labels.count;
        let message = format!("has {rows} x {columns} weights, but {m} labels need {m} x {m}");
        return Err(Error::malformed(path, message));
    }
    let metric = LabelMetric::new(&d).map_err(|error| error.of_file(path))?;
    Ok(Some(Relaxation::Metric(metric)))
}

/// The weights in a table.
fn table(path: &Path, labels: Labels<'_>) -> Result<Array2<f64>> {
    let bytes = file::read(path)?;
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(&bytes[..]);
    let mut records = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| Error::malformed(path, error.to_string()))?;
        let line = record.position().map_or(0, |position| position.line() as usize);
        records.push((line, record));
    }
    match records.split_first() {
        None => Err(Error::malformed(path, "has no weights")),
        Some(((_, header), rows))
            if header.iter().map(str::to_ascii_lowercase).eq(["a", "b", "weight"]) =>
        {
            listed(path, rows, labels)
        }
        Some(_) => matrix(path, &records),
    }
}

fn number(path: &Path, line: usize, cell: &str) -> Result<f64> {
    cell.parse().map_err(|_| {
        let what_to_do = match cell.contains([';', '\t']) {
            true => "separate cells by commas",
            false => {
                "write a row of weights for each label, or the line `a,b,weight` and pairs below it"
            }
        };
        let message = format!("`{}` is not a number; {what_to_do}", cell.escape_debug());
        Error::malformed_line(path, line, message)
    })
}

fn matrix(path: &Path, records: &[(usize, csv::StringRecord)]) -> Result<Array2<f64>> {
    let columns = records[0].1.len();
    let mut weights = Vec::new();
    for (line, record) in records {
        if record.len() != columns {
            let message = format!("has {} cells; the first row has {columns}", record.len());
            return Err(Error::malformed_line(path, *line, message));
        }
        for cell in record {
            weights.push(number(path, *line, cell)?);
        }
    }
    Ok(Array2::from_shape_vec((records.len(), columns), weights).expect("rows of equal length"))
}

fn listed(
    path: &Path,
    rows: &[(usize, csv::StringRecord)],
    labels: Labels<'_>,
) -> Result<Array2<f64>> {
    let m = labels.count;
    let mut weights = Array2::from_shape_fn((m, m), |(a, b)| f64::from(u8::from(a != b)));
    let mut given = Array2::from_elem((m, m), false);
    for &(line, ref record) in rows {
        let wrong = |message: String| Error::malformed_line(path, line, message);
        let cells: Vec<&str> = record.iter().collect();
        let [a, b, weight] = cells[..] else {
            return Err(wrong(format!("has {} cells; a,b,weight are three", record.len())));
        };
        let weight = number(path, line, weight)?;
        let [p, r] = [label(a, labels), label(b, labels)];
        let [p, r] = [p.map_err(wrong)?, r.map_err(wrong)?];
        if p == r {
            return Err(wrong(format!(
                "`{a}` and `{b}` are one label: between its parts there is no cut"
            )));
        }
        if given[[p, r]] {
            return Err(wrong(format!("`{a}` and `{b}` have a weight already")));
        }
        for pair in [[p, r], [r, p]] {
            (weights[pair], given[pair]) = (weight, true);
        }
    }
    Ok(weights)
}

/// The index of a label of this name or number.
fn label(text: &str, labels: Labels<'_>) -> std::result::Result<usize, String> {
    if let Some(p) = labels.names.iter().position(|name| *name == text) {
        return Ok(p);
    }
    match text.parse::<usize>() {
        Ok(p) if p < labels.count => Ok(p),
        Ok(_) => Err(format!("there is no label {text}: they are 0 to {}", labels.count - 1)),
        Err(_) if labels.names.is_empty() => {
            Err(format!("`{text}` is no number of a label; names need --classes"))
        }
        Err(_) => {
            let meant = did_you_mean(text, labels.names.iter().copied());
            Err(format!("no class is called `{text}`{meant}"))
        }
    }
}
