//! What a reconstruction reports on its way.

use super::at_rest::Reconstruction;
use super::descent::Step;
use super::surface::Surface;

/// What happens on the way.
pub enum Event<'a> {
    /// A step was made, and the surface is where it led.
    Step(&'a Step, &'a Surface),
    /// The mean distance of that surface to the truth, in shares of its diagonal: after steps that are
    /// [compared](Step::is_compared), if the truth is given.
    Distance(f64),
    /// A level has ended, and another one follows.
    Level(&'a Reconstruction),
    /// The labels of a surface at rest are being computed.
    Labels,
}
