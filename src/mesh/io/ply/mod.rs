//! PLY, the Stanford polygon format: ascii, binary little endian, binary big endian.
//!
//! The header declares elements and their typed properties, which then follow in that order. Of these,
//!
//! | element | property | becomes |
//! |---|---|---|
//! | `vertex` | scalars `x y z` | the position |
//! | | scalars `red green blue` or `diffuse_red ...`; integers over 255 (`ushort`: 65535), floats as they are | the color |
//! | | scalars `s t`, `u v` or `texture_u texture_v` | texture coordinates of all corners at the vertex |
//! | `face` | list `vertex_indices` or `vertex_index` | a polygon |
//! | | list `texcoord`, u and v of each corner | texture coordinates of the corners |
//! | `tristrips` | list `vertex_indices` | strips, separated by -1; a repeated index is a stitch, not a face |
//!
//! and whatever else there is is skipped. Nothing may follow the last element but blanks and zero bytes: a
//! count that is too low would otherwise pass for a smaller mesh.
//!
//! The parser is our own: ply-rs-bw never ends at `element x 1000000000000000000` without properties, lets the
//! second of two elements of one name replace the first, and spreads its messages over several lines.
//!
//! Reference: Greg Turk, *The PLY Polygon File Format*, 1994.

mod header;
mod values;
mod write;

use std::path::Path;

use nalgebra::Point3;

use self::header::{Element, Encoding, Header, Kind, Property, Scalar};
use self::values::{Ascii, Binary, Values};
use super::{check_color, check_coordinate, check_texture, fan, uv_of_vertices};
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::sweep::join;

pub use self::header::recognizes;
pub use self::write::{write, write_labeled};

pub fn parse(path: &Path, bytes: &[u8]) -> Result<Mesh> {
    let header = Header::parse(path, bytes)?;
    match header.encoding {
        Encoding::Ascii => body(path, &header, Ascii::new(path, bytes, &header)),
        Encoding::LittleEndian => body(path, &header, Binary::<false>::new(path, bytes, &header)),
        Encoding::BigEndian => body(path, &header, Binary::<true>::new(path, bytes, &header)),
    }
}

fn body(path: &Path, header: &Header, mut values: impl Values + Send) -> Result<Mesh> {
    let vertex_count = header
        .elements
        .iter()
        .find(|element| element.name == "vertex")
        .ok_or_else(|| Error::malformed(path, "has no vertices"))?
        .count;
    // What comes behind vertices of one size can be read at the same time.
    let (first, behind) = header.elements.split_first().expect("it has vertices");
    let apart = match first.name == "vertex" && !first.properties.is_empty() {
        true => values.apart(first)?,
        false => None,
    };
    let (vertices, faces) = match apart {
        Some(mut own) => {
            let (vertices, rest) = join(
                || Vertices::read(path, first, &mut own),
                || elements(path, behind, vertex_count, values),
            );
            (vertices?, rest?.1)
        }
        None => elements(path, &header.elements, vertex_count, values)?,
    };
    let uv = match (faces.uv_missing, vertices.uv) {
        (false, _) => Some(faces.uv),
        (true, Some(uv)) => Some(uv_of_vertices(&faces.corners, &uv)),
        (true, None) => None,
    };
    Ok(Mesh {
        vertices: vertices.positions,
        colors: vertices.colors,
        faces: faces.corners,
        uv,
        ..Mesh::default()
    })
}

/// The elements that the rest of the file has.
fn elements(
    path: &Path,
    elements: &[Element],
    vertex_count: usize,
    mut values: impl Values,
) -> Result<(Vertices, Faces)> {
    let mut vertices = Vertices::default();
    let mut faces = Faces::default();
    for element in elements {
        // Without properties there is nothing to read, however many there are said to be.
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
            "face" => faces.read(path, element, vertex_count, &mut values)?,
            "tristrips" => faces.read_strips(path, element, vertex_count, &mut values)?,
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
        values.end()?;
    }
    Ok(())
}

fn skip_property(property: &Property, values: &mut impl Values) -> Result<()> {
    match property.kind {
        Kind::Scalar(scalar) => values.skip(scalar, 1),
        Kind::List { count, item } => {
            let n = list_length(values, count)?;
            values.skip(item, n)
        }
    }
}

fn list_length(values: &mut impl Values, count: Scalar) -> Result<u64> {
    let n = values.integer(count)?;
    u64::try_from(n).map_err(|_| values.error(format!("a list has {n} items")))
}

/// What the element `vertex` holds.
#[derive(Default)]
struct Vertices {
    positions: Vec<Point3<f64>>,
    colors: Option<Vec<[f64; 3]>>,
    uv: Option<Vec<[f64; 2]>>,
}

/// What a property of a vertex is good for.
#[derive(Clone, Copy)]
enum Role {
    Coordinate(usize),
    /// With the value that stands for 1.
    Color(usize, f64),
    Texture(usize),
    Other,
}

impl Vertices {
    fn read(path: &Path, element: &Element, values: &mut impl Values) -> Result<Self> {
        let mut roles = vec![Role::Other; element.properties.len()];
        for (c, name) in ["x", "y", "z"].into_iter().enumerate() {
            let (at, _) = element
                .scalar(path, name)?
                .ok_or_else(|| Error::malformed(path, format!("vertices have no {name}")))?;
            roles[at] = Role::Coordinate(c);
        }
        let colors = [["red", "green", "blue"], ["diffuse_red", "diffuse_green", "diffuse_blue"]];
        let has_colors = match element.first_complete(path, &colors)? {
            Some(found) => {
                for (c, (at, scalar)) in found.into_iter().enumerate() {
                    roles[at] = Role::Color(c, scalar.full_intensity());
                }
                true
            }
            None => false,
        };
        let textures = [["s", "t"], ["u", "v"], ["texture_u", "texture_v"]];
        let has_uv = match element.first_complete(path, &textures)? {
            Some(found) => {
                for (c, (at, _)) in found.into_iter().enumerate() {
                    roles[at] = Role::Texture(c);
                }
                true
            }
            None => false,
        };

        let capacity = values.capacity(element);
        let room = |wanted: bool| if wanted { capacity } else { 0 };
        let mut positions = Vec::with_capacity(capacity);
        let mut colors = Vec::with_capacity(room(has_colors));
        let mut uv = Vec::with_capacity(room(has_uv));
        for _ in 0..element.count {
            values.begin()?;
            let mut x = [0.0; 3];
            let mut color = [0.0; 3];
            let mut texture = [0.0; 2];
            for (property, &role) in element.properties.iter().zip(&roles) {
                let (Kind::Scalar(scalar), false) = (property.kind, matches!(role, Role::Other))
                else {
                    skip_property(property, values)?;
                    continue;
                };
                let value = values.number(scalar)?;
                let checked = match role {
                    Role::Coordinate(_) => check_coordinate(value),
                    Role::Color(_, full) => check_color(value / full).map_err(|_| {
                        format!("the color component {value:?} is outside [0, {full}]")
                    }),
                    Role::Texture(_) => check_texture(value),
                    Role::Other => Ok(value),
                };
                let value = checked.map_err(wrong(values, "vertex", positions.len()))?;
                match role {
                    Role::Coordinate(c) => x[c] = value,
                    Role::Color(c, _) => color[c] = value,
                    Role::Texture(c) => texture[c] = value,
                    Role::Other => {}
                }
            }
            values.end()?;
            positions.push(Point3::from(x));
            if has_colors {
                colors.push(color);
            }
            if has_uv {
                uv.push(texture);
            }
        }
        Ok(Vertices { positions, colors: has_colors.then_some(colors), uv: has_uv.then_some(uv) })
    }
}

/// What the elements `face` and `tristrips` hold.
#[derive(Default)]
struct Faces {
    corners: Vec<[u32; 3]>,
    uv: Vec<[[f64; 2]; 3]>,
    /// Whether some face came without texture coordinates.
    uv_missing: bool,
}

impl Faces {
    fn read(
        &mut self,
        path: &Path,
        element: &Element,
        vertices: usize,
        values: &mut impl Values,
    ) -> Result<()> {
        let indices = element.indices(path)?;
        let texcoord = element.list(path, "texcoord")?.map(|(at, _)| at);
        self.uv_missing |= texcoord.is_none();
        self.corners.reserve(values.capacity(element));
        let (mut list, mut polygon) = (Vec::new(), Vec::new());
        let mut textures: Vec<[f64; 2]> = Vec::new();
        for j in 0..element.count {
            values.begin()?;
            polygon.clear();
            textures.clear();
            for (at, property) in element.properties.iter().enumerate() {
                match property.kind {
                    Kind::List { count, item } if at == indices => {
                        let n = list_length(values, count)?;
                        list.clear();
                        values.integers(item, n, &mut list)?;
                        for &k in &list {
                            polygon
                                .push(vertex_index(k, vertices).map_err(wrong(values, "face", j))?);
                        }
                    }
                    Kind::List { count, item } if Some(at) == texcoord => {
                        let n = list_length(values, count)?;
                        if n % 2 == 1 {
                            return Err(values.error(format!("face {j}: texcoord has {n} numbers")));
                        }
                        for _ in 0..n / 2 {
                            let t = [values.number(item)?, values.number(item)?];
                            for t in t {
                                check_texture(t).map_err(wrong(values, "face", j))?;
                            }
                            textures.push(t);
                        }
                    }
                    _ => skip_property(property, values)?,
                }
            }
            values.end()?;
            if polygon.len() < 3 {
                let n = polygon.len();
                return Err(values.error(format!("face {j}: needs 3 corners and has {n}")));
            }
            self.corners.extend(fan(&polygon));
            if textures.len() == polygon.len() {
                self.uv.extend(fan(&textures));
            } else if textures.is_empty() {
                self.uv_missing = true;
            } else {
                let (n, corners) = (textures.len(), polygon.len());
                return Err(values
                    .error(format!("face {j}: {n} texture coordinates for {corners} corners")));
            }
        }
        Ok(())
    }

    /// The triangles (a, b, c), (c, b, d), (c, d, e), ... of each strip a, b, c, d, e, ...
    fn read_strips(
        &mut self,
        path: &Path,
        element: &Element,
        vertices: usize,
        values: &mut impl Values,
    ) -> Result<()> {
        self.uv_missing = true;
        let indices = element.indices(path)?;
        for j in 0..element.count {
            values.begin()?;
            for (at, property) in element.properties.iter().enumerate() {
                let Kind::List { count, item } = property.kind else {
                    skip_property(property, values)?;
                    continue;
                };
                if at != indices {
                    skip_property(property, values)?;
                    continue;
                }
                let mut strip = Vec::new();
                for _ in 0..list_length(values, count)? {
                    let k = values.integer(item)?;
                    if k == -1 {
                        self.add_strip(&strip);
                        strip.clear();
                    } else {
                        strip.push(vertex_index(k, vertices).map_err(wrong(values, "strip", j))?);
                    }
                }
                self.add_strip(&strip);
            }
            values.end()?;
        }
        Ok(())
    }

    fn add_strip(&mut self, strip: &[u32]) {
        let triangles = strip.windows(3).enumerate().map(|(i, w)| match i % 2 {
            0 => [w[0], w[1], w[2]],
            _ => [w[1], w[0], w[2]],
        });
        self.corners.extend(triangles.filter(|[a, b, c]| a != b && b != c && c != a));
    }
}

/// An index as it should be, or what is wrong with it.
fn vertex_index(k: i64, vertices: usize) -> std::result::Result<u32, String> {
    u32::try_from(k)
        .ok()
        .filter(|&k| (k as usize) < vertices)
        .ok_or_else(|| format!("refers to vertex {k}, but the file has {vertices}, counted from 0"))
}

/// Puts before a message which element it is about, and where.
fn wrong(values: &impl Values, what: &str, j: usize) -> impl Fn(String) -> Error {
    move |message| values.error(format!("{what} {j}: {message}"))
}
