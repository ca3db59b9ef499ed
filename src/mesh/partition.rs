//! Disjoint sets with path halving. The root of a class is its smallest member.
//!
//! Reference: Tarjan, van Leeuwen, *Worst-case analysis of set union algorithms*, J. ACM 31(2), 1984.

pub struct Partition {
    parent: Vec<u32>,
}

impl Partition {
    /// Each of n members alone.
    pub fn new(n: usize) -> Self {
        Partition { parent: (0..n as u32).collect() }
    }

    /// The smallest member of the class of k.
    pub fn root(&mut self, mut k: u32) -> u32 {
        while self.parent[k as usize] != k {
            let above = self.parent[self.parent[k as usize] as usize];
            self.parent[k as usize] = above;
            k = above;
        }
        k
    }

    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }

    /// How many classes the marked members have, of which either all or none are marked.
    pub fn classes(&self, marked: &[bool]) -> usize {
        let roots = self.parent.iter().enumerate().zip(marked);
        roots.filter(|&((k, &parent), &marked)| marked && parent as usize == k).count()
    }
}
