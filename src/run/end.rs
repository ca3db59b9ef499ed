//! When a run stops, and how it ended.

use std::time::Duration;

use serde::{Deserialize, Serialize};

/// When to stop. Without any bound a run goes on until the observer ends it.
#[derive(Clone, Debug, Default)]
pub struct Stop {
    /// Certified: (E - D) / (E - B) at most this.
    pub relative_gap: Option<f64>,
    /// Steps of this call, not of the whole run.
    pub iterations: Option<u64>,
    /// Wall time of this call.
    pub time: Option<Duration>,
    /// The paper's |U^t - U^{t-1}|_inf <= delta, looked at where samples are taken. It certifies nothing; an
    /// over-relaxed U^{t-1} counts as it is, outside the simplex or not.
    pub change: Option<f64>,
    /// Steps between samples; `None` starts with [`super::FIRST_INTERVAL`], keeps it at about 4 % of the iterations so
    /// far, and goes up to 8 or 25 % where the last two samples foretell that the gap needs as many.
    pub interval: Option<u64>,
}

/// A limit of time in seconds. Fails if it is negative, NaN, infinite or above about 1e19, with what it must be.
pub fn time_limit(seconds: f64) -> Result<Duration, &'static str> {
    Duration::try_from_secs_f64(seconds)
        .map_err(|_| "must be a number of seconds from 0 to 1e19; without it there is no limit")
}

impl Stop {
    /// The same with less time, because of what was spent before.
    pub fn after(&self, spent: Duration) -> Self {
        Stop { time: self.time.map(|limit| limit.saturating_sub(spent)), ..self.clone() }
    }
}

/// How a run ended. None of these is an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// The certified gap was reached.
    Converged,
    /// The change of U fell below what was asked for; the gap says how good that is.
    Stalled,
    /// The iteration limit of this call was reached before the gap.
    IterationLimit,
    /// The time limit of this call was reached before the gap.
    TimeLimit,
    /// The observer ended the run; the best answer so far is kept.
    Interrupted,
    /// A number that is none appeared; the best answer before it is kept.
    Diverged,
    /// A lower bound exceeded an energy: nothing is certified.
    Contradicted,
    /// A solver outside the program ended by itself.
    Ended,
    /// A solver outside the program ended with an error; what it reached before is kept.
    Failed,
}

impl Status {
    /// The status in words, for the user.
    pub fn sentence(self) -> &'static str {
        match self {
            Status::Converged => "converged: the certified gap is within the tolerance",
            Status::Stalled => {
                "stopped: U changed by no more than the given amount, which certifies nothing by itself"
            }
            Status::IterationLimit => "stopped at the iteration limit before the gap was reached",
            Status::TimeLimit => "stopped at the time limit before the gap was reached",
            Status::Interrupted => "interrupted; what was reached so far is kept",
            Status::Diverged => {
                "diverged: a value is not a number any more; the best answer before that is kept"
            }
            Status::Contradicted => {
                "contradicted: the lower bound exceeds the energy by more than rounding allows, so that nothing is \
                 certified; this is a fault of the program, please report it"
            }
            Status::Ended => "the solver ended by itself before the gap was reached",
            Status::Failed => "the solver failed; what it reached before is kept",
        }
    }
}
