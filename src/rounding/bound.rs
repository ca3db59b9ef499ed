//! A bound for labels: no labeling of the vertices has a smaller energy.
//!
//! ```text
//! R(x)   = sum_v f_v(x_v) + sum_j theta_j(x_1, x_2, x_3)                        theta_j = lambda n_j of `labels.rs`
//! L(y)   = sum_v min_p g_v(p) + sum_j min_x ( theta_j(x) - sum_c y_jc(x_c) )    g_v = f_v + sum of y_jc at corners c = v
//! L(y)  <= R(x) for all y and x
//! ```
//!
//! The dual field of the relaxation gives a first y, the K^T q of each face, for which L(y) is D(q) or more. Block-coordinate
//! ascent then never lowers L: vertex after vertex, g_v takes the min-marginals of the faces at v, and shares the sum among
//! those that have later vertices; then in the opposite order. Reference: V. Kolmogorov, *A new look at reweighted message
//! passing*, IEEE Transactions on Pattern Analysis and Machine Intelligence 37(5), 2015.

use super::labels::Labels;
use crate::domain::Domain;
use crate::mesh::incidence::Incidence;

/// The field y of a problem, and its bound.
pub struct LabelBound<'a> {
    domain: Domain<'a>,
    /// 3 j + c for the corners at each vertex.
    around: Incidence<u32>,
    m: usize,
    /// g, m numbers per vertex; infinite where a label is forbidden.
    g: Vec<f64>,
    /// y, m numbers per corner 3 j + c.
    y: Vec<f64>,
    /// lambda l_c / sqrt(2), the cost of a face whose corner c differs from the two others.
    single: Vec<[f64; 3]>,
    /// The cost of a face with three labels.
    triple: Vec<f64>,
    /// In both orders, the share of g_v that each face with a later vertex gets.
    share: Vec<f64>,
}

/// An ascent asks whether to go on after this many vertices.
const VERTICES_BETWEEN_QUESTIONS: usize = 4096;

impl<'a> LabelBound<'a> {
    /// `y` has m numbers per corner; for every label, those of a face sum to zero.
    pub fn new(labels: &Labels<'a>, y: Vec<f64>) -> Self {
        let (m, domain) = (labels.m, labels.domain());
        assert_eq!(y.len(), 3 * m * domain.terms());
        let around = domain.around(|j, c| (3 * j + c) as u32);
        let cost = |v: usize, p: usize| match labels.is_allowed(v, p as u8) {
            true => labels.cost(v, p as u8),
            false => f64::INFINITY,
        };
        let mut g: Vec<f64> = (0..labels.vertices())
            .flat_map(|v| (0..m).map(move |p| (v, p)))
            .map(|(v, p)| cost(v, p))
            .collect();
        for (corner, y) in y.chunks(m).enumerate() {
            let v = domain.corners(corner / 3)[corner % 3] as usize;
            g[v * m..][..m].iter_mut().zip(y).for_each(|(g, y)| *g += y);
        }
        let faces = 0..domain.terms() as u32;
        let costs = |j: u32| [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map(|x| labels.face_cost(j, x));
        let single: Vec<[f64; 3]> = faces.clone().map(costs).collect();
        let triple: Vec<f64> = faces.map(|j| labels.face_cost(j, [0, 1, 2])).collect();
        let share = (0..labels.vertices()).map(|v| {
            let ends = |corner: &u32| {
                let face = domain.corners(*corner as usize / 3).map(|w| w as usize);
                [face.iter().any(|&w| w > v), face.iter().any(|&w| w < v)]
            };
            let counts = around.at(v).iter().map(ends).fold([0_u32; 2], |sum, [later, earlier]| {
                [sum[0] + u32::from(later), sum[1] + u32::from(earlier)]
            });
            1.0 / f64::from(counts[0].max(counts[1]).max(1))
        });
        let share = share.collect();
        LabelBound { domain, around, m, g, y, single, triple, share }
    }

    /// One ascent in each order of the vertices; ends early, with a field that is as valid as any, if `go_on` returns false.
    pub fn ascend(&mut self, go_on: &mut dyn FnMut() -> bool) {
        let n = self.share.len();
        let mut minima = MinMarginals::default();
        for v in 0..n {
            if v % VERTICES_BETWEEN_QUESTIONS == 0 && !go_on() {
                return;
            }
            self.update(v, |w, v| w > v, &mut minima);
        }
        for v in (0..n).rev() {
            if v % VERTICES_BETWEEN_QUESTIONS == 0 && !go_on() {
                return;
            }
            self.update(v, |w, v| w < v, &mut minima);
        }
    }

    fn update(
        &mut self,
        v: usize,
        is_later: impl Fn(usize, usize) -> bool,
        minima: &mut MinMarginals,
    ) {
        let m = self.m;
        for &corner in self.around.at(v) {
            let corner = corner as usize;
            minima.find(self, corner);
            let (g, y) = (&mut self.g[v * m..][..m], &mut self.y[corner * m..][..m]);
            for ((g, y), &least) in g.iter_mut().zip(y).zip(&minima.without_own) {
                if g.is_finite() {
                    // The min-marginal of the face becomes 0.
                    *g += least - *y;
                    *y = least;
                }
            }
        }
        minima.given.clear();
        minima.given.extend(self.g[v * m..][..m].iter().map(|g| self.share[v] * g));
        for &corner in self.around.at(v) {
            let corner = corner as usize;
            if self.domain.corners(corner / 3).iter().any(|&w| is_later(w as usize, v)) {
                let (g, y) = (&mut self.g[v * m..][..m], &mut self.y[corner * m..][..m]);
                for ((g, y), &given) in g.iter_mut().zip(y).zip(&minima.given) {
                    if g.is_finite() {
                        *g -= given;
                        *y -= given;
                    }
                }
            }
        }
    }

    /// L(y), lowered by what the rounding of its terms and of their sum can have added.
    pub fn bound(&self, labels: &Labels<'_>) -> f64 {
        let m = self.m;
        let mut minima = MinMarginals::default();
        let (mut sum, mut size) = (0.0, 0.0);
        for v in 0..self.share.len() {
            // g from f and y, without the rounding errors of its updates.
            let mut least = f64::INFINITY;
            for p in (0..m).filter(|&p| self.g[v * m + p].is_finite()) {
                let mut g = labels.cost(v, p as u8);
                size += g.abs();
                for &corner in self.around.at(v) {
                    let y = self.y[corner as usize * m + p];
                    size += y.abs();
                    g += y;
                }
                least = least.min(g);
            }
            sum += least;
        }
        for (j, triple) in self.triple.iter().enumerate() {
            minima.find(self, 3 * j);
            let (v, y) = (self.domain.corners(j)[0] as usize, &self.y[3 * j * m..][..m]);
            let mut least = f64::INFINITY;
            for p in (0..m).filter(|&p| self.g[v * m + p].is_finite()) {
                least = least.min(minima.without_own[p] - y[p]);
            }
            sum += least;
            size += self.y[3 * j * m..][..3 * m].iter().map(|y| y.abs()).sum::<f64>() + triple;
        }
        let additions = (self.share.len() + self.triple.len()) as f64 + 64.0;
        sum - additions * f64::EPSILON * size
    }

    #[cfg(test)]
    pub fn min_marginals(&self, corner: usize) -> Vec<f64> {
        let mut minima = MinMarginals::default();
        minima.find(self, corner);
        minima.without_own
    }

    /// argmin_p g_v(p).
    pub fn decoded(&self) -> Vec<u8> {
        let least =
            |g: &[f64]| (0..self.m).fold(0, |best, p| if g[p] < g[best] { p } else { best });
        self.g.chunks(self.m).map(|g| least(g) as u8).collect()
    }
}

/// The min-marginals of a face at one of its corners, without y at this corner:
///
/// ```text
/// min over labels x with x_c = p of   theta_j(x) - y_ja(x_a) - y_jb(x_b)
/// ```
#[derive(Default)]
struct MinMarginals {
    /// For each p.
    without_own: Vec<f64>,
    /// -y at the two other corners, infinite for forbidden labels.
    others: [Vec<f64>; 2],
    /// What a vertex gives to its faces.
    given: Vec<f64>,
}

impl MinMarginals {
    fn find(&mut self, field: &LabelBound<'_>, corner: usize) {
        let (m, j, c) = (field.m, corner / 3, corner % 3);
        let (a, b) = ((c + 1) % 3, (c + 2) % 3);
        for (other, costs) in [a, b].into_iter().zip(&mut self.others) {
            let v = field.domain.corners(j)[other] as usize;
            let (g, y) = (&field.g[v * m..][..m], &field.y[(3 * j + other) * m..][..m]);
            costs.clear();
            let cost = |(g, y): (&f64, &f64)| if g.is_finite() { -y } else { f64::INFINITY };
            costs.extend(g.iter().zip(y).map(cost));
        }
        let [at_a, at_b] = [&self.others[0][..], &self.others[1][..]];
        let (single, triple) = (field.single[j], field.triple[j]);
        let [least_a, least_b] = [at_a, at_b].map(three_smallest);
        let equal = at_a.iter().zip(at_b).map(|(a, b)| a + b).fold(f64::INFINITY, f64::min);
        // Among the three smallest at each corner there is one that is neither p nor the label of the other corner.
        let different = |excluded: usize| {
            let mut least = (f64::INFINITY, [excluded; 2]);
            for (r, x) in least_a {
                for (s, y) in least_b {
                    if r != s && r != excluded && s != excluded && x + y < least.0 {
                        least = (x + y, [r, s]);
                    }
                }
            }
            least
        };
        let (all_different, [r, s]) = different(usize::MAX);
        self.without_own.clear();
        for p in 0..m {
            let apart = if p == r || p == s { different(p).0 } else { all_different };
            let one_equal =
                (at_a[p] + least_b[0].1 + single[b]).min(least_a[0].1 + at_b[p] + single[a]);
            let least = (at_a[p] + at_b[p]).min(one_equal).min(equal + single[c]);
            self.without_own.push(least.min(apart + triple));
        }
    }
}

/// The three smallest costs and their labels; infinite where there are fewer.
fn three_smallest(costs: &[f64]) -> [(usize, f64); 3] {
    let mut least = [(usize::MAX - 1, f64::INFINITY); 3];
    for (p, &cost) in costs.iter().enumerate() {
        if cost < least[2].1 {
            least[2] = (p, cost);
            if cost < least[1].1 {
                least.swap(1, 2);
            }
            if cost < least[0].1 {
                least.swap(0, 1);
            }
        }
    }
    least
}
