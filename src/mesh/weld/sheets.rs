//! Edges that get more than two faces by a weld, where sheets lie on each other or touch.

use crate::mesh::Mesh;

/// The number of edges of the welded mesh with more than two proper faces that were merged from edges with at most two
/// each.
pub fn new_non_manifold_edges(
    mesh: &Mesh,
    of: &[u32],
    first: &[u32],
    merged_onto: &[bool],
) -> usize {
    // Only edges with a merged vertex have additional faces.
    let changed = |v: u32| merged_onto[first[v as usize] as usize];
    let mut sides: Vec<[[u32; 2]; 2]> = (mesh.faces.iter())
        .filter(|face| {
            let [a, b, c] = face.map(|v| of[v as usize]);
            a != b && b != c && c != a
        })
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .filter(|&[a, b]| changed(a) || changed(b))
        .map(|side| {
            let ascending = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
            [ascending(side.map(|v| of[v as usize])), ascending(side)]
        })
        .collect();
    sides.sort_unstable();
    sides
        .chunk_by(|a, b| a[0] == b[0])
        .filter(|edge| {
            edge.len() > 2 && edge.chunk_by(|a, b| a[1] == b[1]).all(|side| side.len() <= 2)
        })
        .count()
}
