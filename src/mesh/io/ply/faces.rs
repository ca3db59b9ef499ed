//! The faces of a PLY file: polygons and triangle strips, with their colors, texture coordinates and images.

use std::path::Path;

use nalgebra::Point3;

use super::header::{Element, Kind, Property};
use super::values::Values;
use super::{colors_of, list_length, skip_property, vertex_index, wrong};
use crate::error::Result;
use crate::mesh::io::colors::Colors;
use crate::mesh::io::occurrences::Occurrences;
use crate::mesh::io::polygon::Polygons;
use crate::mesh::io::{INVALID_TEXTURE, TOO_FEW_CORNERS, fan, valid_uv};

/// The contents of the elements `face` and `tristrips`. Vectors of optional values may be shorter than the faces.
#[derive(Default)]
pub struct Faces {
    /// The numbers of vertices and images.
    vertices: usize,
    textures: usize,
    pub corners: Vec<[u32; 3]>,
    polygons: Polygons,
    pub colors: Option<Colors>,
    pub uv: Option<Vec<[[f64; 2]; 3]>>,
    pub images: Option<Vec<Option<u32>>>,
    /// Faces of the file with too few corners, with texture coordinates that are not one pair per corner or are
    /// invalid, or with an image that does not exist.
    too_few: Occurrences,
    wrong_length: Occurrences,
    invalid_uv: Occurrences,
    no_image: Occurrences,
}

/// The values of one face.
#[derive(Default)]
struct Face {
    /// Its corners, before and after the check.
    list: Vec<i64>,
    polygon: Vec<u32>,
    texture: Vec<[f64; 2]>,
    /// Number of items of the list `texcoord`.
    texture_length: u64,
    color: [f64; 3],
    image: Option<u32>,
}

impl Face {
    fn clear(&mut self) {
        let Face { list, polygon, texture, texture_length, color, image } = self;
        list.clear();
        polygon.clear();
        texture.clear();
        (*texture_length, *color, *image) = (0, [0.0; 3], None);
    }
}

/// The meaning of a property of a face.
#[derive(Clone, Copy)]
enum Role {
    Corners,
    Texture,
    Image,
    Color(usize),
    Other,
}

impl Faces {
    pub fn new(vertices: usize, textures: usize) -> Self {
        Faces { vertices, textures, ..Faces::default() }
    }

    pub fn read(&mut self, path: &Path, element: &Element, values: &mut impl Values) -> Result<()> {
        let roles = self.roles(path, element)?;
        self.corners.reserve(values.capacity(element));
        let mut face = Face::default();
        for j in 0..element.count {
            values.begin()?;
            face.clear();
            for (property, &role) in element.properties.iter().zip(&roles) {
                self.read_property(j, property, role, values, &mut face)?;
            }
            self.add(j, &face);
        }
        self.uv = self.uv.take().filter(|uv| !uv.is_empty()).map(|mut uv| {
            uv.resize(self.corners.len(), [[f64::NAN; 2]; 3]);
            uv
        });
        Ok(())
    }

    /// The roles of the properties; reserves memory for their values.
    fn roles(&mut self, path: &Path, element: &Element) -> Result<Vec<Role>> {
        let mut roles = vec![Role::Other; element.properties.len()];
        self.colors = colors_of(element).map(|(indices, colors)| {
            for (c, at) in indices.into_iter().enumerate() {
                roles[at] = Role::Color(c);
            }
            colors
        });
        self.uv = element.any_list("texcoord").map(|at| {
            roles[at] = Role::Texture;
            Vec::new()
        });
        if self.textures > 0
            && let Some((at, _)) = element.any_scalar("texnumber")
        {
            roles[at] = Role::Image;
            self.images = Some(vec![None; self.corners.len()]);
        }
        roles[element.indices(path)?] = Role::Corners;
        Ok(roles)
    }

    #[inline(always)]
    fn read_property(
        &mut self,
        j: usize,
        property: &Property,
        role: Role,
        values: &mut impl Values,
        face: &mut Face,
    ) -> Result<()> {
        match (property.kind, role) {
            (Kind::List { count, item }, Role::Corners) => {
                let n = list_length(values, count)?;
                face.list.clear();
                values.integers(item, n, &mut face.list)?;
                for &k in &face.list {
                    let k = vertex_index(k, self.vertices);
                    face.polygon.push(k.map_err(wrong(values, "face", j))?);
                }
            }
            (Kind::List { count, item }, Role::Texture) => {
                let n = list_length(values, count)?;
                for _ in 0..n / 2 {
                    let t = [values.number_or_nan(item)?, values.number_or_nan(item)?];
                    let t = valid_uv(t, &mut self.invalid_uv, || format!("face {j}"));
                    face.texture.push(t);
                }
                values.skip(item, n % 2)?;
                face.texture_length = n;
            }
            (Kind::Scalar(scalar), Role::Image) => {
                let number = values.number_or_nan(scalar)?;
                let known = (0.0..self.textures as f64).contains(&number) && number.fract() == 0.0;
                face.image = known.then_some(number as u32);
                if !known {
                    self.no_image.add(|| format!("face {j}"));
                }
            }
            (Kind::Scalar(scalar), Role::Color(c)) => {
                face.color[c] = values.number_or_nan(scalar)?;
            }
            _ => skip_property(property, values)?,
        }
        Ok(())
    }

    /// Adds the triangles of a face, with its color, texture coordinates and image.
    #[inline(always)]
    fn add(&mut self, j: usize, face: &Face) {
        let n = face.polygon.len();
        if n < 3 {
            self.too_few.add(|| format!("face {j}"));
            return;
        }
        let first = self.corners.len();
        self.polygons.add(first, n);
        self.corners.extend(fan(&face.polygon));
        let triangles = first..self.corners.len();
        if let Some(uv) = &mut self.uv {
            if face.texture_length == 2 * n as u64 {
                uv.resize(first, [[f64::NAN; 2]; 3]);
                uv.extend(fan(&face.texture));
            } else if face.texture_length > 0 {
                self.wrong_length.add(|| format!("face {j}"));
            }
        }
        if let Some(colors) = &mut self.colors {
            triangles.for_each(|triangle| {
                colors.set(triangle, face.color, || format!("face {j}"));
            });
        }
        if let Some(images) = &mut self.images {
            images.resize(self.corners.len(), face.image);
        }
    }

    /// The triangles (a, b, c), (c, b, d), (c, d, e), ... of each strip a, b, c, d, e, ...
    pub fn read_strips(
        &mut self,
        path: &Path,
        element: &Element,
        values: &mut impl Values,
    ) -> Result<()> {
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
                        let k = vertex_index(k, self.vertices);
                        strip.push(k.map_err(wrong(values, "strip", j))?);
                    }
                }
                self.add_strip(&strip);
            }
        }
        if let Some(uv) = &mut self.uv {
            uv.resize(self.corners.len(), [[f64::NAN; 2]; 3]);
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

    /// Warns of what was left out, and triangulates the polygons inside themselves, now that the positions are known.
    pub fn finish(&mut self, path: &Path, vertices: &[Point3<f64>]) {
        self.too_few.warn(path, TOO_FEW_CORNERS);
        self.invalid_uv.warn(path, INVALID_TEXTURE);
        self.wrong_length.warn(
            path,
            "texture coordinates of faces whose texcoord does not have one pair per corner are unknown",
        );
        self.no_image.warn(path, "faces whose texnumber is not that of an image have no image");
        self.polygons.triangulate(path, vertices, &mut self.corners, self.uv.as_deref_mut());
    }
}
