//! What is written is read again, to the bit where the format can hold it.

use std::fs;

use nalgebra::Point3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::{FORMATS, decorated, read, written};
use crate::mesh::io::{self, Format, write_labeled};
use crate::mesh::{Mesh, Shape};

/// Coordinates of every size, an unreferenced vertex, a degenerate and a duplicate face.
fn awkward() -> Mesh {
    let points = [
        [0.1, -0.0, 1.0 / 3.0],
        [1e49, -2.5e-300, 5e-324],
        [f64::MIN_POSITIVE, f64::EPSILON, -1e-7],
        [9007199254740993.0, 0.3, -0.7],
        [1.0, 2.0, 3.0],
    ];
    Mesh::new(points.map(Point3::from).to_vec(), vec![[0, 1, 2], [2, 1, 0], [3, 3, 0], [0, 1, 2]])
}

#[test]
fn obj_and_ply_hold_everything() {
    for mesh in [awkward(), decorated()] {
        assert_eq!(read(Format::Obj, written(Format::Obj, &mesh)).unwrap(), mesh);
        let mut ply = read(Format::Ply, written(Format::Ply, &mesh)).unwrap();
        if let (Some(rounded), Some(colors)) = (&ply.colors, &mesh.colors) {
            for (a, b) in rounded.as_flattened().iter().zip(colors.as_flattened()) {
                assert!((a - b).abs() <= 0.5 / 255.0);
            }
        }
        ply.colors.clone_from(&mesh.colors);
        assert_eq!(ply, mesh);
    }
}

/// Any coordinate that is let in, whatever its bits.
#[test]
fn every_coordinate_survives_text() {
    let mut random = Pcg64::seed_from_u64(3);
    let mut coordinate = || loop {
        let x = f64::from_bits(random.random());
        if x.abs() <= 1e50 {
            return x;
        }
    };
    let points = (0..3000).map(|_| Point3::new(coordinate(), coordinate(), coordinate()));
    let mesh = Mesh::new(points.collect(), vec![[0, 1, 2]]);
    for format in [Format::Obj, Format::Ply, Format::Off] {
        let read = read(format, written(format, &mesh)).unwrap();
        for (a, b) in read.vertices.iter().zip(&mesh.vertices) {
            assert_eq!(a.map(f64::to_bits), b.map(f64::to_bits), "{format:?}");
        }
    }
}

#[test]
fn off_holds_all_but_texture_coordinates() {
    for mut mesh in [awkward(), decorated()] {
        let off = read(Format::Off, written(Format::Off, &mesh)).unwrap();
        mesh.uv = None;
        assert_eq!(off, mesh);
    }
}

/// Coordinates of 32 bits, numbered in the order of the faces, pass through STL unchanged.
#[test]
fn stl_holds_the_surface() {
    let mut mesh = Shape::Sphere { level: 2 }.mesh();
    for x in &mut mesh.vertices {
        *x = x.map(|x| f64::from(x as f32));
    }
    let once = read(Format::Stl, written(Format::Stl, &mesh)).unwrap();
    assert_eq!(once.vertices.len(), mesh.vertices.len());
    for j in 0..mesh.faces.len() {
        assert_eq!(once.corners(j), mesh.corners(j));
    }
    let twice = read(Format::Stl, written(Format::Stl, &once)).unwrap();
    assert_eq!(twice, once);
}

/// One mesh, four formats: the same vertices and faces in the same order.
#[test]
fn formats_agree() {
    let mut mesh = read(Format::Stl, written(Format::Stl, &decorated())).unwrap();
    mesh.colors = None;
    for format in FORMATS {
        assert_eq!(read(format, written(format, &mesh)).unwrap(), mesh, "{format:?}");
    }
}

#[test]
fn files_are_found_by_extension_in_any_case_and_else_by_content() {
    let folder = tempfile::tempdir().unwrap();
    let mut mesh = decorated();
    mesh.colors = None;
    mesh.uv = None;
    for extension in ["obj", "PLY", "Off", "STL"] {
        let path = folder.path().join("mesh").with_extension(extension);
        io::write(&path, &mesh).unwrap();
        let read = io::read(&path).unwrap();
        assert_eq!(read.faces.len(), mesh.faces.len());
        for name in ["mesh.unknown", "mesh"] {
            let unnamed = folder.path().join(name);
            fs::copy(&path, &unnamed).unwrap();
            assert_eq!(io::read(&unnamed).unwrap(), read, "{extension}");
        }
    }
}

#[test]
fn labels_are_bytes_beside_the_colors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("segmented.ply");
    let mesh = Shape::Grid { nx: 2, ny: 1 }.mesh();
    let labels = [0, 1, 2, 3, 4, 63];
    let palette: Vec<_> = (0..64).map(|p| [p.min(5) as f64 / 5.0, 0.0, 1.0]).collect();
    let colors: Vec<_> = labels.map(|label| palette[usize::from(label)]).to_vec();
    write_labeled(&path, &mesh, &labels, &palette).unwrap();
    let read = io::read(&path).unwrap();
    assert_eq!(read.vertices, mesh.vertices);
    assert_eq!(read.colors.unwrap(), colors);
    let bytes = fs::read(&path).unwrap();
    let header = b"property uchar blue\nproperty uchar label\nelement face 4\n";
    assert!(bytes.windows(header.len()).any(|window| window == header));
}

#[test]
fn what_a_format_cannot_hold_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = awkward();
    let stl = io::write(&folder.path().join("a.stl"), &mesh).unwrap_err();
    assert!(stl.to_string().contains("too large for STL"));
    let vtk = io::write(&folder.path().join("a.vtk"), &mesh).unwrap_err();
    assert!(vtk.to_string().contains(".obj, .ply, .off and .stl"));
    assert!(io::write(&folder.path().join("no/a.ply"), &mesh).is_err());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}
