//! Who lies where, in blocks of as many vertices or faces as a vector has lanes, and what has to wait for what.
//!
//! Vertices come in the order of the mesh, faces in the order of their last vertex. A face is due as soon as that
//! vertex has moved; a vertex may move again as soon as all its faces are done. Where neighbors have near numbers,
//! the next iteration so follows a few blocks behind.

use std::ops::Range;

use crate::mesh::order::sorted_by;
use crate::sweep::{collect, ranges, results};

/// A part may compute so much of what others own again, as a share of what it owns.
const LARGEST_BORDER: f64 = 0.125;

/// So many numbers make a row of what is gathered.
pub const ROW: usize = 4;

/// The lane of each row in a block; how many there are is a power of two.
#[derive(Clone)]
pub struct Lanes {
    pub order: Vec<usize>,
    shift: u32,
}

impl Lanes {
    pub fn new(order: Vec<usize>) -> Self {
        assert!(order.len().is_power_of_two());
        Lanes { shift: order.len().trailing_zeros(), order }
    }

    pub fn width(&self) -> usize {
        self.order.len()
    }

    /// The block of the i-th row, and its number there.
    #[inline(always)]
    pub fn block(&self, i: usize) -> (usize, usize) {
        (i >> self.shift, i & (self.order.len() - 1))
    }

    /// Where the first entry of the i-th row lies, if rows have `entries`; the next ones follow at a distance of
    /// the width.
    #[inline(always)]
    pub fn first(&self, i: usize, entries: usize) -> usize {
        let (block, row) = self.block(i);
        ((block * entries) << self.shift) + self.order[row]
    }
}

/// The order of a whole mesh, and what waits for what, block by block.
pub struct Layout {
    pub lanes: Lanes,
    /// Ascending by their last vertex.
    pub faces: Vec<u32>,
    /// How many blocks of faces are due after each block of vertices.
    due: Vec<u32>,
    /// The last block of vertices that must have moved before all faces at this block, and at those before it, are
    /// done.
    until: Vec<u32>,
    /// The first block of vertices at the faces that end in this block or behind it.
    from: Vec<u32>,
    /// So many blocks of faces are done at the most from the first one at a block of vertices to the last.
    pub ring: usize,
}

/// What the faces say about each block of vertices: `due`, `until` and `from` of [`Layout`], of these blocks alone.
struct Seen {
    due: Vec<u32>,
    until: Vec<u32>,
    from: Vec<u32>,
    /// The first block of faces at it.
    met: Vec<u32>,
}

impl Seen {
    fn nothing(blocks: usize) -> Self {
        let numbers: Vec<u32> = (0..blocks as u32).collect();
        Seen {
            due: vec![0; blocks],
            until: numbers.clone(),
            from: numbers,
            met: vec![u32::MAX; blocks],
        }
    }

    fn and(mut self, other: Self) -> Self {
        let each = |a: &mut [u32], b: &[u32], of: fn(u32, u32) -> u32| {
            a.iter_mut().zip(b).for_each(|(a, &b)| *a = of(*a, b));
        };
        each(&mut self.due, &other.due, Ord::max);
        each(&mut self.until, &other.until, Ord::max);
        each(&mut self.from, &other.from, Ord::min);
        each(&mut self.met, &other.met, Ord::min);
        self
    }
}

impl Layout {
    /// For the corners of all faces of a mesh.
    pub fn new(corners: &[[u32; 3]], vertices: usize, lanes: Lanes) -> Self {
        let last_vertex = |j: usize| last(&corners[j]) as u32;
        let faces = sorted_by(&collect(corners.len(), last_vertex), vertices);
        let width = lanes.width();
        let count = vertices.div_ceil(width);
        let block = |v: usize| lanes.block(v).0;
        // Each thread some of the blocks of faces; the first and the last of what any of them saw counts.
        let cuts = ranges(faces.len().div_ceil(width));
        let seen = results(cuts.windows(2).map(|cut| cut[0]..cut[1]).collect(), |range| {
            let mut seen = Seen::nothing(count);
            // Backwards: the first block of faces at a vertex is the last that is written.
            for i in range.rev() {
                let (mut begins, mut ends) = (count, 0);
                for &j in &faces[i * width..faces.len().min((i + 1) * width)] {
                    let corners = &corners[j as usize];
                    let begin = block(first(corners));
                    ends = block(last(corners));
                    seen.from[ends] = seen.from[ends].min(begin as u32);
                    begins = begins.min(begin);
                    for &v in corners {
                        seen.met[block(v as usize)] = i as u32;
                    }
                }
                seen.due[ends] = seen.due[ends].max(i as u32 + 1);
                seen.until[begins] = seen.until[begins].max(ends as u32);
            }
            seen
        });
        let Seen { mut due, mut until, mut from, met } =
            seen.into_iter().reduce(Seen::and).unwrap_or_else(|| Seen::nothing(count));
        for b in 1..count {
            due[b] = due[b].max(due[b - 1]);
            until[b] = until[b].max(until[b - 1]);
        }
        for b in (1..count).rev() {
            from[b - 1] = from[b - 1].min(from[b]);
        }
        let done = |b: usize| due[until[b] as usize].saturating_sub(met[b]) as usize;
        let ring = (0..count).map(done).max().unwrap_or(0);
        Layout { lanes, faces, due, until, from, ring }
    }

    /// Blocks of vertices.
    pub fn blocks(&self) -> usize {
        self.due.len()
    }

    /// How many blocks of faces are due before this block of vertices moves.
    #[inline(always)]
    pub fn due_before(&self, block: usize) -> usize {
        if block == 0 { 0 } else { self.due[block - 1] as usize }
    }

    /// Whether all faces at a block of vertices are done, once all blocks before `moved` have moved.
    #[inline(always)]
    pub fn is_done(&self, block: usize, moved: usize) -> bool {
        (self.until[block] as usize) < moved
    }

    /// How many blocks an iteration is behind the one before it, in the mean.
    pub fn lag(&self) -> f64 {
        let lag = |(b, &until): (usize, &u32)| f64::from(until) - b as f64;
        self.until.iter().enumerate().map(lag).sum::<f64>() / self.blocks().max(1) as f64
    }

    /// What `count` threads with about the same work hold, for passes of up to `deepest` iterations, or of half as many
    /// as often as the borders are too wide.
    pub fn windows(&self, corners: &[[u32; 3]], count: usize, deepest: usize) -> Vec<Window> {
        // A vertex costs about half as much as a face.
        let work: Vec<usize> = (0..=self.blocks()).map(|b| 2 * self.due_before(b) + b).collect();
        let all = work[self.blocks()];
        let mut cuts: Vec<usize> =
            (0..=count).map(|k| work.partition_point(|&work| work < all * k / count)).collect();
        cuts.dedup();
        let own: Vec<Range<usize>> = cuts.windows(2).map(|cut| cut[0]..cut[1]).collect();
        let reaches = |depth| -> Vec<_> {
            own.iter().map(|own| (own.clone(), self.reach(corners, own, depth))).collect()
        };
        let is_narrow = |(own, reach): &(Range<usize>, Vec<Range<usize>>)| {
            let held = reach[reach.len() - 1].len();
            held as f64 <= (1.0 + LARGEST_BORDER) * own.len() as f64
        };
        let mut depth = deepest;
        while depth > 1 && !reaches(depth).iter().all(is_narrow) {
            depth /= 2;
        }
        results(reaches(depth), |(own, reach)| self.window(corners, own, reach))
    }

    /// [`Window::reach`].
    fn reach(&self, corners: &[[u32; 3]], own: &Range<usize>, depth: usize) -> Vec<Range<usize>> {
        // The first block of faces may begin with some that end before the first own vertex.
        let first = self.faces.get(self.due_before(own.start) * self.lanes.width());
        let begins = match first {
            Some(&j) => self.lanes.block(last(&corners[j as usize])).0.min(own.start),
            None => own.start,
        };
        let mut reach = Vec::with_capacity(depth + 1);
        reach.push(begins..own.end);
        for k in 0..depth {
            let Range { start, end } = reach[k];
            reach.push(self.from[start] as usize..self.until[end - 1] as usize + 1);
        }
        reach
    }

    fn window(&self, corners: &[[u32; 3]], own: Range<usize>, reach: Vec<Range<usize>>) -> Window {
        let width = self.lanes.width();
        let own_faces = self.due_before(own.start)..self.due_before(own.end);
        let vertices = reach[reach.len() - 1].clone();
        let held_faces = self.due_before(vertices.start)..self.due_before(vertices.end);
        let held = width * vertices.start..width * vertices.end;
        // Else the begins of rows are no u32.
        assert!(ROW * held.len().max(3 * self.ring * width) < u32::MAX as usize);
        let mut faces = vec![NO_FACE; held_faces.len() * width];
        let mut places = vec![0; 3 * faces.len()];
        let mut degree = vec![0_u32; held.len()];
        let end = self.faces.len().min(held_faces.end * width);
        for (i, &j) in self.faces[held_faces.start * width..end].iter().enumerate() {
            let corners = &corners[j as usize];
            if corners.iter().all(|&v| held.contains(&(v as usize))) {
                faces[i] = j;
                let (block, row) = self.lanes.block(i);
                for (c, v) in corners.iter().enumerate() {
                    let place = v - held.start as u32;
                    places[(3 * block + c) * width + row] = ROW as u32 * place;
                    degree[place as usize] += 1;
                }
            }
        }
        let rows_at = self.rows_at(&faces, &places, degree);
        Window { own, own_faces, reach, held_faces, faces, places, rows_at }
    }

    /// Where the faces at each vertex leave what they add to it, by how many faces there are.
    fn rows_at(&self, faces: &[u32], places: &[u32], mut degree: Vec<u32>) -> RowsAt {
        let width = self.lanes.width();
        let mut start = Vec::with_capacity(degree.len() / width + 1);
        start.push(0);
        let mut length = 0;
        for degree in degree.chunks_mut(width) {
            let most = degree.iter().copied().max().unwrap_or(0) as usize;
            // From here on the entry of a vertex is where the next of its faces goes.
            for (row, next) in degree.iter_mut().enumerate() {
                *next = (length + row) as u32;
            }
            length += width * most;
            start.push(length);
        }
        // Else they are no u32.
        assert!(length < u32::MAX as usize);
        let mut next = degree;
        let nothing = (ROW * self.ring * 3 * width) as u32;
        let mut rows = vec![nothing; length];
        let blocks = faces.chunks_exact(width).zip(places.chunks_exact(3 * width));
        for (block, (faces, places)) in blocks.enumerate() {
            let first = ROW * (block % self.ring * 3 * width);
            for (row, _) in faces.iter().enumerate().filter(|(_, j)| **j != NO_FACE) {
                for c in 0..3 {
                    let next = &mut next[places[c * width + row] as usize / ROW];
                    rows[*next as usize] = (first + ROW * (c * width + row)) as u32;
                    *next += width as u32;
                }
            }
        }
        RowsAt { start, rows }
    }
}

/// What one thread holds: the blocks that it owns, and those around them that it computes again, so that a pass of
/// several iterations asks no other thread for anything.
pub struct Window {
    /// Blocks of vertices.
    pub own: Range<usize>,
    /// Blocks of faces.
    pub own_faces: Range<usize>,
    /// `reach[k]`: the blocks of vertices whose u and K^T q must be right where k more iterations follow, for the own
    /// ones to be right after them.
    pub reach: Vec<Range<usize>>,
    /// Blocks of faces.
    pub held_faces: Range<usize>,
    /// The faces that are held, [`NO_FACE`] where a block is not full. A face with a corner that is not held is none.
    pub faces: Vec<u32>,
    /// Where their corners begin in rows of the vertices that are held, `[block][corner][row]`.
    pub places: Vec<u32>,
    pub rows_at: RowsAt,
}

/// For each vertex where the rows `[block of the ring][corner][row]` of its faces begin, in their order, filled up with
/// one that lies behind all.
pub struct RowsAt {
    /// For each block of vertices, and the end.
    start: Vec<usize>,
    /// `[block][face at the vertex][row]`
    rows: Vec<u32>,
}

impl RowsAt {
    /// For so many rows in all.
    pub fn all_within(&self, length: usize) -> bool {
        all_within(&self.rows, length)
    }

    #[inline(always)]
    pub fn block(&self, block: usize) -> &[u32] {
        &self.rows[self.start[block]..self.start[block + 1]]
    }
}

/// Whether all rows that begin there are among so many.
pub fn all_within(begins: &[u32], length: usize) -> bool {
    let last = begins.iter().copied().max();
    last.is_none_or(|last| last as usize + ROW <= ROW * length)
}

/// Fills up blocks: has no weights, and lies anywhere.
pub const NO_FACE: u32 = u32::MAX;

impl Window {
    /// The blocks of vertices that are held.
    pub fn vertices(&self) -> Range<usize> {
        self.reach[self.depth()].clone()
    }

    /// How many iterations a pass may make.
    pub fn depth(&self) -> usize {
        self.reach.len() - 1
    }

    /// Every face that is held, with its place.
    #[inline(always)]
    pub fn each_face(&self, mut work: impl FnMut(usize, usize)) {
        for (i, &j) in self.faces.iter().enumerate() {
            if j != NO_FACE {
                work(i, j as usize);
            }
        }
    }
}

/// The first of its vertices.
fn first(corners: &[u32; 3]) -> usize {
    let [a, b, c] = *corners;
    a.min(b).min(c) as usize
}

/// The last of its vertices.
fn last(corners: &[u32; 3]) -> usize {
    let [a, b, c] = *corners;
    a.max(b).max(c) as usize
}
