//! Stopping criteria of a run, and how it ended.

use std::time::Duration;

use serde::{Deserialize, Serialize};

/// The stopping criteria. Without any of them a run continues until the observer ends it.
#[derive(Clone, Debug, Default)]
pub struct Stop {
    /// The certified gap: (E - D) / (E - B) is at most this.
    pub relative_gap: Option<f64>,
    /// Maximum number of steps of this call, not of the whole run.
    pub iterations: Option<u64>,
    /// Maximum wall time of this call.
    pub time: Option<Duration>,
    /// delta of the paper's criterion |U^t - U^{t-1}|_inf <= delta, checked where samples are taken. It certifies
    /// nothing. An over-relaxed U^{t-1} is used as it is, inside the simplex or not.
    pub change: Option<f64>,
    /// Steps between samples. `None` starts with [`super::FIRST_INTERVAL`], stays at about 4 % of the iterations so
    /// far, and increases up to 8 steps or 25 % where the last two samples predict that the gap needs as many.
    pub interval: Option<u64>,
}

/// A time limit in seconds. Fails with a message if it is negative, NaN, infinite or above about 1e19.
pub fn time_limit(seconds: f64) -> Result<Duration, &'static str> {
    Duration::try_from_secs_f64(seconds)
        .map_err(|_| "must be a number of seconds from 0 to 1e19; omit it for no limit")
}

impl Stop {
    /// The same criteria with the time that is left after `spent`.
    pub fn after(&self, spent: Duration) -> Self {
        Stop { time: self.time.map(|limit| limit.saturating_sub(spent)), ..self.clone() }
    }
}

/// How a run ended. None of these is an [`Error`](crate::Error).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Status {
    /// The certified gap was reached.
    Converged,
    /// The change of U fell to the requested threshold; the gap tells how good U is.
    Stalled,
    /// No further step changes U; the gap tells how good it is.
    Settled,
    /// The iteration limit of this call was reached before the gap.
    IterationLimit,
    /// The time limit of this call was reached before the gap.
    TimeLimit,
    /// The observer ended the run; the best U and bound so far are kept.
    Interrupted,
    /// A NaN appeared; the best U and bound before it are kept.
    Diverged,
    /// A lower bound exceeded an energy: nothing is certified.
    Contradicted,
    /// An external solver ended on its own.
    Ended,
    /// An external solver ended with an error; its earlier iterates are kept.
    Failed,
}

impl Status {
    /// The status in words, for the user.
    pub fn sentence(self) -> &'static str {
        match self {
            Status::Converged => "converged: the certified gap is within the tolerance",
            Status::Stalled => {
                "stopped: the change of U fell to the given threshold, which by itself certifies nothing"
            }
            Status::Settled => {
                "settled: no further step of this method changes U; the gap tells how good it is"
            }
            Status::IterationLimit => "stopped at the iteration limit before the gap was reached",
            Status::TimeLimit => "stopped at the time limit before the gap was reached",
            Status::Interrupted => "interrupted; the best result so far is kept",
            Status::Diverged => "diverged: a value became NaN; the best result before that is kept",
            Status::Contradicted => {
                "contradicted: the lower bound exceeds the energy by more than rounding allows, so nothing is \
                 certified; this is a bug in the program, please report it"
            }
            Status::Ended => "the solver ended on its own before the gap was reached",
            Status::Failed => "the solver failed; its best result before that is kept",
        }
    }
}
