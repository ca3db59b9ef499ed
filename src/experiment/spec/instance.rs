//! `[[instance]]`: what is to be segmented.

use std::ops::Range;
use std::path::Path;

use super::super::choice::DataChoice;
use super::super::document::{Fits, Scalar, Section, Spanned, Wrong};
use super::super::grid::{Group, Keys};
use super::super::nearest::did_you_mean;
use super::cell::{Cell, label_of};
use crate::mesh::{Normalize, Source};
use crate::operator::Mass;
use crate::regions;

/// What is to be segmented.
#[derive(Clone, Debug)]
pub struct InstanceCell {
    /// Its name in figures, tables and messages.
    pub label: String,
    pub(crate) keys: Keys,
    /// What the argument MESH names, see [`Source::parse`].
    pub mesh: String,
    pub(crate) data: DataChoice,
    /// Standard deviation of the normal noise that is added to every entry of the data; 0 for none.
    pub noise: f64,
    /// Of the noise and of k-means.
    pub seed: u64,
    /// m, from 2 to 64; 0 where a file of costs tells it.
    pub regions: usize,
    pub(crate) lambda: LambdaChoice,
    /// The quadrature of the data term.
    pub mass: Mass,
    /// Whether the mesh is scaled to area 1.
    pub normalize: Normalize,
    /// Where its mesh and its data stand in the file.
    pub(crate) mesh_span: Range<usize>,
    pub(crate) data_span: Range<usize>,
}

/// The key `lambda` of an instance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LambdaChoice {
    Given(f64),
    /// A multiple of what `segment` takes for these data: "auto", "0.5 auto".
    Auto(f64),
}

impl LambdaChoice {
    fn of(Spanned { value, span }: &Spanned<Scalar>, data: &DataChoice) -> Fits<Self> {
        let wrong = |message: &str| Err(Wrong::at(span, message));
        let valid = |x: f64| x >= 0.0 && x.is_finite();
        let factor = match value {
            Scalar::Text(text) => text.strip_suffix("auto").map(str::trim_end),
            _ => None,
        };
        match (value.number(), factor) {
            (Some(lambda), _) if valid(lambda) => Ok(LambdaChoice::Given(lambda)),
            (_, Some(_)) if matches!(data, DataChoice::Costs(_)) => {
                wrong("lambda is chosen for data, and these are costs: give a number")
            }
            (_, Some("")) => Ok(LambdaChoice::Auto(1.0)),
            (_, Some(factor)) => match factor.parse() {
                Ok(factor) if valid(factor) => Ok(LambdaChoice::Auto(factor)),
                _ => wrong("lambda before \"auto\" needs a number from 0, as in \"0.5 auto\""),
            },
            _ => wrong(
                "lambda must be a number from 0, \"auto\", or a multiple such as \"0.5 auto\"",
            ),
        }
    }
}

pub(super) fn read_instances(mut section: Section<'_>, folder: &Path) -> Fits<Vec<InstanceCell>> {
    let label = section.text("label")?.map(|label| label.value);
    let mut group = Group { keys: Vec::new(), zip: Vec::new() };
    for key in ["mesh", "data", "noise", "seed", "regions", "lambda", "mass", "normalize"] {
        match section.list(key)? {
            Some(values) => group.keys.push((key.to_owned(), values)),
            None if ["mesh", "data", "lambda"].contains(&key) => {
                return Err(Wrong::at(&section.span, format!("{} needs {key}", section.name)));
            }
            None => {}
        }
    }
    group.zipped(&mut section)?;
    let table = section.span.clone();
    section.end()?;
    let cells = group.cells(&table)?;
    cells.iter().map(|cell| read_cell(&Cell(cell), &group, label.as_deref(), folder)).collect()
}

fn read_cell(
    cell: &Cell<'_>,
    group: &Group,
    label: Option<&str>,
    folder: &Path,
) -> Fits<InstanceCell> {
    let (mesh, mesh_span) = cell.text("mesh")?.expect("it is needed");
    if !mesh.starts_with("data:") && !folder.join(mesh).exists() {
        Source::parse(mesh).map_err(|error| Wrong::at(mesh_span, error.to_string()))?;
    }
    let (data, data_span) = cell.text("data")?.expect("it is needed");
    let data: DataChoice = data.parse().map_err(|message: String| {
        let known = ["waves", "own", "colors", "curvature"];
        Wrong::at(data_span, message + &did_you_mean(data, known))
    })?;
    let lambda = LambdaChoice::of(cell.get("lambda").expect("it is needed"), &data)?;
    let regions = region_count(cell, &data, data_span)?;
    Ok(InstanceCell {
        label: label_of(label, plain_label(cell, group, mesh, &data, regions), cell, group),
        keys: cell.keys(),
        mesh: mesh.to_owned(),
        data,
        noise: cell.number("noise", 0.0, 0.0)?,
        seed: cell.count("seed", 0, 0..=u64::MAX)?,
        regions,
        lambda,
        mass: cell.named("mass", Mass::Barycentric)?,
        normalize: cell.named("normalize", Normalize::Area)?,
        mesh_span: mesh_span.clone(),
        data_span: data_span.clone(),
    })
}

/// Of costs, which have their own number of regions, 0.
fn region_count(cell: &Cell<'_>, data: &DataChoice, data_span: &Range<usize>) -> Fits<usize> {
    match (cell.get("regions"), data) {
        (Some(given), DataChoice::Costs(_)) => {
            let message = "costs have one column per region: leave regions out";
            Err(Wrong::at(&given.span, message))
        }
        (None, DataChoice::Costs(_)) => Ok(0),
        (None, _) => Err(Wrong::at(data_span, "regions is needed beside this data")),
        (Some(_), _) => {
            let range = *regions::REGIONS.start() as u64..=*regions::REGIONS.end() as u64;
            Ok(cell.count("regions", 0, range)? as usize)
        }
    }
}

/// What an instance without a label of its own is called.
fn plain_label(
    cell: &Cell<'_>,
    group: &Group,
    mesh: &str,
    data: &DataChoice,
    regions: usize,
) -> String {
    let text = |key: &str| cell.get(key).map(|value| value.value.text());
    let regions = if regions > 0 { format!(", {regions} regions") } else { String::new() };
    let lambda = text("lambda").expect("it is needed");
    let mass = text("mass").map_or(String::new(), |mass| format!(", {mass}"));
    let varied = ["noise", "seed"].into_iter().filter(|key| group.varies(key));
    let varied = varied.map(|key| format!(", {key} {}", text(key).expect("it varies")));
    format!("{mesh}, {data}{regions}, lambda {lambda}{mass}{}", varied.collect::<String>())
}
