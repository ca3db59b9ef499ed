//! Tables and their formats: CSV, Markdown, booktabs LaTeX.

use std::path::Path;

use super::super::figures::{Clock, NameColumn, TableKind, TableSpec, Target};
use super::super::quoting::one_line;
use super::super::results::Done;
use super::super::variable::Variable;
use super::cell_value::{CellValue, value_of};
use super::pool::{Cell, Pool, given, latex, number};
use crate::error::{Error, Result};
use crate::figure::tex;
use crate::file;

pub struct Table<'a> {
    pub name: String,
    pub title: String,
    pub columns: Vec<String>,
    pub rows: Vec<Vec<TableEntry>>,
    /// Columns of names that are left out in LaTeX.
    pub without: Vec<NameColumn>,
    /// The runs behind its numbers.
    pub sources: Vec<&'a Done>,
}

#[derive(Clone, Debug, PartialEq)]
pub enum TableEntry {
    Text(String),
    Number(f64),
    /// The gap was not reached; the text says how far the run came.
    Censored(String),
    Nothing,
}

impl TableEntry {
    pub fn text(&self) -> String {
        match self {
            TableEntry::Text(text) | TableEntry::Censored(text) => text.clone(),
            TableEntry::Number(x) => number(*x),
            TableEntry::Nothing => String::new(),
        }
    }

    fn latex(&self) -> String {
        match self {
            TableEntry::Number(x) => latex(*x),
            entry => tex::escaped(&entry.text()),
        }
    }
}

pub fn table<'a>(pool: &Pool<'a>, spec: &TableSpec) -> Table<'a> {
    let cells = pool.selected(&spec.selection);
    let (default, columns, rows) = match &spec.kind {
        TableKind::TimeToGap { gaps, to, clocks } => time_to_gap(pool, &cells, gaps, *to, clocks),
        TableKind::Cells { columns } => variables_of(pool, &cells, columns),
    };
    Table {
        name: spec.name.clone(),
        title: spec.title.clone().unwrap_or(default),
        columns,
        rows,
        without: spec.without.clone(),
        sources: cells.iter().flat_map(|cell| cell.runs.iter().copied()).collect(),
    }
}

type Content = (String, Vec<String>, Vec<Vec<TableEntry>>);

/// A row for each cell, with iterations and median seconds for each gap.
fn time_to_gap(
    pool: &Pool<'_>,
    cells: &[&Cell<'_>],
    gaps: &[f64],
    to: Target,
    clocks: &[Clock],
) -> Content {
    let mut columns = vec!["instance".to_owned(), "solver".to_owned()];
    for clock in clocks {
        columns.extend(gaps.iter().map(|&gap| format!("{} to {}", clock.label(), given(gap))));
    }
    let row = |cell: &&Cell<'_>| {
        let mut row = vec![
            TableEntry::Text(pool.instance(cell).label.clone()),
            TableEntry::Text(pool.solver(cell).label.clone()),
        ];
        for &clock in clocks {
            row.extend(gaps.iter().map(|&gap| match pool.time_to(cell, clock, gap, to) {
                None => TableEntry::Nothing,
                Some(spread) if spread.median.is_finite() => TableEntry::Number(spread.median),
                Some(_) => {
                    TableEntry::Censored(match cell.runs.first().and_then(|run| run.trace.last()) {
                        Some(last) => {
                            let gap = match to {
                                Target::Certificate => last.relative_gap.unwrap_or(f64::NAN),
                                Target::Optimum => pool.peers(cell).suboptimality(last.energy),
                            };
                            format!("> {} ({gap:.0e})", number(clock.of(last)))
                        }
                        None => String::new(),
                    })
                }
            }));
        }
        row
    };
    let what = match clocks {
        [Clock::Seconds] => "Seconds in steps",
        [Clock::Iterations] => "Iterations",
        _ => "Iterations and seconds in steps",
    };
    let title = match to {
        Target::Certificate => format!("{what} to certified gaps"),
        Target::Optimum => format!("{what} to within a share of the optimum"),
    };
    (title, columns, cells.iter().map(row).collect())
}

fn variables_of(pool: &Pool<'_>, cells: &[&Cell<'_>], variables: &[Variable]) -> Content {
    let mut columns = vec!["instance".to_owned(), "solver".to_owned()];
    columns.extend(variables.iter().map(|variable| variable.short_name().replace('-', " ")));
    let row = |cell: &&Cell<'_>| {
        let mut row = vec![
            TableEntry::Text(pool.instance(cell).label.clone()),
            TableEntry::Text(pool.solver(cell).label.clone()),
        ];
        row.extend(variables.iter().map(|variable| match value_of(pool, cell, variable, None) {
            CellValue::Number(spread) => TableEntry::Number(spread.median),
            CellValue::Text(text) => TableEntry::Text(text),
            CellValue::Nothing => TableEntry::Nothing,
        }));
        row
    };
    ("Runs".to_owned(), columns, cells.iter().map(row).collect())
}

impl Table<'_> {
    /// Writes `name.csv`, `name.md` and `name.tex`.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let path = |extension: &str| folder.join(format!("{}.{extension}", self.name));
        let write = |extension: &str, text: String| {
            file::write(&path(extension), |out| out.write_all(text.as_bytes()))
        };
        write("csv", self.csv().map_err(|error| Error::io(&path("csv"), error))?)?;
        write("md", self.markdown())?;
        write("tex", self.latex())
    }

    /// Takes the rows of a table that was written earlier.
    ///
    /// # Errors
    /// The file is not a table.
    pub fn read(&mut self, path: &Path) -> Result<()> {
        let bytes = file::read(path)?;
        let malformed = |error: csv::Error| Error::malformed(path, error.to_string());
        let mut csv = csv::Reader::from_reader(&bytes[..]);
        let names = csv.headers().map_err(malformed)?;
        self.columns = names.iter().map(|name| of_cell(name).to_owned()).collect();
        let entry = |(column, text): (usize, &str)| match text.parse() {
            _ if text.is_empty() => TableEntry::Nothing,
            Ok(x) if column >= 2 => TableEntry::Number(x),
            _ if text.starts_with("> ") => TableEntry::Censored(text.into()),
            _ => TableEntry::Text(of_cell(text).into()),
        };
        let row = |row: csv::Result<csv::StringRecord>| {
            Ok(row.map_err(malformed)?.iter().enumerate().map(entry).collect())
        };
        self.rows = csv.records().map(row).collect::<Result<_>>()?;
        if self.columns.len() < 2 {
            return Err(Error::malformed(path, "is not a table of a report"));
        }
        Ok(())
    }

    /// The table as CSV, with numbers in full precision.
    fn csv(&self) -> std::io::Result<String> {
        let mut csv = csv::Writer::from_writer(Vec::new());
        csv.write_record(self.columns.iter().map(|name| cell(name)))?;
        for row in &self.rows {
            csv.write_record(row.iter().map(|entry| match entry {
                TableEntry::Number(x) => x.to_string(),
                entry => cell(&entry.text()),
            }))?;
        }
        let bytes = csv.into_inner().map_err(csv::IntoInnerError::into_error)?;
        String::from_utf8(bytes).map_err(std::io::Error::other)
    }

    pub fn markdown(&self) -> String {
        let line = |entries: Vec<String>| format!("| {} |\n", entries.join(" | "));
        let rule = |i: usize| if self.is_numeric(i) { "---:" } else { "---" }.to_owned();
        let mut text = format!("{}\n\n", markdown(&self.title));
        text += &line(self.columns.iter().map(|column| markdown(column)).collect());
        text += &line((0..self.columns.len()).map(rule).collect());
        for row in &self.rows {
            text += &line(row.iter().map(|entry| markdown(&entry.text())).collect());
        }
        text
    }

    /// Without the columns that are not wanted, and those of the instance and the solver if there is only one.
    fn latex(&self) -> String {
        let names = [NameColumn::Instance, NameColumn::Solver];
        let is_shown = |i: usize| match names.get(i) {
            Some(name) if self.without.contains(name) => false,
            Some(_) => self.rows.windows(2).any(|pair| pair[0][i] != pair[1][i]),
            None => true,
        };
        let shown: Vec<usize> = (0..self.columns.len()).filter(|&i| is_shown(i)).collect();
        let columns: String =
            shown.iter().map(|&i| if self.is_numeric(i) { 'r' } else { 'l' }).collect();
        let line = |entries: Vec<String>| {
            let entries: Vec<&str> = shown.iter().map(|&i| &entries[i][..]).collect();
            format!("{} \\\\\n", entries.join(" & "))
        };
        let mut text = format!("% {}: needs the package booktabs\n", one_line(&self.title));
        text += &format!("\\begin{{tabular}}{{{columns}}}\n\\toprule\n");
        text += &line(self.columns.iter().map(|name| tex::escaped(name)).collect());
        text += "\\midrule\n";
        for row in &self.rows {
            text += &line(row.iter().map(TableEntry::latex).collect());
        }
        text + "\\bottomrule\n\\end{tabular}\n"
    }

    /// Whether a column holds at least one number and no text.
    pub fn is_numeric(&self, column: usize) -> bool {
        let mut entries = self.rows.iter().map(|row| &row[column]);
        entries.clone().any(|entry| matches!(entry, TableEntry::Number(_)))
            && entries.all(|entry| !matches!(entry, TableEntry::Text(_)))
    }

    /// Every number with its name `table/instance/solver/column`.
    pub fn numbers(&self) -> impl Iterator<Item = (String, f64)> + '_ {
        self.rows.iter().flat_map(move |row| {
            let name = |column: &str| {
                format!("{}/{}/{}/{column}", self.name, row[0].text(), row[1].text())
            };
            let entries = row.iter().zip(&self.columns);
            entries.filter_map(move |(entry, column)| match entry {
                TableEntry::Number(x) => Some((name(column), *x)),
                _ => None,
            })
        })
    }
}

/// A text as a cell of CSV. A spreadsheet computes what begins as a formula, unless an apostrophe comes first.
fn cell(text: &str) -> String {
    match is_formula(text.trim_start_matches('\'')) {
        true => format!("'{text}"),
        false => text.to_owned(),
    }
}

/// The text of such a cell.
fn of_cell(cell: &str) -> &str {
    match cell.strip_prefix('\'') {
        Some(text) if is_formula(text.trim_start_matches('\'')) => text,
        _ => cell,
    }
}

/// Whether a text begins as a formula, and is more than numbers with commas between them.
fn is_formula(text: &str) -> bool {
    let is_number = |part: &str| part.trim().parse::<f64>().is_ok();
    text.starts_with(['=', '+', '-', '@', '\t', '\r']) && !text.split(',').all(is_number)
}

/// Escapes a text for Markdown: markup, tags and cell borders.
fn markdown(text: &str) -> String {
    let mut escaped = String::new();
    let mut before = ' ';
    for (i, c) in text.char_indices() {
        let after = text[i + c.len_utf8()..].chars().next().unwrap_or(' ');
        match c {
            '<' => escaped += "&lt;",
            '&' if after.is_ascii_alphabetic() || after == '#' => escaped += "&amp;",
            c if c.is_control() => escaped.push(' '),
            // Within a word it is not markup.
            '_' if before.is_alphanumeric() && after.is_alphanumeric() => escaped.push(c),
            '\\' | '|' | '*' | '`' | '[' | ']' | '$' | '_' => {
                escaped.push('\\');
                escaped.push(c);
            }
            c => escaped.push(c),
        }
        before = c;
    }
    escaped
}
