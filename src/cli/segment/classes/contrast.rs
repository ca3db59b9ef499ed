//! `--edge-aware`: where cuts are cheap.

use crate::mesh::Mesh;
use crate::mesh::contrast::Contrast;
use crate::{Error, Result};

use super::arguments::EdgeAware;
use super::input::numbers;
use crate::cli::memory::Memory;

/// What weights the edges.
///
/// # Errors
/// The mesh has no colors, the file cannot be read, or does not have a positive weight per face.
pub fn read(edge_aware: &EdgeAware, mesh: &Mesh, memory: &Memory) -> Result<Contrast> {
    let path = match edge_aware {
        EdgeAware::Normals => return Ok(Contrast::Normals),
        EdgeAware::Colors => return colors(mesh).map(Contrast::Colors),
        EdgeAware::File(path) => path,
    };
    let weights = numbers(path, "weights", memory)?;
    let faces = mesh.faces.len();
    if weights.dim() != (faces, 1) {
        let (rows, columns) = weights.dim();
        let message = format!(
            "has {rows} x {columns} numbers, but the mesh has {faces} faces; supply one weight per face"
        );
        return Err(Error::malformed(path, message));
    }
    let weights: Vec<f64> = weights.iter().copied().collect();
    if let Some(j) = weights.iter().position(|w| !(*w > 0.0 && w.is_finite())) {
        let message = format!(
            "the weight of face {j} is {:?}: weights must be positive and finite, so that no cut is free",
            weights[j]
        );
        return Err(Error::malformed(path, message));
    }
    Ok(Contrast::Faces(weights))
}

/// The color of each face.
fn colors(mesh: &Mesh) -> Result<Vec<[f64; 3]>> {
    if let Some(colors) = &mesh.face_colors {
        return Ok(colors.clone());
    }
    let Some(colors) = &mesh.colors else {
        let message = "--edge-aware colors: the mesh has no colors; use --edge-aware normals, or weights of a file";
        return Err(Error::unsuitable(message));
    };
    let mean = |face: &[u32; 3]| {
        let corners = face.map(|v| colors[v as usize]);
        [0, 1, 2].map(|c| corners.iter().map(|color| color[c]).sum::<f64>() / 3.0)
    };
    Ok(mesh.faces.iter().map(mean).collect())
}
