//! The result for other programs: VTK, glTF, GIFTI, FreeSurfer and JSON.
//!
//! | name | file | content |
//! |---|---|---|
//! | `vtp`, `vtu` | `segmented.vtp` | label, U, margin (largest entry of u less the second); labels of faces; bounds |
//! | `glb` | `segmented.glb` | the surface in the colors of the regions, and a label per vertex |
//! | `label-gii` | `segmented.label.gii` | labels of vertices, with names and colors |
//! | `annot` | `segmented.annot` | the same for FreeSurfer |
//! | `json` | `labels.json` | labels of vertices and faces, names, colors |

use std::io::Write;
use std::ops::Range;
use std::path::Path;

use ndarray::{Array1, Array2, s};
use serde::Serialize;
use strum::{EnumIter, EnumString, IntoStaticStr, VariantNames};

use crate::error::Result;
use crate::file;
use crate::mesh::Mesh;
use crate::mesh::io::vtk::{self, Content, Rows};
use crate::mesh::io::{
    Properties, Scalars, write_annotation, write_glb, write_glb_of_faces, write_labels,
};
use crate::solve::Summary;

/// A format in which the result is written as well.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumIter, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum Export {
    /// PolyData of VTK.
    Vtp,
    /// An unstructured grid of VTK.
    Vtu,
    /// Binary glTF.
    Glb,
    /// Labels of GIFTI.
    LabelGii,
    /// An annotation of FreeSurfer.
    Annot,
    /// Text.
    Json,
}

/// What is written: labels with their U on a mesh.
#[derive(Clone, Copy)]
pub struct Exported<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// The numbers of the result.
    pub summary: &'a Summary,
    /// A row per vertex, or per face if the labels are those of faces.
    pub u: &'a Array2<f64>,
    /// V labels; -1 where there is none.
    pub vertices: &'a Array1<i32>,
    /// F labels, if there are any.
    pub faces: Option<&'a Array1<i32>>,
    /// The names of the regions.
    pub names: &'a [String],
    /// Their colors, RGB in [0, 1].
    pub colors: &'a [[f64; 3]],
    /// What the file of the mesh had besides.
    pub others: &'a Properties,
}

impl Export {
    /// The name of the file.
    pub fn file(self) -> &'static str {
        match self {
            Export::Vtp => "segmented.vtp",
            Export::Vtu => "segmented.vtu",
            Export::Glb => "segmented.glb",
            Export::LabelGii => "segmented.label.gii",
            Export::Annot => "segmented.annot",
            Export::Json => "labels.json",
        }
    }

    /// Writes the file into a folder.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(self, folder: &Path, exported: Exported<'_>) -> Result<()> {
        let Exported { mesh, vertices, names, colors, .. } = exported;
        let path = folder.join(self.file());
        let labels = || vertices.to_vec();
        let names: Vec<Option<String>> = names.iter().cloned().map(Some).collect();
        file::write(&path, |out: &mut dyn Write| match self {
            Export::Vtp => exported.vtk(out, vtk::Kind::PolyData),
            Export::Vtu => exported.vtk(out, vtk::Kind::UnstructuredGrid),
            Export::Glb => match exported.faces.filter(|_| exported.summary.on.is_some()) {
                Some(faces) => write_glb_of_faces(out, mesh, &faces.to_vec(), colors),
                None => write_glb(out, mesh, &labels(), colors),
            },
            Export::LabelGii => write_labels(out, &labels(), &names, colors),
            Export::Annot => write_annotation(out, &labels(), &names, colors),
            Export::Json => exported.json(out),
        })
    }
}

impl Exported<'_> {
    fn vtk(self, out: &mut dyn Write, kind: vtk::Kind) -> std::io::Result<()> {
        let Exported { mesh, summary, u, vertices, faces, .. } = self;
        let (vertices, faces) = (vertices.to_vec(), faces.map(|labels| labels.to_vec()));
        let u = u.as_standard_layout();
        let numbers = u.as_slice().expect("in standard layout");
        let margins: Vec<f64> = u.outer_iter().map(|row| margin(row.iter())).collect();
        let of_u = || {
            [
                ("u".to_owned(), Rows::Floats(numbers, u.ncols())),
                ("margin".to_owned(), Rows::Floats(&margins, 1)),
            ]
        };
        let mut of_vertices = vec![("label".to_owned(), Rows::Integers(&vertices))];
        let mut of_faces: Vec<_> =
            faces.iter().map(|labels| ("label".to_owned(), Rows::Integers(labels))).collect();
        match summary.on {
            Some(_) => of_faces.extend(of_u()),
            None => of_vertices.extend(of_u()),
        }
        let [others_of_vertices, others_of_faces] =
            [&self.others.of_vertices, &self.others.of_faces].map(columns);
        of_vertices.extend(others_of_vertices.iter().map(Column::rows));
        of_faces.extend(others_of_faces.iter().map(Column::rows));
        let number = |name: &str, x: f64| (name.to_owned(), vec![x]);
        let mut fields = vec![
            number("lambda", summary.lambda),
            number("energy", summary.energy),
            number("dual_bound", summary.dual_bound),
            number("relative_gap", summary.relative_gap),
            number("rounded_energy", summary.rounded_energy),
            number("rounded_relative_gap", summary.rounded_relative_gap),
            ("meshseg_version".to_owned(), version()),
        ];
        // Text has no infinity that all programs read.
        fields.retain(|(_, numbers)| numbers.iter().all(|x| x.is_finite()));
        vtk::write(out, &Content { mesh, of_vertices, of_faces, fields }, kind)
    }

    fn json(self, out: &mut dyn Write) -> std::io::Result<()> {
        #[derive(Serialize)]
        struct Region<'a> {
            name: &'a str,
            color: [f64; 3],
        }
        #[derive(Serialize)]
        struct Labels<'a> {
            regions: Vec<Region<'a>>,
            labels: Vec<i32>,
            #[serde(skip_serializing_if = "Option::is_none")]
            face_labels: Option<Vec<i32>>,
        }
        let regions = self.names.iter().zip(self.colors);
        let labels = Labels {
            regions: regions.map(|(name, &color)| Region { name, color }).collect(),
            labels: self.vertices.to_vec(),
            face_labels: self.faces.map(|labels| labels.to_vec()),
        };
        serde_json::to_writer(&mut *out, &labels)?;
        out.write_all(b"\n")
    }
}

/// An array of the file of a mesh, row by row.
struct Column {
    name: String,
    numbers: Vec<f64>,
    components: usize,
}

impl Column {
    fn rows(&self) -> (String, Rows<'_>) {
        (self.name.clone(), Rows::Floats(&self.numbers, self.components))
    }
}

fn columns(others: &Option<Scalars>) -> Vec<Column> {
    let Some(others) = others else { return Vec::new() };
    let array = |(name, columns): (String, Range<usize>)| {
        let numbers = others.numbers.slice(s![.., columns.clone()]);
        Column { name, numbers: numbers.iter().copied().collect(), components: columns.len() }
    };
    others.arrays(&["label", "u", "margin"]).into_iter().map(array).collect()
}

/// Major, minor, patch.
fn version() -> Vec<f64> {
    let parts = env!("CARGO_PKG_VERSION").split('.');
    parts.filter_map(|part| part.parse().ok()).collect()
}

/// The largest number of a row less the second; NaN if the row is unknown.
fn margin<'a>(row: impl Iterator<Item = &'a f64>) -> f64 {
    let (mut first, mut second) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
    for &u in row {
        if u.is_nan() {
            return f64::NAN;
        }
        (first, second) = if u > first { (u, first) } else { (first, second.max(u)) };
    }
    first - second
}
