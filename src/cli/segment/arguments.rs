//! The arguments of `meshseg segment`.

use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::str::FromStr;

use nalgebra::Vector3;
use strum::{EnumString, IntoStaticStr, VariantNames};

use crate::data::input::DataSource;
use crate::data::lambertian::Illumination;
use crate::data::projection::{Fit, Projection};
use crate::data::texture::Texel;
use crate::data::{Initial, ModelName};
use crate::labeling::{Baseline, Labeler};
use crate::mesh::Normalize;
use crate::names::Named;
use crate::{Error, Result};

use super::classes::ClassArguments;
use crate::cli::means::{self, Means};
use crate::cli::memory::Memory;
use crate::cli::named;
use crate::cli::solving::Solving;
use crate::cli::views::ViewArguments;

/// Segment colors, textures, an image, curvature, class probabilities or other data on a mesh into regions.
///
/// Region parameters and labels are computed alternately; the final labels are certified for the final parameters.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Mesh file, builtin:spot, or a shape such as torus:400x250
    pub mesh: PathBuf,

    /// colors (of vertices, else of faces or materials, in [0,1]), texture (the images of the materials),
    /// texture:IMAGE (PNG or JPEG, at the texture coordinates, as stored), image:IMAGE (projected onto the surface, see
    /// --project; JPEG photos are turned upright according to their EXIF orientation), curvature (mean curvature by the
    /// cotangent Laplacian, positive where the surface is convex as seen from outside), curvature:mean-quadric (the
    /// same of quadrics fitted to two rings of vertices, for noisy meshes), curvature:gaussian (by the angle defect),
    /// curvature:shape-index (1 on caps, 0.5 on ridges, 0 on saddles, -0.5 in ruts, -1 in cups), or FILE.npy (V or V x
    /// d numbers; uint8 is divided by 255), FILE.gii, FILE.annot or lh.NAME (numbers of GIFTI and FreeSurfer). The middle 96 % of a curvature are mapped to [0,1], the shape index from
    /// [-1,1]. views:FILE has images of calibrated cameras, see Views below [default: the textures or colors that come
    /// with the mesh]
    #[arg(long, value_name = "DATA")]
    pub data: Option<DataSource>,

    /// How image:IMAGE is projected onto the surface: xy, xz, yz; two axes such as x,-z (to the right and upwards in
    /// the image); cylinder or sphere (around z; around another axis as in cylinder:y) [default: by the texture
    /// coordinates of the mesh; xy for a grid]
    #[arg(long, value_name = "AXES", allow_hyphen_values = true)]
    pub project: Option<Projection>,

    /// Fit of an image that is projected along two axes. cover: it keeps its aspect ratio, and what is too long is
    /// cropped at both ends; stretch: it is stretched to fit
    #[arg(long, value_parser = named::<Fit>(), default_value = "cover")]
    pub fit: Fit,

    /// How a vertex samples an image. mean: the mean over its third of its faces; vertex: the color at its position
    #[arg(long, value_parser = named::<Texel>(), default_value = "mean")]
    pub texel: Texel,

    /// Number of regions, 2 to 64; auto:2..8 chooses one of 2 to 8, for which clusters of the data are different, compact
    /// and far from each other (the largest Calinski-Harabasz index on a coarse mesh); auto is short for auto:2..8
    #[arg(long, value_name = "M", allow_negative_numbers = true,
        required_unless_present_any = ["means", "thresholds", "probabilities", "property", "scores", "labels_in"],
        conflicts_with_all = ["means", "thresholds"])]
    pub regions: Option<Regions>,

    /// Model of the data in a region. constant: near a mean, costs are squared distances; l1: near a median except for
    /// outliers, costs are absolute differences, summed over the columns of the data; gaussian: normally distributed
    /// with a mean and a covariance, costs are negative log densities, for regions that differ by their spread as well; histogram: any distribution of
    /// up to three numbers, costs are negative log densities of smoothed histograms; albedo: near an albedo times the
    /// light that falls on the surface, see --light, for shaded colors and views.
    /// Baselines that ignore cuts, scored by the energy and bound of constant for their means: kmeans, the nearest
    /// center of area-weighted k-means; threshold, the classes of least variance of data with one number per vertex
    /// (Otsu's method), or those of --thresholds [default: constant, or that of the parameters]
    #[arg(long, value_parser = named::<Model>())]
    pub model: Option<Model>,

    /// Region parameters that stay as they are: FILE.npy with one row of means (medians for l1) per region, or, for any
    /// model, the summary.json of an earlier run
    #[arg(long, value_name = "FILE", conflicts_with_all = ["every", "init", "thresholds"])]
    pub means: Option<PathBuf>,

    /// Vertices or faces whose regions are given: a .csv file with the header vertex,region or face,region (a face
    /// stands for its corners; for labels of faces a vertex stands for the faces around it), or FILE.npy with one integer per vertex or face, -1 where nothing is given. The labels
    /// agree with them, and so do all labelings that the certificate refers to; the regions start from the data there
    #[arg(long, value_name = "FILE", conflicts_with_all = ["init", "thresholds"])]
    pub seeds: Option<PathBuf>,

    #[command(flatten)]
    pub lighting: Lighting,

    /// Thresholds of --model threshold, ascending, separated by commas
    #[arg(long, value_name = "T,...", value_delimiter = ',', allow_negative_numbers = true)]
    pub thresholds: Vec<f64>,

    /// Weight of the length of the cuts, in units of squared data times length (of data times length for l1, of length
    /// for gaussian and histogram) [default: 0.02 times the variance of the data (half of their mean deviation for l1,
    /// half of their dimension for gaussian and histogram), times the square root of the area, halved until no region is empty on a coarse mesh and
    /// the labels there explain two thirds of what k-means (k-medians for l1, a mixture for gaussian) explains. For class
    /// probabilities: the largest of twelve whose labels, fitted to four fifths of the rows, explain the others as well as the best]
    #[arg(long, allow_negative_numbers = true)]
    pub lambda: Option<f64>,

    /// Iterations between re-estimations of the region parameters
    #[arg(long, value_name = "R", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..), allow_negative_numbers = true)]
    pub every: u64,

    /// Initial region parameters. kmeans: means of clusters (medians for l1; for gaussian a mixture of normal
    /// distributions, fitted from clusters); random: those of random regions
    #[arg(long, value_parser = named::<Initial>(), default_value = "kmeans")]
    pub init: Initial,

    /// Seed of the initial region parameters
    #[arg(long, default_value_t = 0, allow_negative_numbers = true)]
    pub seed: u64,

    /// area: scale the mesh to total area 1, so that lambda means the same for every mesh; none: keep its units
    #[arg(long, value_parser = named::<Normalize>(), default_value = "area")]
    pub normalize: Normalize,

    /// Merge vertices within this distance of each other, in the units of the file, into the first of them [default: 0,
    /// equal positions only]; results refer to the vertices of the file
    #[arg(long, value_name = "TOLERANCE", num_args = 0..=1, default_missing_value = "0", allow_negative_numbers = true)]
    pub weld: Option<f64>,

    /// Keep coincident vertices separate; cuts between them are free
    #[arg(long, conflicts_with = "weld")]
    pub no_weld: bool,

    #[command(flatten)]
    pub classes: ClassArguments,

    #[command(flatten)]
    pub views: ViewArguments,

    #[command(flatten)]
    pub solving: Solving,

    /// What the names of files stand for, if they are in memory.
    #[arg(skip)]
    pub memory: Memory,
}

const EXAMPLES: &str = "\
Examples:
  meshseg segment builtin:spot --regions 3 --out results/spot
  meshseg segment person.ply --regions 4 --lambda 0.005 --out results/person
  meshseg segment bunny.ply --data curvature --regions 3 --out results/bunny
  meshseg segment model.obj --data texture:atlas.png --regions 5 --out results/model
  meshseg segment grid:300x200 --data image:photo.jpg --regions 3 --out results/photo
  meshseg segment bunny.ply --data image:photo.jpg --project xy --regions 3 --out results/bunny
  meshseg segment temple.ply --data views:templeSR_par.txt --regions 4 --out results/temple
  meshseg segment scan.ply --probabilities votes.npy --out results/scan";

/// The light of --model albedo.
#[derive(clap::Args)]
pub struct Lighting {
    /// Direction towards the light of --model albedo, in the axes of the mesh [default: estimated]
    #[arg(
        long,
        value_name = "X,Y,Z",
        value_delimiter = ',',
        num_args = 1,
        allow_hyphen_values = true
    )]
    light: Vec<f64>,

    /// Ambient light of --model albedo, relative to the light [default: estimated]
    #[arg(long, value_name = "A", allow_negative_numbers = true)]
    ambient: Option<f64>,
}

impl Lighting {
    /// The light as far as it is given, for the chosen labeler.
    pub fn illumination(&self, labeler: &Labeler) -> Result<Illumination> {
        let given = [("--light", !self.light.is_empty()), ("--ambient", self.ambient.is_some())];
        if let Some((name, _)) = given.iter().find(|(_, given)| *given) {
            match labeler {
                Labeler::Estimated(ModelName::Albedo) => {}
                Labeler::Given(ModelName::Albedo, _) => {
                    let message = format!("{name}: the given parameters have a light of their own");
                    return Err(Error::unsuitable(message));
                }
                _ => return Err(Error::unsuitable(format!("{name} needs --model albedo"))),
            }
        }
        let light = match self.light[..] {
            [] => None,
            [x, y, z] if [x, y, z].iter().all(|x| x.is_finite()) && [x, y, z] != [0.0; 3] => {
                // Divided by the largest first, so that no square overflows.
                let light = Vector3::new(x, y, z);
                Some((light / light.amax()).normalize())
            }
            _ => {
                return Err(Error::unsuitable(
                    "--light: must be three numbers, not all 0, such as 1,0,2",
                ));
            }
        };
        if let Some(ambient) = self.ambient.filter(|a| !(*a >= 0.0 && a.is_finite())) {
            let message = format!("--ambient {ambient:?}: must be a finite number, at least 0");
            return Err(Error::unsuitable(message));
        }
        // -0 becomes 0.
        Ok(Illumination { light, ambient: self.ambient.map(|ambient| ambient + 0.0) })
    }
}

#[derive(Clone, Copy, PartialEq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "lowercase")]
pub enum Model {
    Constant,
    L1,
    Gaussian,
    Histogram,
    Albedo,
    KMeans,
    Threshold,
}

impl Arguments {
    /// The method that labels the data.
    pub fn labeler(&self) -> Result<Labeler> {
        let named = match self.model {
            Some(Model::KMeans | Model::Threshold) | None => None,
            Some(model) => ModelName::named(model.name()),
        };
        let baseline = self.model.is_some() && named.is_none();
        if baseline && let Some(path) = &self.means {
            let message = "--means does not apply to a baseline, which has means of its own";
            return Err(Error::unsuitable(message).of_file(path));
        }
        if baseline && let Some(path) = &self.seeds {
            let message = "--seeds does not apply to a baseline, whose classes ignore positions";
            return Err(Error::unsuitable(message).of_file(path));
        }
        if !self.thresholds.is_empty() && self.model != Some(Model::Threshold) {
            return Err(Error::unsuitable("--thresholds needs --model threshold"));
        }
        Ok(match (self.model, &self.means) {
            (_, Some(path)) => {
                let Means { model, parameters } = means::read(path, named, &self.memory)?;
                Labeler::Given(model, parameters)
            }
            (Some(Model::KMeans), _) => Labeler::Baseline(Baseline::KMeans { seed: self.seed }),
            (Some(Model::Threshold), _) if self.thresholds.is_empty() => {
                Labeler::Baseline(Baseline::Otsu)
            }
            (Some(Model::Threshold), _) => {
                Labeler::Baseline(Baseline::Thresholds(self.thresholds.clone()))
            }
            _ => Labeler::Estimated(named.unwrap_or_default()),
        })
    }
}

/// The argument of `--regions`.
#[derive(Clone)]
pub enum Regions {
    /// m.
    Number(usize),
    /// One of these.
    Auto(RangeInclusive<usize>),
}

impl FromStr for Regions {
    type Err = &'static str;

    fn from_str(text: &str) -> std::result::Result<Self, Self::Err> {
        let number = |text: &str| {
            let m = text.parse().ok().filter(|m| (2..=64).contains(m));
            m.ok_or("must be a number from 2 to 64, or auto:2..8")
        };
        let Some(range) = text.strip_prefix("auto") else {
            return Ok(Regions::Number(number(text)?));
        };
        if range.is_empty() {
            return Ok(Regions::Auto(2..=8));
        }
        let ends = range.strip_prefix(':').and_then(|range| range.split_once(".."));
        let (low, high) = ends.ok_or("must be a number from 2 to 64, or auto:2..8")?;
        let (low, high) = (number(low)?, number(high)?);
        if low > high {
            return Err("the first number of auto:2..8 must not be above the second");
        }
        Ok(Regions::Auto(low..=high))
    }
}
