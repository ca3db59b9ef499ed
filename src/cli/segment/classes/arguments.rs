//! The options of class probabilities.

use std::path::{Path, PathBuf};

use meshseg::classes::costs::DEFAULT_FLOOR;
use meshseg::domain::Element;
use meshseg::{Error, Result};

use crate::cli::named;

/// How sure labels are by default.
const DEFAULT_CONFIDENCE: f64 = 0.9;

/// Options that belong to other data.
const OTHER_DATA: [&str; 11] = [
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
];

#[derive(clap::Args)]
#[command(
    next_help_heading = "Class probabilities, as of a network or of votes, in place of --data and --regions"
)]
pub struct ClassArguments {
    /// Probabilities of m classes, or numbers of votes for them, one row per vertex or face: FILE.npy, FILE.npz (one array, or
    /// one named `probabilities`) or FILE.csv. Costs are -log(p), rows of zeros or NaN are unknown and take the labels of their
    /// neighbors
    #[arg(long, value_name = "FILE", conflicts_with_all = OTHER_DATA, conflicts_with_all = ["scores", "labels_in"])]
    probabilities: Option<PathBuf>,

    /// Scores such as the logits of a network, in the same layout (in FILE.npz named `scores`); their softmax is taken
    #[arg(long, value_name = "FILE", conflicts_with_all = OTHER_DATA, conflicts_with = "labels_in")]
    scores: Option<PathBuf>,

    /// Labels to be smoothed: one integer per vertex or face, from 0; -1 or NaN where nothing is known
    #[arg(long, value_name = "FILE", conflicts_with_all = OTHER_DATA)]
    labels_in: Option<PathBuf>,

    /// The least probability: one vote against all others costs at most -log(P) [default: 1e-6]
    #[arg(long, value_name = "P", allow_negative_numbers = true, conflicts_with = "labels_in")]
    floor: Option<f64>,

    /// The probability that a given label is right [default: 0.9]
    #[arg(long, value_name = "C", allow_negative_numbers = true, requires = "labels_in")]
    confidence: Option<f64>,

    /// A label that means unknown, besides -1; can be repeated
    #[arg(long, value_name = "LABEL", allow_negative_numbers = true, requires = "labels_in")]
    unknown: Vec<i64>,

    /// Where labels are. vertices: the cut runs through faces; faces: along edges, and with two classes the labels are optimal
    /// [default: where the probabilities are]. Labels of both are written
    #[arg(long, value_parser = named::<Element>())]
    on: Option<Element>,

    /// Names and colors of the classes: a table FILE.csv with the header name or name,color, or FILE.toml with a [[class]]
    /// each; a color is written as #rrggbb
    #[arg(long, value_name = "FILE")]
    classes: Option<PathBuf>,
}

/// What is given of the classes.
pub enum Given {
    /// The file of probabilities.
    Probabilities(PathBuf),
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
            Given::Probabilities(path) | Given::Scores(path) | Given::Labels(path) => path,
        }
    }

    /// What it holds.
    pub fn what(&self) -> &'static str {
        match self {
            Given::Probabilities(_) => "probabilities",
            Given::Scores(_) => "scores",
            Given::Labels(_) => "labels",
        }
    }
}

impl ClassArguments {
    /// What is given, if anything is.
    pub fn given(&self) -> Option<Given> {
        let ClassArguments { probabilities, scores, labels_in, .. } = self;
        let probabilities = probabilities.clone().map(Given::Probabilities);
        let scores = || scores.clone().map(Given::Scores);
        probabilities.or_else(scores).or_else(|| labels_in.clone().map(Given::Labels))
    }

    /// Fails if an option is given that other data do not have.
    pub fn check_unused(&self) -> Result<()> {
        let ClassArguments { floor, on, classes, .. } = self;
        let given = [
            ("--floor", floor.is_some()),
            ("--on", on.is_some()),
            ("--classes", classes.is_some()),
        ];
        match given.iter().find(|(_, given)| *given) {
            None => Ok(()),
            Some((name, _)) => Err(Error::unsuitable(format!(
                "{name} needs --probabilities, --scores or --labels-in"
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

    /// The file of names and colors.
    pub fn list(&self) -> Option<&Path> {
        self.classes.as_deref()
    }
}
