//! PLY, the Stanford polygon format: ascii, binary little endian, binary big endian.
//!
//! The header declares elements and their typed properties, which then follow in that order. Of these,
//!
//! | element | property | becomes |
//! |---|---|---|
//! | `vertex` | scalars `x y z` | the position |
//! | | scalars `red green blue`, `r g b` or `diffuse_red ...`; integers over 255 (`ushort`: 65535), floats up to 1 or 255 | the color |
//! | | scalars `s t`, `u v` or `texture_u texture_v` | texture coordinates of all corners at the vertex |
//! | `face` | list `vertex_indices` or `vertex_index` | a polygon |
//! | | scalars `red green blue` and so on | the color of the face |
//! | | list `texcoord`, u and v of each corner | texture coordinates of the corners |
//! | | scalar `texnumber` | which `comment TextureFile NAME` of the header has the image; with one such comment, all have it |
//! | `tristrips` | list `vertex_indices` | strips, separated by -1; a repeated index is a stitch, not a face |
//!
//! and everything else is skipped. Positions and indices must be valid; invalid colors and texture coordinates are left
//! out with a warning. Only blanks and zero bytes may follow the last element: otherwise a count that is too low would
//! pass for a smaller mesh.
//!
//! We use our own parser: ply-rs-bw does not terminate on `element x 1000000000000000000` without properties, lets the
//! second of two elements with the same name replace the first, and prints messages of several lines.
//!
//! Reference: Greg Turk, *The PLY Polygon File Format*, 1994.

mod faces;
mod header;
mod items;
mod others;
mod scalars;
mod values;
mod write;

use std::path::Path;

use nalgebra::Point3;

use self::faces::Faces;
use self::header::{Element, Encoding, Header, Kind};
use self::items::{colors_of, list_length, skip_property, vertex_index, wrong};
use self::values::{Ascii, Binary, Values};
use super::colors::Colors;
use super::occurrences::{Occurrences, warn};
use super::{
    INVALID_TEXTURE, check_coordinate, check_faces, uv_of_vertices, valid_uv, warn_untextured,
};
use crate::error::{Error, Result};
use crate::mesh::{Image, Material, Materials, Mesh, Placement};
use crate::sweep::join;

pub use self::header::recognizes;
pub use self::scalars::{read_properties, read_scalars};
pub use self::write::{write, write_labeled, write_labeled_faces};

/// `folder` contains the images.
pub fn parse(path: &Path, folder: Option<&Path>, bytes: &[u8]) -> Result<Mesh> {
    let header = Header::parse(path, bytes)?;
    let mut mesh = match header.encoding {
        Encoding::Ascii => body(path, &header, Ascii::new(path, bytes, &header)),
        Encoding::LittleEndian => body(path, &header, Binary::<false>::new(path, bytes, &header)),
        Encoding::BigEndian => body(path, &header, Binary::<true>::new(path, bytes, &header)),
    }?;
    if let Some(materials) = &mut mesh.materials {
        let image = |name: &String| Material {
            name: name.clone(),
            color: None,
            image: Some(Image::File(folder.unwrap_or(Path::new("")).join(name))),
            placement: Placement::default(),
        };
        materials.all = header.textures.iter().map(image).collect();
    }
    Ok(mesh)
}

fn body(path: &Path, header: &Header, mut values: impl Values + Send) -> Result<Mesh> {
    let vertex_count = header
        .elements
        .iter()
        .find(|element| element.name == "vertex")
        .ok_or_else(|| Error::malformed(path, "has no vertices"))?
        .count;
    // If all vertices have the same size, the following elements are read concurrently.
    let (first, behind) = header.elements.split_first().expect("it has vertices");
    let vertex_values = match first.name == "vertex" && !first.properties.is_empty() {
        true => values.split_off(first)?,
        false => None,
    };
    let faces = Faces::new(vertex_count, header.textures.len());
    let (vertices, mut faces) = match vertex_values {
        Some(mut own) => {
            let (vertices, rest) = join(
                || Vertices::read(path, first, &mut own),
                || elements(path, behind, faces, values),
            );
            (vertices?, rest?.1)
        }
        None => elements(path, &header.elements, faces, values)?,
    };
    check_faces(path, &faces.corners)?;
    vertices.invalid_uv.warn(path, INVALID_TEXTURE);
    faces.finish(path, &vertices.positions);
    let count = faces.corners.len();
    let uv = match (faces.uv, vertices.uv) {
        (Some(uv), _) => Some(uv),
        (None, Some(uv)) => Some(uv_of_vertices(&faces.corners, &uv)),
        (None, None) => None,
    };
    Ok(Mesh {
        colors: vertices
            .colors
            .and_then(|colors| colors.finish(path, vertices.positions.len(), "vertices")),
        vertices: vertices.positions,
        face_colors: faces.colors.and_then(|colors| colors.finish(path, count, "faces")),
        uv: uv.and_then(|uv| warn_untextured(path, uv)),
        materials: of_faces(path, header, faces.images, count)
            .map(|of_faces| Materials { all: Vec::new(), of_faces }),
        faces: faces.corners,
    })
}

/// The image of each face, if the file names images.
fn of_faces(
    path: &Path,
    header: &Header,
    images: Option<Vec<Option<u32>>>,
    faces: usize,
) -> Option<Vec<Option<u32>>> {
    match (header.textures.len(), images) {
        (0, _) => None,
        (_, Some(mut images)) => {
            images.resize(faces, None);
            Some(images)
        }
        (1, None) => Some(vec![Some(0); faces]),
        (n, None) => {
            warn(
                path,
                &format!(
                    "names {n} images, but faces have no texnumber to choose one; the images are left out"
                ),
            );
            None
        }
    }
}

/// Reads the given elements.
fn elements(
    path: &Path,
    elements: &[Element],
    mut faces: Faces,
    mut values: impl Values,
) -> Result<(Vertices, Faces)> {
    let mut vertices = Vertices::default();
    for element in elements {
        // Without properties there is nothing to read, whatever the declared count.
        if element.properties.is_empty() && element.count > 0 {
            if matches!(element.name.as_str(), "vertex" | "face" | "tristrips") {
                let message = format!("the element {} has no properties", element.name);
                return Err(Error::malformed(path, message));
            }
            continue;
        }
        values.expect(element)?;
        match element.name.as_str() {
            "vertex" => vertices = Vertices::read(path, element, &mut values)?,
            "face" => faces.read(path, element, &mut values)?,
            "tristrips" => faces.read_strips(path, element, &mut values)?,
            _ => skip(element, &mut values)?,
        }
    }
    values.finish()?;
    Ok((vertices, faces))
}

fn skip(element: &Element, values: &mut impl Values) -> Result<()> {
    for _ in 0..element.count {
        values.begin()?;
        for property in &element.properties {
            skip_property(property, values)?;
        }
    }
    Ok(())
}

/// The contents of the element `vertex`.
#[derive(Default)]
struct Vertices {
    positions: Vec<Point3<f64>>,
    colors: Option<Colors>,
    uv: Option<Vec<[f64; 2]>>,
    invalid_uv: Occurrences,
}

/// The meaning of a property of a vertex.
#[derive(Clone, Copy)]
enum Role {
    Coordinate(usize),
    Color(usize),
    Texture(usize),
    Other,
}

impl Vertices {
    fn read(path: &Path, element: &Element, values: &mut impl Values) -> Result<Self> {
        let mut roles = vec![Role::Other; element.properties.len()];
        for (c, name) in ["x", "y", "z"].into_iter().enumerate() {
            roles[element.scalar(path, name)?] = Role::Coordinate(c);
        }
        let capacity = values.capacity(element);
        let mut colors = colors_of(element).map(|(indices, colors)| {
            for (c, at) in indices.into_iter().enumerate() {
                roles[at] = Role::Color(c);
            }
            colors.with_capacity(capacity)
        });
        let textures = [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]];
        let mut uv = element.first_complete(&textures).map(|found| {
            for (c, (at, _)) in found.into_iter().enumerate() {
                roles[at] = Role::Texture(c);
            }
            Vec::with_capacity(capacity)
        });

        let mut positions = Vec::with_capacity(capacity);
        let mut invalid_uv = Occurrences::default();
        for k in 0..element.count {
            values.begin()?;
            let mut x = [0.0; 3];
            let mut color = [0.0; 3];
            let mut texture = [0.0; 2];
            for (property, &role) in element.properties.iter().zip(&roles) {
                match (property.kind, role) {
                    (Kind::Scalar(scalar), Role::Coordinate(c)) => {
                        x[c] = check_coordinate(values.number(scalar)?)
                            .map_err(wrong(values, "vertex", k))?;
                    }
                    (Kind::Scalar(scalar), Role::Color(c)) => {
                        color[c] = values.number_or_nan(scalar)?;
                    }
                    (Kind::Scalar(scalar), Role::Texture(c)) => {
                        texture[c] = values.number_or_nan(scalar)?;
                    }
                    _ => skip_property(property, values)?,
                }
            }
            positions.push(Point3::from(x));
            if let Some(colors) = &mut colors {
                colors.set(k, color, || format!("vertex {k}"));
            }
            if let Some(uv) = &mut uv {
                uv.push(valid_uv(texture, &mut invalid_uv, || format!("vertex {k}")));
            }
        }
        Ok(Vertices { positions, colors, uv, invalid_uv })
    }
}
