//! Subdivision until the edges of a textured mesh are short in its image.
//!
//! ```text
//! l_e = the largest length of edge e, in texels, in its faces;   all edges with l_e > N are divided at once, until l_e <= N
//! ```
//!
//! Edges are divided for all their faces, and for those of other vertices at the same positions, so that the mesh stays
//! conforming. A face is divided by the median of its longest divided side; by Apollonius' theorem, that is at most
//! sqrt(L^2 + 2 N^2) / 2 long if no side is longer than L and one is at most N, and at most N if two are. Thus L becomes
//! at most max(N, L / 2, sqrt(L^2 + 2 N^2) / 2), and the number of passes is about log2(L / N).

use std::collections::HashSet;

use super::Mesh;
use super::shapes::MAX_FACES;
use super::subdivide::Divided;
use super::weld::Weld;

/// The area of an equilateral face with edges of length 1: no face without longer edges is larger.
const LARGEST_AREA: f64 = 0.433_012_8;

/// Right-angled faces that are halved in both directions until their longest edge is a little shorter than N / 2 are
/// 7 < SLACK^2 times as many as equilateral ones with edges of length N.
const SLACK: f64 = 3.0;

/// More than [`MAX_FACES`] faces would be needed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TooFine {
    /// A length of edges, in texels, that is possible.
    pub possible: f64,
}

impl Mesh {
    /// The mesh with no edge longer than `most` texels. `density` are the numbers of texels along a unit of u and of v
    /// on each face, F x 2; 0 on faces without an image, which are divided only where their neighbors are. Colors and
    /// texture coordinates are interpolated linearly; the old vertices keep their indices.
    ///
    /// # Errors
    /// More than [`MAX_FACES`] faces would be needed.
    ///
    /// # Panics
    /// `most` is not positive, or the mesh has no texture coordinates.
    pub fn subdivided_to_texels(
        &self,
        mut density: Vec<[f64; 2]>,
        most: f64,
    ) -> Result<Self, TooFine> {
        assert!(most > 0.0 && density.len() == self.faces.len());
        let mut mesh = self.clone();
        let area: f64 = (0..density.len()).map(|j| mesh.texels(&density, j).area()).sum();
        let shortest = (area / (LARGEST_AREA * MAX_FACES as f64)).sqrt();
        if most < shortest {
            return Err(TooFine { possible: (SLACK * shortest).ceil() });
        }
        loop {
            let of = Weld::exact(&mesh).map(|weld| weld.of);
            let key = |a: u32, b: u32| {
                let [a, b] = [a, b].map(|v| of.as_ref().map_or(v, |of| of[v as usize]));
                (a.min(b), a.max(b))
            };
            let mut long = HashSet::new();
            for (j, &[v1, v2, v3]) in mesh.faces.iter().enumerate() {
                let lengths = mesh.texels(&density, j).lengths();
                for ((a, b), length) in [(v1, v2), (v2, v3), (v3, v1)].into_iter().zip(lengths) {
                    if length > most {
                        long.insert(key(a, b));
                    }
                }
            }
            if long.is_empty() {
                return Ok(mesh);
            }
            let divides = |a: u32, b: u32| long.contains(&key(a, b));
            let parts = |&[v1, v2, v3]: &[u32; 3]| {
                1 + [(v1, v2), (v2, v3), (v3, v1)].iter().filter(|&&(a, b)| divides(a, b)).count()
            };
            if mesh.faces.iter().map(parts).sum::<usize>() as u64 > MAX_FACES {
                return Err(TooFine { possible: (SLACK * most).ceil() });
            }
            let Divided { mesh: finer, whole, .. } =
                mesh.divided(divides, |j| mesh.texels(&density, j).lengths());
            density = whole.iter().map(|&j| density[j as usize]).collect();
            mesh = finer;
        }
    }

    /// Face j in its image.
    fn texels(&self, density: &[[f64; 2]], j: usize) -> Triangle {
        let uv = self.uv.as_ref().expect("texture coordinates")[j];
        Triangle(uv.map(|t| [0, 1].map(|axis| density[j][axis] * t[axis])))
    }
}

/// The corners of a face in its image, in texels. NaN if it has no image.
struct Triangle([[f64; 2]; 3]);

impl Triangle {
    /// The edges 12, 23, 31.
    fn edges(&self) -> [[f64; 2]; 3] {
        let Triangle(t) = self;
        [(0, 1), (1, 2), (2, 0)].map(|(a, b)| [t[b][0] - t[a][0], t[b][1] - t[a][1]])
    }

    fn lengths(&self) -> [f64; 3] {
        self.edges().map(|[x, y]| x.hypot(y))
    }

    /// 0 if it has no image.
    fn area(&self) -> f64 {
        let [[ax, ay], [bx, by], _] = self.edges();
        (0.5 * (ax * by - ay * bx)).abs().max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Statistics;
    use crate::samples::rng;
    use rand::RngExt;

    fn textured(text: &str) -> Mesh {
        text.parse::<crate::mesh::Shape>().unwrap().textured()
    }

    /// The length of the longest edge in texels; the density of a face is in its color.
    fn longest(mesh: &Mesh) -> f64 {
        let density = densities(mesh);
        let lengths = (0..density.len()).flat_map(|j| mesh.texels(&density, j).lengths());
        lengths.fold(0.0, f64::max)
    }

    fn densities(mesh: &Mesh) -> Vec<[f64; 2]> {
        mesh.face_colors.as_ref().unwrap().iter().map(|&[u, v, _]| [u, v]).collect()
    }

    fn refined(mesh: &mut Mesh, density: &[[f64; 2]], most: f64) -> Mesh {
        mesh.face_colors = Some(density.iter().map(|&[u, v]| [u, v, 0.0]).collect());
        mesh.subdivided_to_texels(density.to_vec(), most).unwrap()
    }

    /// A surface without boundary stays one, whose points are the same, although faces differ in their images.
    #[test]
    fn edges_are_short_and_the_surface_is_the_same() {
        let mut mesh = textured("torus:12x8");
        let mut rng = rng(161);
        let each = || [rng.random_range(0.0..300.0), rng.random_range(0.0..300.0)];
        let density: Vec<[f64; 2]> = std::iter::repeat_with(each).take(mesh.faces.len()).collect();
        let before = Statistics::of(&mesh);
        for most in [1.0, 2.5, 7.0] {
            let fine = refined(&mut mesh, &density, most);
            assert!(longest(&fine) <= most);
            let after = Statistics::of(&fine);
            assert!((after.area - before.area).abs() < 1e-12 * before.area);
            assert_eq!(after.euler_characteristic, before.euler_characteristic);
            let defects = [
                after.boundary_edges,
                after.non_manifold_edges,
                after.inconsistent_edges,
                after.degenerate_faces,
                after.duplicate_faces,
            ];
            assert_eq!(defects, [0; 5]);
            assert_eq!(fine.vertices[..mesh.vertices.len()], mesh.vertices);
        }
    }

    /// The number of faces is between those of equilateral faces with edges of N and of N / SLACK.
    #[test]
    fn edges_are_not_divided_without_need() {
        for (text, density) in [("grid:5x3", [100.0, 160.0]), ("torus:12x8", [512.0, 128.0])] {
            let mut mesh = textured(text);
            let density = vec![density; mesh.faces.len()];
            for most in [1.0, 2.5, 7.0] {
                let fine = refined(&mut mesh, &density, most);
                assert!(longest(&fine) <= most, "{text} {most}");
                let density = densities(&fine);
                let area: f64 = (0..density.len()).map(|j| fine.texels(&density, j).area()).sum();
                let least = area / (LARGEST_AREA * most * most);
                let share = fine.faces.len() as f64 / least;
                assert!((1.0..SLACK * SLACK).contains(&share), "{text} {most}: {share}");
            }
        }
    }

    /// Only faces with a fine image, and their neighbors, are divided.
    #[test]
    fn faces_without_an_image_stay() {
        let mesh = textured("grid:10x10");
        let left = |j: usize| mesh.corners(j).iter().all(|x| x.x < 0.31);
        let density: Vec<[f64; 2]> =
            (0..mesh.faces.len()).map(|j| if left(j) { [64.0; 2] } else { [0.0; 2] }).collect();
        let fine = mesh.subdivided_to_texels(density, 2.0).unwrap();
        assert!(fine.faces.len() > 4 * mesh.faces.len());
        let right = |mesh: &Mesh| -> Vec<[u32; 3]> {
            let all = (0..mesh.faces.len()).filter(|&j| mesh.corners(j).iter().all(|x| x.x > 0.39));
            all.map(|j| mesh.faces[j]).collect()
        };
        assert_eq!(right(&fine), right(&mesh));
        let unplaced =
            Mesh { uv: Some(vec![[[f64::NAN; 2]; 3]; mesh.faces.len()]), ..mesh.clone() };
        let none = vec![[0.0; 2]; mesh.faces.len()];
        let same = unplaced.subdivided_to_texels(none, 1.0).unwrap();
        assert_eq!(same.faces, mesh.faces);
    }

    /// A mesh whose faces share no vertices has no gaps after a weld.
    #[test]
    fn seams_stay_closed() {
        let whole = textured("torus:12x8");
        let corners = || 0..3 * whole.faces.len() as u32;
        let vertices = corners().map(|i| whole.corners(i as usize / 3)[i as usize % 3]).collect();
        let faces = corners().step_by(3).map(|i| [i, i + 1, i + 2]).collect();
        let soup = Mesh { uv: whole.uv.clone(), ..Mesh::new(vertices, faces) };
        let density = |j: usize| [5.0 + (j % 7) as f64 * 20.0; 2];
        let fine = soup.subdivided_to_texels((0..soup.faces.len()).map(density).collect(), 1.5);
        let welded = Weld::exact(&fine.unwrap()).unwrap().mesh;
        assert_eq!(Statistics::of(&welded).boundary_edges, 0);
        assert_eq!(Statistics::of(&welded).euler_characteristic, 0);
    }

    #[test]
    fn too_many_faces_are_refused_before_they_are_made() {
        let mesh = textured("grid:1x1");
        let refused =
            |most: f64| mesh.subdivided_to_texels(vec![[1e5; 2]; 2], most).unwrap_err().possible;
        assert_eq!([refused(1.0), refused(1e-300)], [65.0; 2]);
    }
}
