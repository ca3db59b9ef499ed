//! What a file has at its vertices and faces besides the mesh reaches the results unchanged.

use std::fs;
use std::path::Path;

use meshseg::mesh::io::{self, Properties, Scalars};
use ndarray::Array2;

use crate::support::{Folder, costs, stderr};

fn properties(path: &Path) -> Properties {
    io::read_properties(path, &io::read(path).unwrap()).unwrap()
}

fn column(scalars: &Scalars, name: &str) -> Vec<f64> {
    let c = scalars.names.iter().position(|found| found == name);
    let c = c.unwrap_or_else(|| panic!("{name}: {:?}", scalars.names));
    scalars.numbers.column(c).to_vec()
}

fn header(path: &Path) -> String {
    let bytes = fs::read(path).unwrap();
    let end = bytes.windows(10).position(|window| window == b"end_header").unwrap();
    String::from_utf8(bytes[..end].to_vec()).unwrap()
}

/// A square of two triangles with all types of numbers; `label` and the colors are taken by the result.
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
    property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float quality\nproperty int id\n\
    property double time\nproperty char sign\nproperty short label\nelement face 2\n\
    property list uchar int vertex_indices\nproperty ushort part\nproperty uint big\nend_header\n\
    0 0 0 255 0 0 0.1 -70000 1e-300 -5 300\n1 0 0 0 255 0 nan 2 0.1 6 -1\n1 1 0 0 0 255 -inf 3 -0.1 7 2\n\
    0 1 0 9 9 9 1e30 4 12345678.9 8 4\n3 0 1 2 65535 4294967295\n3 0 2 3 7 1\n";

#[test]
fn properties_of_ply_keep_their_types_and_values() {
    let folder = Folder::new();
    folder.write("a.ply", PLY);
    folder.array("S.npy", &costs(4, 2));
    folder.array("P.npy", &ndarray::array![[0.9, 0.1], [0.2, 0.8]]);
    let given = properties(&folder.path("a.ply"));
    let (of_vertices, of_faces) = (given.of_vertices.unwrap(), given.of_faces.unwrap());
    for line in [
        "solve a.ply --costs S.npy --lambda 0.1",
        "segment a.ply --data colors --regions 2",
        "segment a.ply --probabilities P.npy --lambda 0.1",
        "solve a.ply --costs P.npy --on faces --lambda 0.1",
    ] {
        folder.done(&format!("{line} --no-preview --also vtp --out out"));
        let lines = header(&folder.path("out/segmented.ply"));
        for property in [
            "float quality",
            "int id",
            "double time",
            "char sign",
            "short input_label",
            "uchar input_red",
            "uchar input_green",
            "uchar input_blue",
            "ushort part",
            "uint big",
        ] {
            assert!(lines.contains(&format!("property {property}\n")), "{line}: {lines}");
        }
        for file in ["segmented.ply", "segmented.vtp"] {
            let found = properties(&folder.path(&format!("out/{file}")));
            let (vertices, faces) = (found.of_vertices.unwrap(), found.of_faces.unwrap());
            for (given, found) in [(&of_vertices, &vertices), (&of_faces, &faces)] {
                for name in &given.names {
                    let taken = match file {
                        "segmented.ply" => {
                            ["label", "red", "green", "blue"].contains(&name.as_str())
                        }
                        _ => name == "label",
                    };
                    let new = if taken { format!("input_{name}") } else { name.clone() };
                    // `quality` is a float: its text may have more digits than that.
                    let bits = |x: Vec<f64>| -> Vec<u64> {
                        let bits = |x: f64| match name == "quality" {
                            true => u64::from((x as f32).to_bits()),
                            false => x.to_bits(),
                        };
                        x.into_iter().map(bits).collect()
                    };
                    let (a, b) = (column(given, name), column(found, &new));
                    assert_eq!(bits(a), bits(b), "{line}: {file}: {name}");
                }
            }
        }
    }
    // The result of a result: what it had is there, once more under another name.
    folder.done("solve out/segmented.ply --costs S.npy --lambda 0.1 --no-preview --out again");
    let found = properties(&folder.path("again/segmented.ply")).of_vertices.unwrap();
    assert_eq!(column(&found, "input_label"), column(&of_vertices, "label"));
    assert!(found.names.contains(&"input_input_label".to_owned()), "{:?}", found.names);
    assert_eq!(column(&found, "time"), column(&of_vertices, "time"));
}

/// Arrays of VTK with several components stay arrays, and columns of PLY.
#[test]
fn arrays_of_vtk_stay_arrays() {
    let folder = Folder::new();
    folder.array("S.npy", &costs(240, 3));
    let given = "--costs S.npy --lambda 0.01 --no-preview --also vtp";
    folder.done(&format!("solve torus:20x12 {given} --out first"));
    folder.done(&format!("solve first/segmented.vtp {given} --out second"));
    let u: Array2<f64> = ndarray_npy::read_npy(folder.path("first/u.npy")).unwrap();
    let text = String::from_utf8_lossy(&fs::read(folder.path("second/segmented.vtp")).unwrap())
        .into_owned();
    let array = text.split("<DataArray").find(|array| array.contains("\"input_u\"")).unwrap();
    assert!(array.contains("NumberOfComponents=\"3\""), "{array}");
    for (file, name) in [("segmented.vtp", "input_u"), ("segmented.ply", "u")] {
        let found = properties(&folder.path(&format!("second/{file}"))).of_vertices.unwrap();
        for p in 0..3 {
            assert_eq!(column(&found, &format!("{name}[{p}]")), u.column(p).to_vec(), "{file}");
        }
    }
}

/// Triangle strips have no properties, so that not every face of such a mesh has one.
#[test]
fn properties_of_faces_beside_strips_are_left_out_with_a_warning() {
    let folder = Folder::new();
    let strips = PLY
        .replace("element face 2", "element face 1")
        .replace(
            "end_header",
            "element tristrips 1\nproperty list int int vertex_indices\nend_header",
        )
        .replace("3 0 2 3 7 1\n", "3 0 2 3\n");
    folder.write("strips.ply", strips);
    folder.array("S.npy", &costs(4, 2));
    let output = folder.run("solve strips.ply --costs S.npy --lambda 0.1 --no-preview --out out");
    assert!(output.status.success(), "{}", stderr(&output));
    let said = stderr(&output);
    assert!(said.contains("its properties of faces do not reach the results"), "{said}");
    let found = properties(&folder.path("out/segmented.ply"));
    assert!(found.of_faces.is_none() && found.of_vertices.is_some());
}

/// What a polygon has, its triangles have: n - 2 for n corners, and none for fewer than three; also as probabilities by
/// name.
#[test]
fn properties_of_polygons_reach_their_triangles() {
    let folder = Folder::new();
    folder.write(
        "a.ply",
        "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\nelement face 3\n\
         property uchar part\nproperty list uchar int vertex_indices\nproperty float p_0\nproperty float p_1\nend_header\n\
         0 0 0\n1 0 0\n2 0 0\n2 1 0\n1 1 0\n0 1 0\n7 4 0 1 4 5 0.9 0.1\n8 2 0 1 0.5 0.5\n9 4 1 2 3 4 0.2 0.8\n",
    );
    let given = properties(&folder.path("a.ply")).of_faces.unwrap();
    assert_eq!(column(&given, "part"), [7.0, 7.0, 9.0, 9.0]);
    folder.done("segment a.ply --property p_* --lambda 0.01 --no-preview --also vtp --out out");
    let labels: ndarray::Array1<i32> =
        ndarray_npy::read_npy(folder.path("out/face_labels.npy")).unwrap();
    assert_eq!(labels.to_vec(), [0, 0, 1, 1]);
    for file in ["segmented.ply", "segmented.vtp"] {
        let found = properties(&folder.path(&format!("out/{file}"))).of_faces.unwrap();
        assert_eq!(column(&found, "part"), [7.0, 7.0, 9.0, 9.0], "{file}");
    }
    // A polygon of many corners and numbers: a file of 500 kB.
    let names: String = (0..2000).map(|c| format!("property uchar n{c}\n")).collect();
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
         element face 1\nproperty list uint int vertex_indices\n{names}end_header\n"
    )
    .into_bytes();
    for x in [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        bytes.extend(x.to_le_bytes());
    }
    bytes.extend(120_000_u32.to_le_bytes());
    (0..120_000_i32).for_each(|k| bytes.extend((k % 3).to_le_bytes()));
    bytes.extend(vec![1; 2000]);
    folder.write("b.ply", bytes);
    let message =
        io::read_properties(&folder.path("b.ply"), &io::read(&folder.path("a.ply")).unwrap());
    let message = message.err().unwrap().to_string();
    assert!(message.contains("divide the polygons first"), "{message}");
}
