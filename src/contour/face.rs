//! The cells {x : u_p(x) is the largest} of one face, exactly, for functions u_p that are linear on the face and integers at
//! its corners.
//!
//! A node is a point in homogeneous barycentric coordinates w. It is a corner, a zero of u_q - u_p on an edge, or the common
//! zero of two differences, w = (u_r - u_p) x (u_q - u_p). Regions are inserted one after the other: the sign of u_q - u_p at
//! a node of cell p is that of sum_i w_i (u_q - u_p)_i, and u_q - max_p u_p is concave, so that region q wins somewhere iff it
//! wins at a node, and takes one convex part of each cell. With integers of 42 bits all signs are exact in 128 bits. A tie
//! changes nothing, so that the first of equal regions wins.

/// Homogeneous barycentric coordinates: not negative, of positive sum.
pub type Node = [i128; 3];

/// Values at the corners are integers from 0 to 2^BITS.
pub const BITS: u32 = 41;

/// What is on the other side of an edge of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Another face: the edge is part of that opposite to a corner.
    Border(usize),
    /// The cell of another region.
    Region(usize),
}

/// A convex polygon.
#[derive(Clone, Debug)]
pub struct Cell {
    pub region: usize,
    /// The nodes in the orientation of the face, each with the side of the edge to the next one.
    pub corners: Vec<(usize, Side)>,
}

/// The cells of a face; regions that are the largest at no inner point have none.
pub struct Partition {
    pub nodes: Vec<Node>,
    pub cells: Vec<Cell>,
}

impl Partition {
    /// The cells of m regions, whose values at the corners are `value(corner, region)`.
    pub fn new(m: usize, value: impl Fn(usize, usize) -> i64) -> Self {
        let border = |i| (i, Side::Border((i + 2) % 3));
        let corners = vec![border(0), border(1), border(2)];
        let mut partition = Partition {
            nodes: vec![[1, 0, 0], [0, 1, 0], [0, 0, 1]],
            cells: vec![Cell { region: 0, corners }],
        };
        let difference = |q: usize, p: usize| {
            std::array::from_fn::<i128, 3, _>(|i| i128::from(value(i, q)) - i128::from(value(i, p)))
        };
        for q in 1..m {
            partition.insert(q, &difference);
        }
        partition.drop_unused_nodes();
        partition
    }

    /// Inserts region q. `difference(q, p)` has u_q - u_p at the corners of the face.
    fn insert(&mut self, q: usize, difference: &impl Fn(usize, usize) -> [i128; 3]) {
        let mut signs = vec![0; self.nodes.len()];
        for cell in &self.cells {
            let d = difference(q, cell.region);
            for &(n, _) in &cell.corners {
                signs[n] = dot(self.nodes[n], d).signum();
            }
        }
        if signs.iter().all(|&sign| sign <= 0) {
            return;
        }
        let mut crossings = Vec::new();
        let mut taken: Vec<(usize, usize, Side)> = Vec::new();
        let mut remaining = Vec::with_capacity(self.cells.len() + 1);
        for cell in std::mem::take(&mut self.cells) {
            let [kept, given] = self.divide(&cell, q, &signs, &mut crossings, difference);
            let next = given.iter().cycle().skip(1);
            taken.extend(given.iter().zip(next).map(|(&(n, side), &(to, _))| (n, to, side)));
            if !kept.is_empty() {
                remaining.push(Cell { region: cell.region, corners: kept });
            }
        }
        let outline: Vec<(usize, usize, Side)> = taken
            .iter()
            .copied()
            .filter(|&(from, to, _)| !taken.iter().any(|&(a, b, _)| (a, b) == (to, from)))
            .collect();
        for cell in &mut remaining {
            let count = cell.corners.len();
            for i in 0..count {
                let (from, to) = (cell.corners[i].0, cell.corners[(i + 1) % count].0);
                // Where q took all of the neighbor.
                if outline.iter().any(|&(a, b, _)| (a, b) == (to, from)) {
                    cell.corners[i].1 = Side::Region(q);
                }
            }
        }
        remaining.push(Cell { region: q, corners: chained(&outline) });
        remaining.iter_mut().for_each(Cell::drop_inner_nodes);
        self.cells = remaining;
    }

    /// The part of a cell that it keeps and the part that region q takes, each a polygon or empty. `crossings` has the nodes
    /// that were added where the sign of u_q - max_p u_p changes along an edge, for the cell on the other side.
    fn divide(
        &mut self,
        cell: &Cell,
        q: usize,
        signs: &[i128],
        crossings: &mut Vec<([usize; 2], usize)>,
        difference: &impl Fn(usize, usize) -> [i128; 3],
    ) -> [Vec<(usize, Side)>; 2] {
        let p = cell.region;
        let gives = cell.corners.iter().any(|&(n, _)| signs[n] > 0);
        let keeps = !gives || cell.corners.iter().any(|&(n, _)| signs[n] < 0);
        let (mut kept, mut given) = (Vec::new(), Vec::new());
        let next = cell.corners.iter().cycle().skip(1);
        for (&(n, side), &(n_next, _)) in cell.corners.iter().zip(next) {
            let (sign, sign_next) = (signs[n], signs[n_next]);
            if sign <= 0 && keeps {
                let is_chord = sign == 0 && sign_next > 0;
                kept.push((n, if is_chord { Side::Region(q) } else { side }));
            }
            if sign >= 0 && gives {
                let is_chord = sign == 0 && sign_next < 0;
                given.push((n, if is_chord { Side::Region(p) } else { side }));
            }
            if sign * sign_next < 0 {
                let edge = [n.min(n_next), n.max(n_next)];
                let known = crossings.iter().find(|(other, _)| *other == edge);
                let crossing = known.map_or(self.nodes.len(), |&(_, node)| node);
                if crossing == self.nodes.len() {
                    self.nodes.push(match side {
                        Side::Border(i) => on_border(i, difference(q, p)),
                        Side::Region(r) => common(difference(r, p), difference(q, p)),
                    });
                    crossings.push((edge, crossing));
                }
                let leaves = sign < 0;
                kept.push((crossing, if leaves { Side::Region(q) } else { side }));
                given.push((crossing, if leaves { side } else { Side::Region(p) }));
            }
        }
        [kept, given]
    }

    fn drop_unused_nodes(&mut self) {
        let mut index = vec![usize::MAX; self.nodes.len()];
        let mut used = Vec::new();
        for (n, _) in self.cells.iter_mut().flat_map(|cell| &mut cell.corners) {
            if index[*n] == usize::MAX {
                index[*n] = used.len();
                used.push(self.nodes[*n]);
            }
            *n = index[*n];
        }
        self.nodes = used;
    }
}

impl Cell {
    /// Drops the nodes between two edges with the same side, which lie on a line.
    fn drop_inner_nodes(&mut self) {
        let count = self.corners.len();
        let is_corner = |i: usize| self.corners[(i + count - 1) % count].1 != self.corners[i].1;
        let corners = (0..count).filter(|&i| is_corner(i)).map(|i| self.corners[i]).collect();
        self.corners = corners;
    }
}

/// The directed edges as a polygon.
fn chained(edges: &[(usize, usize, Side)]) -> Vec<(usize, Side)> {
    let mut polygon = Vec::with_capacity(edges.len());
    let mut edge = edges[0];
    for _ in 0..edges.len() {
        polygon.push((edge.0, edge.2));
        let next = edges.iter().find(|next| next.0 == edge.1);
        edge = *next.expect("the outline of a convex part is closed");
    }
    polygon
}

fn dot(w: Node, d: [i128; 3]) -> i128 {
    w[0] * d[0] + w[1] * d[1] + w[2] * d[2]
}

/// The zero of a difference d on the edge opposite to corner i, at whose ends d has opposite signs; without common factors,
/// so that it is the same for every face at the edge.
fn on_border(i: usize, d: [i128; 3]) -> Node {
    let (a, b) = ((i + 1) % 3, (i + 2) % 3);
    let (wa, wb) = (d[b].abs(), d[a].abs());
    let factor = common_factor(wa, wb);
    let mut w = [0; 3];
    (w[a], w[b]) = (wa / factor, wb / factor);
    w
}

fn common_factor(mut a: i128, mut b: i128) -> i128 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

/// The common zero of two differences.
fn common(a: [i128; 3], b: [i128; 3]) -> Node {
    let w: Node = std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    });
    if w.iter().sum::<i128>() < 0 { w.map(|w| -w) } else { w }
}
