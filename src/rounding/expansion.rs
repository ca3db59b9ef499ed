//! Expansion moves: the best set of vertices that change to one label, by a minimum cut of the graph of `labels.rs`.
//!
//! The cut is restricted to a band around the cuts between labels and the vertices whose u is not one-hot, which grows
//! where changes reach its rim. Three labels in a face cost more than in the graph, so a connected set of changes is
//! accepted only if it lowers the energy. Reference: Y. Boykov, O. Veksler, R. Zabih, *Fast approximate energy
//! minimization via graph cuts*, IEEE Transactions on Pattern Analysis and Machine Intelligence 23(11), 2001.

use super::labels::Labels;
use super::min_cut::{Edge, MinCut};

/// The band reaches this many rings of vertices beyond a cut or a change.
const RINGS: usize = 2;

/// At most this many rounds over all labels.
const MAX_ROUNDS: usize = 6;

/// Expands all labels in turn until none lowers the energy. `uncertain` vertices are in the band.
pub fn expand(labels: &mut Labels<'_>, uncertain: impl Fn(usize) -> bool) {
    let mut band = Band::around(labels, uncertain);
    let (mut since_change, m) = (0, labels.m);
    for round in 0..MAX_ROUNDS * m {
        if since_change == m {
            break;
        }
        let changed = band.expand(labels, (round % m) as u8);
        since_change = if changed { 0 } else { since_change + 1 };
    }
}

/// The minimizer of two labels: one cut of the whole graph, where faces have at most two labels.
pub fn minimize_two(labels: &mut Labels<'_>) {
    assert_eq!(labels.m, 2);
    let mut all = Band::of(labels, (0..labels.vertices() as u32).collect());
    let zeros = (0..labels.vertices()).map(|v| if labels.is_allowed(v, 0) { 0 } else { 1 });
    labels.labels = zeros.collect();
    let changed = all.cut(labels, 1);
    changed.into_iter().for_each(|v| labels.labels[v as usize] = 1);
}

/// The vertices that may change, and the edges at them.
struct Band {
    vertices: Vec<u32>,
    is_in: Vec<bool>,
    /// Edges with at least one end in the band, each once, with their weights.
    edges: Vec<([u32; 2], f64)>,
    /// The node of each vertex in the present graph.
    node: Vec<u32>,
}

/// The vertex is no node.
const NONE: u32 = u32::MAX;

impl Band {
    fn around(labels: &Labels<'_>, uncertain: impl Fn(usize) -> bool) -> Self {
        let at_cut = |v: usize| {
            let differs = |&j: &u32| {
                let [a, b, c] = labels.face_labels(j);
                a != b || b != c
            };
            labels.faces_at(v).iter().any(differs)
        };
        let core = (0..labels.vertices()).filter(|&v| at_cut(v) || uncertain(v));
        let core: Vec<u32> = core.map(|v| v as u32).collect();
        let mut band = Band::of(labels, Vec::new());
        band.add_rings(labels, core);
        band
    }

    fn of(labels: &Labels<'_>, vertices: Vec<u32>) -> Self {
        let n = labels.vertices();
        let mut band = Band {
            vertices: Vec::new(),
            is_in: vec![false; n],
            edges: Vec::new(),
            node: vec![NONE; n],
        };
        band.add(labels, vertices);
        band
    }

    /// Adds vertices that are not in the band yet, and their edges.
    fn add(&mut self, labels: &Labels<'_>, new: Vec<u32>) {
        let mut neighbors = Vec::new();
        for &v in &new {
            labels.neighbors(v as usize, &mut neighbors);
            // Edges to vertices that were added before exist.
            let fresh = neighbors.iter().filter(|(w, _)| !self.is_in[*w as usize]);
            self.edges.extend(fresh.map(|&(w, weight)| ([v, w], weight)));
            self.is_in[v as usize] = true;
        }
        self.vertices.extend(new);
    }

    /// Adds the given vertices and those within some rings of them; whether any of these is new.
    fn add_rings(&mut self, labels: &Labels<'_>, core: Vec<u32>) -> bool {
        let before = self.vertices.len();
        let fresh: Vec<u32> = core.iter().copied().filter(|&v| !self.is_in[v as usize]).collect();
        self.add(labels, fresh);
        let mut rim = core;
        for _ in 0..RINGS {
            let mut next: Vec<u32> = rim
                .iter()
                .flat_map(|&v| labels.faces_at(v as usize))
                .flat_map(|&j| labels.face(j))
                .filter(|&w| !self.is_in[w as usize])
                .collect();
            next.sort_unstable();
            next.dedup();
            self.add(labels, next.clone());
            rim.extend(next);
        }
        self.vertices.len() > before
    }

    /// Changes vertices to label p where this lowers the energy; whether any changed.
    fn expand(&mut self, labels: &mut Labels<'_>, p: u8) -> bool {
        let mut any = false;
        loop {
            let changed = self.cut(labels, p);
            let accepted = accept(labels, changed, p);
            any |= !accepted.is_empty();
            if accepted.is_empty() || !self.add_rings(labels, accepted) {
                return any;
            }
        }
    }

    /// The vertices that change to label p in the best expansion in the graph.
    fn cut(&mut self, labels: &Labels<'_>, p: u8) -> Vec<u32> {
        let may_change = |v: u32| {
            let v = v as usize;
            labels.labels[v] != p && labels.is_allowed(v, p)
        };
        let nodes: Vec<u32> = self.vertices.iter().copied().filter(|&v| may_change(v)).collect();
        for (i, &v) in nodes.iter().enumerate() {
            self.node[v as usize] = i as u32;
        }
        let gain = |&v: &u32| {
            let v = v as usize;
            labels.cost(v, p) - labels.cost(v, labels.labels[v])
        };
        let mut costs: Vec<f64> = nodes.iter().map(gain).collect();
        let mut edges = Vec::with_capacity(self.edges.len());
        for &([v, w], weight) in &self.edges {
            let [i, j] = [v, w].map(|v| self.node[v as usize]);
            let [a, b] = [v, w].map(|v| labels.labels[v as usize]);
            let apart = if a != b { weight } else { 0.0 };
            // x = 1 where the label becomes p. The edge costs `apart` for (0, 0), the weight if one of two nodes changes,
            // and nothing for (1, 1).
            match (i, j) {
                (NONE, NONE) => {}
                (NONE, j) => costs[j as usize] += if a != p { weight } else { 0.0 } - apart,
                (i, NONE) => costs[i as usize] += if b != p { weight } else { 0.0 } - apart,
                (i, j) => {
                    costs[i as usize] += weight - apart;
                    costs[j as usize] -= weight;
                    edges.push(Edge { ends: [i, j], costs: [2.0 * weight - apart, 0.0] });
                }
            }
        }
        let change = MinCut::new(costs, &edges).minimizer();
        nodes.iter().for_each(|&v| self.node[v as usize] = NONE);
        nodes.into_iter().zip(change).filter_map(|(v, change)| change.then_some(v)).collect()
    }
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
