//! Generated surfaces with known geometry: torus, sphere, grid, closed surfaces around the origin, and two with known
//! parts.
//!
//! | shape | V | F | Euler characteristic | area | Gaussian curvature |
//! |---|---|---|---|---|---|
//! | `torus:NUxNV` | nu nv | 2 nu nv | 0 | 1, exactly that of the mesh | cos v / (r (R + r cos v)) before scaling |
//! | `sphere:LEVEL` | 10 4^level + 2 | 20 4^level | 2 | 4 pi - O(4^-level) | 1 |
//! | `ellipsoid:LEVEL`, `peanut:LEVEL`, `dent:LEVEL` | as a sphere | as a sphere | 2 | see `shapes/star.rs` | |
//! | `grid:NXxNY` | (nx + 1)(ny + 1) | 2 nx ny | 1 | ny / nx | 0 |
//! | `jaw:NUxNV`, `city:NXxNY` | as a grid | as a grid | 1 | see `shapes/jaw.rs`, `shapes/city.rs` | |

mod city;
mod jaw;
mod star;

use std::f64::consts::TAU;
use std::fmt;
use std::str::FromStr;

use nalgebra::Point3;

use super::Mesh;
use crate::error::{Error, Result};

pub use star::Star;

/// Shapes with more faces than this are refused.
pub const MAX_FACES: u64 = 50_000_000;

/// The finest sphere, of 20,971,520 faces.
const MAX_SPHERE_LEVEL: u32 = 10;

/// A generated surface. Its text form is the one of the command line, such as `torus:400x250`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// With R = 1, r = 0.4 and u = 2 pi i / nu, v = 2 pi j / nv, the point
    /// ((R + r cos v) cos u, (R + r cos v) sin u, r sin v) is vertex i nv + j; then scaled to area 1.
    ///
    /// The smooth torus has area 4 pi^2 R r, total Gaussian curvature 0, and mean curvature
    /// (R + 2 r cos v) / (2 r (R + r cos v)), all before scaling. Normals point outwards.
    Torus {
        /// Vertices along u, around the axis; 3 or more.
        nu: u32,
        /// Vertices along v, around the tube; 3 or more.
        nv: u32,
    },
    /// The unit icosahedron, subdivided `level` times at its midpoints, which are moved to the unit sphere.
    ///
    /// All normals point outwards; the principal curvatures are 1.
    Sphere {
        /// How often the icosahedron is subdivided, 0 to 10.
        level: u32,
    },
    /// The same sphere with its vertices moved along their directions.
    ///
    /// Normals point outwards.
    Star {
        /// The surface.
        kind: Star,
        /// How often the icosahedron is subdivided, 0 to 10.
        level: u32,
    },
    /// nx x ny square cells of side 1/nx on [0, 1] x [0, ny/nx] in the plane z = 0, each cut along its diagonal
    /// from the lower left; vertex (i, j) has index j (nx + 1) + i.
    ///
    /// The boundary is one loop of 2 (nx + ny) edges; normals point along +z.
    Grid {
        /// Cells along x; 1 or more.
        nx: u32,
        /// Cells along y; 1 or more.
        ny: u32,
    },
    /// Fourteen teeth in an arch of gums, 15 parts; a grid of nu x nv cells on [0, 1] x [0, 1], as the next one.
    ///
    /// Normals point outwards.
    Jaw {
        /// Cells along the arch; 1 or more.
        nu: u32,
        /// Cells across it; 1 or more.
        nv: u32,
    },
    /// Blocks of a city, 12 parts.
    ///
    /// Normals point upwards.
    City {
        /// Cells along x; 1 or more.
        nx: u32,
        /// Cells along y; 1 or more.
        ny: u32,
    },
}

impl Shape {
    /// The words before the colon of what [`Shape::from_str`] takes.
    pub const NAMES: [&str; 8] =
        ["torus", "sphere", "ellipsoid", "peanut", "dent", "grid", "jaw", "city"];

    /// The forms that [`Shape::from_str`] takes.
    pub const SYNTAX: &str = "torus:400x250, sphere:6, ellipsoid:6, peanut:6, dent:6, grid:100x100, jaw:700x120 or city:300x300";

    /// The mesh of the shape, without colors and texture coordinates.
    pub fn mesh(self) -> Mesh {
        match self {
            Shape::Torus { nu, nv } => torus(nu, nv),
            Shape::Sphere { level } => sphere(level),
            Shape::Star { kind, level } => {
                let mut mesh = sphere(level);
                mesh.vertices.iter_mut().for_each(|x| *x = kind.point(x.coords));
                mesh
            }
            Shape::Grid { nx, ny } => grid(nx, ny),
            Shape::Jaw { nu, nv } => over_square(nu, nv, jaw::point),
            Shape::City { nx, ny } => over_square(nx, ny, city::point),
        }
    }

    /// The number of its known parts, if it has some.
    pub fn parts(self) -> Option<usize> {
        match self {
            Shape::Jaw { .. } => Some(jaw::PARTS),
            Shape::City { .. } => Some(city::PARTS),
            _ => None,
        }
    }

    /// The part that each face belongs to, that of its centroid in the square it is drawn on; if it has known parts.
    pub fn part_of_faces(self) -> Option<Vec<usize>> {
        let (nx, ny, part): (_, _, fn(f64, f64) -> usize) = match self {
            Shape::Jaw { nu, nv } => (nu, nv, jaw::part),
            Shape::City { nx, ny } => (nx, ny, city::part),
            _ => return None,
        };
        let flat = over_square(nx, ny, |x, y| Point3::new(x, y, 0.0));
        let part = |j: usize| {
            let [a, b, c] = flat.corners(j).map(|x| x.coords);
            let centroid = (a + b + c) / 3.0;
            part(centroid.x, centroid.y)
        };
        Some((0..flat.faces.len()).map(part).collect())
    }

    /// F.
    pub fn faces(self) -> u64 {
        match self {
            Shape::Torus { nu: a, nv: b }
            | Shape::Grid { nx: a, ny: b }
            | Shape::Jaw { nu: a, nv: b }
            | Shape::City { nx: a, ny: b } => {
                u64::from(a).saturating_mul(b.into()).saturating_mul(2)
            }
            Shape::Sphere { level } | Shape::Star { level, .. } => 20 << (2 * level),
        }
    }
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Shape::Torus { nu, nv } => write!(f, "torus:{nu}x{nv}"),
            Shape::Sphere { level } => write!(f, "sphere:{level}"),
            Shape::Star { kind, level } => write!(f, "{}:{level}", <&str>::from(kind)),
            Shape::Grid { nx, ny } => write!(f, "grid:{nx}x{ny}"),
            Shape::Jaw { nu, nv } => write!(f, "jaw:{nu}x{nv}"),
            Shape::City { nx, ny } => write!(f, "city:{nx}x{ny}"),
        }
    }
}

impl FromStr for Shape {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let refuse =
            |why: String| Err(Error::unsuitable(format!("{}: {why}", text.escape_debug())));
        let (name, size) = text.split_once(':').unwrap_or((text, ""));
        let pair = || {
            let (a, b) = size.split_once('x')?;
            Some((number(a)?, number(b)?))
        };
        let shape = match name {
            "torus" => match pair() {
                Some((nu @ 3.., nv @ 3..)) => Shape::Torus { nu, nv },
                Some(_) => return refuse("a torus needs at least 3x3 vertices".into()),
                None => return refuse("write a torus as torus:400x250".into()),
            },
            "sphere" | "ellipsoid" | "peanut" | "dent" => match number(size) {
                Some(level @ ..=MAX_SPHERE_LEVEL) => {
                    name.parse().map_or(Shape::Sphere { level }, |kind| Shape::Star { kind, level })
                }
                Some(_) => {
                    return refuse(format!(
                        "the level of a {name} must be 0 to {MAX_SPHERE_LEVEL}"
                    ));
                }
                None => return refuse(format!("write a {name} with its level as {name}:6")),
            },
            "grid" | "jaw" | "city" => match pair() {
                Some((nu @ 1.., nv @ 1..)) if name == "jaw" => Shape::Jaw { nu, nv },
                Some((nx @ 1.., ny @ 1..)) if name == "city" => Shape::City { nx, ny },
                Some((nx @ 1.., ny @ 1..)) => Shape::Grid { nx, ny },
                Some(_) => return refuse(format!("a {name} needs at least 1x1 cells")),
                None => return refuse(format!("write a {name} with its cells as {name}:100x100")),
            },
            _ => return refuse(format!("is not a shape; use one like {}", Shape::SYNTAX)),
        };
        if shape.faces() > MAX_FACES {
            return refuse(format!("would have too many faces; at most {MAX_FACES} are possible"));
        }
        Ok(shape)
    }
}

/// Parses digits only; a number that does not fit is too large in any case.
fn number(text: &str) -> Option<u32> {
    if text.is_empty() || !text.bytes().all(|b| b.is_ascii_digit()) {
        return None;
    }
    Some(text.parse().unwrap_or(u32::MAX))
}

fn torus(nu: u32, nv: u32) -> Mesh {
    const MAJOR_RADIUS: f64 = 1.0;
    const MINOR_RADIUS: f64 = 0.4;
    let index = |i: u32, j: u32| (i % nu) * nv + j % nv;
    let mut vertices = Vec::with_capacity(nu as usize * nv as usize);
    let mut faces = Vec::with_capacity(2 * vertices.capacity());
    for i in 0..nu {
        let (sin_u, cos_u) = (TAU * f64::from(i) / f64::from(nu)).sin_cos();
        for j in 0..nv {
            let (sin_v, cos_v) = (TAU * f64::from(j) / f64::from(nv)).sin_cos();
            let distance = MAJOR_RADIUS + MINOR_RADIUS * cos_v;
            vertices.push(Point3::new(distance * cos_u, distance * sin_u, MINOR_RADIUS * sin_v));
            let (a, b) = (index(i, j), index(i + 1, j + 1));
            faces.push([a, index(i + 1, j), b]);
            faces.push([a, b, index(i, j + 1)]);
        }
    }
    let mesh = Mesh::new(vertices, faces);
    let c = mesh.area().sqrt().recip();
    mesh.scaled(c)
}

fn sphere(level: u32) -> Mesh {
    let project = |mut mesh: Mesh| {
        for x in &mut mesh.vertices {
            x.coords.normalize_mut();
        }
        mesh
    };
    (0..level).fold(project(icosahedron()), |mesh, _| project(mesh.subdivided()))
}

/// The cyclic permutations of (0, +-1, +-phi), with outward normals.
fn icosahedron() -> Mesh {
    let phi = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut vertices = Vec::with_capacity(12);
    for (a, b) in [(-1.0, phi), (1.0, phi), (-1.0, -phi), (1.0, -phi)] {
        vertices.push(Point3::new(a, b, 0.0));
    }
    for (a, b) in [(-1.0, phi), (1.0, phi), (-1.0, -phi), (1.0, -phi)] {
        vertices.push(Point3::new(0.0, a, b));
    }
    for (a, b) in [(-1.0, phi), (1.0, phi), (-1.0, -phi), (1.0, -phi)] {
        vertices.push(Point3::new(b, 0.0, a));
    }
    let faces = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    Mesh::new(vertices, faces)
}

fn grid(nx: u32, ny: u32) -> Mesh {
    let scaled = |i: u32| f64::from(i) / f64::from(nx);
    let index = |i: u32, j: u32| j * (nx + 1) + i;
    let mut vertices = Vec::new();
    for j in 0..=ny {
        for i in 0..=nx {
            vertices.push(Point3::new(scaled(i), scaled(j), 0.0));
        }
    }
    let mut faces = Vec::with_capacity(2 * nx as usize * ny as usize);
    for j in 0..ny {
        for i in 0..nx {
            let (a, c) = (index(i, j), index(i + 1, j + 1));
            faces.push([a, index(i + 1, j), c]);
            faces.push([a, c, index(i, j + 1)]);
        }
    }
    Mesh::new(vertices, faces)
}

/// A grid of nx x ny cells drawn on the unit square, with its vertices moved to where a map takes them.
fn over_square(nx: u32, ny: u32, x: impl Fn(f64, f64) -> Point3<f64>) -> Mesh {
    let mut mesh = grid(nx, ny);
    for (k, vertex) in mesh.vertices.iter_mut().enumerate() {
        let (i, j) = (k as u32 % (nx + 1), k as u32 / (nx + 1));
        *vertex = x(f64::from(i) / f64::from(nx), f64::from(j) / f64::from(ny));
    }
    mesh
}

#[cfg(test)]
mod tests;
