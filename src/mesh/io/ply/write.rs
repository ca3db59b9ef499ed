//! Writing PLY: binary little endian, coordinates as doubles so that they read back to the same bits.

use std::io::{self, Write};
use std::path::Path;

use crate::error::Result;
use crate::file;
use crate::mesh::Mesh;
use crate::mesh::io::coordinates;
use crate::sweep::collect;

pub fn write(out: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    match &mesh.colors {
        None => {
            header(out, mesh, "")?;
            records::<24>(out, mesh.vertices.len(), |k, record| position(mesh, k, record))?;
        }
        Some(colors) => {
            header(out, mesh, COLOR)?;
            records::<27>(out, mesh.vertices.len(), |k, record| {
                position(mesh, k, record);
                record[24..].copy_from_slice(&bytes(colors[k]));
            })?;
        }
    }
    faces(out, mesh)
}

/// Writes a mesh with a color and a label per vertex (`uchar` all of them: some readers abort on vertices with
/// extras of several types).
///
/// `labels` has one entry per vertex, `colors` one RGB in [0, 1] per label.
///
/// # Errors
/// The file cannot be written.
pub fn write_labeled(path: &Path, mesh: &Mesh, labels: &[u8], colors: &[[f64; 3]]) -> Result<()> {
    assert_eq!(labels.len(), mesh.vertices.len());
    let colors: Vec<[u8; 3]> = colors.iter().copied().map(bytes).collect();
    file::write(path, |out| {
        header(out, mesh, &format!("{COLOR}property uchar label\n"))?;
        records::<28>(out, mesh.vertices.len(), |k, record| {
            position(mesh, k, record);
            record[24..27].copy_from_slice(&colors[usize::from(labels[k])]);
            record[27] = labels[k];
        })?;
        faces(out, mesh)
    })
}

const COLOR: &str = "property uchar red\nproperty uchar green\nproperty uchar blue\n";

/// What stands before the numbers; `extras` are the properties of a vertex besides its position.
fn header(out: &mut dyn Write, mesh: &Mesh, extras: &str) -> io::Result<()> {
    writeln!(out, "ply\nformat binary_little_endian 1.0")?;
    writeln!(out, "element vertex {}", mesh.vertices.len())?;
    writeln!(out, "property double x\nproperty double y\nproperty double z")?;
    write!(out, "{extras}")?;
    writeln!(out, "element face {}", mesh.faces.len())?;
    writeln!(out, "property list uchar uint vertex_indices")?;
    if mesh.uv.is_some() {
        writeln!(out, "property list uchar double texcoord")?;
    }
    writeln!(out, "end_header")
}

fn faces(out: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    match &mesh.uv {
        None => records::<13>(out, mesh.faces.len(), |j, record| corners(mesh, j, record)),
        Some(uv) => records::<62>(out, mesh.faces.len(), |j, record| {
            corners(mesh, j, record);
            record[13] = 6;
            for (bytes, t) in record[14..].chunks_exact_mut(8).zip(uv[j].as_flattened()) {
                bytes.copy_from_slice(&t.to_le_bytes());
            }
        }),
    }
}

/// Writes n records of fixed size, made side by side.
fn records<const SIZE: usize>(
    out: &mut dyn Write,
    n: usize,
    fill: impl Fn(usize, &mut [u8; SIZE]) + Sync,
) -> io::Result<()> {
    let records = collect(n, |index| {
        let mut record = [0; SIZE];
        fill(index, &mut record);
        record
    });
    out.write_all(records.as_flattened())
}

#[inline(always)]
fn position(mesh: &Mesh, k: usize, record: &mut [u8]) {
    for (bytes, x) in record.chunks_exact_mut(8).zip(coordinates(&mesh.vertices[k])) {
        bytes.copy_from_slice(&x.to_le_bytes());
    }
}

#[inline(always)]
fn corners(mesh: &Mesh, j: usize, record: &mut [u8]) {
    record[0] = 3;
    for (bytes, v) in record[1..].chunks_exact_mut(4).zip(mesh.faces[j]) {
        bytes.copy_from_slice(&v.to_le_bytes());
    }
}

/// A float becomes an integer by saturation, so that nothing outside [0, 1] wraps around.
fn bytes(color: [f64; 3]) -> [u8; 3] {
    color.map(|c| (255.0 * c).round() as u8)
}
