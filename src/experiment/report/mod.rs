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
use super::figures::{Clock, FigureKind, FigureSpec, Measure, TableKind, TableSpec, Target};
use super::results::Done;
use super::spec::Spec;
use super::store::Store;
use crate::error::{Error, Result};
use crate::{figure, file};

pub use why::{Why, why};

/// What was written.
pub struct Report {
    pub figures: Vec<PathBuf>,
    pub tables: Vec<PathBuf>,
    pub page: PathBuf,
    pub runs: usize,
    /// Runs that the file asks for and that are not there.
    pub missing: usize,
}

/// Writes `figures/`, `tables/`, `numbers.tex` and `report.html` of the experiment in `folder`.
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

    let figure_folder = made(folder.join("figures"))?;
    let mut shown = Vec::new();
    let mut figure_paths = Vec::new();
    for spec in &figures {
        let drawn = draw::draw(&pool, spec);
        figure::write(&drawn.figure, &figure_folder, &spec.name)?;
        sources(&figure_folder, &spec.name, &drawn.sources)?;
        shown.push(Shown::figure(spec.title.as_deref(), &drawn, &spec.name)?);
        figure_paths.push(figure_folder.join(format!("{}.svg", spec.name)));
    }
    let table_folder = made(folder.join("tables"))?;
    let tables: Vec<table::Table<'_>> =
        tables.iter().map(|spec| table::table(&pool, spec)).collect();
    let mut numbers = NUMBERS.to_owned();
    for table in &tables {
        table.write(&table_folder)?;
        sources(&table_folder, &table.name, &table.sources)?;
        for (name, x) in table.numbers() {
            let value = pool::number(x);
            numbers +=
                &format!("\\expandafter\\def\\csname meshseg@{name}\\endcsname{{{value}}}\n");
        }
    }
    let write = |path: &Path, text: &str| file::write(path, |out| out.write_all(text.as_bytes()));
    write(&folder.join("numbers.tex"), &numbers)?;
    let written = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
    let shown = Shown { figures: shown, tables: &tables, version, written };
    let page = folder.join("report.html");
    write(&page, &page::page(&pool, &store, &shown)?)?;
    let tables =
        tables.iter().map(|table| table_folder.join(format!("{}.md", table.name))).collect();
    Ok(Report {
        figures: figure_paths,
        tables,
        page,
        runs,
        missing: (wanted as usize).saturating_sub(runs),
    })
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

const NUMBERS: &str = "% \\result{TABLE/INSTANCE/SOLVER/COLUMN} is a number of a table.\n\
    \\providecommand{\\result}[1]{\\csname meshseg@#1\\endcsname}\n";

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
