//! The photographs, and what is behind the surface in them.

use meshseg::data::views::{Picture, View, ViewFolder};
use meshseg::evolve::images::{Background, Shot};
use meshseg::{Error, Result, sweep};

use super::arguments::{Arguments, Behind};

/// At most this many pixels of all images together: each takes 35 bytes.
const MAX_PIXELS: usize = 1 << 28;

/// The photographs of a file of views.
pub struct Photographs {
    pub shots: Vec<Shot>,
    /// What is behind the surface, in words.
    pub background: String,
    /// What was decided, a line each.
    pub notes: Vec<String>,
    /// What was left out, a sentence each.
    pub warnings: Vec<String>,
    pub folder: ViewFolder,
}

impl Photographs {
    /// Reads all images, masks and backgrounds.
    pub fn read(arguments: &Arguments) -> Result<Self> {
        let folder = ViewFolder::open(&arguments.views, arguments.images.as_deref())?;
        let indices: Vec<usize> = (0..folder.views.len()).collect();
        let pictures = sweep::results(indices, |i| folder.picture(i));
        let pictures: Vec<Picture> = pictures.into_iter().collect::<Result<_>>()?;
        let wrong = |message: String| Error::malformed(&arguments.views, message);
        let pixels: usize = pictures.iter().map(|picture| picture.width * picture.height).sum();
        if pixels > MAX_PIXELS {
            let message = format!("{pixels} pixels of all images are too many; shrink them, and K");
            return Err(wrong(message));
        }
        let unmasked = pictures.iter().position(|picture| !picture.has_mask());
        let mut notes = Vec::new();
        let behind = arguments.background.unwrap_or_else(|| match unmasked {
            None if arguments.regions == 1 => Behind::Masks,
            _ => {
                let color = border_color(&pictures);
                let [r, g, b] = color;
                notes.push(format!(
                    "background {r:.3},{g:.3},{b:.3}, the median color at the borders of the images; --background gives another"
                ));
                Behind::Color(color)
            }
        });
        if let (Behind::Masks, Some(i)) = (behind, unmasked) {
            let image = &folder.views[i].image;
            let message = format!("{image} has no mask, but --background masks needs all of them");
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
                            "{} has no background, but --background images needs all of them",
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
