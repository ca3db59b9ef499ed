//! Who imports whom, and who thereby imports itself.

use std::collections::{BTreeMap, BTreeSet};

/// The first imports the second.
pub type Edges = BTreeSet<(String, String)>;

/// The sets, each sorted, of those who import each other, directly or through others.
pub fn circles(edges: &Edges) -> Vec<Vec<String>> {
    let mut next: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (from, to) in edges {
        next.entry(from).or_default().push(to);
    }
    let reached: BTreeMap<&str, BTreeSet<&str>> =
        next.keys().map(|&from| (from, reached(from, &next))).collect();
    let both = |a: &str, b: &str| {
        reached[a].contains(b) && reached.get(b).is_some_and(|back| back.contains(a))
    };
    let mut circles: Vec<Vec<String>> = Vec::new();
    for &a in next.keys().filter(|&&a| both(a, a)) {
        if !circles.iter().any(|circle| both(a, &circle[0])) {
            let circle = next.keys().filter(|&&b| both(a, b));
            circles.push(circle.map(|&b| b.to_owned()).collect());
        }
    }
    circles
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
