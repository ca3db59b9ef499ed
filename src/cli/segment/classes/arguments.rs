//! The options of class probabilities.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::classes::Cleaning;
use crate::classes::costs::DEFAULT_FLOOR;
use crate::domain::Element;
use crate::mesh::Mesh;
use crate::{Error, Result};

use crate::cli::named;

/// How sure labels are by default.
const DEFAULT_CONFIDENCE: f64 = 0.9;

/// Options that belong to other data.
const OTHER_DATA: [&str; 13] = [
    "data",
    "project",
    "fit",
    "texel",
    "regions",
    "model",
    "means",
    "thresholds",
    "every",
    "init",
    "light",
    "ambient",
    "seed",
];

#[derive(clap::Args)]
#[command(
    next_help_heading = "Class probabilities, as of a network or of votes, in place of --data and --regions"
)]
pub struct ClassArguments {
    /// Probabilities of m classes, or numbers of votes for them, one row per vertex or face: FILE.npy, FILE.npz (one array, or
    /// one named `probabilities`) or FILE.csv, or FILE.func.gii with m arrays. Costs are -log(p), rows of zeros or NaN are unknown and take the labels of their
    /// neighbors
    #[arg(long, value_name = "FILE", conflicts_with_all = OTHER_DATA,
        conflicts_with_all = ["property", "scores", "labels_in"])]
    probabilities: Option<PathBuf>,

    /// The same in numeric properties of the vertices or faces of a PLY mesh: those with this name, where * stands for any
    /// characters, as in p_*, in the order of the file
    #[arg(long, value_name = "NAME", conflicts_with_all = OTHER_DATA, conflicts_with_all = ["scores", "labels_in"])]
    property: Option<String>,

    /// Scores such as the logits of a network, in the same layout (in FILE.npz named `scores`); their softmax is taken
    #[arg(long, value_name = "FILE", conflicts_with_all = OTHER_DATA, conflicts_with = "labels_in")]
    scores: Option<PathBuf>,

    /// Labels to be smoothed: one integer per vertex or face, from 0; -1 or NaN where nothing is known. FILE.label.gii has
    /// the keys of its labels (unknown: ???), FILE.annot their rows in its table
    #[arg(long, value_name = "FILE", conflicts_with_all = OTHER_DATA)]
    labels_in: Option<PathBuf>,

    /// The least probability: one vote against all others costs at most -log(P) [default: 1e-6]
    #[arg(long, value_name = "P", allow_negative_numbers = true, conflicts_with = "labels_in")]
    floor: Option<f64>,

    /// The probability that a given label is right [default: 0.9]
    #[arg(long, value_name = "C", allow_negative_numbers = true, requires = "labels_in",
        conflicts_with_all = ["probabilities", "property", "scores"])]
    confidence: Option<f64>,

    /// A label that means unknown, besides -1; can be repeated
    #[arg(long, value_name = "LABEL", allow_negative_numbers = true, requires = "labels_in",
        conflicts_with_all = ["probabilities", "property", "scores"])]
    unknown: Vec<i64>,

    /// Where labels are. vertices: the cut runs through faces; faces: along edges, and with two classes the labels are optimal
    /// [default: where the probabilities are]. Labels of both are written
    #[arg(long, value_parser = named::<Element>())]
    on: Option<Element>,

    /// The part of the surface that counts: FILE.npy or FILE.csv with one number per vertex or face, 0 where it is left out. What is left out
    /// has the label -1
    #[arg(long, value_name = "FILE")]
    mask: Option<PathBuf>,

    /// Where cuts are cheap. normals: at creases, lambda times exp(-a^2 / 2 s^2) for an angle a between two faces and s = 30
    /// degrees; colors: where the colors of the mesh change, exp(-d^2 / 2 s^2) for a difference d and its root mean square s;
    /// both at least 0.05. FILE.npy or FILE.csv: a positive weight per face, by which lambda is multiplied
    #[arg(long, value_name = "normals|colors|FILE")]
    edge_aware: Option<EdgeAware>,

    /// In the end, parts of labels with a smaller area take the label of a neighbor: in squared units of the file, or a share
    /// of the surface such as 0.1%. What this changes in energy is reported
    #[arg(long, value_name = "AREA", allow_negative_numbers = true)]
    min_area: Option<Area>,

    /// In the end, parts of labels with a smaller area that lie within one other label take that label
    #[arg(long, value_name = "AREA", allow_negative_numbers = true)]
    fill_holes: Option<Area>,

    /// In the end, each connected component of the surface gets the one label that costs least in total
    #[arg(long)]
    components: bool,

    /// Names and colors of the classes: a table FILE.csv with the header name or name,color, or FILE.toml with a [[class]]
    /// each; a color is written as #rrggbb
    #[arg(long, value_name = "FILE")]
    classes: Option<PathBuf>,
}

/// The argument of `--edge-aware`.
#[derive(Clone)]
pub enum EdgeAware {
    Normals,
    Colors,
    File(PathBuf),
}

impl EdgeAware {
    /// As in the summary.
    pub fn name(&self) -> String {
        match self {
            EdgeAware::Normals => "normals".into(),
            EdgeAware::Colors => "colors".into(),
            EdgeAware::File(path) => path.display().to_string(),
        }
    }
}

impl FromStr for EdgeAware {
    type Err = &'static str;

    fn from_str(text: &str) -> std::result::Result<Self, Self::Err> {
        Ok(match text {
            "normals" => EdgeAware::Normals,
            "colors" => EdgeAware::Colors,
            "" => return Err("must be normals, colors or a file of weights"),
            file => EdgeAware::File(file.into()),
        })
    }
}

/// An area.
#[derive(Clone, Copy)]
pub enum Area {
    /// In squared units of the file.
    Absolute(f64),
    /// A share of the surface.
    Share(f64),
}

impl FromStr for Area {
    type Err = &'static str;

    fn from_str(text: &str) -> std::result::Result<Self, Self::Err> {
        let message =
            "must be a positive number, in squared units of the file, or a share such as 0.1%";
        let number = |text: &str| {
            text.trim().parse().ok().filter(|x: &f64| *x > 0.0 && x.is_finite()).ok_or(message)
        };
        match text.strip_suffix('%') {
            Some(share) => Ok(Area::Share(number(share)? / 100.0)),
            None => number(text).map(Area::Absolute),
        }
    }
}

impl Area {
    /// In squared units of a mesh that was scaled by a factor.
    fn on(self, mesh: &Mesh, scale: f64) -> f64 {
        match self {
            Area::Absolute(area) => area * scale * scale,
            Area::Share(share) => share * mesh.area(),
        }
    }
}

/// What is given of the classes.
pub enum Given {
    /// The file of probabilities.
    Probabilities(PathBuf),
    /// The mesh whose properties these are, and their name.
    Property(PathBuf, String),
    /// The file of scores.
    Scores(PathBuf),
    /// The file of labels.
    Labels(PathBuf),
}

impl Given {
    /// The least probability, if there is one.
    pub fn floor(&self, arguments: &ClassArguments) -> Option<f64> {
        match self {
            Given::Labels(_) => None,
            _ => Some(arguments.floor.unwrap_or(DEFAULT_FLOOR)),
        }
    }

    /// How sure labels are.
    pub fn confidence(&self, arguments: &ClassArguments) -> Option<f64> {
        match self {
            Given::Labels(_) => Some(arguments.confidence.unwrap_or(DEFAULT_CONFIDENCE)),
            _ => None,
        }
    }

    /// The file.
    pub fn path(&self) -> &Path {
        match self {
            Given::Probabilities(path)
            | Given::Property(path, _)
            | Given::Scores(path)
            | Given::Labels(path) => path,
        }
    }

    /// What it holds.
    pub fn what(&self) -> &'static str {
        match self {
            Given::Probabilities(_) | Given::Property(..) => "probabilities",
            Given::Scores(_) => "scores",
            Given::Labels(_) => "labels",
        }
    }
}

impl ClassArguments {
    /// What is given, if anything is; properties are those of the mesh.
    pub fn given(&self, mesh: &Path) -> Option<Given> {
        let ClassArguments { probabilities, property, scores, labels_in, .. } = self;
        let property = property.clone().map(|name| Given::Property(mesh.to_owned(), name));
        let all = [
            probabilities.clone().map(Given::Probabilities),
            property,
            scores.clone().map(Given::Scores),
            labels_in.clone().map(Given::Labels),
        ];
        all.into_iter().flatten().next()
    }

    /// Fails if an option is given that other data do not have.
    pub fn check_unused(&self) -> Result<()> {
        let ClassArguments { floor, on, classes, edge_aware, min_area, fill_holes, .. } = self;
        let given = [
            ("--floor", floor.is_some()),
            ("--on", on.is_some()),
            ("--classes", classes.is_some()),
            ("--mask", self.mask.is_some()),
            ("--edge-aware", edge_aware.is_some()),
            ("--min-area", min_area.is_some()),
            ("--fill-holes", fill_holes.is_some()),
            ("--components", self.components),
        ];
        match given.iter().find(|(_, given)| *given) {
            None => Ok(()),
            Some((name, _)) => Err(Error::unsuitable(format!(
                "{name} needs --probabilities, --property, --scores or --labels-in"
            ))),
        }
    }

    /// Labels that mean unknown.
    pub fn unknown(&self) -> &[i64] {
        &self.unknown
    }

    /// Where labels are, if it is given.
    pub fn on(&self) -> Option<Element> {
        self.on
    }

    /// What counts of the surface, if it is given.
    pub fn mask(&self) -> Option<&Path> {
        self.mask.as_deref()
    }

    /// Where cuts are cheap, if it is given.
    pub fn edge_aware(&self) -> Option<&EdgeAware> {
        self.edge_aware.as_ref()
    }

    /// What is done to labels of a mesh that was scaled by a factor.
    pub fn cleaning(&self, mesh: &Mesh, scale: f64) -> Cleaning {
        Cleaning {
            min_area: self.min_area.map(|area| area.on(mesh, scale)),
            fill_holes: self.fill_holes.map(|area| area.on(mesh, scale)),
            one_per_component: self.components,
        }
    }

    /// The file of names and colors.
    pub fn list(&self) -> Option<&Path> {
        self.classes.as_deref()
    }
}
