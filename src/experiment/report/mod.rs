//! Figures, tables and a page, drawn from what is on disk alone.

mod draw;
mod page;
mod pool;
mod quantity;
mod table;
mod why;

#[cfg(test)]
mod tests;

use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use serde_json::json;

use self::page::Shown;
use self::pool::Pool;
use super::figures::{
    Clock, FigureKind, FigureSpec, Measure, Places, TableKind, TableSpec, Target,
};
use super::results::Done;
use super::runner::SHOWN;
use super::spec::Spec;
use super::store::Store;
use crate::error::{Error, Result};
use crate::figure::{self, tex};
use crate::file;

pub use why::{Why, why};

/// What was written.
pub struct Report {
    /// The SVG files of the figures.
    pub figures: Vec<PathBuf>,
    /// The Markdown files of the tables.
    pub tables: Vec<PathBuf>,
    /// `report.html`.
    pub page: PathBuf,
    /// Runs that the report is made of.
    pub runs: usize,
    /// Runs that the file asks for and that are not there.
    pub missing: usize,
    /// Why figures and tables stayed as they were, or are not there, a line each.
    pub kept: Vec<String>,
    /// A figure of the file for which no run has anything to show; all others are written.
    pub empty: Option<Error>,
}

/// Writes `figures/`, `tables/`, `numbers.tex` and `report.html` of the experiment in `folder`.
///
/// Results may come without the labels of their runs, which are large. Then the figures and tables that need them
/// stay as they are.
///
/// # Errors
/// A folder without runs, files in it that are damaged, and what cannot be written.
pub fn report(folder: &Path, version: &str) -> Result<Report> {
    let kept = folder.join("experiment.toml");
    if !kept.is_file() {
        return Err(Error::malformed(
            folder,
            "is no folder of an experiment: it has no experiment.toml; run `meshseg experiment run` first",
        ));
    }
    let name = folder.file_name().map(|name| name.to_string_lossy().into_owned());
    let spec = Spec { name: name.unwrap_or_default(), ..Spec::open(&kept)? };
    let store = Store::open(folder.to_owned())?;
    let done = Done::all(&store)?;
    let pool = Pool::of(&spec, &done);
    let runs = pool.runs().count();
    if runs == 0 {
        return Err(Error::malformed(
            folder,
            "has no runs yet; run `meshseg experiment run` first",
        ));
    }
    let wanted = pool.cells.len() as u64 * spec.repetitions;
    let (figures, tables) = asked(&spec);
    let unlabeled = pool.runs().filter(|run| lacks_labels(run)).count();
    let (mut kept, mut empty) = (Vec::new(), None);
    let mut keep = |path: &Path, stays: bool| {
        kept.push(format!(
            "{} {}: it needs the labels of all runs, and {unlabeled} of {runs} came without labels.npy; \
             `meshseg experiment run --force` makes them",
            path.display(),
            if stays { "stays as it was" } else { "is left out" }
        ));
    };

    let figure_folder = made(folder.join("figures"))?;
    let mut shown = Vec::new();
    let mut figure_paths = Vec::new();
    for figure in &figures {
        let (name, title) = (&figure.name[..], figure.title.as_deref());
        let path = figure_folder.join(format!("{name}.svg"));
        if unlabeled > 0 && figure.quantities().contains(&LABELS) {
            keep(&path, path.is_file());
            if path.is_file() {
                shown.push(Shown::old(title, &path, name)?);
                figure_paths.push(path);
            }
            continue;
        }
        let drawn = draw::draw(&pool, figure);
        if drawn.figure.panels.is_empty() {
            let message = format!(
                "the figure {name:?} has nothing to show: no run has {}",
                figure.quantities().join(" and ")
            );
            empty.get_or_insert(spec.format_error(&figure.places.shown, message));
            continue;
        }
        figure::write(&drawn.figure, &figure_folder, name)?;
        sources(&figure_folder, name, &drawn.sources)?;
        shown.push(Shown::figure(title, &drawn, name)?);
        figure_paths.push(path);
    }
    let table_folder = made(folder.join("tables"))?;
    let (mut table_paths, mut listed) = (Vec::new(), Vec::new());
    let mut numbers = NUMBERS.to_owned();
    for spec in &tables {
        let path = table_folder.join(format!("{}.md", spec.name));
        let mut table = table::table(&pool, spec);
        if unlabeled > 0 && spec.quantities().contains(&LABELS) {
            let old = table_folder.join(format!("{}.csv", spec.name));
            keep(&old, old.is_file());
            if !old.is_file() {
                continue;
            }
            table.read(&old)?;
        } else {
            table.write(&table_folder)?;
            sources(&table_folder, &table.name, &table.sources)?;
        }
        for (name, x) in table.numbers() {
            numbers += &defined(&name, &pool::number(x));
        }
        table_paths.push(path);
        listed.push(table);
    }
    let write = |path: &Path, text: &str| file::write(path, |out| out.write_all(text.as_bytes()));
    write(&folder.join("numbers.tex"), &numbers)?;
    let written = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
    let shown = Shown { figures: shown, tables: &listed, version, written };
    let page = folder.join("report.html");
    write(&page, &page::page(&pool, &store, &shown)?)?;
    Ok(Report {
        figures: figure_paths,
        tables: table_paths,
        page,
        runs,
        missing: (wanted as usize).saturating_sub(runs),
        kept,
        empty,
    })
}

/// The quantity that is computed of labels.
const LABELS: &str = "labels-changed";

/// Whether a run was made with labels that are not there.
fn lacks_labels(run: &Done) -> bool {
    run.labels.is_none() && run.manifest.repetition == 0 && run.summary.vertices <= SHOWN
}

/// What the file asks for; if nothing, decay over both clocks and the times to gaps.
fn asked(spec: &Spec) -> (Vec<FigureSpec>, Vec<TableSpec>) {
    let decay = |name: &str, x: Clock| FigureSpec {
        name: name.into(),
        title: None,
        kind: FigureKind::Decay { x, y: Measure::Suboptimality },
        page: true,
        columns: 2,
        only: None,
        solvers: None,
        places: Places::default(),
    };
    let figures = match &spec.figures[..] {
        [] => vec![
            decay("decay-iterations", Clock::Iterations),
            decay("decay-seconds", Clock::Seconds),
        ],
        figures => figures.to_vec(),
    };
    let tables = match &spec.tables[..] {
        [] => vec![TableSpec {
            name: "time-to-gap".into(),
            title: None,
            kind: TableKind::TimeToGap { gaps: vec![1e-2, 1e-3, 1e-4], to: Target::Certificate },
        }],
        tables => tables.to_vec(),
    };
    (figures, tables)
}

const NUMBERS: &str = "\
% \\result{TABLE/INSTANCE/SOLVER/COLUMN} is a number of a table: the names as they are, with \\%, \\&, \\#, \\$, \\{ and \\}.\n\
\\providecommand{\\result}[1]{\\ifcsname meshseg@\\detokenize{#1}\\endcsname\n\
\x20 \\csname meshseg@\\detokenize{#1}\\endcsname\\else\\textbf{??}\\typeout{There is no result \\detokenize{#1}}\\fi}\n";

/// A number by the name that people type, and by the one that is escaped as a text is.
fn defined(name: &str, value: &str) -> String {
    let define = |name: &str| {
        format!("\\expandafter\\def\\csname meshseg@\\detokenize{{{name}}}\\endcsname{{{value}}}\n")
    };
    let (typed, escaped) = (tex::typed(name), tex::escaped(name));
    define(&typed) + &if escaped == typed { String::new() } else { define(&escaped) }
}

fn made(folder: PathBuf) -> Result<PathBuf> {
    fs::create_dir_all(&folder).map_err(|error| Error::io(&folder, error))?;
    Ok(folder)
}

/// Keeps which runs the numbers of a figure or a table are of.
fn sources(folder: &Path, stem: &str, runs: &[&Done]) -> Result<()> {
    let ids: Vec<&str> = runs.iter().map(|run| run.manifest.id.as_str()).collect();
    file::write(&folder.join(format!("{stem}.runs.json")), |out| {
        serde_json::to_writer_pretty(&mut *out, &json!({ "runs": ids }))?;
        out.write_all(b"\n")
    })
}
