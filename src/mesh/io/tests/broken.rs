//! Damaged files: each is either still read as a valid mesh or gives an error of one line.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::{FORMATS, PLY, decorated, message, read, written};
use crate::mesh::Mesh;
use crate::mesh::io::Format::{self, Obj, Off, Ply, Stl};

/// Every face refers to existing vertices, and values per vertex or corner are complete, and finite or unknown.
fn assert_consistent(mesh: &Mesh) {
    assert!(!mesh.faces.is_empty());
    let is_color = |c: &f64| c.is_nan() || (0.0..=1.0).contains(c);
    let indices = mesh.faces.as_flattened();
    assert!(indices.iter().all(|&k| (k as usize) < mesh.vertices.len()));
    assert!(mesh.vertices.iter().all(|x| x.iter().all(|x| x.is_finite())));
    if let Some(colors) = &mesh.colors {
        assert_eq!(colors.len(), mesh.vertices.len());
        assert!(colors.as_flattened().iter().all(is_color));
    }
    if let Some(uv) = &mesh.uv {
        assert_eq!(uv.len(), mesh.faces.len());
        assert!(uv.as_flattened().as_flattened().iter().all(|t| !t.is_infinite()));
    }
    if let Some(colors) = &mesh.face_colors {
        assert_eq!(colors.len(), mesh.faces.len());
        assert!(colors.as_flattened().iter().all(is_color));
    }
    if let Some(materials) = &mesh.materials {
        assert_eq!(materials.of_faces.len(), mesh.faces.len());
        let mut indices = materials.of_faces.iter().flatten();
        assert!(indices.all(|&index| (index as usize) < materials.all.len()));
    }
    // The mesh can be written.
    for format in FORMATS {
        written(format, mesh);
    }
}

/// Valid files of every kind, to be damaged.
fn corpus() -> Vec<(Format, Vec<u8>)> {
    let mesh = decorated();
    let mut corpus: Vec<_> = FORMATS.map(|format| (format, written(format, &mesh))).into();
    let textured = PLY
        .replace(
            "element face",
            "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face",
        )
        .replace("0 0 0\n3", "0 0 0 9 0 255\n3")
        .replace(
            "end_header",
            "property list uchar float texcoord\nelement tristrips 1\n\
            property list int int vertex_indices\nend_header",
        );
    let text = textured.replace("3 0 0 0\n", "3 0 0 0 6 0 0 1 0 1 1\n6 0 0 -1 0 0 0\n");
    corpus.push((Ply, text.into_bytes()));
    let facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    corpus.push((Stl, format!("solid a\n{facet}{facet}endsolid a\n").into_bytes()));
    let off = "STCNOFF\n3 2 0\n0 0 0 0 0 1 255 0 0 0 1\n1 0 0 0 0 1 0 1 0 0 1\n0 1 0 0 0 1 0 0 1 0 1\n3 0 1 2\n3 2 1 0 5\n";
    corpus.push((Off, off.as_bytes().to_vec()));
    let obj = "v 0 0 0\nv 1 0 0\nv 1 1 \\\n 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 -1/-1/-1\nf 1//1 2//1 3//1\nf 3 2 1\n";
    corpus.push((Obj, obj.as_bytes().to_vec()));
    let painted = "ply\nformat ascii 1.0\ncomment TextureFile a b.png\ncomment TextureFile c.png\n\
        element vertex 4\nproperty float x\nproperty int64 y\nproperty double z\nproperty float r\n\
        property float g\nproperty float b\nelement face 2\nproperty list uint64 int64 vertex_indices\n\
        property list uchar float texcoord\nproperty int texnumber\nproperty uchar red\nproperty uchar green\n\
        property uchar blue\nend_header\n0 0 0 1 0 0\n3 1 0 1 0 0 0 2 0\n1 .5 0 1 1 0 0 0 1\n\
        4 0 1 2 3 8 0 0 1 0 1 1 0 1 1 255 0 0\n3 0 1 2 0 0 9 9 9\n";
    corpus.push((Ply, painted.as_bytes().to_vec()));
    let off = "OFF4 3 0\n0 0 0 255 0 0\n3 1 0 9 9 9\n0 2 0\n1 1 0 1 2 3 4\n4 0 1 2 3 0.5 0 1\n2 0 1\n3 0 1 2\n";
    corpus.push((Off, off.as_bytes().to_vec()));
    let obj = "v 0 0 0 255 0 0\nv 3 1 0\nv 0 2 0 9 9 9 1\nv 1 1 0\nvt 0 0\nvt nan 1\nusemtl a b\nf 1/1 2/2 3/9 4\n\
        usemtl c\nf 1 2\nf 1 2 3\n#MRGB ff102030ff102030\n#MRGB ff102030ff102030\n";
    corpus.push((Obj, obj.as_bytes().to_vec()));
    for (format, bytes) in &corpus {
        assert_consistent(&read(*format, bytes).unwrap());
    }
    corpus
}

/// A truncated text may happen to be valid; a truncated binary file never is.
#[test]
fn cut_off_anywhere() {
    for (format, bytes) in corpus() {
        let binary = bytes.contains(&0);
        for length in 0..bytes.len() {
            match read(format, &bytes[..length]) {
                Ok(mesh) => {
                    assert!(!binary, "{format:?} cut at {length} of {}", bytes.len());
                    assert_consistent(&mesh);
                }
                Err(error) => {
                    message::<Mesh>(Err(error), "cut off");
                }
            }
        }
    }
}

#[test]
fn random_bytes_changed() {
    let mut random = Pcg64::seed_from_u64(1);
    for (format, bytes) in corpus() {
        for _ in 0..3000 {
            let mut broken = bytes.clone();
            for _ in 0..random.random_range(1..4) {
                let at = random.random_range(0..broken.len());
                broken[at] = match random.random_range(0..4) {
                    0 => broken[at] ^ (1 << random.random_range(0..8)),
                    1 => random.random(),
                    2 => b'0' + random.random_range(0..10),
                    _ => *b" \n\r-+./#\\e".get(random.random_range(0..10)).unwrap(),
                };
            }
            match read(format, &broken) {
                Ok(mesh) => assert_consistent(&mesh),
                Err(error) => {
                    message::<Mesh>(Err(error), "changed");
                }
            }
        }
    }
}

/// Every reader gets every file, and noise.
#[test]
fn files_of_another_format() {
    let mut random = Pcg64::seed_from_u64(2);
    let mut files: Vec<Vec<u8>> = corpus().into_iter().map(|(_, bytes)| bytes).collect();
    files.extend((0..200).map(|n| (0..n).map(|_| random.random()).collect()));
    for format in FORMATS {
        for bytes in &files {
            if let Ok(mesh) = read(format, bytes) {
                assert_consistent(&mesh);
            }
        }
    }
}
