//! Disjoint sets (union-find) with path halving. The root of a set is its smallest member.
//!
//! Reference: Tarjan, van Leeuwen, *Worst-case analysis of set union algorithms*, J. ACM 31(2), 1984.

pub struct DisjointSets {
    parent: Vec<u32>,
}

impl DisjointSets {
    /// n sets of one member each.
    pub fn new(n: usize) -> Self {
        DisjointSets { parent: (0..n as u32).collect() }
    }

    /// The smallest member of the set that contains k.
    pub fn root(&mut self, mut k: u32) -> u32 {
        while self.parent[k as usize] != k {
            let above = self.parent[self.parent[k as usize] as usize];
            self.parent[k as usize] = above;
            k = above;
        }
        k
    }

    /// Merges the sets that contain a and b.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }

    /// The number of marked sets. Of each set either all members or none must be marked.
    pub fn count(&self, marked: &[bool]) -> usize {
        let roots = self.parent.iter().enumerate().zip(marked);
        roots.filter(|&((k, &parent), &marked)| marked && parent as usize == k).count()
    }
}
