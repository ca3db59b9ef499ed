//! What a reconstruction reports on its way.

use super::at_rest::Reconstruction;
use super::descent::Step;

/// What happens on the way.
pub enum Event<'a> {
    /// A step was made; the distance to the truth is there now and then, if that is given.
    Step(&'a Step, Option<f64>),
    /// A level has ended, and another one follows.
    Level(&'a Reconstruction),
    /// The labels of a surface at rest are being computed.
    Labels,
}
