//! GIFTI: all ways to write an array mean the same, labels come back, and damaged files are refused.

use std::fmt::Write;
use std::io::Write as _;
use std::path::Path;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use ndarray::{Array2, array};

use super::{assert_survives_damage, message, read};
use crate::error::Result;
use crate::mesh::Mesh;
use crate::mesh::io::Format::Gii;
use crate::mesh::io::{self, GiftiArrays, names_values, read_arrays, write_labels};

const POINTS: [f64; 12] = [0.0, 0.0, 0.5, 1.0, 0.0, -1.25, 0.0, 1.0, 0.0, 0.1, 0.7, 3e-8];
const TRIANGLES: [f64; 6] = [0.0, 1.0, 2.0, 1.0, 3.0, 2.0];

/// How an array is written.
#[derive(Clone, Copy, Debug)]
struct Way {
    of: &'static str,
    encoding: &'static str,
    endian: &'static str,
    order: &'static str,
}

const PLAIN: Way =
    Way { of: "FLOAT32", encoding: "ASCII", endian: "LittleEndian", order: "RowMajorOrder" };

fn bytes_of(of: &str, x: f64, big: bool) -> Vec<u8> {
    let mut bytes = match of {
        "UINT8" => vec![x as u8],
        "INT32" => (x as i32).to_le_bytes().to_vec(),
        "INT64" => (x as i64).to_le_bytes().to_vec(),
        "FLOAT32" => (x as f32).to_le_bytes().to_vec(),
        "FLOAT64" => x.to_le_bytes().to_vec(),
        _ => panic!("{of}"),
    };
    if big {
        bytes.reverse();
    }
    bytes
}

/// A `DataArray` of numbers that are given row by row.
fn array_of(intent: &str, columns: usize, values: &[f64], way: Way) -> String {
    let rows = values.len() / columns;
    let mut ordered = values.to_vec();
    if way.order == "ColumnMajorOrder" {
        ordered = (0..values.len()).map(|k| values[k % rows * columns + k / rows]).collect();
    }
    let big = way.endian == "BigEndian";
    let bytes: Vec<u8> = ordered.iter().flat_map(|&x| bytes_of(way.of, x, big)).collect();
    let data = match way.encoding {
        "ASCII" if way.of == "FLOAT32" => {
            ordered.iter().map(|&x| format!("{} ", x as f32)).collect()
        }
        "ASCII" => ordered.iter().map(|x| format!("{x}\n")).collect(),
        "Base64Binary" => BASE64_STANDARD.encode(&bytes),
        _ => {
            let mut stream = ZlibEncoder::new(Vec::new(), Compression::default());
            stream.write_all(&bytes).unwrap();
            BASE64_STANDARD.encode(stream.finish().unwrap())
        }
    };
    let Way { of, encoding, endian, order } = way;
    let dimensions = match columns {
        1 => format!("Dimensionality=\"1\" Dim0=\"{rows}\""),
        _ => format!("Dimensionality=\"2\" Dim0=\"{rows}\" Dim1=\"{columns}\""),
    };
    format!(
        "<DataArray Intent=\"NIFTI_INTENT_{intent}\" DataType=\"NIFTI_TYPE_{of}\" ArrayIndexingOrder=\"{order}\" \
         {dimensions} Encoding=\"{encoding}\" Endian=\"{endian}\" ExternalFileName=\"\">\n<MetaData><MD><Name>\
         <![CDATA[a<b]]></Name><Value/></MD></MetaData>\n<Data>{data}</Data></DataArray>\n"
    )
}

fn file_of(arrays: &str) -> String {
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!DOCTYPE GIFTI SYSTEM \"gifti.dtd\">\n<!-- <GIFTI> -->\n\
         <GIFTI Version='1.0'>\n<MetaData/>\n{arrays}</GIFTI>\n"
    )
}

fn surface(points: Way, triangles: Way) -> String {
    let points = array_of("POINTSET", 3, &POINTS, points);
    let triangles = array_of("TRIANGLE", 3, &TRIANGLES, triangles);
    file_of(&(points + &triangles))
}

fn plain() -> String {
    surface(PLAIN, Way { of: "INT32", ..PLAIN })
}

fn arrays(content: impl AsRef<[u8]>) -> Result<GiftiArrays> {
    read_arrays(Path::new("test"), content.as_ref())
}

#[test]
fn all_encodings_byte_orders_and_orders_of_indices_are_the_same_mesh() {
    let expected = read(Gii, plain()).unwrap();
    assert_eq!(expected.faces, [[0, 1, 2], [1, 3, 2]]);
    assert!(expected.vertices[3].z == f64::from(3e-8_f32));
    let mut ways = 0;
    for encoding in ["ASCII", "Base64Binary", "GZipBase64Binary"] {
        for endian in ["LittleEndian", "BigEndian"] {
            for order in ["RowMajorOrder", "ColumnMajorOrder"] {
                for of in ["UINT8", "INT32", "INT64", "FLOAT32", "FLOAT64"] {
                    let way = Way { of, encoding, endian, order };
                    let content = surface(Way { of: "FLOAT32", ..way }, way);
                    assert_eq!(read(Gii, content).unwrap(), expected, "{way:?}");
                    ways += 1;
                }
            }
        }
    }
    assert_eq!(ways, 60);
    // Names of the C library.
    let way = Way { encoding: "Base64Binary", endian: "BigEndian", ..PLAIN };
    let content = surface(way, Way { of: "INT32", ..way });
    let content = content.replace("Base64Binary", "GIFTI_ENCODING_B64BIN");
    assert_eq!(read(Gii, content.replace("BigEndian", "GIFTI_ENDIAN_BIG")).unwrap(), expected);
    // Doubles are not rounded.
    for encoding in ["ASCII", "Base64Binary", "GZipBase64Binary"] {
        let way = Way { of: "FLOAT64", encoding, ..PLAIN };
        let mesh = read(Gii, surface(way, way)).unwrap();
        assert_eq!(mesh.vertices[3].z, 3e-8);
    }
}

#[test]
fn base64_may_be_broken_into_lines_and_lack_its_padding() {
    let way = Way { encoding: "Base64Binary", ..PLAIN };
    let content = file_of(&array_of("SHAPE", 1, &POINTS[..4], way));
    let expected = arrays(&content).unwrap();
    let start = content.find("<Data>").unwrap() + 6;
    let broken = format!(
        "{}\n  {}\n\t{}",
        &content[..start],
        &content[start..start + 5],
        &content[start + 5..]
    );
    assert_eq!(arrays(broken).unwrap(), expected);
    assert!(content.contains("==</Data>") || content.contains("=</Data>"));
    assert_eq!(
        arrays(content.replace("=", "~").replace("~~</Data>", "</Data>").replace("~", "="))
            .unwrap(),
        expected
    );
}

#[test]
fn arrays_become_columns() {
    let integers = Way { of: "INT32", encoding: "GZipBase64Binary", ..PLAIN };
    let content = file_of(
        &[
            array_of("TIME_SERIES", 1, &[1.0, 2.0], PLAIN),
            array_of("VECTOR", 3, &[3.0, 4.0, 5.0, 6.0, 7.0, 8.0], integers),
            array_of("SHAPE", 1, &[f64::NAN, f64::INFINITY], PLAIN),
        ]
        .concat(),
    );
    let read = arrays(content).unwrap();
    assert!(!read.are_labels && read.table.is_empty());
    let mut values = read.values;
    assert!(values[[0, 4]].is_nan());
    values[[0, 4]] = 0.0;
    assert_eq!(values, array![[1.0, 3.0, 4.0, 5.0, 0.0], [2.0, 6.0, 7.0, 8.0, f64::INFINITY]]);
}

#[test]
fn labels_and_their_names_come_back() {
    let labels = [0, 2, -1, 1, 2];
    let names = [Some("<\"a\" & 'b'>".to_owned()), None, Some("\u{e9}\n\u{0} ]]>".to_owned())];
    let colors = [[1.0, 0.0, 0.25], [f64::NAN; 3], [0.1, 0.2, 0.3]];
    let mut bytes = Vec::new();
    write_labels(&mut bytes, &labels, &names, &colors).unwrap();
    let read = arrays(&bytes).unwrap();
    assert!(read.are_labels);
    assert_eq!(read.values, array![[1.0], [3.0], [0.0], [2.0], [3.0]]);
    let table: Vec<_> = read.table.iter().map(|row| (row.key, row.name.as_str())).collect();
    let escaped = "\u{e9}\\u{a}\\u{0} ]]>";
    assert_eq!(table, [(0, "???"), (1, "<\"a\" & 'b'>"), (2, "region 1"), (3, escaped)]);
    assert_eq!(read.table[1].color, Some([1.0, 0.0, 0.25, 1.0]));
    assert_eq!(read.table[2].color, Some([0.0, 0.0, 0.0, 1.0]));
    // As they were.
    assert_eq!(read.known(), array![[0.0], [2.0], [-1.0], [1.0], [2.0]]);
    assert_survives_damage(&bytes, |bytes| arrays(bytes));
    // Keys that the table does not have are unknown, unless there is no table.
    let integers = Way { of: "INT32", ..PLAIN };
    let keys = array_of("LABEL", 1, &[7.0, 8.0], integers);
    assert_eq!(arrays(file_of(&keys)).unwrap().known(), array![[7.0], [8.0]]);
    let table = "<LabelTable><Label Key=\"7\">a</Label></LabelTable>";
    let keys = arrays(file_of(&(table.to_owned() + &keys))).unwrap();
    assert_eq!(keys.known(), array![[0.0], [-1.0]]);
}

#[test]
fn files_are_found_by_their_content() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("surface"), plain()).unwrap();
    let mesh: Mesh = io::read(&path("surface")).unwrap();
    assert_eq!(mesh, read(Gii, plain()).unwrap());
    let values = file_of(&array_of("NONE", 1, &[0.5, f64::NAN], PLAIN));
    for name in ["a.func.gii", "lh.gii", "lh.data", "a.GII"] {
        std::fs::write(path(name), &values).unwrap();
        assert!(names_values(&path(name)));
        let read: Array2<f64> = io::read_data(&path(name)).unwrap();
        assert!(read[[0, 0]] == 0.5 && read[[1, 0]].is_nan() && read.dim() == (2, 1));
    }
    std::fs::write(path("b.gii"), values.replace("0.5", "inf")).unwrap();
    assert!(message(io::read_data(&path("b.gii")), "inf").contains("row 0, column 0 is inf"));
    for name in ["c.surf.gii", "b.gii"] {
        let refused = message(io::write(&path(name), &mesh), name);
        assert!(
            refused.contains(name) && refused.contains("only read; use one of .obj, .ply"),
            "{refused}"
        );
        assert!(message(io::check_labeled_faces(&path(name)), name).contains(".ply"));
    }
}

#[test]
fn damaged_files() {
    let binary = Way { encoding: "Base64Binary", ..PLAIN };
    let packed = Way { encoding: "GZipBase64Binary", endian: "BigEndian", ..PLAIN };
    for content in [plain(), surface(packed, Way { of: "INT32", ..binary })] {
        assert_survives_damage(content.as_bytes(), |bytes| read(Gii, bytes));
    }
}

fn refused(content: &str, part: &str) {
    let message = message(read(Gii, content), part);
    assert!(message.contains(part), "{part}: {message}");
}

#[test]
fn malformed() {
    let valid = plain();
    for (from, to, part) in [
        ("<GIFTI V", "<Gifti V", "expected GIFTI, not \"Gifti\""),
        ("</GIFTI>\n", "", "ends within the element \"GIFTI\""),
        ("</GIFTI>", "</GIFTI>x", "continues after"),
        ("</DataArray>", "</Data>", "the element \"DataArray\" ends as \"Data\""),
        ("Encoding=\"ASCII\"", "Encoding=\"ExternalFileBinary\"", "in another file"),
        ("Encoding=\"ASCII\"", "Encoding=\"Hex\"", "\"Hex\" is not a valid Encoding"),
        ("Encoding=\"ASCII\"", "", "no attribute Encoding"),
        ("Encoding=\"ASCII\"", "Encoding=\"Base64Binary\"", "is not Base64"),
        ("TYPE_FLOAT32", "TYPE_COMPLEX64", "is not a valid DataType"),
        ("RowMajorOrder", "Rows", "\"Rows\" is not a valid ArrayIndexingOrder"),
        ("Dimensionality=\"2\"", "Dimensionality=\"9\"", "\"9\" is not a valid Dimensionality"),
        ("Dim0=\"4\"", "Dim0=\"3\"", "must have 9 numbers, but has more"),
        ("Dim0=\"4\"", "Dim0=\"5\"", "must have 15 numbers, but has 12"),
        ("Dim0=\"4\"", "Dim0=\"0\"", "\"0\" is not a valid Dim0"),
        ("Dim0=\"4\"", "Dim0=\"-4\"", "\"-4\" is not a valid Dim0"),
        ("Dim0=\"4\"", "Dim0=\"9223372036854775807\"", "is too large"),
        ("Dim1=\"3\"", "Dim1=\"4\"", "must have 16 numbers"),
        ("Dim0=\"4\" Dim1=\"3\"", "Dim0=\"6\" Dim1=\"2\"", "has 2 columns; it must have 3"),
        ("<Data>0", "<Data>x", "\"x\" is not a number of its type"),
        ("<Data>0 ", "<Data>nan ", "vertex 0: NaN is not a finite"),
        ("0\n1\n2\n", "0\n1\n2.5\n", "\"2.5\" is not a number of its type"),
        ("0\n1\n2\n", "0\n1\n4\n", "face 0: refers to vertex 4, but the file has 4 vertices"),
        ("0\n1\n2\n", "0\n1\n-1\n", "refers to vertex -1"),
        ("POINTSET", "NONE", "has no surface|holds no surface"),
        ("TRIANGLE", "POINTSET", "several arrays NIFTI_INTENT_POINTSET"),
        ("\"gifti.dtd\"", "\"gifti.dtd\" [<!ENTITY a \"b\">]", "declarations within the file"),
        ("<!-- <GIFTI> -->", "<!-- <GIFTI>", "does not end"),
    ] {
        assert!(valid.contains(from), "{from}");
        let content = valid.replacen(from, to, 1);
        let message = message(read(Gii, &content), part);
        assert!(part.split('|').any(|part| message.contains(part)), "{part}: {message}");
    }
    refused("", "ends before its first element");
    refused("\u{0}\u{1}", "ends before its first element");
    let numbers = file_of(&array_of("SHAPE", 1, &[0.5], PLAIN));
    refused(&numbers, "give a .surf.gii as mesh");
    assert!(message(arrays(&valid), "surface").contains("no numbers at vertices"));
    let two = array_of("SHAPE", 1, &[0.5], PLAIN) + &array_of("SHAPE", 1, &[0.5, 1.0], PLAIN);
    assert!(message(arrays(file_of(&two)), "lengths").contains("different lengths: 1 and 2 rows"));
    let key = "<LabelTable><Label Key=\"4294967296\">a</Label></LabelTable>";
    assert!(message(arrays(file_of(key)), "key").contains("no valid Key"));
}

/// What is declared needs no memory, and no form of a file takes more than linear time.
#[test]
fn gigantic() {
    let huge = "Dim0=\"1000000000000\"";
    for encoding in ["ASCII", "Base64Binary", "GZipBase64Binary"] {
        let way = Way { encoding, ..PLAIN };
        let content = surface(way, Way { of: "INT32", ..way });
        refused(&content.replace("Dim0=\"4\"", huge), "numbers");
    }
    // Zeros that inflate to a thousand times the file.
    let packed = Way { encoding: "GZipBase64Binary", of: "UINT8", ..PLAIN };
    let zeros = file_of(&array_of("SHAPE", 1, &vec![0.0; 10_000_000], packed));
    assert!(message(arrays(&zeros), "zeros").contains("too many for this file"));
    assert!(message(arrays(zeros.replace("10000000", "10")), "more").contains("has 11 bytes"));

    let nested = "<a>".repeat(1_000_000);
    refused(&format!("<GIFTI>{nested}"), "ends within the element \"a\"");
    let mut attributes = String::new();
    for k in 0..200_000 {
        write!(attributes, " a{k}=\"\"").unwrap();
    }
    refused(&format!("<GIFTI{attributes}></GIFTI>"), "has no surface");
    let pieces = "x<![CDATA[<]]>&lt;".repeat(200_000);
    let table = format!("<LabelTable><Label Key=\"1\">{pieces}</Label></LabelTable>");
    let content = table + &array_of("LABEL", 1, &[1.0], Way { of: "INT32", ..PLAIN });
    assert_eq!(arrays(file_of(&content)).unwrap().table[0].name.len(), 600_000);
}

#[test]
fn references_are_characters() {
    let label = |text: &str| {
        let table = format!("<LabelTable><Label Key=\"-7\">{text}</Label></LabelTable>");
        let read = arrays(file_of(&(table + &array_of("LABEL", 1, &[1.0], PLAIN)))).unwrap();
        (read.table[0].key, read.table[0].name.clone())
    };
    for (text, name) in [
        ("&lt;&gt;&amp;&quot;&apos;", "<>&\"'"),
        ("&#60;&#x3c;&#xe9;&#1114111;", "<<\u{e9}\u{10ffff}"),
        ("&amp;lt;", "&lt;"),
        ("&what; &#x110000; & &", "&what; &#x110000; & &"),
        (" a <b>hidden</b><![CDATA[&lt;]]> ", "a &lt;"),
    ] {
        assert_eq!(label(text), (-7, name.to_owned()));
    }
}
