//! Files of VTK: what we write is read back, all codings of a mesh are the same mesh, and damage is an error of one line.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::io::Write;

use super::super::read_scalars;
use super::super::vtk::{self, Content, Kind, Rows};
use super::{Format, decorated, message, read};
use crate::mesh::{Mesh, Shape};

fn written(mesh: &Mesh, kind: Kind) -> Vec<u8> {
    let labels: Vec<i32> = (0..mesh.vertices.len() as i32).map(|v| v % 3 - 1).collect();
    let u: Vec<f64> = (0..2 * mesh.faces.len()).map(|i| (i as f64).sin()).collect();
    let content = Content {
        mesh,
        of_vertices: vec![("a <label> & \"more\"".into(), Rows::Integers(&labels))],
        of_faces: vec![("u".into(), Rows::Floats(&u, 2))],
        fields: vec![("lambda".into(), vec![0.1]), ("version".into(), vec![0.0, 1.0, f64::NAN])],
    };
    let mut bytes = Vec::new();
    vtk::write(&mut bytes, &content, kind).unwrap();
    bytes
}

#[test]
fn what_is_written_is_read_back_to_the_same_bits() {
    let mesh = Mesh { colors: None, uv: None, ..decorated() };
    for kind in [Kind::PolyData, Kind::UnstructuredGrid] {
        let bytes = written(&mesh, kind);
        assert_eq!(read(Format::Vtk, &bytes).unwrap(), mesh);
        let path = Path::new("some.vtp");
        let found = read_scalars(path, &bytes, &|_, name| name == "u").unwrap();
        assert!(found.of_faces);
        assert_eq!(found.names, ["u[0]", "u[1]"]);
        assert_eq!(found.numbers[[3, 1]], 7.0_f64.sin());
        let found = read_scalars(path, &bytes, &|of, _| of == "vertex").unwrap();
        assert_eq!(found.names, ["a <label> & \"more\""]);
        assert_eq!(found.numbers.column(0).to_vec()[..4], [-1.0, 0.0, 1.0, -1.0]);
    }
}

#[test]
fn colors_survive_a_conversion() {
    let folder = tempfile::tempdir().unwrap();
    let mut mesh = Mesh { uv: None, ..decorated() };
    for color in mesh.colors.iter_mut().flatten() {
        *color = color.map(|c| (255.0 * c).round() / 255.0);
    }
    mesh.face_colors = Some(mesh.faces.iter().map(|f| [f64::from(f[0] % 2), 0.0, 1.0]).collect());
    for name in ["mesh.vtp", "mesh.VTU"] {
        let path = folder.path().join(name);
        super::super::write(&path, &mesh).unwrap();
        assert_eq!(super::super::read(&path).unwrap(), mesh);
    }
    let legacy = super::super::write(&folder.path().join("mesh.vtk"), &mesh).unwrap_err();
    assert!(legacy.to_string().contains("write .vtp or .vtu"), "{legacy}");
}

/// The coordinates and corners of two triangles that share an edge, with their numbers.
const POINTS: [f32; 12] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.5, 0.0, 1.0, 0.0];
const CORNERS: [i32; 6] = [0, 1, 2, 0, 2, 3];
const VALUES: [f64; 2] = [0.25, -7.0];

fn square() -> Mesh {
    let vertices = POINTS.chunks(3).map(|x| nalgebra::Point3::new(x[0], x[1], x[2]).cast());
    Mesh::new(vertices.collect(), vec![[0, 1, 2], [0, 2, 3]])
}

/// How bytes are put into a file of XML.
#[derive(Clone, Copy, Debug)]
struct Coding {
    little: bool,
    wide: bool,
    /// The size of a block.
    block: Option<usize>,
    base64: bool,
    appended: bool,
}

impl Coding {
    fn words(&self, words: &[usize]) -> Vec<u8> {
        let word = |&n: &usize| match (self.wide, self.little) {
            (true, true) => (n as u64).to_le_bytes().to_vec(),
            (true, false) => (n as u64).to_be_bytes().to_vec(),
            (false, true) => (n as u32).to_le_bytes().to_vec(),
            (false, false) => (n as u32).to_be_bytes().to_vec(),
        };
        words.iter().flat_map(word).collect()
    }

    fn coded(&self, bytes: &[u8]) -> Vec<u8> {
        let (head, body) = match self.block {
            None => (self.words(&[bytes.len()]), bytes.to_vec()),
            Some(block) => {
                let blocks: Vec<Vec<u8>> = bytes
                    .chunks(block)
                    .map(|part| {
                        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
                        encoder.write_all(part).unwrap();
                        encoder.finish().unwrap()
                    })
                    .collect();
                let mut words = vec![blocks.len(), block, bytes.len() % block];
                words.extend(blocks.iter().map(Vec::len));
                (self.words(&words), blocks.concat())
            }
        };
        match (self.base64, self.block) {
            (false, _) => [head, body].concat(),
            (true, None) => STANDARD.encode([head, body].concat()).into_bytes(),
            (true, Some(_)) => (STANDARD.encode(head) + &STANDARD.encode(body)).into_bytes(),
        }
    }

    fn file(&self, kind: &str) -> Vec<u8> {
        let number = |bytes: &dyn Fn(bool) -> Vec<u8>| bytes(self.little);
        let points = number(&|little| {
            POINTS
                .iter()
                .flat_map(|x| if little { x.to_le_bytes() } else { x.to_be_bytes() })
                .collect()
        });
        let corners = number(&|little| {
            CORNERS
                .iter()
                .flat_map(|x| if little { x.to_le_bytes() } else { x.to_be_bytes() })
                .collect()
        });
        let ends = number(&|little| {
            [3_i64, 6]
                .iter()
                .flat_map(|x| if little { x.to_le_bytes() } else { x.to_be_bytes() })
                .collect()
        });
        let values = number(&|little| {
            VALUES
                .iter()
                .flat_map(|x| if little { x.to_le_bytes() } else { x.to_be_bytes() })
                .collect()
        });
        let mut behind = Vec::new();
        let mut array = |attributes: &str, bytes: &[u8]| {
            let coded = self.coded(bytes);
            if self.appended {
                let offset = behind.len();
                behind.extend(coded);
                return format!(
                    "<DataArray {attributes} format=\"appended\" offset=\"{offset}\"/>"
                );
            }
            let text = String::from_utf8(coded).unwrap();
            format!("<DataArray {attributes} format=\"binary\">\n {text}\n</DataArray>")
        };
        let points = array("type=\"Float32\" NumberOfComponents=\"3\"", &points);
        let corners = array("type=\"Int32\" Name=\"connectivity\"", &corners);
        let ends = array("type=\"Int64\" Name=\"offsets\"", &ends);
        let types = array("type=\"UInt8\" Name=\"types\"", &[5, 5]);
        let values = array("type=\"Float64\" Name=\"value\"", &values);
        let (cells, number) = match kind {
            "PolyData" => ("Polys", "NumberOfPolys"),
            _ => ("Cells", "NumberOfCells"),
        };
        let types = if kind == "PolyData" { String::new() } else { types };
        let order = if self.little { "LittleEndian" } else { "BigEndian" };
        let header = if self.wide { "UInt64" } else { "UInt32" };
        let compressor =
            if self.block.is_some() { "compressor=\"vtkZLibDataCompressor\"" } else { "" };
        let mut text = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"{kind}\" version=\"1.0\" byte_order=\"{order}\" \
             header_type=\"{header}\" {compressor}><{kind}><Piece NumberOfPoints=\"4\" {number}=\"2\">\
             <CellData>{values}</CellData><Points>{points}</Points><{cells}>{corners}{ends}{types}</{cells}>\
             </Piece></{kind}>"
        )
        .into_bytes();
        if self.appended {
            let encoding = if self.base64 { "base64" } else { "raw" };
            text.extend(format!("<AppendedData encoding=\"{encoding}\">\n _").into_bytes());
            text.extend(behind);
            text.extend(b"\n</AppendedData>");
        }
        text.extend(b"</VTKFile>");
        text
    }
}

fn codings() -> impl Iterator<Item = Coding> {
    let choices = (0..16).flat_map(|bits| [None, Some(7), Some(4096)].map(|block| (bits, block)));
    choices
        .map(|(bits, block)| Coding {
            little: bits & 1 > 0,
            wide: bits & 2 > 0,
            block,
            base64: bits & 4 > 0,
            appended: bits & 8 > 0,
        })
        .filter(|coding| coding.base64 || coding.appended)
}

#[test]
fn all_codings_are_the_same_mesh() {
    for coding in codings() {
        for kind in ["PolyData", "UnstructuredGrid"] {
            let bytes = coding.file(kind);
            assert_eq!(read(Format::Vtk, &bytes).unwrap(), square(), "{coding:?} {kind}");
            let found =
                read_scalars(Path::new("a.vtu"), &bytes, &|_, name| name == "value").unwrap();
            assert_eq!(found.numbers.column(0).to_vec(), VALUES, "{coding:?}");
        }
    }
}

const LEGACY: &str = "# vtk DataFile Version 3.0\na title\nASCII\nDATASET POLYDATA\nFIELD FieldData 1\nwho 1 1 string\nme too\n\
    POINTS 5 float\n0 0 0 1 0 0 1 1 0.5\n0 1 0 0.5 2 0\n\nVERTICES 1 2\n1 0\nPOLYGONS 1 5\n4 0 1 2 3\nTRIANGLE_STRIPS 1 4\n3 3 2 4\n\
    CELL_DATA 3\nSCALARS region%20of int\nLOOKUP_TABLE default\n7\n8\n9\nPOINT_DATA 5\nCOLOR_SCALARS any 3\n\
    1 0 0 0 1 0 0 0 1 1 1 1 0 0 0\nMETADATA\nINFORMATION 0\n\nFIELD more 2\np 2 5 double\n1 2 3 4 5 6 7 8 9 10\nq 1 5 char\n1 2 3 4 5\n";

#[test]
fn legacy_text_is_read() {
    let mesh = read(Format::Vtk, LEGACY).unwrap();
    assert_eq!(mesh.faces, [[0, 1, 2], [0, 2, 3], [3, 2, 4]]);
    assert_eq!(mesh.colors.unwrap()[1], [0.0, 1.0, 0.0]);
    let path = Path::new("some.vtk");
    // The quadrilateral is two triangles, the vertex none.
    let found = read_scalars(path, LEGACY.as_bytes(), &|_, name| name == "region of").unwrap();
    assert!(found.of_faces && found.numbers.column(0).to_vec() == [8.0, 8.0, 9.0]);
    let found =
        read_scalars(path, LEGACY.as_bytes(), &|_, name| name == "p" || name == "q").unwrap();
    assert_eq!(found.numbers.row(4).to_vec(), [9.0, 10.0, 5.0]);
    let error = read_scalars(path, LEGACY.as_bytes(), &|_, name| name == "w").err().unwrap();
    assert!(error.to_string().contains("vertex:p, vertex:q, face:region of"), "{error}");
}

#[test]
fn legacy_bytes_and_version_5_are_the_same_mesh() {
    let big = |numbers: &[i32]| numbers.iter().flat_map(|x| x.to_be_bytes()).collect::<Vec<u8>>();
    let points: Vec<u8> = POINTS.iter().flat_map(|x| x.to_be_bytes()).collect();
    let head = |version: &str, set: &str| {
        format!("# vtk DataFile Version {version}\ntitle\nBINARY\nDATASET {set}\nPOINTS 4 float\n")
            .into_bytes()
    };
    let polydata = [
        head("4.2", "POLYDATA"),
        points.clone(),
        b"\nPOLYGONS 2 8\n".to_vec(),
        big(&[3, 0, 1, 2, 3, 0, 2, 3]),
        b"\n".to_vec(),
    ]
    .concat();
    let grid = [
        head("3.0", "UNSTRUCTURED_GRID"),
        points.clone(),
        b"\nCELLS 2 8\n".to_vec(),
        big(&[3, 0, 1, 2, 3, 0, 2, 3]),
        b"\nCELL_TYPES 2\n".to_vec(),
        big(&[5, 7]),
        b"\nPOINT_DATA 4\nSCALARS a unsigned_char 2\nLOOKUP_TABLE default\n".to_vec(),
        vec![10, 1, 10, 2, 32, 3, 10, 4],
        b"\n".to_vec(),
    ]
    .concat();
    let wide = |numbers: &[i64]| numbers.iter().flat_map(|x| x.to_be_bytes()).collect::<Vec<u8>>();
    let version_5 = [
        head("5.1", "POLYDATA"),
        points,
        b"\nPOLYGONS 3 6\nOFFSETS vtktypeint64\n".to_vec(),
        wide(&[0, 3, 6]),
        b"\nCONNECTIVITY vtktypeint64\n".to_vec(),
        wide(&[0, 1, 2, 0, 2, 3]),
        b"\n".to_vec(),
    ]
    .concat();
    for bytes in [&polydata, &grid, &version_5] {
        assert_eq!(read(Format::Vtk, bytes).unwrap(), square());
        assert_eq!(Format::of_content(bytes), Some(Format::Vtk));
    }
    let found = read_scalars(Path::new("a.vtk"), &grid, &|_, name| name == "a").unwrap();
    assert_eq!(found.numbers.row(2).to_vec(), [32.0, 3.0]);
}

/// Bytes of all kinds, cut off anywhere or changed anywhere, are a mesh or an error of one line.
#[test]
fn damage_is_an_error_of_one_line() {
    let files = [
        LEGACY.as_bytes().to_vec(),
        written(&Shape::Torus { nu: 3, nv: 3 }.mesh(), Kind::UnstructuredGrid),
        Coding { little: true, wide: false, block: Some(16), base64: true, appended: false }
            .file("PolyData"),
        Coding { little: false, wide: true, block: Some(16), base64: false, appended: true }
            .file("PolyData"),
    ];
    let check = |bytes: &[u8], context: &str| {
        if let Err(error) = read(Format::Vtk, bytes) {
            message::<Mesh>(Err(error), context);
        }
    };
    for (i, file) in files.iter().enumerate() {
        for end in 0..file.len() {
            check(&file[..end], &format!("file {i} up to {end}"));
            for byte in [b'9', b'-', 0xff] {
                let mut changed = file.clone();
                changed[end] = byte;
                check(&changed, &format!("file {i} with {byte} at {end}"));
            }
        }
    }
}

#[test]
fn what_is_no_surface_is_refused() {
    let cases = [
        (LEGACY.replace("POLYDATA", "STRUCTURED_POINTS"), "only POLYDATA and UNSTRUCTURED_GRID"),
        (LEGACY.replace("POINTS 5", "POINTS 900000000000"), "more than the file has bytes"),
        (LEGACY.replace("3 3 2 4\n", "3 3 2 5\n"), "cell 2 has the point 5; there are 5"),
        (LEGACY.replace("4 0 1 2 3\n", "4 0 1 2 x\n"), "`x` is not a number"),
        (LEGACY.replace("ASCII", "EBCDIC"), "neither ASCII nor BINARY"),
        ("<VTKFile type=\"ImageData\"/>".into(), "`ImageData`; only PolyData"),
        ("<VTKFile type=\"PolyData\" compressor=\"vtkLZ4DataCompressor\"/>".into(), "write it with zlib"),
        ("<VTKFile type=\"PolyData\"><PolyData/></VTKFile>".into(), "has no faces"),
        ("<VTKFile".into(), "does not end"),
        (LEGACY.replace("int\nLOOKUP", "int 0\nLOOKUP"), "has no components"),
        (
            "# vtk DataFile Version 2.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0 0 1 0 0 0 1 0 0 0 1\n\
             CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n"
                .into(),
            "extract the surface",
        ),
    ];
    for (content, expected) in cases {
        let found = message(read(Format::Vtk, &content), &content);
        assert!(found.contains(expected), "{found}");
    }
}
