//! Arrays that are invalid as costs, U or data.

use std::fs;

use ndarray::{Array, Array1, Array2, Array3, array};
use ndarray_npy::{WritableElement, WriteNpyExt};

use super::{folder, refuse};

fn npy<A: WritableElement, D: ndarray::Dimension>(array: Array<A, D>) -> Vec<u8> {
    let mut bytes = Vec::new();
    array.write_npy(&mut bytes).unwrap();
    bytes
}

/// An array file with this header and four rows of two doubles.
fn with_header(header: &str) -> Vec<u8> {
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend([0; 64]);
    bytes
}

/// Files that are not arrays of numbers per vertex, for any purpose.
fn malformed() -> Vec<(Vec<u8>, &'static str)> {
    let good = npy(Array2::<f64>::zeros((4, 2)));
    let header = |descr: &str, shape: &str| {
        with_header(&format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}\n"))
    };
    let no_data = |shape: &str| {
        let bytes = header("'<f8'", shape);
        bytes[..bytes.len() - 64].to_vec()
    };
    vec![
        (Vec::new(), "is empty"),
        (b"0.5 0.5\n0.5 0.5\n".to_vec(), "numpy.save"),
        (good[..5].to_vec(), "numpy.save"),
        (good[..9].to_vec(), "ends inside its header"),
        (good[..40].to_vec(), "ends inside its header"),
        (good[..good.len() - 1].to_vec(), "bytes of data"),
        ([good.as_slice(), b"x"].concat(), "bytes of data"),
        (b"\x93NUMPY\x07\x00\x00\x00{}".to_vec(), "version"),
        (b"\x93NUMPY\x02\x00\xff\xff\xff\xff{".to_vec(), "ends inside its header"),
        (header("'<f8'", "(4611686018427387904, 4)"), "does not match its shape"),
        (
            header("'<f8'", "(18446744073709551615, 18446744073709551615)"),
            "does not match its shape",
        ),
        (header("'<f8'", "(99999999999999999999999, 2)"), "shape"),
        (header("'<f8'", "(-4, -2)"), "shape"),
        (header("'<f8'", "(1000000, 1000000)"), "does not match its shape"),
        (no_data("(0, 18446744073709551615)"), "does not match its shape"),
        (no_data("(18446744073709551615, 0)"), "does not match its shape"),
        (header("'<f8'", "8"), "shape"),
        (header("'<c8'", "(4, 2)"), "plain numbers"),
        (header("'<U2'", "(4, 2)"), "a.npy"),
        (header("'|S8'", "(4, 2)"), "plain numbers"),
        (header("'|O'", "(4, 2)"), "plain numbers"),
        (header("'|O8'", "(4, 2)"), "plain numbers"),
        (header("'<f2'", "(15, 2)"), "does not match its shape"),
        (header("'<f16'", "(2, 2)"), "plain numbers"),
        (header("'<M8[s]'", "(4, 2)"), "plain numbers"),
        (header("[('a', '<f8')]", "(4, 2)"), "plain numbers"),
        (header(&"[".repeat(9000), "(4, 2)"), "plain numbers"),
        (with_header("{'shape': (4, 2)}"), "plain numbers"),
        (with_header("{'descr': '<f8', 'shape': (4, 2)}\n"), "a.npy"),
        (npy(Array3::<f64>::zeros((4, 2, 1))), "axes"),
        (npy(ndarray::arr0(1.0)), "axes"),
    ]
}

/// Zeros except for one entry.
fn with(row: usize, column: usize, entry: f64) -> Array2<f64> {
    let mut array = Array2::zeros((4, 2));
    array[[row, column]] = entry;
    array
}

/// Labels and fields must not contain NaN, and data must be finite.
#[test]
fn entries_that_are_not_finite_are_refused() {
    let folder = folder();
    for (entry, name) in [(f64::NAN, "NaN"), (f64::NEG_INFINITY, "-inf"), (f64::INFINITY, "inf")] {
        folder.write("a.npy", npy(with(2, 1, entry)));
        let part = format!("row 2, column 1 is {name}");
        for line in [
            "solve square.obj --costs S.npy --init a.npy --lambda 1 --out out",
            "evaluate square.obj --costs S.npy --u a.npy --lambda 1",
            "evaluate square.obj --costs S.npy --u U.npy --q a.npy --lambda 1",
            "segment square.obj --data a.npy --regions 2 --out out",
        ] {
            if !(entry.is_nan() && line.starts_with("segment")) {
                refuse(&folder, line, &["a.npy", &part]);
            }
        }
    }
}

#[test]
fn malformed_arrays_are_refused_wherever_one_is_read() {
    let folder = folder();
    for (bytes, part) in malformed() {
        folder.write("a.npy", bytes);
        for line in [
            "solve square.obj --costs a.npy --lambda 1 --out out",
            "solve square.obj --costs S.npy --init a.npy --lambda 1 --out out",
            "evaluate square.obj --costs S.npy --u a.npy --lambda 1",
            "segment square.obj --data a.npy --regions 2 --out out",
        ] {
            refuse(&folder, line, &["a.npy", part]);
        }
    }
}

#[test]
fn costs_that_do_not_fit_are_refused() {
    let folder = folder();
    for (bytes, part) in [
        (npy(Array1::<f64>::zeros(4)), "has 1 axis; it must have 2"),
        (npy(Array2::<f64>::zeros((3, 2))), "3 rows, but the mesh has 4 vertices"),
        (npy(Array2::<f64>::zeros((2, 4))), "2 rows, one per face: add --on faces"),
        (npy(Array2::<f64>::zeros((0, 2))), "0 rows"),
        (npy(Array2::<f64>::zeros((4, 0))), "0 regions: must be from 2 to 64"),
        (npy(Array2::<f64>::zeros((4, 1))), "1 regions: must be from 2 to 64"),
        (npy(Array2::<f64>::zeros((4, 65))), "65 regions: must be from 2 to 64"),
        (npy(with(2, 1, f64::NAN)), "NaN in row 2, column 1"),
        (npy(with(3, 0, f64::NEG_INFINITY)), "-inf in row 3, column 0"),
    ] {
        folder.write("a.npy", bytes);
        refuse(&folder, "solve square.obj --costs a.npy --lambda 1 --out out", &["a.npy", part]);
        refuse(&folder, "evaluate square.obj --costs a.npy --u U.npy --lambda 1", &["a.npy", part]);
    }
    folder.write(
        "a.npy",
        npy(Array2::from_shape_fn((4, 2), |(_, p)| if p == 0 { -1e308 } else { 1e308 })),
    );
    refuse(&folder, "solve square.obj --costs a.npy --lambda 1 --out out", &["double precision"]);
}

#[test]
fn a_u_that_does_not_fit_is_refused() {
    let folder = folder();
    let start = "solve square.obj --costs S.npy --init a.npy --lambda 1 --out out";
    for u in [Array2::<f64>::zeros((4, 3)), Array2::zeros((3, 2)), Array2::zeros((4, 0))] {
        folder.write("a.npy", npy(u));
        refuse(&folder, start, &["a.npy", "entries, but the costs"]);
        refuse(
            &folder,
            "evaluate square.obj --costs S.npy --u a.npy --lambda 1",
            &["a.npy", "entries"],
        );
    }
    for u in [Array2::zeros((4, 2)), array![[0.5, 0.5], [2.0, -1.0], [1.0, 0.0], [0.0, 1.0]]] {
        folder.write("a.npy", npy(u));
        refuse(&folder, start, &["a.npy", "is not in the simplex"]);
    }
    for name in ["missing.npy", "Uniform", "argmax"] {
        let line = format!("solve square.obj --costs S.npy --init {name} --lambda 1 --out out");
        refuse(&folder, &line, &[name]);
    }
}

#[test]
fn data_that_do_not_fit_are_refused() {
    let folder = folder();
    let line = "segment square.obj --data a.npy --regions 2 --out out";
    for (bytes, part) in [
        (npy(Array1::<f64>::zeros(3)), "3 rows, but the mesh has 4 vertices"),
        (npy(Array2::<u8>::zeros((5, 3))), "5 rows, but the mesh has 4 vertices"),
        (npy(Array2::<f64>::zeros((4, 0))), "no columns"),
        (npy(Array1::from_elem(4, f64::NAN)), "NaN"),
        (npy(array![0.0, 1e300, 0.0, 1.0]), "double precision"),
    ] {
        folder.write("a.npy", bytes);
        refuse(&folder, line, &["a.npy", part]);
    }
}

#[test]
fn paths_that_are_not_array_files_are_refused() {
    let folder = folder();
    fs::create_dir(folder.path("folder.npy")).unwrap();
    for (name, part) in [("missing.npy", "No such file"), ("folder.npy", "is a folder")] {
        for line in [
            format!("solve square.obj --costs {name} --lambda 1 --out out"),
            format!("evaluate square.obj --costs {name} --u U.npy --lambda 1"),
            format!("evaluate square.obj --costs S.npy --u {name} --lambda 1"),
            format!("segment square.obj --data {name} --regions 2 --out out"),
        ] {
            refuse(&folder, &line, &[name, part]);
        }
    }
}
