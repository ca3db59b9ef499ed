//! An instance as it is solved: mesh, pointwise costs and colors.
//!
//! Costs have fixed parameters: the palette of synthetic data, otherwise those with which the model starts, for piecewise
//! constant data the means of area-weighted k-means. Hence every solver of fixed costs gets the same convex problem.

use std::ops::ControlFlow;
use std::path::Path;

use nalgebra::Vector3;
use ndarray::{Array2, Ix1};
use rand::SeedableRng;
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;
use tracing::subscriber::{self, NoSubscriber};

use super::choice::DataChoice;
use super::fixed_costs::FixedCosts;
use super::folders::{Folders, InstanceError};
use super::photographs::Photographed;
use super::spec::{InstanceCell, LambdaChoice};
use crate::classes::lambda;
use crate::data::constant::Mean;
use crate::data::humans;
use crate::data::input::{self, DataSource, Mapping};
use crate::data::lambertian::Illumination;
use crate::data::pixels::Evidence;
use crate::data::synthetic::{Waves, waves};
use crate::data::views::CamerasAround;
use crate::data::{
    Data, DataModel, Initial, LitSurface, ModelName, ModelTask, Observed, PiecewiseConstant,
    Radiance,
};
use crate::domain::Element;
use crate::error::{Error, Result};
use crate::exchange::Exchanged;
use crate::file;
use crate::labeling::{default_lambda, pointwise_costs};
use crate::mesh::geometry::{barycentric_areas, vertex_normals};
use crate::mesh::orient::orient;
use crate::mesh::weld::{coincident, free_cuts};
use crate::mesh::{Mesh, Shape, Source};
use crate::npy;
use crate::rounding::Rounding;
use crate::run::Stop;
use crate::seeds::Seeds;
use crate::segment::Alternation;
use crate::solve::{Request, check_mesh};
use crate::solver::Method;
use crate::start::Start;

impl Folders {
    /// Makes the instance.
    ///
    /// # Errors
    /// Files cannot be read, or do not fit each other.
    pub fn instance(&self, cell: &InstanceCell) -> std::result::Result<Instance, InstanceError> {
        let source = self.mesh(cell.mesh_name())?;
        let mesh = scaled_mesh(&source, cell)?;
        let Costed { data, evidence, costs, looks, mut truth } = match &self.data(&cell.data)? {
            DataChoice::Waves => costs_of_waves(&mesh, cell)?,
            DataChoice::Photographs(cameras) => costs_of_photographs(&mesh, *cameras, cell)?,
            DataChoice::Costs(path) => FixedCosts::given(&mesh, path, cell.on)?.into(),
            DataChoice::Probabilities(path) => {
                FixedCosts::of_probabilities(&mesh, path, cell.on)?.into()
            }
            DataChoice::Classes => FixedCosts::of_classes(&source, &mesh, cell)?.into(),
            DataChoice::Own => costs_of_data(&source, &mesh, None, &self.mapping(cell)?, cell)?,
            DataChoice::Source(choice) => {
                costs_of_data(&source, &mesh, Some(choice), &self.mapping(cell)?, cell)?
            }
        };
        if let Some(name) = &cell.truth {
            truth = Some(Truth::read(&self.path(name)?, &mesh, cell.on)?);
        }
        let lambda = match (cell.lambda, &data) {
            (LambdaChoice::Given(lambda), _) => lambda,
            (LambdaChoice::Auto(factor), Some(data)) => {
                let default = lambda_of(&mesh, data, evidence.as_ref(), cell);
                factor * default.map_err(|error| error.of_file(Path::new(cell.mesh_name())))?
            }
            (LambdaChoice::Auto(factor), None) => factor * lambda_of_classes(&mesh, &costs, cell)?,
        };
        let grid = match source {
            Source::Shape(Shape::Grid { nx, ny }) if cell.on == Element::Vertices => {
                Some([nx as usize + 1, ny as usize + 1])
            }
            _ => None,
        };
        Ok(Instance { mesh, on: cell.on, data, evidence, costs, lambda, looks, truth, grid })
    }
}

/// The mesh, scaled as the cell requests. Warns about coincident vertices.
pub fn scaled_mesh(source: &Source, cell: &InstanceCell) -> Result<Mesh> {
    let mesh = source.mesh()?;
    let scale = cell.normalize.scale(mesh.area());
    let mesh = mesh.scaled(scale);
    check_mesh(&mesh).map_err(|error| error.of_file(Path::new(cell.mesh_name())))?;
    let coincident = coincident(&mesh);
    if coincident > 0 {
        tracing::warn!(
            "{source}: {}; weld them with `meshseg mesh convert --weld`",
            free_cuts(coincident)
        );
    }
    Ok(mesh)
}

/// Costs, the data they are computed from, and the rest as in [`Instance`].
struct Costed {
    data: Option<Data>,
    evidence: Option<Evidence>,
    costs: Array2<f64>,
    looks: Vec<[f64; 3]>,
    truth: Option<Truth>,
}

impl From<FixedCosts> for Costed {
    fn from(FixedCosts { s, looks, labels }: FixedCosts) -> Self {
        let of_classes = |labels: Vec<usize>| Truth {
            labelings: vec![labels.into_iter().map(|label| label as i64).collect()],
            in_order: true,
        };
        Costed { data: None, evidence: None, costs: s, looks, truth: labels.map(of_classes) }
    }
}

fn costs_of_waves(mesh: &Mesh, cell: &InstanceCell) -> Result<Costed> {
    let Waves { data, labels, palette } = waves(mesh, cell.regions, cell.noise, cell.seed);
    let looks = (0..mesh.vertices.len()).map(|k| color(data.at(k))).collect();
    let costs = match cell.model {
        ModelName::Constant => {
            let mu: Vec<Mean> = palette.iter().map(|mu| Mean { mean: mu.to_vec() }).collect();
            pointwise_costs(&PiecewiseConstant::new(&data), &mu)
        }
        _ => initial_costs(mesh, &data, None, cell)?,
    };
    let truth = Some(Truth::of_waves(labels, cell));
    Ok(Costed { data: Some(data), evidence: None, costs, looks, truth })
}

/// The costs of photographs of a pattern.
fn costs_of_photographs(
    mesh: &Mesh,
    cameras: CamerasAround,
    cell: &InstanceCell,
) -> Result<Costed> {
    let InstanceCell { photography, regions, noise, seed, model, .. } = cell;
    let Photographed { data, evidence, pattern: Waves { labels, palette, .. } } =
        photography.data(mesh, cameras, *regions, *noise, *seed)?;
    let known = |k: usize| data.known(k).map_or(UNKNOWN_COLOR, color);
    let looks = (0..mesh.vertices.len()).map(known).collect();
    let mu = || palette.iter().map(|mu| Mean { mean: mu.to_vec() }).collect::<Vec<_>>();
    let costs = match (model, &evidence) {
        (ModelName::Constant, Some(evidence)) => {
            pointwise_costs(&Radiance::new(&data, evidence), &mu())
        }
        (ModelName::Constant, None) => pointwise_costs(&PiecewiseConstant::new(&data), &mu()),
        _ => initial_costs(mesh, &data, evidence.as_ref(), cell)?,
    };
    let truth = Some(Truth::of_waves(labels, cell));
    Ok(Costed { data: Some(data), evidence, costs, looks, truth })
}

/// The costs of the parameters with which an estimation starts.
fn initial_costs(
    mesh: &Mesh,
    data: &Data,
    evidence: Option<&Evidence>,
    cell: &InstanceCell,
) -> Result<Array2<f64>> {
    let normals = normals(mesh, cell.model);
    cell.model.with(on_surface(data, evidence, &normals), InitialCosts { mesh, cell })
}

struct InitialCosts<'a> {
    mesh: &'a Mesh,
    cell: &'a InstanceCell,
}

impl ModelTask for InitialCosts<'_> {
    type Output = Array2<f64>;

    fn run<D: DataModel>(self, model: &D) -> Result<Array2<f64>> {
        let InitialCosts { mesh, cell } = self;
        let mut rng = Pcg64::seed_from_u64(cell.seed);
        let mu = model.start(Initial::KMeans, cell.regions, &barycentric_areas(mesh), &mut rng)?;
        Ok(pointwise_costs(model, &mu))
    }
}

/// The costs of noisy data.
fn costs_of_data(
    source: &Source,
    mesh: &Mesh,
    choice: Option<&DataSource>,
    mapping: &Mapping,
    cell: &InstanceCell,
) -> Result<Costed> {
    let input = match choice {
        // Cameras are in the units of the file; warnings about that were reported.
        Some(DataSource::Views(_)) => {
            let mesh = subscriber::with_default(NoSubscriber::default(), || source.mesh())?;
            input::read(source, &mesh, None, choice, mapping)?
        }
        _ => input::read(source, mesh, None, choice, mapping)?,
    };
    input.warnings.iter().for_each(|warning| tracing::warn!("{source}: {warning}"));
    let mut data = input.data;
    let mut rng = Pcg64::seed_from_u64(cell.seed);
    let noise = Normal::new(0.0, cell.noise).expect("a finite standard deviation");
    data.values.iter_mut().for_each(|value| *value += noise.sample(&mut rng));
    let evidence = input.evidence;
    let costs = initial_costs(mesh, &data, evidence.as_ref(), cell)?;
    let looks = match cell.noise > 0.0 && data.dimension == 3 {
        true => (0..data.len()).map(|k| color(data.at(k))).collect(),
        false => input.colors,
    };
    Ok(Costed { data: Some(data), evidence, costs, looks, truth: None })
}

/// Labelings that are right.
pub struct Truth {
    /// V or F labels each; negative where unknown.
    pub labelings: Vec<Vec<i64>>,
    /// Whether the labels are the regions of the fixed costs, in their order.
    pub in_order: bool,
}

impl Truth {
    /// The labels of waves, whose palette is that of the fixed costs of the model constant.
    fn of_waves(labels: Vec<usize>, cell: &InstanceCell) -> Self {
        let labels = labels.into_iter().map(|label| label as i64).collect();
        Truth { labelings: vec![labels], in_order: cell.model == ModelName::Constant }
    }

    /// A `.npy` file of V or F integers, or a `.mat` file of human segmentations of the image on the mesh.
    fn read(path: &Path, mesh: &Mesh, on: Element) -> Result<Self> {
        let labelings = match path.extension().is_some_and(|extension| extension == "mat") {
            true => humans::on_mesh(mesh, path)?,
            false => vec![npy::integers::<Ix1>(path, &file::read(path)?)?.to_vec()],
        };
        let (labels, elements) = (labelings[0].len(), on.count(mesh));
        if labels != elements {
            let [_, many] = on.nouns();
            let message = format!("has {labels} labels, but the mesh has {elements} {many}");
            return Err(Error::malformed(path, message));
        }
        Ok(Truth { labelings, in_order: false })
    }
}

/// The color of unknown vertices.
const UNKNOWN_COLOR: [f64; 3] = [0.5; 3];

/// The problem that every solver gets.
pub struct Instance {
    pub mesh: Mesh,
    /// What is labeled.
    pub on: Element,
    /// What the costs are computed from, unless they are given.
    pub data: Option<Data>,
    /// What pixels say beyond the data, which are their means.
    pub evidence: Option<Evidence>,
    /// V x m or F x m.
    pub costs: Array2<f64>,
    pub lambda: f64,
    /// The data as a color per vertex.
    pub looks: Vec<[f64; 3]>,
    /// The labels that generated synthetic data, or given ones.
    pub truth: Option<Truth>,
    /// Columns and rows of vertices of a grid whose vertices are labeled.
    pub grid: Option<[usize; 2]>,
}

/// What lambda is searched with.
fn request(cell: &InstanceCell) -> Request {
    Request {
        // Not yet known.
        lambda: 0.0,
        relaxation: cell.relaxation,
        mass: cell.mass,
        method: Method::default(),
        stop: Stop::default(),
        coarse_to_fine: false,
        keep_dual: false,
        rounding: Rounding::Argmax,
        label_gap: None,
    }
}

impl Instance {
    /// The problem for solvers outside the program.
    ///
    /// # Errors
    /// No face has an area, or the integrated costs leave the range of double precision.
    pub fn exchanged(&self, cell: &InstanceCell) -> Result<Exchanged> {
        let Instance { mesh, on, costs, lambda, .. } = self;
        let problem = match on {
            Element::Vertices => Exchanged::new(mesh, costs, *lambda, cell.mass, &Start::Argmin)?,
            Element::Faces => Exchanged::on_faces(mesh, None, costs, *lambda, &Start::Argmin)?,
        };
        Ok(problem.in_relaxation(cell.relaxation))
    }
}

/// The lambda that `segment` chooses.
fn lambda_of(
    mesh: &Mesh,
    data: &Data,
    evidence: Option<&Evidence>,
    cell: &InstanceCell,
) -> Result<f64> {
    let InstanceCell { regions, seed, model, .. } = *cell;
    let initial = Initial::KMeans;
    let alternation =
        Alternation { regions, initial, seed, every: 10, labels: None, seeds: Seeds::default() };
    let request = request(cell);
    let mut observe = |_: Option<&_>| ControlFlow::Continue(());
    let normals = normals(mesh, model);
    let observed = on_surface(data, evidence, &normals);
    default_lambda(mesh, observed, model, &alternation, &request, &mut observe)
}

/// The lambda that `segment` chooses for class probabilities.
fn lambda_of_classes(mesh: &Mesh, costs: &Array2<f64>, cell: &InstanceCell) -> Result<f64> {
    let request = request(cell);
    let mut observe = |_: Option<&_>| ControlFlow::Continue(());
    let lambda = lambda::of_costs(mesh, (costs, cell.on), cell.on, &request, &mut observe);
    Ok(lambda
        .map_err(|error| error.of_file(Path::new(cell.mesh_name())))?
        .expect("nobody interrupts"))
}

/// The outward normals that the model albedo needs; none for other models.
pub fn normals(mesh: &Mesh, model: ModelName) -> Vec<Vector3<f64>> {
    match model {
        ModelName::Albedo => vertex_normals(&orient(mesh).mesh),
        _ => Vec::new(),
    }
}

/// The data for any model; the light is to be estimated.
pub fn on_surface<'a>(
    data: &'a Data,
    evidence: Option<&'a Evidence>,
    normals: &'a [Vector3<f64>],
) -> Observed<'a> {
    let lit = LitSurface { normals, illumination: Illumination::default() };
    Observed { data, evidence, lit: Some(lit) }
}

fn color(values: &[f64]) -> [f64; 3] {
    [0, 1, 2].map(|i| values[i].clamp(0.0, 1.0))
}
