//! A surface that is ready to be drawn, with its cameras.

use std::sync::Arc;

use image::RgbaImage;
use nalgebra::Vector3;

use super::layout::MARGIN;
use super::shown::Shown;
use super::surface::Surface;
use crate::mesh::Mesh;
use crate::optics::camera::Camera;
use crate::render::normals::corner_normals;
use crate::render::scene::{Ground, Scene};
use crate::render::view::{self, View, default_view};
use crate::sweep;

pub(super) struct Stage<'a> {
    surface: &'a Surface<'a>,
    /// `None` if there is nothing to draw.
    scene: Option<Scene>,
    /// The cameras, and whether the surface is lit.
    cameras: Vec<(Camera, bool)>,
    /// At the corners of each face, if some view is lit.
    normals: Option<Arc<Vec<[Vector3<f32>; 3]>>>,
}

impl<'a> Stage<'a> {
    /// The stages of all surfaces. Those of one mesh or one frame have the cameras of the first of them.
    pub fn all(surfaces: &'a [Surface<'a>], views: &[View]) -> Vec<Self> {
        let mut stages: Vec<Stage> = Vec::with_capacity(surfaces.len());
        for surface in surfaces {
            let same =
                stages.iter().find(|stage| std::ptr::eq(frame(stage.surface), frame(surface)));
            let stage = Stage::new(surface, views, same);
            stages.push(stage);
        }
        stages
    }

    fn new(surface: &'a Surface<'a>, views: &[View], same: Option<&Stage>) -> Self {
        let scene = match &surface.regions {
            Some(regions) => {
                let rows = regions.compared();
                let rows = rows.as_slice().expect("rows are contiguous");
                scene(surface, rows, regions.count())
            }
            None => scene(surface, &vec![0.0; surface.mesh.vertices.len()], 1),
        };
        let mut stage = Stage { surface, scene, cameras: Vec::new(), normals: None };
        let Some(scene) = &stage.scene else { return stage };
        if let Some(Stage { cameras, normals, surface: first, .. }) = same {
            stage.cameras = cameras.clone();
            stage.normals = match std::ptr::eq(first.mesh, surface.mesh) {
                true => normals.clone(),
                false => stage.lit_normals(),
            };
            return stage;
        }
        let framed =
            surface.frame.and_then(|frame| Scene::new(frame, &vec![0.0; frame.vertices.len()], 1));
        let seen = framed.as_ref().unwrap_or(scene);
        let field = seen.field();
        for &view in views {
            let straight = view::straight_on(&seen.mesh).filter(|_| view == View::Auto);
            let lit = straight.is_none();
            let cameras = view::cameras(&seen.mesh, &field, view, straight);
            stage.cameras.extend(cameras.into_iter().map(|camera| (camera, lit)));
        }
        // From one distance, so that perspective does not change the scale.
        let farthest =
            stage.cameras.iter().map(|(camera, _)| camera.distance()).fold(0.0, f64::max);
        for (camera, _) in &mut stage.cameras {
            *camera = camera.clone().at_distance(farthest, &seen.mesh.vertices);
        }
        stage.normals = stage.lit_normals();
        stage
    }

    /// The normals at the corners of each face, if some view is lit.
    fn lit_normals(&self) -> Option<Arc<Vec<[Vector3<f32>; 3]>>> {
        let scene = self.scene.as_ref().filter(|_| self.cameras.iter().any(|(_, lit)| *lit))?;
        Some(Arc::new(corner_normals(&scene.mesh)))
    }

    /// The sizes of the views, in units of length of the mesh in the unit ball.
    pub fn sizes(&self) -> Vec<[f64; 2]> {
        if self.cameras.is_empty() {
            return vec![[2.0; 2]];
        }
        let size = |(camera, _): &(Camera, bool)| camera.extent().map(|x| x * camera.distance());
        self.cameras.iter().map(size).collect()
    }

    /// The mesh in the unit ball and its first camera, if there is anything to draw.
    pub fn scene_and_camera(&self) -> Option<(&Scene, &Camera)> {
        Some((self.scene.as_ref()?, &self.cameras.first()?.0))
    }

    /// The up direction of the mesh or of its frame.
    pub fn upright(&self, scene: &Scene) -> [f64; 3] {
        default_view(self.surface.frame.unwrap_or(&scene.mesh))[1]
    }

    /// The views of each quantity, at a scale in pixels per unit of length.
    pub fn draw(&self, shown: &[Shown], scale: f64) -> Vec<Vec<RgbaImage>> {
        let Some(scene) = self.scene.as_ref().filter(|_| !shown.is_empty()) else {
            return vec![Vec::new(); shown.len()];
        };
        let layer = |&shown: &Shown| self.surface.quantity(shown).layer(scene);
        let layers: Vec<_> = shown.iter().map(layer).collect();
        let field = scene.field();
        let views =
            sweep::results(self.cameras.iter().collect(), |(camera, lit): &(Camera, bool)| {
                let camera = camera.clone().scaled(scale * camera.distance(), MARGIN);
                let normals =
                    self.normals.as_ref().filter(|_| *lit).map(|normals| normals.as_slice());
                scene.draw(&field, &camera, normals, &layers, Ground::Transparent)
            });
        let mut of_quantity = vec![Vec::with_capacity(views.len()); shown.len()];
        for view in views {
            for (pictures, picture) in of_quantity.iter_mut().zip(view) {
                pictures.push(picture);
            }
        }
        of_quantity
    }
}

/// The scene of a surface in its frame.
fn scene(surface: &Surface, rows: &[f64], m: usize) -> Option<Scene> {
    match surface.frame {
        Some(frame) => Scene::within(surface.mesh, rows, m, frame),
        None => Scene::new(surface.mesh, rows, m),
    }
}

/// The mesh whose cameras a surface has.
fn frame<'a>(surface: &Surface<'a>) -> &'a Mesh {
    surface.frame.unwrap_or(surface.mesh)
}
