//! The data that belong to a mesh: the textures of its materials, the colors of its vertices, those of its faces.

use super::reader::{InputData, Reader, colored};
use super::signal::varies;
use crate::counted::counted;
use crate::data::texture::{Sums, color_of_face, images};
use crate::error::{Error, Result};
use crate::mesh::Source;
use crate::unreached::INHERIT;

/// The kinds of data that a mesh may have, the preferred one first.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Own {
    Textures,
    Vertices,
    Faces,
}

impl Own {
    fn name(self) -> &'static str {
        match self {
            Own::Textures => "the textures of its materials",
            Own::Vertices => "the colors of its vertices",
            Own::Faces => "the colors of its faces",
        }
    }
}

impl Reader<'_> {
    /// The first kind of data that can be read and is not constant.
    pub(super) fn own(&self) -> Result<InputData> {
        let offers: Vec<Own> = [Own::Textures, Own::Vertices, Own::Faces]
            .into_iter()
            .filter(|&own| self.has(own))
            .collect();
        let mut constant: Option<(Own, InputData)> = None;
        let mut refused: Option<Error> = None;
        for (i, &own) in offers.iter().enumerate() {
            let mut input = match self.read_own(own, false) {
                Ok(input) => input,
                Err(error) if i + 1 == offers.len() && constant.is_none() => {
                    return Err(refused.unwrap_or(error));
                }
                Err(error) => {
                    tracing::warn!("{error}; {} are ignored", own.name());
                    refused.get_or_insert(error);
                    continue;
                }
            };
            if !varies(&input.data) {
                constant.get_or_insert((own, input));
                continue;
            }
            if let Some((other, _)) = constant {
                input.notes.push(format!(
                    "{} are constant, so {} are used",
                    other.name(),
                    own.name()
                ));
            } else if own == Own::Textures
                && let Some(other) = offers.get(i + 1)
            {
                input.notes.push(format!(
                    "{} are used as data; --data colors uses {}",
                    own.name(),
                    other.name()
                ));
            }
            return Ok(input);
        }
        match constant {
            Some((_, input)) => Ok(input),
            None => Err(self.lacks("has neither colors nor textures")),
        }
    }

    pub(super) fn has(&self, own: Own) -> bool {
        let materials = self.mesh.materials.as_ref();
        match own {
            Own::Textures => {
                self.source.texture().is_some()
                    || self.mesh.uv.is_some() && materials.is_some_and(|m| !images(m).is_empty())
            }
            Own::Vertices => self.mesh.colors.is_some(),
            Own::Faces => {
                self.mesh.face_colors.is_some()
                    || materials.is_some_and(|m| m.all.iter().any(|m| m.color.is_some()))
            }
        }
    }

    /// With `all`, every image must be readable.
    pub(super) fn read_own(&self, own: Own, all: bool) -> Result<InputData> {
        match own {
            Own::Textures => self.textures(None, all),
            Own::Vertices => {
                let colors = self.mesh.colors.clone().unwrap_or_default();
                let unknown = colors.iter().filter(|color| color[0].is_nan()).count();
                if unknown > 0 {
                    tracing::warn!(
                        "{unknown} of {} no color; {INHERIT}",
                        counted(colors.len(), "vertex has", "vertices have")
                    );
                }
                colored(colors, "colors".into())
            }
            Own::Faces => {
                let mut sums = Sums::new(self.mesh);
                let mut bare = 0;
                for j in 0..self.mesh.faces.len() {
                    match color_of_face(self.mesh, j) {
                        Some(color) => sums.add_color(self.mesh, j, color),
                        None => bare += 1,
                    }
                }
                let colors = sums.means(self.mesh);
                if bare > 0 {
                    let unknown = colors.iter().filter(|color| color[0].is_nan()).count();
                    tracing::warn!(
                        "{bare} of {} no color, so {} no data; {INHERIT}",
                        counted(self.mesh.faces.len(), "face has", "faces have"),
                        counted(unknown, "vertex has", "vertices have")
                    );
                }
                colored(colors, "colors of faces".into())
            }
        }
    }

    /// An error that says what the mesh lacks, and lists all data that can be chosen.
    pub(super) fn lacks(&self, what: &str) -> Error {
        let has_uv = self.mesh.uv.is_some() || matches!(self.source, Source::Shape(_));
        let mut choices = Vec::new();
        if self.has(Own::Vertices) || self.has(Own::Faces) {
            choices.push("--data colors");
        }
        if self.has(Own::Textures) {
            choices.push("--data texture");
        }
        if has_uv {
            choices.extend(["--data texture:IMAGE", "--data image:IMAGE"]);
        } else {
            choices.push("--data image:IMAGE --project xy");
        }
        choices.push("--data curvature");
        Error::unsuitable(format!(
            "{}: {what}; choose {} or --data FILE.npy",
            self.source,
            choices.join(", ")
        ))
    }
}
