//! The light and the albedos of a lit surface for given U, by alternating least squares.
//!
//! ```text
//! min  sum_p sum_k (M U)_kp r_k |c_k - (e_k.x) rho_p|^2       x = (L, alpha),  e_k = (N_k, 1) where N_k.L > 0, else (0, 1)
//!
//! S_p = sum_k (M U)_kp r_k e_k e_k^T                           T_pi = sum_k (M U)_kp r_k c_ki e_k    for channel i
//! rho_pi = T_pi.x / x^T S_p x                                  sum_p |rho_p|^2 S_p x = sum_pi rho_pi T_pi
//! ```
//!
//! While the set of lit vertices stays the same, S and T are all that the data say, so that one pass over the vertices
//! serves any number of turns. They are summed again for the lit vertices of the light found, until these do not change.
//! Only the products rho L and rho alpha are determined: |L| = 1, and alpha is relative to it; or L = 0 and alpha = 1.

use nalgebra::{Matrix4, SymmetricEigen, Vector3, Vector4};

use super::{Albedo, Lambertian, MAX_ALBEDO};
use crate::data::{DataModel, Weights};
use crate::sweep::{collect, results};

/// A region keeps its albedo while int u_p r h^2 is below this fraction of int u_p r: it lies in the dark.
const MIN_LIT_SHARE: f64 = 0.05;

/// Maximum number of sets of lit vertices.
const MAX_LIT_SETS: usize = 30;

/// Maximum number of turns of the albedos and the light for one set.
const MAX_TURNS: usize = 200;

/// A turn that changes the light by less than this is the last.
const SETTLED_LIGHT: f64 = 1e-9;

/// Maximum number of fits of the light of a surface of one region.
const MAX_INITIAL_FITS: usize = 20;

/// A fit that lowers the costs by less than this fraction is the last of them.
const SETTLED_COSTS: f64 = 1e-4;

/// Eigenvalues below this fraction of the largest count as 0: on a plane light and ambient light cannot be told
/// apart, and the shortest x is chosen.
const RANK: f64 = 1e-9;

/// Maximum number of steps of the eigenvalues of a matrix, which need ten.
const MAX_EIGENVALUE_STEPS: usize = 1000;

/// There is no light if it is weaker than this fraction of the ambient light: its direction would be arbitrary.
const DIM: f64 = 1e-6;

/// Vertices whose sums are added before those of others, in their order.
const BLOCK: usize = 4096;

/// The sums over the vertices of one region.
#[derive(Clone)]
struct Moments {
    /// S_p.
    squares: Matrix4<f64>,
    /// T_p, one column per channel.
    colors: Vec<Vector4<f64>>,
}

impl Moments {
    fn none(d: usize) -> Self {
        Moments { squares: Matrix4::zeros(), colors: vec![Vector4::zeros(); d] }
    }

    fn add(&mut self, other: &Moments) {
        self.squares += other.squares;
        self.colors.iter_mut().zip(&other.colors).for_each(|(sum, more)| *sum += more);
    }
}

fn x(mu: &Albedo) -> Vector4<f64> {
    Vector3::from(mu.light).push(mu.ambient)
}

impl Lambertian<'_> {
    /// Which vertices the light reaches.
    fn lit(&self, mu: &Albedo) -> Vec<bool> {
        let light = Vector3::from(mu.light);
        collect(self.normals.len(), |k| self.normals[k].dot(&light) > 0.0)
    }

    /// S and T of m regions, `weights` = M U.
    fn moments(&self, weights: Weights<'_>, m: usize, lit: &[bool]) -> Vec<Moments> {
        let none = || vec![Moments::none(self.means().dimension); m];
        let n = weights.vertices();
        let blocks = results((0..n).step_by(BLOCK).collect(), |first: usize| {
            let mut moments = none();
            for k in (first..n.min(first + BLOCK)).filter(|&k| self.is_known(k)) {
                let (r, c, _) = self.pixels.at(k);
                let e = if lit[k] { self.normals[k].push(1.0) } else { Vector4::w() };
                let square = e * e.transpose();
                for (moments, u) in moments.iter_mut().zip(weights.at(k)) {
                    let w = r * u;
                    moments.squares += w * square;
                    moments.colors.iter_mut().zip(c).for_each(|(sum, c)| *sum += w * *c * e);
                }
            }
            moments
        });
        let mut total = none();
        for block in blocks {
            total.iter_mut().zip(&block).for_each(|(total, block)| total.add(block));
        }
        total
    }

    /// Sets the albedos to the minimizers for the light, from 0 to the largest; regions in the dark keep theirs.
    fn fit_albedos(&self, moments: &[Moments], mu: &mut [Albedo]) {
        let highest = MAX_ALBEDO * self.means().values.iter().copied().fold(0.0, f64::max);
        for (mu, Moments { squares, colors }) in mu.iter_mut().zip(moments) {
            let x = x(mu);
            let (lit, mass) = (x.dot(&(squares * x)), squares[(3, 3)]);
            if lit > 0.0 && lit >= MIN_LIT_SHARE * mass {
                for (rho, color) in mu.albedo.iter_mut().zip(colors) {
                    // The costs are a sum of convex functions of one number each.
                    *rho = (color.dot(&x) / lit).clamp(0.0, highest);
                }
            }
        }
    }

    /// Sets L and alpha, as far as they are not given, to the minimizers for the albedos, which are scaled so that |L| = 1,
    /// or alpha = 1 if the colors show no light. Returns the largest change; none, with nothing changed, if a given alpha
    /// leaves no such choice, or if the numbers leave the range of double precision.
    fn fit_light(&self, moments: &[Moments], mu: &mut [Albedo]) -> Option<f64> {
        let (mut matrix, mut rhs) = (Matrix4::zeros(), Vector4::zeros());
        for (mu, Moments { squares, colors }) in mu.iter().zip(moments) {
            for (rho, color) in mu.albedo.iter().zip(colors) {
                matrix += rho * rho * squares;
                rhs += *rho * color;
            }
        }
        let found = self.minimizer(&matrix, &rhs)?;
        let strength = found.xyz().norm();
        let is_lit = strength > DIM * found.w.abs();
        let (light, ambient, strength) = match self.given.ambient {
            _ if !(strength.is_finite() && found.w.is_finite()) => return None,
            Some(ambient) if is_lit => (found.xyz() / strength, ambient, strength),
            None if is_lit => (found.xyz() / strength, found.w / strength, strength),
            None if found.w > 0.0 => (Vector3::zeros(), 1.0, found.w),
            _ => return None,
        };
        let change = (light.push(ambient) - x(&mu[0])).amax();
        for mu in mu {
            (mu.light, mu.ambient) = (light.into(), ambient);
            mu.albedo.iter_mut().for_each(|rho| *rho *= strength);
        }
        Some(change)
    }

    /// x with alpha >= 0 that solves the normal equations, with L or alpha kept if it is given.
    fn minimizer(&self, matrix: &Matrix4<f64>, rhs: &Vector4<f64>) -> Option<Vector4<f64>> {
        if let Some(light) = self.given.light {
            let rest = rhs.w - matrix.column(3).xyz().dot(&light);
            return Some(light.push((rest / matrix[(3, 3)]).max(0.0)));
        }
        let with_ambient = |ambient: f64| {
            // alpha is replaced by its value, in the scale of the rest.
            let (mut matrix, mut rhs, scale) = (*matrix, *rhs, matrix.trace());
            for i in 0..3 {
                rhs[i] -= ambient * matrix[(i, 3)];
                (matrix[(i, 3)], matrix[(3, i)]) = (0.0, 0.0);
            }
            (matrix[(3, 3)], rhs[3]) = (scale, scale * ambient);
            shortest_solution(&matrix, &rhs)
        };
        if let Some(ambient) = self.given.ambient {
            return with_ambient(ambient);
        }
        let x = shortest_solution(matrix, rhs)?;
        if x.w < 0.0 { with_ambient(0.0) } else { Some(x) }
    }

    /// The albedos for the light so far; then the light and the albedos together, if that lowers the costs further.
    pub(super) fn fit_all(&self, weights: Weights<'_>, mu: &mut [Albedo]) {
        let m = mu.len();
        let mut lit = self.lit(&mu[0]);
        let mut moments = self.moments(weights, m, &lit);
        self.fit_albedos(&moments, mu);
        if self.given.light.is_some() && self.given.ambient.is_some() {
            return;
        }
        let mut relit = mu.to_vec();
        for _ in 0..MAX_LIT_SETS {
            for _ in 0..MAX_TURNS {
                match self.fit_light(&moments, &mut relit) {
                    Some(change) => {
                        self.fit_albedos(&moments, &mut relit);
                        if change <= SETTLED_LIGHT {
                            break;
                        }
                    }
                    None => return,
                }
            }
            let now = self.lit(&relit[0]);
            if now == lit {
                break;
            }
            lit = now;
            moments = self.moments(weights, m, &lit);
            self.fit_albedos(&moments, &mut relit);
        }
        if self.costs_of(weights, &relit) < self.costs_of(weights, mu) {
            mu.clone_from_slice(&relit);
        }
    }

    /// The light of a surface of one region, with its albedo: the best of those found from the directions of the axes.
    pub(super) fn initial_light(&self, vertex_weights: &[f64]) -> Albedo {
        let weights = Weights::new(vertex_weights, 1);
        let directions = match self.given.light {
            Some(light) => vec![light],
            None => {
                let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
                axes.into_iter().flat_map(|axis| [axis, -axis]).collect()
            }
        };
        let mut best: Option<(f64, Albedo)> = None;
        for light in directions {
            let albedo = vec![1.0; self.means().dimension];
            let ambient = self.given.ambient.unwrap_or(0.0);
            let mut mu = [Albedo { albedo, light: light.into(), ambient }];
            let mut costs = f64::INFINITY;
            for _ in 0..MAX_INITIAL_FITS {
                self.fit_all(weights, &mut mu);
                let now = self.costs_of(weights, &mu);
                let settled = now >= (1.0 - SETTLED_COSTS) * costs;
                costs = now;
                if settled {
                    break;
                }
            }
            if best.as_ref().is_none_or(|(least, _)| costs < *least) {
                let [mu] = mu;
                best = Some((costs, mu));
            }
        }
        best.expect("there is a direction").1
    }
}

/// The shortest x of least residual for a positive semidefinite matrix; `None` if its eigenvalues are not found.
fn shortest_solution(matrix: &Matrix4<f64>, rhs: &Vector4<f64>) -> Option<Vector4<f64>> {
    // Scaled, so that no product of entries leaves the range of double precision.
    let scale = matrix.trace();
    if !(scale > 0.0 && scale.is_finite()) {
        return None;
    }
    let eigen = SymmetricEigen::try_new(matrix / scale, f64::EPSILON, MAX_EIGENVALUE_STEPS)?;
    let smallest = RANK * eigen.eigenvalues.max();
    let along = eigen.eigenvectors.tr_mul(&(rhs / scale));
    let x = along.zip_map(&eigen.eigenvalues, |b, e| if e > smallest { b / e } else { 0.0 });
    Some(eigen.eigenvectors * x)
}
