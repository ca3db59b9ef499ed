//! The numbers of a segmentation, as in `summary.json`.

use serde::Serialize;

use crate::data::input::InputData;
use crate::labeling::Labeler;
use crate::names::Named;
use crate::segment::count::Count;
use crate::solve::Summary;

use super::arguments::Arguments;
use super::found::{Found, Region};
use super::surface::Surface;
use crate::cli::views::ViewSummary;

/// Those of every solve, and what the segmentation adds.
#[derive(Serialize)]
pub struct SegmentSummary<'a> {
    #[serde(flatten)]
    pub summary: &'a Summary,
    pub data: &'a str,
    pub data_unit_range: Option<[f64; 2]>,
    pub data_unit: Option<&'static str>,
    pub data_sign: Option<&'static str>,
    pub welded_vertices: usize,
    /// Whether lambda was chosen for the data.
    pub lambda_chosen: bool,
    /// Empty if the number of regions was given.
    pub regions_tried: &'a [Count],
    pub model: &'static str,
    pub init: &'static str,
    pub seed: u64,
    pub seed_vertices: usize,
    pub every: u64,
    pub re_estimations: usize,
    pub normalize: &'static str,
    pub scale: f64,
    pub region_parameters: &'a [Region],
    #[serde(skip_serializing_if = "Option::is_none")]
    pub views: Option<ViewSummary<'a>>,
}

/// All of them, without those of views.
pub fn summary<'a>(
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
