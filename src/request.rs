//! The request to a solver, and the observer of its steps.

use std::ops::ControlFlow;

use crate::error::{Error, Result};
use crate::operator::Mass;
use crate::relaxation::Relaxation;
use crate::rounding::Rounding;
use crate::run::{Sample, Stop};
use crate::solver::Method;

/// The request to a solver, in addition to the costs.
#[derive(Clone, Debug)]
pub struct Request {
    /// Weight of the total variation, in units of cost times length.
    pub lambda: f64,
    /// The relaxation of the labels.
    pub relaxation: Relaxation,
    /// The quadrature of the data term.
    pub mass: Mass,
    /// The solver, with its settings.
    pub method: Method,
    /// When the run ends, unless the observer ends it earlier.
    pub stop: Stop,
    /// Start from solutions on successively coarser meshes; see `coarse.rs`.
    pub coarse_to_fine: bool,
    /// Keep the dual field of the best bound in [`crate::solve::Solution::q`].
    pub keep_dual: bool,
    /// How U is rounded to labels.
    pub rounding: Rounding,
    /// Labels and their bound are improved until the labels are at most this share above any labeling, if it is given.
    pub label_gap: Option<f64>,
}

impl Request {
    /// Whether the dual field of the best bound is needed at the end.
    pub(crate) fn needs_dual(&self) -> bool {
        self.keep_dual || self.label_gap.is_some()
    }

    /// Fails if lambda or the label gap is negative or not finite, or a setting of the method, or the label gap, is out
    /// of range or does not apply to the relaxation.
    pub fn check(&self) -> Result<()> {
        check_lambda(self.lambda)?;
        if let Some(gap) = self.label_gap
            && !(gap >= 0.0 && gap.is_finite())
        {
            return Err(Error::unsuitable(format!(
                "the label gap is {gap:?}: it must be a finite number, 0 or more"
            )));
        }
        if let Relaxation::Metric(_) = self.relaxation
            && self.label_gap.is_some()
        {
            return Err(Error::unsuitable(
                "labels are improved up to a gap only where all pairs of labels weigh the same: leave the label gap out",
            ));
        }
        self.method.check()?;
        self.method.check_relaxation(self.relaxation)
    }
}

/// Called between the passes of a solver, with a sample where one was taken; may end the run.
pub type Observer<'a> = &'a mut dyn FnMut(Option<&Sample>) -> ControlFlow<()>;

pub(crate) fn check_lambda(lambda: f64) -> Result<()> {
    if lambda >= 0.0 && lambda.is_finite() {
        Ok(())
    } else {
        Err(Error::unsuitable(format!("lambda = {lambda:?}: must be a finite number, 0 or more")))
    }
}
