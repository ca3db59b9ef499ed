//! The image or color of each face, and the resulting colors of the vertices.
//!
//! **Materials.** A face has the image of its material; without one, its own color or that of the material (`Kd`).
//! **Tiles.** Images whose names have a UDIM number, `skin.1001.png`, `skin_1001.png` or `skin.<UDIM>.png`, are tiles
//! if coordinates leave [0, 1]: tile (i, j) is the image 1001 + i + 10 j, 0 <= i <= 9, of the same folder.
//! **Placements** transform the coordinates of a face first; a clamped image has one copy and no tiles. A face is
//! **unknown** if it has an image but no texture coordinates, neither image nor color, or a tile without an image.

use std::borrow::Cow;
use std::collections::HashMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::decode::Turn;
use super::pyramid::Texture;
use super::sample::{Texel, tile};
use super::udim::{Tiled, number_of};
use super::vertices::{Sums, is_placed, texels_per_face};
use crate::counted::counted;
use crate::error::{Error, Result};
use crate::mesh::{Image, Material, Materials, Mesh, Placement};
use crate::unreached::INHERIT;

/// An image and the faces that have it.
struct Picture {
    content: Content,
    /// The name of its material.
    material: Option<String>,
    placement: Placement,
    /// Ascending, at most F.
    faces: Vec<u32>,
}

/// The location of an image.
#[derive(Clone)]
pub enum Content {
    /// A PNG or JPEG file, and whether its EXIF orientation is applied.
    File(PathBuf, Turn),
    /// The content of a PNG or JPEG file, embedded in the program.
    Embedded(&'static [u8]),
    /// The name of an image inside the file of the mesh, and its content.
    Inside(PathBuf, Arc<[u8]>),
}

/// Images and colors of all faces.
pub struct Paints<'a> {
    /// Texture coordinates in the images of the faces.
    uv: Cow<'a, [[[f64; 2]; 3]]>,
    pictures: Vec<Picture>,
    colored: Vec<(u32, [f64; 3])>,
    without_coordinates: usize,
    without_image_and_color: usize,
    without_tile: usize,
    /// The names of missing images of tiles.
    missing: Vec<String>,
}

/// The colors of the vertices, and where they came from.
pub struct Painted {
    /// V colors; NaN where unknown.
    pub colors: Vec<[f64; 3]>,
    /// The names of the images.
    pub images: Vec<String>,
    /// The median number of texels per face.
    pub texels_per_face: f64,
}

/// The color of a face: its own, or else that of its material.
pub fn color_of_face(mesh: &Mesh, j: usize) -> Option<[f64; 3]> {
    let own = mesh.face_colors.as_ref().map(|colors| colors[j]);
    own.filter(|color| !color[0].is_nan()).or_else(|| {
        let materials = mesh.materials.as_ref()?;
        materials.all[materials.of_faces[j]? as usize].color
    })
}

/// The images of the materials of a mesh, each once.
pub fn images(materials: &Materials) -> Vec<&Path> {
    let mut images: Vec<&Path> = Vec::new();
    for image in materials.all.iter().filter_map(|material| material.image.as_ref()) {
        if !images.contains(&image.path()) {
            images.push(image.path());
        }
    }
    images
}

/// The images that a given one takes the place of: those of its name, or, if there are none, of its name in another
/// case.
pub fn replaced<'a>(images: &[&'a Path], given: &Path) -> Vec<&'a Path> {
    let of_name = |same: fn(&Path, &Path) -> bool| -> Vec<&'a Path> {
        images.iter().copied().filter(|image| same(image, given)).collect()
    };
    let exactly = of_name(is_exactly);
    if exactly.is_empty() { of_name(is_same_image) } else { exactly }
}

/// Whether two names are the same, including tiles.
fn is_exactly(a: &Path, b: &Path) -> bool {
    match (Tiled::of(a), Tiled::of(b)) {
        (Some(a), Some(b)) => a.before == b.before && a.behind == b.behind,
        _ => a.file_name() == b.file_name(),
    }
}

/// Whether two names denote the same image in any case, including its tiles.
fn is_same_image(a: &Path, b: &Path) -> bool {
    let names = |a: Option<&OsStr>, b: Option<&OsStr>| match (a, b) {
        (Some(a), Some(b)) => a.eq_ignore_ascii_case(b),
        _ => false,
    };
    match (Tiled::of(a), Tiled::of(b)) {
        (Some(a), Some(b)) => {
            a.before.eq_ignore_ascii_case(&b.before) && a.behind.eq_ignore_ascii_case(&b.behind)
        }
        _ => names(a.file_name(), b.file_name()),
    }
}

impl<'a> Paints<'a> {
    fn new(uv: &'a [[[f64; 2]; 3]], pictures: Vec<Picture>) -> Self {
        Paints {
            uv: Cow::Borrowed(uv),
            pictures,
            colored: Vec::new(),
            without_coordinates: 0,
            without_image_and_color: 0,
            without_tile: 0,
            missing: Vec::new(),
        }
    }

    /// One image for all faces.
    pub fn of_image(content: Content, uv: &'a [[[f64; 2]; 3]]) -> Self {
        let placement = Placement::default();
        let picture = Picture { content, material: None, placement, faces: Vec::new() };
        let mut paints = Paints::new(uv, vec![picture]);
        for j in 0..uv.len() {
            paints.assign(j, 0);
        }
        paints.tiles();
        paints
    }

    /// The image or color of the material of each face. `given` replaces the image of the same name, and images that
    /// are not where the materials say are searched for next to it.
    pub fn of_materials(
        mesh: &Mesh,
        materials: &Materials,
        uv: &'a [[[f64; 2]; 3]],
        given: Option<&Path>,
    ) -> Self {
        let mut paints = Paints::new(uv, Vec::new());
        let named = images(materials);
        let replaced = given.map_or(Vec::new(), |given| replaced(&named, given));
        let mut known = HashMap::new();
        let mut index_of = |image: &Image, placement: Placement, material: &str| {
            *known.entry((image.clone(), placement.bits())).or_insert_with(|| {
                paints.pictures.push(Picture {
                    content: content(image, given, &replaced),
                    material: Some(material.to_owned()),
                    placement,
                    faces: Vec::new(),
                });
                paints.pictures.len() - 1
            })
        };
        let index_of = |material: &Material| {
            Some(index_of(material.image.as_ref()?, material.placement, &material.name))
        };
        let of_materials: Vec<Option<usize>> = materials.all.iter().map(index_of).collect();
        for (j, material) in materials.of_faces.iter().enumerate() {
            match material.and_then(|m| of_materials[m as usize]) {
                Some(picture) => {
                    let placement = paints.pictures[picture].placement;
                    if !placement.is_identity() {
                        paints.uv.to_mut()[j] = placement.of(&uv[j]);
                    }
                    paints.assign(j, picture);
                }
                None => match color_of_face(mesh, j) {
                    Some(color) => paints.colored.push((j as u32, color)),
                    None => paints.without_image_and_color += 1,
                },
            }
        }
        paints.tiles();
        paints
    }

    /// The files on which the colors depend.
    pub fn files(&self) -> Vec<&Path> {
        let mut files = Vec::new();
        for picture in self.pictures.iter().filter(|picture| !picture.faces.is_empty()) {
            if let Content::File(path, _) = &picture.content {
                files.push(path.as_path());
            }
        }
        files
    }

    /// The numbers of texels along a unit of u and of v on each face, F x 2; 0 on faces without an image.
    ///
    /// # Errors
    /// An image cannot be read.
    pub fn density(&self) -> Result<Vec<[f64; 2]>> {
        let mut density = vec![[0.0; 2]; self.uv.len()];
        for picture in self.pictures.iter().filter(|picture| !picture.faces.is_empty()) {
            let (_, texture) = picture.open()?;
            let size = [texture.width, texture.height].map(f64::from);
            let texels = [0, 1].map(|axis| size[axis] * picture.placement.scale[axis].abs());
            picture.faces.iter().for_each(|&j| density[j as usize] = texels);
        }
        Ok(density)
    }

    fn assign(&mut self, j: usize, picture: usize) {
        if is_placed(&self.uv[j]) {
            self.pictures[picture].faces.push(j as u32);
        } else {
            self.without_coordinates += 1;
        }
    }

    /// Splits images into their tiles.
    fn tiles(&mut self) {
        let uv = &self.uv;
        for picture in std::mem::take(&mut self.pictures) {
            let tiled = match &picture.content {
                Content::File(path, turn) => {
                    let uv = picture.faces.iter().map(|&j| &uv[j as usize]);
                    Tiled::in_use(path, picture.placement.clamp, uv).map(|tiled| (tiled, *turn))
                }
                Content::Embedded(_) | Content::Inside(..) => None,
            };
            let Some((tiled, turn)) = tiled else {
                self.pictures.push(picture);
                continue;
            };
            let mut of_tiles: HashMap<Option<u32>, Option<usize>> = HashMap::new();
            for &j in &picture.faces {
                let number = number_of(tile(&uv[j as usize]));
                let index = *of_tiles.entry(number).or_insert_with(|| {
                    let path = tiled.path(number?);
                    if !path.exists() {
                        self.missing.push(name_of(&path));
                        return None;
                    }
                    let material = picture.material.clone();
                    let content = Content::File(path, turn);
                    let placement = Placement { clamp: false, ..picture.placement };
                    self.pictures.push(Picture { content, material, placement, faces: Vec::new() });
                    Some(self.pictures.len() - 1)
                });
                match index {
                    Some(index) => self.pictures[index].faces.push(j),
                    None => self.without_tile += 1,
                }
            }
        }
    }

    /// The colors of the vertices; one image is in memory at a time.
    ///
    /// # Errors
    /// An image cannot be read, and `all` are required or no other image can be read; or no face has an image or a
    /// color.
    pub fn colors(self, mesh: &Mesh, texel: Texel, all: bool) -> Result<Painted> {
        let mut painting = Painting::new(mesh, self.uv.len());
        for &(j, color) in &self.colored {
            painting.add_color(mesh, j as usize, color);
        }
        for picture in self.pictures.iter().filter(|picture| !picture.faces.is_empty()) {
            match picture.open() {
                Ok(opened) => painting.add_picture(mesh, &self.uv, &picture.faces, opened, texel),
                Err(error) if all => return Err(error),
                Err(error) => {
                    painting.unread += picture.faces.len();
                    painting.first_error.get_or_insert(error);
                }
            }
        }
        let Painting { sums, known, sizes, images, unread, first_error } = painting;
        if let Some(error) = first_error {
            if images.is_empty() {
                return Err(error);
            }
            tracing::warn!("{error}");
        }
        let reasons = self.reasons(unread);
        if known == 0 {
            return Err(Error::unsuitable(format!(
                "no face has a color ({reasons}); choose other data"
            )));
        }
        let colors = sums.means(mesh);
        if !reasons.is_empty() {
            let unknown = colors.iter().filter(|color| color[0].is_nan()).count();
            tracing::warn!(
                "of {}, {reasons}, so {} no data; {INHERIT}",
                counted(mesh.faces.len(), "face", "faces"),
                counted(unknown, "vertex has", "vertices have")
            );
        }
        Ok(Painted { colors, images, texels_per_face: texels_per_face(&self.uv, |j| sizes[j]) })
    }

    /// The reasons why faces have no color, with their numbers; the images of `unread` faces cannot be read.
    fn reasons(&self, unread: usize) -> String {
        let counts = [
            (self.without_coordinates, ["has", "have"], "no texture coordinates"),
            (self.without_image_and_color, ["has", "have"], "neither an image nor a color"),
            (unread, ["has", "have"], "an image that cannot be read"),
            (self.without_tile, ["lies", "lie"], "on a tile without an image"),
        ];
        let reasons = counts.iter().filter(|(count, ..)| *count > 0);
        let reasons: Vec<String> = reasons
            .map(|&(count, [one, many], reason)| counted(count, one, many) + " " + reason)
            .collect();
        let mut reasons = reasons.join(", ");
        if !self.missing.is_empty() {
            let more = if self.missing.len() > 3 { ", ..." } else { "" };
            let first = &self.missing[..self.missing.len().min(3)];
            reasons += &format!(" ({}{more} not found)", first.join(", "));
        }
        reasons
    }
}

impl Picture {
    /// The name and the content of the image.
    fn open(&self) -> Result<(String, Texture)> {
        let (name, texture) = match &self.content {
            Content::File(path, turn) => (name_of(path), Texture::open(path, *turn)),
            Content::Embedded(bytes) => {
                ("the embedded image".into(), Texture::decode(bytes, Path::new("image")))
            }
            Content::Inside(name, bytes) => (name_of(name), Texture::decode(bytes, name)),
        };
        let mut texture = texture.map_err(|error| match &self.material {
            Some(name) => {
                Error::unsuitable(format!("the image of material {}: {error}", name.escape_debug()))
            }
            None => error,
        })?;
        texture.clamp = self.placement.clamp;
        Ok((name, texture))
    }
}

/// The colors of the faces, accumulated at the vertices.
struct Painting {
    sums: Sums,
    /// The number of faces with a color.
    known: usize,
    /// The sizes of the images of the faces, in texels.
    sizes: Vec<Option<[f64; 2]>>,
    /// The names of the images.
    images: Vec<String>,
    /// The number of faces with images that cannot be read.
    unread: usize,
    first_error: Option<Error>,
}

impl Painting {
    fn new(mesh: &Mesh, faces: usize) -> Self {
        Painting {
            sums: Sums::new(mesh),
            known: 0,
            sizes: vec![None; faces],
            images: Vec::new(),
            unread: 0,
            first_error: None,
        }
    }

    fn add_color(&mut self, mesh: &Mesh, j: usize, color: [f64; 3]) {
        self.known += 1;
        self.sums.add_color(mesh, j, color);
    }

    fn add_picture(
        &mut self,
        mesh: &Mesh,
        uv: &[[[f64; 2]; 3]],
        faces: &[u32],
        (name, mut texture): (String, Texture),
        texel: Texel,
    ) {
        for &j in faces {
            self.sizes[j as usize] = Some([texture.width, texture.height].map(f64::from));
        }
        self.known += faces.len();
        // Materials may place one image in several ways.
        if !self.images.contains(&name) {
            self.images.push(name);
        }
        let face = |i: usize| faces[i] as usize;
        self.sums.add_texture(mesh, uv, &mut texture, texel, faces.len(), face);
    }
}

/// The content of an image; the given file is that of those that it replaces.
fn content(image: &Image, given: Option<&Path>, replaced: &[&Path]) -> Content {
    match (image, given) {
        (image, Some(given)) if replaced.contains(&image.path()) => {
            Content::File(given.to_owned(), Turn::AsStored)
        }
        (Image::Inside(name, bytes), _) => Content::Inside(name.clone(), bytes.clone()),
        (Image::File(path), given) => Content::File(whereabouts(path, given), Turn::AsStored),
    }
}

/// The path of an image: where the materials say, or next to the given one.
fn whereabouts(image: &Path, given: Option<&Path>) -> PathBuf {
    match given {
        Some(given) if !image.exists() => {
            match image.file_name().map(|name| given.with_file_name(name)) {
                Some(beside) if beside.exists() => beside,
                _ => image.to_owned(),
            }
        }
        _ => image.to_owned(),
    }
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_are_the_same_in_any_case_and_for_any_tile() {
        assert!(is_same_image(Path::new("a/s.1001.png"), Path::new("S.<UDIM>.png")));
        assert!(is_same_image(Path::new("a/Roof.png"), Path::new("roof.PNG")));
        assert!(!is_same_image(Path::new("roof.png"), Path::new("wall.png")));
    }
}
