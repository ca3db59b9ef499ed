//! The faces of a PLY file: polygons and triangle strips, with what they carry.

use std::path::Path;

use nalgebra::Point3;

use super::header::{Element, Kind};
use super::values::Values;
use super::{colors_of, list_length, skip_property, vertex_index, wrong};
use crate::error::Result;
use crate::mesh::io::colors::Colors;
use crate::mesh::io::places::Places;
use crate::mesh::io::polygon::Polygons;
use crate::mesh::io::{NO_NUMBERS, TOO_FEW_CORNERS, fan, place_in_image};

/// What the elements `face` and `tristrips` hold. What only some faces have may end early.
#[derive(Default)]
pub struct Faces {
    /// How many vertices and images there are.
    vertices: usize,
    textures: usize,
    pub corners: Vec<[u32; 3]>,
    polygons: Polygons,
    pub colors: Option<Colors>,
    pub uv: Option<Vec<[[f64; 2]; 3]>>,
    pub images: Option<Vec<Option<u32>>>,
    /// Of the faces as they are in the file: with too few corners, texture coordinates that are not a pair for each
    /// corner or no numbers, images that are not there.
    too_few: Places,
    odd: Places,
    no_numbers: Places,
    no_image: Places,
    /// The lists of the face that is being read.
    list: Vec<i64>,
    polygon: Vec<u32>,
    texture: Vec<[f64; 2]>,
}

/// What a property of a face is good for.
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
        let mut roles = vec![Role::Other; element.properties.len()];
        let mut colors = colors_of(element).map(|(places, colors)| {
            for (c, at) in places.into_iter().enumerate() {
                roles[at] = Role::Color(c);
            }
            colors
        });
        let mut uv = element.any_list("texcoord").map(|at| {
            roles[at] = Role::Texture;
            Vec::new()
        });
        let mut images = None;
        if self.textures > 0
            && let Some((at, _)) = element.any_scalar("texnumber")
        {
            roles[at] = Role::Image;
            images = Some(vec![None; self.corners.len()]);
        }
        roles[element.indices(path)?] = Role::Corners;

        self.corners.reserve(values.capacity(element));
        for j in 0..element.count {
            values.begin()?;
            self.polygon.clear();
            self.texture.clear();
            let mut color = [0.0; 3];
            let mut image = None;
            let mut given = 0;
            for (property, &role) in element.properties.iter().zip(&roles) {
                match (property.kind, role) {
                    (Kind::List { count, item }, Role::Corners) => {
                        let n = list_length(values, count)?;
                        self.list.clear();
                        values.integers(item, n, &mut self.list)?;
                        for &k in &self.list {
                            let k = vertex_index(k, self.vertices);
                            self.polygon.push(k.map_err(wrong(values, "face", j))?);
                        }
                    }
                    (Kind::List { count, item }, Role::Texture) => {
                        let n = list_length(values, count)?;
                        for _ in 0..n / 2 {
                            let t = [values.number_or_nan(item)?, values.number_or_nan(item)?];
                            let t = place_in_image(t, &mut self.no_numbers, || format!("face {j}"));
                            self.texture.push(t);
                        }
                        values.skip(item, n % 2)?;
                        given = n;
                    }
                    (Kind::Scalar(scalar), Role::Image) => {
                        let number = values.number_or_nan(scalar)?;
                        let known =
                            (0.0..self.textures as f64).contains(&number) && number.fract() == 0.0;
                        image = known.then_some(number as u32);
                        if image.is_none() {
                            self.no_image.add(|| format!("face {j}"));
                        }
                    }
                    (Kind::Scalar(scalar), Role::Color(c)) => {
                        color[c] = values.number_or_nan(scalar)?;
                    }
                    _ => skip_property(property, values)?,
                }
            }
            let n = self.polygon.len();
            if n < 3 {
                self.too_few.add(|| format!("face {j}"));
                continue;
            }
            let first = self.corners.len();
            self.polygons.add(first, n);
            self.corners.extend(fan(&self.polygon));
            let triangles = first..self.corners.len();
            if let Some(uv) = &mut uv {
                if given == 2 * n as u64 {
                    uv.resize(first, [[f64::NAN; 2]; 3]);
                    uv.extend(fan(&self.texture));
                } else if given > 0 {
                    self.odd.add(|| format!("face {j}"));
                }
            }
            if let Some(colors) = &mut colors {
                triangles.for_each(|triangle| {
                    colors.set(triangle, color, || format!("face {j}"));
                });
            }
            if let Some(images) = &mut images {
                images.resize(self.corners.len(), image);
            }
        }
        self.uv = uv.filter(|uv| !uv.is_empty()).map(|mut uv| {
            uv.resize(self.corners.len(), [[f64::NAN; 2]; 3]);
            uv
        });
        self.colors = colors;
        self.images = images;
        Ok(())
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

    /// What was left out, and polygons cut inside themselves, now that the positions are known.
    pub fn finish(&mut self, path: &Path, vertices: &[Point3<f64>]) {
        self.too_few.warn(path, TOO_FEW_CORNERS);
        self.no_numbers.warn(path, NO_NUMBERS);
        self.odd.warn(
            path,
            "faces whose texcoord is not a pair for each corner have unknown texture coordinates",
        );
        self.no_image.warn(path, "faces whose texnumber is none of the images have none");
        self.polygons.triangulate(path, vertices, &mut self.corners, self.uv.as_deref_mut());
    }
}
