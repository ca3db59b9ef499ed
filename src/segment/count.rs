//! A number of regions for data of any kind, as a suggestion.
//!
//! ```text
//! CH(m) = ( (C_1 - C_m) / (m - 1) ) / ( C_m / (n - m) )         C_m: costs of the best m clusters of n data, without cuts
//! ```
//!
//! is largest where clusters are compact and far from each other. The data are those of a coarse mesh, which have little
//! noise. Numbers for which two clusters would be merged, or one is a speck, are left out. Reference: T. Calinski, J. Harabasz, *A dendrite method for cluster analysis*, Communications in Statistics
//! 3(1), 1974.

use std::borrow::Cow;
use std::ops::RangeInclusive;

use rand::SeedableRng;
use rand_pcg::Pcg64;
use serde::Serialize;

use super::estimate::{Estimate, ModelEstimate};
use super::lambda::{Explained, coarse_weights, labels_without_cuts};
use crate::data::{DataModel, Initial};
use crate::error::Result;
use crate::mesh::Mesh;
use crate::operator::Mass;
use crate::regions::with_regions;
use crate::solve::model_mesh;

/// One number of regions.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Count {
    /// m.
    pub regions: usize,
    /// CH(m); infinite if the clusters describe the data exactly.
    pub index: f64,
    /// Whether all clusters are larger than a speck and their parameters differ, so that no regions would be merged.
    pub distinct: bool,
}

/// The index of each number of regions, for a model whose costs are not negative: constant or l1. `seed` is that of the
/// clusters. Numbers above that of the different data are left out, except for the first.
///
/// # Errors
/// A fit that fails, and a mesh of which no face has an area.
pub fn of_data<D: DataModel>(
    mesh: &Mesh,
    model: &D,
    numbers: RangeInclusive<usize>,
    mass: Mass,
    seed: u64,
) -> Result<Vec<Count>> {
    let estimate = &mut ModelEstimate::new(Cow::Borrowed(model), Vec::new());
    of_estimate(mesh, estimate, numbers, mass, seed)
}

/// The number of distinct regions with the largest index, the smallest of equals; the smallest number if regions are not
/// distinct for any.
pub fn best(counts: &[Count]) -> usize {
    let better = |best: &Count, count: &Count| {
        count.distinct && (!best.distinct || count.index > best.index)
    };
    let first = |best: Count, &count: &Count| if better(&best, &count) { count } else { best };
    counts[1..].iter().fold(counts[0], first).regions
}

/// Not generic, so that it is compiled here.
fn of_estimate(
    mesh: &Mesh,
    estimate: &mut dyn Estimate,
    numbers: RangeInclusive<usize>,
    mass: Mass,
    seed: u64,
) -> Result<Vec<Count>> {
    let (usable, _) = model_mesh(mesh)?;
    let different = estimate.different(*numbers.end()).max(*numbers.start());
    let (_, known) = coarse_weights(&usable, estimate, mass);
    let n = known.iter().filter(|&&w| w > 0.0).count();
    let mut counts = Vec::new();
    for m in *numbers.start()..=different.min(*numbers.end()) {
        let mut rng = Pcg64::seed_from_u64(seed);
        estimate.start(Initial::KMeans, m, &known, &mut rng)?;
        let explained = with_regions!(m, explained(estimate, &known))?;
        let (between, within) = (explained.costs, explained.within);
        let freedom = n.saturating_sub(m) as f64 / (m - 1) as f64;
        let index = if within > 0.0 { between / within * freedom } else { f64::INFINITY };
        counts.push(Count { regions: m, index, distinct: explained.regions == m });
    }
    Ok(counts)
}

fn explained<const M: usize>(estimate: &mut dyn Estimate, known: &[f64]) -> Result<Explained> {
    let scale = estimate.scale(known);
    Explained::of(&labels_without_cuts::<M>(estimate), estimate, known, scale)
}
