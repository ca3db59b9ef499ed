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
    /// Pointwise costs, V x m.
    Costs(PathBuf),
}

impl DataChoice {
    /// Whether it is images on disk with their cameras.
    pub fn is_views(&self) -> bool {
        matches!(self, DataChoice::Source(DataSource::Views(_)))
    }
}

impl FromStr for DataChoice {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match (text, text.split_once(':')) {
            ("waves", _) => Ok(DataChoice::Waves),
            ("own", _) => Ok(DataChoice::Own),
            (_, Some(("photographs", cameras))) => cameras
                .parse()
                .map(DataChoice::Photographs)
                .map_err(|error| format!("data = \"photographs:N:WxH\": {error}")),
            (_, Some(("costs", file))) if file.ends_with(".npy") => {
                Ok(DataChoice::Costs(file.into()))
            }
            (_, Some(("curvature", _))) => text.parse().map(DataChoice::Source),
            _ => text.parse().map(DataChoice::Source).map_err(|_| {
                "data must be \"waves\", \"photographs:N:WxH\" (of a pattern, by N cameras), \"own\" (the texture or the colors of the mesh), \"colors\", \"texture\", \
                 \"texture:IMAGE\", \"image:IMAGE\", \"views:FILE\" (images of calibrated cameras), \"curvature\", \"curvature:mean-quadric\", \
                 \"curvature:gaussian\", \"curvature:shape-index\", \"FILE.npy\" or \"costs:FILE.npy\""
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
        }
    }
}
