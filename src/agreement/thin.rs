//! Thinning of a set of pixels to lines that are one pixel wide and connected where the set is.
//!
//! Two kinds of passes take turns until nothing changes; each removes all pixels at once that are removable by their
//! eight neighbors. Reference: Z. Guo, R. W. Hall, *Parallel Thinning with Two-Subiteration Algorithms*, Communications
//! of the ACM 32, 1989, algorithm A1, which the Berkeley benchmark uses.

/// Thins a bitmap of this width, row by row.
pub fn thin(set: &mut [bool], width: usize) {
    let members: Vec<usize> = (0..set.len()).filter(|&at| set[at]).collect();
    // A pixel is examined again in a pass only after a neighbor is gone. Bit s: it is listed for passes of kind s.
    let mut listed: Vec<u8> = set.iter().map(|&member| if member { 0b11 } else { 0 }).collect();
    let mut pending = [members.clone(), members];
    while pending.iter().any(|pixels| !pixels.is_empty()) {
        for pass in 0..2 {
            let candidates = std::mem::take(&mut pending[pass]);
            candidates.iter().for_each(|&at| listed[at] &= !(1 << pass));
            let removed: Vec<usize> = candidates
                .into_iter()
                .filter(|&at| set[at] && is_removable(around(set, width, at), pass))
                .collect();
            removed.iter().for_each(|&at| set[at] = false);
            for neighbor in removed.iter().flat_map(|&at| neighbors(set.len(), width, at)).flatten()
            {
                for (kind, pixels) in pending.iter_mut().enumerate() {
                    if set[neighbor] && listed[neighbor] & (1 << kind) == 0 {
                        listed[neighbor] |= 1 << kind;
                        pixels.push(neighbor);
                    }
                }
            }
        }
    }
}

/// The neighbors to the right, upper right, above and so on around the pixel.
fn neighbors(length: usize, width: usize, at: usize) -> [Option<usize>; 8] {
    let (x, y, height) = (at % width, at / width, length / width);
    let right = (x + 1 < width).then_some(1);
    let left = (x > 0).then_some(-1);
    let above = (y > 0).then_some(-(width as isize));
    let below = (y + 1 < height).then_some(width as isize);
    let here = Some(0);
    [
        (right, here),
        (right, above),
        (here, above),
        (left, above),
        (left, here),
        (left, below),
        (here, below),
        (right, below),
    ]
    .map(|(across, along)| Some(at.wrapping_add_signed(across? + along?)))
}

fn around(set: &[bool], width: usize, at: usize) -> [bool; 8] {
    neighbors(set.len(), width, at).map(|neighbor| neighbor.is_some_and(|neighbor| set[neighbor]))
}

/// The conditions of the reference on x_1, ..., x_8, here numbered from 0.
fn is_removable(x: [bool; 8], pass: usize) -> bool {
    let pairs = |condition: &dyn Fn(usize) -> bool| (0..4).filter(|&i| condition(2 * i)).count();
    let crossings = pairs(&|i| !x[i] && (x[i + 1] || x[(i + 2) % 8]));
    let first = pairs(&|i| x[i] || x[i + 1]);
    let second = pairs(&|i| x[i + 1] || x[(i + 2) % 8]);
    let kept = match pass {
        0 => (x[1] || x[2] || !x[7]) && x[0],
        _ => (x[5] || x[6] || !x[3]) && x[4],
    };
    crossings == 1 && (2..=3).contains(&first.min(second)) && !kept
}
