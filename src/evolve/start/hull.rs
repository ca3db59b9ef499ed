//! The visual hull: the points that every view shows inside its silhouette.
//!
//! ```text
//! v(x) = min_i d_i(K (R x + t) / z) z / f_i       d_i: signed distance to the contour in image i, in pixels
//! ```
//!
//! The hull is v > 0, and near its surface v is about the distance to it, so that the surface between the points of a
//! grid is found by interpolation. Before that, v becomes (2 S - S^2) v with means S over neighboring points: the steps of
//! pixels and fins that are thinner than a step of the grid disappear, and the rest changes in fourth order. The genus is
//! that of the scene if the silhouettes show every hole.
//!
//! Reference: A. Laurentini, *The visual hull concept for silhouette-based image understanding*, IEEE PAMI 16(2), 1994.

mod extent;

use nalgebra::Point3;

use super::signed_distance::SignedDistance;
use super::tetrahedra::{Grid, surface};
use crate::error::{Error, Result};
use crate::evolve::remesh::{collapse_below, flip};
use crate::evolve::silhouette::Silhouette;
use crate::evolve::smoothing::tangential;
use crate::mesh::Mesh;
use crate::mesh::disjoint_sets::DisjointSets;
use crate::sweep;
use extent::extent;

/// Parts with less of the volume of the largest one are errors of the silhouettes.
const LEAST_VOLUME: f64 = 0.01;

/// Edges are collapsed up to this length in steps of the grid: marching tetrahedra make edges of all lengths up to 1.7.
const SHORT: f64 = 0.7;

/// How often short edges are collapsed, edges flipped, and vertices moved.
const ROUNDS: usize = 5;

/// Edges are flipped between faces within this angle: surfaces of tetrahedra are rough.
const FLIP_ANGLE: f64 = 45.0 * std::f64::consts::PI / 180.0;

/// How far vertices move within the surface in each round.
const TANGENTIAL: f64 = 0.3;

/// The surface of the visual hull, closed and without edges that are much shorter than the steps of a grid with
/// `resolution` of these along the longest side of the hull. The hull continues beyond the image where a silhouette is cut
/// off at its border.
///
/// # Errors
/// There are no silhouettes or one of them is empty, no point is inside all of them, or the hull reaches to the cameras.
///
/// # Panics
/// The resolution is not from 4 to 512.
pub fn hull(silhouettes: &[Silhouette], resolution: usize) -> Result<Mesh> {
    assert!((4..=512).contains(&resolution), "resolution {resolution}");
    let bounds = extent(silhouettes)?;
    let sides = bounds.high - bounds.low;
    let step = sides.max() / resolution as f64;
    // A layer of points outside on every side.
    let grid = Grid {
        origin: bounds.low.map(|x| x - step),
        step,
        size: [0, 1, 2].map(|i| (sides[i] / step).ceil() as usize + 3),
    };
    let views: Vec<(&Silhouette, SignedDistance)> =
        silhouettes.iter().map(|silhouette| (silhouette, SignedDistance::of(silhouette))).collect();
    let mut values = sweep::collect(grid.len(), |i| depth_inside(&views, grid.point(i)));
    let once = smoothed(&grid, &values);
    let twice = smoothed(&grid, &once);
    sweep::sweep((&mut values[..], &once[..], &twice[..]), |_, (v, once, twice)| {
        *v = 2.0 * once - twice;
    });
    (0..grid.len()).filter(|&i| grid.is_border(i)).for_each(|i| values[i] = -step);
    let mesh = large_parts(&surface(&grid, &values));
    if mesh.faces.is_empty() {
        return Err(Error::unsuitable(format!(
            "the visual hull is thinner than a {resolution}th of its length; choose a finer grid, or check the masks",
        )));
    }
    Ok(regular(mesh, SHORT * step))
}

/// v at a point, negative outside of the hull.
fn depth_inside(views: &[(&Silhouette, SignedDistance)], x: Point3<f64>) -> f64 {
    let mut smallest = f64::INFINITY;
    for (Silhouette { camera, .. }, distance) in views {
        let at = camera.project(x);
        if at.w <= 0.0 {
            return -1.0;
        }
        let pixels_per_unit = camera.pixels_per_unit().sqrt() * at.w;
        smallest = smallest.min(distance.at(at.x, at.y) / pixels_per_unit);
    }
    smallest
}

/// S v, the means (v_{i-1} + 2 v_i + v_{i+1}) / 4 along all axes. Values at the ends of an axis stay.
fn smoothed(grid: &Grid, values: &[f64]) -> Vec<f64> {
    (0..3).fold(values.to_vec(), |values, axis| {
        let stride = grid.size[..axis].iter().product::<usize>();
        sweep::collect(grid.len(), |i| {
            let at = grid.coordinates(i)[axis];
            if at == 0 || at + 1 == grid.size[axis] {
                return values[i];
            }
            0.25 * (values[i - stride] + 2.0 * values[i] + values[i + stride])
        })
    })
}

/// The mesh without the parts that have little volume, and without the vertices of these.
fn large_parts(mesh: &Mesh) -> Mesh {
    let mut joined = DisjointSets::new(mesh.vertices.len());
    mesh.faces.iter().for_each(|&[a, b, c]| {
        joined.join(a, b);
        joined.join(a, c);
    });
    let roots: Vec<usize> =
        (0..mesh.vertices.len() as u32).map(|k| joined.root(k) as usize).collect();
    let mut volumes = vec![0.0; mesh.vertices.len()];
    for (j, face) in mesh.faces.iter().enumerate() {
        let [a, b, c] = mesh.corners(j).map(|x| x - mesh.vertices[0]);
        volumes[roots[face[0] as usize]] += a.dot(&b.cross(&c)) / 6.0;
    }
    let largest = volumes.iter().fold(0.0, |largest: f64, &v| largest.max(v));
    let keep = |k: usize| volumes[roots[k]] > LEAST_VOLUME * largest;
    let mut index = vec![0; mesh.vertices.len()];
    let mut vertices = Vec::new();
    for (k, x) in mesh.vertices.iter().enumerate().filter(|&(k, _)| keep(k)) {
        index[k] = vertices.len() as u32;
        vertices.push(*x);
    }
    let kept = mesh.faces.iter().filter(|face| keep(face[0] as usize));
    Mesh::new(vertices, kept.map(|face| face.map(|k| index[k as usize])).collect())
}

/// The surface with faces of about the same size and shape.
fn regular(mut mesh: Mesh, short: f64) -> Mesh {
    for _ in 0..ROUNDS {
        loop {
            let next = collapse_below(&mesh, short).mesh;
            if next.faces.len() == mesh.faces.len() {
                break;
            }
            mesh = next;
        }
        mesh = flip(&mesh, FLIP_ANGLE).mesh;
        let places = tangential(&mesh, TANGENTIAL);
        mesh.vertices = places.into_iter().map(Point3::from).collect();
    }
    mesh
}
