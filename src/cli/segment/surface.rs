//! The mesh that `meshseg segment` works on, and what the file says about it.

use nalgebra::Vector3;

use crate::Result;
use crate::counted::counted;
use crate::data::ModelName;
use crate::data::input::{self, DataSource, InputData, Mapping};
use crate::domain::Element;
use crate::labeling::Labeler;
use crate::mesh::geometry::vertex_normals;
use crate::mesh::orient::{Oriented, orient};
use crate::mesh::{Mesh, Source, Weld};
use crate::names::Named;
use crate::seeds::Seeds;
use crate::solve::check_mesh;

use super::arguments::Arguments;
use crate::cli::{note, seeds, welding};

/// The mesh that is segmented.
pub struct Surface {
    pub source: Source,
    /// The mesh of the file.
    pub mesh: Mesh,
    pub weld: Option<Weld>,
    /// Factor by which the welded mesh is scaled.
    pub scale: f64,
    /// The mesh after welding and scaling.
    pub scaled: Mesh,
}

impl Surface {
    pub fn read(arguments: &Arguments) -> Result<Self> {
        let source = Source::parse(&arguments.mesh)?;
        let mesh = arguments.memory.mesh(&arguments.mesh)?.into_owned();
        Surface::of(source, mesh, arguments)
    }

    /// The surface of a mesh that comes from a source.
    pub fn of(source: Source, mesh: Mesh, arguments: &Arguments) -> Result<Self> {
        let tolerance = arguments.weld.unwrap_or(0.0);
        let weld = if arguments.no_weld { None } else { welding::weld(&mesh, tolerance)? };
        let welded = weld.as_ref().map_or(&mesh, |weld| &weld.mesh);
        let scale = arguments.normalize.scale(welded.area());
        let scaled = welded.clone().scaled(scale);
        check_mesh(&scaled).map_err(|error| error.of_file(&arguments.mesh))?;
        Ok(Surface { source, mesh, weld, scale, scaled })
    }

    pub fn welded(&self) -> &Mesh {
        self.weld.as_ref().map_or(&self.mesh, |weld| &weld.mesh)
    }

    /// The data on the welded mesh.
    pub fn input(&self, arguments: &Arguments) -> Result<InputData> {
        let Arguments { texel, project, fit, .. } = *arguments;
        let data = arguments.data.as_ref();
        if let Some(DataSource::File(path)) = data
            && let Some(array) = arguments.memory.array(path)
        {
            return input::of_array(path, array, self.welded(), self.weld.as_ref());
        }
        let mapping = Mapping { texel, project, fit, views: arguments.views.options(data)? };
        input::read(&self.source, self.welded(), self.weld.as_ref(), data, &mapping)
    }

    /// The normals that the model albedo needs, of faces that are turned outwards, and a warning about these; none for
    /// other models.
    pub fn normals(&self, labeler: &Labeler) -> (Vec<Vector3<f64>>, Option<String>) {
        if labeler.name() != ModelName::Albedo.name() {
            return (Vec::new(), None);
        }
        let Oriented { mesh, flipped, .. } = orient(&self.scaled);
        let turned = (flipped > 0).then(|| {
            format!(
                "{flipped} of {} were turned for the light, so that neighbors agree and closed surfaces face outwards",
                counted(mesh.faces.len(), "face", "faces")
            )
        });
        (vertex_normals(&mesh), turned)
    }

    /// The seeds of the file, on the welded mesh.
    pub fn seeds(&self, arguments: &Arguments, m: usize) -> Result<Seeds> {
        let Some(path) = &arguments.seeds else { return Ok(Seeds::default()) };
        let seeds = seeds::read(path, &self.mesh, m, Element::Vertices, &arguments.memory)?;
        let welded = self.weld.as_ref().map(|weld| seeds.welded(weld));
        welded.unwrap_or(Ok(seeds)).map_err(|error| error.of_file(path))
    }

    /// Reports what was done to the mesh.
    pub fn report(&self, arguments: &Arguments) {
        if self.weld.is_some() {
            let welded = welding::note(self.weld.as_ref(), arguments.weld.unwrap_or(0.0));
            note(&format!("{welded} (--no-weld keeps them separate)"));
        } else if let Some(tolerance) = arguments.weld {
            note(&welding::note(None, tolerance));
        }
        // Not where the note would say 1.000000.
        if (self.scale - 1.0).abs() > 5e-7 {
            note(&format!(
                "scaled by {:.6e} to total area 1, which lambda refers to; --normalize none keeps the units",
                self.scale
            ));
        }
    }
}

/// What is wrong with the mesh or the data.
pub fn warnings(surface: &Surface, input: &InputData, arguments: &Arguments) -> Vec<String> {
    let mut warnings = input.warnings.clone();
    warnings.extend(of_mesh(surface, arguments));
    warnings
}

/// What is wrong with the mesh.
pub fn of_mesh(surface: &Surface, arguments: &Arguments) -> Vec<String> {
    let mut warnings = Vec::new();
    warnings.extend(match arguments.weld {
        Some(_) => welding::unmended(surface.welded()),
        None => welding::shattered(surface.welded(), "--weld"),
    });
    let side_effect = |weld| welding::side_effect(weld, "--no-weld keeps them separate");
    warnings.extend(surface.weld.as_ref().and_then(side_effect));
    warnings
}
