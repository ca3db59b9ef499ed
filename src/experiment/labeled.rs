//! One run of a program's own solver: the solution, the region parameters where it estimates them, and its agreement with
//! the right labels.

use std::ops::ControlFlow;

use ndarray::ArrayView1;

use crate::agreement::{Agreement, MeanAgreement, boundaries, grid_image};
use crate::contour::cut_length;
use crate::domain::Element;
use crate::error::{Error, Result};
use crate::labeling::{Baseline, Labeler, Labeling, label};
use crate::level_sets::{LevelSet, level_sets};
use crate::mesh::Mesh;
use crate::mesh::dual::{Dual, face_areas};
use crate::mesh::extent::{BoundingBox, bounding_box};
use crate::mesh::geometry::barycentric_areas;
use crate::run::{Sample, Stop};
use crate::seeds::Seeds;
use crate::segment::Alternation;
use crate::solve::{Request, Solution, solve, solve_on_faces};
use crate::solver::Method;
use crate::start::Start;
use crate::sweep;

use super::instance::{Instance, Truth, normals, on_surface};
use super::manifest::Scores;
use super::plan::Planned;
use super::spec::{BaselineName, Estimation, Init, InstanceCell, Task};
use crate::data::Initial;

/// Called between the steps of a run.
pub type StepObserver<'a> = &'a mut (dyn FnMut(Option<&Sample>) -> ControlFlow<()> + Send);

/// What a run made.
pub struct Made {
    pub solution: Solution,
    /// The values of the region parameters, if they are not those of the instance.
    pub parameters: Option<Vec<Vec<f64>>>,
    /// The thresholds of two regions, if they were requested.
    pub level_sets: Option<Vec<LevelSet>>,
}

impl Made {
    /// A run with the costs of the instance.
    pub fn of(solution: Solution) -> Self {
        Made { solution, parameters: None, level_sets: None }
    }
}

/// Makes a run that needs no command.
///
/// # Errors
/// The solver or the data model cannot handle the instance.
pub fn attempt(
    run: &Planned<'_>,
    instance: &Instance,
    stop: Stop,
    observe: StepObserver<'_>,
) -> Result<Made> {
    let solver = run.solver;
    let method = match solver.task {
        Task::Baseline(_) => Method::default(),
        _ => Method::parse(&solver.name, &solver.options)?,
    };
    let request = Request {
        lambda: instance.lambda,
        relaxation: run.instance.relaxation,
        mass: run.instance.mass,
        method,
        stop,
        coarse_to_fine: solver.coarse_to_fine,
        keep_dual: false,
        rounding: solver.rounding,
        label_gap: solver.label_gap,
    };
    let made = || match &solver.task {
        Task::Segment(estimation) => {
            let labeler = Labeler::Estimated(run.instance.model);
            labeled(instance, run.instance, labeler, *estimation, &request, observe)
        }
        Task::Baseline(name) => {
            let seed = run.instance.seed;
            let baseline = match name {
                BaselineName::KMeans => Baseline::KMeans { seed },
                BaselineName::Threshold => Baseline::Otsu,
            };
            // What it does not use.
            let estimation = Estimation { every: 1, init: Init::KMeans, seed };
            let labeler = Labeler::Baseline(baseline);
            labeled(instance, run.instance, labeler, estimation, &request, observe)
        }
        Task::Solve | Task::External(_) => solved(instance, &request, observe)
            .and_then(|solution| with_level_sets(run, instance, solution, &request)),
        Task::Reconstruct(_) => unreachable!("reconstructed.rs makes surfaces"),
    };
    sweep::with_threads(solver.threads, made)?
        .map_err(|error| Error::unsuitable(format!("{}: {error}", solver.label)))
}

/// The solution on vertices or on faces.
fn solved(instance: &Instance, request: &Request, observe: StepObserver<'_>) -> Result<Solution> {
    let Instance { mesh, on, costs, .. } = instance;
    match on {
        Element::Vertices => solve(mesh, costs, &Start::Argmin, request, observe),
        Element::Faces => {
            let seeds = Seeds::default();
            solve_on_faces(mesh, None, costs, &seeds, &Start::Argmin, request, observe)
        }
    }
}

/// The length of the cuts between the labels of an instance.
pub fn length_of_cuts(instance: &Instance, labels: ArrayView1<'_, i32>) -> f64 {
    match instance.on {
        Element::Vertices => cut_length(&instance.mesh, labels),
        Element::Faces => Dual::new(&instance.mesh).length_between(labels),
    }
}

fn with_level_sets(
    run: &Planned<'_>,
    instance: &Instance,
    solution: Solution,
    request: &Request,
) -> Result<Made> {
    let level_sets = match run.solver.thresholds {
        Some(_) if instance.costs.ncols() != 2 => {
            return Err(Error::unsuitable("thresholds divide two regions only"));
        }
        Some(count) => {
            let u = solution.u.column(0);
            Some(level_sets(&instance.mesh, &instance.costs, u, count, request)?)
        }
        None => None,
    };
    Ok(Made { level_sets, ..Made::of(solution) })
}

fn labeled(
    instance: &Instance,
    cell: &InstanceCell,
    labeler: Labeler,
    Estimation { every, init, seed }: Estimation,
    request: &Request,
    observe: StepObserver<'_>,
) -> Result<Made> {
    let Some(data) = &instance.data else {
        return Err(Error::unsuitable("fixed costs have no parameters that could be estimated"));
    };
    let regions = cell.regions;
    let initial = if init == Init::Random { Initial::Random } else { Initial::KMeans };
    let labels = initial_labels(&instance.mesh, init, regions);
    let alternation =
        Alternation { regions, initial, seed, every, labels, seeds: Seeds::default() };
    let lambda = Some(request.lambda);
    let mesh = &instance.mesh;
    let normals = normals(mesh, cell.model);
    let observed = on_surface(data, instance.evidence.as_ref(), &normals);
    let Labeling { solution, regions, .. } =
        label(mesh, observed, &labeler, &alternation, lambda, request, observe)?;
    let parameters = Some(regions.into_iter().map(|region| region.value).collect());
    Ok(Made { solution, parameters, level_sets: None })
}

/// Number of stripes of each region.
const STRIPES: usize = 6;

/// The labels of geometric starts.
fn initial_labels(mesh: &Mesh, init: Init, m: usize) -> Option<Vec<usize>> {
    let BoundingBox { min, max } = bounding_box(mesh)?;
    let (low, high) = (nalgebra::Point3::from(min), nalgebra::Point3::from(max));
    let extent = high - low;
    let axis = extent.imax();
    // From 0 to 1 along the longest side, and away from the center.
    let along = |x: &nalgebra::Point3<f64>| (x[axis] - low[axis]) / extent[axis];
    let center = nalgebra::center(&low, &high);
    let farthest = mesh.vertices.iter().map(|x| (x - center).norm()).fold(0.0, f64::max);
    let part = |t: f64, parts: usize| ((t * parts as f64) as usize).min(parts - 1);
    let labels = |label: &dyn Fn(&nalgebra::Point3<f64>) -> usize| {
        Some(mesh.vertices.iter().map(label).collect())
    };
    match init {
        Init::KMeans | Init::Random => None,
        Init::Slabs => labels(&|x| part(along(x), m)),
        Init::OppositeSlabs => labels(&|x| m - 1 - part(along(x), m)),
        Init::Stripes => labels(&|x| part(along(x), STRIPES * m) % m),
        Init::Shells => labels(&|x| part((x - center).norm() / farthest, m)),
    }
}

/// The agreement of a run with the right labels.
pub struct Agreed {
    /// The share of the area with a wrong label.
    pub mislabeled: f64,
    /// Other measures.
    pub others: Scores,
}

/// The agreement with the truth of an instance, if it has one.
///
/// # Errors
/// No vertex has a known label, or too many boundaries to be matched.
pub fn scores(
    run: &Planned<'_>,
    instance: &Instance,
    solution: &Solution,
) -> Result<Option<Agreed>> {
    let Some(Truth { labelings, in_order }) = &instance.truth else { return Ok(None) };
    let labels: Vec<i64> = solution.labels.iter().map(|&label| i64::from(label)).collect();
    // Vertices without a face have no area, and labels that mean nothing.
    let weights = match instance.on {
        Element::Vertices => barycentric_areas(&instance.mesh),
        Element::Faces => face_areas(&instance.mesh),
    };
    let agreements: Vec<Agreement> = (labelings.iter())
        .map(|truth| Agreement::new(&labels, truth, &weights))
        .collect::<Result<_>>()?;
    let MeanAgreement { accuracy, rand_index, variation_of_information, covering, .. } =
        MeanAgreement::of(&agreements);
    let boundary_f = match instance.grid {
        None => None,
        Some(size) => {
            let image = grid_image(&labels, size[0]);
            let truths: Vec<Vec<i64>> =
                labelings.iter().map(|truth| grid_image(truth, size[0])).collect();
            let truths: Vec<&[i64]> = truths.iter().map(|truth| &truth[..]).collect();
            Some(boundaries(&image, &truths, size)?.all.f)
        }
    };
    let others = Scores { rand_index, variation_of_information, covering, boundary_f };
    let mislabeled = match *in_order && run.solver.task.has_fixed_costs() {
        // The regions have their names.
        true => {
            let pairs = labels.iter().zip(&labelings[0]).zip(&weights);
            let wrong = pairs.filter(|((label, truth), _)| label != truth).map(|(_, w)| w);
            wrong.sum::<f64>() / weights.iter().sum::<f64>()
        }
        false => 1.0 - accuracy,
    };
    Ok(Some(Agreed { mislabeled, others }))
}
