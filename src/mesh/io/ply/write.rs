//! Writing PLY: binary little endian, with coordinates as doubles, which are read back to the same bits.

use std::io::{self, Write};
use std::path::Path;

use super::others::Others;
use crate::error::Result;
use crate::file;
use crate::mesh::io::paths::relative;
use crate::mesh::io::scalars::Properties;
use crate::mesh::io::{coordinates, known};
use crate::mesh::{Materials, Mesh};
use crate::sweep::collect;

/// Writes the mesh. The names of images are relative to `folder`.
pub fn write(out: &mut dyn Write, mesh: &Mesh, folder: &Path) -> io::Result<()> {
    match &mesh.colors {
        None => {
            header(out, mesh, ["", ""], Some(folder))?;
            records::<24>(out, mesh.vertices.len(), |k, record| position(mesh, k, record))?;
        }
        Some(colors) => {
            header(out, mesh, [COLOR_PROPERTIES, ""], Some(folder))?;
            records::<27>(out, mesh.vertices.len(), |k, record| {
                position(mesh, k, record);
                record[24..].copy_from_slice(&bytes(known(colors[k])));
            })?;
        }
    }
    if mesh.face_colors.is_some() || images(mesh).is_some() {
        return painted_faces(out, mesh);
    }
    faces(out, mesh)
}

/// Writes a mesh with a color and a label per vertex. All are `uchar`: some readers abort on vertices with additional
/// properties of several types.
///
/// `labels` has one entry per vertex, `face_labels` one per face, which then have colors and labels, too; `colors` has
/// one RGB in [0, 1] per label. Other labels are gray. `others` are the numbers that the file of the mesh had; where names
/// are taken, theirs begin with `input_`.
///
/// # Errors
/// The file cannot be written.
pub fn write_labeled(
    path: &Path,
    mesh: &Mesh,
    labels: &[u8],
    face_labels: Option<&[u8]>,
    colors: &[[f64; 3]],
    others: &Properties,
) -> Result<()> {
    assert_eq!(labels.len(), mesh.vertices.len());
    let colors: Vec<[u8; 3]> = colors.iter().copied().map(bytes).collect();
    let color = |label: u8| colors.get(usize::from(label)).unwrap_or(&GRAY);
    let [of_vertices, of_faces] = [&others.of_vertices, &others.of_faces].map(Others::new);
    let properties = labeled_properties();
    let face_properties = if face_labels.is_some() { &properties } else { "" };
    let extras = [
        properties.clone() + &of_vertices.header(),
        face_properties.to_owned() + &of_faces.header(),
    ];
    file::write(path, |out| {
        header(out, mesh, [&extras[0], &extras[1]], None)?;
        let labeled = |k: usize, record: &mut [u8; 28]| {
            position(mesh, k, record);
            record[24..27].copy_from_slice(color(labels[k]));
            record[27] = labels[k];
        };
        if of_vertices.is_empty() {
            records(out, mesh.vertices.len(), labeled)?;
        } else {
            let (mut record, mut rest) = ([0; 28], vec![0; of_vertices.bytes()]);
            for k in 0..mesh.vertices.len() {
                labeled(k, &mut record);
                of_vertices.write(k, &mut rest);
                out.write_all(&record)?;
                out.write_all(&rest)?;
            }
        }
        if face_labels.is_none() && of_faces.is_empty() {
            return faces(out, mesh);
        }
        painted_faces_with(out, mesh, |j, record| {
            if let Some(labels) = face_labels {
                record.extend(color(labels[j]));
                record.push(labels[j]);
            }
            let first = record.len();
            record.resize(first + of_faces.bytes(), 0);
            of_faces.write(j, &mut record[first..]);
        })
    })
}

/// Writes a mesh without texture coordinates, with a color and a label per face as `uchar`.
///
/// `labels` has one entry per face, `colors` one RGB in [0, 1] per label.
///
/// # Errors
/// The file cannot be written.
pub fn write_labeled_faces(
    path: &Path,
    mesh: &Mesh,
    labels: &[u8],
    colors: &[[f64; 3]],
) -> Result<()> {
    assert!(labels.len() == mesh.faces.len() && mesh.uv.is_none());
    let colors: Vec<[u8; 3]> = colors.iter().copied().map(bytes).collect();
    file::write(path, |out| {
        header(out, mesh, ["", &labeled_properties()], None)?;
        records::<24>(out, mesh.vertices.len(), |k, record| position(mesh, k, record))?;
        records::<17>(out, mesh.faces.len(), |j, record| {
            corners(mesh, j, record);
            record[13..16].copy_from_slice(&colors[usize::from(labels[j])]);
            record[16] = labels[j];
        })
    })
}

fn labeled_properties() -> String {
    format!("{COLOR_PROPERTIES}property uchar label\n")
}

/// The color of a label that is no region.
const GRAY: [u8; 3] = [184; 3];

const COLOR_PROPERTIES: &str = "property uchar red\nproperty uchar green\nproperty uchar blue\n";

/// The images of the mesh's materials, and the image of each material.
fn images(mesh: &Mesh) -> Option<(Vec<&Path>, Vec<Option<usize>>)> {
    mesh.materials.as_ref().map(Materials::images).filter(|(images, _)| !images.is_empty())
}

/// Writes the header; `extras` are properties of a vertex besides its position, and of a face. Without a `folder`,
/// which image names are relative to, texture coordinates, images and colors of faces are omitted.
fn header(
    out: &mut dyn Write,
    mesh: &Mesh,
    extras: [&str; 2],
    folder: Option<&Path>,
) -> io::Result<()> {
    writeln!(out, "ply\nformat binary_little_endian 1.0")?;
    let images = folder.and_then(|folder| Some((folder, images(mesh)?.0)));
    if let Some((folder, images)) = &images {
        for image in images {
            writeln!(out, "comment TextureFile {}", relative(image, folder))?;
        }
    }
    writeln!(out, "element vertex {}", mesh.vertices.len())?;
    writeln!(out, "property double x\nproperty double y\nproperty double z")?;
    write!(out, "{}", extras[0])?;
    writeln!(out, "element face {}", mesh.faces.len())?;
    writeln!(out, "property list uchar uint vertex_indices")?;
    if mesh.uv.is_some() {
        writeln!(out, "property list uchar double texcoord")?;
    }
    if images.is_some() {
        writeln!(out, "property int texnumber")?;
    }
    if folder.is_some() && mesh.face_colors.is_some() {
        write!(out, "{COLOR_PROPERTIES}")?;
    }
    writeln!(out, "{}end_header", extras[1])
}

fn faces(out: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    match &mesh.uv {
        None => records::<13>(out, mesh.faces.len(), |j, record| corners(mesh, j, record)),
        Some(uv) if uv.iter().all(is_known) => records::<62>(out, mesh.faces.len(), |j, record| {
            corners(mesh, j, record);
            textures(&uv[j], &mut record[13..]);
        }),
        // Records differ in length.
        Some(_) => painted_faces_with(out, mesh, |_, _| {}),
    }
}

/// Writes faces with image numbers and colors after their lists.
fn painted_faces(out: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    let images = images(mesh);
    painted_faces_with(out, mesh, |j, record| {
        if let Some((materials, (_, index_of))) = mesh.materials.as_ref().zip(images.as_ref()) {
            let image = materials.of_faces[j].and_then(|material| index_of[material as usize]);
            record.extend(image.map_or(-1, |image| image as i32).to_le_bytes());
        }
        if let Some(colors) = &mesh.face_colors {
            record.extend(bytes(known(colors[j])));
        }
    })
}

fn painted_faces_with(
    out: &mut dyn Write,
    mesh: &Mesh,
    paint: impl Fn(usize, &mut Vec<u8>),
) -> io::Result<()> {
    let mut record = Vec::new();
    for j in 0..mesh.faces.len() {
        record.clear();
        record.resize(13, 0);
        corners(mesh, j, &mut record);
        if let Some(uv) = &mesh.uv {
            let length = if is_known(&uv[j]) { 49 } else { 1 };
            record.resize(13 + length, 0);
            if length > 1 {
                textures(&uv[j], &mut record[13..]);
            }
        }
        paint(j, &mut record);
        out.write_all(&record)?;
    }
    Ok(())
}

/// Whether all corners have texture coordinates; otherwise the list is empty.
fn is_known(face: &[[f64; 2]; 3]) -> bool {
    face.iter().all(|t| !t[0].is_nan())
}

fn textures(face: &[[f64; 2]; 3], record: &mut [u8]) {
    record[0] = 6;
    for (bytes, t) in record[1..].chunks_exact_mut(8).zip(face.as_flattened()) {
        bytes.copy_from_slice(&t.to_le_bytes());
    }
}

/// Writes n records of fixed size, which are encoded in parallel.
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

/// Conversion to integers saturates, so that values outside [0, 1] do not wrap around.
fn bytes(color: [f64; 3]) -> [u8; 3] {
    color.map(|c| (255.0 * c).round() as u8)
}
