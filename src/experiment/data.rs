//! An instance as it is solved: mesh, pointwise costs and colors.
//!
//! Costs are s_p(x) = |C(x) - mu_p|^2 with fixed means: the palette of synthetic data, otherwise those of area-weighted
//! k-means. Hence every solver gets the same convex problem.

use std::ops::ControlFlow;
use std::ops::Range;
use std::path::{Path, PathBuf};

use ndarray::Array2;
use rand::SeedableRng;
use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;
use sha2::{Digest, Sha256};
use tracing::subscriber::{self, NoSubscriber};

use super::choice::DataChoice;
use super::spec::{External, InstanceCell, LambdaChoice};
use crate::colormap::categorical;
use crate::costs;
use crate::data::input::{self, DataSource, Mapping};
use crate::data::kmeans::kmeans;
use crate::data::synthetic::waves;
use crate::data::{Data, Initial, PiecewiseConstant};
use crate::error::{Error, Result};
use crate::file;
use crate::mesh::geometry::barycentric_areas;
use crate::mesh::weld::{coincident, free_cuts};
use crate::mesh::{Mesh, Source};
use crate::npy;
use crate::operator::Mass;
use crate::regions;
use crate::run::Stop;
use crate::segment::{Alternation, lambda};
use crate::solve::{Request, check_mesh};
use crate::solver::Method;

/// The folders in which files are looked up.
pub struct Folders {
    /// The folder of the experiment file, to which paths are relative.
    pub folder: PathBuf,
    /// The folder that `data:` stands for.
    pub data: Option<PathBuf>,
}

/// Why an instance cannot be made.
pub enum InstanceError {
    /// It needs the folder of data that may not be redistributed, but `--data-dir` was not given.
    DataFolder,
    Error(Error),
}

impl From<InstanceError> for Error {
    fn from(missing: InstanceError) -> Self {
        match missing {
            InstanceError::DataFolder => Error::unsuitable(
                "the instance needs the data folder: give --data-dir or set MESHSEG_DATA",
            ),
            InstanceError::Error(error) => error,
        }
    }
}

impl From<Error> for InstanceError {
    fn from(error: Error) -> Self {
        InstanceError::Error(error)
    }
}

impl Folders {
    fn path(&self, name: &str) -> std::result::Result<PathBuf, InstanceError> {
        match (name.strip_prefix("data:"), &self.data) {
            (Some(name), Some(data)) => Ok(data.join(name)),
            (Some(_), None) => Err(InstanceError::DataFolder),
            (None, _) => Ok(self.folder.join(name)),
        }
    }

    fn mesh(&self, name: &str) -> std::result::Result<Source, InstanceError> {
        let path = self.path(name)?;
        Ok(if path.exists() || name.starts_with("data:") {
            Source::File(path)
        } else {
            match Source::parse(name)? {
                Source::File(_) => Source::File(path),
                other => other,
            }
        })
    }

    fn data(&self, choice: &DataChoice) -> std::result::Result<DataChoice, InstanceError> {
        let at = |path: &Path| self.path(&path.to_string_lossy());
        Ok(match choice {
            DataChoice::Costs(path) => DataChoice::Costs(at(path)?),
            DataChoice::Source(DataSource::Texture(Some(path))) => {
                DataChoice::Source(DataSource::Texture(Some(at(path)?)))
            }
            DataChoice::Source(DataSource::Image(path)) => {
                DataChoice::Source(DataSource::Image(at(path)?))
            }
            DataChoice::Source(DataSource::File(path)) => {
                DataChoice::Source(DataSource::File(at(path)?))
            }
            other => other.clone(),
        })
    }

    /// A hash of the files that an instance is made from; generated meshes and data are identified by their names.
    ///
    /// # Errors
    /// A file is missing or cannot be read.
    pub fn content(&self, cell: &InstanceCell) -> std::result::Result<String, InstanceError> {
        let mut hash = Sha256::new();
        let source = self.mesh(&cell.mesh)?;
        if let Source::File(path) = &source {
            hash.update(file::read(path)?);
        }
        match &self.data(&cell.data)? {
            DataChoice::Costs(path) | DataChoice::Source(DataSource::File(path)) => {
                hash.update(file::read(path)?);
            }
            DataChoice::Own => paint(&mut hash, &source, None)?,
            DataChoice::Source(choice) => paint(&mut hash, &source, Some(choice))?,
            DataChoice::Waves => {}
        }
        Ok(hex(&hash.finalize()))
    }

    /// A hash of the files among the words of a command; files that these use in turn are not included.
    ///
    /// # Errors
    /// A file cannot be read.
    pub fn command(&self, external: &External) -> Result<String> {
        let mut hash = Sha256::new();
        for word in external.command.split_whitespace() {
            let path = self.folder.join(word);
            if path.is_file() {
                hash.update(file::read(&path)?);
            }
        }
        Ok(hex(&hash.finalize()))
    }

    /// The span in the experiment file that is to blame if an instance cannot be made: its mesh, if that alone fails,
    /// otherwise its data.
    pub fn blame<'a>(&self, cell: &'a InstanceCell) -> &'a Range<usize> {
        let mesh = || -> std::result::Result<(), InstanceError> {
            let mesh = self.mesh(&cell.mesh)?.mesh()?;
            Ok(check_mesh(&mesh)?)
        };
        if mesh().is_err() { &cell.mesh_span } else { &cell.data_span }
    }

    /// Makes the instance.
    ///
    /// # Errors
    /// Files cannot be read, or do not fit each other.
    pub fn instance(&self, cell: &InstanceCell) -> std::result::Result<Instance, InstanceError> {
        let source = self.mesh(&cell.mesh)?;
        let mesh = scaled_mesh(&source, cell)?;
        let Costed { data, costs, looks, truth } = match &self.data(&cell.data)? {
            DataChoice::Waves => costs_of_waves(&mesh, cell),
            DataChoice::Costs(path) => given_costs(&mesh, path)?,
            DataChoice::Own => costs_of_data(&source, &mesh, None, cell)?,
            DataChoice::Source(choice) => costs_of_data(&source, &mesh, Some(choice), cell)?,
        };
        let lambda = match (cell.lambda, &data) {
            (LambdaChoice::Given(lambda), _) => lambda,
            (LambdaChoice::Auto(factor), Some(data)) => {
                let default = default_lambda(&mesh, data, cell);
                factor * default.map_err(|error| error.of_file(Path::new(&cell.mesh)))?
            }
            (LambdaChoice::Auto(_), None) => unreachable!("the file was checked for this"),
        };
        Ok(Instance { mesh, costs, lambda, looks, truth })
    }
}

/// The mesh, scaled as the cell requests. Warns about coincident vertices.
fn scaled_mesh(source: &Source, cell: &InstanceCell) -> Result<Mesh> {
    let mesh = source.mesh()?;
    let scale = cell.normalize.scale(mesh.area());
    let mesh = mesh.scaled(scale);
    check_mesh(&mesh).map_err(|error| error.of_file(Path::new(&cell.mesh)))?;
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
    costs: Array2<f64>,
    looks: Vec<[f64; 3]>,
    truth: Option<Vec<usize>>,
}

fn costs_of_waves(mesh: &Mesh, cell: &InstanceCell) -> Costed {
    let waves = waves(mesh, cell.regions, cell.noise, cell.seed);
    let mu: Vec<Vec<f64>> = waves.palette.iter().map(|mu| mu.to_vec()).collect();
    let looks = (0..mesh.vertices.len()).map(|k| color(waves.data.at(k))).collect();
    let costs = distances(&waves.data, &mu);
    Costed { data: Some(waves.data), costs, looks, truth: Some(waves.labels) }
}

/// The costs of a file; each vertex has the color of its cheapest region.
fn given_costs(mesh: &Mesh, path: &Path) -> Result<Costed> {
    let costs = npy::read_rows(path)?;
    npy::check_rows(path, &costs, mesh.vertices.len())?;
    regions::check(costs.ncols()).map_err(|error| error.of_file(path))?;
    costs::checked(&costs, Mass::Barycentric).map_err(|error| error.of_file(path))?;
    let look = |s: ndarray::ArrayView1<f64>| {
        let cheapest = (1..s.len()).fold(0, |best, p| if s[p] < s[best] { p } else { best });
        if s[cheapest].is_nan() { UNKNOWN_COLOR } else { categorical(cheapest) }
    };
    let looks = costs.outer_iter().map(look).collect();
    Ok(Costed { data: None, costs, looks, truth: None })
}

/// The costs of noisy data for the means of k-means.
fn costs_of_data(
    source: &Source,
    mesh: &Mesh,
    choice: Option<&DataSource>,
    cell: &InstanceCell,
) -> Result<Costed> {
    let input = input::read(source, mesh, None, choice, &Mapping::default())?;
    input.warnings.iter().for_each(|warning| tracing::warn!("{source}: {warning}"));
    let mut data = input.data;
    let mut rng = Pcg64::seed_from_u64(cell.seed);
    let noise = Normal::new(0.0, cell.noise).expect("a finite standard deviation");
    data.values.iter_mut().for_each(|value| *value += noise.sample(&mut rng));
    let mut rng = Pcg64::seed_from_u64(cell.seed);
    let known = data.known_area(&barycentric_areas(mesh));
    let mu = kmeans(&data.values, data.dimension, &known, cell.regions, &mut rng);
    let costs = distances(&data, &mu);
    Ok(Costed { data: Some(data), costs, looks: input.colors, truth: None })
}

/// Hashes the inputs that color a mesh but are not in its file: its materials from libraries, and images. A mesh that
/// cannot be read is an error only when the instance is made.
fn paint(hash: &mut Sha256, source: &Source, choice: Option<&DataSource>) -> Result<()> {
    let given = match choice {
        Some(DataSource::Curvature(_)) => return Ok(()),
        Some(DataSource::Texture(given)) => given.is_some(),
        Some(DataSource::Image(_)) => true,
        _ => false,
    };
    if !given && !matches!(source, Source::File(_)) {
        return Ok(());
    }
    // Warnings are reported when the instance is made, which reads the mesh again.
    let mesh = subscriber::with_default(NoSubscriber::default(), || source.mesh());
    let Ok(mesh) = mesh else { return Ok(()) };
    for material in mesh.materials.iter().flat_map(|materials| &materials.all) {
        let color = material.color.map(|color| color.map(f64::to_bits));
        hash.update(format!("{color:?} {:?}", material.placement.bits()));
    }
    for path in input::image_files(source, &mesh, choice, &Mapping::default()) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let bytes = match (file::read(&path), choice) {
            (Ok(bytes), _) => bytes,
            // Images that the mesh names may be missing.
            (Err(_), None) => Vec::new(),
            (Err(error), Some(_)) => return Err(error),
        };
        hash.update(format!("{name} {} ", bytes.len()));
        hash.update(bytes);
    }
    Ok(())
}

/// The color of unknown vertices.
const UNKNOWN_COLOR: [f64; 3] = [0.5; 3];

/// The problem that every solver gets.
pub struct Instance {
    pub mesh: Mesh,
    /// V x m.
    pub costs: Array2<f64>,
    pub lambda: f64,
    /// The data as a color per vertex.
    pub looks: Vec<[f64; 3]>,
    /// The region of each vertex from which synthetic data were generated.
    pub truth: Option<Vec<usize>>,
}

/// The lambda that `segment` chooses.
fn default_lambda(mesh: &Mesh, data: &Data, cell: &InstanceCell) -> Result<f64> {
    let InstanceCell { regions, seed, mass, .. } = *cell;
    let alternation = Alternation { regions, initial: Initial::KMeans, seed, every: 10 };
    let request = Request {
        // Not yet known.
        lambda: 0.0,
        mass,
        method: Method::default(),
        stop: Stop::default(),
        coarse_to_fine: false,
        keep_dual: false,
    };
    let model = PiecewiseConstant::new(data);
    lambda::of_data(mesh, &model, &alternation, &request, &mut |_| ControlFlow::Continue(()))
}

/// The costs of the piecewise constant model; NaN where the data are unknown.
fn distances(data: &Data, mu: &[Vec<f64>]) -> Array2<f64> {
    let model = PiecewiseConstant::new(data);
    Array2::from_shape_fn((data.len(), mu.len()), |(k, p)| model.cost(k, &mu[p]))
}

fn color(values: &[f64]) -> [f64; 3] {
    [0, 1, 2].map(|i| values[i].clamp(0.0, 1.0))
}

pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
