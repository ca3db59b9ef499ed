//! The choice of the surface to start from.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use nalgebra::{Point3, Vector3};

use super::{around, cuboid, hull, sphere};
use crate::error::Result;
use crate::evolve::images::{Shot, squared_distance};
use crate::evolve::silhouette::Silhouette;
use crate::mesh::Mesh;

/// Subdivisions of a sphere: 642 vertices.
const SUBDIVISIONS: u32 = 3;

/// Cells along an edge of a box: 602 vertices.
const CELLS: u32 = 10;

/// Cells along the longest side of a visual hull.
const HULL_CELLS: usize = 24;

/// Without a mask, pixels farther than this from the background show the surface.
const FROM_BACKGROUND: f64 = 0.15;

/// The surface to start from.
#[derive(Clone, Debug, PartialEq)]
pub enum Choice {
    /// A sphere of this center and radius, in the middle of what the cameras see if it has none.
    Sphere(Option<[f64; 4]>),
    /// A box in the middle of what the cameras see.
    Box,
    /// The visual hull.
    Hull,
    /// A mesh, as the argument MESH names it.
    Mesh(PathBuf),
}

impl FromStr for Choice {
    type Err = &'static str;

    fn from_str(text: &str) -> std::result::Result<Self, Self::Err> {
        match text {
            "sphere" => return Ok(Choice::Sphere(None)),
            "box" => return Ok(Choice::Box),
            "hull" => return Ok(Choice::Hull),
            _ => {}
        }
        let Some(numbers) = text.strip_prefix("sphere:").filter(|text| text.contains(',')) else {
            return Ok(Choice::Mesh(text.into()));
        };
        let numbers = numbers.split(',').map(|number| number.trim().parse().ok());
        let numbers: Option<Vec<f64>> = numbers.collect();
        let ball = numbers.and_then(|numbers| <[f64; 4]>::try_from(numbers).ok());
        let possible = |ball: &[f64; 4]| ball.iter().all(|x| x.is_finite()) && ball[3] > 0.0;
        ball.filter(possible)
            .map(|ball| Choice::Sphere(Some(ball)))
            .ok_or("must be sphere:CX,CY,CZ,R, with a radius R above 0")
    }
}

impl Choice {
    /// The surface for these photographs; `read` reads a mesh.
    ///
    /// # Errors
    /// The cameras do not look at one point, there is no visual hull, or the mesh cannot be read.
    pub fn mesh(&self, shots: &[Shot], read: impl Fn(&Path) -> Result<Mesh>) -> Result<Mesh> {
        let ball = || {
            let cameras: Vec<_> =
                shots.iter().map(|shot| (shot.view.camera, shot.size())).collect();
            around(&cameras)
        };
        match self {
            Choice::Sphere(Some([x, y, z, r])) => {
                Ok(sphere(Point3::new(*x, *y, *z), *r, SUBDIVISIONS))
            }
            Choice::Sphere(None) => {
                let ball = ball()?;
                Ok(sphere(ball.center, ball.radius, SUBDIVISIONS))
            }
            Choice::Box => {
                let ball = ball()?;
                let half = Vector3::repeat(ball.radius / 3.0_f64.sqrt());
                Ok(cuboid(ball.center - half, ball.center + half, CELLS))
            }
            Choice::Hull => hull(&shots.iter().map(silhouette).collect::<Vec<_>>(), HULL_CELLS),
            Choice::Mesh(path) => read(path),
        }
    }
}

fn silhouette(shot: &Shot) -> Silhouette {
    let masked = shot.picture.has_mask();
    shot.silhouette(|color, background| {
        masked || squared_distance(color, background) > FROM_BACKGROUND * FROM_BACKGROUND
    })
}
