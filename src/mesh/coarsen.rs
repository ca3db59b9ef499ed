//! A coarser mesh of the same surface, and the interpolation P from its vertices to the fine ones.
//!
//! The coarse vertices are a maximal independent set of the fine ones: no two are neighbors, and every other vertex has
//! one of them as a neighbor, so that about a quarter remains. Each other vertex joins its nearest coarse neighbor; a
//! face whose corners have joined three different coarse vertices becomes a face between these. The surface may be
//! anything: faces that fold or collapse reduce the quality, not the validity.

use nalgebra::Point3;

use super::Mesh;
use super::triangle::nearest_weights;
use crate::sweep::sweep;

/// A coarse mesh, and P.
pub struct Coarsening {
    /// Its vertices are a subset of the fine ones; no face is degenerate, and no two have the same corners.
    pub mesh: Mesh,
    /// The rows of P, one per fine vertex.
    pub parents: Vec<Parents>,
}

/// One row of P: the coarse vertices between which a fine one is interpolated.
#[derive(Clone, Copy, Debug)]
pub struct Parents {
    /// The vertices of a coarse face; three times the same vertex if the fine one coincides with it.
    pub corners: [u32; 3],
    /// Nonnegative, with sum 1.
    pub weights: [f64; 3],
}

impl Parents {
    fn one(c: u32) -> Self {
        Parents { corners: [c; 3], weights: [1.0, 0.0, 0.0] }
    }
}

impl Coarsening {
    /// P^T w, one weight per coarse vertex, from one weight per fine vertex; only vertices v with `counts(v)`
    /// contribute.
    pub fn restricted(&self, weights: &[f64], counts: impl Fn(usize) -> bool) -> Vec<f64> {
        let mut coarse = vec![0.0; self.mesh.vertices.len()];
        for (v, parents) in self.parents.iter().enumerate().filter(|&(v, _)| counts(v)) {
            for (&c, share) in parents.corners.iter().zip(parents.weights) {
                coarse[c as usize] += share * weights[v];
            }
        }
        coarse
    }
}

/// At most this many faces around a coarse vertex are searched for the nearest point; a hub may have any number.
const MAX_FACES_SEARCHED: usize = 32;

impl Mesh {
    /// P interpolates linearly at the point nearest to the fine vertex on the coarse faces around the coarse vertex
    /// that it joined.
    pub fn coarsened(&self) -> Coarsening {
        let around = Incidence::new(self);
        let (chosen, number) = independent_set(self, &around);

        let mut joined = vec![0; self.vertices.len()];
        sweep(&mut joined[..], |v, joined| {
            *joined = number[self.nearest_chosen(v, &around, &number)]
        });

        let mut faces: Vec<[u32; 3]> = (self.faces.iter())
            .map(|face| face.map(|v| joined[v as usize]))
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .map(|mut face| {
                face.sort_unstable();
                face
            })
            .collect();
        faces.sort_unstable();
        faces.dedup();
        let vertices = chosen.iter().map(|&v| self.vertices[v as usize]).collect();
        let mesh = Mesh::new(vertices, faces).without_degenerate_faces().0.into_owned();

        let around = Incidence::new(&mesh);
        let mut parents = vec![Parents::one(0); self.vertices.len()];
        sweep(&mut parents[..], |v, parents| {
            *parents = if number[v] == NOT_CHOSEN {
                mesh.nearest_point(self.vertices[v], joined[v], &around)
            } else {
                Parents::one(number[v])
            };
        });
        Coarsening { mesh, parents }
    }

    /// v if it was chosen, else its nearest chosen neighbor.
    fn nearest_chosen(&self, v: usize, around: &Incidence, number: &[u32]) -> usize {
        if number[v] != NOT_CHOSEN {
            return v;
        }
        let x = self.vertices[v];
        let mut nearest = (f64::INFINITY, v);
        for w in around.faces(v).iter().flat_map(|&j| self.faces[j as usize]) {
            let w = w as usize;
            if number[w] != NOT_CHOSEN {
                let distance = (self.vertices[w] - x).norm_squared();
                if distance < nearest.0 || nearest.1 == v {
                    nearest = (distance, w);
                }
            }
        }
        nearest.1
    }

    /// The point nearest to x on the faces around vertex c.
    fn nearest_point(&self, x: Point3<f64>, c: u32, around: &Incidence) -> Parents {
        let mut nearest = Parents::one(c);
        let mut smallest = (self.vertices[c as usize] - x).norm_squared();
        for &j in around.faces(c as usize).iter().take(MAX_FACES_SEARCHED) {
            let corners = self.corners(j as usize);
            let weights = nearest_weights(x, corners);
            let [a, b, c] = corners.map(|corner| corner - x);
            let distance = (a * weights[0] + b * weights[1] + c * weights[2]).norm_squared();
            // Also false if products of very large or small coordinates are NaN.
            if distance < smallest {
                smallest = distance;
                nearest = Parents { corners: self.faces[j as usize], weights };
            }
        }
        nearest
    }
}

const NOT_CHOSEN: u32 = u32::MAX;

/// The chosen vertices in ascending order, and for each vertex its index among them.
fn independent_set(mesh: &Mesh, around: &Incidence) -> (Vec<u32>, Vec<u32>) {
    let mut chosen = Vec::new();
    let mut number = vec![NOT_CHOSEN; mesh.vertices.len()];
    let mut covered = vec![false; mesh.vertices.len()];
    for v in 0..mesh.vertices.len() {
        if !covered[v] {
            number[v] = chosen.len() as u32;
            chosen.push(v as u32);
            for &w in around.faces(v).iter().flat_map(|&j| &mesh.faces[j as usize]) {
                covered[w as usize] = true;
            }
        }
    }
    (chosen, number)
}

/// The faces around each vertex.
struct Incidence {
    start: Vec<u32>,
    faces: Vec<u32>,
}

impl Incidence {
    fn new(mesh: &Mesh) -> Self {
        let mut start = vec![0; mesh.vertices.len() + 1];
        for &v in mesh.faces.iter().flatten() {
            start[v as usize + 1] += 1;
        }
        for v in 0..mesh.vertices.len() {
            start[v + 1] += start[v];
        }
        let mut next = start.clone();
        let mut faces = vec![0; 3 * mesh.faces.len()];
        for (j, corners) in mesh.faces.iter().enumerate() {
            for &v in corners {
                let end = &mut next[v as usize];
                faces[*end as usize] = j as u32;
                *end += 1;
            }
        }
        Incidence { start, faces }
    }

    fn faces(&self, v: usize) -> &[u32] {
        &self.faces[self.start[v] as usize..self.start[v + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Shape;
    use crate::samples::{needles, shape, soup, zoo};

    fn levels(mesh: Mesh) -> Vec<Coarsening> {
        let mut levels = vec![mesh.coarsened()];
        while levels[levels.len() - 1].mesh.faces.len() > 1 && levels.len() < 12 {
            levels.push(levels[levels.len() - 1].mesh.coarsened());
        }
        levels
    }

    /// On all levels, rows of P are nonnegative and sum to 1, and a coarse vertex is its own only parent.
    #[test]
    fn rows_are_partitions_of_unity_whatever_the_mesh() {
        let meshes = zoo().into_iter().map(|(_, mesh)| mesh);
        let terrible = [needles(20, 1e-9), soup(300, 2000, 3), Mesh::default()];
        let extreme = [1e-80, 1e-60, 1e50].map(|c| shape("sphere:3").scaled(c));
        for mesh in meshes.chain(terrible).chain(extreme) {
            let mut fine = mesh.vertices.clone();
            for level in levels(mesh) {
                assert_eq!(level.parents.len(), fine.len());
                let mut own = vec![false; level.mesh.vertices.len()];
                for (x, Parents { corners, weights }) in fine.iter().zip(&level.parents) {
                    assert!(weights.iter().all(|&w| w >= 0.0));
                    assert!((weights.iter().sum::<f64>() - 1.0).abs() <= 1e-15);
                    let first = corners[0] as usize;
                    own[first] |= weights[0] == 1.0 && level.mesh.vertices[first] == *x;
                }
                assert!(own.iter().all(|&own| own));
                assert!((0..level.mesh.faces.len()).all(|j| !level.mesh.is_degenerate(j)));
                fine = level.mesh.vertices;
            }
        }
    }

    /// On a flat grid the coarse faces cover the whole grid, and P reproduces linear functions.
    #[test]
    fn linear_functions_on_a_flat_grid_are_exact() {
        for text in ["grid:20x20", "grid:31x17"] {
            let mesh = shape(text);
            let Coarsening { mesh: coarse, parents } = mesh.coarsened();
            let covered = (mesh.area() - coarse.area()) / mesh.area();
            for (x, Parents { corners, weights }) in mesh.vertices.iter().zip(parents) {
                let [a, b, c] = corners.map(|c| coarse.vertices[c as usize].coords);
                let error = (a * weights[0] + b * weights[1] + c * weights[2] - x.coords).norm();
                // Beyond the last coarse row of an odd grid there is no interpolation.
                let inside = x.x <= coarse_end(&coarse, 0) && x.y <= coarse_end(&coarse, 1);
                assert!(!inside || error <= 1e-15, "{text}: {x} {error}");
            }
            assert!(covered.abs() <= 0.12, "{text}: {covered}");
        }
    }

    fn coarse_end(mesh: &Mesh, axis: usize) -> f64 {
        mesh.vertices.iter().map(|x| x[axis]).fold(0.0, f64::max)
    }

    /// A quarter of the vertices on regular grids, a fifth to a third elsewhere, and nearly the same area.
    #[test]
    fn the_coarse_surface_is_close_to_the_fine_one() {
        for (text, tolerance) in [("sphere:5", 0.01), ("torus:160x100", 0.005)] {
            let mesh = text.parse::<Shape>().unwrap().mesh();
            let coarse = mesh.coarsened().mesh;
            let share = coarse.vertices.len() as f64 / mesh.vertices.len() as f64;
            assert!((0.15..0.35).contains(&share), "{text}: {share}");
            let lost = 1.0 - coarse.area() / mesh.area();
            assert!(lost.abs() <= tolerance, "{text}: {lost}");
        }
    }

    /// A vertex with more faces than are searched.
    #[test]
    fn a_hub_takes_linear_time() {
        let rim = 20_000;
        let mut points = vec![Point3::origin()];
        points.extend((0..rim).map(|i| {
            let angle = std::f64::consts::TAU * f64::from(i) / f64::from(rim);
            Point3::new(angle.cos(), angle.sin(), 0.0)
        }));
        for hub in [0, rim] {
            let mut points = points.clone();
            points.swap(0, hub as usize);
            let at = |i: u32| if i == hub { 0 } else { i };
            let faces = (0..rim).map(|i| [hub, at(1 + i), at(1 + (i + 1) % rim)]).collect();
            levels(Mesh::new(points, faces));
        }
    }
}
