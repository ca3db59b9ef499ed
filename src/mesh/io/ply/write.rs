//! Writing PLY: binary little endian, coordinates as doubles so that they read back to the same bits.

use std::io::{self, Write};
use std::path::Path;

use crate::error::Result;
use crate::file;
use crate::mesh::Mesh;
use crate::mesh::io::coordinates;

pub fn write(out: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    write_all(out, mesh, mesh.colors.as_deref(), None)
}

/// Writes a mesh with a color and a label per vertex (`uchar` all of them: some readers abort on vertices with
/// extras of several types).
///
/// `colors` are RGB in [0, 1]; both slices have one entry per vertex.
///
/// # Errors
/// The file cannot be written.
pub fn write_labeled(path: &Path, mesh: &Mesh, colors: &[[f64; 3]], labels: &[u8]) -> Result<()> {
    file::write(path, |out| write_all(out, mesh, Some(colors), Some(labels)))
}

fn write_all(
    out: &mut dyn Write,
    mesh: &Mesh,
    colors: Option<&[[f64; 3]]>,
    labels: Option<&[u8]>,
) -> io::Result<()> {
    assert!(colors.is_none_or(|colors| colors.len() == mesh.vertices.len()));
    assert!(labels.is_none_or(|labels| labels.len() == mesh.vertices.len()));
    writeln!(out, "ply\nformat binary_little_endian 1.0")?;
    writeln!(out, "element vertex {}", mesh.vertices.len())?;
    writeln!(out, "property double x\nproperty double y\nproperty double z")?;
    if colors.is_some() {
        writeln!(out, "property uchar red\nproperty uchar green\nproperty uchar blue")?;
    }
    if labels.is_some() {
        writeln!(out, "property uchar label")?;
    }
    writeln!(out, "element face {}", mesh.faces.len())?;
    writeln!(out, "property list uchar uint vertex_indices")?;
    if mesh.uv.is_some() {
        writeln!(out, "property list uchar double texcoord")?;
    }
    writeln!(out, "end_header")?;
    for (k, x) in mesh.vertices.iter().enumerate() {
        for x in coordinates(x) {
            out.write_all(&x.to_le_bytes())?;
        }
        if let Some(colors) = colors {
            // A float becomes an integer by saturation, so that nothing outside [0, 1] wraps around.
            out.write_all(&colors[k].map(|c| (255.0 * c).round() as u8))?;
        }
        if let Some(labels) = labels {
            out.write_all(&[labels[k]])?;
        }
    }
    for (j, face) in mesh.faces.iter().enumerate() {
        out.write_all(&[3])?;
        for k in face {
            out.write_all(&k.to_le_bytes())?;
        }
        if let Some(uv) = &mesh.uv {
            out.write_all(&[6])?;
            for t in uv[j].as_flattened() {
                out.write_all(&t.to_le_bytes())?;
            }
        }
    }
    Ok(())
}
