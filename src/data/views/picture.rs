//! The pixels of a view.

use std::path::{Path, PathBuf};

use image::ImageReader;

use super::formats::ViewFile;
use super::view::View;
use crate::data::texture::{Decoded, Texels, Turn, decode_file};
use crate::error::{Error, Result};
use crate::file;

/// The files of the image, of the mask and of the background of a view.
#[derive(Clone, Debug)]
pub struct PictureFiles {
    pub image: PathBuf,
    pub mask: Option<PathBuf>,
    pub background: Option<PathBuf>,
}

/// The files of all views: next to the file of the views, whose path is given, or in the folder `images`, where only
/// their last names count if there is no such folder below it.
///
/// # Errors
/// Files that do not exist, in one line.
pub fn locate(file: &Path, views: &ViewFile, images: Option<&Path>) -> Result<Vec<PictureFiles>> {
    let beside = if file.is_dir() { file } else { file.parent().unwrap_or(Path::new("")) };
    let folder = images.unwrap_or(beside);
    let find = |name: &str| {
        let name = PathBuf::from(name.replace('\\', "/"));
        let last = name.file_name().map(|last| folder.join(last));
        let whole = folder.join(&name);
        match last {
            Some(last) if !whole.is_file() && last.is_file() => last,
            _ => whole,
        }
    };
    let files: Vec<PictureFiles> = views
        .views
        .iter()
        .map(|view| PictureFiles {
            image: find(&view.image),
            mask: view.mask.as_deref().map(find),
            background: view.background.as_deref().map(find),
        })
        .collect();
    let all = files.iter().flat_map(|files| {
        std::iter::once(&files.image).chain(&files.mask).chain(&files.background)
    });
    let missing: Vec<&PathBuf> = all.filter(|path| !path.exists()).collect();
    match missing[..] {
        [] => Ok(files),
        [path] => Err(Error::malformed(
            path,
            "does not exist; name the folder of the images with --images",
        )),
        [first, ..] => Err(Error::malformed(
            file,
            format!(
                "{} of its images do not exist, first {}; name their folder with --images",
                missing.len(),
                first.display()
            ),
        )),
    }
}

/// Width and height of an image in pixels, as stored.
///
/// # Errors
/// A file that cannot be read, or is not an image.
pub fn size(path: &Path) -> Result<[u32; 2]> {
    let (file, _) = file::open(path)?;
    let reader = ImageReader::new(file).with_guessed_format();
    let reader = reader.map_err(|error| Error::io(path, error))?;
    let size = reader.into_dimensions();
    size.map(|(width, height)| [width, height])
        .map_err(|_| Error::malformed(path, "is neither a PNG nor a JPEG image"))
}

/// The pixels of one image, row by row, and which of them count.
pub struct Picture {
    /// In pixels.
    pub width: usize,
    /// In pixels.
    pub height: usize,
    texels: Texels,
    /// Whether the mask keeps each pixel, if there is one.
    mask: Option<Vec<bool>>,
}

impl Picture {
    /// Reads the image and the mask of a view.
    ///
    /// # Errors
    /// A file that cannot be decoded, or is not of the size of the camera or of the image.
    pub fn read(files: &PictureFiles, view: &View) -> Result<Self> {
        let (size, texels) = decoded(&files.image)?;
        if let Some(camera) = view.size.filter(|&camera| camera != size) {
            let [w, h] = size;
            return Err(Error::malformed(
                &files.image,
                format!(
                    "has {w} x {h} pixels, but its camera is for {} x {}; give images of that size, or scale K",
                    camera[0], camera[1]
                ),
            ));
        }
        let mask = match &files.mask {
            None => None,
            Some(path) => {
                let (mask_size, mask) = decoded(path)?;
                if mask_size != size {
                    let [[w, h], [iw, ih]] = [mask_size, size];
                    let message =
                        format!("the mask has {w} x {h} pixels, but its image {iw} x {ih}");
                    return Err(Error::malformed(path, message));
                }
                Some(
                    (0..pixels(&mask))
                        .map(|i| color(&mask, i).iter().sum::<f64>() >= 1.5)
                        .collect(),
                )
            }
        };
        let [width, height] = size.map(|n| n as usize);
        Ok(Picture { width, height, texels, mask })
    }

    /// Reads the picture of what is behind the surface in a view, of the size of its image, if it has one.
    ///
    /// # Errors
    /// A file that cannot be decoded, or is of another size.
    pub fn read_background(files: &PictureFiles, image: &Picture) -> Result<Option<Self>> {
        let Some(path) = &files.background else { return Ok(None) };
        let ([w, h], texels) = decoded(path)?;
        let [width, height] = [w as usize, h as usize];
        if [width, height] != [image.width, image.height] {
            let message = format!(
                "the background has {w} x {h} pixels, but its image {} x {}",
                image.width, image.height
            );
            return Err(Error::malformed(path, message));
        }
        Ok(Some(Picture { width, height, texels, mask: None }))
    }

    /// A picture of 8-bit pixels, row by row, without a mask.
    pub fn of_bytes(width: usize, height: usize, bytes: Vec<[u8; 3]>) -> Self {
        Picture { width, height, texels: Texels::Eight(bytes), mask: None }
    }

    /// The same picture with another mask, row by row.
    ///
    /// # Panics
    /// The mask does not have an entry per pixel.
    pub fn with_mask(self, mask: Vec<bool>) -> Self {
        assert_eq!(mask.len(), self.width * self.height);
        Picture { mask: Some(mask), ..self }
    }

    /// A picture of 16-bit pixels without a mask.
    #[cfg(test)]
    pub fn of(width: usize, height: usize, color: impl Fn(usize, usize) -> [f64; 3]) -> Self {
        let pixel = |i: usize| {
            color(i % width, i / width).map(|c| (c * f64::from(u16::MAX)).round() as u16)
        };
        let texels = Texels::Sixteen((0..width * height).map(pixel).collect());
        Picture { width, height, texels, mask: None }
    }

    /// I at a pixel, counted row by row, in [0, 1].
    #[inline(always)]
    pub fn color(&self, pixel: usize) -> [f64; 3] {
        color(&self.texels, pixel)
    }

    /// Whether there is a mask.
    pub fn has_mask(&self) -> bool {
        self.mask.is_some()
    }

    /// Whether the mask leaves the pixel out.
    pub fn is_masked(&self, pixel: usize) -> bool {
        self.mask.as_ref().is_some_and(|mask| !mask[pixel])
    }
}

fn decoded(path: &Path) -> Result<([u32; 2], Texels)> {
    let Decoded { width, height, k, texels } = decode_file(path, Turn::Calibrated)?;
    if k > 0 {
        let message = format!(
            "the image of {width} x {height} pixels is too large for a view; shrink it, and K with it"
        );
        return Err(Error::malformed(path, message));
    }
    Ok(([width, height], texels))
}

fn pixels(texels: &Texels) -> usize {
    match texels {
        Texels::Eight(texels) => texels.len(),
        Texels::Sixteen(texels) => texels.len(),
    }
}

#[inline(always)]
fn color(texels: &Texels, pixel: usize) -> [f64; 3] {
    match texels {
        Texels::Eight(texels) => texels[pixel].map(|c| f64::from(c) / f64::from(u8::MAX)),
        Texels::Sixteen(texels) => texels[pixel].map(|c| f64::from(c) / f64::from(u16::MAX)),
    }
}
