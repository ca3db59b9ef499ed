//! The picture of a segmentation: the data on the left, the regions and their cut on the right, in one view or two
//! complementary ones, and a legend of the regions below.
//!
//! A software z-buffer with eight samples per pixel, averaged in linear light; each face is shaded once per pixel. Both
//! halves use the same cameras and lights, so that only their colors differ; a flat mesh is viewed straight on and
//! unlit. The same input gives the same bytes. [`panels`] draws pictures for papers by the same code.

mod labels;
mod layer;
mod legend;
mod means;
mod normals;
pub mod panels;
pub mod photographs;
mod region;
mod scene;
mod shading;
mod simplified;
#[cfg(test)]
mod tests;
mod text;
mod view;
pub(crate) mod web;

use crate::mesh::Mesh;
use crate::optics::camera::Camera;
use crate::sweep;
use image::{RgbImage, RgbaImage};
use layer::{Layer, Paint};
use scene::{Ground, Scene};

pub use means::mean_colors;
pub use region::Region;
pub use view::{View, Views, default_view};

/// The maximum width of a half in pixels, and the maximum height of a half with one view.
const HALF_SIZE: f64 = 600.0;
/// The maximum height of a half with two views.
const TWO_VIEW_HEIGHT: f64 = 750.0;
/// Empty pixels around each view.
const MARGIN: f64 = 14.0;
/// The minimum width of a half: captions and legend need some room.
const MIN_HALF_WIDTH: usize = 400;

/// The contents of a picture. Colors are sRGB in [0, 1].
pub struct Picture<'a> {
    /// Of any size, position and orientation. A mesh without area leaves the picture white.
    pub mesh: &'a Mesh,
    /// A color per vertex; gray where NaN.
    pub data: &'a [[f64; 3]],
    /// What these colors show.
    pub caption: &'a str,
    /// m regions, in the order of the columns of U.
    pub regions: &'a [Region],
    /// V x m numbers in row order, such as U, linear on each face: the region at a point is that of the largest.
    pub u: &'a [f64],
    /// From where the mesh is seen.
    pub view: View,
}

impl Picture<'_> {
    /// The picture, at least 800 pixels wide. The same input gives the same bytes, whatever the number of threads.
    pub fn draw(&self) -> RgbImage {
        let colors: Vec<[f64; 3]> = self.regions.iter().map(|region| region.color).collect();
        let scene = Scene::new(self.mesh, self.u, colors.len());
        let halves = scene.map_or_else(
            || [(); 2].map(|()| blank(HALF_SIZE as u32, HALF_SIZE as u32)),
            |scene| {
                let field = scene.field();
                let straight = view::straight_on(&scene.mesh).filter(|_| self.view == View::Auto);
                let lit = straight.is_none();
                let (cameras, normals) = sweep::join(
                    || view::cameras(&scene.mesh, &field, self.view, straight),
                    || lit.then(|| normals::corner_normals(&scene.mesh)),
                );
                let (cameras, side_by_side) = scaled_to_fit(cameras);
                let layers = halves(&scene, self.data, &colors);
                let draw = |camera: &Camera| {
                    let drawn =
                        scene.draw(&field, camera, normals.as_deref(), &layers, Ground::White);
                    drawn.iter().map(opaque).collect::<Vec<_>>()
                };
                let views = sweep::results(cameras.iter().collect(), draw);
                [0, 1].map(|half| {
                    let views: Vec<&RgbImage> = views.iter().map(|view| &view[half]).collect();
                    arranged(&views, side_by_side)
                })
            },
        );
        let width = (halves[0].width() as usize).max(MIN_HALF_WIDTH);
        let legend = legend::Legend::new(self.regions, 2 * width);
        let (top, bottom) = (legend::CAPTION_HEIGHT, legend.height());
        let height = top + halves[0].height() as usize + bottom;
        let mut picture = blank(2 * width as u32, height as u32);
        let captions = [self.caption, "regions"];
        for (i, (half, caption)) in halves.iter().zip(captions).enumerate() {
            let left = i * width + (width - half.width() as usize) / 2;
            copy(half, &mut picture, [left, top]);
            legend::caption(&mut picture, caption, i * width, width);
        }
        legend.draw(&mut picture, height - bottom);
        picture
    }
}

/// The layers of the halves: the data, and the regions with their cut.
fn halves(scene: &Scene, data: &[[f64; 3]], colors: &[[f64; 3]]) -> [Layer; 2] {
    let regions =
        Layer { paint: Paint::regions(colors), cut: Some(layer::linear(layer::CUT_COLOR)) };
    [Layer { paint: scene.colors(data), cut: None }, regions]
}

/// The colors of an image without transparent pixels.
fn opaque(image: &RgbaImage) -> RgbImage {
    let mut colors = RgbImage::new(image.width(), image.height());
    for (to, from) in colors.chunks_exact_mut(3).zip(image.chunks_exact(4)) {
        to.copy_from_slice(&from[..3]);
    }
    colors
}

fn blank(width: u32, height: u32) -> RgbImage {
    RgbImage::from_pixel(width, height, image::Rgb([255; 3]))
}

/// The cameras at a common scale, the largest that fits into a half, and whether two views stand side by side.
fn scaled_to_fit(cameras: Vec<Camera>) -> (Vec<Camera>, bool) {
    let largest = |axis: usize| {
        cameras.iter().map(|camera| camera.extent()[axis]).fold(f64::MIN_POSITIVE, f64::max)
    };
    let count = cameras.len() as f64;
    let scale = |columns: f64, rows: f64, height: f64| {
        let room = |size: f64, parts: f64| size / parts - 2.0 * MARGIN;
        (room(HALF_SIZE, columns) / largest(0)).min(room(height, rows) / largest(1))
    };
    let (horizontal, vertical) = (scale(count, 1.0, HALF_SIZE), scale(1.0, count, TWO_VIEW_HEIGHT));
    let single = count == 1.0;
    let scale = if single || horizontal > vertical { horizontal } else { vertical };
    let cameras = cameras.into_iter().map(|camera| camera.scaled(scale, MARGIN)).collect();
    (cameras, !single && horizontal > vertical)
}

/// The views side by side or stacked, each centered in its cell.
fn arranged(views: &[&RgbImage], side_by_side: bool) -> RgbImage {
    let largest =
        |size: fn(&RgbImage) -> u32| views.iter().map(|view| size(view)).max().unwrap_or(1);
    let (width, height) = (largest(RgbImage::width), largest(RgbImage::height));
    let count = views.len() as u32;
    let (columns, rows) = if side_by_side { (count, 1) } else { (1, count) };
    let mut all = blank(width * columns, height * rows);
    for (i, view) in views.iter().enumerate() {
        let corner = if side_by_side { [i as u32 * width, 0] } else { [0, i as u32 * height] };
        let x = corner[0] + (width - view.width()) / 2;
        let y = corner[1] + (height - view.height()) / 2;
        copy(view, &mut all, [x as usize, y as usize]);
    }
    all
}

/// Copies `from` to a position in `to` where it fits.
fn copy(from: &RgbImage, to: &mut RgbImage, [left, top]: [usize; 2]) {
    let (length, stride) = (3 * from.width() as usize, 3 * to.width() as usize);
    let rows = to.chunks_exact_mut(stride).skip(top);
    for (target, source) in rows.zip(from.chunks_exact(length)) {
        target[3 * left..][..length].copy_from_slice(source);
    }
}
