//! The order of vertices and faces, in blocks of as many as a vector has lanes, and the dependencies between blocks.
//!
//! Vertices keep the order of the mesh; faces are sorted by their last vertex. A face is due as soon as that vertex has
//! moved; a vertex may move again as soon as all its faces are done. If neighbors have nearby numbers, the next
//! iteration therefore follows a few blocks behind.

use std::ops::Range;

use crate::mesh::order::sorted_by;
use crate::sweep::{collect, ranges, results};

/// The largest border of a part, the blocks of other parts that it computes as well, as a fraction of its own blocks.
const MAX_BORDER_FRACTION: f64 = 0.125;

/// The number of regions in a group, whose numbers lie next to each other and are gathered at once.
pub const GROUP: usize = 4;

/// The lane order of a block: the lane of each position. The number of lanes is a power of two.
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

    /// The block of the i-th vertex or face, and its position there.
    #[inline(always)]
    pub fn block(&self, i: usize) -> (usize, usize) {
        (i >> self.shift, i & (self.order.len() - 1))
    }

    /// The index of the first entry of the i-th vertex or face, if each has `entries`; the next ones follow at a
    /// distance of the width.
    #[inline(always)]
    pub fn first(&self, i: usize, entries: usize) -> usize {
        let (block, position) = self.block(i);
        ((block * entries) << self.shift) + self.order[position]
    }
}

/// The order of the faces of a whole mesh, and the dependencies between its blocks.
pub struct BlockLayout {
    pub lanes: Lanes,
    /// All faces, ascending by their last vertex.
    pub faces: Vec<u32>,
    /// For each block of vertices, how many blocks of faces are due once it has moved.
    due: Vec<u32>,
    /// For each block of vertices, the last block of vertices that must have moved before all faces at it, and at those
    /// before it, are done.
    done_after: Vec<u32>,
    /// For each block of vertices, the first one with a corner of a face whose last vertex lies in this block or behind
    /// it.
    first_corner_block: Vec<u32>,
    /// The largest number of blocks of faces from the first one at a block of vertices to the last one that is due
    /// before its faces are done. As many blocks of shares are kept, in a ring.
    pub ring_length: usize,
}

/// The dependencies that some blocks of faces cause, for each block of vertices. `due`, `done_after` and
/// `first_corner_block` become those of [`BlockLayout`] once they are accumulated over the blocks of vertices.
struct Dependencies {
    due: Vec<u32>,
    done_after: Vec<u32>,
    first_corner_block: Vec<u32>,
    /// The first block of faces with a corner in it.
    first_face_block: Vec<u32>,
}

impl Dependencies {
    fn none(blocks: usize) -> Self {
        let itself: Vec<u32> = (0..blocks as u32).collect();
        Dependencies {
            due: vec![0; blocks],
            done_after: itself.clone(),
            first_corner_block: itself,
            first_face_block: vec![u32::MAX; blocks],
        }
    }

    fn merged_with(mut self, other: Self) -> Self {
        let each = |a: &mut [u32], b: &[u32], pick: fn(u32, u32) -> u32| {
            a.iter_mut().zip(b).for_each(|(a, &b)| *a = pick(*a, b));
        };
        each(&mut self.due, &other.due, Ord::max);
        each(&mut self.done_after, &other.done_after, Ord::max);
        each(&mut self.first_corner_block, &other.first_corner_block, Ord::min);
        each(&mut self.first_face_block, &other.first_face_block, Ord::min);
        self
    }
}

impl BlockLayout {
    /// For the corners of all faces of a mesh.
    pub fn new(corners: &[[u32; 3]], vertices: usize, lanes: Lanes) -> Self {
        let last_of_face = |j: usize| last_vertex(&corners[j]) as u32;
        let faces = sorted_by(&collect(corners.len(), last_of_face), vertices);
        let width = lanes.width();
        let count = vertices.div_ceil(width);
        let block = |v: usize| lanes.block(v).0;
        // Each thread visits some of the blocks of faces; the extremes over all threads count.
        let cuts = ranges(faces.len().div_ceil(width));
        let dependencies = results(cuts.windows(2).map(|cut| cut[0]..cut[1]).collect(), |range| {
            let mut dependencies = Dependencies::none(count);
            // In reverse order, so that the first block of faces at a vertex is written last.
            for i in range.rev() {
                let (mut begins, mut ends) = (count, 0);
                for &j in &faces[i * width..faces.len().min((i + 1) * width)] {
                    let corners = &corners[j as usize];
                    let begin = block(first_vertex(corners));
                    ends = block(last_vertex(corners));
                    dependencies.first_corner_block[ends] =
                        dependencies.first_corner_block[ends].min(begin as u32);
                    begins = begins.min(begin);
                    for &v in corners {
                        dependencies.first_face_block[block(v as usize)] = i as u32;
                    }
                }
                dependencies.due[ends] = dependencies.due[ends].max(i as u32 + 1);
                dependencies.done_after[begins] = dependencies.done_after[begins].max(ends as u32);
            }
            dependencies
        });
        let Dependencies { mut due, mut done_after, mut first_corner_block, first_face_block } =
            dependencies
                .into_iter()
                .reduce(Dependencies::merged_with)
                .unwrap_or_else(|| Dependencies::none(count));
        for b in 1..count {
            due[b] = due[b].max(due[b - 1]);
            done_after[b] = done_after[b].max(done_after[b - 1]);
        }
        for b in (1..count).rev() {
            first_corner_block[b - 1] = first_corner_block[b - 1].min(first_corner_block[b]);
        }
        let done =
            |b: usize| due[done_after[b] as usize].saturating_sub(first_face_block[b]) as usize;
        let ring_length = (0..count).map(done).max().unwrap_or(0);
        BlockLayout { lanes, faces, due, done_after, first_corner_block, ring_length }
    }

    /// The number of blocks of vertices.
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
        (self.done_after[block] as usize) < moved
    }

    /// How many blocks an iteration lags behind the one before it, on average.
    pub fn lag(&self) -> f64 {
        let lag = |(b, &done_after): (usize, &u32)| f64::from(done_after) - b as f64;
        self.done_after.iter().enumerate().map(lag).sum::<f64>() / self.blocks().max(1) as f64
    }

    /// The windows of up to `count` threads with about the same work. A pass makes up to `max_depth` iterations; that
    /// number is halved until the borders are narrow enough.
    pub fn windows(&self, corners: &[[u32; 3]], count: usize, max_depth: usize) -> Vec<Window> {
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
            held as f64 <= (1.0 + MAX_BORDER_FRACTION) * own.len() as f64
        };
        let mut depth = max_depth;
        while depth > 1 && !reaches(depth).iter().all(is_narrow) {
            depth /= 2;
        }
        results(reaches(depth), |(own, reach)| self.window(corners, own, reach))
    }

    /// See [`Window::reach`].
    fn reach(&self, corners: &[[u32; 3]], own: &Range<usize>, depth: usize) -> Vec<Range<usize>> {
        // The first block of faces may begin with some whose last vertex comes before the first own one.
        let first_face = self.faces.get(self.due_before(own.start) * self.lanes.width());
        let start = match first_face {
            Some(&j) => self.lanes.block(last_vertex(&corners[j as usize])).0.min(own.start),
            None => own.start,
        };
        let mut reach = Vec::with_capacity(depth + 1);
        reach.push(start..own.end);
        for k in 0..depth {
            let Range { start, end } = reach[k];
            reach.push(
                self.first_corner_block[start] as usize..self.done_after[end - 1] as usize + 1,
            );
        }
        reach
    }

    fn window(&self, corners: &[[u32; 3]], own: Range<usize>, reach: Vec<Range<usize>>) -> Window {
        let width = self.lanes.width();
        let own_faces = self.due_before(own.start)..self.due_before(own.end);
        let vertices = reach[reach.len() - 1].clone();
        let held_faces = self.due_before(vertices.start)..self.due_before(vertices.end);
        let held = width * vertices.start..width * vertices.end;
        // All offsets of groups fit into a u32.
        assert!(GROUP * held.len().max(3 * self.ring_length * width) < u32::MAX as usize);
        let mut faces = vec![NO_FACE; held_faces.len() * width];
        let mut corner_offsets = vec![0; 3 * faces.len()];
        let mut degree = vec![0_u32; held.len()];
        let end = self.faces.len().min(held_faces.end * width);
        for (i, &j) in self.faces[held_faces.start * width..end].iter().enumerate() {
            let corners = &corners[j as usize];
            if corners.iter().all(|&v| held.contains(&(v as usize))) {
                faces[i] = j;
                let (block, position) = self.lanes.block(i);
                for (c, v) in corners.iter().enumerate() {
                    let slot = v - held.start as u32;
                    corner_offsets[(3 * block + c) * width + position] = GROUP as u32 * slot;
                    degree[slot as usize] += 1;
                }
            }
        }
        let share_offsets = self.share_offsets(&faces, &corner_offsets, degree);
        Window { own, own_faces, reach, held_faces, faces, corner_offsets, share_offsets }
    }

    /// Where the faces at each vertex leave their shares of K^T q; `degree` is the number of faces at each vertex.
    fn share_offsets(
        &self,
        faces: &[u32],
        corner_offsets: &[u32],
        mut degree: Vec<u32>,
    ) -> ShareOffsets {
        let width = self.lanes.width();
        let mut start = Vec::with_capacity(degree.len() / width + 1);
        start.push(0);
        let mut length = 0;
        for degree in degree.chunks_mut(width) {
            let max_degree = degree.iter().copied().max().unwrap_or(0) as usize;
            // From here on the entry of a vertex is the index at which the offset of its next face goes.
            for (position, next) in degree.iter_mut().enumerate() {
                *next = (length + position) as u32;
            }
            length += width * max_degree;
            start.push(length);
        }
        // All these indices fit into a u32.
        assert!(length < u32::MAX as usize);
        let mut next = degree;
        let zeros = (GROUP * self.ring_length * 3 * width) as u32;
        let mut offsets = vec![zeros; length];
        let blocks = faces.chunks_exact(width).zip(corner_offsets.chunks_exact(3 * width));
        for (block, (faces, corner_offsets)) in blocks.enumerate() {
            let first = GROUP * (block % self.ring_length * 3 * width);
            for (position, _) in faces.iter().enumerate().filter(|(_, j)| **j != NO_FACE) {
                for c in 0..3 {
                    let next = &mut next[corner_offsets[c * width + position] as usize / GROUP];
                    offsets[*next as usize] = (first + GROUP * (c * width + position)) as u32;
                    *next += width as u32;
                }
            }
        }
        ShareOffsets { start, offsets }
    }
}

/// What one thread holds: the blocks that it owns, and a border of blocks that it computes as well, so that it needs
/// nothing from other threads during a pass of several iterations.
pub struct Window {
    /// The blocks of vertices that are owned.
    pub own: Range<usize>,
    /// The blocks of faces that are owned.
    pub own_faces: Range<usize>,
    /// `reach[k]`: the blocks of vertices whose u and K^T q must be right when k more iterations follow, for the own
    /// ones to be right after them.
    pub reach: Vec<Range<usize>>,
    /// The blocks of faces that are held.
    pub held_faces: Range<usize>,
    /// The faces that are held; [`NO_FACE`] for padding, and for faces with a corner that is not held.
    pub faces: Vec<u32>,
    /// GROUP times the slot of each corner among the vertices that are held, `[block][corner][position]`: the offset of
    /// its first group, in an array with one group per vertex.
    pub corner_offsets: Vec<u32>,
    pub share_offsets: ShareOffsets,
}

/// For each vertex, the offsets of the shares of its faces in `[block of the ring][corner][position]`, in the order of
/// the faces. Vertices with fewer faces than others of their block are padded with the offset of zeros behind the ring.
pub struct ShareOffsets {
    /// Where each block of vertices starts, and the end.
    start: Vec<usize>,
    /// `[block][face at the vertex][position]`
    offsets: Vec<u32>,
}

impl ShareOffsets {
    /// Whether all shares lie within an array of the given number of groups.
    pub fn all_within(&self, groups: usize) -> bool {
        all_within(&self.offsets, groups)
    }

    #[inline(always)]
    pub fn block(&self, block: usize) -> &[u32] {
        &self.offsets[self.start[block]..self.start[block + 1]]
    }
}

/// Whether the groups at these offsets lie within an array of the given number of groups.
pub fn all_within(offsets: &[u32], groups: usize) -> bool {
    let last = offsets.iter().copied().max();
    last.is_none_or(|last| last as usize + GROUP <= GROUP * groups)
}

/// Padding of blocks of faces. Its weights and the offsets of its corners are zero.
pub const NO_FACE: u32 = u32::MAX;

impl Window {
    /// The blocks of vertices that are held.
    pub fn held_vertices(&self) -> Range<usize> {
        self.reach[self.depth()].clone()
    }

    /// The largest number of iterations of a pass.
    pub fn depth(&self) -> usize {
        self.reach.len() - 1
    }

    /// Calls `work(i, j)` for every face j that is held, i its slot.
    #[inline(always)]
    pub fn each_face(&self, mut work: impl FnMut(usize, usize)) {
        for (i, &j) in self.faces.iter().enumerate() {
            if j != NO_FACE {
                work(i, j as usize);
            }
        }
    }
}

/// The first vertex of a face.
fn first_vertex(corners: &[u32; 3]) -> usize {
    let [a, b, c] = *corners;
    a.min(b).min(c) as usize
}

/// The last vertex of a face.
fn last_vertex(corners: &[u32; 3]) -> usize {
    let [a, b, c] = *corners;
    a.max(b).max(c) as usize
}
