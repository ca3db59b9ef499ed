//! The sides of faces, grouped by the edges that they share.

use super::incidence::Incidence;
use crate::sweep::{collect, ranges};

/// A face at an edge.
#[derive(Clone, Copy, Default)]
pub struct Side {
    /// The ends, the smaller first.
    pub edge: [u32; 2],
    /// 3 j + i for the side of face j that begins at its corner i.
    pub corner: u32,
    /// Whether the face traverses the edge from the smaller to the larger end.
    pub ascends: bool,
}

impl Side {
    /// The index of the face.
    pub fn face(&self) -> usize {
        self.corner as usize / 3
    }

    /// The corner of the face that is not on the edge.
    pub fn opposite(&self, faces: &[[u32; 3]]) -> u32 {
        faces[self.face()][(self.corner as usize + 2) % 3]
    }
}

/// All sides, grouped by edge, in the order of their faces; the edges are in the order of their ends.
pub fn sides(faces: &[[u32; 3]]) -> Vec<Side> {
    let side = |i: usize| {
        let (face, corner) = (faces[i / 3], i % 3);
        let (a, b) = (face[corner], face[(corner + 1) % 3]);
        Side { edge: [a.min(b), a.max(b)], corner: i as u32, ascends: a < b }
    };
    let first = collect(3 * faces.len(), |i| [side(i).edge[0]]);
    let vertices = first.iter().map(|&[v]| v as usize + 1).max().unwrap_or(0);
    let mut sides = Incidence::in_ranges(&ranges(vertices), &first, |i, _| side(i)).into_values();
    for same_first in sides.chunk_by_mut(|a, b| a.edge[0] == b.edge[0]) {
        same_first.sort_unstable_by_key(|side| (side.edge[1], side.corner));
    }
    sides
}

/// The groups of sides at the same edge, each with at least one.
pub fn edges(sides: &[Side]) -> impl Iterator<Item = &[Side]> + Clone {
    sides.chunk_by(|a, b| a.edge == b.edge)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::zoo;

    #[test]
    fn all_sides_come_sorted_by_their_edges() {
        for (name, mesh) in zoo() {
            let mut expected = Vec::new();
            for (j, face) in mesh.faces.iter().enumerate() {
                for i in 0..3 {
                    let (a, b) = (face[i], face[(i + 1) % 3]);
                    expected.push(([a.min(b), a.max(b)], (3 * j + i) as u32, a < b));
                }
            }
            expected.sort_unstable();
            let found = sides(&mesh.faces);
            let found: Vec<_> = found.iter().map(|s| (s.edge, s.corner, s.ascends)).collect();
            assert_eq!(found, expected, "{name}");
        }
        assert!(sides(&[]).is_empty());
    }
}
