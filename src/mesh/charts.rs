//! Texture coordinates of the generated shapes, and angles around an axis, for every corner of a face.
//!
//! | shape | u | v |
//! |---|---|---|
//! | torus | angle / 2 pi around the axis | 1/2 + angle / 2 pi around the tube: the outer equator has v = 1/2 |
//! | sphere, ellipsoid, peanut, dent | 1/2 + longitude / 2 pi | 1/2 + latitude / pi |
//! | grid | i / max(nx, ny) | j / max(nx, ny): squares stay squares |
//! | jaw, city | i / nx | j / ny |
//!
//! Coordinates belong to corners of faces, so those of a face at a seam continue beyond 1 instead of running back.

use std::f64::consts::{PI, TAU};

use super::{Mesh, Shape};
use crate::sweep;

impl Shape {
    /// The shape with its texture coordinates.
    pub fn textured(self) -> Mesh {
        let mut mesh = self.mesh();
        mesh.uv = Some(self.uv(&mesh));
        mesh
    }

    /// The texture coordinates of its mesh, which may have been scaled: F triples, one pair per corner.
    pub fn uv(self, mesh: &Mesh) -> Vec<[[f64; 2]; 3]> {
        assert_eq!(self.faces(), mesh.faces.len() as u64);
        let ratio = |i: u32, n: u32| f64::from(i) / f64::from(n);
        sweep::collect(mesh.faces.len(), |face| match self {
            Shape::Torus { nu, nv } => {
                let cell = (face / 2) as u32;
                let (i, j) = (cell / nv, cell % nv);
                let half = if 2 * j < nv { 0.5 } else { -0.5 };
                corners_of_cell(face).map(|[di, dj]| [ratio(i + di, nu), ratio(j + dj, nv) + half])
            }
            Shape::Grid { nx, ny } => {
                let cell = (face / 2) as u32;
                let (i, j) = (cell % nx, cell / nx);
                let n = nx.max(ny);
                corners_of_cell(face).map(|[di, dj]| [ratio(i + di, n), ratio(j + dj, n)])
            }
            Shape::Jaw { nu: nx, nv: ny } | Shape::City { nx, ny } => {
                let cell = (face / 2) as u32;
                let (i, j) = (cell % nx, cell / nx);
                corners_of_cell(face).map(|[di, dj]| [ratio(i + di, nx), ratio(j + dj, ny)])
            }
            Shape::Sphere { .. } | Shape::Star { .. } => {
                let corners = mesh.corners(face).map(|x| [x.x, x.y, x.z]);
                let turns = around(corners.map(|[x, y, _]| [x, y]));
                std::array::from_fn(|i| [turns[i], latitude(corners[i])])
            }
        })
    }
}

/// The corners of the two faces of a square cell, cut along the diagonal from (0, 0).
fn corners_of_cell(face: usize) -> [[u32; 2]; 3] {
    if face.is_multiple_of(2) { [[0, 0], [1, 0], [1, 1]] } else { [[0, 0], [1, 1], [0, 1]] }
}

/// 1/2 + angle / 2 pi around the origin for each corner of a face, at most half a turn from the first. A corner on the
/// axis has no angle and takes the mean of the others.
pub fn around(corners: [[f64; 2]; 3]) -> [f64; 3] {
    let size = corners.as_flattened().iter().fold(0.0, |size, x| f64::max(size, x.abs()));
    let angle = |[x, y]: [f64; 2]| (x.hypot(y) > 1e-12 * size).then(|| 0.5 + y.atan2(x) / TAU);
    let angles = corners.map(angle);
    let Some(first) = angles.iter().flatten().next().copied() else { return [0.5; 3] };
    let turns = angles.map(|angle| angle.map(|angle| angle - (angle - first).round()));
    let known = turns.iter().flatten();
    let mean = known.clone().sum::<f64>() / known.count() as f64;
    turns.map(|turn| turn.unwrap_or(mean))
}

/// 1/2 + latitude / pi of a point seen from the origin.
pub fn latitude([x, y, z]: [f64; 3]) -> f64 {
    0.5 + z.atan2(x.hypot(y)) / PI
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    fn shapes() -> [Shape; 8] {
        [
            "torus:12x8",
            "torus:5x7",
            "sphere:3",
            "peanut:3",
            "grid:6x4",
            "grid:2x5",
            "jaw:28x9",
            "city:9x8",
        ]
        .map(|s| s.parse().unwrap())
    }

    /// No face runs back over the image at a seam, and corners at one vertex differ by whole tiles.
    #[test]
    fn coordinates_are_continuous_up_to_whole_turns() {
        for shape in shapes() {
            let mesh = shape.textured();
            let uv = mesh.uv.as_ref().unwrap();
            let mut of_vertex = vec![None; mesh.vertices.len()];
            for (face, uv) in mesh.faces.iter().zip(uv) {
                let pole = face.iter().any(|&k| {
                    let x = mesh.vertices[k as usize];
                    x.x.hypot(x.y) < 1e-12
                });
                for axis in [0, 1] {
                    let [a, b, c] = [0, 1, 2].map(|i| uv[i][axis]);
                    assert!(a.max(b).max(c) - a.min(b).min(c) <= 0.51, "{shape}: {uv:?}");
                }
                if pole {
                    continue;
                }
                for (&k, t) in face.iter().zip(uv) {
                    let first: &mut [f64; 2] = of_vertex[k as usize].get_or_insert(*t);
                    for axis in [0, 1] {
                        let d = t[axis] - first[axis];
                        assert!((d - d.round()).abs() < 1e-12, "{shape}: {first:?} and {t:?}");
                    }
                }
            }
        }
    }

    /// The coordinates determine the position of a vertex.
    #[test]
    fn coordinates_determine_the_positions() {
        for shape in shapes() {
            let mesh = shape.textured();
            for (face, uv) in mesh.faces.iter().zip(mesh.uv.as_ref().unwrap()) {
                for (&k, &[u, v]) in face.iter().zip(uv) {
                    let x = mesh.vertices[k as usize];
                    let (sin_u, cos_u) = (TAU * u).sin_cos();
                    let expected = match shape {
                        Shape::Torus { .. } => {
                            let c = mesh.vertices[0].x / 1.4;
                            let (sin_v, cos_v) = (TAU * (v - 0.5)).sin_cos();
                            let distance = 1.0 + 0.4 * cos_v;
                            [distance * cos_u * c, distance * sin_u * c, 0.4 * sin_v * c]
                        }
                        Shape::Sphere { .. } | Shape::Star { .. } => {
                            let (sin_v, cos_v) = (PI * (v - 0.5)).sin_cos();
                            let d = Vector3::new(-cos_v * cos_u, -cos_v * sin_u, sin_v);
                            let kind = if let Shape::Star { kind, .. } = shape {
                                Some(kind)
                            } else {
                                None
                            };
                            kind.map_or(d.into(), |kind| kind.point(d).into())
                        }
                        Shape::Grid { nx, ny } => {
                            let c = f64::from(nx.max(ny)) / f64::from(nx);
                            [u * c, v * c, 0.0]
                        }
                        Shape::Jaw { nu: nx, nv: ny } | Shape::City { nx, ny } => {
                            let [i, j] = [u * f64::from(nx), v * f64::from(ny)].map(f64::round);
                            let k = j as usize * (nx as usize + 1) + i as usize;
                            mesh.vertices[k].into()
                        }
                    };
                    for (a, b) in expected.iter().zip(x.iter()) {
                        assert!((a - b).abs() < 1e-12, "{shape}: {expected:?} and {x}");
                    }
                }
            }
        }
    }

    #[test]
    fn corners_on_the_axis_take_the_mean_angle() {
        assert_eq!(around([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), [0.625, 0.5, 0.75]);
        assert_eq!(around([[0.0; 2]; 3]), [0.5; 3]);
        assert_eq!(latitude([0.0, 0.0, -2.0]), 0.0);
        assert_eq!(latitude([0.0; 3]), 0.5);
    }
}
