//! Folds and self-intersections of a surface: what an evolution must not make.

mod crossing;

use serde::{Deserialize, Serialize};

use crate::mesh::Mesh;
use crate::mesh::sides::{Side, edges, sides};
use crate::mesh::tree::{Bounds, Tree};
use crate::sweep;
use crossing::cross;

/// The cosine of 160 degrees, which is the angle between the normals of two faces at a fold.
const FOLD_COSINE: f64 = -0.939_692_620_785_908_4;

/// How often a surface folds or intersects itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Folds {
    /// Edges whose two faces lie on each other: the angle between their normals is above 160 degrees.
    pub folded_edges: usize,
    /// Pairs of faces without a common vertex that pass through each other. Faces that only touch do not count.
    pub intersecting_pairs: usize,
}

/// Counts the folds of a mesh, in about O(F log F) time. Degenerate faces do not count.
pub fn count(mesh: &Mesh) -> Folds {
    let (mesh, _) = mesh.without_degenerate_faces();
    if mesh.faces.is_empty() {
        return Folds { folded_edges: 0, intersecting_pairs: 0 };
    }
    let sides = sides(&mesh.faces);
    let folded_edges = edges(&sides).filter(|edge| is_folded(&mesh, edge)).count();
    let tree = Tree::new(&mesh);
    // Counts are exact in double precision.
    let intersecting_pairs =
        sweep::sum(mesh.faces.len(), |j| crossed_by(&mesh, &tree, j) as f64) as usize;
    Folds { folded_edges, intersecting_pairs }
}

fn is_folded(mesh: &Mesh, edge: &[Side]) -> bool {
    let &[f, g] = edge else { return false };
    let [n, m] = [f, g].map(|side| mesh.area_vector(side.face()).normalize());
    let sign = if f.ascends == g.ascends { -1.0 } else { 1.0 };
    sign * n.dot(&m) < FOLD_COSINE
}

/// The number of faces after face j that pass through it.
fn crossed_by(mesh: &Mesh, tree: &Tree, j: usize) -> usize {
    let mut count = 0;
    let (face, corners) = (mesh.faces[j], mesh.corners(j));
    tree.near(&Bounds::of(corners), |i| {
        let is_apart = |k: &u32| !mesh.faces[i].contains(k);
        if i > j && face.iter().all(is_apart) && cross(&corners, &mesh.corners(i)) {
            count += 1;
        }
    });
    count
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{disjoint, flipped, random_rotation, rng, shape, soup};
    use crate::sweep::with_threads;
    use nalgebra::{Point3, Vector3};

    fn moved(mut mesh: Mesh, by: [f64; 3]) -> Mesh {
        mesh.vertices.iter_mut().for_each(|x| *x += Vector3::from(by));
        mesh
    }

    #[test]
    fn embedded_surfaces_have_none() {
        for text in ["sphere:4", "torus:60x40", "grid:20x20"] {
            let mesh = shape(text);
            for mesh in [flipped(mesh.clone()), mesh.clone().scaled(1e-30), mesh] {
                let none = Folds { folded_edges: 0, intersecting_pairs: 0 };
                assert_eq!(count(&mesh), none, "{text}");
            }
        }
        // Spheres that touch in a vertex, and boxes of the same face.
        let sphere = shape("sphere:3");
        let touching = disjoint([sphere.clone(), moved(sphere, [0.0, 2.0, 0.0])]);
        assert_eq!(count(&touching).intersecting_pairs, 0);
    }

    /// A vertical triangle through one of two faces of a square.
    #[test]
    fn crossing_faces_are_counted_whatever_their_position() {
        let square = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]];
        let sail = [[1.5, 0.5, -1.0], [1.5, 0.6, -1.0], [1.5, 0.5, 1.0]];
        let points: Vec<Point3<f64>> = square.into_iter().chain(sail).map(Point3::from).collect();
        let faces = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6]];
        let mut rng = rng(3);
        for scale in [1e-20, 1.0, 1e20] {
            let turn = random_rotation(&mut rng);
            let turned = points.iter().map(|x| turn * x * scale).collect();
            let mesh = Mesh::new(turned, faces.clone());
            assert_eq!(count(&mesh).intersecting_pairs, 1);
            let mut apart = mesh.clone();
            let away = turn * Vector3::new(0.0, 0.0, 1.01 * scale);
            (4..7).for_each(|k| apart.vertices[k] += away);
            assert_eq!(count(&apart).intersecting_pairs, 0);
        }
    }

    /// The book closes at an edge of 170 degrees between the normals, not at 150.
    #[test]
    fn folds_are_those_of_nearly_opposite_normals() {
        let book = |degrees: f64| {
            let (sin, cos) = f64::to_radians(degrees).sin_cos();
            let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 1.0, 0.0], [0.5, -cos, sin]];
            Mesh::new(points.map(Point3::from).to_vec(), vec![[0, 1, 2], [1, 0, 3]])
        };
        for (degrees, folds) in [(0.0, 0), (90.0, 0), (150.0, 0), (170.0, 1), (179.9, 1)] {
            assert_eq!(count(&book(degrees)).folded_edges, folds, "{degrees}");
            let mut turned = book(degrees);
            turned.faces[1].swap(0, 1);
            assert_eq!(count(&turned).folded_edges, folds, "{degrees}");
        }
    }

    /// All pairs, by another formula: the segments in which the two planes cut the faces have a common point.
    #[test]
    fn pairs_are_those_found_one_by_one() {
        let mesh = soup(120, 250, 21);
        let mut exact = 0;
        for j in 0..mesh.faces.len() {
            for i in 0..j {
                let apart = mesh.faces[j].iter().all(|k| !mesh.faces[i].contains(k));
                exact += usize::from(apart && meet(&mesh.corners(i), &mesh.corners(j)));
            }
        }
        let with = |threads| with_threads(Some(threads), || count(&mesh)).unwrap();
        assert!(exact > 200, "{exact}");
        assert_eq!(with(1).intersecting_pairs, exact);
        assert_eq!(with(1), with(2));
    }

    /// Möller's interval test: both faces cut the common line of their planes in an interval.
    fn meet(a: &[Point3<f64>; 3], b: &[Point3<f64>; 3]) -> bool {
        let plane = |t: &[Point3<f64>; 3]| (t[1] - t[0]).cross(&(t[2] - t[0]));
        let (n, m) = (plane(a), plane(b));
        let along = n.cross(&m);
        let interval = |t: &[Point3<f64>; 3], n: Vector3<f64>, origin: Point3<f64>| {
            let heights = t.map(|x| n.dot(&(x - origin)));
            let mut range: Option<(f64, f64)> = None;
            for i in 0..3 {
                let (p, q) = (i, (i + 1) % 3);
                if (heights[p] > 0.0) != (heights[q] > 0.0) {
                    let share = heights[p] / (heights[p] - heights[q]);
                    let at = along.dot(&(t[p].coords + share * (t[q] - t[p])));
                    range = Some(range.map_or((at, at), |(low, high)| (low.min(at), high.max(at))));
                }
            }
            range
        };
        match (interval(a, m, b[0]), interval(b, n, a[0])) {
            (Some(s), Some(t)) => s.0 <= t.1 && t.0 <= s.1,
            _ => false,
        }
    }
}
