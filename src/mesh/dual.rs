//! The faces of a mesh as the nodes of a graph, joined across the edges that they share.
//!
//! ```text
//! w_e = l_e          an edge of length l_e with two faces
//! w_e = l_e / 2      an edge with n > 2 faces, joined in a ring: separating one of them from the others costs l_e
//! ```
//!
//! Labels of the faces have cuts along edges, and the weights are their lengths.

use ndarray::ArrayView1;

use super::Mesh;
use super::order::Order;
use super::sides::{Side, edges, sides};
use crate::sweep::{collect, sum};

/// The faces of a mesh, and the pairs of them that share an edge.
#[derive(Clone, Debug)]
pub struct Dual {
    /// A_j, F areas.
    pub areas: Vec<f64>,
    /// The two faces of each pair, different ones.
    pub pairs: Vec<[u32; 2]>,
    /// w_e of each pair, in units of length; positive.
    pub weights: Vec<f64>,
}

impl Dual {
    /// The dual of a mesh. Edges without a length join nothing, nor do boundary edges.
    pub fn new(mesh: &Mesh) -> Self {
        Self::weighted(mesh, &|_, _| 1.0)
    }

    /// The same with weights times a positive factor for each two sides of faces at an edge.
    pub fn weighted(mesh: &Mesh, factor: &dyn Fn(&Side, &Side) -> f64) -> Self {
        let (mut pairs, mut weights) = (Vec::new(), Vec::new());
        let sides = sides(&mesh.faces);
        for sides in edges(&sides) {
            let [a, b] = sides[0].edge.map(|v| mesh.vertices[v as usize]);
            let length = (b - a).norm();
            let mut join = |one: &Side, other: &Side, length: f64| {
                let [j, k] = [one, other].map(Side::face);
                // A face that folds onto itself has the same edge twice.
                if j != k && length > 0.0 {
                    pairs.push([j as u32, k as u32]);
                    weights.push(length * factor(one, other));
                }
            };
            match sides {
                [_] => {}
                [one, other] => join(one, other, length),
                ring => {
                    for (one, next) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                        join(one, next, 0.5 * length);
                    }
                }
            }
        }
        Dual { areas: face_areas(mesh), pairs, weights }
    }

    /// The corners of a pair as those of a face of K: the second face twice.
    pub fn corners(&self) -> Vec<[u32; 3]> {
        collect(self.pairs.len(), |e| {
            let [j, k] = self.pairs[e];
            [j, k, k]
        })
    }

    /// The area that belongs to each pair: a third of each of its faces. Positive even between faces without area, so
    /// that no smoothing divides by zero.
    pub fn areas_at_pairs(&self) -> Vec<f64> {
        let both = |e: usize| self.pairs[e].iter().map(|&j| self.areas[j as usize]).sum::<f64>();
        collect(self.pairs.len(), |e| (both(e) / 3.0).max(f64::MIN_POSITIVE))
    }

    /// The length of the edges between faces with different labels.
    pub fn length_between(&self, labels: ArrayView1<'_, i32>) -> f64 {
        let differ = |e: usize| {
            let [j, k] = self.pairs[e].map(|j| labels[j as usize]);
            j != k
        };
        sum(self.pairs.len(), |e| if differ(e) { self.weights[e] } else { 0.0 })
    }

    /// The order in which neighbors are close to each other, and the graph in it.
    pub(crate) fn ordered(self) -> (Order, Self) {
        let order = Order::of_faces(&self.corners(), self.areas.len());
        let ordered = match order.keeps_all() {
            true => self,
            false => self.in_order(order.vertices(), &order.faces(self.pairs.len())),
        };
        (order, ordered)
    }

    /// The same graph with nodes and pairs in another order; `nodes` holds the present index of the node at each new
    /// one, and `pairs` that of each pair.
    fn in_order(&self, nodes: Option<&[u32]>, pairs: &[usize]) -> Self {
        let index = nodes.map(|nodes| {
            let mut index = vec![0; nodes.len()];
            (0..).zip(nodes).for_each(|(new, &present)| index[present as usize] = new);
            index
        });
        let moved = |j: u32| index.as_ref().map_or(j, |index| index[j as usize]);
        Dual {
            areas: match nodes {
                Some(nodes) => nodes.iter().map(|&j| self.areas[j as usize]).collect(),
                None => self.areas.clone(),
            },
            pairs: pairs.iter().map(|&e| self.pairs[e].map(moved)).collect(),
            weights: pairs.iter().map(|&e| self.weights[e]).collect(),
        }
    }
}

/// A_j, 0 for faces that count as having no area.
pub fn face_areas(mesh: &Mesh) -> Vec<f64> {
    let area = |j: usize| if mesh.is_degenerate(j) { 0.0 } else { mesh.face_area(j) };
    collect(mesh.faces.len(), area)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{disjoint, shape, zoo};
    use nalgebra::Point3;

    /// Every pair shares an edge of its weight, and every inner edge of a surface joins one pair.
    #[test]
    fn pairs_share_edges() {
        for (name, mesh) in zoo() {
            let dual = Dual::new(&mesh);
            assert_eq!(dual.areas.len(), mesh.faces.len());
            for (&[j, k], &weight) in dual.pairs.iter().zip(&dual.weights) {
                let [one, other] = [j, k].map(|j| mesh.faces[j as usize]);
                let shared: Vec<Point3<f64>> = one
                    .iter()
                    .filter(|v| other.contains(v))
                    .map(|&v| mesh.vertices[v as usize])
                    .collect();
                assert!(shared.len() >= 2, "{name}");
                let lengths: Vec<f64> = (0..shared.len())
                    .flat_map(|i| (0..i).map(move |k| (i, k)))
                    .map(|(i, k)| (shared[i] - shared[k]).norm())
                    .collect();
                assert!(lengths.iter().any(|&l| weight == l || weight == 0.5 * l), "{name}");
            }
        }
        for text in ["torus:12x9", "sphere:2"] {
            let mesh = shape(text);
            assert_eq!(2 * Dual::new(&mesh).pairs.len(), 3 * mesh.faces.len(), "{text}");
        }
    }

    /// Around an edge with n > 2 faces, each of them is cut off for the length of the edge.
    #[test]
    fn one_of_many_faces_at_an_edge_costs_its_length() {
        for n in 2..7 {
            let mut vertices = vec![Point3::new(0.0, 0.0, 0.0), Point3::new(0.0, 0.0, 3.0)];
            let mut faces = Vec::new();
            for i in 0..n {
                let angle = i as f64;
                vertices.push(Point3::new(angle.cos(), angle.sin(), 1.0));
                faces.push([0, 1, 2 + i as u32]);
            }
            let dual = Dual::new(&Mesh::new(vertices, faces));
            for j in 0..n as u32 {
                let at = |&(pair, _): &(&[u32; 2], &f64)| pair.contains(&j);
                let cut: f64 =
                    dual.pairs.iter().zip(&dual.weights).filter(at).map(|(_, w)| w).sum();
                assert_eq!(cut, 3.0);
            }
        }
    }

    /// Components stay apart, and another order is the same graph.
    #[test]
    fn another_order_is_the_same_graph() {
        let mesh = disjoint([shape("grid:4x3"), shape("sphere:1")]);
        let dual = Dual::new(&mesh);
        let n = dual.areas.len() as u32;
        let nodes: Vec<u32> = (0..n).rev().collect();
        let pairs: Vec<usize> = (0..dual.pairs.len()).rev().collect();
        let moved = dual.in_order(Some(&nodes), &pairs).in_order(Some(&nodes), &pairs);
        assert_eq!(moved.areas, dual.areas);
        assert_eq!(moved.pairs, dual.pairs);
        assert_eq!(moved.weights, dual.weights);
    }
}
