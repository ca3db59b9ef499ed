//! Vertices at equal positions, by a hash table, in O(V) time.

use nalgebra::Point3;

use super::referenced;
use super::table::{Table, hash};
use crate::mesh::Mesh;
use crate::sweep;

/// For each vertex the first referenced vertex at its position; `None` if no two coincide.
pub fn firsts(mesh: &Mesh) -> Option<Vec<u32>> {
    let pairs = equal_pairs(&mesh.vertices, |_| true);
    if pairs.is_empty() {
        return None;
    }
    let referenced = referenced(mesh);
    let pairs = equal_pairs(&mesh.vertices, |v| referenced[v]);
    let mut first: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    for &[v, earlier] in &pairs {
        first[v as usize] = earlier;
    }
    (!pairs.is_empty()).then_some(first)
}

/// Each vertex at the position of an earlier one, and the first vertex there.
///
/// Every thread has a table for its part of the hashes.
fn equal_pairs(points: &[Point3<f64>], counts: impl Fn(usize) -> bool + Sync) -> Vec<[u32; 2]> {
    // -0 + 0 = 0, so that both zeros have the same bits.
    let bits = |v: usize| [points[v].x, points[v].y, points[v].z].map(|x| (x + 0.0).to_bits());
    let hashes = sweep::collect(
        points.len(),
        #[inline(always)]
        |v| hash(bits(v)),
    );
    let parts = sweep::ranges(points.len()).len() - 1;
    let part_of = |hash: u64| ((u128::from(hash) * parts as u128) >> 64) as usize;
    let pairs = sweep::results((0..parts).collect(), |part| {
        let mine = || {
            let all = hashes.iter().enumerate();
            all.filter(|&(v, &hash)| part_of(hash) == part && counts(v))
        };
        let mut table = Table::for_at_most(mine().count());
        let mut pairs = Vec::new();
        for (v, &hash) in mine() {
            let first = table.find_or_insert(hash, v as u32, |w| bits(w as usize) == bits(v));
            if first as usize != v {
                pairs.push([v as u32, first]);
            }
        }
        pairs
    });
    pairs.concat()
}
