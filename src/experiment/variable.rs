//! The variables that relations and tables show: keys of a cell and quantities of its runs.

use std::str::FromStr;

use strum::{EnumMessage, EnumString, IntoStaticStr, VariantNames};

use super::nearest::did_you_mean;

/// A key of the cells, or a quantity of their runs.
#[derive(Clone, Debug, PartialEq)]
pub enum Variable {
    /// `lambda`, `options.epsilon`.
    Key(String),
    Quantity(Quantity),
}

/// A result of the runs of a cell. Messages list the names in this order; `message` is the label of its axis, by
/// default the name.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, EnumString, EnumMessage, IntoStaticStr, VariantNames,
)]
#[strum(serialize_all = "kebab-case")]
pub enum Quantity {
    Vertices,
    Faces,
    Iterations,
    /// Time in steps.
    Seconds,
    /// Time in steps and in rounding.
    #[strum(message = "seconds to the labels")]
    LabelSeconds,
    #[strum(message = "seconds, certificates included")]
    WallSeconds,
    /// E.
    Energy,
    /// D.
    #[strum(message = "lower bound")]
    Bound,
    /// (E - D) / (E - B).
    #[strum(message = "certified gap")]
    Gap,
    /// (E - D*) / (E* - B), D* the best bound and E* the minimum energy of all runs of the instance.
    #[strum(message = "energy above the best bound")]
    Excess,
    /// (min E_eps - D*) / (E* - B), with the minimum over all runs of the same E_eps.
    #[strum(message = "least smoothed energy above the best bound")]
    Bias,
    /// (E_eps - min E_eps) / (E* - B); the excess for solvers without smoothing.
    #[strum(message = "optimization error")]
    OptimizationError,
    /// (R - E) / (E* - B).
    #[strum(message = "rounding error")]
    RoundingError,
    /// Share of labels that differ from those of the run of minimum energy.
    #[strum(message = "share of labels changed")]
    LabelsChanged,
    /// (R - D) / (D - B).
    #[strum(message = "certified gap of the labels")]
    RoundedGap,
    /// (R - L*) / (L* - B), L* the best bound for labels of all runs of the instance.
    #[strum(message = "energy of the labels above the best bound")]
    LabelExcess,
    #[strum(message = "regions that are used")]
    RegionsUsed,
    #[strum(message = "share that is mislabeled")]
    Mislabeled,
    /// Against the right labels, as the next three.
    #[strum(message = "Rand index")]
    RandIndex,
    #[strum(message = "variation of information (bits)")]
    VariationOfInformation,
    #[strum(message = "covering of the truth")]
    Covering,
    /// On grids.
    #[strum(message = "boundary F")]
    BoundaryF,
    /// The share of vertices whose largest u_kp exceeds 0.99.
    #[strum(message = "share of vertices with max u above 0.99")]
    Binary,
    /// The length of the cut.
    #[strum(message = "length of the cut")]
    CutLength,
    /// max_t |E(t) - E| / (E - B) over the thresholds of two regions as labels.
    #[strum(message = "largest error of thresholds as labels")]
    ThresholdLabels,
    /// The same along level lines.
    #[strum(message = "largest error of thresholds along level lines")]
    ThresholdLines,
    /// Of a surface, as those up to the folds.
    Steps,
    /// In shares of the diagonal of the truth, as the next three.
    #[strum(message = "mean distance to the truth / diagonal")]
    Distance,
    /// From the truth to the surface.
    #[strum(message = "mean distance from the truth / diagonal")]
    DistanceBack,
    /// That 95 % of the area do not exceed.
    #[strum(serialize = "distance-95", message = "95th percentile of the distance / diagonal")]
    Distance95,
    #[strum(message = "largest distance / diagonal")]
    LargestDistance,
    #[strum(message = "agreement of silhouettes")]
    SilhouetteIou,
    /// Folded edges and pairs of faces that intersect.
    Folds,
    /// The values of the region parameters in ascending order, where a run estimates them.
    Parameters,
    Status,
}

/// Keys that a cell may have in addition to its options.
const KEYS: [&str; 29] = [
    "mesh",
    "data",
    "on",
    "model",
    "project",
    "background",
    "mask",
    "pattern",
    "light",
    "ambient",
    "principal-error",
    "sampling",
    "pure",
    "grazing",
    "noise",
    "seed",
    "regions",
    "lambda",
    "relaxation",
    "mass",
    "solver",
    "threads",
    "coarse-to-fine",
    "max-iterations",
    "every",
    "init",
    "init-seed",
    "rounding",
    "label-gap",
];

/// The prefix of the keys of options.
const OPTIONS: &str = "options.";

impl FromStr for Variable {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        if name.starts_with(OPTIONS) || KEYS.contains(&name) {
            return Ok(Variable::Key(name.to_owned()));
        }
        name.parse().map(Variable::Quantity).map_err(|_| {
            let quantities = Quantity::VARIANTS;
            let meant = did_you_mean(name, KEYS.iter().chain(quantities).copied());
            format!(
                "{name:?} is not a variable; there are {OPTIONS}KEY, {}, {}{meant}",
                KEYS.join(", "),
                quantities.join(", ")
            )
        })
    }
}

impl Variable {
    /// The name in the experiment file.
    pub fn name(&self) -> &str {
        match self {
            Variable::Key(key) => key,
            Variable::Quantity(quantity) => quantity.into(),
        }
    }

    /// The name, without the prefix of options.
    pub fn short_name(&self) -> &str {
        let name = self.name();
        name.strip_prefix(OPTIONS).unwrap_or(name)
    }

    /// The label of an axis.
    pub fn label(&self) -> &str {
        match self {
            Variable::Key(_) => self.short_name(),
            Variable::Quantity(quantity) => quantity.get_message().unwrap_or(quantity.into()),
        }
    }

    pub fn is_key(&self, name: &str) -> bool {
        matches!(self, Variable::Key(key) if key == name)
    }

    /// Whether it depends on the machine.
    pub fn is_time(&self) -> bool {
        self.is(Quantity::Seconds) || self.is(Quantity::WallSeconds)
    }

    pub fn is(&self, one: Quantity) -> bool {
        *self == Variable::Quantity(one)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_variable_has_the_name_that_is_parsed() {
        for name in KEYS.iter().chain(Quantity::VARIANTS).chain(&["options.epsilon"]) {
            assert_eq!(name.parse::<Variable>().unwrap().name(), *name);
        }
        let message = "wall-second".parse::<Variable>().unwrap_err();
        assert!(message.starts_with(
            "\"wall-second\" is not a variable; there are options.KEY, mesh, data, on, model, project, background, mask, pattern, light, ambient, principal-error, sampling, pure, grazing, noise, \
             seed, regions, lambda, relaxation, mass, solver, threads, coarse-to-fine, max-iterations, every, init, init-seed, rounding, label-gap, vertices, faces, iterations, seconds, label-seconds, wall-seconds, energy, bound, gap, \
             excess, bias, optimization-error, rounding-error, labels-changed, rounded-gap, label-excess, regions-used, mislabeled, \
             rand-index, variation-of-information, covering, boundary-f, binary, cut-length, threshold-labels, \
             threshold-lines, steps, distance, distance-back, distance-95, largest-distance, silhouette-iou, folds, parameters, status; did you mean \"wall-seconds\"?"
        ));
    }

    #[test]
    fn axes_have_labels() {
        for (name, label) in [
            ("options.epsilon", "epsilon"),
            ("lambda", "lambda"),
            ("seconds", "seconds"),
            ("wall-seconds", "seconds, certificates included"),
            ("gap", "certified gap"),
        ] {
            assert_eq!(name.parse::<Variable>().unwrap().label(), label);
        }
    }
}
