//! Photographs of a surface with the cut between its regions drawn into them.
//!
//! The region at a pixel is the argmax of the interpolated U at its center, where a z-buffer finds the nearest face. The
//! cut is drawn in the pixels that show another region than one of their four neighbors does, so that it is two pixels
//! wide. Pixels that show no surface have no region: silhouettes stay as they are, or are drawn as well.

use image::{Rgb, RgbImage};

use super::labels::{LabelField, NO_REGION};
use super::layer::RED;
use super::{blank, copy};
use crate::data::views::{Picture, ViewFolder};
use crate::error::Result;
use crate::mesh::Mesh;
use crate::optics::pinhole::Pinhole;
use crate::optics::zbuffer::ZBuffer;
use crate::sweep;

/// The largest number of views on a sheet.
pub const SHEET_VIEWS: usize = 12;
/// On a sheet, photographs are shrunk by the least integer that brings them to this width and height.
const CELL_SIZE: usize = 420;
/// Pixels between photographs.
const GAP: usize = 6;

/// The regions of a surface, to be drawn into photographs.
pub struct RegionsInViews<'a> {
    mesh: &'a Mesh,
    field: LabelField<'a>,
    silhouettes: bool,
}

impl<'a> RegionsInViews<'a> {
    /// Those of U, V x m in row order, on a mesh in the units of the cameras. Panics if U is not of V rows.
    pub fn new(mesh: &'a Mesh, u: &'a [f64], m: usize) -> Self {
        assert!(m > 0 && u.len() == mesh.vertices.len() * m);
        RegionsInViews { mesh, field: LabelField::new(mesh, u, m), silhouettes: false }
    }

    /// The same with the silhouettes of the surface, in white on black.
    pub fn with_silhouettes(self) -> Self {
        RegionsInViews { silhouettes: true, ..self }
    }

    /// A photograph with the cut in red, in its full size.
    pub fn draw(&self, camera: &Pinhole, picture: &Picture) -> RgbImage {
        self.draw_shrunk(camera, picture, 1)
    }

    /// At most [`SHEET_VIEWS`] views in a grid, evenly chosen, row by row in the order of the views.
    ///
    /// # Errors
    /// An image cannot be read, or is not of the size of its camera.
    pub fn sheet(&self, folder: &ViewFolder) -> Result<RgbImage> {
        let drawn = sweep::results(on_sheet(folder), |i: usize| {
            let picture = folder.picture(i)?;
            let k = picture.width.max(picture.height).div_ceil(CELL_SIZE);
            Ok(self.draw_shrunk(&folder.views[i].camera, &picture, k))
        });
        Ok(grid(&drawn.into_iter().collect::<Result<Vec<_>>>()?))
    }

    /// Photographs in memory in such a grid, all of them.
    pub fn grid(&self, views: &[(Pinhole, &Picture)]) -> RgbImage {
        let drawn = sweep::results(views.to_vec(), |(camera, picture): (Pinhole, &Picture)| {
            let k = picture.width.max(picture.height).div_ceil(CELL_SIZE);
            self.draw_shrunk(&camera, picture, k)
        });
        grid(&drawn)
    }

    /// The photograph shrunk to the means of k x k pixels, then with the cut.
    fn draw_shrunk(&self, camera: &Pinhole, picture: &Picture, k: usize) -> RgbImage {
        let mut image = shrunk(picture, k);
        let (width, height) = (image.width() as usize, image.height() as usize);
        let zbuffer = ZBuffer::new(self.mesh, &camera.scaled(1.0 / k as f64), [width, height], 1);
        let region = |pixel: usize| {
            let Some(j) = zbuffer.face(pixel) else { return NO_REGION };
            let at = || self.field.region_at(j, &zbuffer.on_face(j, pixel % width, pixel / width));
            self.field.face_region(j).unwrap_or_else(at)
        };
        let regions: Vec<u32> = (0..width * height).map(region).collect();
        let mut mark = |a: usize, b: usize| {
            let color = |pixel: usize| match [regions[a], regions[b]].contains(&NO_REGION) {
                false => RED.map(byte),
                // Seen on every ground.
                true if regions[pixel] == NO_REGION => [0; 3],
                true => [255; 3],
            };
            let silhouette = [regions[a], regions[b]].contains(&NO_REGION);
            if regions[a] != regions[b] && (self.silhouettes || !silhouette) {
                for pixel in [a, b] {
                    let (x, y) = ((pixel % width) as u32, (pixel / width) as u32);
                    image.put_pixel(x, y, Rgb(color(pixel)));
                }
            }
        };
        for pixel in 0..width * height {
            if (pixel + 1) % width != 0 {
                mark(pixel, pixel + 1);
            }
            if pixel + width < width * height {
                mark(pixel, pixel + width);
            }
        }
        image
    }
}

/// The views on a sheet.
fn on_sheet(folder: &ViewFolder) -> Vec<usize> {
    let all = folder.views.len();
    let count = all.min(SHEET_VIEWS);
    (0..count).map(|i| i * all / count).collect()
}

/// The number of pixels that a sheet reads.
///
/// # Errors
/// The size of an image is not known, and it cannot be read.
pub fn sheet_pixels(folder: &ViewFolder) -> Result<u64> {
    let pixels = |i: usize| folder.size(i).map(|[w, h]| u64::from(w) * u64::from(h));
    on_sheet(folder).into_iter().map(pixels).sum()
}

/// The means of k x k pixels; incomplete ones at the right and at the bottom are left out.
fn shrunk(picture: &Picture, k: usize) -> RgbImage {
    let [width, height] = [picture.width, picture.height].map(|n| (n / k).max(1));
    RgbImage::from_fn(width as u32, height as u32, |x, y| {
        let mut sum = [0.0; 3];
        let rows = y as usize * k..((y as usize + 1) * k).min(picture.height);
        let columns = x as usize * k..((x as usize + 1) * k).min(picture.width);
        for row in rows.clone() {
            for column in columns.clone() {
                let color = picture.color(row * picture.width + column);
                sum.iter_mut().zip(color).for_each(|(sum, c)| *sum += c);
            }
        }
        Rgb(sum.map(|sum| byte(sum / (rows.len() * columns.len()) as f64)))
    })
}

fn byte(c: f64) -> u8 {
    (255.0 * c).round() as u8
}

/// The images in a grid of about as many rows as columns, each in the middle of its cell, on white.
fn grid(images: &[RgbImage]) -> RgbImage {
    in_columns(images, (1..).find(|n| n * n >= images.len()).unwrap_or(1).max(1))
}

/// Pictures one below the other, each in the middle of its cell, on white.
pub fn below_each_other(images: &[RgbImage]) -> RgbImage {
    in_columns(images, 1)
}

fn in_columns(images: &[RgbImage], columns: usize) -> RgbImage {
    let largest = |size: fn(&RgbImage) -> u32| images.iter().map(size).max().unwrap_or(1) as usize;
    let cell = [largest(RgbImage::width), largest(RgbImage::height)];
    let rows = images.len().div_ceil(columns).max(1);
    let [width, height] =
        [(columns, cell[0]), (rows, cell[1])].map(|(n, size)| (n * (size + GAP) - GAP) as u32);
    let mut sheet = blank(width, height);
    for (i, image) in images.iter().enumerate() {
        let [x, y] = [0, 1].map(|axis| {
            let (at, size) = if axis == 0 {
                (i % columns, image.width())
            } else {
                (i / columns, image.height())
            };
            at * (cell[axis] + GAP) + (cell[axis] - size as usize) / 2
        });
        copy(image, &mut sheet, [x, y]);
    }
    sheet
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;
    use crate::data::views::{Ball, around};
    use crate::samples::{disjoint, shape};

    fn one_hot(labels: impl Iterator<Item = usize>, m: usize) -> Vec<f64> {
        labels.flat_map(|label| (0..m).map(move |p| f64::from(u8::from(p == label)))).collect()
    }

    const GRAY: [u8; 3] = [100; 3];

    fn gray(width: usize, height: usize) -> Picture {
        Picture::of_bytes(width, height, vec![GRAY; width * height])
    }

    fn camera() -> Pinhole {
        let ball = Ball { center: Point3::origin(), radius: 1.0 };
        around(&ball, 1, 4.0, [80, 60]).unwrap()[0].camera
    }

    /// The coordinates of the red pixels; all others are gray.
    fn red(image: &RgbImage) -> Vec<[u32; 2]> {
        let marked = image.enumerate_pixels().filter(|(_, _, pixel)| pixel.0 != GRAY);
        marked
            .map(|(x, y, pixel)| {
                assert_eq!(pixel.0, [230, 0, 0]);
                [x, y]
            })
            .collect()
    }

    /// On a sphere whose left half is region 0, the cut is the two middle columns, from the top of the disk to its
    /// bottom, and nothing else is drawn; a single region has no cut.
    #[test]
    fn the_cut_is_two_pixels_wide() {
        let mesh = shape("sphere:4");
        let left: Vec<f64> = mesh.vertices.iter().flat_map(|x| [-x.x, x.x]).collect();
        let drawn = RegionsInViews::new(&mesh, &left, 2).draw(&camera(), &gray(80, 60));
        let found = red(&drawn);
        assert!(found.iter().all(|[x, _]| (39..=40).contains(x)), "{found:?}");
        // The disk has the radius 27.
        assert!((2 * 53..=2 * 54).contains(&found.len()), "{}", found.len());
        let alone = one_hot(mesh.vertices.iter().map(|_| 0), 2);
        assert!(
            red(&RegionsInViews::new(&mesh, &alone, 2).draw(&camera(), &gray(80, 60))).is_empty()
        );
    }

    /// A small sphere of another region in front of a large one is outlined, and behind it is not seen.
    #[test]
    fn hidden_regions_are_not_drawn() {
        let large = shape("sphere:4").scaled(0.8);
        let n = large.vertices.len();
        for (z, shown) in [(0.9, true), (-0.9, false)] {
            let mut small = shape("sphere:3").scaled(0.1);
            small.vertices.iter_mut().for_each(|x| x.z += z);
            let mesh = disjoint([large.clone(), small]);
            let u = one_hot((0..mesh.vertices.len()).map(|k| usize::from(k >= n)), 2);
            let found = red(&RegionsInViews::new(&mesh, &u, 2).draw(&camera(), &gray(80, 60)));
            assert_eq!(!found.is_empty(), shown);
            assert!(found.iter().all(|&[x, y]| x.abs_diff(39) < 6 && y.abs_diff(29) < 6));
        }
    }

    /// The camera of a shrunk photograph sees the same: the cut is at half the coordinates.
    #[test]
    fn shrunk_photographs_keep_their_regions() {
        let mesh = shape("sphere:4");
        let left: Vec<f64> = mesh.vertices.iter().flat_map(|x| [-x.x - 0.3, x.x + 0.3]).collect();
        let regions = RegionsInViews::new(&mesh, &left, 2);
        let whole = red(&regions.draw(&camera(), &gray(80, 60)));
        let half = regions.draw_shrunk(&camera(), &gray(80, 60), 2);
        assert_eq!((half.width(), half.height()), (40, 30));
        let middle = whole.iter().filter(|[_, y]| *y == 30).map(|[x, _]| x / 2);
        let found: Vec<u32> =
            red(&half).into_iter().filter(|[_, y]| *y == 15).map(|[x, _]| x).collect();
        assert!(middle.into_iter().all(|x| found.contains(&x)), "{found:?}");
        let odd = shrunk(&gray(7, 5), 3);
        assert_eq!((odd.width(), odd.height(), odd.get_pixel(1, 0).0), (2, 1, GRAY));
        assert_eq!(shrunk(&gray(2, 9), 3).dimensions(), (1, 3));
    }

    #[test]
    fn grids_have_a_cell_for_each_image() {
        let image = |width, height| RgbImage::from_pixel(width, height, Rgb(GRAY));
        for (count, columns, rows) in [(1, 1, 1), (2, 2, 1), (4, 2, 2), (5, 3, 2), (12, 4, 3)] {
            let sheet = grid(&vec![image(10, 8); count]);
            assert_eq!(sheet.dimensions(), (16 * columns - 6, 14 * rows - 6));
            let dark = sheet.pixels().filter(|pixel| pixel.0 == GRAY).count();
            assert_eq!(dark, 80 * count);
        }
        let mixed = grid(&[image(10, 4), image(6, 8)]);
        assert_eq!((mixed.dimensions(), mixed.get_pixel(0, 2).0), ((26, 8), GRAY));
        assert_eq!(mixed.get_pixel(17, 0).0, [255; 3]);
    }
}
