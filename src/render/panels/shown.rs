//! What a panel shows, and its names.

use std::fmt;
use std::str::FromStr;

/// A quantity on a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// The data; with `cut`, the boundaries of the regions on top, in red.
    Data {
        /// Whether the cut is drawn.
        cut: bool,
    },
    /// Each region in its mean color, with the cut in red.
    Means,
    /// The regions in the colors of the palette, with the cut.
    Labels,
    /// Column p of U, from 0 to 1.
    Column(usize),
    /// 1 - max_p u_p at the vertices, from 0 to 1 - 1/m.
    Uncertainty,
}

impl Shown {
    /// The forms that [`Shown::from_str`] takes.
    pub const SYNTAX: &str = "data, data+cut, means, labels, u:P or uncertainty";

    /// The caption of a panel that shows it.
    pub fn caption(self) -> String {
        match self {
            Shown::Data { cut: false } => "data".into(),
            Shown::Data { cut: true } => "data and cut".into(),
            Shown::Means => "region means".into(),
            Shown::Labels => "regions".into(),
            Shown::Column(p) => format!("u of region {p}"),
            Shown::Uncertainty => "uncertainty".into(),
        }
    }

    /// Whether it needs regions.
    pub fn needs_regions(self) -> bool {
        self != Shown::Data { cut: false }
    }
}

impl FromStr for Shown {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match (text, text.split_once(':')) {
            ("data", _) => Ok(Shown::Data { cut: false }),
            ("data+cut", _) => Ok(Shown::Data { cut: true }),
            ("means", _) => Ok(Shown::Means),
            ("labels", _) => Ok(Shown::Labels),
            ("uncertainty", _) => Ok(Shown::Uncertainty),
            (_, Some(("u", p))) => p
                .parse()
                .map(Shown::Column)
                .map_err(|_| "the P of u:P must be the number of a region, such as u:0".to_owned()),
            _ => Err(format!("must be {}", Shown::SYNTAX)),
        }
    }
}

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Shown::Data { cut: false } => f.write_str("data"),
            Shown::Data { cut: true } => f.write_str("data+cut"),
            Shown::Means => f.write_str("means"),
            Shown::Labels => f.write_str("labels"),
            Shown::Column(p) => write!(f, "u:{p}"),
            Shown::Uncertainty => f.write_str("uncertainty"),
        }
    }
}
