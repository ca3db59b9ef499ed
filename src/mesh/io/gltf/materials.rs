//! The materials of a glTF file: base colors, and images with their placement.
//!
//! ```text
//! material.pbrMetallicRoughness: {baseColorFactor: [r, g, b, a], baseColorTexture: {index, texCoord}}
//! texture -> image: {uri} or {bufferView}
//! KHR_texture_transform: (s, t) -> offset + scale (s, t), so with v = 1 - t upwards
//! (u, v) -> (o_s + c_s u, 1 - c_t - o_t + c_t v)
//! ```
//!
//! A material without a color is white if another one has a color, since programs leave out white, unless it has an
//! image. Images inside the file keep their names, or have a number. What is not valid is left out with a warning.
//!
//! Reference: Khronos Group, *glTF 2.0 Specification*, section 3.9, "Materials", and *KHR_texture_transform*.

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::sync::Arc;

use super::accessor::Reader;
use super::document::{self, Document, TextureUse, entry};
use super::uri::{self, Target};
use crate::mesh::io::occurrences::Occurrences;
use crate::mesh::io::text::quote;
use crate::mesh::{Image, Material, Materials, Placement};

const CLAMPED: u32 = 33071;
const REPEATED: u32 = 10497;

/// The most characters of the name of an image, of up to four bytes each, which leaves room for what is written around
/// it.
const LONGEST_NAME: usize = 40;

/// Texture coordinates that are rounded are still inside the image.
const ROUNDING: f64 = 1e-3;

/// The n of the `TEXCOORD_n` that a material takes.
pub fn texture_set(document: &Document, material: Option<usize>) -> usize {
    let material = material.and_then(|material| entry(&document.materials, material));
    let texture = material.and_then(|material| material.surface()?.texture.as_ref());
    texture.map_or(0, TextureUse::set)
}

/// The materials that faces have. `of_faces` are indices into all materials of the file.
pub fn of_faces(
    path: &Path,
    folder: Option<&Path>,
    reader: &Reader<'_>,
    mut of_faces: Vec<Option<u32>>,
    uv: Option<&[[[f64; 2]; 3]]>,
) -> Option<Materials> {
    let document = reader.document;
    let mut used = vec![false; document.materials.len()];
    of_faces.iter().flatten().for_each(|&index| used[index as usize] = true);
    let mut painter = Painter {
        document,
        reader,
        folder,
        names: HashSet::new(),
        inside: HashMap::new(),
        contents: HashMap::new(),
        left_out: LeftOut::default(),
    };
    let mut all = Vec::new();
    let mut odd = Vec::new();
    let mut number = vec![None; used.len()];
    for index in (0..used.len()).filter(|&index| used[index]) {
        // They have indices of 32 bits in `of_faces`.
        number[index] = u32::try_from(all.len()).ok();
        let (material, is_odd) = painter.material(index);
        all.push(material);
        odd.push(is_odd);
    }
    if all.is_empty() {
        return None;
    }
    of_faces.iter_mut().for_each(|index| *index = index.and_then(|index| number[index as usize]));
    whiten(&mut all, document, &used);
    for (material, uv) in of_faces.iter().zip(uv.unwrap_or_default()) {
        let Some(index) = material.map(|index| index as usize).filter(|&index| odd[index]) else {
            continue;
        };
        let uv = all[index].placement.of(uv);
        // Not if they are unknown.
        let is_outside = |t: &f64| (t - 0.5).abs() > 0.5 + ROUNDING;
        if uv.as_flattened().iter().any(is_outside) {
            odd[index] = false;
            painter.left_out.wrapping.add(|| quote(all[index].name.as_bytes()));
        }
    }
    painter.left_out.warn(path);
    Some(Materials { all, of_faces })
}

/// Gives white to the materials that have neither a color nor an image, if others have a color.
fn whiten(all: &mut [Material], document: &Document, used: &[bool]) {
    if all.iter().all(|material| material.color.is_none()) {
        return;
    }
    let used = (0..used.len()).filter(|&index| used[index]);
    for (material, index) in all.iter_mut().zip(used) {
        let Some(source) = entry(&document.materials, index) else { continue };
        let surface = source.surface();
        if surface.is_none_or(|surface| surface.color.is_none() && surface.texture.is_none()) {
            material.color = Some([1.0; 3]);
        }
    }
}

/// Materials of which something is left out, by name.
#[derive(Default)]
struct LeftOut {
    invalid: Occurrences,
    colors: Occurrences,
    missing: Occurrences,
    transforms: Occurrences,
    wrapping: Occurrences,
}

impl LeftOut {
    fn warn(&self, path: &Path) {
        self.invalid.warn(path, "materials with values of a wrong type have no color and no image");
        self.colors
            .warn(path, "base colors of materials that are not numbers in [0, 1] are left out");
        self.missing.warn(
            path,
            "images of materials that are neither files nor inside the file, or are no PNG or JPEG images there, are left out",
        );
        self.transforms
            .warn(path, "texture transforms that rotate, or are not finite, are ignored");
        self.wrapping.warn(
            path,
            "images that are mirrored, or clamped in one direction only, are repeated instead",
        );
    }
}

struct Painter<'a> {
    document: &'a Document,
    reader: &'a Reader<'a>,
    folder: Option<&'a Path>,
    names: HashSet<String>,
    /// Images inside the file, by their index.
    inside: HashMap<usize, Image>,
    /// The contents of views that are images, which several images may share.
    contents: HashMap<usize, Arc<[u8]>>,
    left_out: LeftOut,
}

impl Painter<'_> {
    /// The material, and whether its image is wrapped in a way that there is no placement for.
    fn material(&mut self, index: usize) -> (Material, bool) {
        let source = entry(&self.document.materials, index);
        let name = self.name(index, source.and_then(|source| source.name.as_deref()));
        let mut material = Material { name, ..Material::default() };
        let location = || quote(material.name.as_bytes());
        if source.is_none() {
            self.left_out.invalid.add(location);
        }
        let Some(surface) = source.and_then(document::Material::surface) else {
            return (material, false);
        };
        if let Some(color) = &surface.color {
            material.color = match color.as_slice() {
                [r, g, b] | [r, g, b, _] => Some([*r, *g, *b]),
                _ => None,
            };
            material.color = material.color.filter(|c| c.iter().all(|c| (0.0..=1.0).contains(c)));
            if material.color.is_none() {
                self.left_out.colors.add(location);
            }
        }
        let Some(texture) = &surface.texture else { return (material, false) };
        material.image = self.image(texture, &material.name);
        if material.image.is_none() {
            return (material, false);
        }
        match placement(texture) {
            Some(placement) => material.placement = placement,
            None => self.left_out.transforms.add(|| quote(material.name.as_bytes())),
        }
        let wrap = self.wrap(texture);
        material.placement.clamp = wrap == [CLAMPED; 2];
        (material, wrap != [CLAMPED; 2] && wrap != [REPEATED; 2])
    }

    /// Its name on one line, or one that no other material has.
    fn name(&mut self, index: usize, given: Option<&str>) -> String {
        let given = given.unwrap_or_default().replace(char::is_control, " ");
        let mut name = match given.trim() {
            "" => format!("material-{index}"),
            name => name.to_owned(),
        };
        while !self.names.insert(name.clone()) {
            name = format!("{name}-{index}");
        }
        name
    }

    fn image(&mut self, texture: &TextureUse, name: &str) -> Option<Image> {
        let Document { textures, images, .. } = self.document;
        let source = entry(textures, texture.index).and_then(|texture| texture.source);
        let found = source.and_then(|index| Some((index, entry(images, index)?)));
        let image = found.and_then(|(index, image)| {
            let uri = image.uri.as_deref().filter(|uri| !uri.is_empty());
            match (uri.map(Target::of), image.buffer_view) {
                (Some(Target::File(file)), _) => {
                    Some(Image::File(self.folder.unwrap_or(Path::new("")).join(file)))
                }
                (Some(Target::Inside(data)), _) => {
                    self.inside(index, image, |_| uri::bytes(data).map(Arc::from))
                }
                (Some(Target::Elsewhere), _) | (None, None) => None,
                (None, Some(view)) => self.inside(index, image, |painter| painter.content(view)),
            }
        });
        if image.is_none() {
            self.left_out.missing.add(|| quote(name.as_bytes()));
        }
        image
    }

    /// The bytes of a view, once for all of its images.
    fn content(&mut self, view: usize) -> Option<Arc<[u8]>> {
        if let Some(known) = self.contents.get(&view) {
            return Some(known.clone());
        }
        let content: Arc<[u8]> = self.reader.view(view).ok()?.into();
        self.contents.insert(view, content.clone());
        Some(content)
    }

    /// An image inside the file. Its name is that in the file, as far as it can be the name of a file, and no other
    /// image has it.
    fn inside(
        &mut self,
        index: usize,
        image: &document::Image,
        content: impl FnOnce(&mut Self) -> Option<Arc<[u8]>>,
    ) -> Option<Image> {
        if let Some(known) = self.inside.get(&index) {
            return Some(known.clone());
        }
        let content = content(self)?;
        let extension = match &content[..] {
            [0x89, b'P', b'N', b'G', ..] => "png",
            [0xff, 0xd8, 0xff, ..] => "jpg",
            _ => return None,
        };
        let is_plain = |c: &char| c.is_alphanumeric() || "-_ ".contains(*c);
        let given = image.name.as_deref().unwrap_or_default();
        let given: String = given.chars().filter(is_plain).take(LONGEST_NAME).collect();
        let mut name = match given.trim() {
            "" => format!("image-{index}"),
            name => name.to_owned(),
        };
        // Names of files may not differ in case only.
        while !self.names.insert(format!("{name}.{extension}").to_lowercase()) {
            name = format!("{name}-{index}");
        }
        let image = Image::Inside(format!("{name}.{extension}").into(), content);
        self.inside.insert(index, image.clone());
        Some(image)
    }

    /// How the image is continued in the directions of u and v.
    fn wrap(&self, texture: &TextureUse) -> [u32; 2] {
        let sampler =
            entry(&self.document.textures, texture.index).and_then(|texture| texture.sampler);
        let sampler = sampler.and_then(|sampler| entry(&self.document.samplers, sampler));
        let [u, v] = sampler.map_or([None; 2], |sampler| [sampler.wrap_s, sampler.wrap_t]);
        [u.unwrap_or(REPEATED), v.unwrap_or(REPEATED)]
    }
}

/// The placement of an image, unless it is rotated.
fn placement(texture: &TextureUse) -> Option<Placement> {
    let Some(transform) = texture.transform() else { return Some(Placement::default()) };
    let [u, v] = transform.offset.unwrap_or([0.0; 2]);
    let scale = transform.scale.unwrap_or([1.0; 2]);
    let offset = [u, 1.0 - scale[1] - v];
    let is_valid = transform.rotation == 0.0 && scale.iter().chain(&offset).all(|x| x.is_finite());
    is_valid.then_some(Placement { scale, offset, clamp: false })
}
