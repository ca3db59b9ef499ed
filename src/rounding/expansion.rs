//! Expansion moves: the best set of vertices that change to one label, by a minimum cut of the graph of `labels.rs`.
//!
//! The cut is restricted to a band around the cuts between labels and the vertices whose u is not one-hot, which grows
//! where changes reach its rim. Three labels in a face may cost another amount than in the graph, so a connected set of changes is
//! accepted only if it lowers the energy. Reference: Y. Boykov, O. Veksler, R. Zabih, *Fast approximate energy
//! minimization via graph cuts*, IEEE Transactions on Pattern Analysis and Machine Intelligence 23(11), 2001.

use super::labels::Labels;
use super::min_cut::{Edge, MinCut};
use crate::sweep::results;

/// The band reaches this many rings of vertices beyond a cut or a change.
const RINGS: usize = 2;

/// Number of vertices whose neighbors a thread finds at a time.
const PART: usize = 2048;

/// At most this many rounds over all labels.
const MAX_ROUNDS: usize = 6;

/// Expands all labels in turn until none lowers the energy or `go_on`, which is asked before each cut, returns false.
/// `uncertain` vertices are in the band.
pub fn expand(
    labels: &mut Labels<'_>,
    uncertain: impl Fn(usize) -> bool,
    go_on: &mut dyn FnMut() -> bool,
) {
    let mut band = Band::around(labels, uncertain);
    let (mut since_change, m) = (0, labels.m);
    for round in 0..MAX_ROUNDS * m {
        if since_change == m {
            break;
        }
        let changed = band.expand(labels, (round % m) as u8, go_on);
        since_change = if changed { 0 } else { since_change + 1 };
    }
}

/// The minimizer of two labels: one cut of the whole graph, where faces have at most two labels.
pub fn minimize_two(labels: &mut Labels<'_>) {
    assert_eq!(labels.m, 2);
    let mut all = Band::new(labels);
    all.touch(labels, (0..labels.vertices() as u32).collect());
    let zeros = (0..labels.vertices()).map(|v| if labels.is_allowed(v, 0) { 0 } else { 1 });
    labels.labels = zeros.collect();
    let changed = all.cut(labels, 1, 0);
    changed.into_iter().for_each(|v| labels.labels[v as usize] = 1);
}

/// The vertices that may change, and the edges at them.
struct Band {
    vertices: Vec<u32>,
    /// For each vertex of the mesh, its range of `neighbors`; empty outside the band.
    range: Vec<[u32; 2]>,
    neighbors: Vec<(u32, f64)>,
    /// The time of the last change within some rings of each vertex; 0 outside the band.
    touched: Vec<u32>,
    /// Counts changes.
    time: u32,
    /// The time of the last expansion of each label.
    expanded: Vec<u32>,
    /// The node of each vertex in the present graph.
    node: Vec<u32>,
}

/// The vertex is no node.
pub const NONE: u32 = u32::MAX;

impl Band {
    fn new(labels: &Labels<'_>) -> Self {
        let n = labels.vertices();
        Band {
            vertices: Vec::new(),
            range: vec![[0; 2]; n],
            neighbors: Vec::new(),
            touched: vec![0; n],
            time: 0,
            expanded: vec![0; labels.m],
            node: vec![NONE; n],
        }
    }

    fn around(labels: &Labels<'_>, uncertain: impl Fn(usize) -> bool) -> Self {
        let mut is_core = labels.at_cuts();
        (0..labels.vertices()).for_each(|v| is_core[v] |= uncertain(v));
        let core = (0..labels.vertices() as u32).filter(|&v| is_core[v as usize]);
        let mut band = Band::new(labels);
        band.touch(labels, core.collect());
        band
    }

    /// Notes that these vertices have changed: they and those within some rings of them are in the band.
    fn touch(&mut self, labels: &Labels<'_>, changed: Vec<u32>) {
        self.time += 1;
        let known = self.vertices.len();
        let mut ring = changed;
        ring.iter().for_each(|&v| self.add(v));
        for _ in 0..RINGS {
            let mut next = Vec::new();
            for &j in ring.iter().flat_map(|&v| labels.faces_at(v as usize)) {
                for w in labels.face(j) {
                    if self.touched[w as usize] != self.time {
                        self.add(w);
                        next.push(w);
                    }
                }
            }
            ring = next;
        }
        self.add_neighbors(labels, known);
    }

    fn add(&mut self, v: u32) {
        if self.touched[v as usize] == 0 {
            self.vertices.push(v);
        }
        self.touched[v as usize] = self.time;
    }

    /// Adds the neighbors of the vertices from the given place on.
    fn add_neighbors(&mut self, labels: &Labels<'_>, from: usize) {
        let parts = self.vertices[from..].chunks(PART).collect();
        let found = results(parts, |part: &[u32]| {
            let (mut neighbors, mut ends) = (Vec::new(), Vec::with_capacity(part.len()));
            for &v in part {
                labels.add_neighbors(v as usize, &mut neighbors);
                ends.push(neighbors.len());
            }
            (neighbors, ends)
        });
        let mut vertices = self.vertices[from..].iter();
        for (neighbors, ends) in found {
            let (first, mut begin) = (self.neighbors.len(), 0);
            for (end, &v) in ends.into_iter().zip(&mut vertices) {
                self.range[v as usize] = [first + begin, first + end].map(|end| end as u32);
                begin = end;
            }
            self.neighbors.extend(neighbors);
        }
    }

    /// Changes vertices to label p where this lowers the energy; whether any changed.
    fn expand(&mut self, labels: &mut Labels<'_>, p: u8, go_on: &mut dyn FnMut() -> bool) -> bool {
        let mut any = false;
        loop {
            if !go_on() {
                return any;
            }
            let since = std::mem::replace(&mut self.expanded[usize::from(p)], self.time);
            let changed = self.cut(labels, p, since);
            let accepted = accept(labels, changed, p);
            if accepted.is_empty() {
                return any;
            }
            any = true;
            self.touch(labels, accepted);
        }
    }

    /// The vertices that change to label p in the best expansion in the graph, among those that changes have touched
    /// after a time.
    fn cut(&mut self, labels: &Labels<'_>, p: u8, since: u32) -> Vec<u32> {
        let may_change = |v: &u32| {
            let v = *v as usize;
            self.touched[v] > since && labels.labels[v] != p && labels.is_allowed(v, p)
        };
        let nodes: Vec<u32> = self.vertices.iter().copied().filter(may_change).collect();
        let costs = |v: u32, p: u8| labels.cost(v as usize, p);
        let neighbors = |v: u32| {
            let [begin, end] = self.range[v as usize].map(|end| end as usize);
            &self.neighbors[begin..end]
        };
        let costs = Costs { of_label: costs, distance: |a, b| labels.distance(a, b), neighbors };
        best_expansion(nodes, &labels.labels, p, costs, &mut self.node)
    }
}

/// What labels cost in a graph.
pub struct Costs<F, D, N> {
    /// f_vp.
    pub of_label: F,
    /// d(a, b), by which the weight of an edge between labels a and b is multiplied.
    pub distance: D,
    /// The neighbors of a vertex, and the weights of the edges to them.
    pub neighbors: N,
}

/// The vertices among the given ones that change to label p in the best expansion of it. `node` has a place for each
/// vertex of the mesh and holds [`NONE`] before and after.
pub fn best_expansion<'a>(
    nodes: Vec<u32>,
    labels: &[u8],
    p: u8,
    costs: Costs<impl Fn(u32, u8) -> f64, impl Fn(u8, u8) -> f64, impl Fn(u32) -> &'a [(u32, f64)]>,
    node: &mut [u32],
) -> Vec<u32> {
    let Costs { of_label: cost, distance, neighbors } = costs;
    if nodes.is_empty() {
        return nodes;
    }
    for (i, &v) in nodes.iter().enumerate() {
        node[v as usize] = i as u32;
    }
    let mut costs = Vec::with_capacity(nodes.len());
    let mut edges = Vec::with_capacity(4 * nodes.len());
    for (i, &v) in nodes.iter().enumerate() {
        let (i, own) = (i as u32, labels[v as usize]);
        let mut change = cost(v, p) - cost(v, own);
        for &(w, weight) in neighbors(v) {
            let other = labels[w as usize];
            let apart = weight * distance(own, other);
            // x = 1 where the label becomes p. The edge costs `apart` for (0, 0), `first` for (1, 0), `second` for (0,
            // 1), and nothing for (1, 1).
            match node[w as usize] {
                NONE => change += weight * distance(p, other) - apart,
                j if i < j => {
                    let (first, second) = (weight * distance(p, other), weight * distance(own, p));
                    change += first - apart;
                    // Not negative by the triangle inequality, but for rounding.
                    let together = (first + second - apart).max(0.0);
                    edges.push(Edge { ends: [i, j], costs: [together, 0.0] });
                }
                _ => change -= weight * distance(p, own),
            }
        }
        costs.push(change);
    }
    let changes = MinCut::new(costs, &edges).minimizer();
    nodes.iter().for_each(|&v| node[v as usize] = NONE);
    nodes.into_iter().zip(changes).filter_map(|(v, changes)| changes.then_some(v)).collect()
}

/// Accepts the connected sets of changes that lower the energy; the vertices of these.
fn accept(labels: &mut Labels<'_>, changed: Vec<u32>, p: u8) -> Vec<u32> {
    let mut component: std::collections::HashMap<u32, u32> =
        changed.iter().map(|&v| (v, NONE)).collect();
    let mut accepted = Vec::new();
    for (number, &first) in (0..).zip(&changed) {
        if component[&first] != NONE {
            continue;
        }
        component.insert(first, number);
        let mut members = vec![first];
        let mut next = 0;
        while let Some(&v) = members.get(next) {
            next += 1;
            for w in labels.faces_at(v as usize).iter().flat_map(|&j| labels.face(j)) {
                if component.get(&w) == Some(&NONE) {
                    component.insert(w, number);
                    members.push(w);
                }
            }
        }
        let [change, error] = labels.change(&members, p, &|w| component.get(&w) == Some(&number));
        if change < -error {
            members.iter().for_each(|&v| labels.labels[v as usize] = p);
            accepted.extend(members);
        }
    }
    accepted
}
