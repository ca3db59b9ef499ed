//! The surface on which a function changes its sign, from its values on a grid, by marching tetrahedra.
//!
//! ```text
//! a cell with corners 0 .. 7 (bit i: along axis i) = the tetrahedra 0, e_a, e_a + e_b, 7 for the six orders a, b, c
//! an edge from v_0 > 0 to v_1 <= 0 has the vertex x_0 + t (x_1 - x_0),  t = v_0 / (v_0 - v_1)
//! ```
//!
//! Neighboring cells agree on the diagonals of their common side, and a tetrahedron leaves no choice, so that the surface
//! is a closed manifold if the values at the border of the grid are not positive. (Marching cubes have ambiguous cells,
//! whose tables make edges of four faces.)
//!
//! Reference: A. Doi, A. Koide, *An efficient method of triangulating equi-valued surfaces by using tetrahedral cells*,
//! IEICE Transactions E74(1), 1991.

use std::collections::HashMap;

use nalgebra::{Point3, Vector3};

use crate::mesh::Mesh;

/// Vertices stay this far, in lengths of their edge, from its ends: faces may be thin, but have an area.
const MARGIN: f64 = 0.02;

/// A grid of points.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// The first point.
    pub origin: Point3<f64>,
    /// The distance between neighbors.
    pub step: f64,
    /// Points along x, y and z.
    pub size: [usize; 3],
}

impl Grid {
    /// The number of points.
    pub fn len(&self) -> usize {
        self.size.iter().product()
    }

    /// The coordinates of a point, numbered along x first, then y, then z.
    pub fn coordinates(&self, i: usize) -> [usize; 3] {
        let [nx, ny, _] = self.size;
        [i % nx, i / nx % ny, i / (nx * ny)]
    }

    /// The position of a point.
    pub fn point(&self, i: usize) -> Point3<f64> {
        let [x, y, z] = self.coordinates(i).map(|c| c as f64);
        self.origin + self.step * Vector3::new(x, y, z)
    }

    /// Whether a point is at the border.
    pub fn is_border(&self, i: usize) -> bool {
        self.coordinates(i).iter().zip(self.size).any(|(&c, n)| c == 0 || c + 1 == n)
    }
}

/// The orders of the axes, and whether each is even: then the tetrahedron has a positive volume.
const ORDERS: [([usize; 3], bool); 6] = [
    ([0, 1, 2], true),
    ([1, 2, 0], true),
    ([2, 0, 1], true),
    ([0, 2, 1], false),
    ([2, 1, 0], false),
    ([1, 0, 2], false),
];

/// The surface between positive values, which are inside, and others. Normals point outwards.
pub fn surface(grid: &Grid, values: &[f64]) -> Mesh {
    assert_eq!(values.len(), grid.len());
    let steps = [1, grid.size[0], grid.size[0] * grid.size[1]];
    let mut found =
        Surface { grid, values, vertices: Vec::new(), index: HashMap::new(), faces: Vec::new() };
    for first in 0..grid.len() {
        if grid.coordinates(first).iter().zip(grid.size).any(|(&c, n)| c + 1 == n) {
            continue;
        }
        let corner =
            |bits: usize| first + (0..3).map(|i| (bits >> i & 1) * steps[i]).sum::<usize>();
        let inside = (0..8).filter(|&bits| values[corner(bits)] > 0.0).count();
        if inside == 0 || inside == 8 {
            continue;
        }
        for ([a, b, _], is_even) in ORDERS {
            let corners = [0, 1 << a, 1 << a | 1 << b, 7].map(corner);
            let [p, q, r, s] = corners;
            found.tetrahedron(if is_even { corners } else { [p, q, s, r] });
        }
    }
    Mesh::new(found.vertices, found.faces)
}

struct Surface<'a> {
    grid: &'a Grid,
    values: &'a [f64],
    vertices: Vec<Point3<f64>>,
    /// The vertex on an edge from a point inside to one outside.
    index: HashMap<[usize; 2], u32>,
    faces: Vec<[u32; 3]>,
}

/// The even permutations that begin with each corner.
const FROM: [[usize; 4]; 4] = [[0, 1, 2, 3], [1, 0, 3, 2], [2, 0, 1, 3], [3, 0, 2, 1]];

/// The even permutations that begin with each pair of corners.
const FROM_TWO: [[usize; 4]; 6] =
    [[0, 1, 2, 3], [0, 2, 3, 1], [0, 3, 1, 2], [1, 2, 0, 3], [1, 3, 2, 0], [2, 3, 0, 1]];

impl Surface<'_> {
    /// The surface in a tetrahedron of positive volume.
    fn tetrahedron(&mut self, corners: [usize; 4]) {
        let inside = corners.map(|k| self.values[k] > 0.0);
        match inside.iter().filter(|&&inside| inside).count() {
            1 => {
                let order = FROM.into_iter().find(|order| inside[order[0]]).expect("one is inside");
                let [a, b, c, d] = order.map(|i| corners[i]);
                let face = [(a, b), (a, c), (a, d)].map(|(a, b)| self.vertex(a, b));
                self.faces.push(face);
            }
            3 => {
                let order =
                    FROM.into_iter().find(|order| !inside[order[0]]).expect("one is outside");
                let [a, b, c, d] = order.map(|i| corners[i]);
                let face = [(b, a), (d, a), (c, a)].map(|(a, b)| self.vertex(a, b));
                self.faces.push(face);
            }
            2 => {
                let both = |order: &[usize; 4]| inside[order[0]] && inside[order[1]];
                let order = FROM_TWO.into_iter().find(both).expect("two are inside");
                let [a, b, c, d] = order.map(|i| corners[i]);
                let [p, q, r, s] = [(a, c), (a, d), (b, d), (b, c)].map(|(a, b)| self.vertex(a, b));
                let x = [p, q, r, s].map(|k| self.vertices[k as usize]);
                // The shorter diagonal.
                if (x[0] - x[2]).norm_squared() <= (x[1] - x[3]).norm_squared() {
                    self.faces.extend([[p, q, r], [p, r, s]]);
                } else {
                    self.faces.extend([[p, q, s], [q, r, s]]);
                }
            }
            _ => {}
        }
    }

    /// The vertex between a point inside and one outside.
    fn vertex(&mut self, inside: usize, outside: usize) -> u32 {
        *self.index.entry([inside, outside]).or_insert_with(|| {
            let (a, b) = (self.values[inside], self.values[outside]);
            let t = (a / (a - b)).clamp(MARGIN, 1.0 - MARGIN);
            let (x, y) = (self.grid.point(inside), self.grid.point(outside));
            self.vertices.push(x + t * (y - x));
            self.vertices.len() as u32 - 1
        })
    }
}
