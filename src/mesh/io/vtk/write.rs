//! Writes files of VTK in XML: a mesh with arrays of its points, its cells and the whole, as bytes behind the text,
//! which are read back to the same bits. The format is that of `xml.rs`.

use std::io::{self, Write};
use std::path::Path;

use crate::error::{Error, Result};
use crate::file;
use crate::mesh::Mesh;
use crate::mesh::io::{coordinates, known};

/// What the file is a set of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// .vtp
    PolyData,
    /// .vtu
    UnstructuredGrid,
}

impl Kind {
    /// The kind of a name.
    ///
    /// # Errors
    /// It ends in .vtk, which is only read.
    pub fn of_extension(path: &Path) -> Result<Self> {
        match path.extension() {
            Some(end) if end.eq_ignore_ascii_case("vtp") => Ok(Kind::PolyData),
            Some(end) if end.eq_ignore_ascii_case("vtu") => Ok(Kind::UnstructuredGrid),
            _ => {
                Err(Error::malformed(path, "legacy files of VTK are only read; write .vtp or .vtu"))
            }
        }
    }
}

/// The numbers of an array, row by row.
#[derive(Clone, Copy, Debug)]
pub enum Rows<'a> {
    /// Labels.
    Integers(&'a [i32]),
    /// With a number of components.
    Floats(&'a [f64], usize),
    /// RGB in bytes.
    Colors(&'a [[u8; 3]]),
}

/// A mesh with arrays, by name.
pub struct Content<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// One row per vertex; the first one is what is shown.
    pub of_vertices: Vec<(String, Rows<'a>)>,
    /// One row per face.
    pub of_faces: Vec<(String, Rows<'a>)>,
    /// Numbers of the whole. Not texts, which meshio does not read.
    pub fields: Vec<(String, Vec<f64>)>,
}

type Writer<'a> = Box<dyn Fn(&mut dyn Write) -> io::Result<()> + 'a>;

/// An array behind the text.
struct Block<'a> {
    bytes: usize,
    write: Writer<'a>,
}

/// The text, and what follows it.
#[derive(Default)]
struct Document<'a> {
    text: String,
    blocks: Vec<Block<'a>>,
    offset: usize,
}

impl<'a> Document<'a> {
    fn array(
        &mut self,
        (name, kind, components): (&str, &str, usize),
        bytes: usize,
        write: impl Fn(&mut dyn Write) -> io::Result<()> + 'a,
    ) {
        // Without a number of components meshio has N numbers, with 1 an array of N x 1.
        let of = match components {
            1 => String::new(),
            n => format!(" NumberOfComponents=\"{n}\""),
        };
        self.text += &format!(
            "<DataArray type=\"{kind}\" Name=\"{}\"{of} format=\"appended\" offset=\"{}\"/>\n",
            escaped(name),
            self.offset
        );
        self.offset += size_of::<u64>() + bytes;
        self.blocks.push(Block { bytes, write: Box::new(write) });
    }

    fn rows(&mut self, name: &str, rows: Rows<'a>) {
        match rows {
            Rows::Integers(all) => self.array((name, "Int32", 1), 4 * all.len(), move |out| {
                all.iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))
            }),
            Rows::Colors(all) => self.array((name, "UInt8", 3), 3 * all.len(), move |out| {
                out.write_all(all.as_flattened())
            }),
            Rows::Floats(all, components) => {
                self.array((name, "Float64", components), 8 * all.len(), move |out| {
                    all.iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))
                });
            }
        }
    }

    fn data(&mut self, element: &str, arrays: &[(String, Rows<'a>)]) {
        let shown = arrays.first().map(|(name, _)| format!(" Scalars=\"{}\"", escaped(name)));
        self.text += &format!("<{element}{}>\n", shown.unwrap_or_default());
        arrays.iter().for_each(|(name, rows)| self.rows(name, *rows));
        self.text += &format!("</{element}>\n");
    }

    fn fields(&mut self, fields: &[(String, Vec<f64>)]) {
        self.text += "<FieldData>\n";
        for (name, numbers) in fields {
            let words: Vec<String> = numbers.iter().map(|x| format!("{x:?}")).collect();
            self.text += &format!(
                "<DataArray type=\"Float64\" Name=\"{}\" NumberOfTuples=\"{}\" format=\"ascii\">{}</DataArray>\n",
                escaped(name),
                numbers.len(),
                words.join(" ")
            );
        }
        self.text += "</FieldData>\n";
    }
}

/// Writes the file.
///
/// # Errors
/// Those of `out`.
pub fn write(out: &mut dyn Write, content: &Content<'_>, kind: Kind) -> io::Result<()> {
    let Content { mesh, of_vertices, of_faces, fields } = content;
    let (v, f) = (mesh.vertices.len(), mesh.faces.len());
    let (set, number, cells) = match kind {
        Kind::PolyData => ("PolyData", "NumberOfPolys", "Polys"),
        Kind::UnstructuredGrid => ("UnstructuredGrid", "NumberOfCells", "Cells"),
    };
    let mut document = Document::default();
    document.text += &format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"{set}\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\">\n<{set}>\n"
    );
    document.fields(fields);
    document.text += &format!("<Piece NumberOfPoints=\"{v}\" {number}=\"{f}\">\n");
    document.data("PointData", of_vertices);
    document.data("CellData", of_faces);
    document.text += "<Points>\n";
    document.array(("Points", "Float64", 3), 24 * v, |out| {
        let mut numbers = mesh.vertices.iter().flat_map(coordinates);
        numbers.try_for_each(|x| out.write_all(&x.to_le_bytes()))
    });
    document.text += &format!("</Points>\n<{cells}>\n");
    document.array(("connectivity", "Int64", 1), 24 * f, |out| {
        let mut corners = mesh.faces.iter().flatten();
        corners.try_for_each(|&v| out.write_all(&i64::from(v).to_le_bytes()))
    });
    document.array(("offsets", "Int64", 1), 8 * f, move |out| {
        (1..=f).try_for_each(|j| out.write_all(&(3 * j as i64).to_le_bytes()))
    });
    if kind == Kind::UnstructuredGrid {
        document.array(("types", "UInt8", 1), f, move |out| out.write_all(&vec![TRIANGLE; f]));
    }
    document.text += &format!("</{cells}>\n</Piece>\n</{set}>\n<AppendedData encoding=\"raw\">\n_");
    out.write_all(document.text.as_bytes())?;
    for Block { bytes, write } in &document.blocks {
        out.write_all(&(*bytes as u64).to_le_bytes())?;
        write(out)?;
    }
    out.write_all(b"\n</AppendedData>\n</VTKFile>\n")
}

/// Writes a mesh with its colors.
///
/// # Errors
/// The file cannot be written, or its name ends in .vtk, the legacy format.
pub fn write_mesh(path: &Path, mesh: &Mesh) -> Result<()> {
    let kind = Kind::of_extension(path)?;
    let [vertices, faces] = [&mesh.colors, &mesh.face_colors].map(|c| c.as_deref().map(bytes));
    let content = Content {
        mesh,
        of_vertices: colors(vertices.as_deref()),
        of_faces: colors(faces.as_deref()),
        fields: Vec::new(),
    };
    file::write(path, |out: &mut dyn Write| write(out, &content, kind))
}

fn bytes(colors: &[[f64; 3]]) -> Vec<[u8; 3]> {
    colors.iter().map(|&color| known(color).map(|c| (255.0 * c).round() as u8)).collect()
}

fn colors(colors: Option<&[[u8; 3]]>) -> Vec<(String, Rows<'_>)> {
    colors.map(|colors| ("RGB".to_owned(), Rows::Colors(colors))).into_iter().collect()
}

/// The number of a triangle among the cells of VTK.
const TRIANGLE: u8 = 5;

/// A text within an attribute. Control characters, which XML does not have, become spaces.
fn escaped(text: &str) -> String {
    let escape = |c: char| match c {
        '&' => "&amp;".into(),
        '<' => "&lt;".into(),
        '>' => "&gt;".into(),
        '"' => "&quot;".into(),
        c if c.is_control() => " ".into(),
        c => c.to_string(),
    };
    text.chars().map(escape).collect::<Vec<String>>().concat()
}
