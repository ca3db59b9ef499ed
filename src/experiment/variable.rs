//! What a relation or a table shows of a cell, by the names of the experiment file: a key, or a quantity of its runs.

use std::str::FromStr;

use strum::{EnumMessage, EnumString, IntoStaticStr, VariantNames};

use super::nearest::did_you_mean;

/// A key of the cells, or what their runs reached.
#[derive(Clone, Debug, PartialEq)]
pub enum Variable {
    /// `lambda`, `options.epsilon`.
    Key(String),
    Quantity(Quantity),
}

/// What the runs of a cell reached. Messages list the names in this order; `message` is the label of an axis that shows
/// it, by default the name.
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
    /// (E - D*) / (E* - B), D* the best bound and E* the least energy of all runs of the instance.
    #[strum(message = "energy above the best bound")]
    Excess,
    /// (min E_eps - D*) / (E* - B), the minimum by all runs of the same E_eps.
    #[strum(message = "least smoothed energy above the best bound")]
    Bias,
    /// (E_eps - min E_eps) / (E* - B); of solvers that smooth nothing the excess.
    #[strum(message = "optimization error")]
    OptimizationError,
    /// (R - E) / (E* - B).
    #[strum(message = "rounding error")]
    RoundingError,
    /// To the labels of the run of least energy.
    #[strum(message = "share of labels changed")]
    LabelsChanged,
    /// (R - D) / (D - B).
    #[strum(message = "certified gap of the labels")]
    RoundedGap,
    #[strum(message = "regions that are used")]
    RegionsUsed,
    #[strum(message = "share of vertices that are mislabeled")]
    Mislabeled,
    Status,
}

/// Keys that a cell may have besides its options.
const KEYS: [&str; 9] =
    ["mesh", "data", "noise", "seed", "regions", "lambda", "mass", "solver", "threads"];

/// What begins the keys of options.
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
                "{name:?} is nothing to show; there are {OPTIONS}KEY, {}, {}{meant}",
                KEYS.join(", "),
                quantities.join(", ")
            )
        })
    }
}

impl Variable {
    /// As the file has it.
    pub fn name(&self) -> &str {
        match self {
            Variable::Key(key) => key,
            Variable::Quantity(quantity) => quantity.into(),
        }
    }

    /// Its name, that of an option without what begins them all.
    pub fn short_name(&self) -> &str {
        let name = self.name();
        name.strip_prefix(OPTIONS).unwrap_or(name)
    }

    /// What an axis says.
    pub fn label(&self) -> &str {
        match self {
            Variable::Key(_) => self.short_name(),
            Variable::Quantity(quantity) => quantity.get_message().unwrap_or(quantity.into()),
        }
    }

    pub fn is_key(&self, name: &str) -> bool {
        matches!(self, Variable::Key(key) if key == name)
    }

    /// Whether it differs from machine to machine.
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
    fn variables_are_known_by_their_names() {
        for name in KEYS.iter().chain(Quantity::VARIANTS).chain(&["options.epsilon"]) {
            assert_eq!(name.parse::<Variable>().unwrap().name(), *name);
        }
        let message = "wall-second".parse::<Variable>().unwrap_err();
        assert!(message.starts_with(
            "\"wall-second\" is nothing to show; there are options.KEY, mesh, data, noise, seed, regions, \
             lambda, mass, solver, threads, vertices, faces, iterations, seconds, wall-seconds, energy, bound, gap, \
             excess, bias, optimization-error, rounding-error, labels-changed, rounded-gap, regions-used, mislabeled, \
             status; did you mean \"wall-seconds\"?"
        ));
    }

    #[test]
    fn axes_have_words() {
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
