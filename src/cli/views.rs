//! `--data views:FILE`: which pixels count, and what is reported of them.

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::data::input::{DataSource, InputData};
use crate::data::views::{Coverage, PixelWeights, ViewOptions};
use crate::labeling::Labeler;
use crate::mesh::geometry::barycentric_areas;
use crate::names::Named;
use crate::operator::Mass;
use crate::solve::{Request, Solution};
use crate::{Error, Mesh, Result};

use super::{named, note};

/// The options of views.
#[derive(clap::Args)]
#[command(
    next_help_heading = "Views: images of calibrated cameras (--data views:FILE). FILE has a [[view]] with image, \
K, R and t per camera (TOML), or is a Middlebury _par.txt, an OpenMVS .mvs or the folder of a COLMAP text model"
)]
pub struct ViewArguments {
    /// Folder of the images [default: that of FILE]
    #[arg(long, value_name = "DIR")]
    images: Option<PathBuf>,

    /// What a pixel weighs. pixel: all the same; angle: the area on the normalized image plane, so that cameras of
    /// different focal lengths count the same; unit: a vertex weighs its area, and its pixels their mean, for errors
    /// that do not average out [default: pixel]
    #[arg(long, value_parser = named::<PixelWeights>())]
    weights: Option<PixelWeights>,

    /// Use only pixels with the surface, and no jump of depth, in the R - 1 rings of pixels around them: 2 leaves out
    /// mixed colors at silhouettes [default: 1, all pixels]
    #[arg(long, value_name = "R", value_parser = clap::value_parser!(u8).range(1..), allow_negative_numbers = true)]
    pure: Option<u8>,

    /// Use only rays that meet the surface at a cosine of at least C with its normal; 0.2 suits inexact poses [default: 0]
    #[arg(long, value_name = "C", allow_negative_numbers = true)]
    grazing: Option<f64>,

    /// Leave out B pixels at each border of the images [default: 0]
    #[arg(long, value_name = "B", allow_negative_numbers = true)]
    border: Option<u32>,

    /// Samples per pixel and axis; more than 1 helps if faces are smaller than pixels [default: 1]
    #[arg(long, value_name = "S", value_parser = clap::value_parser!(u8).range(1..=16), allow_negative_numbers = true)]
    samples: Option<u8>,
}

impl ViewArguments {
    /// The folder of the images, if it is given.
    pub fn images(&self) -> Option<&Path> {
        self.images.as_deref()
    }

    /// The options for the chosen data.
    pub fn options(&self, data: Option<&DataSource>) -> Result<ViewOptions> {
        let ViewArguments { images, weights, pure, grazing, border, samples } = self;
        let given = [
            ("--images", images.is_some()),
            ("--weights", weights.is_some()),
            ("--pure", pure.is_some()),
            ("--grazing", grazing.is_some()),
            ("--border", border.is_some()),
            ("--samples", samples.is_some()),
        ];
        let has_views = matches!(data, Some(DataSource::Views(_)));
        if let Some((name, _)) = given.iter().find(|(_, given)| *given && !has_views) {
            return Err(Error::unsuitable(format!("{name} needs --data views:FILE")));
        }
        if let Some(c) = grazing.filter(|c| !(0.0..1.0).contains(c)) {
            let message = format!("--grazing {c:?}: must be a cosine, at least 0 and below 1");
            return Err(Error::unsuitable(message));
        }
        let default = ViewOptions::default();
        Ok(ViewOptions {
            images: images.clone(),
            weights: weights.unwrap_or(default.weights),
            samples: samples.map_or(default.samples, usize::from),
            pure: pure.map_or(default.pure, usize::from),
            grazing: grazing.unwrap_or(default.grazing),
            border: border.map_or(default.border, |border| border as usize),
        })
    }
}

/// Checks that the data can be integrated as requested.
pub fn check(data: Option<&DataSource>, request: &Request) -> Result<()> {
    if matches!(data, Some(DataSource::Views(_))) && request.mass != Mass::Barycentric {
        return Err(Error::unsuitable(format!(
            "--mass {}: views are integrated over their pixels; leave --mass out",
            request.mass.name()
        )));
    }
    Ok(())
}

/// Notes that a model sees the means of pixels only.
pub fn note_means(input: &InputData, labeler: &Labeler) {
    if input.evidence.is_some() && !["constant", "albedo"].contains(&labeler.name()) {
        note(&format!(
            "{} sees the mean color of the pixels of each vertex; only constant and albedo see every pixel",
            labeler.name()
        ));
    }
}

/// What `summary.json` says of the views.
#[derive(Serialize)]
pub struct ViewSummary<'a> {
    #[serde(flatten)]
    coverage: &'a Coverage,
    weights: &'static str,
    /// The mean of max_p u_kp over the area that no pixel sees, where the data say nothing of it.
    unseen_max_u: Option<f64>,
}

impl<'a> ViewSummary<'a> {
    /// For the solution on the mesh of the data; `None` if these are not views.
    pub fn of(
        solution: &Solution,
        input: &'a InputData,
        mesh: &Mesh,
        arguments: &ViewArguments,
    ) -> Option<Self> {
        let coverage = input.coverage.as_ref()?;
        let (mut total, mut sum) = (0.0, 0.0);
        for (k, area) in barycentric_areas(mesh).into_iter().enumerate() {
            if !input.data.is_known(k) {
                total += area;
                sum += area * solution.u.row(k).iter().fold(0.0, |most: f64, &u| most.max(u));
            }
        }
        let unseen_max_u = (total > 0.0).then(|| sum / total);
        let weights = arguments.weights.unwrap_or_default().name();
        Some(ViewSummary { coverage, weights, unseen_max_u })
    }
}
