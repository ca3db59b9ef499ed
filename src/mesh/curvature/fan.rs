//! Vertices whose faces form one closed fan: inside the surface, and without non-manifold edges. A formula that is valid
//! there is continued to all other vertices by means.

use crate::mesh::{Incidence, Mesh};
use crate::sweep;

/// The edge opposite to the vertex in each of its faces, in the direction of the face.
pub type Links = Incidence<[u32; 2]>;

/// The links of all vertices of a mesh without degenerate faces.
pub fn links(mesh: &Mesh) -> Links {
    Links::new(mesh, |j, i| {
        let face = mesh.faces[j];
        [face[(i + 1) % 3], face[(i + 2) % 3]]
    })
}

/// N numbers per vertex: at closed fans those of the evaluator, which is called with the vertex and its neighbors in
/// cyclic order; elsewhere the means of the neighbors that are closed fans with numbers, NaN if there are none. An
/// evaluator may have storage of its own, one per range of vertices.
pub fn at_fans<const N: usize, E: FnMut(usize, &[u32]) -> [f64; N]>(
    vertices: usize,
    links: &Links,
    evaluator: impl Fn() -> E + Sync,
) -> Vec<[f64; N]> {
    let mut at_fans = vec![None; vertices];
    sweep::sweep_parts(&mut at_fans, &sweep::ranges(vertices), |first, values| {
        let mut fan = Fan::default();
        let mut evaluate = evaluator();
        for (v, value) in (first..).zip(values) {
            *value = fan.is_closed(links.at(v)).then(|| evaluate(v, &fan.ring));
        }
    });
    (0..vertices).map(|v| at_fans[v].unwrap_or_else(|| mean(links.at(v), &at_fans))).collect()
}

/// The means over the ends of a link.
fn mean<const N: usize>(link: &[[u32; 2]], at_fans: &[Option<[f64; N]>]) -> [f64; N] {
    let mut neighbors = link.as_flattened().to_vec();
    neighbors.sort_unstable();
    neighbors.dedup();
    let known = neighbors.iter().filter_map(|&k| at_fans[k as usize]).filter(|x| !x[0].is_nan());
    let (mut sums, mut count) = ([0.0; N], 0.0);
    for values in known {
        sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
        count += 1.0;
    }
    // 0/0 is NaN.
    sums.map(|sum| sum / count)
}

/// The faces around one vertex in cyclic order.
#[derive(Default)]
struct Fan {
    /// The neighbors.
    ring: Vec<u32>,
    /// Each end of each edge of the link, as vertex and number: 2 i and 2 i + 1 are the ends of edge i.
    ends: Vec<(u32, u32)>,
    /// The number of the other end at the same vertex.
    other: Vec<u32>,
}

impl Fan {
    /// Whether the link is one closed curve; then its vertices are the ring. In O(n log n) time for n faces.
    fn is_closed(&mut self, link: &[[u32; 2]]) -> bool {
        self.ring.clear();
        self.ends.clear();
        self.ends.extend(link.as_flattened().iter().copied().zip(0..));
        self.ends.sort_unstable();
        if link.is_empty() || !self.ends.chunk_by(|a, b| a.0 == b.0).all(|at| at.len() == 2) {
            return false;
        }
        self.other.resize(self.ends.len(), 0);
        for pair in self.ends.chunks_exact(2) {
            self.other[pair[0].1 as usize] = pair[1].1;
            self.other[pair[1].1 as usize] = pair[0].1;
        }
        let mut end = 0;
        loop {
            self.ring.push(link.as_flattened()[end as usize]);
            end = self.other[end as usize ^ 1];
            if end == 0 {
                return self.ring.len() == link.len();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{disjoint, non_manifold, shape};

    fn closed(mesh: &Mesh) -> Vec<bool> {
        let links = links(mesh);
        let mut fan = Fan::default();
        (0..mesh.vertices.len()).map(|v| fan.is_closed(links.at(v))).collect()
    }

    #[test]
    fn closed_fans_are_the_vertices_inside_a_manifold() {
        assert!(closed(&shape("sphere:2")).into_iter().all(|closed| closed));
        assert!(closed(&non_manifold()).into_iter().all(|closed| !closed));
        let inside = closed(&shape("grid:7x5"));
        for (v, closed) in inside.into_iter().enumerate() {
            let (x, y) = (v % 8, v / 8);
            assert_eq!(closed, x > 0 && x < 7 && y > 0 && y < 5);
        }
        // Two spheres that share a vertex.
        let sphere = shape("sphere:1");
        let mut pinched = disjoint([sphere.clone(), sphere.clone()]);
        let n = sphere.vertices.len();
        pinched.faces.iter_mut().flatten().filter(|v| **v == n as u32).for_each(|v| *v = 0);
        let open = |(v, closed): (usize, bool)| (!closed).then_some(v);
        let open: Vec<usize> = closed(&pinched).into_iter().enumerate().filter_map(open).collect();
        assert_eq!(open, [0, n]);
    }

    #[test]
    fn rings_are_cyclic_whatever_the_winding() {
        let mesh = crate::samples::flipped(shape("torus:9x7"));
        let links = links(&mesh);
        let mut fan = Fan::default();
        for v in 0..mesh.vertices.len() {
            assert!(fan.is_closed(links.at(v)));
            for (i, &a) in fan.ring.iter().enumerate() {
                let b = fan.ring[(i + 1) % fan.ring.len()];
                assert!(links.at(v).iter().any(|&link| link == [a, b] || link == [b, a]));
            }
        }
    }
}
