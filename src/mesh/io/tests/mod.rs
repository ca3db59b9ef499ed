//! Tests of readers and writers: round trips, unusual files, malformed files, and files that are read in part.

mod broken;
mod exact;
mod freesurfer;
mod gifti;
mod gltf;
mod left_out;
mod malformed;
mod unusual;
mod vtk;

use std::path::Path;

use super::{Format, parse};
use crate::error::Result;
use crate::mesh::{Mesh, Shape};

const FORMATS: [Format; 4] = [Format::Obj, Format::Ply, Format::Off, Format::Stl];

fn read(format: Format, content: impl AsRef<[u8]>) -> Result<Mesh> {
    parse(Path::new("test"), format, content.as_ref())
}

/// The mesh as written in a format.
fn written(format: Format, mesh: &Mesh) -> Vec<u8> {
    let mut bytes = Vec::new();
    match format {
        Format::Obj => super::obj::write(&mut bytes, mesh, None),
        Format::Ply => super::ply::write(&mut bytes, mesh, Path::new("")),
        Format::Off => super::off::write(&mut bytes, mesh),
        Format::Stl => super::stl::write(&mut bytes, mesh, nalgebra::Vector3::zeros()),
        _ => unreachable!("it is no format of FORMATS"),
    }
    .unwrap();
    bytes
}

/// A closed mesh with colors, and with texture coordinates that jump at a seam.
fn decorated() -> Mesh {
    let mut mesh = Shape::Torus { nu: 5, nv: 4 }.mesh();
    let shade = |k: usize| [k as f64 / 19.0, 1.0 - k as f64 / 19.0, (k % 2) as f64];
    mesh.colors = Some((0..mesh.vertices.len()).map(shade).collect());
    let corner = |j: usize, i: usize| [0.1 * j as f64, (i as f64 - 1.0) / 3.0];
    let uv = (0..mesh.faces.len()).map(|j| [0, 1, 2].map(|i| corner(j, i)));
    mesh.uv = Some(uv.collect());
    mesh
}

/// The smallest PLY file.
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n3 0 0 0\n";

/// Every beginning of a file, and the file with any one byte changed, is read or gives an error of one line.
fn assert_survives_damage<T>(bytes: &[u8], read: impl Fn(&[u8]) -> Result<T>) {
    let check = |bytes: &[u8]| {
        if let Err(error) = read(bytes) {
            message::<T>(Err(error), "damaged");
        }
    };
    assert!(read(bytes).is_ok());
    for length in 0..bytes.len() {
        check(&bytes[..length]);
    }
    for at in 0..bytes.len() {
        for byte in [0xff, b'9', 0] {
            let mut broken = bytes.to_vec();
            broken[at] = byte;
            check(&broken);
        }
    }
}

/// The message of the error that the result must be, on one line.
fn message<T>(result: Result<T>, context: &str) -> String {
    let message = match result {
        Ok(_) => panic!("was read: {context}"),
        Err(error) => error.to_string(),
    };
    assert!(!message.contains(['\n', '\r']), "{message:?}");
    assert!(message.len() < 250, "{message:?}");
    message
}
