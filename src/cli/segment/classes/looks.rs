//! The picture: the most probable class beside the label.

use ndarray::{Array2, ArrayView1};

use crate::classes::carry::colors_to_vertices;
use crate::classes::{ClassLabels, most_probable};
use crate::domain::Element;
use crate::mesh::{Mesh, Split};
use crate::outcome::{Looks, PicturedData};
use crate::render;

use super::prepared::Prepared;
use super::report::{Classes, Shown};
use crate::cli::preview;
use crate::cli::solving::Solving;

/// Faces of larger meshes are too small for colors of their own.
const MAX_FACES_APART: usize = 500_000;

/// What `Split` tells apart besides the label: the most probable class, or that none is known.
const KEYS: u16 = 65;

/// The mesh as it is drawn, with a row of U and a color of the data per vertex.
pub struct Picture {
    mesh: Mesh,
    u: Array2<f64>,
    colors: Vec<[f64; 3]>,
}

impl Picture {
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    pub fn u(&self) -> &Array2<f64> {
        &self.u
    }

    /// Of labels of what counts. Faces with data, or labels, of their own get corners of their own.
    pub fn new(
        prepared: &Prepared,
        found: &ClassLabels,
        u: &Array2<f64>,
        classes: &Classes,
    ) -> Self {
        let costs = prepared.drawn_costs();
        let mesh = &prepared.surface.mesh;
        let color = |s: ArrayView1<'_, f64>| match s[0].is_nan() {
            true => [f64::NAN; 3],
            false => classes.all[most_probable(s)].palette,
        };
        let apart = costs.of == Element::Faces && mesh.faces.len() <= MAX_FACES_APART;
        if prepared.on == Element::Vertices && costs.of == Element::Vertices {
            let colors = costs.s.outer_iter().map(color).collect();
            return Picture { mesh: mesh.clone(), u: u.clone(), colors };
        }
        let class = |j: usize| {
            let s = costs.s.row(j);
            if s[0].is_nan() { KEYS - 1 } else { most_probable(s) as u16 }
        };
        let label = |j: usize| match prepared.on {
            Element::Faces => found.faces[j] as u16,
            Element::Vertices => 0,
        };
        let key = |j: usize| label(j) * KEYS + if apart { class(j) } else { 0 };
        let keys: Vec<u16> = (0..mesh.faces.len()).map(key).collect();
        let Split { mesh: split, of, labels: keys } = mesh.split(&keys);
        let m = classes.all.len();
        let u = match prepared.on {
            Element::Vertices => {
                u.select(ndarray::Axis(0), &of.iter().map(|&v| v as usize).collect::<Vec<_>>())
            }
            Element::Faces => Array2::from_shape_fn((of.len(), m), |(v, p)| {
                f64::from(u8::from(usize::from(keys[v] / KEYS) == p))
            }),
        };
        let colors = match costs.of {
            Element::Vertices => of.iter().map(|&v| color(costs.s.row(v as usize))).collect(),
            Element::Faces if apart => {
                let of_key = |key: &u16| {
                    let class = classes.all.get(usize::from(key % KEYS));
                    class.map_or([f64::NAN; 3], |class| class.palette)
                };
                keys.iter().map(of_key).collect()
            }
            Element::Faces => colors_to_vertices(&split, |j| color(costs.s.row(j))),
        };
        Picture { mesh: split, u, colors }
    }
}

/// What is drawn of the classes and of the data.
pub fn looks(
    classes: &Classes,
    picture: Option<&Picture>,
    of: Element,
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
    let [one, _] = of.nouns();
    Looks {
        regions: classes.all.iter().enumerate().map(region).collect(),
        names: classes
            .all
            .iter()
            .enumerate()
            .map(|(p, class)| class.name.clone().unwrap_or_else(|| preview::name(p)))
            .collect(),
        data: picture.map(|picture| PicturedData {
            colors: picture.colors.clone(),
            caption: format!("the most probable class of each {one}"),
            view: solving.view,
        }),
        views: None,
    }
}
