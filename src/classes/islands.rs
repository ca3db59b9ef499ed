//! Labels without small parts: what is done to labels beyond their energy, and what it costs.
//!
//! A part is a connected set with one label. Parts smaller than an area take the label of their neighbors that costs
//! least; holes, parts within one other label, are filled up to another area. The smallest come first, and of
//! neighboring parts one at a time. With one label per component, each connected component of the surface takes the
//! label of its seeds, or the one that costs least in total.
//!
//! ```text
//! R(after) - R(before)     is reported, for R of `problem.rs`: it is never below the certified bound
//! ```

use serde::{Deserialize, Serialize};

use crate::domain::Domain;
use crate::mesh::disjoint_sets::DisjointSets;
use crate::rounding::graph::{EdgeWeights, Graph};

/// What is done to labels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cleaning {
    /// Parts of a smaller area are absorbed, in squared units of the mesh.
    pub min_area: Option<f64>,
    /// Holes of a smaller area are filled, in squared units of the mesh.
    pub fill_holes: Option<f64>,
    /// Each component of the surface gets one label.
    pub one_per_component: bool,
}

/// What was done, as in `summary.json`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cleaned {
    /// The number of parts that changed their label.
    pub parts: usize,
    /// Their area.
    pub area: f64,
    /// The energy of the labels before.
    pub energy_before: f64,
    /// The energy of the labels after it.
    pub energy_after: f64,
}

impl Cleaning {
    /// Whether nothing is to be done.
    pub fn is_none(&self) -> bool {
        *self == Cleaning::default()
    }

    /// Changes labels; `f` are integrated costs, m per unknown. Parts with an unknown whose label is `fixed` stay, and
    /// so do components with several fixed labels. Returns the number of parts that changed, and their area.
    pub fn apply(
        &self,
        domain: Domain<'_>,
        (f, m): (&[f64], usize),
        lambda: f64,
        fixed: &dyn Fn(usize) -> Option<usize>,
        labels: &mut [u8],
    ) -> (usize, f64) {
        let areas = domain.cell_areas();
        let before = labels.to_vec();
        if self.one_per_component {
            constant_on_components(domain, (f, m), fixed, labels);
        }
        let graph = Graph::new(domain, EdgeWeights::Exact, lambda);
        let parts = Parts { graph: &graph, areas: &areas, f, m, fixed };
        while parts.absorb(self, labels) {}
        let changed = |v: &usize| before[*v] != labels[*v];
        // An empty sum is -0.
        let area = (0..labels.len()).filter(changed).fold(0.0, |sum, v| sum + areas[v]);
        (parts.count_changed(&before, labels), area)
    }
}

/// Each component takes the label of least total cost, or that of its fixed unknowns; it stays as it is if these
/// differ.
fn constant_on_components(
    domain: Domain<'_>,
    (f, m): (&[f64], usize),
    fixed: &dyn Fn(usize) -> Option<usize>,
    labels: &mut [u8],
) {
    let n = labels.len();
    let mut joined = DisjointSets::new(n);
    for j in 0..domain.terms() {
        let [a, b, c] = domain.corners(j);
        joined.join(a, b);
        joined.join(a, c);
    }
    let root: Vec<usize> = (0..n as u32).map(|v| joined.root(v) as usize).collect();
    let mut totals = vec![0.0; n * m];
    // The fixed labels of each component, as bits.
    let mut fixed_labels = vec![0_u64; n];
    for v in 0..n {
        fixed_labels[root[v]] |= fixed(v).map_or(0, |p| 1 << p);
        let f = &f[v * m..][..m];
        totals[root[v] * m..][..m].iter_mut().zip(f).for_each(|(sum, f)| *sum += f);
    }
    for v in 0..n {
        let total = &totals[root[v] * m..][..m];
        let fixed = fixed_labels[root[v]];
        match fixed.count_ones() {
            0 => {
                labels[v] =
                    (1..m).fold(0, |best, p| if total[p] < total[best] { p } else { best }) as u8;
            }
            1 => labels[v] = fixed.trailing_zeros() as u8,
            _ => {}
        }
    }
}

/// The parts of labels on a graph.
struct Parts<'a> {
    graph: &'a Graph,
    areas: &'a [f64],
    f: &'a [f64],
    m: usize,
    fixed: &'a dyn Fn(usize) -> Option<usize>,
}

/// One part.
struct Part {
    members: Vec<u32>,
    area: f64,
}

impl Parts<'_> {
    /// The part of each unknown, and the parts.
    fn of(&self, labels: &[u8]) -> (Vec<u32>, Vec<Part>) {
        let mut part = vec![u32::MAX; labels.len()];
        let mut parts: Vec<Part> = Vec::new();
        for first in 0..labels.len() {
            if part[first] != u32::MAX {
                continue;
            }
            let number = parts.len() as u32;
            part[first] = number;
            let (mut members, mut next) = (vec![first as u32], 0);
            while let Some(&v) = members.get(next) {
                next += 1;
                for &(w, _) in self.graph.neighbors(v) {
                    if part[w as usize] == u32::MAX && labels[w as usize] == labels[first] {
                        part[w as usize] = number;
                        members.push(w);
                    }
                }
            }
            let area = members.iter().map(|&v| self.areas[v as usize]).sum();
            parts.push(Part { members, area });
        }
        (part, parts)
    }

    /// Absorbs small parts, of neighboring ones the smallest; whether there were any.
    fn absorb(&self, cleaning: &Cleaning, labels: &mut [u8]) -> bool {
        let (part, parts) = self.of(labels);
        let limit = |limit: Option<f64>| limit.unwrap_or(0.0);
        let largest = limit(cleaning.min_area).max(limit(cleaning.fill_holes));
        let mut small: Vec<usize> = (0..parts.len()).filter(|&i| parts[i].area < largest).collect();
        small.sort_by(|&a, &b| parts[a].area.total_cmp(&parts[b].area));
        let mut is_blocked = vec![false; parts.len()];
        let mut any = false;
        for i in small {
            let Part { members, area } = &parts[i];
            if is_blocked[i] || members.iter().any(|&v| (self.fixed)(v as usize).is_some()) {
                continue;
            }
            let own = labels[members[0] as usize];
            let (mut borders, mut neighbors) = (vec![0.0; self.m], Vec::new());
            let mut touches = vec![false; self.m];
            for &(w, weight) in members.iter().flat_map(|&v| self.graph.neighbors(v)) {
                let p = labels[w as usize];
                if part[w as usize] as usize != i {
                    borders[usize::from(p)] += weight;
                    touches[usize::from(p)] = true;
                    neighbors.push(part[w as usize] as usize);
                }
            }
            let around = touches.iter().filter(|touches| **touches).count();
            let is_small = *area < limit(cleaning.min_area);
            let is_hole = around == 1 && *area < limit(cleaning.fill_holes);
            if around == 0 || !(is_small || is_hole) {
                continue;
            }
            // All labels cost the cuts to the others; taking label p saves those to it.
            let cost = |p: usize| -> f64 {
                let data: f64 = members.iter().map(|&v| self.f[v as usize * self.m + p]).sum();
                data - borders[p]
            };
            let best = (0..self.m)
                .filter(|&p| touches[p] && p != usize::from(own))
                .min_by(|&a, &b| cost(a).total_cmp(&cost(b)));
            let Some(best) = best else { continue };
            members.iter().for_each(|&v| labels[v as usize] = best as u8);
            is_blocked[i] = true;
            neighbors.into_iter().for_each(|k| is_blocked[k] = true);
            any = true;
        }
        any
    }

    /// The number of parts of the labels before in which a label changed.
    fn count_changed(&self, before: &[u8], labels: &[u8]) -> usize {
        let (_, parts) = self.of(before);
        let changed = |v: &u32| before[*v as usize] != labels[*v as usize];
        parts.iter().filter(|part| part.members.iter().any(changed)).count()
    }
}
