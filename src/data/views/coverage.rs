//! Who saw what: how much of the surface is in how many views, and which pixels count.

use serde::Serialize;

use super::statistics::{PixelCounts, ViewStatistics};
use crate::counted::counted;
use crate::error::{Error, Result};
use crate::unreached::INHERIT;

/// At most this many views are named in a warning.
const MAX_NAMED: usize = 3;

/// A share of pixels that see the back of the surface above which they are reported.
const FEW_BACKS: f64 = 1e-3;

/// How much of the surface and of the images was used.
#[derive(Clone, Debug, Serialize)]
pub struct Coverage {
    /// The format of the file of views.
    pub format: &'static str,
    /// Views in the file.
    pub views: usize,
    /// Views of which at least one pixel counts.
    pub views_used: usize,
    /// Pixels that show the surface and count.
    pub pixels_used: u64,
    /// Pixels that show the surface and do not count.
    pub pixels_left_out: u64,
    /// Share of the area that no pixel sees.
    pub unseen_share: f64,
    /// Share of the area that is in one view only.
    pub in_one_view_share: f64,
    /// Warnings, one sentence each.
    #[serde(skip)]
    pub warnings: Vec<String>,
}

impl Coverage {
    /// One line for the user.
    pub fn sentence(&self) -> String {
        let Coverage { views, views_used, pixels_used, pixels_left_out, .. } = self;
        let left_out = match pixels_left_out {
            0 => String::new(),
            n => format!(" ({n} others are left out)"),
        };
        format!(
            "{views_used} of {views} views ({}) show the surface in {pixels_used} pixels{left_out}; {:.2} % of the area is \
             in no view, {:.2} % in one only",
            self.format,
            100.0 * self.unseen_share,
            100.0 * self.in_one_view_share
        )
    }
}

/// What the views added so far saw.
pub struct Seen {
    /// The number of views that see each vertex.
    by: Vec<u32>,
    views: usize,
    blind: Vec<String>,
    pixels: PixelCounts,
    /// Views with faces behind them, and these faces.
    behind: [usize; 2],
}

impl Seen {
    pub fn new(vertices: usize) -> Self {
        Seen {
            by: vec![0; vertices],
            views: 0,
            blind: Vec::new(),
            pixels: PixelCounts::default(),
            behind: [0; 2],
        }
    }

    pub fn add(&mut self, image: &str, statistics: &ViewStatistics) {
        let ViewStatistics { sums, pixels, behind } = statistics;
        self.views += 1;
        for (by, sums) in self.by.iter_mut().zip(sums) {
            *by += u32::from(sums[0] > 0.0);
        }
        if pixels.used == 0 {
            self.blind.push(image.to_owned());
        }
        if *behind > 0 {
            self.behind[0] += 1;
            self.behind[1] += behind;
        }
        let PixelCounts { used, border, masked, mixed, back, grazing } = &mut self.pixels;
        *used += pixels.used;
        *border += pixels.border;
        *masked += pixels.masked;
        *mixed += pixels.mixed;
        *back += pixels.back;
        *grazing += pixels.grazing;
    }

    /// The report, for the areas of the vertices.
    ///
    /// # Errors
    /// No pixel counts; the message has the reason.
    pub fn coverage(self, format: &'static str, areas: &[f64]) -> Result<Coverage> {
        let PixelCounts { used, border, masked, mixed, back, grazing } = self.pixels;
        let left_out = border + masked + mixed + back + grazing;
        if used == 0 {
            return Err(Error::unsuitable(self.reason(left_out)));
        }
        let share = |views: u32| -> f64 {
            let of_vertices = self.by.iter().zip(areas).filter(|(by, _)| **by == views);
            // An empty sum is -0.
            let area = of_vertices.fold(0.0, |sum, (_, area)| sum + area);
            area / areas.iter().sum::<f64>()
        };
        let (unseen_share, in_one_view_share) = (share(0), share(1));
        let mut warnings = Vec::new();
        if !self.blind.is_empty() {
            let named = self.blind.iter().take(MAX_NAMED).map(String::as_str).collect::<Vec<_>>();
            let more = if self.blind.len() > MAX_NAMED { ", ..." } else { "" };
            warnings.push(format!(
                "{} nothing of the surface: {}{more}",
                counted(self.blind.len(), "view shows", "views show"),
                named.join(", ")
            ));
        }
        if back as f64 > FEW_BACKS * (used + left_out) as f64 {
            warnings.push(format!(
                "{:.1} % of the pixels that show the surface see the back of a face and do not count: the surface is open, \
                 or its faces have different orientations",
                100.0 * back as f64 / (used + left_out) as f64
            ));
        }
        let [views, faces] = self.behind;
        if faces > 0 {
            warnings.push(format!(
                "{} behind {}, which {} left out for; check the units and the poses of the cameras",
                counted(faces, "face reaches", "faces reach"),
                counted(views, "camera", "cameras"),
                if faces == 1 { "it is" } else { "they are" }
            ));
        }
        let unseen = self.by.iter().zip(areas).filter(|(by, area)| **by == 0 && **area > 0.0);
        match unseen.count() {
            0 => {}
            unseen => warnings.push(format!(
                "{} in no view ({:.2} % of the area); {INHERIT}",
                counted(unseen, "vertex is", "vertices are"),
                100.0 * unseen_share
            )),
        }
        Ok(Coverage {
            format,
            views: self.views,
            views_used: self.views - self.blind.len(),
            pixels_used: used,
            pixels_left_out: left_out,
            unseen_share,
            in_one_view_share,
            warnings,
        })
    }

    /// Why no pixel counts.
    fn reason(&self, left_out: u64) -> String {
        let PixelCounts { border, masked, mixed, back, grazing, .. } = self.pixels;
        if left_out == 0 {
            return match self.behind {
                [cameras, _] if cameras == self.views => {
                    "no view shows the surface, which lies behind the cameras; check R and t (x_cam = R x + t, z forward)"
                }
                _ => {
                    "no view shows the surface; check that the cameras and the mesh have the same coordinates"
                }
            }
            .into();
        }
        let reasons = [
            (back, "see the back of the surface, whose faces are oriented inwards; reverse them"),
            (masked, "are dark in the masks, which must be bright where pixels count"),
            (border, "are at the border of the images; lower --border"),
            (mixed, "are not pure; lower --pure, or give larger images"),
            (grazing, "see the surface at a grazing angle; lower --grazing"),
        ];
        let (_, most) =
            reasons.into_iter().max_by_key(|(count, _)| *count).expect("there are five");
        format!("none of the {left_out} pixels that show the surface counts: most {most}")
    }
}
