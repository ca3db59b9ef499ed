//! The settings of the method.

use strum::{EnumString, IntoStaticStr, VariantNames};

use super::steps::Rule;
use crate::error::{Error, Result};
use crate::relaxation::Relaxation;
use crate::solver::balance::{self, Balancing};
use crate::solver::{Adjustable, Setting};

/// The engine that computes the iterates.
#[derive(Clone, Copy, Debug, PartialEq, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum Engine {
    /// The fused engine if the operator has one, otherwise the rows.
    Auto,
    /// Several iterations in one blocked pass over memory.
    Fused,
    /// The reference implementation, for any operator.
    Rows,
}

/// The precision of the iterates; certificates are always in double precision.
#[derive(Clone, Copy, Debug, PartialEq, EnumString, IntoStaticStr, VariantNames)]
pub enum Precision {
    /// 64 bits.
    #[strum(serialize = "f64")]
    Double,
    /// 32 bits: half the memory traffic, gaps down to about 1e-5. Only the fused engine has it.
    #[strum(serialize = "f32")]
    Single,
}

/// The settings of Chambolle-Pock: `steps`, `rho`, `step-ratio`, `balance`, `engine`, `precision`.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The rule of the step lengths.
    pub steps: Rule,
    /// Relaxation, above 0 and below 2.
    pub rho: f64,
    /// Initial omega, in units of the expected size of q (lambda, or less if the costs need less); without a number, 1.5 for
    /// fixed costs and 0.5 for costs that are re-estimated.
    pub step_ratio: Option<f64>,
    /// Whether omega is balanced.
    pub balance: Balancing,
    /// The engine that computes the iterates.
    pub engine: Engine,
    /// The precision of the iterates.
    pub precision: Precision,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            steps: Rule::Local,
            rho: 1.9,
            step_ratio: None,
            balance: Balancing::Adaptive,
            engine: Engine::Auto,
            precision: Precision::Double,
        }
    }
}

/// omega / the expected size of q at the start, for fixed costs.
const STEP_RATIO: f64 = 1.5;

/// The same for costs that are re-estimated after every few steps: U has to follow them, and larger primal steps save 15 to
/// 50 % of the iterations.
const STEP_RATIO_OF_ESTIMATES: f64 = 0.5;

impl Settings {
    /// Fails if the settings do not apply to a relaxation: the fused engine, and with it single precision, lacks those
    /// whose sets do not consist of balls.
    pub fn check_relaxation(&self, relaxation: Relaxation) -> Result<()> {
        let lacking = match relaxation {
            Relaxation::Frobenius | Relaxation::Separate => return Ok(()),
            Relaxation::Envelope => "no relaxation envelope",
            Relaxation::Metric(_) => "no weights of pairs of labels",
        };
        let unsuitable = match (self.engine, self.precision) {
            (Engine::Fused, _) => {
                format!("engine=fused: the fused engine has {lacking}; use engine=auto")
            }
            (_, Precision::Single) => {
                format!(
                    "precision=f32 needs the fused engine, which has {lacking}; use precision=f64"
                )
            }
            _ => return Ok(()),
        };
        Err(Error::unsuitable(format!("solver option {unsuitable}")))
    }

    /// The step ratio that was chosen, or that of fixed costs.
    pub(super) fn step_ratio(&self) -> f64 {
        self.step_ratio.unwrap_or(STEP_RATIO)
    }

    /// The settings for costs that are re-estimated: what was chosen stays.
    pub fn for_estimates(self) -> Self {
        Settings { step_ratio: self.step_ratio.or(Some(STEP_RATIO_OF_ESTIMATES)), ..self }
    }
}

impl Adjustable for Settings {
    fn settings(&mut self) -> Vec<Setting<'_>> {
        vec![
            Setting::choice(
                "steps",
                &mut self.steps,
                "step lengths face by face; from the row and column sums of |K|; or one from a bound of ||K||",
            ),
            balance::relaxation(&mut self.rho),
            Setting::optional(
                balance::STEP_RATIO,
                &mut self.step_ratio,
                f64::MIN_POSITIVE..,
                "1.5, or 0.5 if parameters are re-estimated",
                balance::STEP_RATIO_HELP,
            ),
            self.balance.setting(),
            Setting::choice(
                "engine",
                &mut self.engine,
                "fused: several iterations per memory pass; rows: reference implementation; auto: fused if possible",
            ),
            Setting::choice(
                "precision",
                &mut self.precision,
                "of the iterates; f32 moves half the bytes and reaches gaps down to about 1e-5; certificates are f64",
            ),
        ]
    }
}
