//! The regions of a surface, and what they look like from outside.
//!
//! ```text
//! e = sum_p u_p |I - s mu_p|^2 = |I|^2 - 2 s I.v + s^2 w        v = sum_p u_p mu_p,   w = sum_p u_p |mu_p|^2
//! ```
//!
//! since sum_p u_p = 1. v and w are linear on faces: the energy of the images and its gradient need four numbers per
//! vertex, however many regions there are.

/// The labels and the colors of m regions.
#[derive(Clone, Debug, PartialEq)]
pub struct Coloring {
    /// U, V x m numbers in row order, rows in the simplex.
    pub u: Vec<f64>,
    /// mu_p, in the units of the images; m of them.
    pub mu: Vec<[f64; 3]>,
}

/// v (three channels) and w at a vertex.
pub type Look = [f64; 4];

impl Coloring {
    /// m.
    pub fn regions(&self) -> usize {
        self.mu.len()
    }

    /// v and w at all vertices.
    pub fn looks(&self) -> Vec<Look> {
        let of_region = |mu: &[f64; 3]| -> Look {
            let [r, g, b] = *mu;
            [r, g, b, r * r + g * g + b * b]
        };
        let regions: Vec<Look> = self.mu.iter().map(of_region).collect();
        let look = |u: &[f64]| {
            let mut look = [0.0; 4];
            for (u, region) in u.iter().zip(&regions) {
                look.iter_mut().zip(region).for_each(|(sum, x)| *sum += u * x);
            }
            look
        };
        self.u.chunks(self.regions()).map(look).collect()
    }

    /// The region with the largest u_kp at each vertex, the first of equal ones.
    pub fn labels(&self) -> Vec<usize> {
        let largest =
            |u: &[f64]| (1..u.len()).fold(0, |best, p| if u[p] > u[best] { p } else { best });
        self.u.chunks(self.regions()).map(largest).collect()
    }

    /// Whether U is the same at all vertices: then nothing slides along the surface.
    pub fn is_uniform(&self) -> bool {
        let m = self.regions();
        self.u.chunks(m).all(|u| u == &self.u[..m])
    }
}
