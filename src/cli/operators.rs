//! `meshseg operators`: K, the mass matrices and the Laplacian for SciPy and other programs.

use std::path::{Path, PathBuf};

use sprs::CsMat;

use crate::mesh::geometry::{barycentric_areas, mixed_voronoi_areas};
use crate::mesh::source;
use crate::operator::{Matrix, export, mass, npz};
use crate::solve::model_mesh;
use crate::{Result, file, npy};

use super::{Outcome, print, table, warn, welding};

/// Write K, the mass matrices and the Laplacian as MatrixMarket (.mtx) and SciPy (.npz) files.
///
/// K is 2F x V: rows 2j and 2j+1 are A_j times the gradient on face j, in its frame (along the edge from its
/// first to its second corner, and across it). M is the consistent mass matrix, mass_barycentric and
/// mass_voronoi the lumped ones, laplacian the stiffness matrix K^T A^-1 K of the cotangent Laplacian. Faces
/// without area are left out; face_areas.npy holds A. Vertices are those of the file; `meshseg mesh convert --weld`
/// merges coincident ones.
#[derive(clap::Args)]
#[command(after_help = "Example:
  meshseg operators bunny.ply --out results/bunny
  python3 -c \"import scipy.sparse as s; K = s.load_npz('results/bunny/K.npz'); print(K.shape)\"")]
pub struct Arguments {
    /// Mesh file, builtin:spot, or a shape such as torus:400x250
    mesh: PathBuf,

    /// Folder for the files; written completely or not at all
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

pub fn run(arguments: &Arguments) -> Outcome {
    file::check_folder(&arguments.out)?;
    let mesh = source(&arguments.mesh)?;
    let (mesh, warnings) = model_mesh(&mesh).map_err(|error| error.of_file(&arguments.mesh))?;
    warn(&warnings);
    warn(&welding::seams(&mesh, welding::CONVERT_COMMAND));
    let k = Matrix::new(&mesh);
    let matrices = [
        ("K", k.csr().clone()),
        ("M", mass::consistent_matrix(&mesh)),
        ("mass_barycentric", diagonal(&barycentric_areas(&mesh))),
        ("mass_voronoi", diagonal(&mixed_voronoi_areas(&mesh))),
        ("laplacian", k.laplacian()),
    ];
    file::write_folder(&arguments.out, |folder: &Path| -> Result<()> {
        for (name, matrix) in &matrices {
            export::write_matrix_market(&folder.join(format!("{name}.mtx")), matrix)?;
            npz::write_npz(&folder.join(format!("{name}.npz")), matrix)?;
        }
        let areas: Vec<f64> = (0..mesh.faces.len()).map(|j| mesh.face_area(j)).collect();
        npy::write(&folder.join("face_areas.npy"), &ndarray::Array1::from(areas))
    })?;
    let mut rows = vec![vec!["matrix".into(), "rows".into(), "columns".into(), "entries".into()]];
    rows.extend(matrices.iter().map(|(name, matrix)| {
        vec![
            (*name).to_owned(),
            matrix.rows().to_string(),
            matrix.cols().to_string(),
            matrix.nnz().to_string(),
        ]
    }));
    print(&table::columns(&rows))?;
    Ok(())
}

fn diagonal(entries: &[f64]) -> CsMat<f64> {
    let n = entries.len();
    CsMat::new((n, n), (0..=n).collect(), (0..n).collect(), entries.to_vec())
}
