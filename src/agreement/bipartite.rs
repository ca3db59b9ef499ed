//! Maximum one-to-one matching of the pixels of two sets within a distance.
//!
//! The nearest pairs are matched first, then shortest augmenting paths complete the matching. A pixel that is matched
//! stays matched. Reference: J. E. Hopcroft, R. M. Karp, *An n^(5/2) Algorithm for Maximum Matchings in Bipartite
//! Graphs*, SIAM J. Comput. 2, 1973. Pairs are enumerated, not stored.

const NONE: u32 = u32::MAX;

/// The displacements of at most `distance` within an image of `size` = [width, height] pixels, the shortest first.
pub fn disk(distance: f64, size: [usize; 2]) -> Vec<[i64; 2]> {
    let [x, y] = size.map(|length| (distance as i64).min(length as i64 - 1));
    let within = |[dx, dy]: &[i64; 2]| ((dx * dx + dy * dy) as f64) <= distance * distance;
    let all = (-y..=y).flat_map(|dy| (-x..=x).map(move |dx| [dx, dy]));
    let mut disk: Vec<_> = all.filter(within).collect();
    disk.sort_by_key(|&[dx, dy]| dx * dx + dy * dy);
    disk
}

/// The matched elements of the first set, in the order of its pixels; there is one of the second set for each.
///
/// Both sets are bitmaps of a grid of this width, row by row. No pair is farther apart than the displacements allow.
pub fn matched(first: &[bool], second: &[bool], width: usize, disk: &[[i64; 2]]) -> Vec<bool> {
    let mut matching = Matching::new(first, second, width, disk);
    matching.pair_nearest();
    while matching.layers() {
        for l in 0..matching.pixels.len() {
            if matching.partner_of_first[l] == NONE {
                matching.augment(l as u32);
            }
        }
    }
    matching.partner_of_first.iter().map(|&r| r != NONE).collect()
}

struct Matching<'a> {
    disk: &'a [[i64; 2]],
    width: i64,
    height: i64,
    /// The coordinates of the pixels of the first set.
    pixels: Vec<[i64; 2]>,
    /// The number of each grid pixel within the second set, or `NONE`.
    second: Vec<u32>,
    partner_of_first: Vec<u32>,
    partner_of_second: Vec<u32>,
    /// Half the length of the shortest alternating path from an unmatched pixel to each of the first set.
    layer: Vec<u32>,
    /// The next displacement to try.
    next: Vec<usize>,
}

impl<'a> Matching<'a> {
    fn new(first: &[bool], second: &[bool], width: usize, disk: &'a [[i64; 2]]) -> Self {
        let members = |set: &[bool]| -> Vec<usize> { (0..set.len()).filter(|&i| set[i]).collect() };
        let (pixels, others) = (members(first), members(second));
        let mut number = vec![NONE; second.len()];
        for (r, &at) in others.iter().enumerate() {
            number[at] = r as u32;
        }
        Matching {
            disk,
            width: width as i64,
            height: (first.len() / width) as i64,
            partner_of_first: vec![NONE; pixels.len()],
            partner_of_second: vec![NONE; others.len()],
            layer: vec![NONE; pixels.len()],
            next: vec![0; pixels.len()],
            pixels: pixels.iter().map(|at| [(at % width) as i64, (at / width) as i64]).collect(),
            second: number,
        }
    }

    /// The pixel of the second set at a displacement from one of the first, or `NONE`.
    fn at(&self, l: usize, displacement: usize) -> u32 {
        let ([x, y], [dx, dy]) = (self.pixels[l], self.disk[displacement]);
        let (x, y) = (x + dx, y + dy);
        if x < 0 || y < 0 || x >= self.width || y >= self.height {
            return NONE;
        }
        self.second[(y * self.width + x) as usize]
    }

    fn pair(&mut self, l: usize, r: u32) {
        self.partner_of_first[l] = r;
        self.partner_of_second[r as usize] = l as u32;
    }

    fn pair_nearest(&mut self) {
        for displacement in 0..self.disk.len() {
            for l in 0..self.pixels.len() {
                if self.partner_of_first[l] == NONE {
                    let r = self.at(l, displacement);
                    if r != NONE && self.partner_of_second[r as usize] == NONE {
                        self.pair(l, r);
                    }
                }
            }
        }
    }

    /// Computes the layers up to the first that touches an unmatched pixel of the second set; false if none does.
    fn layers(&mut self) -> bool {
        self.layer.fill(NONE);
        self.next.fill(0);
        let unmatched = |l: &u32| self.partner_of_first[*l as usize] == NONE;
        let mut front: Vec<u32> = (0..self.pixels.len() as u32).filter(unmatched).collect();
        front.iter().for_each(|&l| self.layer[l as usize] = 0);
        let mut depth = 0;
        while !front.is_empty() {
            depth += 1;
            let mut ends = false;
            let mut following = Vec::new();
            for l in front {
                for displacement in 0..self.disk.len() {
                    let r = self.at(l as usize, displacement);
                    if r == NONE {
                        continue;
                    }
                    match self.partner_of_second[r as usize] {
                        NONE => ends = true,
                        partner if self.layer[partner as usize] == NONE => {
                            self.layer[partner as usize] = depth;
                            following.push(partner);
                        }
                        _ => {}
                    }
                }
            }
            if ends {
                return true;
            }
            front = following;
        }
        false
    }

    /// Searches an augmenting path from an unmatched pixel of the first set through increasing layers, and applies it.
    fn augment(&mut self, start: u32) {
        let mut path = vec![start as usize];
        while let Some(&l) = path.last() {
            let displacement = self.next[l];
            if displacement == self.disk.len() {
                path.pop();
                continue;
            }
            self.next[l] += 1;
            let r = self.at(l, displacement);
            if r == NONE {
                continue;
            }
            let partner = self.partner_of_second[r as usize];
            if partner == NONE {
                for &l in &path {
                    let r = self.at(l, self.next[l] - 1);
                    self.pair(l, r);
                }
                return;
            }
            if self.layer[partner as usize] == self.layer[l] + 1 {
                path.push(partner as usize);
            }
        }
    }
}
