//! Panels as a page on which their surfaces are turned together.
//!
//! Positions have 16 bits within the unit ball, colors 8. Surfaces with more vertices than fit are coarsened; the
//! vertices that are left keep their positions and colors.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value, json};

use super::bar::Bar;
use super::shown::Shown;
use super::stage::Stage;
use super::{Panel, Panels};
use crate::colormap::{categorical, sequential};
use crate::error::{Error, Result};
use crate::mesh::orient::orient;
use crate::mesh::{Mesh, Weld, coarsen::Coarsening};
use crate::render::web;

/// The largest size of the surfaces and colors of a page, in characters of base64.
const MAX_SIZE: usize = 12_000_000;
/// Characters for a vertex of a surface, with its two faces, and of a panel.
const SURFACE_SIZE: usize = 24;
const PANEL_SIZE: usize = 6;
/// Indices of vertices have 16 bits.
const MAX_VERTICES: usize = 1 << 16;
/// Colors along a color bar.
const STOPS: u32 = 16;
/// A view from less than about eight degrees off the up direction has its own up direction.
const STEEP: f64 = 0.99;

impl Panels<'_> {
    /// The page as HTML, with a title; `program` made it. It has the headings and the captions of the picture,
    /// and begins with its first view. It takes at most 13 MB and the size of the page without surfaces, 0.7
    /// MB: there, surfaces with many vertices are coarsened, all with more than 65,536.
    ///
    /// # Errors
    /// Those of [`Panels::png`].
    ///
    /// # Panics
    /// An array of a surface is not of its vertices.
    pub fn html(&self, title: &str, program: &str) -> Result<String> {
        self.page(title, program, false)
    }

    /// The same as a film: a surface for each row, with its columns on a slider.
    ///
    /// # Errors
    /// Those of [`Panels::png`].
    ///
    /// # Panics
    /// An array of a surface is not of its vertices.
    pub fn film(&self, title: &str, program: &str) -> Result<String> {
        self.page(title, program, true)
    }

    fn page(&self, title: &str, program: &str, film: bool) -> Result<String> {
        self.check()?;
        let stages = Stage::all(self.surfaces, self.views);
        let count = self.panels.len();
        // A page scrolls: if the number of columns is free, about as many rows.
        let columns =
            self.columns.unwrap_or(count.min((count as f64).sqrt().ceil().max(3.0) as usize));
        self.check_headings(columns)?;

        let shown: Vec<usize> = self.distinct_meshes();
        let most = MAX_SIZE / (SURFACE_SIZE * shown.len() + PANEL_SIZE * count);
        let bodies: Vec<Option<Body>> = shown
            .iter()
            .map(|&s| Body::of(&stages[s], most.min(MAX_VERTICES)))
            .collect::<Result<_>>()?;
        let body_of = |surface: usize| {
            shown
                .iter()
                .position(|&s| self.same_mesh(s, surface))
                .expect("its own, or an equal one")
        };
        let panels = self.panels.iter().zip(self.captions()).map(|(panel, caption)| {
            let body = body_of(panel.surface);
            let mut value = match &bodies[body] {
                Some(body) => self.panel(panel, body),
                None => json!({}),
            };
            value["surface"] = bodies[body].as_ref().map(|_| body).into();
            value["caption"] = caption.into();
            value["bar"] = self.surfaces[panel.surface].bar(panel.shown).map(bar).into();
            value
        });
        Ok(web::page(&json!({ "figure": {
            "title": title, "program": program, "columns": columns, "film": film,
            "column_headings": self.column_headings, "row_headings": self.row_headings,
            "panels": panels.collect::<Vec<_>>(),
            "surfaces": bodies.iter().map(|body| body.as_ref().map(Body::json)).collect::<Vec<_>>(),
        }})))
    }

    fn same_mesh(&self, a: usize, b: usize) -> bool {
        std::ptr::eq(self.surfaces[a].mesh, self.surfaces[b].mesh)
    }

    /// The first surface of each mesh.
    fn distinct_meshes(&self) -> Vec<usize> {
        let mut first: Vec<usize> = Vec::new();
        for panel in self.panels {
            if !first.iter().any(|&s| self.same_mesh(s, panel.surface)) {
                first.push(panel.surface);
            }
        }
        first
    }

    fn panel(&self, panel: &Panel, body: &Body) -> Value {
        let surface = &self.surfaces[panel.surface];
        let quantity = surface.quantity(panel.shown);
        let colors: Vec<u8> =
            body.vertices.iter().flat_map(|&k| quantity.color(k).map(byte)).collect();
        let regions = surface.regions.as_ref().filter(|_| quantity.cut.is_some());
        let labels: Option<Vec<u8>> =
            regions.map(|regions| body.vertices.iter().map(|&k| regions.label(k) as u8).collect());
        json!({
            "colors": encode(&colors), "labels": labels.as_deref().map(encode),
            "sharp": matches!(panel.shown, Shown::Means | Shown::Labels),
            "cut": quantity.cut.map(|color| color.map(byte)),
        })
    }
}

/// A mesh as the page has it.
struct Body {
    mesh: Mesh,
    /// The vertices of the given mesh that its vertices are.
    vertices: Vec<usize>,
    /// The number of vertices of the given mesh that faces refer to.
    all: usize,
    /// The direction to the viewer, and the up direction.
    view: [[f64; 3]; 2],
}

impl Body {
    /// `None` if there is nothing to show.
    ///
    /// # Errors
    /// Nothing is left of the surface if it is coarsened.
    fn of(stage: &Stage, most: usize) -> Result<Option<Self>> {
        let Some((scene, camera)) = stage.scene_and_camera() else { return Ok(None) };
        let [_, up, towards] = [0, 1, 2].map(|i| camera.axes().row(i).transpose());
        let upright = stage.upright(scene);
        let along: f64 = (0..3).map(|i| upright[i] * towards[i]).sum();
        let up = if along.abs() < STEEP { upright } else { up.into() };

        let all = scene.vertices().len();
        let (mut mesh, mut vertices) = (scene.mesh.clone(), scene.vertices().to_vec());
        if all > most
            && let Some(weld) = Weld::exact(&mesh)
        {
            (mesh, vertices) = part(weld.mesh, weld.of.iter().copied().zip(vertices));
        }
        while mesh.vertices.len() > most {
            let Coarsening { mesh: coarse, parents } = mesh.coarsened();
            let kept =
                parents.iter().zip(vertices).filter(|(parents, _)| parents.weights[0] == 1.0);
            let kept = kept.map(|(parents, k)| (parents.corners[0], k));
            (mesh, vertices) = part(orient(&coarse).mesh, kept);
            if mesh.faces.is_empty() {
                return Err(Error::unsuitable(format!(
                    "the surface of {all} vertices is in too many pieces to be coarsened to {most} for a page; draw it \
                     as a .png file"
                )));
            }
        }
        Ok(Some(Body { mesh, vertices, all, view: [towards.into(), up] }))
    }

    fn json(&self) -> Value {
        let Body { mesh, all, view: [towards, up], .. } = self;
        // From [-1, 1].
        let step = |x: f64| (32767.5 * (x + 1.0)).round().clamp(0.0, 65535.0) as u16;
        let positions = mesh.vertices.iter().flat_map(|x| [x.x, x.y, x.z]).map(step);
        let faces = mesh.faces.iter().flatten().map(|&v| v as u16);
        json!({
            "positions": encode(&positions.flat_map(u16::to_le_bytes).collect::<Vec<_>>()),
            "faces": encode(&faces.flat_map(u16::to_le_bytes).collect::<Vec<_>>()),
            "vertices": all, "view": { "towards": towards, "up": up },
        })
    }
}

/// The part of a mesh that has faces, and the first of the vertices that each of its vertices stands for, given as pairs
/// of a vertex of the mesh and one of those.
fn part(mesh: Mesh, stands_for: impl Iterator<Item = (u32, usize)>) -> (Mesh, Vec<usize>) {
    let mut first = vec![usize::MAX; mesh.vertices.len()];
    for (v, k) in stands_for {
        let first = &mut first[v as usize];
        *first = k.min(*first);
    }
    let mut index = vec![u32::MAX; first.len()];
    let (mut points, mut vertices, mut faces) = (Vec::new(), Vec::new(), mesh.faces);
    for v in faces.iter_mut().flatten() {
        let old = *v as usize;
        if index[old] == u32::MAX {
            index[old] = points.len() as u32;
            points.push(mesh.vertices[old]);
            vertices.push(first[old]);
        }
        *v = index[old];
    }
    (Mesh::new(points, faces), vertices)
}

fn bar(bar: Bar) -> Value {
    let colors = |count: usize, color: &dyn Fn(usize) -> [f64; 3]| -> Vec<[u8; 3]> {
        (0..count).map(|i| color(i).map(byte)).collect()
    };
    match bar {
        Bar::Numbers { range, label } => {
            let stop = |i: usize| sequential(i as f64 / f64::from(STOPS));
            json!({ "colors": colors(STOPS as usize + 1, &stop), "range": range, "label": label })
        }
        Bar::Regions(m) => json!({ "colors": colors(m, &categorical) }),
    }
}

fn byte(color: f64) -> u8 {
    (255.0 * color).round() as u8
}

fn encode(bytes: &[u8]) -> String {
    BASE64_STANDARD.encode(bytes)
}

#[cfg(test)]
mod tests;
