//! Flips of edges towards regular valences.
//!
//! ```text
//!        c                c
//!      /   \            / | \        sum over a, b, c, d of (valence - target)^2,
//!    a ----- b   ->    a  |  b       target 6, or 4 at a border
//!      \   /            \ | /
//!        d                d
//! ```

use std::collections::HashMap;

use nalgebra::Point3;

use super::quality::{normal, quality, within};
use super::remeshed::Remeshed;
use crate::mesh::Mesh;
use crate::mesh::sides::{edges, sides};

/// A flip leaves no face below this quality, unless one was worse before.
const LOWEST_QUALITY: f64 = 0.3;

/// Two directed edges with the same ends and direction: the surface is not an oriented manifold there.
const NOT_MANIFOLD: u32 = u32::MAX;

/// Flips edges as long as that lowers the squared deviation of the valences. An edge is flipped only if both new faces
/// are within `max_angle` radians of both old ones, so that none turns over, and are not badly shaped. The vertices keep
/// their indices and places.
pub fn flip(mesh: &Mesh, max_angle: f64) -> Remeshed {
    let mut flips = Flips::new(mesh, max_angle.cos());
    loop {
        let sides = sides(&flips.faces);
        let flipped = edges(&sides).filter(|edge| {
            let [a, b] = edge[0].edge;
            flips.flip(a, b)
        });
        // Each flip lowers the deviation, which is an integer.
        if flipped.count() == 0 {
            break;
        }
    }
    Remeshed::of_faces(mesh.vertices.clone(), flips.faces)
}

/// The faces, and what must be known of them.
struct Flips<'a> {
    vertices: &'a [Point3<f64>],
    cosine: f64,
    faces: Vec<[u32; 3]>,
    /// The face that traverses an edge in this direction.
    face_at: HashMap<[u32; 2], u32>,
    /// Valence minus target of each vertex.
    excess: Vec<i32>,
}

impl<'a> Flips<'a> {
    fn new(mesh: &'a Mesh, cosine: f64) -> Self {
        let mut face_at = HashMap::with_capacity(3 * mesh.faces.len());
        for (j, &[a, b, c]) in (0..).zip(&mesh.faces) {
            for side in [[a, b], [b, c], [c, a]] {
                face_at.entry(side).and_modify(|face| *face = NOT_MANIFOLD).or_insert(j);
            }
        }
        let mut excess = vec![-6; mesh.vertices.len()];
        let mut border = vec![false; mesh.vertices.len()];
        for edge in edges(&sides(&mesh.faces)) {
            for k in edge[0].edge {
                excess[k as usize] += 1;
                border[k as usize] |= edge.len() == 1;
            }
        }
        excess.iter_mut().zip(border).for_each(|(excess, border)| *excess += 2 * i32::from(border));
        Flips { vertices: &mesh.vertices, cosine, faces: mesh.faces.clone(), face_at, excess }
    }

    /// The faces at an edge and their other corners, if there are exactly two that agree in orientation.
    fn around(&self, a: u32, b: u32) -> Option<[(u32, u32); 2]> {
        let at = |a: u32, b: u32| {
            let j = *self.face_at.get(&[a, b]).filter(|&&j| j != NOT_MANIFOLD)?;
            let corner = self.faces[j as usize].into_iter().find(|&k| k != a && k != b)?;
            Some((j, corner))
        };
        Some([at(a, b)?, at(b, a)?])
    }

    /// Flips the edge ab if it is still there and that is allowed and an improvement.
    fn flip(&mut self, a: u32, b: u32) -> bool {
        let Some([(f, c), (g, d)]) = self.around(a, b) else { return false };
        let is_edge = |from: u32, to: u32| self.face_at.contains_key(&[from, to]);
        if c == d || is_edge(c, d) || is_edge(d, c) {
            return false;
        }
        let after = [(a, -1), (b, -1), (c, 1), (d, 1)];
        let squares = |with: i32| -> i32 {
            after.iter().map(|&(k, change)| (self.excess[k as usize] + with * change).pow(2)).sum()
        };
        let new = [[d, b, c], [c, a, d]];
        if squares(1) >= squares(0) || !self.is_possible([[a, b, c], [b, a, d]], new) {
            return false;
        }
        for (k, change) in after {
            self.excess[k as usize] += change;
        }
        self.face_at.remove(&[a, b]);
        self.face_at.remove(&[b, a]);
        for (j, face) in [f, g].into_iter().zip(new) {
            let [x, y, z] = face;
            self.faces[j as usize] = face;
            for side in [[x, y], [y, z], [z, x]] {
                self.face_at.insert(side, j);
            }
        }
        true
    }

    fn is_possible(&self, old: [[u32; 3]; 2], new: [[u32; 3]; 2]) -> bool {
        let corners = |face: [u32; 3]| face.map(|k| self.vertices[k as usize]);
        let (old, new) = (old.map(corners), new.map(corners));
        let worst = |faces: [_; 2]| faces.into_iter().map(quality).fold(f64::INFINITY, f64::min);
        let normals = old.map(normal);
        worst(new) >= worst(old).min(LOWEST_QUALITY)
            && new
                .iter()
                .all(|face| normals.iter().all(|old| within(&normal(*face), old, self.cosine)))
    }
}
