//! Figures, tables and a page, drawn from the files of the runs alone.

mod caption;
mod cell_value;
mod draw;
mod evolution;
mod latex;
mod page;
mod photographs;
mod pool;
mod relation;
mod requested;
mod surface;
mod table;
mod why;
mod written;

#[cfg(test)]
mod tests;

use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use self::page::{PageContent, PageFigure};
use self::pool::Pool;
use self::requested::requested;
use self::surface::DrawnSurfaces;
use self::table::Table;
use super::figures::{FigureKind, FigureSpec, TableSpec};
use super::results::Done;
use super::spec::Spec;
use super::store::MAX_SHOWN_VERTICES;
use super::store::Store;
use super::variable::{Quantity, Variable};
use crate::counted::counted;
use crate::error::{Error, Result};
use crate::figure::{self, Formats};
use crate::file;

pub use why::{Why, why};
use written::{WrittenFigures, write_sources};

/// The files that were written.
pub struct Report {
    /// The files of the figures: SVG, and PNG of surfaces, with a page of the same name on which they can be turned.
    pub figures: Vec<PathBuf>,
    /// The Markdown files of the tables.
    pub tables: Vec<PathBuf>,
    /// `report.html`.
    pub page: PathBuf,
    /// Number of runs that the report is made of.
    pub runs: usize,
    /// Number of runs of the experiment that are missing.
    pub missing: usize,
    /// Why figures and tables are unchanged or left out, a line each.
    pub kept: Vec<String>,
    /// A figure of the file for which no run has anything to show; all others are written.
    pub empty: Option<Error>,
    /// The names of all figures and tables of the file.
    pub names: Vec<String>,
}

/// Writes `figures/`, `tables/`, `numbers.tex` and `report.html` of the experiment in `folder`.
///
/// Results may come without the labels of their runs, which are large. Then the figures and tables that need them are
/// not written again.
///
/// # Errors
/// The folder has no runs, files in it are damaged, or a file cannot be written.
pub fn report(folder: &Path, version: &str) -> Result<Report> {
    write_report(folder, folder, version, Formats::All)
}

/// The report without pictures, PNG and page, written into another folder; what is not written again is looked for there.
///
/// # Errors
/// As [`report`].
pub fn report_vector(folder: &Path, into: &Path, version: &str) -> Result<Report> {
    write_report(folder, into, version, Formats::Vector)
}

fn write_report(folder: &Path, into: &Path, version: &str, formats: Formats) -> Result<Report> {
    let spec = kept_spec(folder)?;
    let store = Store::open(folder.to_owned())?;
    let done = Done::all(&store)?;
    let pool = Pool::of(&spec, &done);
    let runs = pool.runs().count();
    if runs == 0 {
        let message = match done.len() {
            0 => "has no runs yet; run `meshseg experiment run` first".to_owned(),
            others => format!(
                "has {}, but none of its experiment.toml; `meshseg experiment run` makes those",
                counted(others, "run", "runs")
            ),
        };
        return Err(Error::malformed(folder, message));
    }
    let wanted = pool.cells.len() as u64 * spec.repetitions;
    let (figures, tables) = requested(&spec);
    let names = figures.iter().map(|figure| &figure.name);
    let names = names.chain(tables.iter().map(|table| &table.name)).cloned().collect();
    let unlabeled =
        Unlabeled { lacking: pool.runs().filter(|run| lacks_labels(run)).count(), runs };
    let shown = created(into.join("figures"))?;
    let program = format!("meshseg {version}");
    let target = Target { folder: &shown, formats, program: &program };
    let figures = write_figures(&pool, &store, &figures, &unlabeled, &target)?;
    let tables = write_tables(&pool, &tables, &unlabeled, &created(into.join("tables"))?)?;

    let write = |path: &Path, text: &str| file::write(path, |out| out.write_all(text.as_bytes()));
    write(&into.join("numbers.tex"), &latex::numbers(&pool, &tables.listed, &figures.shown))?;
    let page = into.join("report.html");
    if formats == Formats::All {
        let content = PageContent {
            figures: figures.shown,
            tables: &tables.listed,
            program: &program,
            written: humantime::format_rfc3339_seconds(SystemTime::now()).to_string(),
        };
        write(&page, &page::page(&pool, &store, &content)?)?;
    }
    Ok(Report {
        figures: figures.paths,
        tables: tables.paths,
        page,
        runs,
        missing: (wanted as usize).saturating_sub(runs),
        kept: [figures.kept, tables.kept].concat(),
        empty: figures.empty,
        names,
    })
}

/// The experiment file that is kept with the results in a folder.
fn kept_spec(folder: &Path) -> Result<Spec> {
    let path = folder.join("experiment.toml");
    if !path.is_file() {
        return Err(Error::malformed(
            folder,
            "is not the results folder of an experiment: it has no experiment.toml; run `meshseg experiment run` first",
        ));
    }
    let name = folder.file_name().map(|name| name.to_string_lossy().into_owned());
    Ok(Spec { name: name.unwrap_or_default(), ..Spec::open(&path)? })
}

/// The number of runs whose labels are missing.
struct Unlabeled {
    lacking: usize,
    runs: usize,
}

impl Unlabeled {
    /// Whether one of these variables cannot be computed.
    fn prevents(&self, variables: &[&Variable]) -> bool {
        self.lacking > 0 && variables.iter().any(|variable| variable.is(Quantity::LabelsChanged))
    }

    /// Says why a file is not written.
    fn sentence(&self, path: &Path) -> String {
        let Unlabeled { lacking, runs } = self;
        format!(
            "{} {}: it needs the labels of all runs, but {lacking} of {runs} have no labels.npy; \
             `meshseg experiment run --force` makes them",
            path.display(),
            if path.is_file() { "is unchanged" } else { "is left out" }
        )
    }
}

/// Where figures are written, in which formats, and by which program.
struct Target<'a> {
    folder: &'a Path,
    formats: Formats,
    program: &'a str,
}

fn write_figures(
    pool: &Pool<'_>,
    store: &Store,
    figures: &[FigureSpec],
    unlabeled: &Unlabeled,
    target: &Target<'_>,
) -> Result<WrittenFigures> {
    let Target { folder, formats, program } = *target;
    let mut written = WrittenFigures::default();
    for figure in figures {
        let name = &figure.name[..];
        let cells = pool.selected(&figure.selection);
        if formats == Formats::Vector && figure.kind.is_picture() {
            let caption = caption::kept(folder, name)?;
            if !caption.is_empty() {
                written.shown.push(PageFigure::unseen(figure, caption));
            }
            continue;
        }
        if let FigureKind::Photographs = figure.kind {
            photographs::write(pool, &cells, figure, folder, &mut written)?;
            continue;
        }
        let surfaces = match &figure.kind {
            FigureKind::Surface(surface) => {
                Some(surface::draw(pool, store, &cells, figure, surface, program))
            }
            FigureKind::Evolution(evolution) => {
                Some(evolution::draw(pool, store, &cells, figure, evolution, program))
            }
            _ => None,
        };
        if let Some(drawn) = surfaces {
            let drawn = drawn.map_err(|error| pool.spec.format_error(&figure.shown, error))?;
            write_surfaces(pool, figure, drawn, folder, &mut written)?;
            continue;
        }
        let path = folder.join(format!("{name}.svg"));
        let shown = if unlabeled.prevents(&figure.variables()) {
            written.kept.push(unlabeled.sentence(&path));
            if !path.is_file() {
                continue;
            }
            PageFigure::kept(figure, &path)?
        } else {
            let drawn = draw::draw(pool, figure);
            if drawn.figure.panels.is_empty() {
                written.empty.get_or_insert_with(|| nothing_to_show(pool.spec, figure));
                continue;
            }
            figure::write(&drawn.figure, folder, name, formats)?;
            write_sources(folder, name, &drawn.sources)?;
            caption::write(folder, name, &drawn.caption)?;
            PageFigure::drawn(figure, &drawn)?
        };
        written.shown.push(shown);
        written.paths.push(path);
    }
    Ok(written)
}

/// Writes a figure of surfaces, as PNG and as a page on which they can be turned.
fn write_surfaces(
    pool: &Pool<'_>,
    figure: &FigureSpec,
    drawn: Option<DrawnSurfaces<'_>>,
    folder: &Path,
    written: &mut WrittenFigures,
) -> Result<()> {
    let name = &figure.name[..];
    let path = folder.join(format!("{name}.png"));
    let advice = "`meshseg experiment run --force` makes them";
    match drawn {
        Some(DrawnSurfaces { png, html, sources, left_out }) => {
            if !left_out.is_empty() {
                written.kept.push(format!(
                    "{} shows no {}: their surfaces or labels are missing; {advice}",
                    path.display(),
                    left_out.join(", ")
                ));
            }
            file::write(&path, |out| out.write_all(&png))?;
            let page = path.with_extension("html");
            file::write(&page, |out| out.write_all(html.as_bytes()))?;
            write_sources(folder, name, &sources)?;
            caption::write(folder, name, &caption::of_pictures(pool, figure, &sources))?;
        }
        None => {
            written.kept.push(format!(
                "{} {}: it needs the surfaces and the labels of the runs; {advice}",
                path.display(),
                if path.is_file() { "is unchanged" } else { "is left out" }
            ));
            if !path.is_file() {
                return Ok(());
            }
        }
    }
    written.shown.push(PageFigure::picture(figure, &path)?);
    written.paths.push(path);
    Ok(())
}

fn nothing_to_show(spec: &Spec, figure: &FigureSpec) -> Error {
    let variables = figure.variables();
    let names: Vec<&str> = variables.into_iter().map(Variable::name).collect();
    let (name, names) = (&figure.name, names.join(" and "));
    let names = if names.is_empty() { "what it shows" } else { &names };
    let message = format!("the figure {name:?} has nothing to show: no run has {names}");
    spec.format_error(&figure.shown, message)
}

#[derive(Default)]
struct WrittenTables<'a> {
    paths: Vec<PathBuf>,
    listed: Vec<Table<'a>>,
    /// As in [`Report`].
    kept: Vec<String>,
}

fn write_tables<'a>(
    pool: &Pool<'a>,
    tables: &[TableSpec],
    unlabeled: &Unlabeled,
    folder: &Path,
) -> Result<WrittenTables<'a>> {
    let mut written = WrittenTables::default();
    for spec in tables {
        let mut table = table::table(pool, spec);
        if unlabeled.prevents(&spec.variables()) {
            let old = folder.join(format!("{}.csv", spec.name));
            written.kept.push(unlabeled.sentence(&old));
            if !old.is_file() {
                continue;
            }
            table.read(&old)?;
        } else {
            table.write(folder)?;
            write_sources(folder, &table.name, &table.sources)?;
        }
        written.paths.push(folder.join(format!("{}.md", spec.name)));
        written.listed.push(table);
    }
    Ok(written)
}

/// Whether the labels of a run are missing although they were kept when it was made.
fn lacks_labels(run: &Done) -> bool {
    run.labels.is_none()
        && run.summary.labels().is_some()
        && run.manifest.repetition == 0
        && run.summary.vertices() <= MAX_SHOWN_VERTICES
}

fn created(folder: PathBuf) -> Result<PathBuf> {
    fs::create_dir_all(&folder).map_err(|error| Error::io(&folder, error))?;
    Ok(folder)
}
