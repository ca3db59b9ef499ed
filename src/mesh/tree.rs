//! A tree of boxes around the faces of a mesh, for the nearest face and for faces that overlap a box.
//!
//! The faces are halved at the median of their centers along the longest side of the box of these centers, down to a few
//! in a leaf. Reference: C. Ericson, *Real-time collision detection*, 2005, chapter 6.

use nalgebra::Point3;

use super::Mesh;
use super::triangle::nearest_weights;

/// At most this many faces in a leaf.
const LEAF: usize = 4;

/// The tree is balanced, so that this depth suffices for 2^32 faces.
const MAX_DEPTH: usize = 40;

/// An axis-parallel box.
#[derive(Clone, Copy)]
pub struct Bounds {
    /// The smallest x, y and z.
    pub low: Point3<f64>,
    /// The largest x, y and z.
    pub high: Point3<f64>,
}

impl Bounds {
    /// The smallest box around points, of which there is at least one.
    pub fn of(points: impl IntoIterator<Item = Point3<f64>>) -> Self {
        let empty = Bounds { low: [f64::INFINITY; 3].into(), high: [f64::NEG_INFINITY; 3].into() };
        points
            .into_iter()
            .fold(empty, |Bounds { low, high }, x| Bounds { low: low.inf(&x), high: high.sup(&x) })
    }

    /// Whether the boxes have a point in common.
    #[inline(always)]
    fn overlaps(&self, other: &Bounds) -> bool {
        (0..3).all(|i| self.low[i] <= other.high[i] && other.low[i] <= self.high[i])
    }

    /// The squared distance of a point; 0 inside.
    #[inline(always)]
    fn distance_squared(&self, x: &Point3<f64>) -> f64 {
        let beyond = |i: usize| (self.low[i] - x[i]).max(x[i] - self.high[i]).max(0.0);
        [0, 1, 2].map(beyond).iter().map(|d| d * d).sum()
    }
}

/// A node; the left child of an inner one follows it.
struct Node {
    bounds: Bounds,
    /// The right child of an inner node, the first of the faces of a leaf.
    first: u32,
    /// The number of faces of a leaf; 0 for an inner node.
    count: u32,
}

/// The point of a surface that is nearest to a given one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// The squared distance between the two.
    pub distance_squared: f64,
    /// A face on which it lies.
    pub face: usize,
    /// Its barycentric coordinates there.
    pub weights: [f64; 3],
}

/// The tree of a mesh with at least one face.
pub struct Tree {
    nodes: Vec<Node>,
    /// The faces in the order of the leaves, and their corners.
    faces: Vec<u32>,
    corners: Vec<[Point3<f64>; 3]>,
}

impl Tree {
    /// Builds the tree in O(F log F) time. Panics if there are no faces.
    pub fn new(mesh: &Mesh) -> Self {
        assert!(!mesh.faces.is_empty());
        let center = |j: usize| {
            let [a, b, c] = mesh.corners(j).map(|x| x.coords);
            Point3::from(a + b + c)
        };
        let mut items: Vec<(Point3<f64>, u32)> =
            (0..mesh.faces.len()).map(|j| (center(j), j as u32)).collect();
        let mut nodes = Vec::with_capacity(mesh.faces.len());
        build(mesh, &mut items, 0, &mut nodes);
        let faces: Vec<u32> = items.into_iter().map(|(_, j)| j).collect();
        let corners = faces.iter().map(|&j| mesh.corners(j as usize)).collect();
        Tree { nodes, faces, corners }
    }

    /// The squared distance from x to the nearest face. No face may be degenerate.
    pub fn distance_squared(&self, x: Point3<f64>) -> f64 {
        self.nearest(x).distance_squared
    }

    /// The nearest point of the faces to x. No face may be degenerate.
    pub fn nearest(&self, x: Point3<f64>) -> Nearest {
        let mut nearest =
            Nearest { distance_squared: f64::INFINITY, face: 0, weights: [1.0, 0.0, 0.0] };
        let mut stack = [(0, 0.0); MAX_DEPTH];
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let (at, bound) = stack[height];
            if bound >= nearest.distance_squared {
                continue;
            }
            let Node { first, count, .. } = self.nodes[at];
            if count > 0 {
                for i in first as usize..(first + count) as usize {
                    let weights = nearest_weights(x, self.corners[i]);
                    let [a, b, c] = self.corners[i].map(|corner| corner - x);
                    let d = (a * weights[0] + b * weights[1] + c * weights[2]).norm_squared();
                    if d < nearest.distance_squared {
                        let face = self.faces[i] as usize;
                        nearest = Nearest { distance_squared: d, face, weights };
                    }
                }
                continue;
            }
            let [left, right] = [at + 1, first as usize]
                .map(|child| (child, self.nodes[child].bounds.distance_squared(&x)));
            // The nearer child comes first.
            let (near, far) = if left.1 <= right.1 { (left, right) } else { (right, left) };
            stack[height] = far;
            stack[height + 1] = near;
            height += 2;
        }
        nearest
    }

    /// Calls `visit` for the faces whose own boxes overlap a box, and maybe for others.
    pub fn near(&self, bounds: &Bounds, mut visit: impl FnMut(usize)) {
        let mut stack = [0; MAX_DEPTH];
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let at = stack[height];
            let Node { bounds: own, first, count } = &self.nodes[at];
            if !own.overlaps(bounds) {
                continue;
            }
            if *count > 0 {
                let leaf = *first as usize..(first + count) as usize;
                self.faces[leaf].iter().for_each(|&j| visit(j as usize));
            } else {
                stack[height] = *first as usize;
                stack[height + 1] = at + 1;
                height += 2;
            }
        }
    }
}

/// Appends the nodes of some faces, given by three times their centers; `first` is the index of the first of them.
fn build(mesh: &Mesh, items: &mut [(Point3<f64>, u32)], first: usize, nodes: &mut Vec<Node>) {
    let corners = items.iter().flat_map(|&(_, j)| mesh.corners(j as usize));
    let bounds = Bounds::of(corners);
    if items.len() <= LEAF {
        nodes.push(Node { bounds, first: first as u32, count: items.len() as u32 });
        return;
    }
    let centers = Bounds::of(items.iter().map(|(center, _)| *center));
    let axis = (centers.high - centers.low).imax();
    let half = items.len() / 2;
    items.select_nth_unstable_by(half, |a, b| a.0[axis].total_cmp(&b.0[axis]));
    let at = nodes.len();
    nodes.push(Node { bounds, first: 0, count: 0 });
    let (left, right) = items.split_at_mut(half);
    build(mesh, left, first, nodes);
    nodes[at].first = nodes.len() as u32;
    build(mesh, right, first + half, nodes);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{random_vector, rng, soup, zoo};

    /// The nearest of all faces, one by one.
    #[test]
    fn distances_are_those_of_the_nearest_face() {
        let mut rng = rng(7);
        for (name, mesh) in zoo().into_iter().chain([("large soup", soup(300, 3000, 9))]) {
            let tree = Tree::new(&mesh);
            let size = mesh.vertices.iter().map(|x| x.coords.amax()).fold(0.0, f64::max);
            for _ in 0..50 {
                let x = Point3::from(2.0 * size * random_vector(&mut rng));
                let distance = |j: usize| {
                    let corners = mesh.corners(j);
                    let weights = nearest_weights(x, corners);
                    let [a, b, c] = corners.map(|corner| corner - x);
                    (a * weights[0] + b * weights[1] + c * weights[2]).norm_squared()
                };
                let exact = (0..mesh.faces.len()).map(distance).fold(f64::INFINITY, f64::min);
                let Nearest { distance_squared, face, weights } = tree.nearest(x);
                assert!((distance_squared - exact).abs() <= 1e-12 * exact, "{name}: {exact}");
                assert_eq!(distance_squared, distance(face), "{name}");
                assert_eq!(weights, nearest_weights(x, mesh.corners(face)), "{name}");
            }
        }
    }

    #[test]
    fn every_face_whose_box_overlaps_is_found_once() {
        for (name, mesh) in zoo() {
            let tree = Tree::new(&mesh);
            let of = |j: usize| Bounds::of(mesh.corners(j));
            for j in 0..mesh.faces.len() {
                let mut found = Vec::new();
                tree.near(&of(j), |i| found.push(i));
                found.sort_unstable();
                assert!(found.windows(2).all(|pair| pair[0] < pair[1]), "{name}");
                let overlaps = |&i: &usize| of(i).overlaps(&of(j));
                found.retain(overlaps);
                let exact: Vec<usize> = (0..mesh.faces.len()).filter(overlaps).collect();
                assert_eq!(found, exact, "{name}");
            }
        }
    }
}
