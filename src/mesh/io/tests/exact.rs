//! Written meshes are read back bit for bit, as far as the format can hold them.

use std::fs;

use nalgebra::Point3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::{FORMATS, decorated, read, written};
use crate::mesh::io::{self, Format, Properties, write_labeled};
use crate::mesh::{Image, Mesh, Shape};

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
fn obj_and_ply_hold_all_but_materials() {
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

/// Any valid coordinate, whatever its bits.
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

/// Vertices with 32-bit coordinates, numbered in the order of the faces, pass through STL unchanged.
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
    write_labeled(&path, &mesh, &labels, None, &palette, &Properties::default()).unwrap();
    let read = io::read(&path).unwrap();
    assert_eq!(read.vertices, mesh.vertices);
    assert_eq!(read.colors.unwrap(), colors);
    let bytes = fs::read(&path).unwrap();
    let header = b"property uchar blue\nproperty uchar label\nelement face 4\n";
    assert!(bytes.windows(header.len()).any(|window| window == header));
}

#[test]
fn meshes_that_a_format_cannot_hold_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = awkward();
    let stl = io::write(&folder.path().join("a.stl"), &mesh).unwrap_err();
    assert!(stl.to_string().contains("too large for STL"));
    let vtk = io::write(&folder.path().join("a.vtk"), &mesh).unwrap_err();
    assert!(vtk.to_string().contains("write .vtp or .vtu"));
    let other = io::write(&folder.path().join("a.xyz"), &mesh).unwrap_err();
    assert!(other.to_string().contains(".obj, .ply, .off, .stl, .vtp and .vtu"));
    assert!(io::write(&folder.path().join("no/a.ply"), &mesh).is_err());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// Unknown colors and texture coordinates are unknown when read back; none is written as NaN.
#[test]
fn unknown_values_stay_unknown() {
    let mut mesh = decorated();
    mesh.colors.as_mut().unwrap()[3] = [f64::NAN; 3];
    mesh.uv.as_mut().unwrap()[7] = [[f64::NAN; 2]; 3];
    // As text, since NaN differs from itself.
    let shown = |mesh: &Mesh| format!("{:?} {:?}", mesh.colors, mesh.uv);
    for format in FORMATS {
        let bytes = written(format, &mesh);
        assert!(!String::from_utf8_lossy(&bytes).contains("NaN"));
        let read = read(format, &bytes).unwrap();
        match format {
            Format::Obj => assert_eq!(shown(&read), shown(&mesh)),
            Format::Ply => {
                let gray = read.colors.unwrap()[3];
                assert!(gray.iter().all(|c| (c - 0.5).abs() < 0.01), "{gray:?}");
                assert_eq!(format!("{:?}", read.uv), format!("{:?}", mesh.uv));
            }
            Format::Off => assert_eq!(read.colors.unwrap()[3], [0.5; 3]),
            _ => {}
        }
    }
}

/// The colors of faces survive bit for bit, or to 8 bits.
#[test]
fn off_and_ply_hold_colors_of_faces() {
    let mut mesh = decorated();
    let count = mesh.faces.len();
    mesh.face_colors = Some((0..count).map(|j| [j as f64 / count as f64, 1.0, 0.0]).collect());
    let off = read(Format::Off, written(Format::Off, &mesh)).unwrap();
    assert_eq!(off.face_colors, mesh.face_colors);
    let ply = read(Format::Ply, written(Format::Ply, &mesh)).unwrap();
    assert_eq!((&ply.uv, &ply.faces), (&mesh.uv, &mesh.faces));
    for (a, b) in ply.face_colors.unwrap().iter().zip(mesh.face_colors.as_ref().unwrap()) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 0.5 / 255.0));
    }
}

/// Images keep their faces and their paths, whatever the folder; OBJ also keeps names and colors.
#[test]
fn materials_survive() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::create_dir(path("in")).unwrap();
    fs::create_dir(path("out")).unwrap();
    fs::write(
        path("in/two parts.mtl"),
        "newmtl roof tiles\nKd 0.5 0.25 0.125\nmap_Kd -clamp on img\\roof 1.png\nnewmtl wall\nKd 1 1 1\n",
    )
    .unwrap();
    fs::write(
        path("in/a.obj"),
        "mtllib two parts.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nusemtl roof tiles\nf 1 3 4\nf 2 3 4\n\
         usemtl wall\nf 1 2 4\n",
    )
    .unwrap();
    let first = io::read(&path("in/a.obj")).unwrap();
    let materials = first.materials.clone().unwrap();
    assert_eq!(materials.of_faces, [None, Some(0), Some(0), Some(1)]);
    assert_eq!(materials.all[0].name, "roof tiles");
    assert_eq!(materials.all[0].color, Some([0.5, 0.25, 0.125]));
    assert_eq!(materials.all[0].image, Some(Image::File(path("in/img/roof 1.png"))));
    assert_eq!((materials.all[1].color, &materials.all[1].image), (Some([1.0; 3]), &None));

    io::write(&path("out/b.obj"), &first).unwrap();
    let library = fs::read_to_string(path("out/b.mtl")).unwrap();
    assert!(library.contains("map_Kd -clamp on ../in/img/roof 1.png"), "{library}");
    let second = io::read(&path("out/b.obj")).unwrap().materials.unwrap();
    let canonical = |image: &Option<Image>| {
        image.as_ref().map(|image| image.path().to_string_lossy().replace("out/../", ""))
    };
    assert_eq!(second.of_faces, materials.of_faces);
    for (a, b) in second.all.iter().zip(&materials.all) {
        assert_eq!((&a.name, a.color, a.placement), (&b.name, b.color, b.placement));
        assert_eq!(canonical(&a.image), canonical(&b.image));
    }

    io::write(&path("out/c.ply"), &first).unwrap();
    let third = io::read(&path("out/c.ply")).unwrap().materials.unwrap();
    assert_eq!(third.of_faces, [None, Some(0), Some(0), None]);
    assert_eq!(canonical(&third.all[0].image), canonical(&materials.all[0].image));
    assert_eq!(third.all.len(), 1);
}

/// Map coordinates keep their distances, and the header states the origin; a mesh whose vertices would merge is
/// refused.
#[test]
fn stl_far_from_the_origin() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("site.stl");
    let mut mesh = Shape::Grid { nx: 20, ny: 20 }.mesh();
    for x in &mut mesh.vertices {
        *x = Point3::new(448_250.125 + x.x, 5_411_900.5 + x.y, 311.0);
    }
    io::write(&path, &mesh).unwrap();
    let read = io::read(&path).unwrap();
    assert_eq!((read.vertices.len(), read.faces.len()), (mesh.vertices.len(), mesh.faces.len()));
    let bytes = fs::read(&path).unwrap();
    let header = String::from_utf8(bytes[..80].to_vec()).unwrap();
    let origin = header.trim_end_matches('\0').strip_prefix("binary STL, origin ").unwrap();
    let origin: Vec<f64> = origin.split(' ').map(|x| x.parse().unwrap()).collect();
    for j in 0..mesh.faces.len() {
        for (a, b) in read.corners(j).iter().zip(mesh.corners(j)) {
            for i in 0..3 {
                assert!((a[i] + origin[i] - b[i]).abs() < 1e-7, "{a} {b} {origin:?}");
            }
        }
    }
    // No origin is near both ends.
    mesh.vertices.push(Point3::new(-448_250.0, 1e9, 0.0));
    mesh.faces.push([0, 1, mesh.vertices.len() as u32 - 1]);
    let message = io::write(&path, &mesh).unwrap_err().to_string();
    assert!(message.contains("would merge"), "{message}");
    assert_eq!(fs::read(&path).unwrap(), bytes);
}
