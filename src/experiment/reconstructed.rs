//! A run that reconstructs a surface: its numbers, its trace and the surface on the way.
//!
//! A row of the trace describes the surface after a number of steps: its energy and, now and then, its agreement with the
//! truth. The clock counts steps; it stands still while surfaces are compared with the truth, and while labels are
//! certified.

use std::path::Path;
use std::time::Instant;

use image::RgbImage;
use nalgebra::Vector3;

use super::folders::Folders;
use super::labeled::StepObserver;
use super::plan::Planned;
use super::scene::Scene;
use super::spec::{Evolution, InstanceCell, LambdaChoice};
use super::surface_trace::{Measures, Row};
use super::true_labels::TrueLabels;
use crate::data::ModelName;
use crate::error::{Error, Result};
use crate::evolve::images::Shot;
use crate::evolve::silhouette::{Silhouette, overlap};
use crate::evolve::{
    Event, Light, Plan, Reconstruction, Summary, Surface, known_silhouettes, reconstruct,
};
use crate::mesh::Mesh;
use crate::mesh::distance::between;
use crate::render::photographs::RegionsInViews;
use crate::solve::check_mesh;
use crate::sweep;

/// The surface is kept at the start, after these steps, and at the end of each level.
const KEPT_AFTER: [usize; 4] = [5, 10, 20, 40];

/// At most this many photographs are kept.
const PHOTOGRAPHS: usize = 4;

/// The gray of a surface whose regions are not known yet.
const GRAY: [f64; 3] = [0.72; 3];

/// A reconstructed surface.
pub struct Reconstructed {
    /// Its numbers.
    pub summary: Summary,
    /// The share of its area whose label is not that of the nearest point of the truth, if the truth has labels.
    pub mislabeled: Option<f64>,
    /// mu.
    pub colors: Vec<[f64; 3]>,
    /// The surface before the first step, after some, and at the end.
    pub rows: Vec<Row>,
    /// The surface on the way.
    pub frames: Vec<Frame>,
    /// The last surface in some of its photographs: silhouettes and cuts.
    pub photographs: RgbImage,
}

/// A surface on the way.
pub struct Frame {
    /// The number of steps.
    pub step: usize,
    /// Its vertices have the colors of their regions.
    pub mesh: Mesh,
}

/// Makes a run; `observe` may end it.
///
/// # Errors
/// The start cannot be read, or the scene cannot be reconstructed.
pub fn reconstructed(
    run: &Planned<'_>,
    evolution: &Evolution,
    scene: &Scene,
    folders: &Folders,
    observe: StepObserver<'_>,
) -> Result<Reconstructed> {
    let made = || {
        let read = |path: &Path| {
            let mesh = folders.mesh(&path.to_string_lossy())?.mesh()?;
            check_mesh(&mesh).map_err(|error| error.of_file(path))?;
            Ok(mesh)
        };
        let start = evolution.start.mesh(&scene.shots, read)?;
        let plan = plan(run.instance, evolution);
        let truth = scene.truth.as_ref().map(|truth| &truth.mesh);
        let mut watched = Watched::new(scene, &start);
        let watch = &mut |event: Event<'_>| {
            watched.watch(event)?;
            Ok(observe(None))
        };
        let found = reconstruct(&scene.shots, &start, truth, &plan, watch)?;
        watched.end(scene, &found)
    };
    sweep::with_threads(run.solver.threads, made)?
        .map_err(|error| Error::unsuitable(format!("{}: {error}", run.solver.label)))
}

fn plan(cell: &InstanceCell, evolution: &Evolution) -> Plan {
    let light = cell.photography.light.filter(|_| cell.model == ModelName::Albedo);
    Plan {
        regions: cell.regions,
        lambda: match cell.lambda {
            LambdaChoice::Given(lambda) => lambda,
            LambdaChoice::Auto(_) => unreachable!("the file was checked for this"),
        },
        light: light.map(|direction| Light {
            direction: Vector3::from(direction).normalize(),
            ambient: cell.photography.ambient,
        }),
        seed: cell.seed,
        ..evolution.plan()
    }
}

/// What is recorded on the way.
struct Watched {
    /// What the surface should fill, if that is known without its colors.
    silhouettes: Option<Vec<Silhouette>>,
    labels: Option<TrueLabels>,
    rows: Vec<Row>,
    frames: Vec<Frame>,
    /// Of the surface that the next row describes.
    next: Measures,
    /// Until the last step.
    seconds: f64,
    /// When the clock began to run again.
    since: Instant,
}

impl Watched {
    fn new(scene: &Scene, start: &Mesh) -> Self {
        let truth = scene.truth.as_ref();
        let silhouettes = known_silhouettes(&scene.shots, truth.map(|truth| &truth.mesh));
        let next = Measures {
            distance: truth.map(|truth| between(start, &truth.mesh).mean),
            silhouette_iou: iou(start, silhouettes.as_deref()),
            mislabeled: None,
        };
        Watched {
            silhouettes,
            labels: truth.and_then(TrueLabels::new),
            rows: Vec::new(),
            frames: vec![Frame { step: 0, mesh: colored(start, |_| GRAY) }],
            next,
            seconds: 0.0,
            since: Instant::now(),
        }
    }

    fn watch(&mut self, event: Event<'_>) -> Result<()> {
        match event {
            Event::Step(step, surface) => {
                let before = self.seconds;
                self.seconds += self.since.elapsed().as_secs_f64();
                self.rows.push(Row::of(step, before, std::mem::take(&mut self.next)));
                if step.is_compared() {
                    self.next = self.measures(surface)?;
                }
                if KEPT_AFTER.contains(&(step.step + 1)) {
                    self.keep(step.step + 1, surface);
                }
            }
            Event::Distance(distance) => self.next.distance = Some(distance),
            Event::Level(found) => self.reached(found)?,
            Event::Labels => return Ok(()),
        }
        self.since = Instant::now();
        Ok(())
    }

    /// What is known of a surface at rest.
    fn reached(&mut self, found: &Reconstruction) -> Result<()> {
        self.next = Measures {
            distance: found.distances.map(|distances| distances.mean),
            silhouette_iou: Some(found.quality.silhouette_iou),
            mislabeled: self.mislabeled(&found.surface)?,
        };
        self.keep(found.trace.len(), &found.surface);
        Ok(())
    }

    fn end(mut self, scene: &Scene, found: &Reconstruction) -> Result<Reconstructed> {
        self.reached(found)?;
        let mislabeled = self.next.mislabeled;
        self.rows.push(Row::last(found, self.seconds, self.next));
        Ok(Reconstructed {
            summary: Summary::of(found, self.seconds),
            mislabeled,
            colors: found.surface.coloring.mu.clone(),
            rows: self.rows,
            frames: self.frames,
            photographs: photographs(&scene.shots, &found.surface),
        })
    }

    fn measures(&self, surface: &Surface) -> Result<Measures> {
        Ok(Measures {
            distance: None,
            silhouette_iou: iou(&surface.mesh, self.silhouettes.as_deref()),
            mislabeled: self.mislabeled(surface)?,
        })
    }

    fn mislabeled(&self, surface: &Surface) -> Result<Option<f64>> {
        let labels = surface.coloring.labels();
        let mislabeled = |truth: &TrueLabels| truth.mislabeled(&surface.mesh, &labels);
        self.labels.as_ref().map(mislabeled).transpose()
    }

    fn keep(&mut self, step: usize, surface: &Surface) {
        let labels = surface.coloring.labels();
        let color = |k: usize| surface.coloring.mu[labels[k]].map(|c| c.clamp(0.0, 1.0));
        self.frames.retain(|frame| frame.step != step);
        self.frames.push(Frame { step, mesh: colored(&surface.mesh, color) });
    }
}

/// The silhouettes and the cuts of a surface in some photographs, evenly chosen.
fn photographs(shots: &[Shot], surface: &Surface) -> RgbImage {
    let count = shots.len().min(PHOTOGRAPHS);
    let chosen = (0..count).map(|i| &shots[i * shots.len() / count]);
    let views: Vec<_> = chosen.map(|shot| (shot.view.camera, &shot.picture)).collect();
    let coloring = &surface.coloring;
    let regions = RegionsInViews::new(&surface.mesh, &coloring.u, coloring.regions());
    regions.with_silhouettes().grid(&views)
}

fn iou(mesh: &Mesh, silhouettes: Option<&[Silhouette]>) -> Option<f64> {
    silhouettes.map(|silhouettes| overlap(mesh, silhouettes).iou())
}

fn colored(mesh: &Mesh, color: impl Fn(usize) -> [f64; 3]) -> Mesh {
    let colors = Some((0..mesh.vertices.len()).map(color).collect());
    Mesh { colors, ..Mesh::new(mesh.vertices.clone(), mesh.faces.clone()) }
}
