//! Convex relaxations of the same model. They differ in the set in which each q_j lives, and nowhere else:
//!
//! ```text
//! frobenius   |q_j| <= lambda                                      lambda |(K U)_j|
//! separate    |q_jp| <= lambda / sqrt(2)         for all p         lambda / sqrt(2) sum_p |(K U)_jp|
//! envelope    |q_ja - q_jb| <= sqrt(2) lambda    for all a, b      the support function, see `relaxation/diameter.rs`
//! metric      the same times d(a, b)             for all a, b      the support function, see `relaxation/transport.rs`
//! ```
//!
//! q_jp in R^2 is the tangent vector of region p. To the right is the support function of the set, max_q <q_j, (K
//! U)_j>, which is the energy of face j. (K U)_j sums to zero over the regions, and then each of the first three is at
//! most the next one. Where only two regions change, as in a face whose corners have at most two labels, these are
//! equal; they are the same for m = 2. Three labels in a face cost 1 to 1.2247 times as much with `separate`, and 1 to
//! 1.4143 times with `envelope`. In the fourth, a cut between the labels a and b weighs d(a, b), for a metric d on the
//! labels; with d = 1 it is the third.
//!
//! - frobenius: equation (3) of Delaunoy et al., ICCV 2009; J. Lellmann et al., *Convex multi-class image labeling by
//!   simplex-constrained total variation*, SSVM 2009.
//! - separate: C. Zach, D. Gallup, J.-M. Frahm, M. Niethammer, *Fast global labeling for real-time stereo using multiple plane
//!   sweeps*, VMV 2008.
//! - envelope, metric: A. Chambolle, D. Cremers, T. Pock, *A convex approach to minimal partitions*, SIAM J. Imaging
//!   Sciences 5, 2012.

mod balls;
mod diameter;
mod envelope;
mod label_metric;
mod multipliers;
mod set;
pub(crate) mod transport;

pub use balls::{Frobenius, Separate};
pub use envelope::Envelope;
pub use label_metric::LabelMetric;
pub use set::{DualSet, Relaxation};

/// Evaluates an expression in which `$set` is the [`DualSet`] of a relaxation.
macro_rules! with_set {
    ($relaxation:expr, $set:ident => $body:expr) => {
        match $relaxation {
            $crate::relaxation::Relaxation::Frobenius => {
                let $set = $crate::relaxation::Frobenius;
                $body
            }
            $crate::relaxation::Relaxation::Separate => {
                let $set = $crate::relaxation::Separate;
                $body
            }
            relaxation => {
                let $set = $crate::relaxation::Envelope(relaxation.label_metric());
                $body
            }
        }
    };
}
pub(crate) use with_set;

#[cfg(test)]
mod tests;
