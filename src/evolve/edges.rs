//! The edges of a surface with the faces at each, and the neighbors of each vertex.

use crate::mesh::Mesh;

/// The edges of a mesh, whatever the number of faces at each: usually two, one at a boundary.
pub struct Edges {
    /// The two ends of each edge, the smaller vertex first.
    pub ends: Vec<[u32; 2]>,
    /// The faces at edge i and their corners opposite to it are those from `start[i]` to `start[i + 1]`.
    start: Vec<u32>,
    wings: Vec<Wing>,
}

/// A face at an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wing {
    /// j.
    pub face: u32,
    /// The vertex of the face that is not on the edge.
    pub opposite: u32,
}

impl Edges {
    /// The edges of the faces of a mesh, ordered by their ends.
    pub fn of(mesh: &Mesh) -> Self {
        let mut halves = Vec::with_capacity(3 * mesh.faces.len());
        for (j, &[a, b, c]) in mesh.faces.iter().enumerate() {
            for [a, b, opposite] in [[a, b, c], [b, c, a], [c, a, b]] {
                halves.push(([a.min(b), a.max(b)], Wing { face: j as u32, opposite }));
            }
        }
        // Stable: the faces at an edge stay in their order.
        halves.sort_by_key(|(ends, _)| *ends);
        let (mut ends, mut start) = (Vec::new(), Vec::new());
        for (i, (of_edge, _)) in halves.iter().enumerate() {
            if ends.last() != Some(of_edge) {
                ends.push(*of_edge);
                start.push(i as u32);
            }
        }
        start.push(halves.len() as u32);
        Edges { ends, start, wings: halves.into_iter().map(|(_, wing)| wing).collect() }
    }

    /// The faces at edge i.
    #[inline(always)]
    pub fn wings(&self, i: usize) -> &[Wing] {
        &self.wings[self.start[i] as usize..self.start[i + 1] as usize]
    }
}

/// The neighbors of each vertex.
pub struct Neighbors {
    start: Vec<u32>,
    vertices: Vec<u32>,
}

impl Neighbors {
    /// Along these edges of V vertices.
    pub fn along(edges: &Edges, vertices: usize) -> Self {
        let mut start = vec![0; vertices + 1];
        for [a, b] in &edges.ends {
            start[*a as usize + 1] += 1;
            start[*b as usize + 1] += 1;
        }
        for k in 0..vertices {
            start[k + 1] += start[k];
        }
        let mut next = start.clone();
        let mut of = vec![0; 2 * edges.ends.len()];
        for &[a, b] in &edges.ends {
            for (from, to) in [(a, b), (b, a)] {
                let slot = &mut next[from as usize];
                of[*slot as usize] = to;
                *slot += 1;
            }
        }
        Neighbors { start, vertices: of }
    }

    /// Those of vertex k.
    #[inline(always)]
    pub fn of(&self, k: usize) -> &[u32] {
        &self.vertices[self.start[k] as usize..self.start[k + 1] as usize]
    }
}
