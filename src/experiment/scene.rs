//! What a surface is reconstructed from: photographs, and the truth where it is known.

use super::choice::DataChoice;
use super::folders::{Folders, InstanceError};
use super::instance::scaled_mesh;
use super::photographs::Album;
use super::spec::InstanceCell;
use crate::data::input::DataSource;
use crate::data::views::Picture;
use crate::error::Error;
use crate::evolve::images::{Background, Shot};
use crate::evolve::shots::Photographs;
use crate::mesh::Mesh;
use crate::solve::check_mesh;

/// Photographs and the truth.
pub struct Scene {
    /// One per view.
    pub shots: Vec<Shot>,
    /// The true surface, if it is known.
    pub truth: Option<Truth>,
}

/// The true surface.
pub struct Truth {
    /// In the units of the cameras.
    pub mesh: Mesh,
    /// The region of each vertex, if that is known, and the color of each region.
    pub regions: Option<(Vec<usize>, Vec<[f64; 3]>)>,
}

impl Folders {
    /// Photographs an instance, or reads its views.
    ///
    /// # Errors
    /// Files cannot be read, or do not fit each other.
    pub fn scene(&self, cell: &InstanceCell) -> Result<Scene, InstanceError> {
        let source = cell.mesh.as_deref().map(|name| self.mesh(name)).transpose()?;
        match (&self.data(&cell.data)?, source) {
            (DataChoice::Photographs(cameras), Some(source)) => {
                let InstanceCell { photography, regions, noise, seed, .. } = cell;
                let mesh = scaled_mesh(&source, cell)?;
                let Album { views, photographs, pattern } =
                    photography.album(&mesh, *cameras, *regions, *noise, *seed)?;
                let shots = views.into_iter().zip(photographs).map(|(view, photograph)| Shot {
                    view,
                    picture: Picture::of_bytes(
                        photograph.width,
                        photograph.height,
                        photograph.bytes(),
                    ),
                    background: Background::Color(photography.background),
                });
                let regions = Some((pattern.labels, pattern.palette));
                Ok(Scene { shots: shots.collect(), truth: Some(Truth { mesh, regions }) })
            }
            (DataChoice::Source(DataSource::Views(path)), source) => {
                let images = cell.images.as_deref().map(|folder| self.path(folder)).transpose()?;
                let Photographs { shots, warnings, notes, .. } = Photographs::read(
                    path,
                    images.as_deref(),
                    cell.background,
                    cell.mask.as_ref(),
                    cell.regions,
                )?;
                warnings.iter().for_each(|warning| tracing::warn!("{}: {warning}", cell.label));
                notes.iter().for_each(|note| tracing::info!("{}: {note}", cell.label));
                // Cameras are in the units of the file.
                let mesh = source.map(|source| source.mesh()).transpose()?;
                if let Some(mesh) = &mesh {
                    check_mesh(mesh)?;
                }
                Ok(Scene { shots, truth: mesh.map(|mesh| Truth { mesh, regions: None }) })
            }
            _ => Err(Error::unsuitable("the instance has no photographs").into()),
        }
    }
}
