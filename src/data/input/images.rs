//! Images on a mesh: by its texture coordinates, or projected onto it.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use super::own::Own;
use super::reader::{InputData, Reader, colored};
use super::source::{DataSource, Mapping};
use crate::data::projection::Projection;
use crate::data::texture::{
    Content, Painted, Paints, Sums, Texel, Texture, Turn, images, replaced, texels_per_face,
};
use crate::error::{Error, Result};
use crate::mesh::shapes::MAX_FACES;
use crate::mesh::{Mesh, Shape, Source};

/// A mesh with more texels per face than this is reported as too coarse for its texture.
const MANY_TEXELS: f64 = 16.0;
/// The number of texels per face that is recommended then.
const FEW_TEXELS: f64 = 4.0;

/// The image files that the chosen data are read from, including those of materials and tiles; empty if there are none.
pub fn image_files(
    source: &Source,
    mesh: &Mesh,
    choice: Option<&DataSource>,
    mapping: &Mapping,
) -> Vec<PathBuf> {
    let reader = Reader { source, mesh, mapping };
    let Some(uv) = reader.uv() else {
        return match choice {
            Some(DataSource::Image(image)) => vec![image.clone()],
            _ => Vec::new(),
        };
    };
    let paints = match choice {
        Some(DataSource::Image(image)) if reader.projection().is_some() => {
            return vec![image.clone()];
        }
        Some(DataSource::Image(image)) => {
            Paints::of_image(Content::File(image.clone(), Turn::Upright), &uv)
        }
        Some(DataSource::Texture(_)) | None => {
            let given = match choice {
                Some(DataSource::Texture(given)) => given.as_deref(),
                _ => None,
            };
            match reader.paints(given, &uv) {
                Ok((paints, _)) => paints,
                Err(_) => return Vec::new(),
            }
        }
        Some(
            DataSource::Colors
            | DataSource::Curvature(_)
            | DataSource::Views(_)
            | DataSource::File(_),
        ) => return Vec::new(),
    };
    paints.files().into_iter().map(Path::to_owned).collect()
}

/// The numbers of texels along a unit of u and of v on each face of the mesh, F x 2, in the images of its materials; 0
/// on faces without an image.
///
/// # Errors
/// The mesh has no texture coordinates or no material with an image, or an image cannot be read.
pub fn density(source: &Source, mesh: &Mesh) -> Result<Vec<[f64; 2]>> {
    let reader = Reader { source, mesh, mapping: &Mapping::default() };
    let lacks = |what: &str| Error::unsuitable(format!("{source}: has no {what}"));
    let uv = mesh.uv.as_ref().ok_or_else(|| lacks("texture coordinates"))?;
    if !reader.has(Own::Textures) {
        return Err(lacks("material with an image"));
    }
    reader.paints(None, uv)?.0.density()
}

impl Reader<'_> {
    /// The images of the materials, or the given one, by the texture coordinates. With `all`, every image must be
    /// readable.
    pub(super) fn textures(&self, given: Option<&Path>, all: bool) -> Result<InputData> {
        let Some(uv) = self.uv() else {
            return Err(self.lacks("has no texture coordinates"));
        };
        let (paints, notes) = self.paints(given, &uv)?;
        let painted = paints.colors(self.mesh, self.mapping.texel, all);
        let painted = painted.map_err(|error| error.of_file(&self.name()))?;
        let name = match (given, painted.images.as_slice()) {
            (None, _) if self.source.texture().is_some() => "texture".into(),
            (Some(image), [] | [_]) => format!("texture {}", image.display()),
            (None, [image]) => format!("texture {image}"),
            (_, images) if images.len() > 3 => {
                format!("textures {}, ... ({} images)", images[..3].join(", "), images.len())
            }
            (_, images) => format!("textures {}", images.join(", ")),
        };
        self.painted(painted, name, notes)
    }

    /// The image of each face, and notes on the one that was given.
    fn paints<'b>(
        &self,
        given: Option<&Path>,
        uv: &'b [[[f64; 2]; 3]],
    ) -> Result<(Paints<'b>, Vec<String>)> {
        let named = self.mesh.materials.as_ref().map_or(Vec::new(), images);
        let mut notes = Vec::new();
        let paints = match (given, self.source.texture(), &self.mesh.materials) {
            (None, Some(bytes), _) => Paints::of_image(Content::Embedded(bytes), uv),
            (None, None, Some(materials)) if !named.is_empty() => {
                Paints::of_materials(self.mesh, materials, uv, None)
            }
            (None, ..) => return Err(self.lacks("has no material with an image")),
            (Some(image), _, Some(materials)) if !replaced(&named, image).is_empty() => {
                let several = replaced(&named, image).len();
                if several > 1 {
                    notes.push(format!(
                        "{} takes the place of {several} of the {} images of the materials, which have its name",
                        image.display(),
                        named.len()
                    ));
                } else if named.len() > 1 {
                    notes.push(format!(
                        "{} is one of {} images of the materials; each face takes the image of its own material",
                        image.display(),
                        named.len()
                    ));
                }
                Paints::of_materials(self.mesh, materials, uv, Some(image))
            }
            (Some(image), ..) => {
                if named.len() > 1 {
                    notes.push(format!(
                        "{} is not one of the {} images of the materials and is used for all faces; --data texture \
                         uses theirs",
                        image.display(),
                        named.len()
                    ));
                }
                Paints::of_image(Content::File(image.to_owned(), Turn::AsStored), uv)
            }
        };
        Ok((paints, notes))
    }

    /// An image by the requested projection, or by the texture coordinates.
    pub(super) fn image(&self, image: &Path) -> Result<InputData> {
        let name = format!("image {}", image.display());
        let Mapping { texel, fit, .. } = *self.mapping;
        if let Some(projection) = self.projection() {
            let mut texture = Texture::open(image, Turn::Upright)?;
            let size = [texture.width, texture.height];
            let projected = projection.project(self.mesh, size, fit);
            let projected = projected.map_err(|error| error.of_file(&self.name()))?;
            let mut sums = Sums::new(self.mesh);
            sums.add_texture(
                self.mesh,
                &projected.uv,
                &mut texture,
                texel,
                projected.uv.len(),
                |j| j,
            );
            let painted = Painted {
                colors: sums.means(self.mesh),
                images: Vec::new(),
                texels_per_face: texels_per_face(&projected.uv, |_| Some(size.map(f64::from))),
            };
            return self.painted(painted, name, vec![projected.description]);
        }
        let Some(uv) = self.uv() else {
            return Err(Error::unsuitable(format!(
                "{}: has no texture coordinates for an image; add --project {}",
                self.source,
                Projection::SYNTAX
            )));
        };
        let paints = Paints::of_image(Content::File(image.to_owned(), Turn::Upright), &uv);
        let painted = paints.colors(self.mesh, texel, true);
        let painted = painted.map_err(|error| error.of_file(&self.name()))?;
        let note = "the image follows the texture coordinates of the mesh; --project xy projects it onto the \
                    front instead";
        self.painted(painted, name, vec![note.into()])
    }

    /// The projection of `image:`, unless it follows the texture coordinates.
    fn projection(&self) -> Option<Projection> {
        match (self.mapping.project, self.source) {
            (None, Source::Shape(Shape::Grid { .. })) => Some(Projection::XY),
            (project, _) => project,
        }
    }

    fn painted(&self, painted: Painted, name: String, mut notes: Vec<String>) -> Result<InputData> {
        notes.extend(self.hint(painted.texels_per_face));
        let mut input = colored(painted.colors, name)?;
        input.notes = notes;
        Ok(input)
    }

    /// Advice if the mesh does not resolve the texture.
    fn hint(&self, texels_per_face: f64) -> Option<String> {
        if texels_per_face <= MANY_TEXELS {
            return None;
        }
        let faces = self.mesh.faces.len() as u64;
        let fits = |times: &u32| faces.saturating_mul(4_u64.pow(*times)) <= MAX_FACES / 10;
        let wanted = ((texels_per_face / FEW_TEXELS).log2() / 2.0).ceil() as u32;
        let times = (1..=wanted.min(8)).rev().find(fits);
        let finer = times.map_or(String::new(), |times| {
            format!(
                "; `meshseg mesh convert {} --out finer.obj --subdivide {times}` makes a mesh that resolves more",
                in_shell(&self.source.to_string())
            )
        });
        Some(format!(
            "the image is finer than the mesh, with about {texels_per_face:.0} texels per face: each vertex takes \
             {}{finer}",
            match self.mapping.texel {
                Texel::Mean => "the mean around it",
                Texel::Vertex => "the color at one point",
            }
        ))
    }

    /// The texture coordinates of the mesh; those of a generated shape are computed.
    pub(super) fn uv(&self) -> Option<Cow<'_, [[[f64; 2]; 3]]>> {
        match (&self.mesh.uv, self.source) {
            (Some(uv), _) => Some(Cow::Borrowed(uv)),
            (None, Source::Shape(shape)) => Some(Cow::Owned(shape.uv(self.mesh))),
            (None, _) => None,
        }
    }
}

/// A word of a command line, quoted if necessary.
fn in_shell(word: &str) -> Cow<'_, str> {
    if word.bytes().all(|b| b.is_ascii_alphanumeric() || b"._-+/:".contains(&b)) {
        Cow::Borrowed(word)
    } else {
        Cow::Owned(format!("'{}'", word.replace('\'', r"'\''")))
    }
}
