//! Changes of connectivity that keep the faces of an evolving surface well shaped: long edges are split, edges are flipped
//! towards regular valences, short ones are collapsed. None changes the topology.
//!
//! Reference: M. Botsch, L. Kobbelt, *A remeshing approach to multiresolution modeling*, SGP 2004.

mod collapse;
mod flip;
mod lengths;
mod quality;
mod remeshed;
mod split;

pub use collapse::collapse_below;
pub use collapse::collapse_short;
pub use flip::flip;
pub use lengths::median_edge_length;
pub use remeshed::Remeshed;
pub use split::split_long;

#[cfg(test)]
mod tests;
