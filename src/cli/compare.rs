//! `meshseg compare`: the agreement of labels with others, or with human segmentations.

mod labels;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::agreement::{Agreement, Boundaries, Boundary, MeanAgreement, boundaries, grid_image};
use crate::counted::counted;
use crate::data::humans;
use crate::domain::Element;
use crate::mesh::dual::face_areas;
use crate::mesh::geometry::barycentric_areas;
use crate::mesh::{Mesh, Shape, Source};
use crate::{Error, Result};

use super::{Outcome, print, print_json, table, warn};
use labels::Labels;

/// Compare labels with those of another segmentation or of humans, whatever the regions are called.
///
/// The table has the share of correct labels under the best matching of regions, the Rand index and the Rand index
/// adjusted for chance, the variation of information in bits, the covering of TRUTH, and precision, recall and F of the
/// boundaries, where the labels form an image. Vertices with a negative label are unknown and left out.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  meshseg compare results/spot results/other --mesh builtin:spot
  meshseg segment grid:480x320 --data image:horses.jpg --regions 3 --out results/horses
  meshseg compare results/horses horses.mat --mesh grid:480x320

A .mat file of the Berkeley data set (BSDS500) has the segmentations of several humans. They lie on the mesh as \
the image does with --data image:IMAGE on a grid.")]
pub struct Arguments {
    /// Labels of the vertices or of the faces: a .npy file of integers, or a result folder
    labels: PathBuf,

    /// The labels to compare with: a .npy file, a result folder, or a .mat file of human segmentations
    truth: PathBuf,

    /// The mesh of the labels: vertices, or faces, count with their areas [default: all count the same]
    #[arg(long, value_name = "MESH")]
    mesh: Option<PathBuf>,

    /// The labels are an image, row by row from the top; a grid such as --mesh grid:480x320 has a size of its own
    #[arg(long, value_name = "WxH", value_parser = image_size)]
    image_size: Option<[usize; 2]>,

    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// The scores against one truth.
#[derive(Serialize)]
struct Row {
    #[serde(flatten)]
    agreement: Agreement,
    boundary: Option<Boundary>,
}

/// The scores against all truths.
#[derive(Serialize)]
struct Comparison {
    labels: String,
    truth: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    vertices: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    faces: Option<usize>,
    /// `area` or `equal`.
    weights: &'static str,
    /// In pixels; where the labels form an image.
    boundary_tolerance: Option<f64>,
    /// One per truth.
    each: Vec<Row>,
    mean: MeanAgreement,
    /// The boundaries of all truths together.
    boundary: Option<Boundary>,
    warnings: Vec<String>,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let mut found = labels::read(&arguments.labels)?;
    let (labels, place, truths) = if arguments.truth.extension() == Some(OsStr::new("mat")) {
        found.retain(|labels| labels.on != Some(Element::Faces));
        let labels = found.swap_remove(0);
        let place = Place::read(arguments, &labels)?;
        let truths = humans(&arguments.truth, &place)?;
        (labels.labels, place, truths)
    } else {
        let [labels, truth] = labels::pair(found, labels::read(&arguments.truth)?);
        let place = Place::read(arguments, &labels)?;
        (labels.labels, place, vec![truth.labels])
    };
    if let Some(truth) = truths.iter().find(|truth| truth.len() != labels.len()) {
        let message = format!(
            "has {}, but {} has {}; both must label the same vertices or faces",
            counted(truth.len(), "label", "labels"),
            arguments.labels.display(),
            labels.len()
        );
        return Err(Error::malformed(&arguments.truth, message).into());
    }
    let comparison = compared(arguments, &labels, &truths, &place)?;
    if arguments.json {
        print_json(&comparison)?;
    } else {
        print(&text(&comparison))?;
    }
    warn(&comparison.warnings);
    Ok(())
}

/// Parses WxH.
fn image_size(text: &str) -> std::result::Result<[usize; 2], String> {
    let size = text.split_once('x').and_then(|(width, height)| {
        let side = |text: &str| text.parse::<u32>().ok().filter(|&side| side > 0);
        Some([side(width)? as usize, side(height)? as usize])
    });
    size.ok_or_else(|| "must be width and height in pixels, such as 481x321".into())
}

/// Where the labels are: on a mesh, in an image, both or neither.
struct Place {
    mesh: Option<Mesh>,
    on: Element,
    /// Width and height.
    image: Option<[usize; 2]>,
    /// Whether the image consists of the vertices of a grid.
    is_grid: bool,
}

impl Place {
    /// Reads the mesh. It must have as many vertices or faces as there are labels, and the image as many pixels.
    fn read(arguments: &Arguments, Labels { labels, on }: &Labels) -> Result<Self> {
        let labels = labels.len();
        let source = arguments.mesh.as_ref().map(Source::parse).transpose()?;
        let mesh = source.as_ref().map(Source::mesh).transpose()?;
        let mismatch = |message: String| Error::malformed(&arguments.labels, message);
        let found = counted(labels, "label", "labels");
        let elements = on.map_or_else(|| vec![Element::Vertices, Element::Faces], |on| vec![on]);
        let on = match &mesh {
            None => Some(elements[0]),
            Some(mesh) => elements.into_iter().find(|on| on.count(mesh) == labels),
        };
        let Some(on) = on else {
            let (source, mesh) = source.as_ref().zip(mesh.as_ref()).expect("there is a mesh");
            let vertices = counted(mesh.vertices.len(), "vertex", "vertices");
            let faces = counted(mesh.faces.len(), "face", "faces");
            return Err(mismatch(format!("has {found}, but {source} has {vertices} and {faces}")));
        };
        let grid = match source {
            Some(Source::Shape(Shape::Grid { nx, ny })) if on == Element::Vertices => {
                Some([nx as usize + 1, ny as usize + 1])
            }
            _ => None,
        };
        let image = match (grid, arguments.image_size) {
            (Some(grid), Some(size)) if grid != size => {
                return Err(Error::unsuitable(format!(
                    "the grid has {} x {} vertices, which is not --image-size; leave that out",
                    grid[0], grid[1]
                )));
            }
            (grid, size) => grid.or(size),
        };
        if let Some([width, height]) = image
            && width.checked_mul(height) != Some(labels)
        {
            return Err(mismatch(format!(
                "has {found}, but an image of {width} x {height} pixels has {}",
                width.saturating_mul(height)
            )));
        }
        Ok(Place { mesh, on, image, is_grid: grid.is_some() })
    }

    /// The scores of the boundaries, if the labels form an image.
    fn boundaries(&self, labels: &[i64], truths: &[Vec<i64>]) -> Result<Option<Boundaries>> {
        let Some(size) = self.image else { return Ok(None) };
        let image = |labels: &[i64]| match self.is_grid {
            true => grid_image(labels, size[0]),
            false => labels.to_vec(),
        };
        let truths: Vec<Vec<i64>> = truths.iter().map(|truth| image(truth)).collect();
        let slices: Vec<&[i64]> = truths.iter().map(Vec::as_slice).collect();
        boundaries(&image(labels), &slices, size).map(Some)
    }

    fn weights(&self, labels: usize) -> Vec<f64> {
        match (&self.mesh, self.on) {
            (None, _) => vec![1.0; labels],
            (Some(mesh), Element::Vertices) => barycentric_areas(mesh),
            (Some(mesh), Element::Faces) => face_areas(mesh),
        }
    }
}

/// Reads human segmentations.
fn humans(path: &Path, place: &Place) -> Result<Vec<Vec<i64>>> {
    if let Some(mesh) = &place.mesh {
        return humans::on_mesh(mesh, path);
    }
    let Some([width, height]) = place.image else {
        let message = "is compared with labels on a grid or of pixels; add --mesh such as grid:480x320, or --image-size";
        return Err(Error::malformed(path, message));
    };
    let humans = humans::read(path)?;
    let (rows, columns) = humans[0].dim();
    if [columns, rows] != [width, height] {
        let message = format!("has images of {columns} x {rows} pixels, not {width} x {height}");
        return Err(Error::malformed(path, message));
    }
    Ok(humans.iter().map(|human| human.iter().map(|&label| label.into()).collect()).collect())
}

fn compared(
    arguments: &Arguments,
    labels: &[i64],
    truths: &[Vec<i64>],
    place: &Place,
) -> Result<Comparison> {
    let weights = place.weights(labels.len());
    let agreement = |truth: &Vec<i64>| Agreement::new(labels, truth, &weights);
    let agreements = truths.iter().map(agreement).collect::<Result<Vec<_>>>();
    let names = format!("{} and {}", arguments.labels.display(), arguments.truth.display());
    let agreements = agreements.map_err(|error| error.of_file(Path::new(&names)))?;
    let mut warnings: Vec<String> = degenerate(&agreements).into_iter().collect();
    let found = match place.boundaries(labels, truths) {
        Ok(found) => found,
        Err(error) => {
            warnings.push(format!("boundaries are not compared: {error}"));
            None
        }
    };
    let of_truth = |i: usize| found.as_ref().map(|found: &Boundaries| found.each[i]);
    let mean = MeanAgreement::of(&agreements);
    let row = |(i, agreement)| Row { agreement, boundary: of_truth(i) };
    Ok(Comparison {
        labels: arguments.labels.display().to_string(),
        truth: arguments.truth.display().to_string(),
        vertices: (place.on == Element::Vertices).then_some(labels.len()),
        faces: (place.on == Element::Faces).then_some(labels.len()),
        weights: if place.mesh.is_some() { "area" } else { "equal" },
        boundary_tolerance: found.as_ref().map(|found| found.tolerance),
        each: agreements.into_iter().enumerate().map(row).collect(),
        mean,
        boundary: found.as_ref().map(|found| found.all),
        warnings,
    })
}

/// A warning if the labels have a single region.
fn degenerate(agreements: &[Agreement]) -> Option<String> {
    let single = agreements.iter().all(|it| it.regions == 1);
    single.then(|| "all labels are equal; segment with more regions or a smaller --lambda".into())
}

/// The table, and how it counts.
fn text(comparison: &Comparison) -> String {
    let Comparison { each, mean, boundary, .. } = comparison;
    let mut header = vec!["", "regions", "accuracy", "Rand", "adjusted", "VI (bits)", "covering"];
    if boundary.is_some() {
        header.extend(["precision", "recall", "F"]);
    }
    let cells = |name: String, regions: String, scores: [f64; 5], boundary: Option<Boundary>| {
        let edges = boundary.map(|it| [it.precision, it.recall, it.f]);
        let numbers = scores.into_iter().chain(edges.into_iter().flatten());
        let numbers = numbers.map(|x| format!("{x:.4}"));
        [name, regions].into_iter().chain(numbers).collect::<Vec<_>>()
    };
    let mut rows = vec![header.into_iter().map(String::from).collect()];
    for (i, Row { agreement: it, boundary }) in each.iter().enumerate() {
        let name = if each.len() == 1 { "truth".into() } else { format!("human {}", i + 1) };
        let scores = [
            it.accuracy,
            it.rand_index,
            it.adjusted_rand_index,
            it.variation_of_information,
            it.covering,
        ];
        rows.push(cells(name, it.truth_regions.to_string(), scores, *boundary));
    }
    if each.len() > 1 {
        let scores = [
            mean.accuracy,
            mean.rand_index,
            mean.adjusted_rand_index,
            mean.variation_of_information,
            mean.covering,
        ];
        rows.push(cells("all humans".into(), String::new(), scores, *boundary));
    }
    format!("{}\n{}", counts(comparison), table::columns(&rows))
}

/// What was compared, as a sentence.
fn counts(comparison: &Comparison) -> String {
    let Comparison { each, vertices, faces, weights, boundary_tolerance, .. } = comparison;
    let numbers = |of: fn(&Agreement) -> usize| {
        let (least, most) = each.iter().fold((usize::MAX, 0), |(least, most), row| {
            let n = of(&row.agreement);
            (least.min(n), most.max(n))
        });
        if least == most { most.to_string() } else { format!("{least} to {most}") }
    };
    let unknown = match numbers(|it| it.unknown) {
        none if none == "0" => String::new(),
        some => format!(", {some} of them unknown and left out"),
    };
    let tolerance = boundary_tolerance
        .map_or(String::new(), |it| format!("; boundaries match within {it:.2} pixels"));
    let weights = match *weights {
        "area" => "weighted by their areas",
        _ => "each with the same weight",
    };
    let regions = numbers(|it| it.regions);
    let noun = if regions == "1" { "region" } else { "regions" };
    let labeled = match (vertices, faces) {
        (Some(vertices), _) => format!("{vertices} vertices"),
        (None, faces) => format!("{} faces", faces.unwrap_or_default()),
    };
    format!("{regions} {noun} on {labeled}{unknown}, {weights}{tolerance}\n")
}
