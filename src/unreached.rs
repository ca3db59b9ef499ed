//! Vertices that no data reach: components of the surface without any known vertex. All labels cost the same there, so
//! the labels of such components are arbitrary, and a warning reports them.

use crate::counted::counted;
use crate::domain::Domain;
use crate::mesh::disjoint_sets::DisjointSets;

/// The clause of a warning about what happens to unknown vertices.
pub(crate) const INHERIT: &str =
    "where they are connected to known vertices, they take the labels of their neighbors";

/// A warning that counts these vertices, or faces, if there are any. Every face of a mesh has an area.
pub(crate) fn warning(domain: Domain<'_>, known: impl Fn(usize) -> bool) -> Option<String> {
    let vertices = domain.unknowns();
    if (0..vertices).all(&known) {
        return None;
    }
    let mut joined = DisjointSets::new(vertices);
    for [a, b, c] in (0..domain.terms()).map(|j| domain.corners(j)) {
        joined.join(a, b);
        joined.join(a, c);
    }
    let mut reached = vec![false; vertices];
    for v in (0..vertices).filter(|&v| known(v)) {
        reached[joined.root(v as u32) as usize] = true;
    }
    let areas = domain.cell_areas();
    let (mut count, mut area) = (0, 0.0);
    for v in (0..vertices).filter(|&v| !reached[joined.root(v as u32) as usize]) {
        count += 1;
        area += areas[v];
    }
    (count > 0).then(|| {
        let [are, labels, them] = match count {
            1 => ["is", "its label means nothing", "it"],
            _ => ["are", "their labels mean nothing", "them"],
        };
        let [one, many] = domain.element().nouns();
        format!(
            "{} ({:.2} % of the area) {are} unknown and not connected to any known {one}: {labels}; give {them} data, \
             connect {them} to the rest, or remove {them}",
            counted(count, one, many),
            100.0 * area / domain.area()
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{disjoint, shape};

    #[test]
    fn vertices_of_components_without_data_are_counted() {
        let one = shape("grid:2x2");
        let n = one.vertices.len();
        let mut two = disjoint([one.clone(), one.scaled(3.0)]);
        assert_eq!(warning((&two).into(), |_| true), None);
        // A single known vertex is enough.
        assert_eq!(warning((&two).into(), |v| v == 0 || v == n), None);
        let message = warning((&two).into(), |v| v < n).unwrap();
        assert!(message.contains(&format!("{n} vertices (90.00 % of the area)")), "{message}");
        // A vertex without faces is a component, too.
        two.vertices.push(two.vertices[0]);
        let message = warning((&two).into(), |v| v < 2 * n).unwrap();
        assert!(message.contains("1 vertex (0.00 % of the area) is unknown"), "{message}");
    }
}
