//! Images stored rotated or mirrored, as phones do, row by row in upright orientation.

use image::metadata::Orientation;

pub struct Upright {
    /// The width of the image as stored.
    pub width: u32,
    pub height: u32,
    /// The transform that makes it upright.
    pub orientation: Orientation,
}

impl Upright {
    /// Width and height of the upright image.
    pub fn size(&self) -> (u32, u32) {
        match self.orientation {
            Orientation::NoTransforms
            | Orientation::Rotate180
            | Orientation::FlipHorizontal
            | Orientation::FlipVertical => (self.width, self.height),
            Orientation::Rotate90
            | Orientation::Rotate270
            | Orientation::Rotate90FlipH
            | Orientation::Rotate270FlipH => (self.height, self.width),
        }
    }

    /// Where pixel (x, y) of the upright image is stored: its column and row. Rotations are clockwise and come before
    /// flips.
    fn stored(&self, x: usize, y: usize) -> (usize, usize) {
        let (right, lower) = (self.width as usize - 1, self.height as usize - 1);
        match self.orientation {
            Orientation::NoTransforms => (x, y),
            Orientation::FlipHorizontal => (right - x, y),
            Orientation::FlipVertical => (x, lower - y),
            Orientation::Rotate180 => (right - x, lower - y),
            Orientation::Rotate90 => (y, lower - x),
            Orientation::Rotate270 => (right - y, x),
            Orientation::Rotate90FlipH => (y, x),
            Orientation::Rotate270FlipH => (right - y, lower - x),
        }
    }

    /// Passes the rows of the upright image to `push`, from top to bottom; each pixel has `channels` bytes.
    pub fn rows(&self, stored: &[u8], channels: usize, mut push: impl FnMut(&[u8])) {
        let width = self.width as usize;
        if self.orientation == Orientation::NoTransforms {
            stored.chunks(width * channels).for_each(push);
            return;
        }
        let (columns, rows) = self.size();
        let mut upright = Vec::with_capacity(columns as usize * channels);
        for y in 0..rows as usize {
            upright.clear();
            for x in 0..columns as usize {
                let (column, row) = self.stored(x, y);
                upright.extend_from_slice(&stored[(row * width + column) * channels..][..channels]);
            }
            push(&upright);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{DynamicImage, RgbImage};

    /// Compared with the image library, which needs a second copy of the image.
    #[test]
    fn every_orientation_is_that_of_the_library() {
        let image = RgbImage::from_fn(3, 2, |x, y| image::Rgb([x as u8, y as u8, 7]));
        for exif in 1..=8 {
            let orientation = Orientation::from_exif(exif).unwrap();
            let mut expected = DynamicImage::ImageRgb8(image.clone());
            expected.apply_orientation(orientation);
            let upright = Upright { width: 3, height: 2, orientation };
            let mut rows = Vec::new();
            upright.rows(image.as_raw(), 3, |row| rows.extend_from_slice(row));
            assert_eq!(upright.size(), (expected.width(), expected.height()), "{exif}");
            assert_eq!(rows, expected.into_rgb8().into_raw(), "{exif}");
        }
    }
}
