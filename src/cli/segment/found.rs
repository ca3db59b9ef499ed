//! What `meshseg segment` finds: labels, and the regions as they are shown.

use serde::Serialize;

use crate::colormap::categorical;
use crate::data::input::InputData;
use crate::labeling::Labeling;
use crate::render;
use crate::segment::count::Count;
use crate::solve::Solution;

/// The labels, and the regions as they are shown.
pub struct Found {
    pub solution: Solution,
    pub regions: Vec<Region>,
    /// [`Labeling::value_name`].
    pub value_name: &'static str,
    pub estimates: usize,
    /// Number of vertices of the mesh, after welding, whose regions are given.
    pub seed_vertices: usize,
    /// The numbers of regions that were tried, if one was to be chosen.
    pub counts: Vec<Count>,
}

/// Ambient light, relative to the light, above which the light makes no difference.
const DOMINANT_AMBIENT: f64 = 20.0;

impl Found {
    /// A warning if the model albedo has a light that hardly matters.
    pub fn barely_lit(&self) -> Option<String> {
        let parameters = &self.regions[0].parameters;
        let ambient = parameters.get("ambient")?.as_f64()?;
        let no_light = parameters.get("light")?.as_array()?.iter().all(|x| x.as_f64() == Some(0.0));
        (no_light || ambient > DOMINANT_AMBIENT).then(|| {
            "the colors hardly depend on the light: give another --light, or leave out --model albedo".into()
        })
    }
}

/// One region in the summary and in the table.
#[derive(Serialize)]
pub struct Region {
    /// mu_p, under the names of the model.
    #[serde(flatten)]
    pub parameters: serde_json::Value,
    /// Their numbers, see [`RegionParameters`](crate::labeling::RegionParameters).
    #[serde(skip)]
    pub value: Vec<f64>,
    /// As which it is drawn.
    pub palette: [f64; 3],
    /// Mean of the shown colors over its vertices, if it has any.
    pub color: Option<[f64; 3]>,
    /// Total area of the barycentric cells of its vertices.
    pub area: f64,
    /// Its share of the total area.
    pub share: f64,
}

/// The regions of a labeling on a mesh with the given vertex areas.
pub fn describe_regions(labeling: &Labeling, input: &InputData, area: &[f64]) -> Vec<Region> {
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
