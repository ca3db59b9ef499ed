//! The surface that evolves.

use meshseg::evolve::images::Shot;
use meshseg::evolve::start::{around, cuboid, hull, sphere};
use meshseg::{Mesh, Result};
use nalgebra::{Point3, Vector3};

use super::arguments::Start;
use super::shots::Photographs;
use crate::cli::inputs::mesh_with_area;

/// Subdivisions of a sphere: 642 vertices.
const SUBDIVISIONS: u32 = 3;

/// Cells along an edge of a box: 602 vertices.
const CELLS: u32 = 10;

/// Cells along the longest side of a visual hull.
const HULL_CELLS: usize = 24;

/// Without a mask, pixels farther than this from the background show the surface.
const FROM_BACKGROUND: f64 = 0.15;

/// The surface to start from.
pub fn mesh(start: &Start, photographs: &Photographs) -> Result<Mesh> {
    let shots = &photographs.shots;
    let ball = || {
        let cameras: Vec<_> = shots.iter().map(|shot| (shot.view.camera, shot.size())).collect();
        around(&cameras)
    };
    match start {
        Start::Sphere(Some([x, y, z, r])) => Ok(sphere(Point3::new(*x, *y, *z), *r, SUBDIVISIONS)),
        Start::Sphere(None) => {
            let ball = ball()?;
            Ok(sphere(ball.center, ball.radius, SUBDIVISIONS))
        }
        Start::Box => {
            let ball = ball()?;
            let half = Vector3::repeat(ball.radius / 3.0_f64.sqrt());
            Ok(cuboid(ball.center - half, ball.center + half, CELLS))
        }
        Start::Hull => hull(&shots.iter().map(silhouette).collect::<Vec<_>>(), HULL_CELLS),
        Start::Mesh(path) => mesh_with_area(path),
    }
}

fn silhouette(shot: &Shot) -> meshseg::evolve::silhouette::Silhouette {
    let masked = shot.picture.has_mask();
    shot.silhouette(|color, background| {
        let squared: f64 = color.iter().zip(background).map(|(c, b)| (c - b).powi(2)).sum();
        masked || squared > FROM_BACKGROUND * FROM_BACKGROUND
    })
}
