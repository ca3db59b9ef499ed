//! Distances between two surfaces.
//!
//! ```text
//! d(x, B) = min_{y in B} |x - y|        mean(A, B) = 1/|A| int_A d(x, B) dA
//! int_j d dA = A_j ( 3/4 d(center) + 1/12 sum of d at the corners )
//! ```
//!
//! The rule is exact for quadratic functions, and its points include the vertices, where a piecewise linear surface
//! reaches out farthest. Faces of a coarse surface, across which the signed distance changes its sign, are divided until
//! there are some tens of thousands. Both directions are needed: a surface that lacks a horn lies on the whole one. All
//! lengths are divided by the diagonal of the bounding box of the second surface.
//!
//! Reference: P. Cignoni, C. Rocchini, R. Scopigno, *Metro: measuring error on simplified surfaces*, Computer Graphics
//! Forum 17(2), 1998.

use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use super::Mesh;
use super::geometry::barycentric_areas;
use super::tree::{Bounds, Tree};
use crate::sweep;

/// A surface with fewer faces is divided.
const MIN_FACES: usize = 20_000;

/// Distances relative to the diagonal of the second surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Distances {
    /// The mean over the first surface of the distance to the second.
    pub mean: f64,
    /// The mean over the second surface of the distance to the first.
    pub back: f64,
    /// The distance that 95 % of the area do not exceed, of the direction in which it is larger.
    pub percentile_95: f64,
    /// The largest distance in either direction.
    pub largest: f64,
}

/// The distances from a to b, such as the truth, and back.
///
/// # Panics
/// One of the meshes has no face with an area.
pub fn between(a: &Mesh, b: &Mesh) -> Distances {
    let [a, b] = [a, b].map(|mesh| mesh.without_degenerate_faces().0);
    let (forth, back) = sweep::join(|| Sampled::new(&a, &b), || Sampled::new(&b, &a));
    let corners = b.faces.iter().flatten().map(|&k| b.vertices[k as usize]);
    let Bounds { low, high } = Bounds::of(corners);
    let diagonal = (high - low).norm();
    Distances {
        mean: forth.mean() / diagonal,
        back: back.mean() / diagonal,
        percentile_95: forth.percentile(0.95).max(back.percentile(0.95)) / diagonal,
        largest: forth.largest().max(back.largest()) / diagonal,
    }
}

/// Distances at points of a surface, and their shares of its area.
struct Sampled {
    /// In ascending order of the distances.
    samples: Vec<[f64; 2]>,
    area: f64,
}

impl Sampled {
    fn new(from: &Mesh, to: &Mesh) -> Self {
        let tree = Tree::new(to);
        assert!(!from.faces.is_empty(), "there is a face with an area");
        let mut divided = Mesh::new(from.vertices.clone(), from.faces.clone());
        while divided.faces.len() < MIN_FACES {
            divided = divided.subdivided();
        }
        let from = &divided;
        let areas = barycentric_areas(from);
        let vertices = from.vertices.len();
        let mut samples = sweep::collect(vertices + from.faces.len(), |i| {
            let (x, weight) = match i.checked_sub(vertices) {
                // a_k is the sum of A_j / 3 over the faces at vertex k.
                None => (from.vertices[i], areas[i] / 4.0),
                Some(j) => (center(from.corners(j)), 0.75 * from.face_area(j)),
            };
            [if weight > 0.0 { tree.distance_squared(x).sqrt() } else { 0.0 }, weight]
        });
        samples.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
        let area = sweep::sum(samples.len(), |i| samples[i][1]);
        Sampled { samples, area }
    }

    fn mean(&self) -> f64 {
        let term = |i: usize| self.samples[i][0] * self.samples[i][1];
        sweep::sum(self.samples.len(), term) / self.area
    }

    fn percentile(&self, share: f64) -> f64 {
        let mut sum = 0.0;
        let reached = self.samples.iter().find(|[_, weight]| {
            sum += weight;
            sum >= share * self.area
        });
        reached.map_or_else(|| self.largest(), |[distance, _]| *distance)
    }

    fn largest(&self) -> f64 {
        self.samples.last().map_or(0.0, |[distance, _]| *distance)
    }
}

fn center([a, b, c]: [Point3<f64>; 3]) -> Point3<f64> {
    Point3::from((a.coords + b.coords + c.coords) / 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{bumpy, disjoint, shape, zoo};
    use crate::sweep::with_threads;
    use nalgebra::Vector3;

    fn moved(mut mesh: Mesh, by: [f64; 3]) -> Mesh {
        mesh.vertices.iter_mut().for_each(|x| *x += Vector3::from(by));
        mesh
    }

    #[test]
    fn a_surface_lies_on_itself_and_on_its_subdivision() {
        // Nearest points on thin faces are uncertain by the rounding error divided by the square of their aspect ratio.
        let thin = |name: &str| ["needles", "soup"].contains(&name);
        for (name, mesh) in zoo().into_iter().filter(|(name, _)| !thin(name)) {
            for same in [mesh.clone(), mesh.subdivided()] {
                let zero = between(&same, &mesh);
                assert!(zero.largest <= 1e-15, "{name}: {zero:?}");
            }
        }
    }

    #[test]
    fn parallel_planes_have_their_distance() {
        let plane = shape("grid:7x5");
        let above = moved(shape("grid:4x9"), [0.0, 0.0, 0.3]);
        let above = Mesh {
            vertices: above
                .vertices
                .iter()
                .map(|x| Point3::new(x.x, x.y * 5.0 / 7.0 / 2.25, x.z))
                .collect(),
            ..above
        };
        let diagonal = 1.0_f64.hypot(5.0 / 7.0);
        let Distances { mean, back, percentile_95, largest } = between(&above, &plane);
        for found in [mean, back, percentile_95, largest] {
            assert!((found - 0.3 / diagonal).abs() <= 1e-14, "{found}");
        }
    }

    /// The difference of the radii, up to the sagitta of the faces.
    #[test]
    fn concentric_spheres_have_the_difference_of_their_radii() {
        for level in [3, 4] {
            let unit = shape(&format!("sphere:{level}"));
            let sagitta = 0.25_f64.powi(level) * 0.3;
            let Distances { mean, back, largest, .. } = between(&unit.clone().scaled(1.1), &unit);
            let diagonal = 2.0 * 3.0_f64.sqrt();
            for found in [mean, back, largest] {
                assert!((found * diagonal - 0.1).abs() <= sagitta, "{found}");
            }
        }
    }

    /// Only one direction sees a missing part.
    #[test]
    fn what_is_missing_is_seen_on_the_way_back() {
        let sphere = shape("sphere:3");
        let both = disjoint([sphere.clone(), moved(sphere.clone(), [10.0, 0.0, 0.0])]);
        let found = between(&sphere, &both);
        assert!(found.mean <= 1e-15 && found.back > 0.3 && found.largest > 0.7, "{found:?}");
        assert!(found.percentile_95 > 0.7);
        let same = between(&both, &sphere);
        assert!(same.back <= 1e-15 && same.mean > 0.3);
    }

    /// A plane at an angle of arctan 1 / 2 has linear distances, which the rule integrates exactly.
    #[test]
    fn linear_distances_are_integrated_exactly() {
        let plane = moved(shape("grid:1x1").scaled(8.0), [-4.0, -4.0, 0.0]);
        let mut tilted = shape("grid:3x3");
        tilted.vertices.iter_mut().for_each(|x| x.z = x.x / 2.0 + 0.1);
        let found = between(&tilted, &plane);
        let diagonal = 8.0 * 2.0_f64.sqrt();
        assert!((found.mean * diagonal - 0.35).abs() <= 1e-14, "{found:?}");
    }

    /// Two faces that a plane crosses: the mean of |x - 1/2| over the unit square, up to the faces of the subdivision in
    /// which the sign changes.
    #[test]
    fn distances_of_changing_sign_are_integrated_on_coarse_faces() {
        let plane = moved(shape("grid:1x1").scaled(8.0), [-4.0, -4.0, 0.0]);
        let mut crossing = shape("grid:1x1");
        crossing.vertices.iter_mut().for_each(|x| x.z = x.x - 0.45);
        let found = between(&crossing, &plane);
        let exact = (0.45_f64.powi(2) + 0.55_f64.powi(2)) / 2.0;
        let mean = found.mean * 8.0 * 2.0_f64.sqrt();
        assert!((mean - exact).abs() <= 1e-4, "{mean} {exact}");
    }

    #[test]
    fn scale_and_threads_change_nothing() {
        let (a, b) = (bumpy(20), shape("grid:15x15"));
        let with = |threads| with_threads(Some(threads), || between(&a, &b)).unwrap();
        assert_eq!(with(1), with(2));
        let scaled = between(&a.clone().scaled(1e-3), &b.clone().scaled(1e-3));
        assert!((scaled.mean - with(1).mean).abs() <= 1e-13 * scaled.mean);
    }
}
