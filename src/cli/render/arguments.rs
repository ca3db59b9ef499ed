//! The arguments of `meshseg render`.

mod synthetic;

use std::path::{Path, PathBuf};

use crate::data::input::{DataSource, Mapping};
use crate::data::projection::{Fit, Projection};
use crate::data::texture::Texel;
use crate::data::views::ViewOptions;
use crate::render::panels::{PageWidth, Shown};
use crate::sweep::MAX_THREADS;

use super::viewpoints::Viewpoints;
use crate::cli::named;
pub use synthetic::SyntheticArguments;

/// Draw a mesh, or the result of a run, as a picture for print or as a page in 3-D; make photographs of a mesh.
///
/// The picture is a PNG file of 300 dots per inch. It has a panel for each quantity, with captions (a), (b), ... and
/// color bars; all views have the same scale.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A mesh file, builtin:spot, or a shape such as torus:400x250; or the folder of a run: a result folder of segment
    /// or solve, or runs/ID of an experiment
    #[arg(value_name = "MESH|RUN")]
    pub surface: PathBuf,

    /// Quantities, separated by commas. data (a color bar if they are numbers), data+cut (with the boundaries of the
    /// regions in red), means (each region in its mean color), labels (the regions in the colors of the palette), u:P
    /// (the labels U of region P), uncertainty (1 - max_p u_p at the vertices) [default: those of data,means,labels
    /// that are known]
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub show: Vec<Shown>,

    /// Viewpoints, separated by commas: auto (one or two that show the regions; a flat mesh straight on), front, back,
    /// x, -x, y, -y, z, -z, or AZIMUTH,ELEVATION in degrees from the front and the horizon. Or cameras, which make
    /// synthetic photographs (see below): sphere:N:WxH, N cameras all around MESH with images of W x H pixels (640x480 if
    /// they are left out), or FILE, the path of an existing file or folder with cameras as in segment --data views:FILE
    #[arg(
        long,
        value_name = "LIST|FILE|sphere:N",
        default_value = "auto",
        allow_hyphen_values = true
    )]
    pub views: Viewpoints,

    /// Draw the regions of RUN, a run of segment --data views:FILE, into its photographs: the cut in red. --out FILE.png is
    /// a sheet of at most 12 of them; --out DIR is a folder with all of them, regions-000.png, ... in the order of FILE
    #[arg(long, conflicts_with_all = ["show", "views", "u", "labels", "width", "columns", "transparent", "project"])]
    pub photographs: bool,

    /// Folder of the images of views [default: that of FILE]
    #[arg(long, value_name = "DIR")]
    pub images: Option<PathBuf>,

    /// The data of the mesh, as in segment; of a run, those that can be read without its mesh: curvature,
    /// texture:IMAGE, image:IMAGE or FILE.npy [default: those that come with the mesh; of a run, those that were
    /// segmented]
    #[arg(long, value_name = "DATA")]
    pub data: Option<DataSource>,

    /// How image:IMAGE is projected onto the surface, as in segment
    #[arg(long, value_name = "AXES", allow_hyphen_values = true)]
    pub project: Option<Projection>,

    /// Fit of an image that is projected along two axes, as in segment
    #[arg(long, value_parser = named::<Fit>(), default_value = "cover")]
    pub fit: Fit,

    /// How a vertex samples an image, as in segment
    #[arg(long, value_parser = named::<Texel>(), default_value = "mean")]
    pub texel: Texel,

    /// The labels U of the vertices of MESH, V x m numbers
    #[arg(long, value_name = "U.npy", conflicts_with = "labels")]
    pub u: Option<PathBuf>,

    /// The regions of the vertices or of the faces of MESH, V or F integers from 0
    #[arg(long, value_name = "LABELS.npy")]
    pub labels: Option<PathBuf>,

    /// The PNG file; or an HTML file, a page on which the surface can be turned; or the folder of photographs [default:
    /// render.png]
    #[arg(long, value_name = "FILE.png")]
    pub out: Option<PathBuf>,

    /// Width of the picture: millimeters such as 85 or 85mm, or pixels such as 1004px [default: 170mm]
    #[arg(long, value_name = "WIDTH", allow_negative_numbers = true)]
    pub width: Option<PageWidth>,

    /// Number of columns of panels [default: as fits best]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..), allow_negative_numbers = true)]
    pub columns: Option<u8>,

    /// A transparent ground instead of a white one
    #[arg(long)]
    pub transparent: bool,

    /// Number of threads; the picture does not depend on it [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=i64::from(MAX_THREADS)), allow_negative_numbers = true)]
    pub threads: Option<u16>,

    #[command(flatten)]
    pub synthetic: SyntheticArguments,
}

const EXAMPLES: &str = "\
Examples:
  meshseg render results/spot --out spot.png
  meshseg render builtin:spot --u results/spot/u.npy --show data,means,labels --out spot.png
  meshseg render results/spot --out spot.html
  meshseg render results/spot --show labels,u:0,uncertainty --views front,back --out spot-u.png
  meshseg render bunny.ply --data curvature --width 85 --transparent --out bunny.png
  meshseg render spot.obj --views sphere:24:640x480 --labels L.npy --noise 0.1 --out photographs
  meshseg render results/temple --photographs --out temple.png";

impl Arguments {
    /// The output.
    pub fn out(&self) -> &Path {
        self.out.as_deref().unwrap_or(Path::new("render.png"))
    }

    /// Whether the output is a file of this type.
    pub fn out_ends_in(&self, end: &str) -> bool {
        let extension = self.out().extension();
        extension.is_some_and(|extension| extension.eq_ignore_ascii_case(end))
    }

    /// How images are mapped to the mesh.
    pub fn mapping(&self) -> Mapping {
        let Arguments { texel, project, fit, .. } = *self;
        let views = ViewOptions { images: self.images.clone(), ..ViewOptions::default() };
        Mapping { texel, project, fit, views }
    }
}
