//! The graph of imports, and its cycles.

use std::collections::{BTreeMap, BTreeSet};

/// The first imports the second.
pub type Edges = BTreeSet<(String, String)>;

/// The sets, each sorted, of files that import each other, directly or indirectly.
pub fn cycles(edges: &Edges) -> Vec<Vec<String>> {
    let mut next: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (from, to) in edges {
        next.entry(from).or_default().push(to);
    }
    let reached: BTreeMap<&str, BTreeSet<&str>> =
        next.keys().map(|&from| (from, reached(from, &next))).collect();
    let both = |a: &str, b: &str| {
        reached[a].contains(b) && reached.get(b).is_some_and(|back| back.contains(a))
    };
    let mut cycles: Vec<Vec<String>> = Vec::new();
    for &a in next.keys().filter(|&&a| both(a, a)) {
        if !cycles.iter().any(|circle| both(a, &circle[0])) {
            let circle = next.keys().filter(|&&b| both(a, b));
            cycles.push(circle.map(|&b| b.to_owned()).collect());
        }
    }
    cycles
}

fn reached<'a>(from: &'a str, next: &BTreeMap<&'a str, Vec<&'a str>>) -> BTreeSet<&'a str> {
    let (mut found, mut left) = (BTreeSet::new(), vec![from]);
    while let Some(at) = left.pop() {
        for &to in next.get(at).into_iter().flatten() {
            if found.insert(to) {
                left.push(to);
            }
        }
    }
    found
}
