//! The exported matrices: the file formats that other programs need, and the identities between the matrices.

use std::fs::{self, File};

use ndarray::{Array1, Array2};
use ndarray_npy::{NpzReader, read_npy};

use crate::support::{Folder, names};

const MATRICES: [&str; 5] = ["K", "M", "mass_barycentric", "mass_voronoi", "laplacian"];

/// A MatrixMarket file as a dense matrix.
fn matrix_market(folder: &Folder, name: &str) -> Array2<f64> {
    let text = fs::read_to_string(folder.path(&format!("out/{name}.mtx"))).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("%%MatrixMarket matrix coordinate real general"));
    let words = |line: &str| line.split(' ').map(String::from).collect::<Vec<_>>();
    let sizes: Vec<usize> =
        words(lines.next().unwrap()).iter().map(|word| word.parse().unwrap()).collect();
    let mut matrix = Array2::zeros((sizes[0], sizes[1]));
    let mut entries = 0;
    for line in lines {
        let entry = words(line);
        let [row, column] = [0, 1].map(|i| entry[i].parse::<usize>().unwrap() - 1);
        matrix[[row, column]] = entry[2].parse().unwrap();
        entries += 1;
    }
    assert_eq!(entries, sizes[2]);
    matrix
}

/// The members that `scipy.sparse.load_npz` requires, as a dense matrix.
fn npz(folder: &Folder, name: &str) -> Array2<f64> {
    let path = folder.path(&format!("out/{name}.npz"));
    let mut npz = NpzReader::new(File::open(&path).unwrap()).unwrap();
    let mut members = npz.names().unwrap();
    members.sort();
    assert_eq!(members, ["data", "format", "indices", "indptr", "shape"]);
    // NumPy writes a byte string without dimension as `|S3`, and this is its only number of bytes.
    let bytes = fs::read(&path).unwrap();
    let format = bytes.windows(6).position(|window| window == b"'|S3',").unwrap();
    assert!(bytes[format..format + 120].windows(4).any(|window| window == b"\ncsr"));

    let indices: Array1<i64> = npz.by_name("indices").unwrap();
    let indptr: Array1<i64> = npz.by_name("indptr").unwrap();
    let shape: Array1<i64> = npz.by_name("shape").unwrap();
    let data: Array1<f64> = npz.by_name("data").unwrap();
    let mut matrix = Array2::zeros((shape[0] as usize, shape[1] as usize));
    assert_eq!(indptr.len(), matrix.nrows() + 1);
    for row in 0..matrix.nrows() {
        for i in indptr[row]..indptr[row + 1] {
            matrix[[row, indices[i as usize] as usize]] = data[i as usize];
        }
    }
    matrix
}

#[test]
fn both_formats_agree_and_the_identities_hold() {
    for mesh in ["torus:7x5", "grid:4x3", "sphere:1"] {
        let folder = Folder::new();
        let table = folder.done(&format!("operators {mesh} --out out"));
        assert_eq!(table.lines().count(), 1 + MATRICES.len());
        let mut expected: Vec<String> = vec!["face_areas.npy".into()];
        expected.extend(
            MATRICES.iter().flat_map(|name| [format!("{name}.mtx"), format!("{name}.npz")]),
        );
        assert_eq!(names(&folder.path("out")), expected.into_iter().collect());

        let [k, m, barycentric, voronoi, laplacian] = MATRICES.map(|name| {
            let matrix = npz(&folder, name);
            assert_eq!(matrix, matrix_market(&folder, name), "{mesh}: {name}");
            matrix
        });
        let areas: Array1<f64> = read_npy(folder.path("out/face_areas.npy")).unwrap();
        let (faces, vertices) = (areas.len(), m.nrows());
        assert_eq!(k.dim(), (2 * faces, vertices));
        assert_eq!((m.ncols(), barycentric.dim()), (vertices, (vertices, vertices)));

        let ones = Array1::<f64>::ones(vertices);
        let tiny = |x: &Array1<f64>| x.iter().all(|x| x.abs() < 1e-13);
        assert!(tiny(&k.dot(&ones)), "K 1 = 0");
        assert!(tiny(&(m.dot(&ones) - barycentric.diag())), "M 1 = lumped masses");
        for lumped in [&barycentric, &voronoi] {
            assert!((lumped.sum() - areas.sum()).abs() < 1e-12);
            assert_eq!(lumped, Array2::from_diag(&lumped.diag()));
        }
        let doubled = Array2::from_shape_fn(k.dim(), |(row, v)| k[[row, v]] / areas[row / 2]);
        let difference = k.t().dot(&doubled) - &laplacian;
        assert!(difference.iter().all(|x| x.abs() < 1e-12), "K^T A^-1 K");
    }
}

#[test]
fn faces_without_area_are_left_out_with_a_warning() {
    let folder = Folder::new();
    folder.write("damaged.obj", format!("{}f 1 2 2\n", crate::support::SQUARE_OBJ));
    let output = folder.run("operators damaged.obj --out out");
    assert_eq!(output.status.code(), Some(0));
    assert!(crate::support::stderr(&output).contains("1 face without area was left out"));
    assert_eq!(npz(&folder, "K").dim(), (4, 4));
}
