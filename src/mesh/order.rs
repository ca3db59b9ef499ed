//! A numbering that places neighbors close to each other in memory, for meshes whose own numbering is scattered.
//!
//! A numbering around a closed surface, in which the first vertices touch the last ones, is folded: the first, the
//! last, the second, the last but one. Otherwise vertices are ordered by reverse Cuthill-McKee: breadth-first search
//! from a far end of each component, where the neighbors of a vertex are ordered by their number of faces, and then
//! reversed. Faces are sorted by their last vertex. Reference: A. George, J. W. H. Liu, *Computer Solution of Large
//! Sparse Positive Definite Systems*, 1981, chapter 4.

use std::borrow::Cow;

use super::{Incidence, Mesh};
use crate::sweep::{collect, join, ranges, sum};

/// A numbering counts as scattered if the mean front of a sweep, the visited vertices with unvisited neighbors, exceeds
/// this factor times sqrt(V), or if the last vertices of successive faces are that far apart on average. Strip-wise
/// numbering has a factor of about 1 or 2; in a random order the front is V / 2.
const SCATTERED_FRONT: f64 = 4.0;

/// A new order of the vertices and faces of a mesh; `None` keeps the present one.
pub struct Order {
    /// The present index of the vertex at each new index.
    vertices: Option<Vec<u32>>,
    /// The same for the faces.
    faces: Option<Vec<u32>>,
}

impl Order {
    /// The present order.
    pub fn as_it_is() -> Self {
        Order { vertices: None, faces: None }
    }

    /// The order for a mesh; the present one if it is not scattered.
    pub fn of(mesh: &Mesh) -> Self {
        Self::of_faces(&mesh.faces, mesh.vertices.len())
    }

    /// The same for the faces of a mesh of `count` vertices, or for what has the corners of faces.
    pub fn of_faces(corners: &[[u32; 3]], count: usize) -> Self {
        let folded = |v| fold(v, count as u32);
        let (as_it_is, when_folded) =
            join(|| front(corners, count, |v| v), || front(corners, count, folded));
        let bound = SCATTERED_FRONT * (count as f64).sqrt();
        let vertices = if as_it_is <= bound {
            None
        } else if when_folded <= bound {
            let mut order = vec![0; count];
            (0..count as u32).for_each(|v| order[folded(v) as usize] = v);
            Some(order)
        } else {
            Some(reverse_cuthill_mckee(corners, count))
        };
        let faces = match &vertices {
            Some(vertices) => {
                let index = inverse(vertices);
                Some(by_last(corners, count, |v| index[v as usize]))
            }
            None if jump(corners) > bound => Some(by_last(corners, count, |v| v)),
            None => None,
        };
        Order { vertices, faces }
    }

    /// The mesh in this order, without colors, texture coordinates and materials.
    pub fn mesh<'a>(&self, mesh: Cow<'a, Mesh>) -> Cow<'a, Mesh> {
        let Some(order) = &self.faces else { return mesh };
        let face = |j: usize| mesh.faces[order[j] as usize];
        let (vertices, faces) = match &self.vertices {
            Some(vertices) => {
                let index = inverse(vertices);
                let faces = collect(order.len(), |j| face(j).map(|v| index[v as usize]));
                (collect(vertices.len(), |v| mesh.vertices[vertices[v] as usize]), faces)
            }
            None => (mesh.vertices.clone(), collect(order.len(), face)),
        };
        Cow::Owned(Mesh { vertices, faces, ..Mesh::default() })
    }

    /// Whether nothing moves.
    pub fn keeps_all(&self) -> bool {
        self.vertices.is_none() && self.faces.is_none()
    }

    /// The present index of the vertex at each new index, if any vertex moves.
    pub fn vertices(&self) -> Option<&[u32]> {
        self.vertices.as_deref()
    }

    /// The present index of the face at each of `count` new indices.
    pub fn faces(&self, count: usize) -> Vec<usize> {
        match &self.faces {
            Some(order) => order.iter().map(|&j| j as usize).collect(),
            None => (0..count).collect(),
        }
    }

    /// Reorders values at the vertices of the original mesh.
    pub fn applied<T: Copy + Send + Sync>(&self, values: Vec<T>) -> Vec<T> {
        match &self.vertices {
            Some(order) => collect(order.len(), |v| values[order[v] as usize]),
            None => values,
        }
    }

    /// The new index of each vertex of the original mesh, if any vertex moves.
    pub fn indices(&self) -> Option<Vec<u32>> {
        self.vertices.as_ref().map(|order| inverse(order))
    }
}

/// The mean over the vertices of the distance, in new indices, to the last vertex of all faces at this vertex or at
/// earlier ones.
fn front(faces: &[[u32; 3]], vertices: usize, index: impl Fn(u32) -> u32) -> f64 {
    let mut last = vec![0; vertices];
    for &face in faces {
        let [a, b, c] = face.map(&index);
        let begin = &mut last[a.min(b).min(c) as usize];
        *begin = a.max(b).max(c).max(*begin);
    }
    let mut sum = 0.0;
    let mut most = 0;
    for (v, last) in last.into_iter().enumerate() {
        most = last.max(most).max(v as u32);
        sum += f64::from(most - v as u32);
    }
    sum / vertices as f64
}

/// Alternately from both ends to the middle.
fn fold(v: u32, vertices: u32) -> u32 {
    if v < vertices.div_ceil(2) { 2 * v } else { 2 * (vertices - 1 - v) + 1 }
}

/// The mean distance of the last vertices of successive faces.
fn jump(faces: &[[u32; 3]]) -> f64 {
    let far = |j: usize| f64::from(last(faces[j]).abs_diff(last(faces[j - 1])));
    sum(faces.len(), |j| if j > 0 { far(j) } else { 0.0 }) / faces.len() as f64
}

fn last([a, b, c]: [u32; 3]) -> u32 {
    a.max(b).max(c)
}

/// The inverse permutation.
fn inverse(order: &[u32]) -> Vec<u32> {
    let mut index = vec![0; order.len()];
    for (new, &present) in order.iter().enumerate() {
        index[present as usize] = new as u32;
    }
    index
}

/// The faces sorted by their last vertex, where vertices have the given indices.
fn by_last(faces: &[[u32; 3]], vertices: usize, index: impl Fn(u32) -> u32 + Sync) -> Vec<u32> {
    sorted_by(&collect(faces.len(), |j| last(faces[j].map(&index))), vertices)
}

/// The numbers 0, 1, ... in the order of their keys, which are below `count`: counting sort.
pub fn sorted_by(keys: &[u32], count: usize) -> Vec<u32> {
    if keys.is_sorted() {
        return (0..keys.len() as u32).collect();
    }
    Incidence::in_ranges(&ranges(count), keys.as_chunks::<1>().0, |i, _| i as u32).into_values()
}

fn reverse_cuthill_mckee(corners: &[[u32; 3]], count: usize) -> Vec<u32> {
    // The neighbors of a vertex side by side: reading them from the faces, which are scattered in memory, takes several
    // times as long.
    let around = Incidence::in_ranges(&ranges(count), corners, |j, i| {
        let face = corners[j];
        [face[(i + 1) % 3], face[(i + 2) % 3]]
    });
    let mut order = Vec::with_capacity(count);
    let mut reached = vec![false; count];
    for v in 0..count as u32 {
        if reached[v as usize] {
            continue;
        }
        let component = order.len();
        breadth_first(&around, v, &mut order, &mut reached);
        // The last vertex of a first search is a far end to start from.
        let end = order[order.len() - 1];
        for v in order.drain(component..) {
            reached[v as usize] = false;
        }
        breadth_first(&around, end, &mut order, &mut reached);
    }
    order.reverse();
    order
}

/// Appends the vertices of the component of `begin`, nearer ones first.
fn breadth_first(
    around: &Incidence<[u32; 2]>,
    begin: u32,
    order: &mut Vec<u32>,
    reached: &mut [bool],
) {
    let mut next = order.len();
    order.push(begin);
    reached[begin as usize] = true;
    while let Some(&v) = order.get(next) {
        next += 1;
        let news = order.len();
        for &neighbor in around.at(v as usize).as_flattened() {
            if !reached[neighbor as usize] {
                reached[neighbor as usize] = true;
                order.push(neighbor);
            }
        }
        order[news..].sort_by_key(|&v| around.at(v as usize).len());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{disjoint, rng, shape, shuffled, with_isolated_vertices, zoo};

    fn is_bijection(order: &[u32], n: usize) -> bool {
        let mut sorted = order.to_vec();
        sorted.sort_unstable();
        sorted == (0..n as u32).collect::<Vec<_>>()
    }

    #[test]
    fn every_vertex_and_face_has_one_index() {
        for (name, mesh) in zoo() {
            let vertices = reverse_cuthill_mckee(&mesh.faces, mesh.vertices.len());
            assert!(is_bijection(&vertices, mesh.vertices.len()), "{name}");
            let index = inverse(&vertices);
            let sorted = by_last(&mesh.faces, mesh.vertices.len(), |v| index[v as usize]);
            assert!(is_bijection(&sorted, mesh.faces.len()), "{name}");
            let last = |&j: &u32| last(mesh.faces[j as usize].map(|v| index[v as usize]));
            assert!(sorted.iter().map(last).is_sorted(), "{name}");
        }
    }

    #[test]
    fn good_orders_are_kept() {
        for text in ["grid:100x100", "grid:30x200"] {
            let order = Order::of(&shape(text));
            assert!(order.vertices.is_none() && order.faces.is_none(), "{text}");
        }
    }

    fn width(mesh: &Mesh) -> f64 {
        front(&mesh.faces, mesh.vertices.len(), |v| v)
    }

    /// The width is twice the circle of vertices that a sweep along the surface crosses.
    #[test]
    fn numberings_of_closed_surfaces_are_folded() {
        for (text, around) in [("torus:400x250", 250.0), ("torus:60x90", 90.0)] {
            let mesh = shape(text);
            let order = Order::of(&mesh);
            assert_eq!(order.vertices().unwrap()[..3], [0, mesh.vertices.len() as u32 - 1, 1]);
            let folded = order.mesh(Cow::Owned(mesh));
            assert!((width(&folded) / around - 2.0).abs() < 0.1, "{text}: {}", width(&folded));
            let again = Order::of(&folded);
            assert!(again.vertices.is_none() && again.faces.is_none(), "{text}");
        }
    }

    #[test]
    fn scattered_orders_become_local() {
        let tidy = shape("torus:120x75");
        let pair = disjoint([tidy.clone(), tidy.clone()]);
        let isolated = with_isolated_vertices(tidy.clone());
        for mesh in [tidy.clone(), pair, isolated] {
            let (scattered, _) = shuffled(&mesh, &mut rng(141));
            assert!(width(&scattered) > 0.4 * tidy.vertices.len() as f64);
            let narrow = Order::of(&scattered).mesh(Cow::Borrowed(&scattered));
            assert!(width(&narrow) < 3.0 * 75.0, "{}", width(&narrow));
            assert!(jump(&narrow.faces) < 3.0);
            let again = Order::of(&narrow);
            assert!(again.vertices.is_none() && again.faces.is_none());
        }
    }

    /// The triangles in space stay the same, and values stay at their vertices.
    #[test]
    fn the_surface_is_the_same() {
        let (mesh, _) = shuffled(&with_isolated_vertices(shape("torus:50x40")), &mut rng(142));
        let order = Order::of(&mesh);
        let moved = order.mesh(Cow::Borrowed(&mesh));
        let vertices = order.applied((0..mesh.vertices.len()).collect());
        let indices = order.indices().unwrap();
        assert!((0..mesh.vertices.len()).all(|v| vertices[indices[v] as usize] == v));
        for (&x, &v) in moved.vertices.iter().zip(&vertices) {
            assert_eq!(x, mesh.vertices[v]);
        }
        let mut faces = mesh.faces.clone();
        let mut back: Vec<[u32; 3]> =
            moved.faces.iter().map(|face| face.map(|v| vertices[v as usize] as u32)).collect();
        faces.sort_unstable();
        back.sort_unstable();
        assert_eq!(faces, back);
    }

    #[test]
    fn shuffled_faces_are_sorted_without_moving_vertices() {
        let mut mesh = shape("grid:60x50");
        let half = mesh.faces.split_off(3000);
        mesh.faces = mesh.faces.into_iter().zip(half).flat_map(|(a, b)| [a, b]).collect();
        let order = Order::of(&mesh);
        assert!(order.vertices.is_none());
        let sorted = order.mesh(Cow::Borrowed(&mesh));
        assert_eq!(sorted.vertices, mesh.vertices);
        assert!(sorted.faces.iter().map(|&face| last(face)).is_sorted());
    }
}
