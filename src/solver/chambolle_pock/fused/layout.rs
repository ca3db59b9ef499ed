//! What one thread owns: a contiguous range of vertices, every face that touches it, and their other vertices.
//!
//! Faces come in the order of their largest vertex, whichever part they lie in. A face between two ranges lies in
//! both parts and is computed in both, from the same numbers. Its vertices outside the range are ghosts: they move
//! as in their own part, once K^T q is fetched from there.

use std::ops::Range;

/// The lane of each row in a block; how many there are is a power of two.
pub struct Lanes {
    pub order: Vec<usize>,
    shift: u32,
}

impl Lanes {
    pub fn new(order: &[usize]) -> Self {
        assert!(order.len().is_power_of_two());
        Lanes { order: order.to_vec(), shift: order.len().trailing_zeros() }
    }

    pub fn width(&self) -> usize {
        self.order.len()
    }

    /// The block of the i-th row, and its number there.
    #[inline(always)]
    fn block(&self, i: usize) -> (usize, usize) {
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

/// Who lies where in a part, whatever the numbers are.
pub struct Layout {
    pub range: Range<usize>,
    /// Vertices of other parts, ascending; they come before the own ones, in blocks of their own.
    pub ghosts: Vec<u32>,
    /// Ascending by their largest vertex.
    pub faces: Vec<u32>,
    pub lanes: Lanes,
    /// Places of the corners in the rows of vertices, `[block][corner][row]`.
    pub corners: Vec<u32>,
    /// How many blocks of faces are done after each block of vertices.
    pub faces_due: Vec<u32>,
    /// Own vertices whose K^T q goes to the outbox, as places.
    pub sent: Vec<u32>,
    /// For each ghost the part that owns it, and where in its outbox it lies.
    pub sources: Vec<(u32, u32)>,
}

impl Layout {
    /// For the corners of all faces of a mesh.
    pub fn new(
        range: Range<usize>,
        corners: &[[u32; 3]],
        vertices: usize,
        order: &[usize],
    ) -> Self {
        let is_own = |v: u32| range.contains(&(v as usize));
        let corners_of = |j: &u32| corners[*j as usize];
        let faces = faces_at(&range, corners, vertices);
        let mut ghosts: Vec<u32> =
            faces.iter().flat_map(corners_of).filter(|&v| !is_own(v)).collect();
        ghosts.sort_unstable();
        ghosts.dedup();
        let mut layout = Layout {
            range: range.clone(),
            ghosts,
            lanes: Lanes::new(order),
            corners: Vec::new(),
            faces_due: Vec::new(),
            sent: Vec::new(),
            sources: Vec::new(),
            faces,
        };

        let width = order.len();
        let place = |v: u32| match is_own(v) {
            true => layout.place(v as usize),
            false => layout.ghosts.binary_search(&v).expect("corners outside are ghosts"),
        };
        // Faces that only fill up the last block have no weights and lie anywhere.
        let mut corners = vec![0; 3 * width * layout.faces.len().div_ceil(width)];
        let vertex_blocks = layout.own_from() / width + range.len().div_ceil(width);
        let mut faces_due = vec![0; vertex_blocks];
        let mut last = 0;
        for (block, faces) in layout.faces.chunks(width).enumerate() {
            for (o, j) in faces.iter().enumerate() {
                for (c, v) in corners_of(j).into_iter().enumerate() {
                    let place = place(v);
                    corners[(3 * block + c) * width + o] = place as u32;
                    last = last.max(layout.lanes.block(place).0);
                }
            }
            faces_due[last] = block as u32 + 1;
        }
        let mut due = 0;
        for block in &mut faces_due {
            due = due.max(*block);
            *block = due;
        }
        (layout.corners, layout.faces_due) = (corners, faces_due);
        layout
    }

    /// How many vertices and faces there is room for, full blocks of both.
    pub fn room(&self) -> (usize, usize) {
        (self.faces_due.len() * self.lanes.width(), self.corners.len() / 3)
    }

    /// The place of the first own vertex: ghosts come first, then a block begins.
    pub fn own_from(&self) -> usize {
        self.ghosts.len().next_multiple_of(self.lanes.width())
    }

    /// The place of an own vertex.
    #[inline(always)]
    pub fn place(&self, v: usize) -> usize {
        self.own_from() + v - self.range.start
    }

    /// Every place that has a vertex, and that vertex.
    #[inline(always)]
    pub fn each_place(&self, mut work: impl FnMut(usize, usize)) {
        for (place, &v) in self.ghosts.iter().enumerate() {
            work(place, v as usize);
        }
        for (place, v) in (self.own_from()..).zip(self.range.clone()) {
            work(place, v);
        }
    }

    /// Every place that only fills up a block.
    pub fn each_gap(&self, work: impl FnMut(usize)) {
        let behind = self.own_from() + self.range.len()..self.room().0;
        (self.ghosts.len()..self.own_from()).chain(behind).for_each(work);
    }
}

/// The last of its vertices.
pub fn last(corners: &[u32; 3]) -> usize {
    let [a, b, c] = *corners;
    a.max(b).max(c) as usize
}

/// The faces with a vertex in the range, by counting sort in the order of their last vertex.
fn faces_at(range: &Range<usize>, corners: &[[u32; 3]], vertices: usize) -> Vec<u32> {
    let is_own = |&v: &u32| (v as usize).wrapping_sub(range.start) < range.len();
    let touches = |corners: &[u32; 3]| corners.iter().any(is_own);
    let mut start = vec![0_u32; vertices + 1];
    for corners in corners.iter().filter(|corners| touches(corners)) {
        start[last(corners) + 1] += 1;
    }
    let mut sum = 0;
    for start in &mut start {
        sum += *start;
        *start = sum;
    }
    let mut faces = vec![0; sum as usize];
    for (j, corners) in corners.iter().enumerate().filter(|(_, corners)| touches(corners)) {
        let place = &mut start[last(corners)];
        faces[*place as usize] = j as u32;
        *place += 1;
    }
    faces
}

/// Tells each part which of its vertices the others need, and where they find those of others.
pub fn connect(parts: &mut [Layout]) {
    for owner in 0..parts.len() {
        let range = parts[owner].range.clone();
        let is_own = |v: &u32| range.contains(&(*v as usize));
        let mut wanted: Vec<u32> =
            parts.iter().flat_map(|part| &part.ghosts).copied().filter(is_own).collect();
        wanted.sort_unstable();
        wanted.dedup();
        let own_from = parts[owner].own_from();
        let place = |&v: &u32| (own_from + v as usize - range.start) as u32;
        parts[owner].sent = wanted.iter().map(place).collect();
        for part in &mut *parts {
            part.sources.resize(part.ghosts.len(), (0, 0));
            for (source, ghost) in part.sources.iter_mut().zip(&part.ghosts) {
                if let Ok(letter) = wanted.binary_search(ghost) {
                    *source = (owner as u32, letter as u32);
                }
            }
        }
    }
}
