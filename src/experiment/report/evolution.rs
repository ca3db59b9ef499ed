//! Figures of surfaces on the way: a row for each reconstruction, a column for each number of steps, for its end and for
//! the truth. The page has all surfaces that were kept, on a slider.

use std::path::{Path, PathBuf};

use super::super::figures::{EvolutionFigure, FigureSpec};
use super::super::results::Done;
use super::super::store::Store;
use super::pool::{Cell, Pool};
use super::surface::{DrawnSurfaces, page_width};
use crate::error::Result;
use crate::mesh::{Mesh, io};
use crate::render::View;
use crate::render::panels::{Panel, Panels, Regions, Shown, ShownData, Surface};

/// A reconstruction whose surfaces are there.
struct Way<'a> {
    heading: String,
    run: &'a Done,
    /// Each after a number of steps, ascending.
    frames: Vec<(usize, Colored)>,
    /// The index of its instance among those that are shown.
    instance: usize,
}

/// What is known of an instance.
struct Place {
    /// All its surfaces together.
    frame: Mesh,
    truth: Option<Colored>,
}

/// A surface whose vertices have the colors of their regions.
struct Colored {
    mesh: Mesh,
    colors: Vec<[f64; 3]>,
    labels: Vec<usize>,
    palette: Vec<[f64; 3]>,
}

impl Colored {
    fn read(path: &Path) -> Result<Self> {
        let mesh = io::read(path)?;
        let colors = mesh.colors.clone().unwrap_or_else(|| vec![[0.72; 3]; mesh.vertices.len()]);
        let mut palette: Vec<[f64; 3]> = Vec::new();
        let mut label = |color: &[f64; 3]| {
            palette.iter().position(|known| known == color).unwrap_or_else(|| {
                palette.push(*color);
                palette.len() - 1
            })
        };
        let labels = colors.iter().map(&mut label).collect();
        Ok(Colored { labels, palette, colors, mesh })
    }

    fn surface<'a>(&'a self, frame: &'a Mesh) -> Surface<'a> {
        Surface {
            mesh: &self.mesh,
            data: Some(ShownData::Colors(&self.colors)),
            regions: Some(Regions::of_labels(&self.labels, self.palette.len(), None)),
            means: Some(self.palette.clone()),
            frame: Some(frame),
        }
    }
}

/// Draws the surfaces of the cells by a program with a name; `None` if no cell has any.
///
/// # Errors
/// A surface cannot be read.
pub fn draw<'a>(
    pool: &Pool<'a>,
    store: &Store,
    cells: &[&Cell<'a>],
    figure: &FigureSpec,
    evolution: &EvolutionFigure,
    program: &str,
) -> Result<Option<DrawnSurfaces<'a>>> {
    let (mut ways, mut places, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
    let instances = cells.chunk_by(|a, b| a.instance == b.instance);
    let one = instances.clone().count() == 1;
    for cells in instances {
        let label = pool.instance(cells[0]).label.as_str();
        let before = ways.len();
        for cell in cells {
            let solver = pool.solver(cell);
            let Some(run) = cell.runs.iter().copied().find(|run| !run.frames.is_empty()) else {
                if solver.task.evolution().is_some() {
                    left_out.push(label);
                }
                continue;
            };
            let read = |(step, path): &(usize, PathBuf)| Ok((*step, Colored::read(path)?));
            ways.push(Way {
                heading: match (one, cells.len()) {
                    (true, _) => solver.label.clone(),
                    (false, 1) => label.to_owned(),
                    _ => format!("{label}: {}", solver.label),
                },
                run,
                frames: run.frames.iter().map(read).collect::<Result<_>>()?,
                instance: places.len(),
            });
        }
        if let Some(first) = ways.get(before) {
            let id = &first.run.manifest.instance_id;
            let path = store.folder.join("instances").join(format!("{id}.ply"));
            let truth = path.exists().then(|| Colored::read(&path)).transpose()?;
            let of_ways = ways[before..].iter().flat_map(|way| way.frames.iter().map(|(_, it)| it));
            let frame = together(of_ways.chain(&truth).map(|colored| &colored.mesh));
            places.push(Place { frame, truth });
        }
    }
    if ways.is_empty() {
        return Ok(None);
    }
    left_out.dedup();
    let shown = Ways { ways: &ways, places: &places, views: &evolution.views };
    let mut all: Vec<usize> =
        ways.iter().flat_map(|way| way.frames.iter().map(|it| it.0)).collect();
    all.sort_unstable();
    all.dedup();
    let png = shown.with_panels(&evolution.steps, true, |panels| {
        Panels { width: page_width(figure), ..panels }.png()
    })?;
    let title = figure.title.as_deref().unwrap_or(&figure.name);
    let html = shown.with_panels(&all, false, |panels| panels.film(title, program))?;
    let sources = ways.iter().map(|way| way.run).collect();
    Ok(Some(DrawnSurfaces { png, html, sources, left_out }))
}

/// All meshes as one.
fn together<'m>(meshes: impl Iterator<Item = &'m Mesh>) -> Mesh {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for mesh in meshes {
        let first = vertices.len() as u32;
        vertices.extend_from_slice(&mesh.vertices);
        faces.extend(mesh.faces.iter().map(|face| face.map(|k| first + k)));
    }
    Mesh::new(vertices, faces)
}

/// Rows of surfaces.
struct Ways<'w, 'a> {
    ways: &'w [Way<'a>],
    places: &'w [Place],
    views: &'w [View],
}

impl Ways<'_, '_> {
    /// The grid of the surfaces after numbers of steps, perhaps with the end, and with the truth where it is known. A
    /// reconstruction that has ended before keeps its last surface.
    fn with_panels<T>(
        &self,
        steps: &[usize],
        with_end: bool,
        draw: impl FnOnce(Panels<'_>) -> Result<T>,
    ) -> Result<T> {
        let has_truth = self.places.iter().any(|place| place.truth.is_some());
        let mut headings: Vec<String> = steps.iter().map(|step| in_words(*step)).collect();
        headings.extend(with_end.then(|| "end".to_owned()));
        headings.extend(has_truth.then(|| "truth".to_owned()));
        let (mut surfaces, mut panels) = (Vec::new(), Vec::new());
        for way in self.ways {
            let place = &self.places[way.instance];
            let until = |step: usize| {
                let reached = way.frames.iter().rev().find(|(at, _)| *at <= step);
                &reached.unwrap_or(&way.frames[0]).1
            };
            let ends = with_end.then_some(usize::MAX);
            let of_way = steps.iter().copied().chain(ends).map(until);
            // Where the truth is not known the last surface stays.
            let truth = has_truth.then(|| place.truth.as_ref().unwrap_or(until(usize::MAX)));
            for colored in of_way.chain(truth) {
                panels.push(Panel { surface: surfaces.len(), shown: Shown::Means, caption: None });
                surfaces.push(colored.surface(&place.frame));
            }
        }
        let row_headings: Vec<String> = match self.ways.len() {
            1 => Vec::new(),
            _ => self.ways.iter().map(|way| way.heading.clone()).collect(),
        };
        draw(Panels {
            surfaces: &surfaces,
            panels: &panels,
            views: self.views,
            columns: Some(headings.len()),
            row_headings: &row_headings,
            column_headings: &headings,
            width: Default::default(),
            transparent: false,
        })
    }
}

fn in_words(step: usize) -> String {
    match step {
        0 => "start".into(),
        1 => "1 step".into(),
        _ => format!("{step} steps"),
    }
}
