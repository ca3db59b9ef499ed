//! Vertices that no data reach: components of the surface of which nothing is known. They cost nothing and touch nothing
//! else, so that any label is as good there as another, and the one that they get must not pass for an answer.

use crate::mesh::Mesh;
use crate::mesh::geometry::barycentric_areas;
use crate::mesh::partition::Partition;

/// What becomes of vertices that have no data of their own, wherever they are.
pub(crate) const INHERIT: &str =
    "where they are connected with others, they take the labels of their neighbors";

/// What must be said of them, if there are any. Every face of the mesh has an area.
pub(crate) fn unreached(mesh: &Mesh, known: impl Fn(usize) -> bool) -> Option<String> {
    let vertices = mesh.vertices.len();
    if (0..vertices).all(&known) {
        return None;
    }
    let mut joined = Partition::new(vertices);
    for &[a, b, c] in &mesh.faces {
        joined.join(a, b);
        joined.join(a, c);
    }
    let mut reached = vec![false; vertices];
    for v in (0..vertices).filter(|&v| known(v)) {
        reached[joined.root(v as u32) as usize] = true;
    }
    let areas = barycentric_areas(mesh);
    let (mut count, mut area) = (0, 0.0);
    for v in (0..vertices).filter(|&v| !reached[joined.root(v as u32) as usize]) {
        count += 1;
        area += areas[v];
    }
    (count > 0).then(|| {
        format!(
            "nothing is known of {count} vertices ({:.2} % of the area), nor of any that they are connected with: their labels \
             mean nothing; give them data, connect them to the rest, or leave them out",
            100.0 * area / mesh.area()
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{disjoint, shape};

    #[test]
    fn components_without_data_are_counted() {
        let one = shape("grid:2x2");
        let n = one.vertices.len();
        let mut two = disjoint([one.clone(), one.scaled(3.0)]);
        assert_eq!(unreached(&two, |_| true), None);
        // One vertex that is known is enough.
        assert_eq!(unreached(&two, |v| v == 0 || v == n), None);
        let said = unreached(&two, |v| v < n).unwrap();
        assert!(said.contains(&format!("{n} vertices (90.00 % of the area)")), "{said}");
        // A vertex in no face is a component as well.
        two.vertices.push(two.vertices[0]);
        let said = unreached(&two, |v| v < 2 * n).unwrap();
        assert!(said.contains("of 1 vertices (0.00 % of the area)"), "{said}");
    }
}
