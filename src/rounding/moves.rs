//! Single moves: one vertex after the other takes the label that costs least next to its neighbors, until none changes.

use std::collections::VecDeque;

use super::labels::Labels;

/// At most this many vertices are tried, per vertex of the mesh.
const MAX_TRIALS: usize = 20;

/// Moves single vertices at cuts; each move lowers the energy.
pub fn improve(labels: &mut Labels<'_>) {
    let mut is_queued = labels.at_cuts();
    let vertices = 0..labels.vertices() as u32;
    let mut queue: VecDeque<u32> = vertices.filter(|&v| is_queued[v as usize]).collect();
    let mut left = MAX_TRIALS * labels.vertices();
    while let Some(v) = queue.pop_front()
        && left > 0
    {
        left -= 1;
        is_queued[v as usize] = false;
        let around = labels.faces_at(v as usize).iter();
        let neighbors: Vec<u32> = around.flat_map(|&j| labels.face(j)).collect();
        let mut candidates: Vec<u8> =
            neighbors.iter().map(|&w| labels.labels[w as usize]).collect();
        candidates.sort_unstable();
        candidates.dedup();
        let mut best = None;
        for p in candidates {
            if p == labels.labels[v as usize] || !labels.is_allowed(v as usize, p) {
                continue;
            }
            let [change, error] = labels.change(&[v], p, &|w| w == v);
            if change < -error && best.is_none_or(|(least, _)| change < least) {
                best = Some((change, p));
            }
        }
        if let Some((_, p)) = best {
            labels.labels[v as usize] = p;
            for w in neighbors {
                if !std::mem::replace(&mut is_queued[w as usize], true) {
                    queue.push_back(w);
                }
            }
        }
    }
}
