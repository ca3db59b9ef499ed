//! The result folder of a run: numbers, trace, fields, the colored mesh, the contour, a picture.
//!
//! Other programs read it; docs/interface.md specifies names and contents. It is written completely or not at all.

mod exports;

use std::io::Write;
use std::path::Path;

use image::RgbImage;
use ndarray::{Array1, Array2};
use serde::Serialize;
use strum::IntoEnumIterator;

use crate::contour::{Contours, compared_rows};
use crate::error::{Error, Result};
use crate::file;
use crate::mesh::io::Properties;
use crate::mesh::{Mesh, io};
use crate::names::Named;
use crate::npy;
use crate::render::{Picture, Region, View};
use crate::run::{Certificate, Sample};
use crate::solve::Solution;
use crate::sweep;

pub use exports::Export;
use exports::Exported;

/// The appearance of the regions and the data.
pub struct Looks {
    /// One per region, in the order of the columns of U.
    pub regions: Vec<Region>,
    /// The names of the regions.
    pub names: Vec<String>,
    /// Without data no picture is drawn.
    pub data: Option<PicturedData>,
    /// Photographs with the cut, if the data are views.
    pub views: Option<RgbImage>,
}

/// The data in the picture.
pub struct PicturedData {
    /// One per vertex of the mesh that is drawn; NaN where the data are unknown.
    pub colors: Vec<[f64; 3]>,
    /// The caption of the data.
    pub caption: String,
    /// The direction from which the mesh is viewed.
    pub view: View,
}

/// What a run found.
#[derive(Clone, Copy)]
pub struct Labeled<'a> {
    /// The solution; its labels and the rows of U may be those of faces.
    pub solution: &'a Solution,
    /// The labels of the vertices.
    pub vertices: &'a Array1<i32>,
    /// The labels of the faces, if there are any.
    pub faces: Option<&'a Array1<i32>>,
    /// What is drawn, if it is not the mesh with U.
    pub drawn: Option<Drawn<'a>>,
    /// The file of the mesh, if it has one: what it has at its vertices and faces reaches the results.
    pub source: Option<&'a Path>,
}

/// What is drawn in place of the mesh and U.
#[derive(Clone, Copy)]
pub struct Drawn<'a> {
    /// A mesh with one color of the data per vertex.
    pub mesh: &'a Mesh,
    /// A row of m numbers per vertex: the region at a point is that of the largest.
    pub u: &'a Array2<f64>,
}

impl<'a> From<&'a Solution> for Labeled<'a> {
    fn from(solution: &'a Solution) -> Self {
        Labeled { solution, vertices: &solution.labels, faces: None, drawn: None, source: None }
    }
}

/// Writes the folder; `summary` becomes `summary.json`. The labels belong to the mesh. A `preview.png`, `views.png`,
/// `q.npy`, `face_labels.npy`, `contours.obj` or export of an earlier run is removed if this run does not write one. Without
/// the `summary.json` and `trace.csv` of an earlier run, nothing is removed, nor is the file of the mesh.
///
/// Fails if a file cannot be written or removed.
pub fn write(
    folder: &Path,
    summary: &impl Serialize,
    labeled: Labeled<'_>,
    mesh: &Mesh,
    looks: &Looks,
    contours: Option<&Contours>,
    exports: &[Export],
) -> Result<()> {
    let Labeled { solution, vertices, faces, drawn, source } = labeled;
    // A result is not lost for what cannot be read again.
    let others = source.map_or_else(Properties::default, |source| {
        io::read_properties(source, mesh).unwrap_or_else(|error| {
            tracing::warn!("{error}; its properties do not reach the results");
            Properties::default()
        })
    });
    // What an earlier run may have written and this one does not.
    let written = [
        ("preview.png", looks.data.is_some()),
        ("views.png", looks.views.is_some()),
        ("q.npy", solution.q.is_some()),
        ("face_labels.npy", faces.is_some()),
        ("contours.obj", contours.is_some()),
    ];
    let exported = Export::iter().map(|export| (export.file(), exports.contains(&export)));
    let missing = written.into_iter().chain(exported).filter(|(_, written)| !written);
    let clear = || remove_earlier(folder, missing.map(|(name, _)| name), source);
    let fill = |folder: &Path| {
        let arrays = || {
            npy::write(&folder.join("u.npy"), &solution.u)?;
            if let Some(q) = &solution.q {
                npy::write(&folder.join("q.npy"), q)?;
            }
            if let Some(faces) = faces {
                npy::write(&folder.join("face_labels.npy"), faces)?;
            }
            npy::write(&folder.join("labels.npy"), vertices)
        };
        let bytes = |labels: &Array1<i32>| labels.iter().map(|&label| label as u8).collect();
        let (labels, face_labels): (Vec<u8>, Option<Vec<u8>>) = (bytes(vertices), faces.map(bytes));
        let palette: Vec<[f64; 3]> = looks.regions.iter().map(|region| region.color).collect();
        let segmented = || {
            let path = folder.join("segmented.ply");
            io::write_labeled(&path, mesh, &labels, face_labels.as_deref(), &palette, &others)
        };
        let (arrays, segmented) = sweep::join(arrays, segmented);
        arrays.and(segmented)?;
        write_trace(&folder.join("trace.csv"), &solution.trace)?;
        let exported = Exported {
            mesh,
            summary: &solution.summary,
            u: &solution.u,
            vertices,
            faces,
            names: &looks.names,
            colors: &palette,
            others: &others,
        };
        exports.iter().try_for_each(|export| export.write(folder, exported))?;
        if let Some(contours) = contours {
            file::write(&folder.join("contours.obj"), |out| contours.write(out))?;
        }

        if let Some(PicturedData { colors, caption, view }) = &looks.data {
            let regions = &looks.regions;
            let threshold = solution.summary.cut_threshold;
            let (mesh, u) = match drawn {
                None => (mesh, compared_rows(solution.u.view(), threshold)),
                Some(Drawn { mesh, u }) => (mesh, compared_rows(u.view(), threshold)),
            };
            let u = u.as_slice().expect("rows are contiguous");
            let image = Picture { mesh, data: colors, caption, regions, u, view: *view }.draw();
            write_png(&folder.join("preview.png"), &image)?;
        }
        if let Some(views) = &looks.views {
            write_png(&folder.join("views.png"), views)?;
        }
        file::write(&folder.join("summary.json"), |out| {
            serde_json::to_writer_pretty(&mut *out, summary)?;
            out.write_all(b"\n")
        })
    };
    file::write_folder_over(folder, fill, clear)
}

/// Removes files of an earlier run, which do not belong to this one, but for the file of the mesh.
fn remove_earlier(
    folder: &Path,
    mut names: impl Iterator<Item = &'static str>,
    source: Option<&Path>,
) -> Result<()> {
    let had_a_result = ["summary.json", "trace.csv"].iter().all(|name| folder.join(name).is_file());
    if !had_a_result {
        return Ok(());
    }
    names.try_for_each(|name| {
        let path = folder.join(name);
        if source.is_some_and(|source| is_same(source, &path)) {
            return Ok(());
        }
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                Err(Error::io(&path, error))
            }
            _ => Ok(()),
        }
    })
}

/// Whether two paths name the same existing file.
fn is_same(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// Writes a picture as a PNG file, which is a third larger than it could be since it is encoded fast.
///
/// # Errors
/// The file cannot be written.
pub fn write_png(path: &Path, image: &RgbImage) -> Result<()> {
    let encode = |out: &mut dyn Write| -> std::result::Result<(), png::EncodingError> {
        let mut encoder = png::Encoder::new(out, image.width(), image.height());
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_compression(png::Compression::Fast);
        encoder.set_filter(png::FilterType::Up);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(image)?;
        writer.finish()
    };
    file::write(path, |out| encode(out).map_err(std::io::Error::other))
}

pub(crate) fn write_trace(path: &Path, trace: &[Sample]) -> Result<()> {
    let smoothed = trace.iter().any(|sample| sample.smoothed_energy.is_some());
    let certified = trace.iter().any(|sample| sample.certificate.is_some());
    file::write(path, |out| {
        let mut csv = csv::Writer::from_writer(out);
        let mut header =
            vec!["iteration", "seconds", "energy", "dual_bound", "gap", "relative_gap", "change"];
        header.extend(smoothed.then_some("smoothed_energy"));
        header.extend(certified.then_some("certificate"));
        csv.write_record(&header)?;
        for sample in trace {
            let optional = |value: Option<f64>| value.map_or_else(String::new, |x| x.to_string());
            let mut record = vec![
                sample.iteration.to_string(),
                sample.seconds.to_string(),
                sample.energy.to_string(),
                sample.dual_bound.to_string(),
                sample.gap.to_string(),
                sample.relative_gap.to_string(),
                optional(sample.change),
            ];
            record.extend(smoothed.then(|| optional(sample.smoothed_energy)));
            let certificate = sample.certificate.map_or("", Certificate::name);
            record.extend(certified.then(|| certificate.to_owned()));
            csv.write_record(&record)?;
        }
        csv.flush()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contour::Cells;
    use crate::operator::Mass;
    use crate::run::Stop;
    use crate::samples::{random_rows, rng, shape};
    use crate::solve::{Request, solve};
    use crate::start::Start;
    use std::ops::ControlFlow;

    /// The picture and the field of an earlier run are removed if the last run made none; other files stay.
    #[test]
    fn a_folder_holds_the_results_of_the_last_run() {
        let mesh = shape("torus:12x8");
        let s = crate::regions::array(&random_rows::<2>(mesh.vertices.len(), &mut rng(891)), 2);
        let solution = |keep_dual: bool| {
            let request = Request {
                lambda: 0.02,
                relaxation: Default::default(),
                mass: Mass::Barycentric,
                method: crate::solver::Method::default(),
                stop: Stop { iterations: Some(3), ..Stop::default() },
                coarse_to_fine: false,
                keep_dual,
                rounding: Default::default(),
                label_gap: None,
            };
            solve(&mesh, &s, &Start::Argmin, &request, &mut |_| ControlFlow::Continue(())).unwrap()
        };
        let looks = |draw: bool| {
            let region = |color| Region { color, mean: None, text: "region".into() };
            Looks {
                regions: vec![region([0.2; 3]), region([0.8; 3])],
                names: vec!["a".into(), "b".into()],
                data: draw.then(|| PicturedData {
                    colors: vec![[0.5; 3]; mesh.vertices.len()],
                    caption: "data".into(),
                    view: "front".parse().unwrap(),
                }),
                views: draw.then(|| RgbImage::new(4, 3)),
            }
        };
        let temporary = tempfile::tempdir().unwrap();
        let folder = temporary.path().join("out");
        let runs = [(true, true), (true, false), (false, true), (true, true), (false, false)];
        for (keep_dual, draw) in runs {
            let solution = solution(keep_dual);
            let cells = Cells::new(&mesh, solution.u.view(), solution.summary.cut_threshold);
            let contours = keep_dual.then(|| cells.contours());
            let looks = looks(draw);
            let exports: &[Export] = if draw { &[Export::Json, Export::Vtp] } else { &[] };
            let labeled = (&solution).into();
            write(&folder, &keep_dual, labeled, &mesh, &looks, contours.as_ref(), exports).unwrap();
            std::fs::write(folder.join("notes.txt"), "mine").unwrap();
            let mut names: Vec<String> = std::fs::read_dir(&folder)
                .unwrap()
                .map(|entry| entry.unwrap().file_name().into_string().unwrap())
                .collect();
            names.sort();
            let mut expected = vec![
                "labels.npy",
                "notes.txt",
                "segmented.ply",
                "summary.json",
                "trace.csv",
                "u.npy",
            ];
            expected.extend(keep_dual.then_some(["q.npy", "contours.obj"]).into_iter().flatten());
            expected.extend(draw.then_some(["labels.json", "segmented.vtp"]).into_iter().flatten());
            expected.extend(draw.then_some("preview.png"));
            expected.extend(draw.then_some("views.png"));
            expected.sort_unstable();
            assert_eq!(names, expected, "{keep_dual}, {draw}");
        }
        // A file that cannot be removed is an error.
        std::fs::create_dir(folder.join("q.npy")).unwrap();
        let solution = solution(false);
        let error =
            write(&folder, &0, (&solution).into(), &mesh, &looks(false), None, &[]).unwrap_err();
        assert!(error.to_string().contains("q.npy"), "{error}");
    }
}
