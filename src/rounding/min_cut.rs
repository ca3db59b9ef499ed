//! Minimum cuts of graphs with terminals.
//!
//! ```text
//! min over x in {0,1}^n of   sum_i t_i x_i + sum_(i,j) c_ij (1 - x_i) x_j,      c_ij >= 0
//! ```
//!
//! Two trees of arcs with residual capacity grow from the source and from the sink; where they meet, flow is augmented,
//! and nodes that lose their parent look for another one. Reference: Y. Boykov, V. Kolmogorov, *An experimental
//! comparison of min-cut/max-flow algorithms for energy minimization in vision*, IEEE Transactions on Pattern Analysis
//! and Machine Intelligence 26(9), 2004; the distances are those of V. Kolmogorov's thesis, 2003, section 2.4.

use std::collections::VecDeque;

/// A graph, and the flow through it.
pub struct MinCut {
    /// Arcs out of node i: `first[i]..first[i + 1]`.
    first: Vec<u32>,
    head: Vec<u32>,
    /// The arc in the other direction.
    reverse: Vec<u32>,
    residual: Vec<f64>,
    /// Residual capacity from the source if positive, to the sink if negative.
    terminal: Vec<f64>,
    tree: Vec<Tree>,
    /// The arc from a node to its parent, or one of the constants below.
    parent: Vec<u32>,
    /// A distance to the terminal, and when it was computed.
    distance: Vec<u32>,
    stamp: Vec<u32>,
    time: u32,
    active: VecDeque<u32>,
    is_active: Vec<bool>,
    orphans: VecDeque<u32>,
}

#[derive(Clone, Copy, PartialEq)]
enum Tree {
    Free,
    Source,
    Sink,
}

/// The parent is the terminal itself.
const TERMINAL: u32 = u32::MAX;
/// There is none.
const NONE: u32 = u32::MAX - 1;

/// An edge i j with the costs c_ij and c_ji, neither of them negative.
#[derive(Clone, Copy)]
pub struct Edge {
    pub ends: [u32; 2],
    pub costs: [f64; 2],
}

impl MinCut {
    /// The graph with one cost t_i per node.
    pub fn new(costs: Vec<f64>, edges: &[Edge]) -> Self {
        let n = costs.len();
        let mut first = vec![0; n + 1];
        for edge in edges {
            edge.ends.iter().for_each(|&i| first[i as usize + 1] += 1);
        }
        for i in 0..n {
            first[i + 1] += first[i];
        }
        let mut next = first.clone();
        let mut place = |i: u32| {
            next[i as usize] += 1;
            next[i as usize] - 1
        };
        let arcs = 2 * edges.len();
        let (mut head, mut reverse, mut residual) = (vec![0; arcs], vec![0; arcs], vec![0.0; arcs]);
        for &Edge { ends: [i, j], costs } in edges {
            let (a, b) = (place(i), place(j));
            for (arc, to, back, cost) in [(a, j, b, costs[0]), (b, i, a, costs[1])] {
                (head[arc as usize], reverse[arc as usize]) = (to, back);
                residual[arc as usize] = cost;
            }
        }
        let mut cut = MinCut {
            first,
            head,
            reverse,
            residual,
            terminal: costs,
            tree: vec![Tree::Free; n],
            parent: vec![NONE; n],
            distance: vec![0; n],
            stamp: vec![0; n],
            time: 0,
            active: VecDeque::new(),
            is_active: vec![false; n],
            orphans: VecDeque::new(),
        };
        for i in 0..n as u32 {
            let t = cut.terminal[i as usize];
            if t != 0.0 {
                cut.tree[i as usize] = if t > 0.0 { Tree::Source } else { Tree::Sink };
                cut.parent[i as usize] = TERMINAL;
                cut.distance[i as usize] = 1;
                cut.activate(i);
            }
        }
        cut
    }

    /// Whether x_i = 1, for every node of a minimizer; 0 where both are minimal.
    pub fn minimizer(mut self) -> Vec<bool> {
        while let Some(&i) = self.active.front() {
            match self.meeting_arc(i) {
                Some(arc) => {
                    self.time += 1;
                    self.augment(arc);
                    while let Some(orphan) = self.orphans.pop_front() {
                        self.adopt(orphan);
                    }
                }
                None => {
                    self.active.pop_front();
                    self.is_active[i as usize] = false;
                }
            }
        }
        self.tree.iter().map(|&tree| tree == Tree::Sink).collect()
    }

    fn arcs(&self, i: u32) -> std::ops::Range<usize> {
        self.first[i as usize] as usize..self.first[i as usize + 1] as usize
    }

    fn activate(&mut self, i: u32) {
        if !self.is_active[i as usize] {
            self.is_active[i as usize] = true;
            self.active.push_back(i);
        }
    }

    /// The residual capacity of an arc in the direction of the flow through a tree: away from the source or towards the
    /// sink, for an arc out of a node of that tree.
    fn capacity(&self, tree: Tree, arc: usize) -> f64 {
        match tree {
            Tree::Sink => self.residual[self.reverse[arc] as usize],
            _ => self.residual[arc],
        }
    }

    /// Grows the tree of node i; the arc from the source tree to the sink tree where it meets the other one.
    fn meeting_arc(&mut self, i: u32) -> Option<usize> {
        let tree = self.tree[i as usize];
        if tree == Tree::Free {
            return None;
        }
        for arc in self.arcs(i) {
            if self.capacity(tree, arc) <= 0.0 {
                continue;
            }
            let j = self.head[arc] as usize;
            if self.tree[j] == Tree::Free {
                self.tree[j] = tree;
                self.parent[j] = self.reverse[arc];
                self.stamp[j] = self.stamp[i as usize];
                self.distance[j] = self.distance[i as usize] + 1;
                self.activate(j as u32);
            } else if self.tree[j] != tree {
                return Some(if tree == Tree::Source { arc } else { self.reverse[arc] as usize });
            } else if self.stamp[j] <= self.stamp[i as usize]
                && self.distance[j] > self.distance[i as usize] + 1
            {
                // A shorter way to the terminal.
                self.parent[j] = self.reverse[arc];
                self.stamp[j] = self.stamp[i as usize];
                self.distance[j] = self.distance[i as usize] + 1;
            }
        }
        None
    }

    /// Pushes as much as the path through this arc admits.
    fn augment(&mut self, arc: usize) {
        let (head, tail) = (self.head[arc], self.head[self.reverse[arc] as usize]);
        let mut amount = self.residual[arc];
        for (end, tree) in [(tail, Tree::Source), (head, Tree::Sink)] {
            let mut i = end;
            while self.parent[i as usize] != TERMINAL {
                let up = self.parent[i as usize] as usize;
                amount = amount.min(self.capacity(tree, self.reverse[up] as usize));
                i = self.head[up];
            }
            amount = amount.min(self.terminal[i as usize].abs());
        }
        self.residual[arc] -= amount;
        self.residual[self.reverse[arc] as usize] += amount;
        for (end, tree) in [(tail, Tree::Source), (head, Tree::Sink)] {
            let mut i = end;
            while self.parent[i as usize] != TERMINAL {
                let up = self.parent[i as usize] as usize;
                let down = self.reverse[up] as usize;
                let [with, against] = if tree == Tree::Source { [down, up] } else { [up, down] };
                self.residual[with] -= amount;
                self.residual[against] += amount;
                if self.residual[with] <= 0.0 {
                    self.orphan(i);
                }
                i = self.head[up];
            }
            let t = &mut self.terminal[i as usize];
            *t -= amount * t.signum();
            if *t == 0.0 {
                self.orphan(i);
            }
        }
    }

    fn orphan(&mut self, i: u32) {
        self.parent[i as usize] = NONE;
        self.orphans.push_back(i);
    }

    /// The distance of a node to its terminal; `None` if it hangs on an orphan.
    fn distance_to_terminal(&mut self, start: u32) -> Option<u32> {
        let (mut i, mut steps) = (start, 0);
        let known = loop {
            if self.stamp[i as usize] == self.time {
                break self.distance[i as usize];
            }
            match self.parent[i as usize] {
                TERMINAL => {
                    (self.stamp[i as usize], self.distance[i as usize]) = (self.time, 1);
                    break 1;
                }
                NONE => return None,
                up => i = self.head[up as usize],
            }
            steps += 1;
        };
        let mut distance = known + steps;
        let total = distance;
        let mut i = start;
        while self.stamp[i as usize] != self.time {
            (self.stamp[i as usize], self.distance[i as usize]) = (self.time, distance);
            distance -= 1;
            i = self.head[self.parent[i as usize] as usize];
        }
        Some(total)
    }

    /// Finds the nearest parent for an orphan, or frees it and makes orphans of its children.
    fn adopt(&mut self, i: u32) {
        let tree = self.tree[i as usize];
        let mut best = None;
        for arc in self.arcs(i) {
            let j = self.head[arc];
            let towards = self.capacity(tree, self.reverse[arc] as usize);
            if towards <= 0.0 || self.tree[j as usize] != tree {
                continue;
            }
            if let Some(distance) = self.distance_to_terminal(j)
                && best.is_none_or(|(least, _)| distance < least)
            {
                best = Some((distance, arc));
            }
        }
        if let Some((distance, arc)) = best {
            self.parent[i as usize] = arc as u32;
            self.stamp[i as usize] = self.time;
            self.distance[i as usize] = distance + 1;
            return;
        }
        for arc in self.arcs(i) {
            let j = self.head[arc];
            if self.tree[j as usize] != tree {
                continue;
            }
            if self.capacity(tree, self.reverse[arc] as usize) > 0.0 {
                self.activate(j);
            }
            let up = self.parent[j as usize];
            if up < NONE && self.head[up as usize] == i {
                self.orphan(j);
            }
        }
        self.tree[i as usize] = Tree::Free;
        self.parent[i as usize] = NONE;
    }
}
