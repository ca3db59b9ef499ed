//! Tables, and their forms: CSV, Markdown, booktabs LaTeX.

use std::path::Path;

use super::super::figures::{Clock, TableKind, TableSpec, Target};
use super::super::results::Done;
use super::pool::{Cell, Pool, given, number};
use super::quantity::{Shown, quantity};
use crate::error::{Error, Result};
use crate::file;

pub struct Table<'a> {
    pub name: String,
    pub title: String,
    pub columns: Vec<String>,
    pub rows: Vec<Vec<Entry>>,
    /// The runs that its numbers are of.
    pub sources: Vec<&'a Done>,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Entry {
    Text(String),
    Number(f64),
    /// Not reached, and how far the run came.
    Censored(String),
    Nothing,
}

impl Entry {
    pub fn text(&self) -> String {
        match self {
            Entry::Text(text) | Entry::Censored(text) => text.clone(),
            Entry::Number(x) => number(*x),
            Entry::Nothing => String::new(),
        }
    }
}

pub fn table<'a>(pool: &Pool<'a>, spec: &TableSpec) -> Table<'a> {
    let (default, columns, rows) = match &spec.kind {
        TableKind::TimeToGap { gaps, to } => time_to_gap(pool, gaps, *to),
        TableKind::Cells { columns } => cells(pool, columns),
    };
    Table {
        name: spec.name.clone(),
        title: spec.title.clone().unwrap_or(default),
        columns,
        rows,
        sources: pool.runs().collect(),
    }
}

type Content = (String, Vec<String>, Vec<Vec<Entry>>);

/// A row for each cell, iterations and median seconds for each gap.
fn time_to_gap(pool: &Pool<'_>, gaps: &[f64], to: Target) -> Content {
    let mut columns = vec!["instance".to_owned(), "solver".to_owned()];
    columns.extend(gaps.iter().map(|&gap| format!("iterations to {}", given(gap))));
    columns.extend(gaps.iter().map(|&gap| format!("seconds to {}", given(gap))));
    let row = |cell: &Cell<'_>| {
        let mut row = vec![
            Entry::Text(pool.instance(cell).label.clone()),
            Entry::Text(pool.solver(cell).label.clone()),
        ];
        for clock in [Clock::Iterations, Clock::Seconds] {
            row.extend(gaps.iter().map(|&gap| match pool.time_to(cell, clock, gap, to) {
                None => Entry::Nothing,
                Some(spread) if spread.median.is_finite() => Entry::Number(spread.median),
                Some(_) => {
                    Entry::Censored(match cell.runs.first().and_then(|run| run.trace.last()) {
                        Some(last) => {
                            let gap = match to {
                                Target::Certificate => last.relative_gap,
                                Target::Optimum => pool.suboptimality(cell.instance, last.energy),
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
    let title = match to {
        Target::Certificate => "Iterations and seconds in steps to certified gaps",
        Target::Optimum => "Iterations and seconds in steps to within a share of the optimum",
    };
    (title.to_owned(), columns, pool.cells.iter().map(row).collect())
}

fn cells(pool: &Pool<'_>, names: &[String]) -> Content {
    let mut columns = vec!["instance".to_owned(), "solver".to_owned()];
    columns.extend(
        names.iter().map(|name| name.strip_prefix("options.").unwrap_or(name).replace('-', " ")),
    );
    let row = |cell: &Cell<'_>| {
        let mut row = vec![
            Entry::Text(pool.instance(cell).label.clone()),
            Entry::Text(pool.solver(cell).label.clone()),
        ];
        row.extend(names.iter().map(|name| match quantity(pool, cell, name, None) {
            Shown::Number(spread) => Entry::Number(spread.median),
            Shown::Text(text) => Entry::Text(text),
            Shown::Nothing => Entry::Nothing,
        }));
        row
    };
    ("Runs".to_owned(), columns, pool.cells.iter().map(row).collect())
}

impl Table<'_> {
    /// Writes `name.csv`, `name.md` and `name.tex`.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, folder: &Path) -> Result<()> {
        let path = |extension: &str| folder.join(format!("{}.{extension}", self.name));
        let write = |extension: &str, text: String| {
            file::write(&path(extension), |out| out.write_all(text.as_bytes()))
        };
        write("csv", self.csv().map_err(|error| Error::io(&path("csv"), error))?)?;
        write("md", self.markdown())?;
        write("tex", self.latex())
    }

    /// Whole numbers, in full precision.
    fn csv(&self) -> std::io::Result<String> {
        let mut csv = csv::Writer::from_writer(Vec::new());
        csv.write_record(&self.columns)?;
        for row in &self.rows {
            csv.write_record(row.iter().map(|entry| match entry {
                Entry::Number(x) => x.to_string(),
                entry => entry.text(),
            }))?;
        }
        let bytes = csv.into_inner().map_err(csv::IntoInnerError::into_error)?;
        String::from_utf8(bytes).map_err(std::io::Error::other)
    }

    pub fn markdown(&self) -> String {
        let line = |entries: Vec<String>| format!("| {} |\n", entries.join(" | "));
        let escape = |text: String| text.replace('|', "\\|");
        let rule = |i: usize| if self.is_numeric(i) { "---:" } else { "---" }.to_owned();
        let mut text = format!("{}\n\n", self.title);
        text += &line(self.columns.clone());
        text += &line((0..self.columns.len()).map(rule).collect());
        for row in &self.rows {
            text += &line(row.iter().map(|entry| escape(entry.text())).collect());
        }
        text
    }

    fn latex(&self) -> String {
        let columns: String =
            (0..self.columns.len()).map(|i| if self.is_numeric(i) { 'r' } else { 'l' }).collect();
        let line = |entries: Vec<String>| {
            let entries: Vec<String> = entries.iter().map(|text| latex(text)).collect();
            format!("{} \\\\\n", entries.join(" & "))
        };
        let mut text = format!("% {}: needs the package booktabs\n", self.title);
        text += &format!("\\begin{{tabular}}{{{columns}}}\n\\toprule\n");
        text += &line(self.columns.clone());
        text += "\\midrule\n";
        for row in &self.rows {
            text += &line(row.iter().map(Entry::text).collect());
        }
        text + "\\bottomrule\n\\end{tabular}\n"
    }

    /// Whether a column holds numbers, at least one.
    pub fn is_numeric(&self, column: usize) -> bool {
        let mut entries = self.rows.iter().map(|row| &row[column]);
        entries.clone().any(|entry| matches!(entry, Entry::Number(_)))
            && entries.all(|entry| !matches!(entry, Entry::Text(_)))
    }

    /// Every number with a name: `table/instance/solver/column`.
    pub fn numbers(&self) -> impl Iterator<Item = (String, f64)> + '_ {
        self.rows.iter().flat_map(move |row| {
            let name = |column: &str| {
                format!("{}/{}/{}/{column}", self.name, row[0].text(), row[1].text())
            };
            let entries = row.iter().zip(&self.columns);
            entries.filter_map(move |(entry, column)| match entry {
                Entry::Number(x) => Some((name(column), *x)),
                _ => None,
            })
        })
    }
}

/// A text with what LaTeX takes for commands escaped.
pub fn latex(text: &str) -> String {
    let mut escaped = String::new();
    for c in text.chars() {
        match c {
            '\\' => escaped += "\\textbackslash{}",
            '~' => escaped += "\\textasciitilde{}",
            '^' => escaped += "\\textasciicircum{}",
            '<' => escaped += "\\textless{}",
            '>' => escaped += "\\textgreater{}",
            '#' | '$' | '%' | '&' | '_' | '{' | '}' => {
                escaped.push('\\');
                escaped.push(c);
            }
            c => escaped.push(c),
        }
    }
    escaped
}
