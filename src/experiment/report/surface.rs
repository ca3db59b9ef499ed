//! Figures of surfaces: a row for each instance, in it the data once and what is shown of each solver.
//!
//! The regions of a solver are matched with those of the first one, so that equal colors mean the same, unless columns of U
//! are shown, which tell which region is which.

use std::rc::Rc;

use super::super::figures::{FigureSpec, SurfaceFigure};
use super::super::results::Done;
use super::super::store::Store;
use super::pool::{Cell, Pool};
use crate::agreement::Confusion;
use crate::domain::Element;
use crate::error::Result;
use crate::mesh::{Mesh, Split, io};
use crate::render::panels::{PageWidth, Panel, Panels, Regions, Shown, ShownData, Surface};

/// A figure of surfaces.
pub struct DrawnSurfaces<'a> {
    /// As a PNG file.
    pub png: Vec<u8>,
    /// As a page on which the surfaces can be turned, HTML.
    pub html: String,
    /// The runs that it shows.
    pub sources: Vec<&'a Done>,
    /// The labels of instances that are left out, since a surface or the labels of a solver are missing.
    pub left_out: Vec<&'a str>,
}

/// The width of a figure in a column, in millimeters.
const COLUMN_WIDTH: &str = "85mm";

/// The width of a figure.
pub fn page_width(figure: &FigureSpec) -> PageWidth {
    match figure.page {
        true => PageWidth::default(),
        false => COLUMN_WIDTH.parse().expect("a width"),
    }
}

/// An instance whose surface and labels are there.
struct Shows<'a> {
    label: &'a str,
    /// One per solver.
    runs: Vec<&'a Done>,
    drawn: Vec<Drawn>,
}

/// A surface with the regions of a run. Labels of faces have vertices of their own.
struct Drawn {
    mesh: Rc<Mesh>,
    regions: Regions,
}

/// Draws the surfaces of the cells by a program with a name, given instance by instance; `None` if all are left out.
///
/// # Errors
/// A surface cannot be read, or a run does not have what is to be shown.
pub fn draw<'a>(
    pool: &Pool<'a>,
    store: &Store,
    cells: &[&Cell<'a>],
    figure: &FigureSpec,
    surface: &SurfaceFigure,
    program: &str,
) -> Result<Option<DrawnSurfaces<'a>>> {
    let by_column = surface.show.iter().any(|shown| matches!(shown, Shown::Column(_)));
    let (mut all, mut left_out) = (Vec::new(), Vec::new());
    for cells in cells.chunk_by(|a, b| a.instance == b.instance) {
        let label = pool.instance(cells[0]).label.as_str();
        match shows(store, cells, label, by_column)? {
            Some(shows) => all.push(shows),
            None => left_out.push(label),
        }
    }
    if all.is_empty() {
        return Ok(None);
    }
    let solvers: Vec<&str> = (cells.iter())
        .filter(|cell| cell.instance == cells[0].instance)
        .map(|cell| pool.solver(cell).label.as_str())
        .collect();
    let (of_instance, of_solver): (Vec<Shown>, Vec<Shown>) =
        surface.show.iter().partition(|shown| !shown.needs_regions());
    let mut columns: Vec<String> = of_instance.iter().map(|shown| shown.caption()).collect();
    for solver in &solvers {
        columns.extend(of_solver.iter().map(|shown| match of_solver.len() {
            1 if solvers.len() > 1 => (*solver).to_owned(),
            _ if solvers.len() == 1 => shown.caption(),
            _ => format!("{solver}: {}", shown.caption()),
        }));
    }
    let mut surfaces = Vec::new();
    let mut panels = Vec::new();
    let panel = |surface: usize, shown: Shown| Panel { surface, shown, caption: None };
    for Shows { drawn, .. } in &all {
        for (s, Drawn { mesh, regions }) in drawn.iter().enumerate() {
            let colors = mesh.colors.as_deref().unwrap_or_default();
            let index = surfaces.len();
            surfaces.push(Surface {
                mesh,
                data: Some(ShownData::Colors(colors)),
                regions: Some(regions.clone()),
                means: None,
                frame: None,
            });
            if s == 0 {
                panels.extend(of_instance.iter().map(|&shown| panel(index, shown)));
            }
            panels.extend(of_solver.iter().map(|&shown| panel(index, shown)));
        }
    }
    let row_headings: Vec<String> = match all.len() {
        1 => Vec::new(),
        _ => all.iter().map(|shows| shows.label.to_owned()).collect(),
    };
    let drawn = Panels {
        surfaces: &surfaces,
        panels: &panels,
        views: &surface.views,
        columns: Some(columns.len()),
        row_headings: &row_headings,
        column_headings: &columns,
        width: page_width(figure),
        transparent: false,
    };
    let png = drawn.png()?;
    let html = drawn.html(figure.title.as_deref().unwrap_or(&figure.name), program)?;
    let sources = all.iter().flat_map(|shows| shows.runs.iter().copied()).collect();
    Ok(Some(DrawnSurfaces { png, html, sources, left_out }))
}

/// The surface of an instance and the labels of the given cells, if all are there.
fn shows<'a>(
    store: &Store,
    cells: &[&Cell<'a>],
    label: &'a str,
    by_column: bool,
) -> Result<Option<Shows<'a>>> {
    let labeled = |cell: &&Cell<'a>| cell.runs.iter().copied().find(|run| run.labels.is_some());
    let Some(runs) = cells.iter().map(labeled).collect::<Option<Vec<&Done>>>() else {
        return Ok(None);
    };
    let id = &runs[0].manifest.instance_id;
    let path = store.folder.join("instances").join(format!("{id}.ply"));
    if !path.exists() {
        return Ok(None);
    }
    let mesh = Rc::new(io::read(&path)?);
    let names = |run: &Done| match by_column {
        true => Ok((0..run.summary.regions()).collect()),
        false => matched(run, runs[0]),
    };
    let drawn = |run: &&Done| {
        let names = names(run)?;
        Ok(match run.on() {
            Element::Vertices => Drawn { mesh: Rc::clone(&mesh), regions: regions(run, &names) },
            Element::Faces => of_faces(&mesh, run, &names),
        })
    };
    let drawn = runs.iter().map(drawn).collect::<Result<_>>()?;
    Ok(Some(Shows { label, runs, drawn }))
}

/// The regions of a run on faces under other names.
fn of_faces(mesh: &Mesh, run: &Done, names: &[usize]) -> Drawn {
    let labels = run.labels.iter().flatten().map(|&label| names[usize::from(label)] as u16);
    let Split { mesh: split, of, labels } = mesh.split(&labels.collect::<Vec<_>>());
    let colors = (mesh.colors.as_ref())
        .map(|colors| of.iter().map(|&v| colors[v as usize]).collect::<Vec<_>>());
    let labels: Vec<usize> = labels.into_iter().map(usize::from).collect();
    let regions = Regions::of_labels(&labels, run.summary.regions(), None);
    Drawn { mesh: Rc::new(Mesh { colors, ..split }), regions }
}

/// For each region of a run the region of the first run with which it has most vertices in common, one to one.
fn matched(run: &Done, first: &Done) -> Result<Vec<usize>> {
    let integers = |run: &Done| -> Vec<i64> {
        run.labels.iter().flatten().map(|&label| i64::from(label)).collect()
    };
    let (labels, reference) = (integers(run), integers(first));
    let confusion = Confusion::new(&labels, &reference, &vec![1.0; labels.len()])?;
    let m = run.summary.regions();
    let mut names: Vec<Option<usize>> = vec![None; m];
    for (row, column) in confusion.matching().into_iter().enumerate() {
        let name = column.map(|column| confusion.truth_labels[column] as usize);
        names[confusion.labels[row] as usize] = name.filter(|&name| name < m);
    }
    let mut free = (0..m).filter(|p| !names.contains(&Some(*p))).collect::<Vec<_>>().into_iter();
    Ok(names.iter().map(|name| name.or_else(|| free.next()).expect("m names")).collect())
}

/// The regions of a run under other names: U for two regions, whose larger entry determines both, otherwise the labels and how certain they
/// are.
fn regions(run: &Done, names: &[usize]) -> Regions {
    let labels = run.labels.iter().flatten().map(|&label| names[usize::from(label)]);
    let certainty: Option<Vec<f64>> = run
        .certainty
        .as_ref()
        .map(|certainty| certainty.iter().map(|&byte| f64::from(byte) / 255.0).collect());
    match (run.summary.regions(), certainty) {
        (2, Some(certainty)) => {
            let row =
                |(label, u): (usize, f64)| if label == 0 { [u, 1.0 - u] } else { [1.0 - u, u] };
            Regions::of_u(labels.zip(certainty).flat_map(row).collect(), 2)
        }
        (m, certainty) => Regions::of_labels(&labels.collect::<Vec<_>>(), m, certainty),
    }
}
