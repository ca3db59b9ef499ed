//! What data a mesh shows: the textures of its materials, the colors of its vertices or faces, an image laid on
//! it, its mean curvature, or an array.

use std::borrow::Cow;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use super::curved::{Curved, SIGN, curved};
use super::projection::{Fit, Projection};
use super::texture::{
    Content, Painted, Paints, Sums, Texel, Texture, Turn, color_of_face, images, is_same_image,
    texels_a_face,
};
use super::{Data, looks};
use crate::error::{Error, Result};
use crate::mesh::geometry::barycentric_areas;
use crate::mesh::shapes::MOST_FACES;
use crate::mesh::{Mesh, Shape, Source, Weld};
use crate::npy;
use crate::render::colormap::sequential;

/// `colors`, `texture`, `texture:IMAGE`, `image:IMAGE`, `curvature` or `FILE.npy`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DataSource {
    Colors,
    /// An image at the texture coordinates, or those that the materials name.
    Texture(Option<PathBuf>),
    /// An image laid on the surface.
    Image(PathBuf),
    Curvature,
    File(PathBuf),
}

impl DataSource {
    /// The forms that [`DataSource::from_str`] takes.
    pub const SYNTAX: &str = "colors, texture, texture:IMAGE, image:IMAGE, curvature or FILE.npy";
}

impl FromStr for DataSource {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match (text, text.split_once(':')) {
            ("colors", _) => Ok(DataSource::Colors),
            ("curvature", _) => Ok(DataSource::Curvature),
            ("texture", _) => Ok(DataSource::Texture(None)),
            (_, Some(("texture", image))) if !image.is_empty() => {
                Ok(DataSource::Texture(Some(image.into())))
            }
            (_, Some(("image", image))) if !image.is_empty() => Ok(DataSource::Image(image.into())),
            (file, _) if file.ends_with(".npy") => Ok(DataSource::File(file.into())),
            _ => Err(format!("must be {}", DataSource::SYNTAX)),
        }
    }
}

impl fmt::Display for DataSource {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            DataSource::Colors => f.write_str("colors"),
            DataSource::Texture(None) => f.write_str("texture"),
            DataSource::Texture(Some(image)) => write!(f, "texture:{}", image.display()),
            DataSource::Image(image) => write!(f, "image:{}", image.display()),
            DataSource::Curvature => f.write_str("curvature"),
            DataSource::File(path) => path.display().fmt(f),
        }
    }
}

/// How images come onto a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Manner {
    pub texel: Texel,
    /// Of `image:`; without it the texture coordinates, and xy for a grid.
    pub project: Option<Projection>,
    pub fit: Fit,
}

/// The data, how it looks, and what to call it.
pub struct Seen {
    pub data: Data,
    /// A color per vertex; NaN where the data are unknown.
    pub looks: Vec<[f64; 3]>,
    pub name: String,
    /// What 0 and 1 stand for, if the data was mapped.
    pub unit_range: Option<[f64; 2]>,
    /// What was chosen, and what else there is to choose, a line each.
    pub notes: Vec<String>,
    /// What the sign of the data means, if it has a meaning that is not plain.
    pub sign: Option<&'static str>,
    pub warnings: Vec<String>,
}

/// Above so many texels a face, the mesh is said to be too coarse for its texture, and should have at most so many.
const MANY_TEXELS: f64 = 16.0;
const FEW_TEXELS: f64 = 4.0;

/// The data of a mesh; without a choice the textures or the colors that come with it. If the mesh is what a weld made
/// of that of the source, arrays have a row for every vertex of the source, and the merged ones take their means.
///
/// Data that are the same everywhere to rounding become the same, with a warning: nothing is stretched.
///
/// # Errors
/// Data that the mesh does not have, files that cannot be read or do not fit it.
pub fn see(
    source: &Source,
    mesh: &Mesh,
    weld: Option<&Weld>,
    choice: Option<&DataSource>,
    manner: &Manner,
) -> Result<Seen> {
    let mut seen = look(source, mesh, weld, choice, manner)?;
    if seen.unit_range.is_none() && flatten(&mut seen.data) {
        let what = if matches!(choice, Some(DataSource::File(_))) { "values" } else { "color" };
        seen.warnings.push(format!(
            "{}: all vertices have the same {what}: there is nothing to segment",
            seen.name
        ));
    }
    Ok(seen)
}

/// Differences below this share of the data are rounding.
const ROUNDING: f64 = 1e-13;

/// Makes data constant that are so up to rounding, in each coordinate and where they are known.
fn flatten(data: &mut Data) -> bool {
    let known = |row: &&[f64]| row.iter().all(|x| !x.is_nan());
    let Some(first) = data.values.chunks(data.dimension).find(known).map(<[f64]>::to_vec) else {
        return false;
    };
    let same = |i: usize| {
        let column = data.values.iter().skip(i).step_by(data.dimension).filter(|x| !x.is_nan());
        let extremes = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = column.fold(extremes, |(low, high), &x| (x.min(low), x.max(high)));
        high - low <= ROUNDING * low.abs().max(high.abs())
    };
    if !(0..data.dimension).all(same) {
        return false;
    }
    for row in data.values.chunks_mut(data.dimension).filter(|row| known(&&**row)) {
        row.copy_from_slice(&first);
    }
    true
}

/// The image files that these data are taken from, those of materials and tiles among them; none where there are none.
pub fn image_files(
    source: &Source,
    mesh: &Mesh,
    choice: Option<&DataSource>,
    manner: &Manner,
) -> Vec<PathBuf> {
    let view = View { source, mesh, manner };
    let Some(uv) = view.uv() else {
        return match choice {
            Some(DataSource::Image(image)) => vec![image.clone()],
            _ => Vec::new(),
        };
    };
    let paints = match choice {
        Some(DataSource::Image(image)) if view.projection().is_some() => {
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
            match view.paints(given, &uv) {
                Ok((paints, _)) => paints,
                Err(_) => return Vec::new(),
            }
        }
        Some(DataSource::Colors | DataSource::Curvature | DataSource::File(_)) => {
            return Vec::new();
        }
    };
    paints.files().into_iter().map(Path::to_owned).collect()
}

fn look(
    source: &Source,
    mesh: &Mesh,
    weld: Option<&Weld>,
    choice: Option<&DataSource>,
    manner: &Manner,
) -> Result<Seen> {
    if manner.project.is_some() && !matches!(choice, Some(DataSource::Image(_))) {
        return Err(Error::unsuitable(
            "--project lays an image on the mesh; name it by --data image:IMAGE",
        ));
    }
    let view = View { source, mesh, manner };
    match choice {
        None => view.own(),
        Some(DataSource::Colors) => {
            match [Own::Vertices, Own::Faces].into_iter().find(|&own| view.has(own)) {
                Some(own) => view.see_own(own, true),
                None => Err(view.lacks("has no colors of vertices, faces or materials")),
            }
        }
        Some(DataSource::Texture(image)) => view.textures(image.as_deref(), true),
        Some(DataSource::Image(image)) => view.image(image),
        Some(DataSource::Curvature) => {
            let curved = curved(mesh).map_err(|error| error.of_file(&view.name()));
            let Curved { values, range, warnings } = curved?;
            Ok(Seen {
                looks: values.iter().map(|&t| sequential(t)).collect(),
                data: Data::new(1, values)?,
                name: "mean curvature".into(),
                unit_range: Some(range),
                notes: Vec::new(),
                sign: Some(SIGN),
                warnings,
            })
        }
        Some(DataSource::File(path)) => numbers(mesh, weld, path),
    }
}

struct View<'a> {
    source: &'a Source,
    mesh: &'a Mesh,
    manner: &'a Manner,
}

/// What may come with a mesh, the first choice first.
#[derive(Clone, Copy, PartialEq)]
enum Own {
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

impl View<'_> {
    /// The first of what comes with the mesh that can be read and is not of one value.
    fn own(&self) -> Result<Seen> {
        let offers: Vec<Own> = [Own::Textures, Own::Vertices, Own::Faces]
            .into_iter()
            .filter(|&own| self.has(own))
            .collect();
        let mut constant: Option<(Own, Seen)> = None;
        let mut refused: Option<Error> = None;
        for (i, &own) in offers.iter().enumerate() {
            let mut seen = match self.see_own(own, false) {
                Ok(seen) => seen,
                Err(error) if i + 1 == offers.len() && constant.is_none() => {
                    return Err(refused.unwrap_or(error));
                }
                Err(error) => {
                    tracing::warn!("{error}; {} are left out", own.name());
                    refused.get_or_insert(error);
                    continue;
                }
            };
            if !varies(&seen.data) {
                constant.get_or_insert((own, seen));
                continue;
            }
            if let Some((other, _)) = constant {
                seen.notes.push(format!(
                    "{} are all of one value: {} are taken",
                    other.name(),
                    own.name()
                ));
            } else if own == Own::Textures
                && let Some(other) = offers.get(i + 1)
            {
                seen.notes.push(format!(
                    "{} are taken as data; --data colors takes {}",
                    own.name(),
                    other.name()
                ));
            }
            return Ok(seen);
        }
        match constant {
            Some((_, seen)) => Ok(seen),
            None => Err(self.lacks("has neither colors nor textures of its own")),
        }
    }

    fn has(&self, own: Own) -> bool {
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

    /// `all`: every image must be there.
    fn see_own(&self, own: Own, all: bool) -> Result<Seen> {
        match own {
            Own::Textures => self.textures(None, all),
            Own::Vertices => {
                let colors = self.mesh.colors.clone().unwrap_or_default();
                let unknown = colors.iter().filter(|color| color[0].is_nan()).count();
                if unknown > 0 {
                    tracing::warn!(
                        "{unknown} of {} vertices have no color; they take the labels of their neighbors",
                        colors.len()
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
                        "{bare} of {} faces have no color: {unknown} vertices have no data; they take the labels \
                         of their neighbors",
                        self.mesh.faces.len()
                    );
                }
                colored(colors, "colors of faces".into())
            }
        }
    }

    /// The images of the materials, or the given one, at the texture coordinates; `all` must be there.
    fn textures(&self, given: Option<&Path>, all: bool) -> Result<Seen> {
        let Some(uv) = self.uv() else {
            return Err(self.lacks("has no texture coordinates"));
        };
        let (paints, notes) = self.paints(given, &uv)?;
        let painted = paints.colors(self.mesh, self.manner.texel, all);
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

    /// Which face has which image, and what is to be said about the one that was given.
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
            (None, ..) => return Err(self.lacks("has no materials that name an image")),
            (Some(image), _, Some(materials))
                if named.iter().any(|named| is_same_image(named, image)) =>
            {
                if named.len() > 1 {
                    notes.push(format!(
                        "{} is one of {} images that the materials name: each face takes that of its material",
                        image.display(),
                        named.len()
                    ));
                }
                Paints::of_materials(self.mesh, materials, uv, Some(image))
            }
            (Some(image), ..) => {
                if named.len() > 1 {
                    notes.push(format!(
                        "{} is none of the {} images that the materials name and is taken for all faces; --data \
                         texture takes theirs",
                        image.display(),
                        named.len()
                    ));
                }
                Paints::of_image(Content::File(image.to_owned(), Turn::AsStored), uv)
            }
        };
        Ok((paints, notes))
    }

    /// An image by the projection that was asked for, or at the texture coordinates.
    fn image(&self, image: &Path) -> Result<Seen> {
        let name = format!("image {}", image.display());
        let Manner { texel, fit, .. } = *self.manner;
        if let Some(projection) = self.projection() {
            let mut texture = Texture::open(image, Turn::Upright)?;
            let size = [texture.width, texture.height];
            let laid = projection.lay(self.mesh, size, fit);
            let laid = laid.map_err(|error| error.of_file(&self.name()))?;
            let mut sums = Sums::new(self.mesh);
            sums.add_texture(self.mesh, &laid.uv, &mut texture, texel, laid.uv.len(), |j| j);
            let painted = Painted {
                colors: sums.means(self.mesh),
                images: Vec::new(),
                texels_a_face: texels_a_face(&laid.uv, |_| Some(size.map(f64::from))),
            };
            return self.painted(painted, name, vec![laid.how]);
        }
        let Some(uv) = self.uv() else {
            return Err(Error::unsuitable(format!(
                "{}: has no texture coordinates to lay an image on; add --project {}",
                self.source,
                Projection::SYNTAX
            )));
        };
        let paints = Paints::of_image(Content::File(image.to_owned(), Turn::Upright), &uv);
        let painted = paints.colors(self.mesh, texel, true);
        let painted = painted.map_err(|error| error.of_file(&self.name()))?;
        let note = "the image lies at the texture coordinates of the mesh; --project xy lays it over its front";
        self.painted(painted, name, vec![note.into()])
    }

    /// How `image:` is laid on the surface, if not at its texture coordinates.
    fn projection(&self) -> Option<Projection> {
        match (self.manner.project, self.source) {
            (None, Source::Shape(Shape::Grid { .. })) => Some(Projection::XY),
            (project, _) => project,
        }
    }

    fn painted(&self, painted: Painted, name: String, mut notes: Vec<String>) -> Result<Seen> {
        notes.extend(self.hint(painted.texels_a_face));
        let mut seen = colored(painted.colors, name)?;
        seen.notes = notes;
        Ok(seen)
    }

    /// What to do about a texture that the mesh does not resolve.
    fn hint(&self, texels_a_face: f64) -> Option<String> {
        if texels_a_face <= MANY_TEXELS {
            return None;
        }
        let faces = self.mesh.faces.len() as u64;
        let fits = |times: &u32| faces.saturating_mul(4_u64.pow(*times)) <= MOST_FACES / 10;
        let wanted = ((texels_a_face / FEW_TEXELS).log2() / 2.0).ceil() as u32;
        let times = (1..=wanted.min(8)).rev().find(fits);
        let finer = times.map_or(String::new(), |times| {
            format!(
                "; `meshseg mesh convert {} --out finer.obj --subdivide {times}` resolves more",
                in_shell(&self.source.to_string())
            )
        });
        Some(format!(
            "the image is finer than the mesh, about {texels_a_face:.0} texels a face: vertices take {}{finer}",
            match self.manner.texel {
                Texel::Mean => "means",
                Texel::Vertex => "one point each",
            }
        ))
    }

    /// The texture coordinates, which shapes have too.
    fn uv(&self) -> Option<Cow<'_, [[[f64; 2]; 3]]>> {
        match (&self.mesh.uv, self.source) {
            (Some(uv), _) => Some(Cow::Borrowed(uv)),
            (None, Source::Shape(shape)) => Some(Cow::Owned(shape.uv(self.mesh))),
            (None, _) => None,
        }
    }

    fn name(&self) -> PathBuf {
        self.source.to_string().into()
    }

    /// What the mesh does not have, and all that can be chosen.
    fn lacks(&self, what: &str) -> Error {
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

/// A word of a command line, in quotes where it needs them.
fn in_shell(word: &str) -> Cow<'_, str> {
    if word.bytes().all(|b| b.is_ascii_alphanumeric() || b"._-+/:".contains(&b)) {
        Cow::Borrowed(word)
    } else {
        Cow::Owned(format!("'{}'", word.replace('\'', r"'\''")))
    }
}

/// Whether there is more than one value among the data that are known.
fn varies(data: &Data) -> bool {
    (0..data.dimension).any(|i| {
        let column = || data.values[i..].iter().step_by(data.dimension).filter(|x| !x.is_nan());
        let (low, high) = column()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| (low.min(x), high.max(x)));
        high - low > ROUNDING * low.abs().max(high.abs())
    })
}

fn colored(colors: Vec<[f64; 3]>, name: String) -> Result<Seen> {
    let data = Data::new(3, colors.as_flattened().to_vec())?;
    Ok(Seen {
        data,
        looks: colors,
        name,
        unit_range: None,
        notes: Vec::new(),
        sign: None,
        warnings: Vec::new(),
    })
}

/// Data from a file.
fn numbers(mesh: &Mesh, weld: Option<&Weld>, path: &Path) -> Result<Seen> {
    let array = npy::read_data(path)?;
    npy::check_rows(path, &array, weld.map_or(mesh.vertices.len(), |weld| weld.of.len()))?;
    let d = array.ncols();
    let mut values: Vec<f64> = array.iter().copied().collect();
    if let Some(weld) = weld {
        values = weld.means(&values, d);
    }
    let data = Data::new(d, values).map_err(|error| error.of_file(path))?;
    let looks = looks::colors(&data, &barycentric_areas(mesh));
    let name = path.display().to_string();
    let unknown = (0..data.len()).filter(|&k| !data.is_known(k)).count();
    let warnings = match unknown {
        0 => Vec::new(),
        _ => vec![format!(
            "{name}: nothing is known of {unknown} vertices; they take the labels of their neighbors"
        )],
    };
    Ok(Seen { data, looks, name, unit_range: None, notes: Vec::new(), sign: None, warnings })
}
