//! The sides of faces, grouped by the edges that they share.

/// A face at an edge.
#[derive(Clone, Copy)]
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

/// All sides, grouped by edge, in the order of their faces.
pub fn sides(faces: &[[u32; 3]]) -> Vec<Side> {
    let mut sides = Vec::with_capacity(3 * faces.len());
    for (j, &face) in (0..).zip(faces) {
        for i in 0..3 {
            let (a, b) = (face[i], face[(i + 1) % 3]);
            sides.push(Side {
                edge: [a.min(b), a.max(b)],
                corner: 3 * j + i as u32,
                ascends: a < b,
            });
        }
    }
    sides.sort_unstable_by_key(|side| (side.edge, side.corner));
    sides
}

/// The groups of sides at the same edge, each with at least one.
pub fn edges(sides: &[Side]) -> impl Iterator<Item = &[Side]> + Clone {
    sides.chunk_by(|a, b| a.edge == b.edge)
}
