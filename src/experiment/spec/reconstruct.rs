//! `name = "reconstruct"`: a surface that evolves until it looks like the photographs of an instance.

use std::ops::Range;

use strum::{EnumString, IntoStaticStr, VariantNames};

use super::super::choice::DataChoice;
use super::super::document::{Scalar, SpanError, SpanResult, Spanned};
use super::super::nearest::did_you_mean;
use super::cell::Cell;
use super::instance::{InstanceCell, LambdaChoice};
use crate::data::ModelName;
use crate::evolve::start::Choice;
use crate::evolve::{Plan, shots};

/// The name of this solver.
pub const RECONSTRUCT: &str = "reconstruct";

/// Its options.
const OPTIONS: [&str; 8] =
    ["start", "levels", "steps", "roughness", "metric", "split", "background", "gradient"];

/// How a surface evolves.
#[derive(Clone, Debug)]
pub struct Evolution {
    /// Where it starts.
    pub start: Choice,
    /// Levels of mesh and images.
    pub levels: usize,
    /// The largest number of steps on each.
    pub steps: usize,
    /// eta.
    pub roughness: f64,
    /// beta.
    pub metric: f64,
    /// Longer edges than this many times the median are divided; `None` if all faces are divided into four.
    pub split: Option<f64>,
    /// Whether pixels that do not show the surface count.
    pub background: Behind,
    /// Which parts the gradient has.
    pub gradient: Gradient,
}

/// The option `background`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "lowercase")]
pub enum Behind {
    /// Pixels that do not show the surface are compared with the background.
    Known,
    /// They count nothing.
    None,
}

/// The option `gradient`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "lowercase")]
pub enum Gradient {
    /// All parts.
    Full,
    /// Contours alone move the surface.
    Contour,
}

impl Evolution {
    /// The request to the library, without what the instance says.
    pub fn plan(&self) -> Plan {
        Plan {
            levels: self.levels,
            steps: self.steps,
            eta: self.roughness,
            beta: self.metric,
            split: self.split,
            background: self.background == Behind::Known,
            interior: self.gradient == Gradient::Full,
            ..Plan::default()
        }
    }

    /// Reads the options of a cell, which has no keys but these and `threads`.
    pub(super) fn read(cell: &Cell<'_>) -> SpanResult<Self> {
        for (key, given) in cell.0 {
            let message = match key.strip_prefix("options.") {
                Some(option) if OPTIONS.contains(&option) => continue,
                Some(option) => {
                    let meant = did_you_mean(option, OPTIONS);
                    let known = OPTIONS.join(", ");
                    format!("{RECONSTRUCT} has no option {option:?}; there are {known}{meant}")
                }
                None if ["solver", "threads"].contains(&key.as_str()) => continue,
                None => format!(
                    "{key} does not apply to {RECONSTRUCT}, which has the key threads and options"
                ),
            };
            return Err(SpanError::at(&given.span, message));
        }
        let plan = Plan::default();
        let count = |key: &str, default: usize, most: u64| {
            cell.count(key, default as u64, 1..=most).map(|count| count as usize)
        };
        Ok(Evolution {
            start: match cell.text("options.start")? {
                None => Choice::Sphere(None),
                Some((text, span)) => text
                    .parse()
                    .map_err(|message| SpanError::at(span, format!("start {message}")))?,
            },
            levels: count("options.levels", plan.levels, 8)?,
            steps: count("options.steps", plan.steps, 65_535)?,
            roughness: cell.number("options.roughness", plan.eta, 0.0)?,
            metric: cell.number("options.metric", plan.beta, 0.0)?,
            split: match cell.get("options.split") {
                None => None,
                // To be swept with and without.
                Some(Spanned { value: Scalar::Boolean(false), .. }) => None,
                Some(_) => Some(cell.number("options.split", 1.0, 1.0)?),
            },
            background: cell.named("options.background", Behind::Known)?,
            gradient: cell.named("options.gradient", Gradient::Full)?,
        })
    }
}

/// Keys of an instance that say nothing of a reconstruction.
const UNUSED: [&str; 7] = ["project", "truth", "sampling", "pure", "grazing", "relaxation", "mass"];

impl InstanceCell {
    /// Why it cannot be reconstructed, and where the file says so.
    pub(super) fn hinders_reconstruction(&self) -> Option<(Range<usize>, String)> {
        let is_photographs = matches!(self.data, DataChoice::Photographs(_));
        let unused = self.keys.iter().find(|(key, _)| UNUSED.contains(&key.as_str()));
        let message = if !(is_photographs || self.data.is_views()) {
            "a reconstruction needs data = \"photographs:N:WxH\" or \"views:FILE\"".into()
        } else if let Some((key, _)) = unused {
            format!("{key} does not apply to a reconstruction: leave it out")
        } else if !matches!(self.model, ModelName::Constant | ModelName::Albedo) {
            "a reconstruction has the model \"constant\" or \"albedo\"".into()
        } else if self.model == ModelName::Albedo && self.photography.light.is_none() {
            "a reconstruction with the model \"albedo\" needs photographs with a light, which it knows"
                .into()
        } else if matches!(self.lambda, LambdaChoice::Auto(_)) {
            "a reconstruction needs a number as lambda".into()
        } else if self.background == Some(shots::Behind::Masks) && self.regions > 1 {
            "masks have one region: regions must be 1".into()
        } else {
            return None;
        };
        Some((self.data_span.clone(), message))
    }

    /// Why it is for reconstructions only, and where the file says so.
    pub(super) fn is_for_reconstruction(&self) -> Option<(Range<usize>, String)> {
        let message = if self.mesh.is_none() {
            "without mesh there is nothing but a reconstruction"
        } else if self.regions == 1 {
            "one region is for reconstructions alone"
        } else if (self.background.is_some() && self.data.is_views()) || self.mask.is_some() {
            "background and mask of views are for reconstructions alone"
        } else {
            return None;
        };
        Some((self.data_span.clone(), message.into()))
    }
}
