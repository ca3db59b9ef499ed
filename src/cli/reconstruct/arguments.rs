//! The arguments of `meshseg reconstruct`.

use std::path::PathBuf;

use nalgebra::Vector3;
use strum::{EnumString, IntoStaticStr, VariantNames};

use crate::evolve::shots::Behind;
use crate::evolve::start;
use crate::evolve::{Light, Plan};
use crate::render::View;
use crate::sweep::MAX_THREADS;
use crate::triple::Triple;
use crate::{Error, Result};

use crate::cli::named;

/// Reconstruct a surface and its regions from photographs of calibrated cameras.
///
/// A start surface evolves until it looks like its photographs: regions of constant color in front of a known background.
/// Labels, colors and surface take turns, on coarse meshes and images first. The labels are certified for the last
/// surface; the surface is a local minimum, and its topology stays that of the start.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The cameras and their images, as in segment --data views:FILE
    #[arg(long, value_name = "FILE")]
    pub views: PathBuf,

    /// Folder of the images [default: that of FILE]
    #[arg(long, value_name = "DIR")]
    pub images: Option<PathBuf>,

    /// Number of regions, 1 to 64; 1 with masks reconstructs from silhouettes alone
    #[arg(long, value_name = "M", value_parser = clap::value_parser!(u8).range(1..=64), allow_negative_numbers = true)]
    pub regions: u8,

    /// The surface that evolves. sphere: a sphere in the middle of what the cameras see; sphere:CX,CY,CZ,R: with this
    /// center and radius; box: a box around the same; hull: the visual hull of the masks, which has holes where they show
    /// some; MESH: a mesh file or a shape, in the units of the cameras
    #[arg(long, value_name = "START", default_value = "sphere", allow_hyphen_values = true)]
    pub start: start::Choice,

    /// What is behind the surface. R,G,B: a color, three numbers from 0 to 1; images: the image `background` of each view
    /// in FILE; masks: black, and the masks replace the images. Pixels that a mask leaves out show the background
    /// [default: masks for one region if all views have masks, else the median color at the borders of the images]
    #[arg(long, value_name = "COLOR|images|masks", allow_hyphen_values = true)]
    pub background: Option<Behind>,

    /// Levels: after each but the last the mesh is refined, and the images are less shrunk
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u8).range(1..=8), allow_negative_numbers = true)]
    pub levels: u8,

    /// Maximum number of steps on each level
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u16).range(1..), allow_negative_numbers = true)]
    pub steps: u16,

    /// Weight of the roughness: larger for smoother surfaces, smaller for thin parts and sharp edges, which it rounds off
    #[arg(long, value_name = "ETA", default_value_t = Plan::default().eta, allow_negative_numbers = true)]
    pub roughness: f64,

    /// beta of the metric, in which first steps are smooth: larger for smoother and safer steps, 0 for the steps of each
    /// vertex alone
    #[arg(long, value_name = "BETA", default_value_t = Plan::default().beta, allow_negative_numbers = true)]
    pub metric: f64,

    /// Between levels, divide only the edges longer than F times the median, and flip edges; 1.3 suits surfaces with
    /// details of different sizes [default: every face is divided into four]
    #[arg(long, value_name = "F", num_args = 0..=1, default_missing_value = "1.3", allow_negative_numbers = true)]
    pub split: Option<f64>,

    /// Model of the colors in a region. constant: near one color from all sides; albedo: near an albedo times the light of
    /// --light
    #[arg(long, value_parser = named::<Model>(), default_value = "constant")]
    pub model: Model,

    /// Direction towards the light of --model albedo, in the axes of the cameras
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub light: Option<Triple>,

    /// Ambient light of --model albedo, relative to the light
    #[arg(long, value_name = "A", allow_negative_numbers = true)]
    pub ambient: Option<f64>,

    /// Weight of the length of the cuts, as in segment, for a surface scaled to area 1
    #[arg(long, value_name = "X", default_value_t = Plan::default().lambda, allow_negative_numbers = true)]
    pub lambda: f64,

    /// The true surface: distances to it are reported
    #[arg(long, value_name = "MESH")]
    pub truth: Option<PathBuf>,

    /// Seed of the first colors
    #[arg(long, default_value_t = 0, allow_negative_numbers = true)]
    pub seed: u64,

    /// Number of threads; the result does not depend on it [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=i64::from(MAX_THREADS)), allow_negative_numbers = true)]
    pub threads: Option<u16>,

    /// Folder for the results; written whole after each level
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,

    /// Viewpoint of preview.png, as in segment
    #[arg(
        long,
        value_name = "VIEW",
        default_value = "auto",
        allow_hyphen_values = true,
        hide_default_value = true
    )]
    pub view: View,

    /// Write neither preview.png nor views.png
    #[arg(long)]
    pub no_preview: bool,
}

const EXAMPLES: &str = "\
Examples:
  meshseg render builtin:spot --views sphere:24:320x240 --background 0.9,0.9,0.9 --out photographs
  meshseg reconstruct --views photographs/views.toml --regions 4 --out results/spot
  meshseg reconstruct --views photographs/views.toml --regions 4 --truth builtin:spot --out results/spot
  meshseg reconstruct --views masks.toml --regions 1 --background masks --start hull --out results/hull
  meshseg reconstruct --views masks.toml --regions 4 --start results/hull/mesh.ply --levels 1 --out results/colors";

#[derive(Clone, Copy, PartialEq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "lowercase")]
pub enum Model {
    Constant,
    Albedo,
}

impl Arguments {
    /// The request to the library.
    pub fn plan(&self) -> Result<Plan> {
        Ok(Plan {
            regions: self.regions.into(),
            levels: self.levels.into(),
            steps: self.steps.into(),
            lambda: self.lambda,
            eta: self.roughness,
            beta: self.metric,
            split: self.split,
            light: self.lit()?,
            seed: self.seed,
            ..Plan::default()
        })
    }

    fn lit(&self) -> Result<Option<Light>> {
        let fail = |message: &str| Err(Error::unsuitable(message));
        if self.model == Model::Constant {
            return match (self.light.is_some(), self.ambient.is_some()) {
                (true, _) => fail("--light needs --model albedo"),
                (_, true) => fail("--ambient needs --model albedo"),
                _ => Ok(None),
            };
        }
        let Some(Triple(direction)) = self.light else {
            return fail("--model albedo needs the direction towards the light: --light X,Y,Z");
        };
        let ambient = self.ambient.unwrap_or(0.0);
        if !(ambient >= 0.0 && ambient.is_finite()) {
            return fail("--ambient: must be a finite number, at least 0");
        }
        let direction = Vector3::from(direction);
        if !(direction.amax().is_normal() && direction.amax().is_finite()) {
            return fail("--light: must be three numbers, not all 0, such as 1,0,2");
        }
        // Divided by the largest first, so that no square overflows.
        let direction = (direction / direction.amax()).normalize();
        Ok(Some(Light { direction, ambient }))
    }
}
