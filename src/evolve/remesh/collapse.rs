//! Collapses of short edges.
//!
//! The ends of an edge become one vertex: its midpoint, or the end that is on a border. That keeps the topology if the
//! ends have no common neighbors but the other corners of the two faces at the edge (the link condition).
//!
//! Reference: T. K. Dey, H. Edelsbrunner, S. Guha, D. V. Nekhayev, *Topology preserving edge contraction*, Publ. Inst.
//! Math. 66(80), 1999.

use nalgebra::{Point3, center};

use super::lengths::{length, median_edge_length};
use super::quality::{normal, quality, within};
use super::remeshed::Remeshed;
use crate::mesh::sides::{Side, edges, sides};
use crate::mesh::{Incidence, Mesh};

/// The cosine of 45 degrees: no face turns farther.
const LEAST_COSINE: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// A collapse leaves no face below this quality, unless one was worse before.
const LOWEST_QUALITY: f64 = 0.3;

/// A collapse makes no edge that is longer than this multiple of the limit below which edges are collapsed, unless one was
/// longer before.
const LONGEST: f64 = 2.0;

/// Collapses edges that are shorter than `factor` times the median, shorter ones first. Edges whose collapse would change
/// the topology, move a border, turn a face over or make a long edge stay. The edges of one call have no common
/// neighbors, so that several calls are needed, best in turns with flips and smoothing, until none is left.
pub fn collapse_short(mesh: &Mesh, factor: f64) -> Remeshed {
    collapse_below(mesh, median_edge_length(mesh).map_or(0.0, |median| factor * median))
}

/// The same for edges that are shorter than a length.
pub fn collapse_below(mesh: &Mesh, limit: f64) -> Remeshed {
    let sides = sides(&mesh.faces);
    let surface = Surface::new(mesh, &sides, LONGEST * limit);
    let mut short: Vec<(f64, &[Side])> = edges(&sides)
        .map(|edge| (length(mesh, edge[0].edge), edge))
        .filter(|&(length, _)| length < limit)
        .collect();
    short.sort_by(|a, b| a.0.total_cmp(&b.0));

    // For each vertex the one that it becomes, and the new place of that.
    let mut joined: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    let mut parents: Vec<(u32, u32, f64)> = joined.iter().map(|&k| (k, k, 0.0)).collect();
    let mut vertices = mesh.vertices.clone();
    let mut touched = vec![false; mesh.vertices.len()];
    let mut valences = surface.neighbors.iter().map(Vec::len).collect::<Vec<_>>();
    for (_, edge) in short {
        let [a, b] = edge[0].edge;
        if touched[a as usize] || touched[b as usize] {
            continue;
        }
        let Some(Collapse { weight, others }) = surface.collapse(edge, &valences) else { continue };
        joined[b as usize] = a;
        parents[a as usize] = (a, b, weight);
        vertices[a as usize] = surface.at(a, b, weight);
        others.iter().for_each(|&c| valences[c as usize] -= 1);
        for k in [a, b] {
            touched[k as usize] = true;
            surface.neighbors[k as usize].iter().for_each(|&n| touched[n as usize] = true);
        }
    }

    // Without the vertices that became others.
    let kept = |k: &usize| joined[*k] as usize == *k;
    let mut index = vec![0; joined.len()];
    (0..joined.len()).filter(kept).zip(0..).for_each(|(k, new)| index[k] = new);
    let faces = mesh.faces.iter().map(|face| face.map(|k| index[joined[k as usize] as usize]));
    let faces = faces.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    let of_kept = |k: usize| (vertices[k], parents[k]);
    let (vertices, parents) = (0..joined.len()).filter(kept).map(of_kept).unzip();
    Remeshed { mesh: Mesh::new(vertices, faces), parents }
}

/// How an edge ab becomes a vertex.
struct Collapse {
    /// The weight of b in the new place.
    weight: f64,
    /// The other corners of its two faces.
    others: [u32; 2],
}

/// The mesh before any collapse.
struct Surface<'a> {
    mesh: &'a Mesh,
    around: Incidence<u32>,
    /// The neighbors of each vertex, in ascending order.
    neighbors: Vec<Vec<u32>>,
    border: Vec<bool>,
    /// Whether more than two faces share an edge at a vertex.
    manifold: Vec<bool>,
    longest: f64,
}

impl<'a> Surface<'a> {
    fn new(mesh: &'a Mesh, sides: &[Side], longest: f64) -> Self {
        let n = mesh.vertices.len();
        let mut neighbors = vec![Vec::new(); n];
        let mut border = vec![false; n];
        let mut manifold = vec![true; n];
        for edge in edges(sides) {
            let [a, b] = edge[0].edge;
            for (k, neighbor) in [(a, b), (b, a)] {
                neighbors[k as usize].push(neighbor);
                border[k as usize] |= edge.len() == 1;
                manifold[k as usize] &= edge.len() <= 2 && a != b;
            }
        }
        neighbors.iter_mut().for_each(|neighbors| neighbors.sort_unstable());
        let around = Incidence::new(mesh, |j, _| j as u32);
        Surface { mesh, around, neighbors, border, manifold, longest }
    }

    fn at(&self, a: u32, b: u32, weight: f64) -> Point3<f64> {
        let [a, b] = [a, b].map(|k| self.mesh.vertices[k as usize]);
        match weight {
            0.0 => a,
            1.0 => b,
            _ => center(&a, &b),
        }
    }

    /// The collapse of the edge of these sides, if it is allowed.
    fn collapse(&self, edge: &[Side], valences: &[usize]) -> Option<Collapse> {
        let &[f, g] = edge else { return None };
        let [a, b] = f.edge;
        if f.ascends == g.ascends || !(self.manifold[a as usize] && self.manifold[b as usize]) {
            return None;
        }
        let weight = match [a, b].map(|k| self.border[k as usize]) {
            [true, true] => return None,
            [true, false] => 0.0,
            [false, true] => 1.0,
            [false, false] => 0.5,
        };
        let others = [f, g].map(|side| side.opposite(&self.mesh.faces));
        let [of_a, of_b] = [a, b].map(|k| &self.neighbors[k as usize]);
        let common: Vec<u32> =
            of_a.iter().copied().filter(|k| of_b.binary_search(k).is_ok()).collect();
        let mut expected = others.to_vec();
        expected.sort_unstable();
        // A vertex inside the surface keeps three neighbors.
        let lowest = |c: u32| if self.border[c as usize] { 3 } else { 4 };
        if common != expected || others.iter().any(|&c| valences[c as usize] < lowest(c)) {
            return None;
        }
        let x = self.at(a, b, weight);
        let is_possible = self.makes_no_long_edge(a, b, x) && self.keeps_faces(a, b, x);
        is_possible.then_some(Collapse { weight, others })
    }

    fn makes_no_long_edge(&self, a: u32, b: u32, x: Point3<f64>) -> bool {
        let longest = |from: Point3<f64>, k: u32| {
            let to = self.neighbors[k as usize].iter().filter(|&&k| k != a && k != b);
            to.map(|&k| (self.mesh.vertices[k as usize] - from).norm()).fold(0.0, f64::max)
        };
        let before = [a, b].map(|k| longest(self.mesh.vertices[k as usize], k));
        let limit = before.into_iter().fold(self.longest, f64::max);
        [a, b].into_iter().all(|k| longest(x, k) <= limit)
    }

    /// Whether the faces that stay at a or b keep their side and shape if both move to x.
    fn keeps_faces(&self, a: u32, b: u32, x: Point3<f64>) -> bool {
        let has_both = |face: &[u32; 3]| face.contains(&a) && face.contains(&b);
        let worst =
            self.faces_at(a).chain(self.faces_at(b)).map(|face| quality(self.corners(face)));
        let lowest = worst.fold(LOWEST_QUALITY, f64::min);
        self.faces_at(a).chain(self.faces_at(b)).filter(|face| !has_both(face)).all(|face| {
            let old = self.corners(face);
            let mut new = old;
            for (corner, k) in new.iter_mut().zip(face) {
                if k == a || k == b {
                    *corner = x;
                }
            }
            within(&normal(new), &normal(old), LEAST_COSINE) && quality(new) >= lowest
        })
    }

    fn faces_at(&self, k: u32) -> impl Iterator<Item = [u32; 3]> {
        self.around.at(k as usize).iter().map(|&j| self.mesh.faces[j as usize])
    }

    fn corners(&self, face: [u32; 3]) -> [Point3<f64>; 3] {
        face.map(|k| self.mesh.vertices[k as usize])
    }
}
