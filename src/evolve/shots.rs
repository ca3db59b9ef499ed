//! The photographs of a file of views, and what is behind the surface in them.

use std::path::Path;
use std::str::FromStr;

use super::images::{Background, Shot};
use crate::data::views::{MaskRule, Picture, View, ViewFolder};
use crate::error::{Error, Result};
use crate::sweep;
use crate::triple::Triple;

/// At most this many pixels of all images together: each takes 35 bytes.
const MAX_PIXELS: usize = 1 << 28;

/// What is behind the surface, as a text `R,G,B`, `images` or `masks`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Behind {
    /// A color.
    Color([f64; 3]),
    /// The image `background` of each view.
    Images,
    /// Black, and the masks replace the images.
    Masks,
}

impl FromStr for Behind {
    type Err = &'static str;

    fn from_str(text: &str) -> std::result::Result<Self, Self::Err> {
        match text {
            "images" => Ok(Behind::Images),
            "masks" => Ok(Behind::Masks),
            _ => match text.parse() {
                Ok(Triple(color)) if color.iter().all(|c| (0.0..=1.0).contains(c)) => {
                    Ok(Behind::Color(color))
                }
                _ => {
                    Err("must be three numbers from 0 to 1, such as 0.9,0.9,0.9, images, or masks")
                }
            },
        }
    }
}

/// The photographs of a file of views.
pub struct Photographs {
    /// One per view.
    pub shots: Vec<Shot>,
    /// What is behind the surface, in words.
    pub background: String,
    /// What was decided, a line each.
    pub notes: Vec<String>,
    /// What was left out, a sentence each.
    pub warnings: Vec<String>,
    /// The files.
    pub folder: ViewFolder,
}

impl Photographs {
    /// Reads all images, masks and backgrounds of the file `path`, whose images may be in another folder. A rule, if there is
    /// one, makes the masks. Without `behind` the background is the masks for one region if all views have masks, else the
    /// median color at the borders.
    ///
    /// # Errors
    /// Files that cannot be read, masks or backgrounds that are missing, too many pixels.
    pub fn read(
        path: &Path,
        images: Option<&Path>,
        behind: Option<Behind>,
        rule: Option<&MaskRule>,
        regions: usize,
    ) -> Result<Self> {
        let folder = ViewFolder::open(path, images)?;
        let indices: Vec<usize> = (0..folder.views.len()).collect();
        let pictures = sweep::results(indices, |i| {
            let picture = folder.picture(i)?;
            Ok(match rule.map(|rule| rule.mask(&picture)) {
                Some(mask) => picture.with_mask(mask),
                None => picture,
            })
        });
        let pictures: Vec<Picture> = pictures.into_iter().collect::<Result<_>>()?;
        let wrong = |message: String| Error::malformed(path, message);
        let pixels: usize = pictures.iter().map(|picture| picture.width * picture.height).sum();
        if pixels > MAX_PIXELS {
            let message = format!("{pixels} pixels of all images are too many; shrink them, and K");
            return Err(wrong(message));
        }
        let unmasked = pictures.iter().position(|picture| !picture.has_mask());
        let mut notes = Vec::new();
        let behind = behind.unwrap_or_else(|| match unmasked {
            None if regions == 1 => Behind::Masks,
            _ => {
                let color = border_color(&pictures);
                let [r, g, b] = color;
                notes.push(format!(
                    "background {r:.3},{g:.3},{b:.3}, the median color at the borders of the images, unless another is given"
                ));
                Behind::Color(color)
            }
        });
        if let (Behind::Masks, Some(i)) = (behind, unmasked) {
            let image = &folder.views[i].image;
            let message =
                format!("{image} has no mask, but the background masks needs all of them");
            return Err(wrong(message));
        }
        let shot = |(i, picture): (usize, Picture)| {
            let view: View = folder.views[i].clone();
            let background = match behind {
                Behind::Color(color) => Background::Color(color),
                Behind::Masks => Background::Mask,
                Behind::Images => match folder.background(i, &picture)? {
                    Some(background) => Background::Picture(background),
                    None => {
                        let message = format!(
                            "{} has no background, but the background images needs all of them",
                            view.image
                        );
                        return Err(wrong(message));
                    }
                },
            };
            Ok(Shot { view, picture, background })
        };
        let shots = pictures.into_iter().enumerate().map(shot).collect::<Result<_>>()?;
        let background = match behind {
            Behind::Color([r, g, b]) => format!("{r},{g},{b}"),
            Behind::Images => "images".into(),
            Behind::Masks => "masks".into(),
        };
        let warnings = folder.warnings.clone();
        Ok(Photographs { shots, background, notes, warnings, folder })
    }
}

/// The median of each channel over the pixels at the borders of all images.
fn border_color(pictures: &[Picture]) -> [f64; 3] {
    let mut channels: [Vec<f64>; 3] = Default::default();
    for picture in pictures {
        let [width, height] = [picture.width, picture.height];
        let rows = (0..width).flat_map(|x| [x, (height - 1) * width + x]);
        let columns = (0..height).flat_map(|y| [y * width, y * width + width - 1]);
        for pixel in rows.chain(columns) {
            let color = picture.color(pixel);
            channels.iter_mut().zip(color).for_each(|(channel, c)| channel.push(c));
        }
    }
    channels.map(|mut channel| {
        let middle = channel.len() / 2;
        *channel.select_nth_unstable_by(middle, f64::total_cmp).1
    })
}
