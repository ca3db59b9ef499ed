//! Vertices within a tolerance, by a grid in O(V) time: vertices in one cell of side tolerance / sqrt(3) are merged
//! without comparison, and blocks of 4 x 4 x 4 cells are hashed, so that the at most 124 cells around another one are
//! in eight blocks.
//!
//! Reference: J. L. Bentley, D. F. Stanat, E. H. Williams, *The complexity of finding fixed-radius near neighbors*,
//! Information Processing Letters 6(6), 1977.

use nalgebra::Point3;

use super::referenced;
use super::table::{Table, hash};
use crate::mesh::Mesh;
use crate::mesh::disjoint_sets::DisjointSets;

/// For each vertex the first one of its class of vertices within a tolerance.
pub fn near(mesh: &Mesh, exact: Option<Vec<u32>>, tolerance: f64) -> Vec<u32> {
    let vertices = mesh.vertices.len() as u32;
    let mut joined = DisjointSets::new(mesh.vertices.len());
    for (v, &first) in (0..).zip(exact.iter().flatten()) {
        joined.join(v, first);
    }
    let referenced = referenced(mesh);
    let mut grid = Grid::new(&mesh.vertices, tolerance);
    for v in (0..vertices).filter(|&v| referenced[v as usize]) {
        if exact.as_ref().is_none_or(|first| first[v as usize] == v) {
            grid.add(v, &mut joined);
        }
    }
    grid.join_neighbors(&mut joined);
    (0..vertices).map(|v| joined.root(v)).collect()
}

/// The side of a cell divided by the tolerance: slightly below 1 / sqrt(3), for rounding.
const CELL_SIDE: f64 = 0.577;

/// The maximum number of cells along half an axis, so that their indices are exact.
const MAX_CELLS: f64 = (1_u64 << 40) as f64;

/// No vertex or cell.
const ABSENT: u32 = u32::MAX;

/// Points in cells, and cells in blocks of 4 x 4 x 4.
struct Grid<'a> {
    points: &'a [Point3<f64>],
    tolerance: f64,
    side: f64,
    cells: Vec<Cell>,
    /// The first cell of each block.
    blocks: Table,
    /// The next vertex of the same cell.
    next: Vec<u32>,
}

struct Cell {
    index: [i64; 3],
    /// Its first vertex, and its last so far.
    first: u32,
    last: u32,
    /// The next cell of the same block, [`ABSENT`] at the last.
    next: u32,
}

impl Cell {
    fn block(&self) -> [i64; 3] {
        self.index.map(|i| i >> 2)
    }
}

impl<'a> Grid<'a> {
    fn new(points: &'a [Point3<f64>], tolerance: f64) -> Self {
        let largest = points.iter().map(|x| x.coords.amax()).fold(0.0, f64::max);
        Grid {
            points,
            tolerance,
            side: (CELL_SIDE * tolerance).max(largest / MAX_CELLS),
            cells: Vec::new(),
            blocks: Table::for_at_most(points.len()),
            next: vec![ABSENT; points.len()],
        }
    }

    fn points_of(&self, cell: u32) -> impl Iterator<Item = &'a Point3<f64>> + '_ {
        let chain = |&v: &u32| Some(self.next[v as usize]).filter(|&v| v != ABSENT);
        let vertices = std::iter::successors(Some(self.cells[cell as usize].first), chain);
        vertices.map(|v| &self.points[v as usize])
    }

    /// The cells of a block.
    fn cells_of(&self, block: [i64; 3]) -> impl Iterator<Item = u32> + '_ {
        let chain =
            |&cell: &u32| Some(self.cells[cell as usize].next).filter(|&cell| cell != ABSENT);
        let same = |cell: u32| self.cells[cell as usize].block() == block;
        std::iter::successors(self.blocks.find(hash_of(block), same), chain)
    }

    /// Adds a vertex and joins it with those in its cell.
    fn add(&mut self, v: u32, joined: &mut DisjointSets) {
        let x = self.points[v as usize];
        let index = [x.x, x.y, x.z].map(|x| (x / self.side).floor() as i64);
        let block = index.map(|i| i >> 2);
        let same = |&cell: &u32| self.cells[cell as usize].index == index;
        let found = self.cells_of(block).find(same);
        if let Some(cell) = found {
            return self.add_to(cell, v, joined);
        }
        let end = self.cells_of(block).last();
        let new = self.cells.len() as u32;
        self.cells.push(Cell { index, first: v, last: v, next: ABSENT });
        match end {
            Some(end) => self.cells[end as usize].next = new,
            None => {
                self.blocks.find_or_insert(hash_of(block), new, |_| false);
            }
        }
    }

    fn add_to(&mut self, cell: u32, v: u32, joined: &mut DisjointSets) {
        let x = &self.points[v as usize];
        if self.side <= CELL_SIDE * self.tolerance {
            joined.join(v, self.cells[cell as usize].first);
        } else {
            // The smallest possible cell is wider than the tolerance; it rarely contains two vertices.
            let mut w = self.cells[cell as usize].first;
            while w != ABSENT {
                if (x - self.points[w as usize]).norm() <= self.tolerance {
                    joined.join(v, w);
                }
                w = self.next[w as usize];
            }
        }
        let last = std::mem::replace(&mut self.cells[cell as usize].last, v);
        self.next[last as usize] = v;
    }

    /// Joins vertices of different cells within the tolerance.
    fn join_neighbors(&self, joined: &mut DisjointSets) {
        for (cell, this) in (0..).zip(&self.cells) {
            // Along an axis, cells up to two steps away are in two blocks.
            let blocks = this.index.map(|i| [(i - 2) >> 2, (i + 2) >> 2]);
            for corner in 0..8 {
                let block = [0, 1, 2].map(|axis| blocks[axis][corner >> axis & 1]);
                for other in self.cells_of(block).filter(|&other| other > cell) {
                    let there = &self.cells[other as usize];
                    let far = |axis: usize| (there.index[axis] - this.index[axis]).abs() > 2;
                    if !(0..3).any(far)
                        && joined.root(this.first) != joined.root(there.first)
                        && self.touch(cell, other)
                    {
                        joined.join(this.first, there.first);
                    }
                }
            }
        }
    }

    /// Whether a vertex of one cell is within the tolerance of a vertex of the other.
    fn touch(&self, cell: u32, other: u32) -> bool {
        let Some(&first) = self.points_of(other).next() else { return false };
        let bounds =
            self.points_of(other).fold((first, first), |(low, high), x| (low.inf(x), high.sup(x)));
        let near_bounds =
            |x: &Point3<f64>| (x - x.sup(&bounds.0).inf(&bounds.1)).norm() <= self.tolerance;
        self.points_of(cell)
            .filter(|x| near_bounds(x))
            .any(|x| self.points_of(other).any(|y| (x - y).norm() <= self.tolerance))
    }
}

fn hash_of(index: [i64; 3]) -> u64 {
    hash(index.map(i64::cast_unsigned))
}
