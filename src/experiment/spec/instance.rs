//! `[[instance]]`: a problem to be solved.

use std::ops::Range;
use std::path::Path;

use super::super::choice::DataChoice;
use super::super::document::{Scalar, Section, SpanError, SpanResult, Spanned};
use super::super::grid::{Group, Keys};
use super::super::nearest::did_you_mean;
use super::super::photographs::{self, Pattern, Photography, Sampling};
use super::cell::{Cell, label_of};
use crate::data::ModelName;
use crate::data::projection::Projection;
use crate::data::views::MaskRule;
use crate::domain::Element;
use crate::evolve::shots::Behind;
use crate::mesh::curvature::CurvatureKind;
use crate::mesh::{Normalize, Shape, Source};
use crate::names::Named;
use crate::operator::Mass;
use crate::regions;
use crate::relaxation::Relaxation;
use crate::triple::Triple;

/// A problem to be solved.
#[derive(Clone, Debug)]
pub struct InstanceCell {
    /// Its name in figures, tables and messages.
    pub label: String,
    pub(crate) keys: Keys,
    /// The mesh, named as the argument MESH, see [`Source::parse`]; `None` if it is unknown, and to be reconstructed from
    /// views.
    pub mesh: Option<String>,
    pub(crate) data: DataChoice,
    /// What is labeled, and has a row of costs or probabilities: vertices or faces.
    pub on: Element,
    /// How photographs are made and read, if the data are photographs; which pixels count, if they are views.
    pub(crate) photography: Photography,
    /// What is behind the surface in photographs or views.
    pub(crate) background: Option<Behind>,
    /// How masks of views are made.
    pub(crate) mask: Option<MaskRule>,
    /// The folder of the images of views.
    pub(crate) images: Option<String>,
    /// Standard deviation of the normal noise that is added to every entry of the data; 0 for none.
    pub noise: f64,
    /// The seed of the noise and of k-means.
    pub seed: u64,
    /// The data model.
    pub model: ModelName,
    /// How an image is projected onto the mesh.
    pub(crate) project: Option<Projection>,
    /// Labels that are right: a `.npy` file of V or F integers, or a `.mat` file of human segmentations.
    pub(crate) truth: Option<String>,
    /// m, from 2 to 64, or 1 for a reconstruction; 0 if the number of columns of a file of costs or probabilities determines it.
    pub regions: usize,
    pub(crate) lambda: LambdaChoice,
    /// The relaxation of the problem.
    pub relaxation: Relaxation,
    /// The quadrature of the data term.
    pub mass: Mass,
    /// Whether the mesh is scaled to area 1.
    pub normalize: Normalize,
    /// The spans of its mesh and its data in the file.
    pub(crate) mesh_span: Range<usize>,
    pub(crate) data_span: Range<usize>,
}

impl InstanceCell {
    /// The name of the mesh. Panics if there is none, in which case only reconstructions run on the instance.
    pub fn mesh_name(&self) -> &str {
        self.mesh.as_deref().expect("the file was checked for this")
    }
}

/// The key `lambda` of an instance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LambdaChoice {
    Given(f64),
    /// A multiple of the lambda that `segment` chooses for these data: "auto", "0.5 auto".
    Auto(f64),
}

impl LambdaChoice {
    fn of(Spanned { value, span }: &Spanned<Scalar>, data: &DataChoice) -> SpanResult<Self> {
        let wrong = |message: &str| Err(SpanError::at(span, message));
        let valid = |x: f64| x >= 0.0 && x.is_finite();
        let factor = match value {
            Scalar::Text(text) => text.strip_suffix("auto").map(str::trim_end),
            _ => None,
        };
        match (value.number(), factor) {
            (Some(lambda), _) if valid(lambda) => Ok(LambdaChoice::Given(lambda)),
            (_, Some(_)) if matches!(data, DataChoice::Costs(_)) => {
                wrong("lambda = \"auto\" needs data, but these are costs: give a number")
            }
            (_, Some("")) => Ok(LambdaChoice::Auto(1.0)),
            (_, Some(factor)) => match factor.parse() {
                Ok(factor) if valid(factor) => Ok(LambdaChoice::Auto(factor)),
                _ => wrong("the factor of lambda must be a number, 0 or more, as in \"0.5 auto\""),
            },
            _ => wrong(
                "lambda must be a number, 0 or more, \"auto\", or a multiple such as \"0.5 auto\"",
            ),
        }
    }
}

pub(super) fn read_instances(
    mut section: Section<'_>,
    folder: &Path,
) -> SpanResult<Vec<InstanceCell>> {
    let label = section.text("label")?.map(|label| label.value);
    let mut group = Group { keys: Vec::new(), zip: Vec::new() };
    let first = ["mesh", "data", "on", "model", "project"];
    let last = ["truth", "noise", "seed", "regions", "lambda", "relaxation", "mass", "normalize"];
    for key in
        first.into_iter().chain(OF_VIEWS).chain(["background"]).chain(photographs::KEYS).chain(last)
    {
        match section.list(key)? {
            Some(values) => group.keys.push((key.to_owned(), values)),
            None if ["data", "lambda"].contains(&key) => {
                return Err(SpanError::at(&section.span, format!("{} needs {key}", section.name)));
            }
            None => {}
        }
    }
    group.zipped(&mut section)?;
    let table = section.span.clone();
    section.end()?;
    let cells = group.cells(&table)?;
    let read = |cell| read_cell(&Cell(cell), &group, label.as_deref(), folder, &table);
    cells.iter().map(|cell| read(cell)).collect()
}

fn read_cell(
    cell: &Cell<'_>,
    group: &Group,
    label: Option<&str>,
    folder: &Path,
    table: &Range<usize>,
) -> SpanResult<InstanceCell> {
    let mesh = cell.text("mesh")?;
    if let Some((mesh, span)) = mesh
        && !mesh.starts_with("data:")
        && !folder.join(mesh).exists()
    {
        Source::parse(mesh).map_err(|error| SpanError::at(span, error.to_string()))?;
    }
    let (data, data_span) = cell.text("data")?.expect("it is needed");
    let data: DataChoice = data.parse().map_err(|message: String| {
        let known = ["waves", "classes", "own", "colors", "curvature"].map(str::to_owned);
        let curvatures = CurvatureKind::names().iter().map(|kind| format!("curvature:{kind}"));
        let known: Vec<String> = known.into_iter().chain(curvatures).collect();
        let known = known.iter().map(String::as_str);
        SpanError::at(data_span, message + &did_you_mean(data, known))
    })?;
    if mesh.is_none() && !data.is_views() {
        return Err(SpanError::at(table, "[[instance]] needs mesh"));
    }
    let lambda = LambdaChoice::of(cell.get("lambda").expect("it is needed"), &data)?;
    let on = read_element(cell, &data)?;
    let regions = region_count(cell, mesh.map(|(mesh, _)| mesh), &data, data_span)?;
    check_keys(cell, &data)?;
    let background = read_background(cell, &data)?;
    Ok(InstanceCell {
        photography: read_photography(cell, background)?,
        background,
        mask: read_mask(cell)?,
        images: cell.text("images")?.map(|(folder, _)| folder.to_owned()),
        label: label_of(
            label,
            plain_label(cell, group, mesh.map(|(mesh, _)| mesh), &data, regions),
            cell,
            group,
        ),
        keys: cell.keys(),
        mesh: mesh.map(|(mesh, _)| mesh.to_owned()),
        on,
        model: read_model(cell, &data)?,
        noise: read_noise(cell, &data)?,
        data,
        project: read_projection(cell)?,
        truth: read_truth(cell)?,
        seed: cell.count("seed", 0, 0..=u64::MAX)?,
        regions,
        lambda,
        relaxation: cell.named("relaxation", on.relaxation())?,
        mass: cell.named("mass", Mass::Barycentric)?,
        normalize: cell.named("normalize", Normalize::Area)?,
        mesh_span: mesh.map_or(data_span, |(_, span)| span).clone(),
        data_span: data_span.clone(),
    })
}

/// What is labeled.
fn read_element(cell: &Cell<'_>, data: &DataChoice) -> SpanResult<Element> {
    let of_classes = matches!(data, DataChoice::Classes);
    let on = cell.named("on", if of_classes { Element::Faces } else { Element::Vertices })?;
    let refused = |key: &str, message: &str| match cell.get(key) {
        Some(given) => Err(SpanError::at(&given.span, message)),
        None => Ok(()),
    };
    match on {
        Element::Vertices if of_classes => {
            refused("on", "\"classes\" are probabilities of faces: leave on out")?;
        }
        Element::Faces if !data.is_costs() => refused(
            "on",
            "labels of faces need data = \"classes\", \"probabilities:FILE.npy\" or \"costs:FILE.npy\"",
        )?,
        Element::Faces => refused("mass", "faces count with their areas: leave mass out")?,
        Element::Vertices => {}
    }
    Ok(on)
}

fn read_noise(cell: &Cell<'_>, data: &DataChoice) -> SpanResult<f64> {
    let noise = cell.number("noise", 0.0, 0.0)?;
    match (data, cell.get("noise")) {
        (DataChoice::Classes, given) if noise == 0.0 => {
            let span = given.map_or_else(
                || cell.get("data").expect("it is needed").span.clone(),
                |given| given.span.clone(),
            );
            Err(SpanError::at(&span, "\"classes\" need noise above 0, such as noise = 0.6"))
        }
        (DataChoice::Costs(_) | DataChoice::Probabilities(_), Some(given)) => {
            let message = format!("{} are taken as they are: leave noise out", data.noun());
            Err(SpanError::at(&given.span, message))
        }
        _ => Ok(noise),
    }
}

fn read_model(cell: &Cell<'_>, data: &DataChoice) -> SpanResult<ModelName> {
    if let (Some(given), true) = (cell.get("model"), data.is_costs()) {
        let message = format!("{} need no model: leave model out", data.noun());
        return Err(SpanError::at(&given.span, message));
    }
    cell.named("model", ModelName::default())
}

fn read_projection(cell: &Cell<'_>) -> SpanResult<Option<Projection>> {
    let Some((text, span)) = cell.text("project")? else { return Ok(None) };
    let projection =
        text.parse().map_err(|message: String| SpanError::at(span, format!("project {message}")));
    projection.map(Some)
}

/// The keys of views alone.
const OF_VIEWS: [&str; 2] = ["images", "mask"];

/// The keys of photographs that views have too.
const OF_BOTH: [&str; 3] = ["pure", "grazing", "background"];

/// Refuses keys that do not apply to the data.
fn check_keys(cell: &Cell<'_>, data: &DataChoice) -> SpanResult<()> {
    let is_views = data.is_views();
    let is_photographs = matches!(data, DataChoice::Photographs(_));
    for key in photographs::KEYS.into_iter().chain(OF_VIEWS).chain(["background"]) {
        let Some(given) = cell.get(key) else { continue };
        let (applies, needed) = if OF_VIEWS.contains(&key) {
            (is_views, "\"views:FILE\"")
        } else if OF_BOTH.contains(&key) {
            (is_views || is_photographs, "\"photographs:N:WxH\" or \"views:FILE\"")
        } else {
            (is_photographs, "\"photographs:N:WxH\"")
        };
        if !applies {
            return Err(SpanError::at(&given.span, format!("{key} needs data = {needed}")));
        }
    }
    let refused = [
        ("noise", "the images of views have noise of their own: leave noise out"),
        ("mass", "views are integrated over their pixels: leave mass out"),
        ("project", "views are projected by their cameras: leave project out"),
    ];
    if let (true, Some(given)) = (data.is_costs(), cell.get("project")) {
        let message = format!("{} are not projected: leave project out", data.noun());
        return Err(SpanError::at(&given.span, message));
    }
    match refused.into_iter().find_map(|(key, message)| Some((cell.get(key)?, message))) {
        Some((given, message)) if is_views => Err(SpanError::at(&given.span, message)),
        _ => Ok(()),
    }
}

/// What is behind the surface: for photographs a color.
fn read_background(cell: &Cell<'_>, data: &DataChoice) -> SpanResult<Option<Behind>> {
    let Some((text, span)) = cell.text("background")? else { return Ok(None) };
    let behind: Behind =
        text.parse().map_err(|message| SpanError::at(span, format!("background {message}")))?;
    match behind {
        Behind::Images | Behind::Masks if !data.is_views() => Err(SpanError::at(
            span,
            "photographs are taken in front of a color: background must be three numbers from 0 to 1, such as \"0.9,0.9,0.9\"",
        )),
        behind => Ok(Some(behind)),
    }
}

/// How masks of views are made.
fn read_mask(cell: &Cell<'_>) -> SpanResult<Option<MaskRule>> {
    let Some((text, span)) = cell.text("mask")? else { return Ok(None) };
    let rule = text.parse().map_err(|message| SpanError::at(span, format!("mask {message}")));
    rule.map(Some)
}

/// The keys that photographs have.
fn read_photography(cell: &Cell<'_>, background: Option<Behind>) -> SpanResult<Photography> {
    let light = match cell.text("light")? {
        None => None,
        Some((text, span)) => match text.parse() {
            Ok(Triple(light))
                if light.iter().all(|x| x.is_finite()) && light.iter().any(|&x| x != 0.0) =>
            {
                Some(light)
            }
            _ => {
                let message =
                    "light must be a direction of three numbers, not all 0, as in \"1,0,2\"";
                return Err(SpanError::at(span, message));
            }
        },
    };
    if let (None, Some(given)) = (light, cell.get("ambient")) {
        let message = "ambient needs light: without one the colors stay as they are";
        return Err(SpanError::at(&given.span, message));
    }
    let sampling = cell.named("sampling", Sampling::default())?;
    if let (Sampling::Vertices, Some((key, given))) =
        (sampling, ["pure", "grazing"].iter().find_map(|key| Some((key, cell.get(key)?))))
    {
        return Err(SpanError::at(&given.span, format!("{key} needs sampling = \"pixels\"")));
    }
    let grazing = cell.number("grazing", 0.0, 0.0)?;
    if let Some(given) = cell.get("grazing").filter(|_| grazing >= 1.0) {
        return Err(SpanError::at(&given.span, "grazing must be a cosine, below 1"));
    }
    Ok(Photography {
        pattern: cell.named("pattern", Pattern::default())?,
        background: match background {
            Some(Behind::Color(color)) => color,
            _ => photographs::BACKGROUND,
        },
        light,
        ambient: cell.number("ambient", 0.0, 0.0)?,
        principal_error: cell.number("principal-error", 0.0, 0.0)?,
        sampling,
        pure: cell.count("pure", 1, 1..=255)? as usize,
        grazing,
    })
}

fn read_truth(cell: &Cell<'_>) -> SpanResult<Option<String>> {
    let Some((text, span)) = cell.text("truth")? else { return Ok(None) };
    if !(text.ends_with(".npy") || text.ends_with(".mat")) {
        return Err(SpanError::at(span, "truth must be \"FILE.npy\" or \"FILE.mat\""));
    }
    Ok(Some(text.to_owned()))
}

/// The number of regions; 0 for costs and probabilities of files, which determine their own.
fn region_count(
    cell: &Cell<'_>,
    mesh: Option<&str>,
    data: &DataChoice,
    data_span: &Range<usize>,
) -> SpanResult<usize> {
    let shape = mesh.and_then(|mesh| mesh.parse::<Shape>().ok());
    let parts = shape.and_then(Shape::parts).filter(|_| matches!(data, DataChoice::Classes));
    match (cell.get("regions"), data, parts) {
        (Some(given), DataChoice::Costs(_) | DataChoice::Probabilities(_), _) => {
            let message = format!("{} have one column per region: leave regions out", data.noun());
            Err(SpanError::at(&given.span, message))
        }
        (None, DataChoice::Costs(_) | DataChoice::Probabilities(_), _) => Ok(0),
        (Some(given), _, Some(parts)) => {
            let message = format!("the surface has {parts} parts of its own: leave regions out");
            Err(SpanError::at(&given.span, message))
        }
        (None, _, Some(parts)) => Ok(parts),
        (None, ..) => Err(SpanError::at(data_span, "these data need the key regions")),
        (Some(_), ..) => {
            let least = match data.is_views() || matches!(data, DataChoice::Photographs(_)) {
                // One region can be reconstructed.
                true => 1,
                false => *regions::REGIONS.start() as u64,
            };
            let range = least..=*regions::REGIONS.end() as u64;
            Ok(cell.count("regions", 0, range)? as usize)
        }
    }
}

/// The label of an instance without a given one.
fn plain_label(
    cell: &Cell<'_>,
    group: &Group,
    mesh: Option<&str>,
    data: &DataChoice,
    regions: usize,
) -> String {
    let text = |key: &str| cell.get(key).map(|value| value.value.text());
    let mesh = mesh.map_or(String::new(), |mesh| format!("{mesh}, "));
    let regions = if regions > 0 { format!(", {regions} regions") } else { String::new() };
    let lambda = text("lambda").expect("it is needed");
    let given = |key: &str| text(key).map_or(String::new(), |name| format!(", {name}"));
    let (relaxation, mass) = (given("relaxation"), given("mass"));
    let varied = ["on", "model", "project", "images", "mask", "background"].into_iter();
    let varied = varied.chain(photographs::KEYS).chain(["noise", "seed"]);
    let varied = varied.filter(|key| group.varies(key));
    let varied = varied.map(|key| format!(", {key} {}", text(key).expect("it varies")));
    format!(
        "{mesh}{data}{regions}, lambda {lambda}{relaxation}{mass}{}",
        varied.collect::<String>()
    )
}
