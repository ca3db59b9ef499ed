//! What `meshseg segment` prints and draws at the end.

use image::RgbImage;

use crate::Result;
use crate::counted::counted;
use crate::data::input::{DataSource, InputData};
use crate::data::palette;
use crate::data::views::ViewFolder;
use crate::labeling::Labeler;
use crate::mesh::geometry::barycentric_areas;
use crate::names::Named;
use crate::outcome::{Looks, PicturedData};
use crate::relaxation::Relaxation;
use crate::render;
use crate::render::photographs::{RegionsInViews, sheet_pixels};
use crate::segment::count::Count;

use super::arguments::Arguments;
use super::found::{Found, Region};
use super::surface::Surface;
use crate::cli::solving::summary_lines;
use crate::cli::{note, preview, table, warn};

/// The regions and the data to be drawn on the mesh of the file, and the photographs that show it.
pub fn looks(found: &Found, surface: &Surface, input: &InputData, arguments: &Arguments) -> Looks {
    let solving = &arguments.solving;
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
        names: (0..found.regions.len()).map(preview::name).collect(),
        data: solving.draws().then(|| PicturedData {
            colors: colors(),
            caption: caption(),
            view: solving.view,
        }),
        views: if solving.draws() { sheet(found, surface, arguments) } else { None },
    }
}

/// The number of pixels in photographs that take about a fifth of a second to draw.
const FEW_PIXELS: u64 = 12_000_000;

/// The photographs with the cut, if the data are views that are drawn fast. Images that can no longer be read are a warning.
fn sheet(found: &Found, surface: &Surface, arguments: &Arguments) -> Option<RgbImage> {
    let Some(DataSource::Views(file)) = &arguments.data else { return None };
    let out = arguments.solving.out.as_ref()?;
    let drawn = || -> Result<Option<RgbImage>> {
        let folder = ViewFolder::open(file, arguments.views.images())?;
        if sheet_pixels(&folder)? > FEW_PIXELS {
            note(&format!(
                "the photographs are large; meshseg render {} --photographs draws the regions into them",
                out.display()
            ));
            return Ok(None);
        }
        let u = &found.solution.u;
        let numbers = u.as_slice().expect("rows are contiguous");
        RegionsInViews::new(&surface.mesh, numbers, u.ncols()).sheet(&folder).map(Some)
    };
    drawn().unwrap_or_else(|error| {
        warn(&[format!("views.png is not written: {error}")]);
        None
    })
}

/// The text that is printed at the end.
pub fn report(
    found: &Found,
    input: &InputData,
    lambda: f64,
    labeler: &Labeler,
    of_cut: Vec<(&'static str, String)>,
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
    if arguments.solving.relaxation.is_none() {
        lines.push(("relaxation", chosen_relaxation(found.regions.len())));
    }
    lines.extend(light(&found.regions[0]).map(|light| ("light", light)));
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
    lines.extend(of_cut);
    lines.extend(arguments.solving.written_to());
    let table = regions_table(found.value_name, &found.regions);
    table::pairs(&lines) + "\n" + &table + "\n" + &next_step(arguments, labeler, lambda)
}

/// The relaxation that was chosen, and why.
fn chosen_relaxation(regions: usize) -> String {
    let reason = match regions {
        2 => "all relaxations are the same for two regions",
        _ => "which certifies labels of more than two regions best",
    };
    format!("{}, {reason}", Relaxation::for_labels(regions).name())
}

/// The light of the model albedo, which is the same for all regions.
fn light(region: &Region) -> Option<String> {
    let numbers = region.parameters.get("light")?.as_array()?;
    let ambient = region.parameters.get("ambient")?.as_f64()?;
    let light: Vec<String> =
        numbers.iter().filter_map(|x| Some(format!("{:.3}", x.as_f64()?))).collect();
    Some(format!("from ({}), ambient light {ambient:.3}", light.join(", ")))
}

/// Suggests what to inspect and what to try next.
fn next_step(arguments: &Arguments, labeler: &Labeler, lambda: f64) -> String {
    let see = arguments.solving.see();
    if let Labeler::Baseline(_) = labeler {
        return see.trim_end_matches("; ").to_owned() + "\n";
    }
    let try_next = if lambda > 0.0 {
        format!("--lambda {:.1e} for fewer cuts, {:.1e} for more", 2.0 * lambda, 0.5 * lambda)
    } else {
        "a --lambda above 0 for fewer cuts".into()
    };
    format!("{see}try {try_next}, or another --regions\n")
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
