//! The regions in the preview of a run: their colors and the legend.

use ndarray::{Array1, Array2, ArrayView1};

use crate::Mesh;
use crate::colormap::categorical;
use crate::mesh::Split;
use crate::mesh::dual::face_areas;
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
    let colors = || costs.outer_iter().map(color_of_cheapest).collect();
    let data = draw.then(|| PicturedData {
        colors: colors(),
        caption: "the cheapest region at each vertex".into(),
        view,
    });
    of_shares(costs.ncols(), labels, &barycentric_areas(mesh), data)
}

/// The same for costs and labels of faces, with the mesh that is drawn, on which each face shows its own region, and a
/// row of U for each of its vertices.
pub fn of_costs_of_faces(
    mesh: &Mesh,
    costs: &Array2<f64>,
    labels: &Array1<i32>,
    view: View,
    draw: bool,
) -> (Looks, Option<(Mesh, Array2<f64>)>) {
    let m = costs.ncols();
    // What tells faces apart: the label, and the cheapest region or that none is known.
    let key = |j: usize| {
        let cheapest = cheapest(costs.row(j)).unwrap_or(m);
        (labels[j] as usize * (m + 1) + cheapest) as u16
    };
    let mut data = None;
    let picture = draw.then(|| {
        let keys: Vec<u16> = (0..mesh.faces.len()).map(key).collect();
        let Split { mesh, labels: keys, .. } = mesh.split(&keys);
        let keys: Vec<usize> = keys.into_iter().map(usize::from).collect();
        let color = |key: &usize| match key % (m + 1) {
            p if p < m => categorical(p),
            _ => [f64::NAN; 3],
        };
        let colors = keys.iter().map(color).collect();
        let caption = "the cheapest region of each face".into();
        data = Some(PicturedData { colors, caption, view });
        let is = |(v, p): (usize, usize)| f64::from(u8::from(keys[v] / (m + 1) == p));
        (mesh, Array2::from_shape_fn((keys.len(), m), is))
    });
    (of_shares(m, labels, &face_areas(mesh), data), picture)
}

/// The region of least cost; `None` where the costs are NaN, that is, unknown.
fn cheapest(s: ArrayView1<'_, f64>) -> Option<usize> {
    let cheapest = (1..s.len()).fold(0, |best, p| if s[p] < s[best] { p } else { best });
    (!s[cheapest].is_nan()).then_some(cheapest)
}

fn color_of_cheapest(s: ArrayView1<'_, f64>) -> [f64; 3] {
    cheapest(s).map_or([f64::NAN; 3], categorical)
}

/// Regions with their shares of the area.
fn of_shares(m: usize, labels: &Array1<i32>, area: &[f64], data: Option<PicturedData>) -> Looks {
    let total: f64 = area.iter().sum();
    let mut shares = vec![0.0; m];
    for (&label, area) in labels.iter().zip(area) {
        shares[label as usize] += area / total;
    }
    let region = |(p, &share): (usize, &f64)| Region {
        color: categorical(p),
        mean: None,
        text: share_of(p, share),
    };
    Looks {
        regions: shares.iter().enumerate().map(region).collect(),
        names: (0..shares.len()).map(name).collect(),
        data,
        views: None,
    }
}
