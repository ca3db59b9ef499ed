//! Seeds: vertices whose labels are given. They are hard constraints of the convex problem:
//!
//! ```text
//! u_k = e_p at a seed k of region p,   that is   f_kr = +inf for r /= p
//! ```
//!
//! Energies and bounds are those of the constrained problem, so a certificate refers to all labelings that agree with
//! the seeds. The constraint applies to the integrated costs f, so it suits every mass matrix. Reference: Y. Boykov,
//! M.-P. Jolly, *Interactive graph cuts for optimal boundary and region segmentation of objects in N-D images*, ICCV
//! 2001.

use crate::error::{Error, Result};
use crate::field::Row;
use crate::mesh::Weld;
use crate::mesh::coarsen::Coarsening;
use crate::mesh::order::Order;
use crate::problem::FORBIDDEN_COST;
use crate::sweep::sweep;

/// The seeds on a mesh of V vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Seeds {
    /// The region of each vertex; empty if there are no seeds.
    regions: Vec<Option<u8>>,
}

impl Seeds {
    /// For V vertices; `regions` holds the region of each seed.
    pub fn new(regions: Vec<Option<u8>>) -> Self {
        if regions.iter().all(Option::is_none) { Seeds::default() } else { Seeds { regions } }
    }

    /// Whether no vertex is a seed.
    pub fn is_empty(&self) -> bool {
        self.regions.is_empty()
    }

    /// The number of seeds.
    pub fn count(&self) -> usize {
        self.regions.iter().flatten().count()
    }

    /// The region of vertex k if it is a seed.
    pub fn region(&self, k: usize) -> Option<usize> {
        self.regions.get(k).copied().flatten().map(usize::from)
    }

    /// Which of m regions have seeds.
    pub fn seeded(&self, m: usize) -> Vec<bool> {
        let mut seeded = vec![false; m];
        self.regions.iter().flatten().for_each(|&p| seeded[usize::from(p)] = true);
        seeded
    }

    /// Fails unless the seeds are those of V vertices and their regions are below m.
    pub fn check(&self, vertices: usize, m: usize) -> Result<()> {
        if self.is_empty() {
            return Ok(());
        }
        if self.regions.len() != vertices {
            return Err(Error::unsuitable(format!(
                "the seeds are those of {} vertices; the mesh has {vertices}",
                self.regions.len()
            )));
        }
        match (0..vertices).find_map(|k| Some((k, self.region(k).filter(|&p| p >= m)?))) {
            None => Ok(()),
            Some((k, p)) => Err(Error::unsuitable(format!(
                "vertex {k} is a seed of region {p}; the {m} regions are numbered from 0 to {}",
                m - 1
            ))),
        }
    }

    /// The seeds of a welded mesh. Fails if vertices that are merged are seeds of different regions.
    pub fn welded(&self, weld: &Weld) -> Result<Self> {
        if self.is_empty() {
            return Ok(Seeds::default());
        }
        let mut regions = vec![None; weld.mesh.vertices.len()];
        for (k, (&v, &region)) in weld.of.iter().zip(&self.regions).enumerate() {
            let Some(p) = region else { continue };
            match regions[v as usize] {
                Some(other) if other != p => {
                    return Err(Error::unsuitable(format!(
                        "vertex {k} is a seed of region {p} but is merged with a seed of region {other}"
                    )));
                }
                _ => regions[v as usize] = region,
            }
        }
        Ok(Seeds { regions })
    }

    /// The seeds of the mesh in another order of its vertices.
    pub(crate) fn in_order(&self, order: &Order) -> Self {
        match self.is_empty() {
            true => Seeds::default(),
            false => Seeds { regions: order.applied(self.regions.clone()) },
        }
    }

    /// The seeds of a coarser mesh: its vertices to which seeds of one region only contribute the most. The others
    /// return on the finest mesh.
    pub(crate) fn restricted(&self, level: &Coarsening) -> Self {
        if self.is_empty() {
            return Seeds::default();
        }
        let mut regions = vec![None; level.mesh.vertices.len()];
        let mut mixed = vec![false; regions.len()];
        for (parents, &region) in level.parents.iter().zip(&self.regions) {
            let Some(p) = region else { continue };
            let [a, b, c] = parents.weights;
            let nearest = if a >= b && a >= c { 0 } else { if b >= c { 1 } else { 2 } };
            let v = parents.corners[nearest] as usize;
            mixed[v] |= regions[v].is_some_and(|other| other != p);
            regions[v] = region;
        }
        regions.iter_mut().zip(mixed).filter(|(_, mixed)| *mixed).for_each(|(region, _)| {
            *region = None;
        });
        Seeds::new(regions)
    }

    /// Forbids the other regions at the seeds. Fails if the costs forbid the region of a seed.
    pub(crate) fn constrain<const M: usize>(&self, f: &mut [Row<M>]) -> Result<()> {
        if self.is_empty() {
            return Ok(());
        }
        let refused = |k: usize| self.region(k).is_some_and(|p| f[k].0[p] == FORBIDDEN_COST);
        if let Some(k) = (0..f.len()).find(|&k| refused(k)) {
            return Err(Error::unsuitable(format!(
                "vertex {k} is a seed of a region that its costs forbid"
            )));
        }
        sweep(f, |k, f| {
            if let Some(seed) = self.region(k) {
                *f = Row::from_fn(|p| if p == seed { f.0[p] } else { FORBIDDEN_COST });
            }
        });
        Ok(())
    }
}
