//! Data that are constant in a region but for errors of any size.
//!
//! ```text
//! s_p(x) = |C(x) - mu_p|_1 = sum_i |C_i(x) - mu_pi|,     mu_pi = the median of C_i with the weights u_p
//! ```
//!
//! A datum pulls at mu_p by its weight, however far away it is: half of a region may be anything before its median is.
//! That the sum of absolute deviations is least at the median: P. J. Huber, *Robust Statistics*, Wiley 1981. As a data
//! term: T. F. Chan, S. Esedoglu, *Aspects of total variation regularized L1 function approximation*, SIAM J. Appl.
//! Math. 65, 2005.

use std::borrow::Cow;

use rand::RngExt;
use rand_pcg::Pcg64;
use serde::Serialize;

use super::kmeans::kmedians;
use super::range::{median, robust_range, robust_unit_range};
use super::{Data, DataModel, Initial, Scale};
use crate::error::Result;
use crate::field::Row;
use crate::mesh::coarsen::Coarsening;
use crate::mesh::order::Order;
use crate::sweep::collect;

/// Quantiles of a coordinate that a coarse vertex has: an odd number, so that one of them is the median.
const QUANTILES: usize = 5;

#[derive(Clone)]
pub struct L1<'a> {
    /// C; on a coarse mesh n values of each coordinate side by side, each of which counts as an n-th of the vertex.
    data: Cow<'a, Data>,
    /// n, odd.
    copies: usize,
    /// For each coordinate its values that are known, by their places in the data, in increasing order.
    sorted: Vec<Vec<usize>>,
}

/// mu_p.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Median {
    /// d numbers, in the units of the data.
    pub median: Vec<f64>,
}

impl<'a> L1<'a> {
    pub fn new(data: &'a Data) -> Self {
        L1::of(Cow::Borrowed(data), 1)
    }

    fn of(data: Cow<'a, Data>, copies: usize) -> Self {
        let sorted = |i: usize| {
            let known = (0..data.len()).filter(|&k| data.is_known(k));
            let of_vertex = |k: usize| k * data.dimension + i * copies;
            let places = known.flat_map(|k| (0..copies).map(move |c| of_vertex(k) + c));
            let mut sorted: Vec<usize> = places.collect();
            let value = |place: &usize| data.values[*place];
            sorted.sort_unstable_by(|a, b| value(a).total_cmp(&value(b)).then(a.cmp(b)));
            sorted
        };
        let sorted = (0..data.dimension / copies).map(sorted).collect();
        L1 { sorted, data, copies }
    }

    /// d.
    fn dimension(&self) -> usize {
        self.sorted.len()
    }

    /// What a vertex has of coordinate i.
    fn values(&self, k: usize, i: usize) -> &[f64] {
        &self.data.at(k)[i * self.copies..][..self.copies]
    }

    /// The medians of coordinate i at all vertices.
    fn middle(&self, i: usize) -> Vec<f64> {
        self.data.column(i * self.copies + self.copies / 2)
    }
}

impl DataModel for L1<'_> {
    type Parameters = Median;

    const TOLD: &'static str = "median";

    fn told(mu: &Median) -> &[f64] {
        &mu.median
    }

    fn vertices(&self) -> usize {
        self.data.len()
    }

    fn is_known(&self, k: usize) -> bool {
        self.data.is_known(k)
    }

    fn different(&self, most: usize) -> usize {
        self.data.different(most)
    }

    fn in_order(&self, order: &Order) -> Cow<'_, Self> {
        match self.data.in_order(order) {
            Cow::Borrowed(_) => Cow::Borrowed(self),
            Cow::Owned(data) => Cow::Owned(L1::of(Cow::Owned(data), self.copies)),
        }
    }

    /// The quantiles of each coordinate at (c + 1/2) / n with the weights P_kc w_k, c from 0 to n - 1: the mean of
    /// |C_i - mu_pi| over what a coarse vertex stands for is nearly that over these. A mean would spread every outlier;
    /// the median alone, which has less noise than the data, makes regions differ by more than they do.
    fn restricted(&self, level: &Coarsening, weights: &[f64], coarse: &[f64]) -> Self {
        let mut shares: Vec<Vec<(usize, f64)>> = vec![Vec::new(); coarse.len()];
        for (v, parents) in level.parents.iter().enumerate().filter(|&(v, _)| self.is_known(v)) {
            for (&c, share) in parents.corners.iter().zip(parents.weights) {
                if share * weights[v] > 0.0 {
                    shares[c as usize].push((v, share * weights[v]));
                }
            }
        }
        let dimension = self.dimension() * QUANTILES;
        let mut values = Vec::with_capacity(coarse.len() * dimension);
        for shares in &shares {
            for i in 0..self.dimension() {
                let each = |&(v, w): &(usize, f64)| self.values(v, i).iter().map(move |&x| (x, w));
                let mut all: Vec<(f64, f64)> = shares.iter().flat_map(each).collect();
                all.sort_unstable_by(|(x, _), (y, _)| x.total_cmp(y));
                let total: f64 = all.iter().map(|(_, w)| w).sum();
                let (mut passed, mut next) = (0.0, all.iter());
                let mut last = 0.0;
                for c in 0..QUANTILES {
                    while passed <= (c as f64 + 0.5) / QUANTILES as f64 * total {
                        let Some(&(value, w)) = next.next() else { break };
                        (passed, last) = (passed + w, value);
                    }
                    values.push(last);
                }
            }
        }
        L1::of(Cow::Owned(Data { dimension, values }), QUANTILES)
    }

    /// The mean deviation from the median, of the data whose extreme 2 % are cut off at both ends if they still differ
    /// then. If half of the data have one value and half another, it is half of what it costs to take one for the
    /// other.
    fn scale(&self, weights: &[f64]) -> Scale {
        let area = self.data.known_area(weights).repeat(self.copies);
        let column = |i: usize| -> Vec<f64> {
            (0..self.copies).flat_map(|c| self.data.column(i * self.copies + c)).collect()
        };
        let columns: Vec<Vec<f64>> = (0..self.dimension()).map(column).collect();
        let cut_off = |column: &Vec<f64>| {
            let (unit, [low, high]) = robust_unit_range(column, &area);
            deviation(&unit, &area) * (high - low)
        };
        let robust: f64 = columns.iter().map(cut_off).sum();
        let all = || columns.iter().map(|column| deviation(column, &area)).sum();
        let deviation = if robust > 0.0 { robust } else { all() };
        Scale { cost: 0.5 * deviation, distance: deviation, change: deviation }
    }

    fn start(
        &self,
        initial: Initial,
        m: usize,
        weights: &[f64],
        rng: &mut Pcg64,
    ) -> Result<Vec<Median>> {
        let area = self.data.known_area(weights);
        let columns: Vec<Vec<f64>> = (0..self.dimension()).map(|i| self.middle(i)).collect();
        if initial == Initial::KMeans {
            // Values far away, which a start would take for regions, are moved to the ends of the others.
            let near = |column: &Vec<f64>| -> Vec<f64> {
                let [low, high] = robust_range(column, &area);
                let near = |&x: &f64| if low < high { x.clamp(low, high) } else { x };
                column.iter().map(near).collect()
            };
            let columns: Vec<Vec<f64>> = columns.iter().map(near).collect();
            let rows: Vec<f64> =
                (0..area.len()).flat_map(|k| columns.iter().map(move |column| column[k])).collect();
            let medians = kmedians(&rows, self.dimension(), &area, m, rng);
            return Ok(medians.into_iter().map(|median| Median { median }).collect());
        }
        let drawn: Vec<usize> = area.iter().map(|_| rng.random_range(0..m)).collect();
        let of = |p: usize| {
            let own = area.iter().zip(&drawn).map(|(&a, &q)| if q == p { a } else { 0.0 });
            let own: Vec<f64> = own.collect();
            // A region that drew no vertex starts at the median of all.
            let area = if own.iter().any(|&a| a > 0.0) { &own } else { &area };
            Median { median: columns.iter().map(|column| median(column, area)).collect() }
        };
        Ok((0..m).map(of).collect())
    }

    fn costs<const M: usize>(&self, mu: &[Median]) -> Vec<Row<M>> {
        assert!(mu.iter().all(|mu| mu.median.len() == self.dimension()));
        let cost = |k: usize, mu: &[f64]| -> f64 {
            let data = self.data.at(k).chunks(self.copies).zip(mu);
            data.flat_map(|(c, mu)| c.iter().map(move |c| (c - mu).abs())).sum::<f64>()
                / self.copies as f64
        };
        let row = |k: usize| Row::from_fn(|p| mu.get(p).map_or(0.0, |mu| cost(k, &mu.median)));
        collect(self.data.len(), |k| if self.is_known(k) { row(k) } else { Row::ZERO })
    }

    /// Where half of a region lies on either side of a gap, all of the gap is a median: the nearest to the one before
    /// is taken, so that what is best already stays.
    fn fit<const M: usize>(&self, weights: &[Row<M>], mu: &mut [Median]) -> Result<f64> {
        let masses = self.data.masses(weights, mu.len());
        // Each vertex comes n times.
        let half = 0.5 * self.copies as f64;
        let halves: Vec<f64> =
            masses.iter().map(|mass| mass.map_or(f64::INFINITY, |mass| half * mass)).collect();
        let mut change = 0.0;
        for (i, sorted) in self.sorted.iter().enumerate() {
            let mut passed = vec![0.0; mu.len()];
            // The least and the largest of all medians of a region.
            let mut ends: Vec<[Option<f64>; 2]> = vec![[None; 2]; mu.len()];
            let mut open = masses.iter().flatten().count();
            for &place in sorted {
                let value = self.data.values[place];
                let row = &weights[place / self.data.dimension].0;
                for (p, (passed, ends)) in passed.iter_mut().zip(&mut ends).enumerate() {
                    *passed += row[p];
                    if ends[1].is_none() && *passed >= halves[p] {
                        ends[0].get_or_insert(value);
                        if *passed > halves[p] {
                            ends[1] = Some(value);
                            open -= 1;
                        }
                    }
                }
                if open == 0 {
                    break;
                }
            }
            for (mu, ends) in mu.iter_mut().zip(ends) {
                let [Some(least), Some(largest)] = ends else { continue };
                let nearest = mu.median[i].clamp(least, largest);
                change = f64::max(change, (nearest - mu.median[i]).abs());
                mu.median[i] = nearest;
            }
        }
        Ok(change)
    }

    /// |mu_a - mu_b|_1.
    fn distance(a: &Median, b: &Median) -> f64 {
        a.median.iter().zip(&b.median).map(|(a, b)| (a - b).abs()).sum()
    }
}

/// int |x - median of x| / area, over what is known.
fn deviation(values: &[f64], area: &[f64]) -> f64 {
    let middle = median(values, area);
    let known = || values.iter().zip(area).filter(|(x, _)| !x.is_nan());
    let total: f64 = known().map(|(_, a)| a).sum();
    known().map(|(x, a)| a * (x - middle).abs()).sum::<f64>() / total
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::PiecewiseConstant;
    use crate::data::constant::Mean;
    use crate::operator::Mass;
    use crate::samples::{bumpy, needles, random_labels, rng, shape};
    use strum::IntoEnumIterator;

    fn random_data(n: usize, dimension: usize) -> Data {
        let mut rng = rng(131);
        Data::new(dimension, (0..n * dimension).map(|_| rng.random()).collect()).unwrap()
    }

    fn medians<const P: usize>(medians: [&[f64]; P]) -> Vec<Median> {
        medians.map(|median| Median { median: median.to_vec() }).to_vec()
    }

    #[test]
    fn costs_are_sums_of_distances() {
        let data = Data::new(2, vec![0.0, 1.0, 3.0, 5.0]).unwrap();
        let costs = L1::new(&data).costs::<2>(&medians([&[0.0, 0.0], &[3.0, 1.0]]));
        assert_eq!(costs, [Row([1.0, 3.0]), Row([8.0, 4.0])]);
    }

    /// The fitted medians minimize sum <u, M s>, for each quadrature: no move of a coordinate of one of them lowers it,
    /// and one beyond all of the data costs at least its length, less the width of the data, times the mass.
    #[test]
    fn the_fit_is_the_minimizer() {
        for mesh in [shape("sphere:2"), bumpy(6).scaled(1e-3), needles(4, 1e-4)] {
            let n = mesh.vertices.len();
            let data = random_data(n, 2);
            let model = L1::new(&data);
            let u = random_labels::<3>(n, 3, &mut rng(132));
            for mass in Mass::iter() {
                let energy = |mu: &[Median]| -> f64 {
                    let f = mass.on(&mesh).integrate(&model.costs::<3>(mu));
                    u.iter().zip(&f).map(|(u, &f)| u.dot(f)).sum()
                };
                let mut mu = medians([&[0.1, 0.9], &[0.5, 0.5], &[2.0, -1.0]]);
                let before = energy(&mu);
                let weights = mass.on(&mesh).integrate(&u);
                model.fit(&weights, &mut mu).unwrap();
                let least = energy(&mu);
                assert!(least < before);
                let moves = [1e-6, 1e-3, 1e-2, 0.1, 0.5, 3.0].into_iter().flat_map(|d| [d, -d]);
                for (p, d) in (0..3).flat_map(|p| moves.clone().map(move |d| (p, d))) {
                    let region: f64 = weights.iter().map(|w| w.0[p]).sum();
                    for i in 0..2 {
                        let mut moved = mu.clone();
                        moved[p].median[i] += d;
                        let rise = energy(&moved) - least;
                        let expected = f64::max(d.abs() - 1.0, 0.0) * region;
                        assert!(rise >= expected - 1e-13 * before, "{mass:?}, {d}: {rise}");
                    }
                }
                assert_eq!(model.fit(&weights, &mut mu).unwrap(), 0.0);
            }
        }
    }

    /// Where a half lies on either side, every place between is a median: one that is there stays, another moves to the
    /// nearest.
    #[test]
    fn of_many_medians_the_nearest_is_taken() {
        let data = Data::new(1, vec![3.0, 0.0, 1.0, 7.0]).unwrap();
        let model = L1::new(&data);
        for (before, after) in [(2.0, 2.0), (0.0, 1.0), (9.0, 3.0), (1.0, 1.0)] {
            let mut mu = medians([&[before]]);
            let change = model.fit(&[Row([1.0]); 4], &mut mu).unwrap();
            assert_eq!((mu[0].median[0], change), (after, f64::abs(after - before)));
        }
        // A vertex without weight is no end of them.
        let weights = [1.0, 1.0, 0.0, 0.0].map(|w| Row([w]));
        let mut mu = medians([&[1.5]]);
        assert_eq!(model.fit(&weights, &mut mu).unwrap(), 0.0);
    }

    /// As long as more than half of a region is in one place, it does not matter where the rest is.
    #[test]
    fn outliers_do_not_move_the_median() {
        let fitted = |far: f64, weight: f64| {
            let data = Data::new(1, [vec![0.25; 60], vec![far; 40]].concat()).unwrap();
            let rows: Vec<Row<1>> =
                (0..100).map(|k| Row([if k < 60 { 1.0 } else { weight }])).collect();
            let mut mu = medians([&[0.5]]);
            L1::new(&data).fit(&rows, &mut mu).unwrap();
            mu[0].median[0]
        };
        for far in [0.5, -3.0, 1e9, -1e300] {
            assert_eq!(fitted(far, 1.0), 0.25);
            // It is the mass that counts, not the number of vertices.
            assert_eq!(fitted(far, 1.6), far);
        }
    }

    /// Of what is not known, costs, medians and the scale take no notice.
    #[test]
    fn unknown_vertices_count_for_nothing() {
        let data = Data::new(2, vec![0.0, 1.0, f64::NAN, 7.0, 4.0, 3.0]).unwrap();
        let model = L1::new(&data);
        let mut mu = medians([&[0.0, 0.0], &[3.0, 1.0]]);
        assert_eq!(model.costs::<2>(&mu)[1], Row::ZERO);
        model.fit(&[Row([0.5, 0.0]), Row([9.0, 9.0]), Row([0.25, 2.0])], &mut mu).unwrap();
        assert_eq!(mu, medians([&[0.0, 1.0], &[4.0, 3.0]]));
        assert_eq!(model.scale(&[1.0, 5.0, 1.0]).distance, 3.0);
    }

    #[test]
    fn an_empty_region_keeps_its_parameters() {
        let data = random_data(5, 2);
        let mut mu = medians([&[0.1; 2], &[7.0, -3.0]]);
        let change = L1::new(&data).fit(&[Row([0.2, 0.0]); 5], &mut mu).unwrap();
        assert_eq!(mu[1].median, [7.0, -3.0]);
        let moved = f64::max((mu[0].median[0] - 0.1).abs(), (mu[0].median[1] - 0.1).abs());
        assert_eq!(change, moved);
        assert!(change > 0.0);
    }

    /// Regions beyond those of the model are padding; their costs are the business of `regions.rs`.
    #[test]
    fn padded_regions_have_no_parameters() {
        let data = random_data(4, 1);
        let model = L1::new(&data);
        let mut mu = medians([&[0.5]; 9]);
        let u = random_labels::<12>(4, 9, &mut rng(133));
        model.fit(&u, &mut mu).unwrap();
        assert!(model.costs::<12>(&mu).iter().all(|s| s.0[9..] == [0.0; 3]));
    }

    /// Data in another unit have a scale in that unit, of which a few values far away change little.
    #[test]
    fn the_scale_has_the_unit_of_the_data() {
        let mut data = random_data(1000, 2);
        let area = vec![0.5; 1000];
        let scale = |data: &Data| L1::new(data).scale(&area).cost;
        let one = scale(&data);
        // Half of the deviations of two coordinates: numbers from 0 to 1 deviate by a quarter in the mean.
        assert!((one - 0.25).abs() < 0.02, "{one}");
        let values = data.values.iter().map(|x| 2.0 * x).collect();
        assert_eq!(scale(&Data { dimension: 2, values }), 2.0 * one);
        data.values[..20].fill(1e9);
        assert!((scale(&data) - one).abs() < 0.05);
        // Two values, one of them rare.
        let values = (0..1000).map(|k| if k < 10 { 1.0 } else { 0.0 }).collect();
        let two = scale(&Data { dimension: 1, values });
        assert!((two - 0.005).abs() < 1e-12, "{two}");
    }

    /// Starts are data, not mixtures of them, whatever the seed; a region that drew no vertex has the median of all.
    #[test]
    fn a_random_start_has_medians() {
        let data = Data::new(1, vec![0.0, 1.0, 5.0, f64::NAN]).unwrap();
        let model = L1::new(&data);
        for seed in 0..20 {
            let mu = model.start(Initial::Random, 9, &[1.0; 4], &mut rng(seed)).unwrap();
            let one_of = |mu: &Median| [0.0, 1.0, 5.0].contains(&mu.median[0]);
            assert!(mu.len() == 9 && mu.iter().all(one_of), "{mu:?}");
            let middle = mu.iter().filter(|mu| mu.median[0] == 1.0).count();
            assert!(middle >= 5, "{mu:?}");
        }
    }

    /// A few values far away are no regions to start from, and no others take their place.
    #[test]
    fn no_region_starts_far_away() {
        let mut rng = rng(135);
        let value = |k: usize| match k % 97 {
            0 => rng.random_range(-1e6..1e6),
            _ => (k % 3) as f64 + rng.random_range(-0.1..0.1),
        };
        let data = Data::new(1, (0..3000).map(value).collect()).unwrap();
        let model = L1::new(&data);
        for seed in 0..5 {
            let mut rng = crate::samples::rng(seed);
            let mu = model.start(Initial::KMeans, 3, &[1.0; 3000], &mut rng).unwrap();
            let mut found: Vec<f64> = mu.iter().map(|mu| mu.median[0]).collect();
            found.sort_by(f64::total_cmp);
            let near = found.iter().zip([0.0, 1.0, 2.0]).all(|(a, b)| (a - b).abs() < 0.05);
            assert!(near, "{found:?}");
        }
    }

    /// Medians of coarse vertices take no notice of a few outliers, means of them take a share of each.
    #[test]
    fn coarse_data_are_medians() {
        let mesh = bumpy(24);
        let mut rng = rng(43);
        let values = mesh.vertices.iter().map(|_| match rng.random_range(0..30) {
            0 => f64::NAN,
            1 => 1e6,
            _ => 0.25,
        });
        let data = Data::new(1, values.collect()).unwrap();
        let weights = Mass::Barycentric.weights(&mesh);
        let level = mesh.coarsened();
        let coarse = level.restricted(&weights, |v| data.is_known(v));
        let restricted = L1::new(&data).restricted(&level, &weights, &coarse);
        let far = restricted.middle(0).iter().filter(|&&x| x != 0.25).count();
        let means = PiecewiseConstant::new(&data).restricted(&level, &weights, &coarse);
        let costs = means.costs::<1>(&[Mean { mean: vec![0.25] }]);
        let moved = costs.iter().filter(|s| s.0[0] > 1e-9).count();
        assert!(far < coarse.len() / 20 && moved > 2 * far, "{far} {moved} of {}", coarse.len());
    }

    /// On a level and on the next costs are nearly the restricted ones, up to what is the same for every region, even for
    /// data that are nothing but noise. Those of the medians alone are not.
    #[test]
    fn coarse_costs_are_nearly_the_restricted_ones() {
        let mesh = shape("torus:60x40");
        let data = random_data(mesh.vertices.len(), 2);
        let mu = medians([&[0.2, 0.9], &[0.5, 0.1], &[0.7, 0.6]]);
        let costs = |model: &L1, weights: &[f64]| -> Vec<Row<3>> {
            model.costs::<3>(&mu).iter().zip(weights).map(|(&s, &w)| s * w).collect()
        };
        let distance = |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| (a[i] - b[i]).abs()).sum::<f64>();
        let (mut model, mut weights) = (L1::new(&data), Mass::Barycentric.weights(&mesh));
        let (mut mesh, mut exact) = (mesh, costs(&model, &weights));
        for _ in 0..2 {
            let level = mesh.coarsened();
            let coarse = level.restricted(&weights, |_| true);
            model = model.restricted(&level, &weights, &coarse);
            exact = crate::transfer::restrict(&level, &exact);
            (mesh, weights) = (level.mesh, coarse);
            let differences = |f: &Row<3>| [f.0[1] - f.0[0], f.0[2] - f.0[0], f.0[2] - f.0[1]];
            let off = |f: &[Row<3>]| -> f64 {
                let pairs = f.iter().zip(&exact).map(|(f, exact)| (differences(f), exact));
                pairs.map(|(f, exact)| distance(f, differences(exact))).sum()
            };
            let size = off(&vec![Row::ZERO; exact.len()]);
            let values = [0, 1].map(|i| model.middle(i));
            let values = (0..exact.len()).flat_map(|k| [values[0][k], values[1][k]]).collect();
            let middle = Data::new(2, values).unwrap();
            let off = [&model, &L1::new(&middle)].map(|model| off(&costs(model, &weights)));
            assert!(off[0] < 0.2 * size && off[1] > 0.5 * size, "{off:?} of {size}");
        }
    }

    /// On a coarse mesh as well the fit is the minimizer.
    #[test]
    fn the_fit_of_coarse_data_is_the_minimizer() {
        let mesh = shape("torus:30x20");
        let data = random_data(mesh.vertices.len(), 2);
        let weights = Mass::Barycentric.weights(&mesh);
        let level = mesh.coarsened();
        let coarse = level.restricted(&weights, |_| true);
        let model = L1::new(&data).restricted(&level, &weights, &coarse);
        let u = random_labels::<3>(coarse.len(), 3, &mut rng(134));
        let weights: Vec<Row<3>> = u.iter().zip(&coarse).map(|(&u, &w)| u * w).collect();
        let energy = |mu: &[Median]| -> f64 {
            model.costs::<3>(mu).iter().zip(&weights).map(|(&s, w)| w.dot(s)).sum()
        };
        let mut mu = medians([&[0.1, 0.9], &[0.5, 0.5], &[2.0, -1.0]]);
        let before = energy(&mu);
        model.fit(&weights, &mut mu).unwrap();
        let least = energy(&mu);
        assert!(least < before && model.fit(&weights, &mut mu).unwrap() == 0.0);
        for (p, i, d) in
            (0..3).flat_map(|p| [(p, 0, 0.01), (p, 1, -0.01), (p, 0, -0.3), (p, 1, 0.3)])
        {
            let mut moved = mu.clone();
            moved[p].median[i] += d;
            assert!(energy(&moved) >= least - 1e-13 * before);
        }
    }
}
