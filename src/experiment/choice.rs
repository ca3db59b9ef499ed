//! The choice of the data of an instance.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use crate::data::input::DataSource;
use crate::data::views::CamerasAround;

/// The key `data` of an instance.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DataChoice {
    /// Synthetic: see [`waves`](crate::data::synthetic::waves).
    Waves,
    /// Photographs of a pattern, in which each region has the color of its palette.
    Photographs(CamerasAround),
    /// The texture or the colors of the mesh.
    Own,
    Source(DataSource),
    /// Pointwise costs, V x m or F x m.
    Costs(PathBuf),
    /// Class probabilities, V x m or F x m.
    Probabilities(PathBuf),
    /// Synthetic class probabilities of faces: see [`noisy_scores`](crate::classes::noisy::noisy_scores).
    Classes,
}

impl DataChoice {
    /// Whether it is images on disk with their cameras.
    pub fn is_views(&self) -> bool {
        matches!(self, DataChoice::Source(DataSource::Views(_)))
    }

    /// Whether it has fixed costs, without parameters to estimate.
    pub fn is_costs(&self) -> bool {
        matches!(self, DataChoice::Costs(_)) || self.is_classes()
    }

    /// What it is called in messages about fixed costs.
    pub fn noun(&self) -> &'static str {
        if self.is_classes() { "class probabilities" } else { "costs" }
    }

    /// Whether it is class probabilities.
    pub fn is_classes(&self) -> bool {
        matches!(self, DataChoice::Probabilities(_) | DataChoice::Classes)
    }
}

impl FromStr for DataChoice {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match (text, text.split_once(':')) {
            ("waves", _) => Ok(DataChoice::Waves),
            ("own", _) => Ok(DataChoice::Own),
            ("classes", _) => Ok(DataChoice::Classes),
            (_, Some(("photographs", cameras))) => cameras
                .parse()
                .map(DataChoice::Photographs)
                .map_err(|error| format!("data = \"photographs:N:WxH\": {error}")),
            (_, Some(("costs", file))) if file.ends_with(".npy") => {
                Ok(DataChoice::Costs(file.into()))
            }
            (_, Some(("probabilities", file))) if file.ends_with(".npy") => {
                Ok(DataChoice::Probabilities(file.into()))
            }
            (_, Some(("curvature", _))) => text.parse().map(DataChoice::Source),
            _ => text.parse().map(DataChoice::Source).map_err(|_| {
                "data must be \"waves\", \"photographs:N:WxH\" (of a pattern, by N cameras), \"own\" (the texture or the colors of the mesh), \"colors\", \"texture\", \
                 \"texture:IMAGE\", \"image:IMAGE\", \"views:FILE\" (images of calibrated cameras), \"curvature\", \"curvature:mean-quadric\", \
                 \"curvature:gaussian\", \"curvature:shape-index\", \"classes\" (noisy class probabilities of faces), \
                 \"FILE.npy\", \"costs:FILE.npy\" or \"probabilities:FILE.npy\""
                    .into()
            }),
        }
    }
}

impl fmt::Display for DataChoice {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            DataChoice::Waves => f.write_str("waves"),
            DataChoice::Photographs(cameras) => write!(f, "photographs:{cameras}"),
            DataChoice::Own => f.write_str("own"),
            DataChoice::Source(source) => source.fmt(f),
            DataChoice::Costs(path) => write!(f, "costs:{}", path.display()),
            DataChoice::Probabilities(path) => write!(f, "probabilities:{}", path.display()),
            DataChoice::Classes => f.write_str("classes"),
        }
    }
}
