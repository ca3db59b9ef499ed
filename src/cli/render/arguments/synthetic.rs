//! The options of synthetic photographs.

use std::path::PathBuf;

use crate::triple::Triple;
use crate::{Error, Result};

/// The options of synthetic photographs.
#[derive(clap::Args)]
#[command(
    next_help_heading = "Synthetic photographs (--views sphere:N or --views FILE). --out is a folder: view-000.png, ..., \
and views.toml with the cameras, which segment --data views:DIR/views.toml reads. A vertex has the color of the data, or \
that of its label (--labels), which reaches as far as it is the nearest corner of its face"
)]
pub struct SyntheticArguments {
    /// Colors of the labels: FILE.npy with three numbers from 0 to 1 per region, or the summary.json of an earlier run
    /// [default: those of the palette]
    #[arg(long, value_name = "FILE")]
    pub means: Option<PathBuf>,

    /// Direction towards the light: colors are multiplied by A + max(0, N.L), L of length 1 and N the normals of the
    /// vertices [default: no light]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub light: Option<Triple>,

    /// A, the ambient light [default: 0 with --light, 1 without]
    #[arg(long, value_name = "A", allow_negative_numbers = true)]
    pub ambient: Option<f64>,

    /// Standard deviation of the normally distributed noise of each channel of each pixel. Colors are clipped to [0, 1] when
    /// they are stored in 8 bits, noise included [default: 0]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub noise: Option<f64>,

    /// Seed of the noise [default: 0]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub noise_seed: Option<u64>,

    /// Color where no ray meets the mesh, in [0, 1] [default: 0.5,0.5,0.5]
    #[arg(long, value_name = "R,G,B", allow_hyphen_values = true)]
    pub background: Option<Triple>,

    /// A pixel is the mean of S x S samples [default: 4]
    #[arg(long, value_name = "S", value_parser = clap::value_parser!(u8).range(1..=16), allow_negative_numbers = true)]
    pub samples: Option<u8>,
}

impl SyntheticArguments {
    /// Fails if one of them is given for a picture.
    pub fn check_unused(&self) -> Result<()> {
        let given = [
            ("--means", self.means.is_some()),
            ("--light", self.light.is_some()),
            ("--ambient", self.ambient.is_some()),
            ("--noise", self.noise.is_some()),
            ("--noise-seed", self.noise_seed.is_some()),
            ("--background", self.background.is_some()),
            ("--samples", self.samples.is_some()),
        ];
        match given.iter().find(|(_, given)| *given) {
            Some((name, _)) => {
                let message = format!("{name} needs cameras: --views sphere:N or --views FILE");
                Err(Error::unsuitable(message))
            }
            None => Ok(()),
        }
    }
}
