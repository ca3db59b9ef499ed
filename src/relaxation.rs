//! Three convex relaxations of the same model. They differ in the set in which each q_j lives, and nowhere else:
//!
//! ```text
//! frobenius   |q_j| <= lambda                                      lambda |(K U)_j|
//! separate    |q_jp| <= lambda / sqrt(2)         for all p         lambda / sqrt(2) sum_p |(K U)_jp|
//! envelope    |q_ja - q_jb| <= sqrt(2) lambda    for all a, b      the support function, see `relaxation/diameter.rs`
//! ```
//!
//! q_jp in R^2 is the tangent vector of region p. To the right is the support function of the set, max_q <q_j, (K U)_j>, which
//! is the energy of face j. (K U)_j sums to zero over the regions, and then each of the three is at most the next one. Where
//! only two regions change, as in a face whose corners have at most two labels, all three are equal; they are the same for m = 2.
//! Three labels in a face cost 1 to 1.2247 times as much with `separate`, and 1 to 1.4143 times with `envelope`.
//!
//! - frobenius: equation (3) of Delaunoy et al., ICCV 2009; J. Lellmann et al., *Convex multi-class image labeling by
//!   simplex-constrained total variation*, SSVM 2009.
//! - separate: C. Zach, D. Gallup, J.-M. Frahm, M. Niethammer, *Fast global labeling for real-time stereo using multiple plane
//!   sweeps*, VMV 2008.
//! - envelope: A. Chambolle, D. Cremers, T. Pock, *A convex approach to minimal partitions*, SIAM J. Imaging Sciences 5, 2012.

mod balls;
mod diameter;
mod envelope;
mod multipliers;
mod set;

pub use balls::{Frobenius, Separate};
pub use envelope::Envelope;
pub use set::{DualSet, Relaxation};

/// Evaluates an expression in which `$Set` is the [`DualSet`] of a relaxation.
macro_rules! with_set {
    ($relaxation:expr, $Set:ident => $body:expr) => {
        match $relaxation {
            $crate::relaxation::Relaxation::Frobenius => {
                type $Set = $crate::relaxation::Frobenius;
                $body
            }
            $crate::relaxation::Relaxation::Separate => {
                type $Set = $crate::relaxation::Separate;
                $body
            }
            $crate::relaxation::Relaxation::Envelope => {
                type $Set = $crate::relaxation::Envelope;
                $body
            }
        }
    };
}
pub(crate) use with_set;

#[cfg(test)]
mod tests;
