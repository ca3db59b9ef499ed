//! `PROBLEM.npz`: everything that a solver needs, as named NumPy arrays.
//!
//! ```text
//! format, version                      "meshseg-problem", 1
//! points, faces                        V x 3, F x 3: the mesh, without faces that have no area
//! K_data, K_indices, K_indptr, K_shape compressed rows, 2F x V: rows 2j and 2j+1 are (K u)_j
//! M_...                                consistent mass, V x V
//! areas                                A_j, F
//! mass_barycentric, mass_voronoi       a_k, V
//! mass                                 the quadrature of f
//! f, lambda, m, u0                     V x m integrated costs, a number, the number of regions, V x m
//! relaxation                           the set of the dual field and the energy of a face; frobenius if it is missing
//! label_metric                         m x m: how much cuts between each two labels weigh, if the relaxation is metric
//! on                                   vertices, or faces; vertices if it is missing
//! ```
//!
//! On faces, rows are those of faces, which `pairs` (E x 2) join with `weights` (E, see `mesh/dual.rs`). K is 2E x F, M
//! the diagonal of the areas, and there are no masses of vertices. Faces without area stay, with cost 0.
//!
//! Numbers are written as float64, indices as int32 and counts as int64; any width is read.

use std::borrow::Cow;
use std::io::Cursor;
use std::path::Path;

use nalgebra::Point3;
use ndarray::{Array1, Array2, ArrayView1, Ix0, Ix1, Ix2, arr0};
use ndarray_npy::{NpzWriter, WriteNpzError};
use sprs::CsMat;

use crate::costs;
use crate::domain::{Domain, Element};
use crate::error::{Error, Result};
use crate::file;
use crate::mesh::Mesh;
use crate::mesh::contrast::Contrast;
use crate::mesh::dual::{Dual, face_areas};
use crate::mesh::geometry::{barycentric_areas, mixed_voronoi_areas};
use crate::mesh::order::Order;
use crate::names::{Named, must_be_one_of};
use crate::npy;
use crate::npz::Archive;
use crate::operator::npz::ByteString;
use crate::operator::{Mass, Matrix, mass};
use crate::problem::FORBIDDEN_COST;
use crate::regions::{self, with_regions};
use crate::relaxation::{LabelMetric, Relaxation};
use crate::request::check_lambda;
use crate::solve::{self, check_mesh, dual_of, model_mesh};
use crate::start::Start;

const FORMAT_NAME: &[u8; 15] = b"meshseg-problem";
const FORMAT_VERSION: i64 = 1;

/// Larger costs would be mistaken for those of padding regions.
const LARGEST_COST: f64 = 1e-10 * FORBIDDEN_COST;

/// A problem with vertices, faces and pairs in the order of the file.
#[derive(Clone, Debug)]
pub struct Exchanged {
    /// The mesh. For labels of vertices, every face has an area.
    pub mesh: Mesh,
    /// The faces and the pairs of them, if labels are those of faces.
    pub dual: Option<Dual>,
    /// Integrated costs, V x m or F x m.
    pub f: Array2<f64>,
    /// Weight of the total variation, in units of cost times length.
    pub lambda: f64,
    /// The relaxation.
    pub relaxation: Relaxation,
    /// The quadrature of f.
    pub mass: Mass,
    /// The initial U, of the same shape.
    pub u0: Array2<f64>,
}

impl Exchanged {
    /// The problem of `solve` with pointwise costs s (V x m), in the relaxation of the paper. Faces without area are left out.
    ///
    /// Fails where [`crate::solve::solve`] refuses lambda, costs, start or mesh, and if the costs forbid a label.
    pub fn new(
        mesh: &Mesh,
        s: &Array2<f64>,
        lambda: f64,
        mass: Mass,
        start: &Start,
    ) -> Result<Self> {
        check_lambda(lambda)?;
        regions::check(s.ncols())?;
        solve::check_rows("costs", s.nrows(), mesh)?;
        let s = without_forbidden(s, mass)?;
        start.check(s.dim())?;
        let (model, _) = model_mesh(mesh)?;
        let model = Mesh::new(model.vertices.clone(), model.faces.clone());
        let domain = Domain::Vertices(&model);
        let (f, u0) = with_regions!(s.ncols(), integrated(domain, &s, mass, start));
        let relaxation = Relaxation::Frobenius;
        Ok(Exchanged { mesh: model, dual: None, f, lambda, relaxation, mass, u0 })
    }

    /// The same for labels of faces, with pointwise costs of F x m, in the relaxation that is exact for them.
    ///
    /// Fails where [`crate::solve::solve_on_faces`] refuses lambda, costs, start, contrast or mesh, and if the costs
    /// forbid a label.
    pub fn on_faces(
        mesh: &Mesh,
        contrast: Option<&Contrast>,
        s: &Array2<f64>,
        lambda: f64,
        start: &Start,
    ) -> Result<Self> {
        check_lambda(lambda)?;
        regions::check(s.ncols())?;
        solve::check_rows_of_faces("costs", s.nrows(), mesh)?;
        let mass = Mass::Barycentric;
        let s = without_forbidden(s, mass)?;
        start.check(s.dim())?;
        let dual = dual_of(mesh, contrast)?;
        let (f, u0) = with_regions!(s.ncols(), integrated((&dual).into(), &s, mass, start));
        let mesh = Mesh::new(mesh.vertices.clone(), mesh.faces.clone());
        let relaxation = Relaxation::Separate;
        Ok(Exchanged { mesh, dual: Some(dual), f, lambda, relaxation, mass, u0 })
    }

    /// What has a row in f, and how these are joined.
    pub fn domain(&self) -> Domain<'_> {
        match &self.dual {
            None => Domain::Vertices(&self.mesh),
            Some(dual) => Domain::Faces(dual),
        }
    }

    /// The same problem in another relaxation.
    pub fn in_relaxation(self, relaxation: Relaxation) -> Self {
        Exchanged { relaxation, ..self }
    }

    /// Writes the archive.
    ///
    /// # Errors
    /// The file cannot be written, or the mesh is too large for 32-bit indices.
    pub fn write(&self, path: &Path) -> Result<()> {
        let entries = 3 * 2 * self.mesh.faces.len().max(self.domain().terms());
        if i32::try_from(entries).is_err() {
            let message = "the mesh is too large for the int32 indices of an exchanged problem";
            return Err(Error::malformed(path, message));
        }
        let bytes = self.npz().map_err(|error| Error::io(path, std::io::Error::other(error)))?;
        file::write(path, |out| out.write_all(&bytes))
    }

    fn npz(&self) -> std::result::Result<Vec<u8>, WriteNpzError> {
        let Exchanged { mesh, dual, f, lambda, relaxation, mass, u0 } = self;
        let points = Array2::from_shape_fn((mesh.vertices.len(), 3), |(v, i)| mesh.vertices[v][i]);
        let faces = Array2::from_shape_fn((mesh.faces.len(), 3), |(j, i)| mesh.faces[j][i] as i32);
        let element: &str = self.domain().element().into();
        let mut npz = NpzWriter::new(Cursor::new(Vec::new()));
        npz.add_array("format", &arr0(ByteString(*FORMAT_NAME)))?;
        npz.add_array("version", &arr0(FORMAT_VERSION))?;
        npz.add_array("points", &points)?;
        npz.add_array("faces", &faces)?;
        npz.add_array("on", &arr0(padded::<8>(element)))?;
        match dual {
            None => {
                let areas = (0..mesh.faces.len()).map(|j| mesh.face_area(j)).collect();
                add_matrix(&mut npz, "K", Matrix::new(mesh).csr())?;
                add_matrix(&mut npz, "M", &mass::consistent_matrix(mesh))?;
                npz.add_array("areas", &Array1::from_vec(areas))?;
                npz.add_array("mass_barycentric", &Array1::from(barycentric_areas(mesh)))?;
                npz.add_array("mass_voronoi", &Array1::from(mixed_voronoi_areas(mesh)))?;
            }
            Some(dual) => {
                let pair = |(e, i): (usize, usize)| dual.pairs[e][i] as i32;
                let pairs = Array2::from_shape_fn((dual.pairs.len(), 2), pair);
                add_matrix(&mut npz, "K", Matrix::across_edges(dual).csr())?;
                add_matrix(&mut npz, "M", &diagonal(&dual.areas))?;
                npz.add_array("areas", &ArrayView1::from(&dual.areas))?;
                npz.add_array("pairs", &pairs)?;
                npz.add_array("weights", &ArrayView1::from(&dual.weights))?;
            }
        }
        npz.add_array("mass", &arr0(padded::<11>(mass.name())))?;
        npz.add_array("f", f)?;
        npz.add_array("lambda", &arr0(*lambda))?;
        npz.add_array("relaxation", &arr0(padded::<9>(relaxation.name())))?;
        if let Relaxation::Metric(metric) = relaxation {
            npz.add_array("label_metric", &metric.matrix())?;
        }
        npz.add_array("m", &arr0(f.ncols() as i64))?;
        npz.add_array("u0", u0)?;
        Ok(npz.finish()?.into_inner())
    }

    /// Reads an archive in the format of [`Self::write`]. K and the masses are ignored, since they follow from the
    /// mesh, and from pairs and weights.
    ///
    /// # Errors
    /// The format or version differs, or an array is missing, of the wrong type or shape, or not finite.
    pub fn read(path: &Path) -> Result<Self> {
        let mut archive = Archive::open(path)?;
        let format = archive.entry("format", npy::byte_string)?;
        if format.as_bytes() != FORMAT_NAME {
            return Err(Error::malformed(
                path,
                "is not a problem; write one with `meshseg problem export`",
            ));
        }
        let version = archive.entry("version", npy::integers::<Ix0>)?.into_scalar();
        if version != FORMAT_VERSION {
            let message = format!(
                "has format version {version}; this program reads version {FORMAT_VERSION}"
            );
            return Err(Error::malformed(path, message));
        }
        let points = archive.entry("points", npy::numbers::<Ix2>)?;
        let faces = archive.entry("faces", npy::integers::<Ix2>)?;
        let f = archive.entry("f", npy::numbers::<Ix2>)?;
        let u0 = archive.entry("u0", npy::numbers::<Ix2>)?;
        let lambda = archive.entry("lambda", npy::numbers::<Ix0>)?.into_scalar();
        let mass = archive.entry("mass", npy::byte_string)?;
        let unsuitable = |message: String| Error::malformed(path, message);
        let vertices = points.nrows();
        if points.ncols() != 3 || faces.ncols() != 3 {
            return Err(unsuitable("points and faces must have three columns".into()));
        }
        let corner = |&k: &i64| u32::try_from(k).ok().filter(|&k| (k as usize) < vertices);
        let corners: Option<Vec<u32>> = faces.iter().map(corner).collect();
        let Some(corners) = corners else {
            return Err(unsuitable(format!(
                "faces has indices outside of 0 to V - 1, with V = {vertices}"
            )));
        };
        let mass =
            Mass::named(&mass).ok_or_else(|| unsuitable(format!("mass {mass:?} is unknown")))?;
        let relaxation = match archive.has("relaxation") {
            true => archive.entry("relaxation", npy::byte_string)?,
            false => Relaxation::Frobenius.name().to_owned(),
        };
        let relaxation = match &*relaxation {
            "metric" => {
                let d = archive.entry("label_metric", npy::numbers::<Ix2>)?;
                let metric = LabelMetric::new(&d).map_err(|error| error.of_file(path))?;
                Relaxation::Metric(metric)
            }
            name => Relaxation::named(name).ok_or_else(|| {
                let names = must_be_one_of(Relaxation::names());
                unsuitable(format!("relaxation {name:?} is unknown: {names}"))
            })?,
        };
        let on = match archive.has("on") {
            true => archive.entry("on", npy::byte_string)?,
            false => <&str>::from(Element::Vertices).to_owned(),
        };
        let on: Element = on.parse().map_err(|_| {
            unsuitable(format!("on {on:?} is unknown: it must be vertices or faces"))
        })?;
        let pairs = match on {
            Element::Vertices => None,
            Element::Faces => {
                let pairs = archive.entry("pairs", npy::integers::<Ix2>)?;
                Some((pairs, archive.entry("weights", npy::numbers::<Ix1>)?))
            }
        };
        let of_file = |error: Error| error.of_file(path);
        check_lambda(lambda).map_err(of_file)?;
        regions::check(f.ncols()).map_err(of_file)?;
        relaxation.check(f.ncols()).map_err(of_file)?;
        if points.iter().any(|x| !x.is_finite()) {
            return Err(unsuitable("points has an entry that is not finite".into()));
        }
        solve::check_finite("costs", &f).map_err(of_file)?;
        if f.iter().any(|f| f.abs() >= LARGEST_COST) {
            return Err(unsuitable("f leaves the range of double precision: scale it down".into()));
        }
        let mesh = Mesh::new(
            points.outer_iter().map(|x| Point3::new(x[0], x[1], x[2])).collect(),
            corners.chunks_exact(3).map(|face| [face[0], face[1], face[2]]).collect(),
        );
        let dual = match pairs {
            None => {
                solve::check_rows("integrated costs", f.nrows(), &mesh).map_err(of_file)?;
                let (model, dropped) = mesh.without_degenerate_faces();
                if dropped > 0 || model.faces.is_empty() {
                    return Err(unsuitable("every face must have an area".into()));
                }
                None
            }
            Some((pairs, weights)) => {
                let rows = f.nrows();
                solve::check_rows_of_faces("integrated costs", rows, &mesh).map_err(of_file)?;
                Some(read_dual(&mesh, &pairs, &weights).map_err(of_file)?)
            }
        };
        let start = Start::Given(u0);
        start.check(f.dim()).map_err(of_file)?;
        let Start::Given(u0) = start else { unreachable!("it was made so") };
        check_mesh(&mesh).map_err(of_file)?;
        Ok(Exchanged { mesh, dual, f, lambda, relaxation, mass, u0 })
    }
}

/// Costs for programs that know of no forbidden labels; unknown rows are 0.
fn without_forbidden(s: &Array2<f64>, mass: Mass) -> Result<Cow<'_, Array2<f64>>> {
    let (s, _) = costs::checked(s, mass)?;
    match s.iter().any(|x| x.is_infinite()) {
        false => Ok(s),
        true => Err(Error::unsuitable(
            "external solvers do not support forbidden labels (costs of +inf): use large finite costs",
        )),
    }
}

/// Pairs and weights of an archive, with the areas of the faces.
fn read_dual(mesh: &Mesh, pairs: &Array2<i64>, weights: &Array1<f64>) -> Result<Dual> {
    let faces = mesh.faces.len();
    if pairs.ncols() != 2 || pairs.nrows() != weights.len() {
        return Err(Error::unsuitable(
            "pairs must have two columns, and a row for each of the weights",
        ));
    }
    let face = |&j: &i64| u32::try_from(j).ok().filter(|&j| (j as usize) < faces);
    let pair = |pair: ArrayView1<'_, i64>| Some([face(&pair[0])?, face(&pair[1])?]);
    let pairs: Option<Vec<[u32; 2]>> =
        pairs.outer_iter().map(|row| pair(row).filter(|[j, k]| j != k)).collect();
    let Some(pairs) = pairs else {
        return Err(Error::unsuitable(format!(
            "pairs must hold two different indices of faces in each row, from 0 to F - 1, with F = {faces}"
        )));
    };
    if let Some(w) = weights.iter().find(|w| !(**w > 0.0 && w.is_finite())) {
        return Err(Error::unsuitable(format!(
            "weights has {w:?}: they must be positive and finite"
        )));
    }
    Ok(Dual { areas: face_areas(mesh), pairs, weights: weights.to_vec() })
}

fn integrated<const M: usize>(
    domain: Domain<'_>,
    s: &Array2<f64>,
    mass: Mass,
    start: &Start,
) -> (Array2<f64>, Array2<f64>) {
    let m = s.ncols();
    let f = solve::integrate::<M>(&domain.quadrature(mass), m, &regions::rows(s.view()));
    let u0 = start.rows(m, &f, &Order::as_it_is());
    (regions::array(&f, m), regions::array(&u0, m))
}

/// A name in a string of fixed length.
fn padded<const N: usize>(name: &str) -> ByteString<N> {
    let mut bytes = [0; N];
    bytes[..name.len()].copy_from_slice(name.as_bytes());
    ByteString(bytes)
}

fn diagonal(entries: &[f64]) -> CsMat<f64> {
    let n = entries.len();
    CsMat::new((n, n), (0..=n).collect(), (0..n).collect(), entries.to_vec())
}

fn add_matrix(
    npz: &mut NpzWriter<Cursor<Vec<u8>>>,
    name: &str,
    matrix: &CsMat<f64>,
) -> std::result::Result<(), WriteNpzError> {
    let integers =
        |numbers: &[usize]| -> Array1<i32> { numbers.iter().map(|&n| n as i32).collect() };
    let shape = Array1::from(vec![matrix.rows() as i64, matrix.cols() as i64]);
    npz.add_array(format!("{name}_data"), &Array1::from(matrix.data().to_vec()))?;
    npz.add_array(format!("{name}_indices"), &integers(matrix.indices()))?;
    npz.add_array(format!("{name}_indptr"), &integers(matrix.indptr().raw_storage()))?;
    npz.add_array(format!("{name}_shape"), &shape)
}
