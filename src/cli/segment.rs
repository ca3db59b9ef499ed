//! `meshseg segment`: the data of a mesh into regions.

use std::path::PathBuf;

use meshseg::data::seen::{self, DataSource, Seen};
use meshseg::data::{Data, RegionParameters, looks};
use meshseg::mesh::Source;
use meshseg::mesh::geometry::barycentric_areas;
use meshseg::outcome::{self, Looks, Shown};
use meshseg::render;
use meshseg::render::colormap::categorical;
use meshseg::segment::{Alternation, Initial, Segmentation, segment};
use meshseg::solve::{Summary, check_mesh};
use meshseg::{Error, sweep};
use serde::Serialize;

use super::progress::Progress;
use super::solving::{Solving, exit, summary_lines};
use super::{Outcome, named, note, preview, print, table, warn};

/// Segment colors, a texture, curvature or other data on a mesh into regions.
///
/// Region parameters and labels are found in turn; the final labels are certified for the final parameters.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Mesh file, builtin:spot, or a shape such as torus:400x250
    mesh: PathBuf,

    /// colors (of the vertices, in [0,1]), texture:IMAGE (PNG or JPEG), curvature (mean curvature, its middle
    /// 96 % mapped to [0,1]), or FILE.npy (V or V x d numbers; uint8 is divided by 255) [default: the colors or
    /// texture that come with the mesh]
    #[arg(long, value_name = "DATA")]
    data: Option<DataSource>,

    /// Number of regions, 2 to 64
    #[arg(long, value_name = "M", value_parser = clap::value_parser!(u8).range(2..=64), allow_negative_numbers = true)]
    regions: u8,

    /// Model of the data in a region
    #[arg(long, value_parser = named(&Model::NAMES), default_value = "constant")]
    model: Model,

    /// Weight of the length of the cuts, in units of squared data times length [default: 0.02 times the variance
    /// of the data, times the square root of the area]
    #[arg(long, allow_negative_numbers = true)]
    lambda: Option<f64>,

    /// Iterations between re-estimations of the region parameters
    #[arg(long, value_name = "R", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..), allow_negative_numbers = true)]
    every: u64,

    /// Where the region parameters start
    #[arg(long, value_parser = named(&Initial::NAMES), default_value = "kmeans")]
    init: Initial,

    /// Seed of the start
    #[arg(long, default_value_t = 0, allow_negative_numbers = true)]
    seed: u64,

    /// area: scale the mesh to total area 1, so that lambda means the same for every mesh; none: keep its units
    #[arg(long, value_parser = named(&Normalize::NAMES), default_value = "area")]
    normalize: Normalize,

    #[command(flatten)]
    solving: Solving,
}

const EXAMPLES: &str = "\
Examples:
  meshseg segment builtin:spot --regions 3 --out results/spot
  meshseg segment person.ply --regions 4 --lambda 0.005 --out results/person
  meshseg segment bunny.ply --data curvature --regions 3 --out results/bunny
  meshseg segment model.obj --data texture:atlas.png --regions 5 --out results/model";

#[derive(Clone, Copy)]
enum Model {
    Constant,
}

impl Model {
    const NAMES: [(&'static str, Model); 1] = [("constant", Model::Constant)];

    fn name(self) -> &'static str {
        match self {
            Model::Constant => "constant",
        }
    }
}

#[derive(Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
enum Normalize {
    Area,
    None,
}

impl Normalize {
    const NAMES: [(&'static str, Normalize); 2] =
        [("area", Normalize::Area), ("none", Normalize::None)];
}

pub fn run(arguments: &Arguments) -> Outcome {
    sweep::with_threads(arguments.solving.threads(), || run_here(arguments))?
}

fn run_here(arguments: &Arguments) -> Outcome {
    let solving = &arguments.solving;
    let mut request = solving.request(arguments.lambda.unwrap_or(0.0))?;
    let source = Source::parse(&arguments.mesh)?;
    let mesh = source.mesh()?;
    let area = mesh.area();
    let scale = match arguments.normalize {
        Normalize::Area if area > 0.0 && area.is_finite() => 1.0 / area.sqrt(),
        Normalize::Area | Normalize::None => 1.0,
    };
    let scaled = mesh.clone().scaled(scale);
    check_mesh(&scaled).map_err(|error| error.of_file(&arguments.mesh))?;
    let seen = seen::see(&source, &scaled, arguments.data.as_ref())?;

    let cells = barycentric_areas(&scaled);
    if arguments.lambda.is_none() {
        request.lambda = default_lambda(&seen.data, &cells);
        if !request.lambda.is_finite() {
            let message = format!("{}: the data leave the range of double precision", seen.name);
            return Err(Error::unsuitable(message + " when squared; scale them down").into());
        }
    }

    let alternation = Alternation {
        regions: usize::from(arguments.regions),
        initial: arguments.init,
        seed: arguments.seed,
        every: arguments.every,
    };
    let mut progress = Progress::new(request.stop.relative_gap.unwrap_or(0.0));
    let mut observe = |sample: Option<&_>| progress.observe(sample);
    let segmentation = segment(&scaled, &seen.data, &alternation, &request, &mut observe)?;
    progress.finish();

    let regions = describe_regions(&segmentation, &seen, &cells);
    let solution = &segmentation.solution;
    let summary = SegmentSummary {
        summary: &solution.summary,
        data: &seen.name,
        data_unit_range: seen.unit_range,
        model: arguments.model.name(),
        init: arguments.init.name(),
        seed: arguments.seed,
        every: arguments.every,
        re_estimations: segmentation.estimates,
        normalize: arguments.normalize,
        scale,
        region_parameters: &regions,
    };
    let drawn = |(p, region): (usize, &Region)| render::Region {
        color: region.palette,
        mean: region.color,
        text: preview::legend(p, region.share, &region.parameters.mean),
    };
    let looks = Looks {
        regions: regions.iter().enumerate().map(drawn).collect(),
        data: (!solving.no_preview).then(|| Shown {
            colors: seen.looks.clone(),
            caption: looks::words(&seen.data, &seen.name, seen.unit_range, &cells),
            view: solving.view,
        }),
    };
    outcome::write(&solving.out, &summary, solution, &mesh, &looks)?;

    if scale != 1.0 {
        note(&format!(
            "scaled by {scale:.6e} to total area 1, which lambda refers to; --normalize none keeps the units"
        ));
    }
    warn(&solution.summary.warnings);
    let mut lines = summary_lines(&solution.summary);
    lines.push(("written to", solving.out.display().to_string()));
    let printed = print(&(table::pairs(&lines) + "\n" + &regions_table(&regions)));
    exit(solution.summary.status, printed)
}

/// Cuts weigh as much as a mistake of one standard deviation within a fiftieth of the mesh's length.
fn default_lambda(data: &Data, area: &[f64]) -> f64 {
    0.02 * data.variance(area) * area.iter().sum::<f64>().sqrt()
}

/// What is told of one region.
#[derive(Serialize)]
struct Region {
    #[serde(flatten)]
    parameters: RegionParameters,
    /// As which it is drawn.
    palette: [f64; 3],
    /// Mean of the shown colors over its vertices, if it has any.
    color: Option<[f64; 3]>,
    /// Of its share of the vertices' barycentric cells.
    area: f64,
    /// Of the whole area.
    share: f64,
}

#[derive(Serialize)]
struct SegmentSummary<'a> {
    #[serde(flatten)]
    summary: &'a Summary,
    data: &'a str,
    data_unit_range: Option<[f64; 2]>,
    model: &'static str,
    init: &'static str,
    seed: u64,
    every: u64,
    re_estimations: usize,
    normalize: Normalize,
    scale: f64,
    region_parameters: &'a [Region],
}

fn describe_regions(segmentation: &Segmentation, seen: &Seen, area: &[f64]) -> Vec<Region> {
    let m = segmentation.parameters.len();
    let mut areas = vec![0.0; m];
    let labels = &segmentation.solution.labels;
    for (&label, area) in labels.iter().zip(area) {
        areas[label as usize] += area;
    }
    let colors = preview::means(&seen.looks, labels, area, m);
    let total: f64 = area.iter().sum();
    let parameters = segmentation.parameters.iter().cloned();
    parameters
        .zip(areas)
        .zip(colors)
        .enumerate()
        .map(|(p, ((parameters, area), color))| Region {
            parameters,
            palette: categorical(p),
            color,
            area,
            share: area / total,
        })
        .collect()
}

fn regions_table(regions: &[Region]) -> String {
    let mut rows: Vec<Vec<String>> =
        vec![["region", "drawn", "color", "mean", "area", "share"].map(String::from).to_vec()];
    rows.extend(regions.iter().enumerate().map(|(p, region)| {
        let mean: Vec<String> =
            region.parameters.mean.iter().map(|mu| format!("{mu:.3}")).collect();
        let hex = |color: [f64; 3]| {
            let [r, g, b] = color.map(|c| (255.0 * c).round() as u8);
            format!("#{r:02x}{g:02x}{b:02x}")
        };
        vec![
            p.to_string(),
            hex(region.palette),
            region.color.map_or_else(String::new, hex),
            mean.join(" "),
            format!("{:.4}", region.area),
            format!("{:.1} %", 100.0 * region.share),
        ]
    }));
    table::columns(&rows)
}
