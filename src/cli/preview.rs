//! The regions in the preview of a run: their colors and the legend.

use ndarray::{Array1, Array2, ArrayView1};

use crate::Mesh;
use crate::colormap::categorical;
use crate::mesh::geometry::barycentric_areas;
use crate::outcome::{Looks, PicturedData};
use crate::render::{Region, View};

/// A line of the legend, with the first three numbers of the value of a region.
pub fn legend(
    p: usize,
    share: f64,
    value_name: &str,
    numbers: &[f64],
    number: impl Fn(f64) -> String,
) -> String {
    let mut text = share_of(p, share);
    if !numbers.is_empty() {
        let first: Vec<String> = numbers.iter().take(3).map(|&mu| number(mu)).collect();
        let more = if numbers.len() > 3 { " …" } else { "" };
        text += &format!("   {value_name} {}{more}", first.join(" "));
    }
    text
}

/// The name of a region that has none.
pub fn name(p: usize) -> String {
    format!("region {p}")
}

fn share_of(p: usize, share: f64) -> String {
    format!("{p}   {:.1} %", 100.0 * share)
}

/// The preview for given costs: each vertex shows its cheapest region.
pub fn of_costs(
    mesh: &Mesh,
    costs: &Array2<f64>,
    labels: &Array1<i32>,
    view: View,
    draw: bool,
) -> Looks {
    let area = barycentric_areas(mesh);
    let total: f64 = area.iter().sum();
    let mut shares = vec![0.0; costs.ncols()];
    for (&label, area) in labels.iter().zip(&area) {
        shares[label as usize] += area / total;
    }
    let region = |(p, &share): (usize, &f64)| Region {
        color: categorical(p),
        mean: None,
        text: share_of(p, share),
    };
    // A vertex whose costs are NaN is unknown.
    let look = |s: ArrayView1<f64>| {
        let cheapest = (1..s.len()).fold(0, |best, p| if s[p] < s[best] { p } else { best });
        if s[cheapest].is_nan() { [f64::NAN; 3] } else { categorical(cheapest) }
    };
    let colors = || costs.outer_iter().map(look).collect();
    Looks {
        regions: shares.iter().enumerate().map(region).collect(),
        names: (0..shares.len()).map(name).collect(),
        data: draw.then(|| PicturedData {
            colors: colors(),
            caption: "the cheapest region at each vertex".into(),
            view,
        }),
        views: None,
    }
}
