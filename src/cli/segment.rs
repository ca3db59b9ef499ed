//! `meshseg segment`: segments the data on a mesh into regions.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use meshseg::colormap::categorical;
use meshseg::counted::counted;
use meshseg::data::input::{self, DataSource, InputData, Mapping};
use meshseg::data::projection::{Fit, Projection};
use meshseg::data::texture::Texel;
use meshseg::data::{Initial, ModelName, palette};
use meshseg::labeling::{Baseline, Labeler, Labeling, count_regions, label};
use meshseg::mesh::geometry::barycentric_areas;
use meshseg::mesh::{Mesh, Normalize, Source, Weld};
use meshseg::names::Named;
use meshseg::operator::Mass;
use meshseg::outcome::{self, Looks, PicturedData};
use meshseg::render;
use meshseg::seeds::Seeds;
use meshseg::segment::Alternation;
use meshseg::segment::count::{self, Count};
use meshseg::solve::{Request, Solution, Summary, check_mesh};
use meshseg::{Error, Result, sweep};
use serde::Serialize;
use strum::{EnumString, IntoStaticStr, VariantNames};

use super::means::{self, Means};
use super::progress::Progress;
use super::seeds;
use super::solving::{Solving, exit, summary_lines};
use super::views::{ViewArguments, ViewSummary};
use super::{Outcome, named, note, one_line, preview, print, table, views, warn, welding};

/// Segment colors, textures, an image, curvature or other data on a mesh into regions.
///
/// Region parameters and labels are computed alternately; the final labels are certified for the final parameters.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Mesh file, builtin:spot, or a shape such as torus:400x250
    mesh: PathBuf,

    /// colors (of vertices, else of faces or materials, in [0,1]), texture (the images of the materials),
    /// texture:IMAGE (PNG or JPEG, at the texture coordinates, as stored), image:IMAGE (projected onto the surface, see
    /// --project; JPEG photos are turned upright according to their EXIF orientation), curvature (mean curvature by the
    /// cotangent Laplacian, positive where the surface is convex as seen from outside), curvature:mean-quadric (the
    /// same of quadrics fitted to two rings of vertices, for noisy meshes), curvature:gaussian (by the angle defect),
    /// curvature:shape-index (1 on caps, 0.5 on ridges, 0 on saddles, -0.5 in ruts, -1 in cups), or FILE.npy (V or V x
    /// d numbers; uint8 is divided by 255). The middle 96 % of a curvature are mapped to [0,1], the shape index from
    /// [-1,1]. views:FILE has images of calibrated cameras, see Views below [default: the textures or colors that come
    /// with the mesh]
    #[arg(long, value_name = "DATA")]
    data: Option<DataSource>,

    /// How image:IMAGE is projected onto the surface: xy, xz, yz; two axes such as x,-z (to the right and upwards in
    /// the image); cylinder or sphere (around z; around another axis as in cylinder:y) [default: by the texture
    /// coordinates of the mesh; xy for a grid]
    #[arg(long, value_name = "AXES", allow_hyphen_values = true)]
    project: Option<Projection>,

    /// Fit of an image that is projected along two axes. cover: it keeps its aspect ratio, and what is too long is
    /// cropped at both ends; stretch: it is stretched to fit
    #[arg(long, value_parser = named::<Fit>(), default_value = "cover")]
    fit: Fit,

    /// How a vertex samples an image. mean: the mean over its third of its faces; vertex: the color at its position
    #[arg(long, value_parser = named::<Texel>(), default_value = "mean")]
    texel: Texel,

    /// Number of regions, 2 to 64; auto:2..8 chooses one of 2 to 8, for which clusters of the data are different, compact
    /// and far from each other (the largest Calinski-Harabasz index on a coarse mesh); auto is short for auto:2..8
    #[arg(long, value_name = "M", allow_negative_numbers = true,
        required_unless_present_any = ["means", "thresholds"], conflicts_with_all = ["means", "thresholds"])]
    regions: Option<Regions>,

    /// Model of the data in a region. constant: near a mean, costs are squared distances; l1: near a median except for
    /// outliers, costs are absolute differences, summed over the columns of the data; gaussian: normally distributed
    /// with a mean and a covariance, costs are negative log densities, for regions that differ by their spread as well; histogram: any distribution of
    /// up to three numbers, costs are negative log densities of smoothed histograms.
    /// Baselines that ignore cuts, scored by the energy and bound of constant for their means: kmeans, the nearest
    /// center of area-weighted k-means; threshold, the classes of least variance of data with one number per vertex
    /// (Otsu's method), or those of --thresholds [default: constant, or that of the parameters]
    #[arg(long, value_parser = named::<Model>())]
    model: Option<Model>,

    /// Region parameters that stay as they are: FILE.npy with one row of means (medians for l1) per region, or the
    /// summary.json of an earlier run
    #[arg(long, value_name = "FILE", conflicts_with_all = ["every", "init", "thresholds"])]
    means: Option<PathBuf>,

    /// Vertices or faces whose regions are given: a .csv file with the header vertex,region or face,region (a face
    /// stands for its corners), or FILE.npy with one integer per vertex or face, -1 where nothing is given. The labels
    /// agree with them, and so do all labelings that the certificate refers to; the regions start from the data there
    #[arg(long, value_name = "FILE", conflicts_with_all = ["init", "thresholds"])]
    seeds: Option<PathBuf>,

    /// Thresholds of --model threshold, ascending, separated by commas
    #[arg(long, value_name = "T,...", value_delimiter = ',', allow_negative_numbers = true)]
    thresholds: Vec<f64>,

    /// Weight of the length of the cuts, in units of squared data times length (of data times length for l1, of length
    /// for gaussian and histogram) [default: 0.02 times the variance of the data (half of their mean deviation for l1,
    /// half of their dimension for gaussian and histogram), times the square root of the area, halved until no region is empty on a coarse mesh and
    /// the labels there explain two thirds of what k-means (k-medians for l1, a mixture for gaussian) explains]
    #[arg(long, allow_negative_numbers = true)]
    lambda: Option<f64>,

    /// Iterations between re-estimations of the region parameters
    #[arg(long, value_name = "R", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..), allow_negative_numbers = true)]
    every: u64,

    /// Initial region parameters. kmeans: means of clusters (medians for l1; for gaussian a mixture of normal
    /// distributions, fitted from clusters); random: those of random regions
    #[arg(long, value_parser = named::<Initial>(), default_value = "kmeans")]
    init: Initial,

    /// Seed of the initial region parameters
    #[arg(long, default_value_t = 0, allow_negative_numbers = true)]
    seed: u64,

    /// area: scale the mesh to total area 1, so that lambda means the same for every mesh; none: keep its units
    #[arg(long, value_parser = named::<Normalize>(), default_value = "area")]
    normalize: Normalize,

    /// Merge vertices within this distance of each other, in the units of the file, into the first of them [default: 0,
    /// equal positions only]; results refer to the vertices of the file
    #[arg(long, value_name = "TOLERANCE", num_args = 0..=1, default_missing_value = "0", allow_negative_numbers = true)]
    weld: Option<f64>,

    /// Keep coincident vertices separate; cuts between them are free
    #[arg(long, conflicts_with = "weld")]
    no_weld: bool,

    #[command(flatten)]
    views: ViewArguments,

    #[command(flatten)]
    solving: Solving,
}

const EXAMPLES: &str = "\
Examples:
  meshseg segment builtin:spot --regions 3 --out results/spot
  meshseg segment person.ply --regions 4 --lambda 0.005 --out results/person
  meshseg segment bunny.ply --data curvature --regions 3 --out results/bunny
  meshseg segment model.obj --data texture:atlas.png --regions 5 --out results/model
  meshseg segment grid:300x200 --data image:photo.jpg --regions 3 --out results/photo
  meshseg segment bunny.ply --data image:photo.jpg --project xy --regions 3 --out results/bunny
  meshseg segment temple.ply --data views:templeSR_par.txt --regions 4 --out results/temple";

#[derive(Clone, Copy, PartialEq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "lowercase")]
enum Model {
    Constant,
    L1,
    Gaussian,
    Histogram,
    KMeans,
    Threshold,
}

impl Arguments {
    fn labeler(&self) -> Result<Labeler> {
        let named = match self.model {
            Some(model @ (Model::Constant | Model::L1 | Model::Gaussian | Model::Histogram)) => {
                ModelName::named(model.name())
            }
            _ => None,
        };
        let baseline = matches!(self.model, Some(Model::KMeans | Model::Threshold));
        if baseline && let Some(path) = &self.means {
            let message = "--means does not apply to a baseline, which has means of its own";
            return Err(Error::unsuitable(message).of_file(path));
        }
        if baseline && let Some(path) = &self.seeds {
            let message = "--seeds does not apply to a baseline, whose classes ignore positions";
            return Err(Error::unsuitable(message).of_file(path));
        }
        if !self.thresholds.is_empty() && self.model != Some(Model::Threshold) {
            return Err(Error::unsuitable("--thresholds needs --model threshold"));
        }
        Ok(match (self.model, &self.means) {
            (_, Some(path)) => {
                let Means { model, parameters } = means::read(path, named)?;
                Labeler::Given(model, parameters)
            }
            (Some(Model::KMeans), _) => Labeler::Baseline(Baseline::KMeans { seed: self.seed }),
            (Some(Model::Threshold), _) if self.thresholds.is_empty() => {
                Labeler::Baseline(Baseline::Otsu)
            }
            (Some(Model::Threshold), _) => {
                Labeler::Baseline(Baseline::Thresholds(self.thresholds.clone()))
            }
            _ => Labeler::Estimated(named.unwrap_or_default()),
        })
    }

    /// m, and what was tried for it.
    fn region_count(
        &self,
        labeler: &Labeler,
        surface: &Surface,
        input: &InputData,
        mass: Mass,
    ) -> Result<(usize, Vec<Count>)> {
        let numbers = match (labeler, &self.regions) {
            (Labeler::Given(_, parameters), _) => return Ok((parameters.len(), Vec::new())),
            (_, None) => return Ok((self.thresholds.len() + 1, Vec::new())),
            (_, Some(Regions::Number(m))) => return Ok((*m, Vec::new())),
            (_, Some(Regions::Auto(numbers))) => numbers.clone(),
        };
        if let Some(path) = &self.seeds {
            let message = "seeds name regions by numbers, so --regions must be a number";
            return Err(Error::unsuitable(message).of_file(path));
        }
        let model = match labeler {
            Labeler::Estimated(model) | Labeler::Given(model, _) => *model,
            Labeler::Baseline(_) => ModelName::Constant,
        };
        let counts =
            count_regions(&surface.scaled, input.observed(), model, numbers, mass, self.seed)?;
        Ok((count::best(&counts), counts))
    }
}

/// The argument of `--regions`.
#[derive(Clone)]
enum Regions {
    /// m.
    Number(usize),
    /// One of these.
    Auto(RangeInclusive<usize>),
}

impl FromStr for Regions {
    type Err = &'static str;

    fn from_str(text: &str) -> std::result::Result<Self, Self::Err> {
        let number = |text: &str| {
            let m = text.parse().ok().filter(|m| (2..=64).contains(m));
            m.ok_or("must be a number from 2 to 64, or auto:2..8")
        };
        let Some(range) = text.strip_prefix("auto") else {
            return Ok(Regions::Number(number(text)?));
        };
        if range.is_empty() {
            return Ok(Regions::Auto(2..=8));
        }
        let ends = range.strip_prefix(':').and_then(|range| range.split_once(".."));
        let (low, high) = ends.ok_or("must be a number from 2 to 64, or auto:2..8")?;
        let (low, high) = (number(low)?, number(high)?);
        if low > high {
            return Err("the first number of auto:2..8 must not be above the second");
        }
        Ok(Regions::Auto(low..=high))
    }
}

pub fn run(arguments: &Arguments) -> Outcome {
    sweep::with_threads(arguments.solving.threads(), || run_here(arguments))?
}

fn run_here(arguments: &Arguments) -> Outcome {
    let solving = &arguments.solving;
    let request = solving.request(arguments.lambda.unwrap_or(0.0))?;
    request.check()?;
    let labeler = arguments.labeler()?;
    views::check(arguments.data.as_ref(), &request)?;
    let surface = Surface::read(arguments)?;
    let input = surface.input(arguments)?;
    input.notes.iter().for_each(|line| note(&one_line(line)));
    views::note_means(&input, &labeler);

    let (regions, counts) = arguments.region_count(&labeler, &surface, &input, request.mass)?;
    let seeds = surface.seeds(arguments, regions)?;
    let mut found = labeled(&surface, &input, &labeler, regions, seeds, arguments, &request)?;
    found.counts = counts;
    let lambda = found.solution.summary.lambda;
    found.solution.summary.warnings.extend(warnings(&surface, &input, arguments));
    found.solution.summary.warnings.extend(mapped_data(&input, &labeler));
    let views = ViewSummary::of(&found.solution, &input, &surface.scaled, &arguments.views);
    if let Some(weld) = &surface.weld {
        found.solution = found.solution.spread(&surface.mesh, weld);
    }
    let summary =
        SegmentSummary { views, ..summary(&found, &surface, &input, &labeler, arguments) };
    let looks = looks(&found, &surface, &input, solving);
    outcome::write(&solving.out, &summary, &found.solution, &surface.mesh, &looks)?;

    surface.report(arguments);
    warn(&found.solution.summary.warnings);
    let printed = print(&report(&found, &input, lambda, &labeler, arguments));
    exit(found.solution.summary.status, printed)
}

/// The mesh that is segmented.
struct Surface {
    source: Source,
    /// The mesh of the file.
    mesh: Mesh,
    weld: Option<Weld>,
    /// Factor by which the welded mesh is scaled.
    scale: f64,
    /// The mesh after welding and scaling.
    scaled: Mesh,
}

impl Surface {
    fn read(arguments: &Arguments) -> Result<Self> {
        let source = Source::parse(&arguments.mesh)?;
        let mesh = source.mesh()?;
        let tolerance = arguments.weld.unwrap_or(0.0);
        let weld = if arguments.no_weld { None } else { welding::weld(&mesh, tolerance)? };
        let welded = weld.as_ref().map_or(&mesh, |weld| &weld.mesh);
        let scale = arguments.normalize.scale(welded.area());
        let scaled = welded.clone().scaled(scale);
        check_mesh(&scaled).map_err(|error| error.of_file(&arguments.mesh))?;
        Ok(Surface { source, mesh, weld, scale, scaled })
    }

    fn welded(&self) -> &Mesh {
        self.weld.as_ref().map_or(&self.mesh, |weld| &weld.mesh)
    }

    /// The data on the welded mesh.
    fn input(&self, arguments: &Arguments) -> Result<InputData> {
        let Arguments { texel, project, fit, .. } = *arguments;
        let data = arguments.data.as_ref();
        let mapping = Mapping { texel, project, fit, views: arguments.views.options(data)? };
        input::read(&self.source, self.welded(), self.weld.as_ref(), data, &mapping)
    }

    /// The seeds of the file, on the welded mesh.
    fn seeds(&self, arguments: &Arguments, m: usize) -> Result<Seeds> {
        let Some(path) = &arguments.seeds else { return Ok(Seeds::default()) };
        let seeds = seeds::read(path, &self.mesh, m)?;
        let welded = self.weld.as_ref().map(|weld| seeds.welded(weld));
        welded.unwrap_or(Ok(seeds)).map_err(|error| error.of_file(path))
    }

    /// Reports what was done to the mesh.
    fn report(&self, arguments: &Arguments) {
        if self.weld.is_some() {
            let welded = welding::note(self.weld.as_ref(), arguments.weld.unwrap_or(0.0));
            note(&format!("{welded} (--no-weld keeps them separate)"));
        } else if let Some(tolerance) = arguments.weld {
            note(&welding::note(None, tolerance));
        }
        if self.scale != 1.0 {
            note(&format!(
                "scaled by {:.6e} to total area 1, which lambda refers to; --normalize none keeps the units",
                self.scale
            ));
        }
    }
}

fn warnings(surface: &Surface, input: &InputData, arguments: &Arguments) -> Vec<String> {
    let mut warnings = input.warnings.clone();
    warnings.extend(match arguments.weld {
        Some(_) => welding::unmended(surface.welded()),
        None => welding::shattered(surface.welded(), "--weld"),
    });
    let side_effect = |weld| welding::side_effect(weld, "--no-weld keeps them separate");
    warnings.extend(surface.weld.as_ref().and_then(side_effect));
    warnings
}

/// Given parameters are in the units of the data as they are segmented, which may depend on the mesh.
fn mapped_data(input: &InputData, labeler: &Labeler) -> Option<String> {
    let (Labeler::Given(..), Some(range)) = (labeler, &input.unit_range) else { return None };
    let [low, high] = range.ends;
    Some(format!(
        "the given means refer to data from 0 to 1, to which {low:.3e} and {high:.3e} are mapped on this mesh; means of \
         another mesh have other units"
    ))
}

fn summary<'a>(
    found: &'a Found,
    surface: &Surface,
    input: &'a InputData,
    labeler: &Labeler,
    arguments: &Arguments,
) -> SegmentSummary<'a> {
    SegmentSummary {
        summary: &found.solution.summary,
        data: &input.name,
        // Lengths are those of the scaled mesh.
        data_unit_range: input.unit_range.map(|range| range.on_scaled(surface.scale)),
        data_unit: input.unit_range.and_then(|range| range.unit()),
        data_sign: input.sign,
        welded_vertices: surface.weld.as_ref().map_or(0, |weld| weld.merged),
        lambda_chosen: arguments.lambda.is_none(),
        regions_tried: &found.counts,
        model: labeler.name(),
        init: match labeler {
            Labeler::Given(..) => "given",
            Labeler::Baseline(baseline) => baseline.name(),
            Labeler::Estimated(_) if found.seed_vertices > 0 => "seeds",
            Labeler::Estimated(_) => arguments.init.name(),
        },
        seed: arguments.seed,
        seed_vertices: found.seed_vertices,
        every: arguments.every,
        re_estimations: found.estimates,
        normalize: arguments.normalize.name(),
        scale: surface.scale,
        region_parameters: &found.regions,
        views: None,
    }
}

/// The regions and the data to be drawn on the mesh of the file.
fn looks(found: &Found, surface: &Surface, input: &InputData, solving: &Solving) -> Looks {
    let number = number_format(&found.regions);
    let drawn = |(p, region): (usize, &Region)| render::Region {
        color: region.palette,
        mean: region.color,
        text: preview::legend(p, region.share, found.value_name, &region.value, &number),
    };
    let colors = || match &surface.weld {
        Some(weld) => weld.spread(&input.colors),
        None => input.colors.clone(),
    };
    let areas = || barycentric_areas(&surface.scaled);
    let range = input.unit_range;
    let (ends, unit) = (range.map(|range| range.ends), range.and_then(|range| range.unit()));
    let caption = || palette::words(&input.data, &input.name, ends, unit, &areas());
    Looks {
        regions: found.regions.iter().enumerate().map(drawn).collect(),
        data: (!solving.no_preview).then(|| PicturedData {
            colors: colors(),
            caption: caption(),
            view: solving.view,
        }),
    }
}

/// The text that is printed at the end.
fn report(
    found: &Found,
    input: &InputData,
    lambda: f64,
    labeler: &Labeler,
    arguments: &Arguments,
) -> String {
    let mut lines = summary_lines(&found.solution.summary);
    if let Some(range) = &input.unit_range {
        let [low, high] = range.ends.map(table::common_format(table::largest(&range.ends), 4));
        let unit = range.unit().map_or_else(String::new, |unit| format!(" in {unit} of the file"));
        lines.push(("data", format!("{}, [{low}, {high}]{unit} mapped to [0, 1]", input.name)));
    }
    if arguments.lambda.is_none() {
        let lambda = lines.iter_mut().find(|(name, _)| *name == "lambda");
        lambda.expect("it has a line").1 += ", chosen for these data";
    }
    if !found.counts.is_empty() {
        let index = |count: &Count| {
            let note = if count.distinct { "" } else { " (not all different)" };
            format!("{} has {:.2e}{note}", count.regions, count.index)
        };
        let tried: Vec<String> = found.counts.iter().map(index).collect();
        let chosen = format!("{}, by the largest index: {}", found.regions.len(), tried.join(", "));
        lines.push(("regions chosen", chosen));
    }
    if found.seed_vertices > 0 {
        let seeds =
            counted(found.seed_vertices, "vertex with a given label", "vertices with given labels");
        lines.push(("seeds", seeds));
    }
    lines.push(("written to", arguments.solving.out.display().to_string()));
    let table = regions_table(found.value_name, &found.regions);
    table::pairs(&lines) + "\n" + &table + "\n" + &next_step(arguments, labeler, lambda)
}

/// The labels, and the regions as they are shown.
struct Found {
    solution: Solution,
    regions: Vec<Region>,
    /// [`Labeling::value_name`].
    value_name: &'static str,
    estimates: usize,
    /// Number of vertices of the mesh, after welding, whose regions are given.
    seed_vertices: usize,
    /// The numbers of regions that were tried, if one was to be chosen.
    counts: Vec<Count>,
}

/// Labels the data by the method that the arguments name; chooses lambda for them if none is given.
fn labeled(
    surface: &Surface,
    input: &InputData,
    labeler: &Labeler,
    regions: usize,
    seeds: Seeds,
    arguments: &Arguments,
    request: &Request,
) -> Result<Found> {
    let seed_vertices = seeds.count();
    let alternation = Alternation {
        regions,
        initial: arguments.init,
        seed: arguments.seed,
        every: arguments.every,
        labels: None,
        seeds,
    };
    let mut progress = Progress::new(request.stop.relative_gap.unwrap_or(0.0));
    let mut observe = |sample: Option<&_>| progress.observe(sample);
    let (mesh, data, lambda) = (&surface.scaled, input.observed(), arguments.lambda);
    let labeling = label(mesh, data, labeler, &alternation, lambda, request, &mut observe)
        .map_err(|error| error.of_file(Path::new(&input.name)))?;
    progress.finish();
    let regions = describe_regions(&labeling, input, &barycentric_areas(mesh));
    let Labeling { solution, value_name, estimates, .. } = labeling;
    Ok(Found { solution, regions, value_name, estimates, seed_vertices, counts: Vec::new() })
}

/// Suggests what to inspect and what to try next.
fn next_step(arguments: &Arguments, labeler: &Labeler, lambda: f64) -> String {
    let picture = if arguments.solving.no_preview { "segmented.ply" } else { "preview.png" };
    let picture = arguments.solving.out.join(picture);
    if let Labeler::Baseline(_) = labeler {
        return format!("see {}\n", picture.display());
    }
    let try_next = if lambda > 0.0 {
        format!("--lambda {:.1e} for fewer cuts, {:.1e} for more", 2.0 * lambda, 0.5 * lambda)
    } else {
        "a --lambda above 0 for fewer cuts".into()
    };
    format!("see {}; try {try_next}, or another --regions\n", picture.display())
}

/// One region in the summary and in the table.
#[derive(Serialize)]
struct Region {
    /// mu_p, under the names of the model.
    #[serde(flatten)]
    parameters: serde_json::Value,
    /// Their numbers, see [`RegionParameters`](meshseg::labeling::RegionParameters).
    #[serde(skip)]
    value: Vec<f64>,
    /// As which it is drawn.
    palette: [f64; 3],
    /// Mean of the shown colors over its vertices, if it has any.
    color: Option<[f64; 3]>,
    /// Total area of the barycentric cells of its vertices.
    area: f64,
    /// Its share of the total area.
    share: f64,
}

#[derive(Serialize)]
struct SegmentSummary<'a> {
    #[serde(flatten)]
    summary: &'a Summary,
    data: &'a str,
    data_unit_range: Option<[f64; 2]>,
    data_unit: Option<&'static str>,
    data_sign: Option<&'static str>,
    welded_vertices: usize,
    /// Whether lambda was chosen for the data.
    lambda_chosen: bool,
    /// Empty if the number of regions was given.
    regions_tried: &'a [Count],
    model: &'static str,
    init: &'static str,
    seed: u64,
    seed_vertices: usize,
    every: u64,
    re_estimations: usize,
    normalize: &'static str,
    scale: f64,
    region_parameters: &'a [Region],
    #[serde(skip_serializing_if = "Option::is_none")]
    views: Option<ViewSummary<'a>>,
}

fn describe_regions(labeling: &Labeling, input: &InputData, area: &[f64]) -> Vec<Region> {
    let m = labeling.regions.len();
    let mut areas = vec![0.0; m];
    let labels = &labeling.solution.labels;
    for (&label, area) in labels.iter().zip(area) {
        areas[label as usize] += area;
    }
    let of_vertices = labels.iter().map(|&label| label as usize);
    let colors = render::mean_colors(&input.colors, of_vertices, area, m);
    let total: f64 = area.iter().sum();
    let parameters = labeling.regions.iter();
    parameters
        .zip(areas)
        .zip(colors)
        .enumerate()
        .map(|(p, ((parameters, area), color))| Region {
            parameters: parameters.all.clone(),
            value: parameters.value.clone(),
            palette: categorical(p),
            color,
            area,
            share: area / total,
        })
        .collect()
}

/// The common format of the numbers of the regions.
fn number_format(regions: &[Region]) -> impl Fn(f64) -> String {
    table::common_format(table::largest(regions.iter().flat_map(|region| &region.value)), 3)
}

fn regions_table(value_name: &str, regions: &[Region]) -> String {
    let mut rows: Vec<Vec<String>> =
        vec![["region", "drawn", "color", value_name, "area", "share"].map(String::from).to_vec()];
    let number = number_format(regions);
    let area = table::common_format(table::largest(regions.iter().map(|region| &region.area)), 4);
    rows.extend(regions.iter().enumerate().map(|(p, region)| {
        let value: Vec<String> = region.value.iter().map(|&mu| number(mu)).collect();
        let hex = |color: [f64; 3]| {
            let [r, g, b] = color.map(|c| (255.0 * c).round() as u8);
            format!("#{r:02x}{g:02x}{b:02x}")
        };
        vec![
            p.to_string(),
            hex(region.palette),
            region.color.map_or_else(String::new, hex),
            value.join(" "),
            area(region.area),
            format!("{:.1} %", 100.0 * region.share),
        ]
    }));
    table::columns(&rows)
}
