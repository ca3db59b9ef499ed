//! Shading normals at the corners of the faces.
//!
//! The normal of face j at vertex v is the area-weighted mean of the normals of those faces around v that
//! make less than 50 degrees with it. Orientation is ignored, so that flipped faces do not cancel their
//! neighbors, and creases stay sharp.

use nalgebra::Vector3;

use super::bands::for_each_band;
use crate::mesh::Mesh;

/// Faces that join across less than this angle are shaded as one smooth surface.
const SMOOTH_COSINE: f64 = 0.643;
/// Around vertices with more faces than this, whose pairs would be too many, faces are shaded flat.
const MAX_VALENCE: usize = 64;

/// Unit normals at the three corners of each face, on the side of the face's own normal.
pub(super) fn corner_normals(mesh: &Mesh) -> Vec<[Vector3<f32>; 3]> {
    let mut area = vec![Vector3::zeros(); mesh.faces.len()];
    for_each_band(&mut area, 1, |first, band| {
        for (i, area) in band.iter_mut().enumerate() {
            *area = mesh.area_vector(first + i);
        }
    });
    let around = Incidence::new(mesh);
    let mut normals = vec![[Vector3::zeros(); 3]; mesh.faces.len()];
    for_each_band(&mut normals, 1, |first, band| {
        for (i, normals) in band.iter_mut().enumerate() {
            let j = first + i;
            *normals = mesh.faces[j].map(|v| {
                let faces = around.faces(v as usize);
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

/// The faces around each vertex, in one list.
struct Incidence {
    start: Vec<usize>,
    face: Vec<u32>,
}

impl Incidence {
    fn new(mesh: &Mesh) -> Self {
        let mut start = vec![0; mesh.vertices.len() + 1];
        for &v in mesh.faces.iter().flatten() {
            start[v as usize + 1] += 1;
        }
        for v in 0..mesh.vertices.len() {
            start[v + 1] += start[v];
        }
        let mut next = start.clone();
        let mut face = vec![0; 3 * mesh.faces.len()];
        for (j, corners) in mesh.faces.iter().enumerate() {
            for &v in corners {
                face[next[v as usize]] = j as u32;
                next[v as usize] += 1;
            }
        }
        Incidence { start, face }
    }

    fn faces(&self, v: usize) -> &[u32] {
        &self.face[self.start[v]..self.start[v + 1]]
    }
}
