//! Writes labels as binary glTF 2.0, for viewers and browsers.
//!
//! ```text
//! "glTF" 2 length | length "JSON" {...} | length "BIN\0" positions, colors, labels, indices
//! ```
//!
//! Positions have 32 bits and are relative to the center of the box around the mesh, by which the node is translated.
//! Colors are linear, as glTF has them, in 16 bits. The attribute `_LABEL` has the labels. Where faces have labels of
//! their own, each has its own three vertices. Reference: *glTF 2.0 Specification*, Khronos, 2021.

use std::io::{self, Write};

use nalgebra::{Point3, Vector3};
use serde_json::{Value, json};

use crate::mesh::Mesh;

/// The color of what has no label.
const GRAY: [f64; 3] = [0.72; 3];

/// Writes a mesh with a label per vertex; `colors` has an RGB in [0, 1] per label.
///
/// # Errors
/// Those of `out`, and a file of more than 4 GiB.
pub fn write_labeled(
    out: &mut dyn Write,
    mesh: &Mesh,
    labels: &[i32],
    colors: &[[f64; 3]],
) -> io::Result<()> {
    write(out, mesh.vertices.len(), &|v| mesh.vertices[v], &|v| labels[v], &mesh.faces, colors)
}

/// The same with a label per face.
///
/// # Errors
/// As [`write_labeled`].
pub fn write_labeled_faces(
    out: &mut dyn Write,
    mesh: &Mesh,
    labels: &[i32],
    colors: &[[f64; 3]],
) -> io::Result<()> {
    let corner = |i: usize| mesh.vertices[mesh.faces[i / 3][i % 3] as usize];
    let count = 3 * mesh.faces.len();
    let index = |i: usize| u32::try_from(i).map_err(|_| too_large());
    let faces = (0..mesh.faces.len())
        .map(|j| Ok([index(3 * j)?, index(3 * j + 1)?, index(3 * j + 2)?]))
        .collect::<io::Result<Vec<_>>>()?;
    write(out, count, &corner, &|i| labels[i / 3], &faces, colors)
}

fn too_large() -> io::Error {
    io::Error::other("the mesh is too large for a file of glTF, which has at most 4 GiB")
}

fn write(
    out: &mut dyn Write,
    count: usize,
    position: &dyn Fn(usize) -> Point3<f64>,
    label: &dyn Fn(usize) -> i32,
    faces: &[[u32; 3]],
    colors: &[[f64; 3]],
) -> io::Result<()> {
    let all: Vec<Point3<f64>> = (0..count).map(position).collect();
    let center = center(&all);
    let local = |x: &Point3<f64>| -> [f32; 3] { (x - center).coords.map(|x| x as f32).into() };
    let (mut least, mut most) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for x in all.iter().map(local) {
        for c in 0..3 {
            (least[c], most[c]) = (least[c].min(x[c]), most[c].max(x[c]));
        }
    }
    let sizes = [12 * count, 8 * count, 4 * count, 12 * faces.len()];
    let mut offset = 0;
    let views: Vec<Value> = sizes
        .iter()
        .zip([34962, 34962, 34962, 34963])
        .map(|(size, target)| {
            offset += size;
            json!({"buffer": 0, "byteOffset": offset - size, "byteLength": size, "target": target})
        })
        .collect();
    let text = json!({
        "asset": {"version": "2.0", "generator": concat!("meshseg ", env!("CARGO_PKG_VERSION"))},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "translation": [center.x, center.y, center.z]}],
        "meshes": [{"primitives": [{
            "attributes": {"POSITION": 0, "COLOR_0": 1, "_LABEL": 2}, "indices": 3, "material": 0
        }]}],
        "materials": [{
            "name": "regions",
            "doubleSided": true,
            "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 1.0}
        }],
        "buffers": [{"byteLength": offset}],
        "bufferViews": views,
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3", "min": least, "max": most},
            {"bufferView": 1, "componentType": 5123, "normalized": true, "count": count, "type": "VEC4"},
            {"bufferView": 2, "componentType": 5126, "count": count, "type": "SCALAR"},
            {"bufferView": 3, "componentType": 5125, "count": 3 * faces.len(), "type": "SCALAR"}
        ]
    });
    let mut text = text.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let length = u32::try_from(12 + 8 + text.len() + 8 + offset).map_err(|_| too_large())?;
    out.write_all(b"glTF")?;
    out.write_all(&2_u32.to_le_bytes())?;
    out.write_all(&length.to_le_bytes())?;
    for (kind, size) in [(b"JSON", text.len()), (b"BIN\0", offset)] {
        out.write_all(&u32::try_from(size).map_err(|_| too_large())?.to_le_bytes())?;
        out.write_all(kind)?;
        if kind == b"JSON" {
            out.write_all(&text)?;
        }
    }
    for x in all.iter().flat_map(local) {
        out.write_all(&x.to_le_bytes())?;
    }
    let color = |p: i32| usize::try_from(p).ok().and_then(|p| colors.get(p)).unwrap_or(&GRAY);
    for v in 0..count {
        let [r, g, b] = color(label(v)).map(|c| (65535.0 * linear(c)).round() as u16);
        [r, g, b, u16::MAX].iter().try_for_each(|c| out.write_all(&c.to_le_bytes()))?;
    }
    (0..count).try_for_each(|v| out.write_all(&(label(v) as f32).to_le_bytes()))?;
    faces.iter().flatten().try_for_each(|v| out.write_all(&v.to_le_bytes()))
}

/// The center of the box around points.
fn center(points: &[Point3<f64>]) -> Vector3<f64> {
    let Some(first) = points.first() else { return Vector3::zeros() };
    let (low, high) = points.iter().fold((first.coords, first.coords), |(low, high), x| {
        (low.inf(&x.coords), high.sup(&x.coords))
    });
    0.5 * low + 0.5 * high
}

/// A component of sRGB as an intensity (IEC 61966-2-1).
fn linear(c: f64) -> f64 {
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}
