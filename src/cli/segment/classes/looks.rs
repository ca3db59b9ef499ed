//! The picture: the most probable class beside the label.

use meshseg::classes::{ClassCosts, most_probable};
use meshseg::domain::Element;
use meshseg::mesh::Split;
use meshseg::outcome::{Looks, PicturedData};
use meshseg::render;
use ndarray::ArrayView1;

use super::report::{Classes, Shown};
use crate::cli::segment::surface::Surface;
use crate::cli::solving::Solving;

/// What is drawn; labels of faces on a mesh that is divided between them.
pub fn looks(
    classes: &Classes,
    costs: &dyn Fn() -> ClassCosts,
    surface: &Surface,
    split: Option<&Split>,
    solving: &Solving,
) -> Looks {
    let region = |(p, class): (usize, &Shown)| render::Region {
        color: class.palette,
        mean: None,
        text: match &class.name {
            Some(name) => format!("{p}   {:.1} %   {name}", 100.0 * class.share),
            None => format!("{p}   {:.1} %", 100.0 * class.share),
        },
    };
    let drawn = || {
        let costs = &costs();
        PicturedData {
            colors: colors(classes, costs, surface, split),
            caption: match costs.of {
                Element::Vertices => "the most probable class at each vertex".into(),
                Element::Faces => {
                    "the most probable class of the faces, averaged at vertices".into()
                }
            },
            view: solving.view,
        }
    };
    Looks {
        regions: classes.all.iter().enumerate().map(region).collect(),
        data: (!solving.no_preview).then(drawn),
        views: None,
    }
}

/// One color per vertex of the drawn mesh; NaN where nothing is known.
fn colors(
    classes: &Classes,
    costs: &ClassCosts,
    surface: &Surface,
    split: Option<&Split>,
) -> Vec<[f64; 3]> {
    let color =
        |s: ArrayView1<'_, f64>| (!s[0].is_nan()).then(|| classes.all[most_probable(s)].palette);
    let mesh = split.map_or(&surface.mesh, |split| &split.mesh);
    let of = |v: usize| split.map_or(v, |split| split.of[v] as usize);
    if costs.of == Element::Vertices {
        return (0..mesh.vertices.len())
            .map(|v| color(costs.s.row(of(v))).unwrap_or([f64::NAN; 3]))
            .collect();
    }
    let mut sums = vec![([0.0; 3], 0.0); mesh.vertices.len()];
    for (j, face) in mesh.faces.iter().enumerate() {
        let Some(color) = color(costs.s.row(j)) else { continue };
        let area = mesh.face_area(j).max(f64::MIN_POSITIVE);
        for &v in face {
            let (sum, total) = &mut sums[v as usize];
            *total += area;
            (0..3).for_each(|c| sum[c] += area * color[c]);
        }
    }
    // 0 / 0 is NaN: nothing is known.
    sums.into_iter().map(|(sum, total)| sum.map(|c| c / total)).collect()
}
