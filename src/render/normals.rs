//! Shading normals at the corners of the faces.
//!
//! The normal of face j at vertex v is the area-weighted mean of the normals of the faces around v that make an
//! angle of less than 50 degrees with it. Orientation is ignored, so that flipped faces do not cancel their
//! neighbors; creases stay sharp.

use nalgebra::Vector3;

use crate::mesh::{Incidence, Mesh};
use crate::optics::bands::for_each_band;

/// The cosine of the angle below which adjacent faces are shaded as one smooth surface.
const SMOOTH_COSINE: f64 = 0.643;
/// Faces are shaded flat around vertices with more faces than this, which would have too many pairs.
const MAX_VALENCE: usize = 64;

/// Unit normals at the three corners of each face, on the side of the face's own normal.
pub(super) fn corner_normals(mesh: &Mesh) -> Vec<[Vector3<f32>; 3]> {
    let mut area = vec![Vector3::zeros(); mesh.faces.len()];
    for_each_band(&mut area, 1, |first, band| {
        for (i, area) in band.iter_mut().enumerate() {
            *area = mesh.area_vector(first + i);
        }
    });
    let around = Incidence::new(mesh, |j, _| j as u32);
    let mut normals = vec![[Vector3::zeros(); 3]; mesh.faces.len()];
    for_each_band(&mut normals, 1, |first, band| {
        for (i, normals) in band.iter_mut().enumerate() {
            let j = first + i;
            *normals = mesh.faces[j].map(|v| {
                let faces = around.at(v as usize);
                let mut sum = area[j];
                if faces.len() <= MAX_VALENCE {
                    for other in faces.iter().filter(|&&i| i as usize != j) {
                        let other = area[*other as usize];
                        let cosine = other.dot(&area[j]);
                        let whole = other.norm_squared() * area[j].norm_squared();
                        if cosine * cosine > SMOOTH_COSINE * SMOOTH_COSINE * whole {
                            sum += other * cosine.signum();
                        }
                    }
                }
                sum.try_normalize(0.0).unwrap_or_else(Vector3::zeros).cast::<f32>()
            });
        }
    });
    normals
}
