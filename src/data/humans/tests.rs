//! Files that the tests write, with labels that name their pixels.

use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use image::{GrayImage, Luma};
use ndarray::array;

use super::*;
use crate::data::input::{self, DataSource, Mapping};
use crate::data::texture::Texel;
use crate::mesh::Source;

/// An element with its padding.
fn element(kind: u32, data: &[u8]) -> Vec<u8> {
    let mut bytes = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
    bytes.extend(data);
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    bytes
}

fn int32(numbers: &[u32]) -> Vec<u8> {
    let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
    element(5, &bytes)
}

fn matrix(class: u8, dimensions: &[u32], name: &str, content: &[u8]) -> Vec<u8> {
    let flags = element(6, &[class, 0, 0, 0, 0, 0, 0, 0]);
    let parts = [&flags, &int32(dimensions), &element(1, name.as_bytes()), content];
    element(14, &parts.map(|part: &[u8]| part.to_vec()).concat())
}

/// An array of class uint16, in the storage type of a kind.
fn numbers(human: &Array2<u16>, kind: u32) -> Vec<u8> {
    let column_by_column = human.t();
    let data: Vec<u8> = match kind {
        2 => column_by_column.iter().map(|&label| label as u8).collect(),
        9 => column_by_column.iter().flat_map(|&label| f64::from(label).to_le_bytes()).collect(),
        _ => column_by_column.iter().flat_map(|label| label.to_le_bytes()).collect(),
    };
    let (rows, columns) = human.dim();
    matrix(11, &[rows as u32, columns as u32], "", &element(kind, &data))
}

/// A struct with a field before `Segmentation`; the length of the names is a short element, as MATLAB writes it.
fn human(segmentation: &[u8]) -> Vec<u8> {
    let mut content = vec![5, 0, 4, 0, 13, 0, 0, 0];
    let mut names = [0; 26];
    names[..10].copy_from_slice(b"Boundaries");
    names[13..25].copy_from_slice(b"Segmentation");
    content.extend(element(1, &names));
    content.extend(matrix(9, &[1, 1], "", &element(2, &[1])));
    content.extend(segmentation);
    matrix(2, &[1, 1], "", &content)
}

fn truth(humans: &[Vec<u8>]) -> Vec<u8> {
    matrix(1, &[1, humans.len() as u32], "groundTruth", &humans.concat())
}

fn file_of(elements: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = format!("{:<124}", "MATLAB 5.0 MAT-file").into_bytes();
    bytes.extend(b"\x00\x01IM");
    bytes.extend(elements.concat());
    bytes
}

fn compressed(content: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(content).unwrap();
    let data = encoder.finish().unwrap();
    [&15_u32.to_le_bytes(), &(data.len() as u32).to_le_bytes(), data.as_slice()].concat()
}

fn two_humans() -> [Array2<u16>; 2] {
    [array![[1, 1, 2], [3, 400, 65535]], array![[0, 1, 2], [3, 4, 5]]]
}

fn tiny() -> Vec<u8> {
    let [a, b] = two_humans();
    let other = matrix(6, &[1, 1], "other", &element(9, &1.5_f64.to_le_bytes()));
    let truth = truth(&[human(&numbers(&a, 4)), human(&numbers(&b, 2))]);
    file_of(&[compressed(&other), compressed(&truth)])
}

#[test]
fn compressed_or_not_and_in_any_type_the_labels_are_the_same() {
    let [a, b] = two_humans();
    assert_eq!(parse(&tiny()).unwrap(), [a.clone(), b.clone()]);
    let plain = file_of(&[truth(&[human(&numbers(&a, 9)), human(&numbers(&b, 9))])]);
    assert_eq!(parse(&plain).unwrap(), [a, b]);
}

#[test]
fn truncated_files_are_refused() {
    let whole = tiny();
    let [a, b] = two_humans();
    let plain = file_of(&[truth(&[human(&numbers(&a, 4)), human(&numbers(&b, 4))])]);
    for bytes in [whole, plain] {
        for end in 0..bytes.len() {
            let message = parse(&bytes[..end]).unwrap_err();
            assert!(!message.contains('\n') && message.len() < 200, "{end}: {message}");
        }
    }
}

/// Wrong bytes, inside and outside of the compressed stream: an error or other labels, never a panic.
#[test]
fn altered_files_are_no_panic() {
    let [a, b] = two_humans();
    let inside = truth(&[human(&numbers(&a, 4)), human(&numbers(&b, 2))]);
    let check = |bytes: &[u8]| {
        if let Err(message) = parse(bytes) {
            assert!(!message.contains('\n') && message.len() < 200, "{message}");
        }
    };
    for at in 0..inside.len() {
        for byte in [0, 1, 2, 15, 127, 255, inside[at] ^ 1, inside[at] ^ 128] {
            let mut altered = inside.clone();
            altered[at] = byte;
            check(&file_of(&[compressed(&altered)]));
            check(&file_of(&[altered]));
        }
    }
    let whole = tiny();
    for at in 0..whole.len() {
        for byte in [0, 255, whole[at] ^ 1, whole[at] ^ 16] {
            let mut altered = whole.clone();
            altered[at] = byte;
            check(&altered);
        }
    }
}

#[test]
fn other_content_is_refused_by_name() {
    let image =
        |rows: u32, columns: u32, data: &[u8]| matrix(11, &[rows, columns], "", &element(4, data));
    let [a, b] = two_humans();
    let (good, wide) = (human(&numbers(&a, 4)), human(&numbers(&b.t().to_owned(), 4)));
    let negative = matrix(10, &[1, 1], "", &element(3, &[255, 255]));
    let half = matrix(6, &[1, 1], "", &element(9, &0.5_f64.to_le_bytes()));
    let mut nameless = human(&numbers(&a, 4));
    let at = nameless.windows(12).position(|it| it == b"Segmentation").unwrap();
    nameless[at] = b's';
    for (bytes, part) in [
        (b"MATLAB 7.3 MAT-file, HDF5".to_vec(), "-v7"),
        (b"\x89HDF".to_vec(), "is not a MATLAB file"),
        ([&[b' '; 124][..], b"\x01\x00MI"].concat(), "big-endian"),
        (file_of(&[]), "no variable groundTruth"),
        (file_of(&[truth(&[])]), "holds no human segmentations"),
        (file_of(&[matrix(2, &[1, 1], "groundTruth", &[])]), "damaged"),
        (file_of(&[image(1, 1, &[1, 0])]), "no variable groundTruth"),
        (file_of(&[truth(&[good.clone(), numbers(&a, 4)])]), "human 2: is not a struct"),
        (file_of(&[truth(&[nameless])]), "human 1: the struct has no field Segmentation"),
        (file_of(&[truth(&[good.clone(), wide])]), "human 2: the segmentation does not have"),
        (file_of(&[truth(&[human(&good)])]), "human 1: Segmentation is not an array"),
        (file_of(&[truth(&[human(&negative)])]), "human 1: a label is not an integer from 0"),
        (file_of(&[truth(&[human(&half)])]), "human 1: a label is not an integer from 0"),
        (file_of(&[truth(&[human(&image(0, 3, &[]))])]), "human 1: an array of 0 x 3"),
        (file_of(&[truth(&[human(&image(2, 3, &[1, 0]))])]), "2 x 3 pixels has 1 label"),
        (file_of(&[truth(&[human(&image(1 << 20, 1 << 20, &[]))])]), "has 0 labels"),
        (file_of(&[truth(&[human(&image(1 << 31, 3, &[]))])]), "human 1: an array of 2147483648"),
        (file_of(&[compressed(&vec![0; 70 << 20])]), "inflates to more than"),
    ] {
        let message = parse(&bytes).unwrap_err();
        assert!(message.contains(part), "{part:?} is not in {message:?}");
    }
}

/// In an image whose colors are its labels, the interpolated color of a vertex rounds to its label.
#[test]
fn labels_lie_on_the_mesh_as_the_image_does() {
    let folder = tempfile::tempdir().unwrap();
    let [mat, png] = ["t.mat", "t.png"].map(|name| folder.path().join(name));
    // Wider and higher than the box, and of the same aspect ratio.
    for (grid, rows, columns) in [("grid:40x20", 9, 12), ("grid:31x47", 10, 25), ("grid:4x2", 3, 5)]
    {
        let across = Array2::from_shape_fn((rows, columns), |(_, i)| i as u16);
        let down = Array2::from_shape_fn((rows, columns), |(row, _)| row as u16);
        let cells = [human(&numbers(&across, 4)), human(&numbers(&down, 4))];
        std::fs::write(&mat, file_of(&[truth(&cells)])).unwrap();
        let source = Source::parse(grid).unwrap();
        let mesh = source.mesh().unwrap();
        let labels = on_mesh(&mesh, &mat).unwrap();
        for (labels, image) in labels.iter().zip([across, down]) {
            let pixel = |i: u32, row: u32| Luma([10 * image[[row as usize, i as usize]] as u8]);
            GrayImage::from_fn(columns as u32, rows as u32, pixel).save(&png).unwrap();
            let mapping = Mapping { texel: Texel::Vertex, ..Mapping::default() };
            let choice = DataSource::Image(png.clone());
            let input = input::read(&source, &mesh, None, Some(&choice), &mapping).unwrap();
            for (k, color) in input.colors.iter().enumerate() {
                let label = 25.5 * color[0];
                // Half-way between two pixels either is the nearest.
                assert!((label - labels[k] as f64).abs() < 0.5 + 1e-9, "{grid}, {k}: {label}");
            }
        }
    }
}

/// 5 x 3 vertices and pixels: vertices are counted from the lower left, rows of pixels from the top.
#[test]
fn a_grid_of_the_size_of_the_image_has_one_vertex_in_each_pixel() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.mat");
    let image = Array2::from_shape_fn((3, 5), |(row, i)| (10 * row + i) as u16);
    std::fs::write(&path, file_of(&[compressed(&truth(&[human(&numbers(&image, 2))]))])).unwrap();
    let mut mesh = crate::samples::shape("grid:4x2");
    let expected: Vec<i64> = vec![20, 21, 22, 23, 24, 10, 11, 12, 13, 14, 0, 1, 2, 3, 4];
    assert_eq!(on_mesh(&mesh, &path).unwrap(), std::slice::from_ref(&expected));
    // A vertex without faces is unknown, wherever it is.
    mesh.vertices.push(nalgebra::Point3::new(9.0, 9.0, 0.0));
    assert_eq!(on_mesh(&mesh, &path).unwrap(), [[expected, vec![UNKNOWN]].concat()]);
}
