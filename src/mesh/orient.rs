//! Consistent orientation: flips faces such that neighbors agree and closed surfaces face outwards.
//!
//! Two faces agree along an edge if they traverse it in opposite directions. A breadth-first search across the edges
//! with exactly two faces spreads the orientation of the first face over a patch. With signs s_j for the faces that are
//! kept (1) or flipped (-1), a patch is closed if the directions of its faces cancel along each of its edges; then its
//! volume
//!
//! ```text
//! V = sum_j s_j det(x_{j,1} - c, x_{j,2} - c, x_{j,3} - c) / 6
//! ```
//!
//! does not depend on c and must be positive. A patch that is open, or encloses no volume, keeps the orientation of
//! most of its area. Faces with the same three corners in any order are represented by the first.

use std::collections::VecDeque;

use nalgebra::Matrix3;

use super::Mesh;
use super::incidence::Incidence;
use super::sides::{self, Side, sides};
use crate::sweep::{collect, ranges};

/// A consistently oriented mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Oriented {
    /// The vertices, and the faces with three different corners, each once; without colors, texture coordinates and
    /// materials.
    pub mesh: Mesh,
    /// The number of flipped faces.
    pub flipped: usize,
    /// Edges along which the faces still disagree, because the surface is one-sided or more than two faces meet there:
    /// more than one direction does not cancel.
    pub inconsistent_edges: usize,
    /// Patches of more than a hundredth of the area that enclose no volume, so that their outside is that of most of
    /// their faces in the file.
    pub open_patches: usize,
}

/// Smaller patches, as a fraction of the area, are not counted.
const SMALLEST_PATCH: f64 = 0.01;

/// Smaller volumes, relative to the sum of the absolute values of their terms, count as zero.
const NEGLIGIBLE_VOLUME: f64 = 1e-9;

const NO_FACE: u32 = u32::MAX;

/// In O(F log F) time.
pub fn orient(mesh: &Mesh) -> Oriented {
    let mut mesh = Mesh::new(mesh.vertices.clone(), once(&mesh.faces));
    let sides = sides(&mesh.faces);
    let edges = || sides::edges(&sides);

    // Across each side: the other face, and whether it must be flipped relative to this one.
    let mut across = vec![(NO_FACE, false); 3 * mesh.faces.len()];
    for edge in edges() {
        if let &[a, b] = edge {
            let turn = a.ascends == b.ascends;
            across[a.corner as usize] = (b.corner / 3, turn);
            across[b.corner as usize] = (a.corner / 3, turn);
        }
    }
    let (mut signs, patches, count) = spread(&across, mesh.faces.len());
    let (turn, open_patches) = patches_to_flip(&mesh, edges(), &signs, &patches, count);
    for (sign, &patch) in signs.iter_mut().zip(&patches) {
        *sign *= if turn[patch as usize] { -1 } else { 1 };
    }
    let inconsistent =
        |edge: &&[Side]| edge.iter().map(|side| direction(side, &signs)).sum::<i32>().abs() > 1;
    let inconsistent_edges = edges().filter(inconsistent).count();
    for (face, &sign) in mesh.faces.iter_mut().zip(&signs) {
        if sign < 0 {
            face.swap(1, 2);
        }
    }
    let flipped = signs.iter().filter(|&&sign| sign < 0).count();
    Oriented { mesh, flipped, inconsistent_edges, open_patches }
}

/// The faces with three different corners in their order, without duplicates.
fn once(faces: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let set = |j: usize| {
        let mut set = faces[j];
        set.sort_unstable();
        set
    };
    let first = collect(faces.len(), |j| [set(j)[0]]);
    let vertices = first.iter().map(|&[v]| v as usize + 1).max().unwrap_or(0);
    let mut sets =
        Incidence::in_ranges(&ranges(vertices), &first, |j, _| (set(j), j as u32)).into_values();
    let mut is_kept = vec![false; faces.len()];
    for same_first in sets.chunk_by_mut(|([a, ..], _), ([b, ..], _)| a == b) {
        same_first.sort_unstable();
        for same in same_first.chunk_by(|(a, _), (b, _)| a == b) {
            let ([a, b, c], j) = same[0];
            is_kept[j as usize] = a != b && b != c;
        }
    }
    faces.iter().zip(is_kept).filter_map(|(&face, is_kept)| is_kept.then_some(face)).collect()
}

/// The direction in which the face traverses the edge, with its sign.
fn direction(side: &Side, signs: &[i8]) -> i32 {
    i32::from(signs[side.face()]) * if side.ascends { 1 } else { -1 }
}

/// Signs that agree with those of the neighbors as far as possible, the patch of each face, and the number of patches.
fn spread(across: &[(u32, bool)], faces: usize) -> (Vec<i8>, Vec<u32>, usize) {
    let mut signs = vec![0_i8; faces];
    let mut patches = vec![0; faces];
    let mut count = 0;
    let mut queue = VecDeque::new();
    for begin in 0..faces {
        if signs[begin] != 0 {
            continue;
        }
        signs[begin] = 1;
        queue.push_back(begin);
        while let Some(j) = queue.pop_front() {
            patches[j] = count;
            for &(neighbor, turn) in &across[3 * j..3 * j + 3] {
                if neighbor != NO_FACE && signs[neighbor as usize] == 0 {
                    signs[neighbor as usize] = if turn { -signs[j] } else { signs[j] };
                    queue.push_back(neighbor as usize);
                }
            }
        }
        count += 1;
    }
    (signs, patches, count as usize)
}

/// The patches that face inwards, or opposite to most of their area, and the number of open patches that are large
/// enough to count.
fn patches_to_flip<'a>(
    mesh: &Mesh,
    edges: impl Iterator<Item = &'a [Side]>,
    signs: &[i8],
    patches: &[u32],
    count: usize,
) -> (Vec<bool>, usize) {
    let mut closed = vec![true; count];
    for edge in edges {
        let mut directions: Vec<(u32, i32)> =
            edge.iter().map(|side| (patches[side.face()], direction(side, signs))).collect();
        directions.sort_unstable();
        for patch in directions.chunk_by(|a, b| a.0 == b.0) {
            closed[patch[0].0 as usize] &=
                patch.iter().map(|(_, direction)| direction).sum::<i32>() == 0;
        }
    }
    let mut origins = vec![None; count];
    // The volume, the sum of its absolute terms, the area that is kept minus the area that is flipped, and the total
    // area.
    let mut sums = vec![[0.0; 4]; count];
    for (j, (&sign, &patch)) in signs.iter().zip(patches).enumerate() {
        let corners = mesh.corners(j);
        let origin = *origins[patch as usize].get_or_insert(corners[0]);
        let volume =
            f64::from(sign) * Matrix3::from_columns(&corners.map(|x| x - origin)).determinant();
        let area = mesh.face_area(j);
        let terms = [volume, volume.abs(), f64::from(sign) * area, area];
        sums[patch as usize].iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
    }
    let all: f64 = sums.iter().map(|sums| sums[3]).sum();
    let mut open_patches = 0;
    let mut inwards = |(&closed, &[volume, size, stays, area]): (&bool, &[f64; 4])| {
        if closed && volume.abs() > NEGLIGIBLE_VOLUME * size {
            return volume < 0.0;
        }
        open_patches += usize::from(area > SMALLEST_PATCH * all);
        stays < 0.0
    };
    let turn = closed.iter().zip(&sums).map(&mut inwards).collect();
    (turn, open_patches)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Statistics;
    use crate::mesh::curvature::mean_curvature;
    use crate::samples::{disjoint, flipped, rng, shape, shuffled, zoo};
    use nalgebra::{Point3, Vector3};
    use rand::RngExt;
    use std::f64::consts::TAU;

    fn inside_out(mut mesh: Mesh) -> Mesh {
        mesh.faces.iter_mut().for_each(|face| face.swap(1, 2));
        mesh
    }

    /// Flips random faces and rotates their corners.
    fn disturbed(mesh: &Mesh, seed: u64) -> Mesh {
        let mut mesh = mesh.clone();
        let mut rng = rng(seed);
        for face in &mut mesh.faces {
            face.rotate_left(rng.random_range(0..3));
            if rng.random() {
                face.swap(1, 2);
            }
        }
        mesh
    }

    /// A band of n cells with that number of half twists.
    fn band(n: u32, twists: u32) -> Mesh {
        let point = |i: u32, side: f64| {
            let s = TAU * f64::from(i) / f64::from(n);
            let t = 0.5 * f64::from(twists) * s;
            let out = 1.0 + side * 0.3 * t.cos();
            Point3::new(out * s.cos(), out * s.sin(), side * 0.3 * t.sin())
        };
        let vertices = (0..n).flat_map(|i| [-1.0, 0.0, 1.0].map(|side| point(i, side))).collect();
        let at = |i: u32, row: u32| {
            let flipped = i == n && !twists.is_multiple_of(2);
            3 * (i % n) + if flipped { 2 - row } else { row }
        };
        let cell = |i: u32, row: u32| {
            let [a, b, c, d] = [at(i, row), at(i + 1, row), at(i + 1, row + 1), at(i, row + 1)];
            [[a, b, c], [a, c, d]]
        };
        let faces = (0..n).flat_map(|i| [cell(i, 0), cell(i, 1)].concat()).collect();
        Mesh::new(vertices, faces)
    }

    #[test]
    fn flipped_faces_are_flipped_back() {
        for mesh in [
            shape("sphere:3"),
            shape("torus:30x20"),
            shape("torus:7x5"),
            flipped(shape("sphere:2")),
        ] {
            let upright = orient(&mesh);
            let curvature = mean_curvature(&upright.mesh);
            assert_eq!(Statistics::of(&upright.mesh).inconsistent_edges, 0);
            for seed in 0..4 {
                let oriented = orient(&disturbed(&mesh, seed));
                assert_eq!(oriented.inconsistent_edges, 0);
                for (h, g) in mean_curvature(&oriented.mesh).iter().zip(&curvature) {
                    assert!((h - g).abs() <= 1e-9 * g.abs().max(1.0));
                }
            }
            assert_eq!(orient(&upright.mesh), Oriented { flipped: 0, ..upright.clone() });
            let oriented = orient(&inside_out(upright.mesh.clone()));
            assert_eq!((oriented.flipped, oriented.inconsistent_edges), (mesh.faces.len(), 0));
        }
    }

    /// Each closed surface is oriented separately, wherever it is and however small.
    #[test]
    fn closed_surfaces_face_outwards() {
        let sphere = shape("sphere:3");
        let far = |mut mesh: Mesh| {
            mesh.vertices.iter_mut().for_each(|x| *x += Vector3::new(1e4, -2e4, 5e3));
            mesh
        };
        let small = sphere.clone().scaled(0.5);
        let nested =
            disjoint([disturbed(&sphere, 1), inside_out(small), far(inside_out(sphere.clone()))]);
        let oriented = orient(&nested);
        let curvature = mean_curvature(&oriented.mesh);
        let n = sphere.vertices.len();
        for (k, h) in curvature.iter().enumerate() {
            let expected = if k / n == 1 { 2.0 } else { 1.0 };
            assert!((h / expected - 1.0).abs() < 0.02, "{h}");
        }
        for tiny in [1e-30, 1e30] {
            assert_eq!(
                orient(&inside_out(sphere.clone().scaled(tiny))).flipped,
                sphere.faces.len()
            );
        }
    }

    #[test]
    fn open_surfaces_keep_the_orientation_of_most_of_their_area() {
        let mut bowl = shape("sphere:3");
        bowl.faces.retain(|face| face.iter().all(|&k| bowl.vertices[k as usize].z < 0.3));
        for most in [bowl.clone(), inside_out(bowl)] {
            let mut mesh = most.clone();
            mesh.faces.iter_mut().step_by(3).for_each(|face| face.swap(0, 1));
            let oriented = orient(&mesh);
            let normals = |mesh: &Mesh, j: usize| mesh.area_vector(j);
            assert!(
                (0..most.faces.len())
                    .all(|j| { normals(&oriented.mesh, j).dot(&normals(&most, j)) > 0.0 })
            );
            assert_eq!(oriented.flipped, most.faces.len().div_ceil(3));
        }
    }

    #[test]
    fn bands_with_a_half_twist_have_one_side() {
        for (twists, sided) in [(0, true), (1, false), (2, true), (3, false)] {
            let oriented = orient(&disturbed(&band(40, twists), 8));
            assert_eq!(oriented.inconsistent_edges == 0, sided, "{twists}");
            let exact = Statistics::of(&oriented.mesh).inconsistent_edges;
            assert_eq!(oriented.inconsistent_edges, exact);
        }
    }

    /// Two cubes that share an edge are two closed surfaces; three sheets at an edge disagree in at most one direction.
    #[test]
    fn edges_of_many_faces_separate_surfaces() {
        let cube = |shift: f64| {
            let at = |i: u32| [i & 1, i >> 1 & 1, i >> 2].map(f64::from);
            let vertices: Vec<_> =
                (0..8).map(|i| Point3::from(at(i)) + Vector3::new(shift, shift, 0.0)).collect();
            let quads = [
                [0, 2, 3, 1],
                [4, 5, 7, 6],
                [0, 1, 5, 4],
                [2, 6, 7, 3],
                [0, 4, 6, 2],
                [1, 3, 7, 5],
            ];
            Mesh::new(
                vertices,
                quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
            )
        };
        let touching = disjoint([cube(0.0), inside_out(cube(1.0))]);
        let welded = crate::mesh::Weld::exact(&touching).unwrap().mesh;
        assert_eq!(Statistics::of(&welded).non_manifold_edges, 1);
        let oriented = orient(&welded);
        assert_eq!((oriented.flipped, oriented.inconsistent_edges), (12, 0));

        let points = [
            [0.0, 0.0, 0.0],
            [0.0, 0.0, 1.0],
            [1.0, 0.0, 0.0],
            [-1.0, 1.0, 0.0],
            [-1.0, -1.0, 0.0],
        ];
        let sheets =
            |faces: &[[u32; 3]]| Mesh::new(points.map(Point3::from).to_vec(), faces.to_vec());
        assert_eq!(orient(&sheets(&[[0, 1, 2], [1, 0, 3], [1, 0, 4]])).inconsistent_edges, 0);
        assert_eq!(orient(&sheets(&[[0, 1, 2], [0, 1, 3], [0, 1, 4]])).inconsistent_edges, 1);
    }

    #[test]
    fn duplicate_faces_count_once() {
        let sphere = shape("sphere:2");
        let mut both = sphere.clone();
        both.faces.extend(inside_out(sphere.clone()).faces);
        both.faces.extend([[0, 0, 1], [3, 3, 3]]);
        let oriented = orient(&both);
        assert_eq!(oriented.mesh.faces, sphere.faces);
        assert_eq!((oriented.flipped, oriented.inconsistent_edges), (0, 0));
    }

    /// Flipping and renumbering do not matter on any mesh of the zoo.
    #[test]
    fn the_result_does_not_depend_on_the_order() {
        for (name, mesh) in zoo() {
            let (renumbered, before) = shuffled(&mesh, &mut rng(31));
            let (a, b) = (orient(&mesh), orient(&renumbered));
            assert_eq!(a.mesh.faces.len(), b.mesh.faces.len(), "{name}");
            if !["non-manifold", "soup", "flipped"].contains(&name) {
                assert_eq!(
                    (a.flipped, a.inconsistent_edges),
                    (b.flipped, b.inconsistent_edges),
                    "{name}"
                );
                let curvature = mean_curvature(&a.mesh);
                for (v, h) in mean_curvature(&b.mesh).into_iter().enumerate() {
                    let g = curvature[before[v] as usize];
                    assert!(
                        h.is_nan() == g.is_nan()
                            && (g.is_nan() || (h - g).abs() <= 1e-6 * g.abs().max(1.0)),
                        "{name}"
                    );
                }
            }
        }
    }
}
