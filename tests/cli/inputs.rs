//! Mesh files in unusual notations: each gives the result of the plain file.

use meshseg::mesh::{Mesh, io};
use ndarray::Array2;

use crate::support::{Folder, SQUARE_OBJ};

fn square_costs() -> Array2<f64> {
    ndarray::array![[0.0, 1.0], [1.0, 0.3], [1.0, 0.2], [0.4, 0.0]]
}

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
    property float z\nproperty int quality\nelement face 1\nproperty list uchar int vertex_indices\n\
    end_header\n0 0 0 7\n1 0 0 7\n1 1 0 7\n0 1 0 7\n4 0 1 2 3\n";

const STL: &str = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\n\
    endloop\nendfacet\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 1 0\nvertex 0 1 0\n\
    endloop\nendfacet\nendsolid\n";

/// Coordinates of one type and 32-bit indices, all big endian.
fn big_endian_ply(mesh: &Mesh) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_big_endian 1.0\nelement vertex {}\nproperty double x\nproperty double y\n\
         property double z\nelement face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        mesh.vertices.len(),
        mesh.faces.len()
    )
    .into_bytes();
    for x in &mesh.vertices {
        x.iter().for_each(|x| bytes.extend(x.to_be_bytes()));
    }
    for face in &mesh.faces {
        bytes.push(3);
        face.iter().for_each(|k| bytes.extend(k.to_be_bytes()));
    }
    bytes
}

#[test]
fn unusual_files_give_the_result_of_the_plain_one() {
    let folder = Folder::new();
    folder.array("S.npy", &square_costs());
    folder.write("plain.obj", SQUARE_OBJ);
    let solve = |mesh: &str| {
        folder.solve(&format!("{mesh} --costs S.npy --lambda 0.1 --no-preview --gap 1e-6"), "out")
    };
    let plain = solve("plain.obj");
    plain.assert_consistent();

    let mesh = io::read(&folder.path("plain.obj")).unwrap();
    let mut binary_stl = vec![b' '; 80];
    binary_stl.extend(2_u32.to_le_bytes());
    for j in 0..2 {
        binary_stl.extend([0; 12]);
        for corner in mesh.corners(j) {
            corner.iter().for_each(|&x| binary_stl.extend((x as f32).to_le_bytes()));
        }
        binary_stl.extend([0; 2]);
    }
    for (name, content) in [
        ("crlf.obj", SQUARE_OBJ.replace('\n', "\r\n").into_bytes()),
        ("mark.obj", format!("\u{feff}{SQUARE_OBJ}").into_bytes()),
        (
            "negative.obj",
            SQUARE_OBJ.replace("f 1 2 3", "f -4 -3 -2").replace("f 1 3 4", "f -4 -2 -1").into(),
        ),
        (
            "polygon.obj",
            SQUARE_OBJ.replace("f 1 2 3\nf 1 3 4", "g a\nf 1//1 2//1 3//1 4//1").into(),
        ),
        ("ascii.ply", PLY.into()),
        ("big.ply", big_endian_ply(&mesh)),
        ("plain.off", "OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n".into()),
        ("welded.stl", STL.into()),
        ("binary.stl", binary_stl),
        // Without an extension, the content determines the format.
        ("no-extension", PLY.into()),
        ("UPPER.OBJ", SQUARE_OBJ.into()),
    ] {
        folder.write(name, content);
        let answer = solve(name);
        assert_eq!(answer.u, plain.u, "{name}");
        assert_eq!(answer.number("energy"), plain.number("energy"), "{name}");
    }
    folder.write("with space.obj", SQUARE_OBJ);
    assert_eq!(solve("with%20space.obj").u, plain.u);
}

/// Vertices in no face, faces without area and repeated faces are allowed: they are counted, reported, and keep their
/// rows.
#[test]
fn damage_is_reported_and_the_rows_stay_in_place() {
    let folder = Folder::new();
    folder.write("damaged.obj", format!("{SQUARE_OBJ}v 9 9 9\nf 1 2 2\nf 1 2 1\n"));
    let mut costs = Array2::zeros((5, 2));
    costs.slice_mut(ndarray::s![..4, ..]).assign(&square_costs());
    folder.array("S.npy", &costs);
    let answer = folder.solve("damaged.obj --costs S.npy --lambda 0.1", "out");
    answer.assert_consistent();
    assert_eq!(answer.u.dim(), (5, 2));
    let warning = answer.summary["warnings"][0].as_str().unwrap();
    assert_eq!(warning, "2 faces without area were left out");
}
