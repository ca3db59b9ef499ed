//! Values of merged vertices: means weighted by barycentric cells, so that integrals sum_v a_v s_v are kept; and the
//! way back, where each vertex takes the value of the vertex that it was merged onto.

use super::Weld;
use crate::mesh::order::sorted_by;
use crate::sweep;

impl Weld {
    /// The means of values at the original vertices, d per vertex, weighted by barycentric cells.
    pub fn means(&self, values: &[f64], d: usize) -> Vec<f64> {
        self.means_by(values, d, &self.areas)
    }

    /// The means with other weights. Rows with a NaN are unknown and ignored: without a known row the mean is NaN,
    /// without any weight all rows count equally. The mean of equal rows is that row, bit for bit.
    pub fn means_by(&self, values: &[f64], d: usize, weights: &[f64]) -> Vec<f64> {
        assert_eq!(values.len(), d * self.of.len());
        let row = |v: u32| &values[v as usize * d..][..d];
        let by_class = sorted_by(&self.of, self.mesh.vertices.len());
        let mut means = Vec::with_capacity(self.mesh.vertices.len() * d);
        for class in by_class.chunk_by(|&v, &w| self.of[v as usize] == self.of[w as usize]) {
            let known = || class.iter().filter(|&&v| row(v).iter().all(|x| !x.is_nan()));
            match known().next() {
                None => means.extend(std::iter::repeat_n(f64::NAN, d)),
                Some(&first) if known().all(|&v| row(v) == row(first)) => means.extend(row(first)),
                Some(_) => {
                    let total: f64 = known().map(|&v| weights[v as usize]).sum();
                    let weight = |v: u32| if total > 0.0 { weights[v as usize] } else { 1.0 };
                    let weighty = || known().filter(|&&v| weight(v) > 0.0);
                    let total: f64 = weighty().map(|&v| weight(v)).sum();
                    means.extend(
                        (0..d).map(|i| {
                            weighty().map(|&v| weight(v) * row(v)[i]).sum::<f64>() / total
                        }),
                    );
                }
            }
        }
        means
    }

    /// Distributes values at the welded vertices to the original vertices.
    pub fn spread<T: Copy + Send + Sync>(&self, values: &[T]) -> Vec<T> {
        sweep::collect(
            self.of.len(),
            #[inline(always)]
            |v| values[self.of[v] as usize],
        )
    }
}
