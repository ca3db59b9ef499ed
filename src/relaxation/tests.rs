//! The three sets and their support functions: each is the other's polar, and the three are ordered.

use std::f64::consts::SQRT_2;

use ndarray::Array2;
use rand::RngExt;
use strum::IntoEnumIterator;

use super::set::squares;
use super::*;
use crate::field::{Row, Tangent};
use crate::operator::{Operator, Stencil};
use crate::samples::{assert_within, random_dual_in, random_tangents, rng, zoo};

/// Tangents that sum to zero over the regions, as those of K U do.
fn variations<const M: usize>(n: usize, seed: u64) -> Vec<Tangent<M>> {
    let mut rng = rng(seed);
    let centered = |q: Tangent<M>, m: usize| {
        let row = |row: Row<M>| {
            let mean = row.0[..m].iter().sum::<f64>() / m as f64;
            Row::from_fn(|p| if p < m { row.0[p] - mean } else { 0.0 })
        };
        Tangent(q.0.map(row))
    };
    let mut all = Vec::new();
    for q in random_tangents::<M>(n, &mut rng) {
        all.extend([M, 4, 3, 2].map(|m| centered(q, m.min(M))));
        // Regions whose shares differ by many orders of magnitude.
        let scale = Row::<M>::from_fn(|p| 10_f64.powi(-(2 * p as i32).min(12)));
        let uneven = q.0.map(|row| Row::from_fn(|p| row.0[p] * scale.0[p]));
        all.push(centered(Tangent(uneven), M));
        // Two regions that are nearly opposite, and a small third one.
        let [a, b, c] = [0, 1, 2].map(|_| rng.random_range(-1.0..1.0));
        let row = |x: f64, small: f64| {
            Row::from_fn(|p| match p {
                0 => x,
                1 => -x - 1e-3 * small,
                2 if M > 2 => 1e-3 * small,
                _ => 0.0,
            })
        };
        if M > 2 {
            all.push(Tangent([row(a, c), row(b, a)]));
        }
    }
    all
}

fn metric(m: usize, d: impl Fn(usize, usize) -> f64) -> LabelMetric {
    let d = |(a, b)| if a == b { 0.0 } else { d(usize::min(a, b), usize::max(a, b)) };
    LabelMetric::new(&Array2::from_shape_fn((m, m), d)).unwrap()
}

/// Of four labels, of no points in the plane.
fn uneven() -> LabelMetric {
    const D: [[f64; 4]; 3] = [[0.0, 1.0, 2.0, 0.7], [0.0, 0.0, 1.5, 1.2], [0.0, 0.0, 0.0, 2.3]];
    metric(4, |a, b| D[a][b])
}

/// How far labels are from label 0, through which the ways between all others lead.
const RADII: [f64; 4] = [0.0, 0.4, 1.0, 0.7];

fn star() -> LabelMetric {
    metric(4, |a, b| RADII[a] + RADII[b])
}

/// Labels on a line.
const PLACES: [f64; 4] = [0.0, 0.5, 0.8, 2.0];

fn line() -> LabelMetric {
    metric(4, |a, b| PLACES[b] - PLACES[a])
}

fn support<const M: usize>(relaxation: Relaxation, ku: Tangent<M>) -> f64 {
    with_set!(relaxation, set => set.support(ku))
}

fn all_supports<const M: usize>(ku: Tangent<M>) -> [f64; 3] {
    [Relaxation::Frobenius, Relaxation::Separate, Relaxation::Envelope].map(|it| support(it, ku))
}

fn assert_ordered<const M: usize>() {
    for ku in variations::<M>(200, 401) {
        let [frobenius, separate, envelope] = all_supports(ku);
        let slack = 1.0 + 1e-13;
        assert!(frobenius <= separate * slack && separate <= envelope * slack, "{M}: {ku:?}");
        // No more than a factor, which many regions attain.
        assert!(envelope <= 2.0 * separate, "{M}: {ku:?}");
    }
}

#[test]
fn each_energy_is_at_most_the_next() {
    assert_ordered::<2>();
    assert_ordered::<3>();
    assert_ordered::<5>();
    assert_ordered::<16>();
}

/// With two regions there is one model: the energies are equal, and so are the sets but for the sum of q_j.
#[test]
fn two_regions_have_one_relaxation() {
    for ku in variations::<2>(200, 402) {
        let [frobenius, separate, envelope] = all_supports(ku);
        assert_within(separate, frobenius, 1e-14, frobenius);
        assert_within(envelope, frobenius, 1e-14, frobenius);
        for lambda in [0.1, 1.0, 10.0] {
            let [a, b, c] = [
                Frobenius.project(ku, lambda),
                Separate.project(ku, lambda),
                Envelope(LabelMetric::POTTS).project(ku, lambda),
            ];
            assert!((a - b).norm() <= 1e-14 * lambda && (a - c).norm() <= 1e-12 * lambda);
        }
    }
}

/// A face whose corners have two labels costs the same in all relaxations; one with three labels costs up to 1.2247 and
/// 1.4143 times as much, which equilateral faces attain.
#[test]
fn faces_of_two_labels_cost_the_same() {
    for (name, mesh) in zoo() {
        let mesh = mesh.without_degenerate_faces().0.into_owned();
        let k = Stencil::new(&mesh);
        for j in 0..mesh.faces.len() {
            let corners = mesh.faces[j];
            let cost = |labels: [usize; 3]| {
                let mut u = vec![Row::<4>::ZERO; mesh.vertices.len()];
                let pairs = corners.iter().zip(labels);
                pairs.for_each(|(&v, p)| u[v as usize] = Row::one_hot(p));
                all_supports(k.at(&u, j))
            };
            for labels in [[0, 0, 1], [3, 1, 3], [2, 0, 0]] {
                let [frobenius, separate, envelope] = cost(labels);
                assert_within(separate, frobenius, 1e-13, frobenius);
                assert_within(envelope, frobenius, 1e-13, frobenius);
            }
            let [frobenius, separate, envelope] = cost([2, 0, 1]);
            assert!(separate <= 1.5_f64.sqrt() * frobenius * (1.0 + 1e-13), "{name}");
            assert!(envelope <= 2.0_f64.sqrt() * frobenius * (1.0 + 1e-13), "{name}");
        }
    }
    let column = |turn: f64| [turn.cos(), turn.sin()];
    let third = std::f64::consts::TAU / 3.0;
    let columns = [0.3, 0.3 + third, 0.3 - third].map(column);
    let ku = Tangent([0, 1].map(|axis| Row::<3>::from_fn(|p| columns[p][axis])));
    let [frobenius, separate, envelope] = all_supports(ku);
    assert_within(separate, 1.5_f64.sqrt() * frobenius, 1e-14, 1.0);
    assert_within(envelope, 2.0_f64.sqrt() * frobenius, 1e-14, 1.0);
}

/// The sum of the distances of the corners of a triangle from its Fermat point, for three regions.
#[test]
fn three_regions_have_a_fermat_point() {
    for ku in variations::<3>(300, 403) {
        let Tangent([x, y]) = ku;
        let mut sides = [0, 1, 2].map(|p| f64::hypot(x.0[p], y.0[p]));
        sides.sort_by(f64::total_cmp);
        let [a, b, c] = sides;
        let area = 0.5 * (x.0[0] * y.0[1] - x.0[1] * y.0[0]).abs();
        let distances = if c * c >= a * a + b * b + a * b {
            a + b
        } else {
            (0.5 * (a * a + b * b + c * c) + 12.0_f64.sqrt() * area).sqrt()
        };
        assert_within(
            Envelope(LabelMetric::POTTS).support(ku),
            SQRT_2 * distances,
            1e-12,
            distances,
        );
    }
}

fn assert_supports<const M: usize>(set: impl DualSet) {
    let mut rng = rng(404);
    let feasible = random_dual_in::<M>(set.relaxation(), 300, 1.0, &mut rng);
    assert!(feasible.iter().all(|&q| set.gauge(q) <= 1.0 + 1e-14));
    for ku in variations::<M>(30, 405) {
        let energy = set.support(ku);
        // No feasible q_j gives more...
        for q in &feasible {
            assert!(q.dot(ku) <= energy + 1e-13 * energy);
        }
        // ... and the gradient of the energy is feasible and gives as much. Centered differences err by h^2 over the length
        // of the shortest vector, so only vectors of similar length are tested.
        let lengths = squares(ku).0.map(f64::sqrt);
        let shortest = lengths.iter().copied().filter(|&x| x > 0.0).fold(f64::INFINITY, f64::min);
        if shortest < 0.05 {
            continue;
        }
        let h = 1e-6;
        let mut q = Tangent::ZERO;
        for p in (0..M).filter(|&p| lengths[p] > 0.0) {
            for axis in 0..2 {
                let at = |h: f64| {
                    let mut moved = ku;
                    moved.0[axis].0[p] += h;
                    // The others make up for it, so that the sum stays zero.
                    let others = (0..M).filter(|&o| o != p && lengths[o] > 0.0);
                    let count = others.clone().count() as f64;
                    others.for_each(|o| moved.0[axis].0[o] -= h / count);
                    set.support(moved)
                };
                // The derivative along e_p - (1 - e_p) / count, for q that sums to zero.
                let count = lengths.iter().filter(|&&x| x > 0.0).count() as f64;
                q.0[axis].0[p] = (at(h) - at(-h)) / (2.0 * h) * (count - 1.0) / count;
            }
        }
        if matches!(set.relaxation(), Relaxation::Separate | Relaxation::Metric(_)) {
            // Only a translate of it lies in the balls; and short flows bend the energy more than differences resolve.
            continue;
        }
        assert!(set.gauge(q) <= 1.0 + 1e-6, "{M}: {} {ku:?}", set.gauge(q));
        assert_within(q.dot(ku), energy, 1e-6, energy);
    }
}

/// The energy of a face is max <q_j, (K U)_j> over the set.
#[test]
fn energies_are_support_functions() {
    assert_supports::<3>(Frobenius);
    assert_supports::<7>(Frobenius);
    assert_supports::<3>(Separate);
    assert_supports::<7>(Separate);
    assert_supports::<3>(Envelope(LabelMetric::POTTS));
    assert_supports::<4>(Envelope(LabelMetric::POTTS));
    assert_supports::<7>(Envelope(LabelMetric::POTTS));
    for metric in [uneven(), star(), line()] {
        assert_supports::<4>(Envelope(metric));
    }
}

/// Of all transports from one region to another, those that pass through many others are the cheapest in trees: all
/// that is on one side of an edge passes it.
#[test]
fn transports_in_trees_are_sums_over_edges() {
    for g in variations::<4>(200, 412) {
        let lengths = squares(g).0.map(f64::sqrt);
        let around: f64 = RADII.iter().zip(lengths).map(|(radius, length)| radius * length).sum();
        assert_within(transport::support(g, star()), around, 1e-11, around);
        let mut along = 0.0;
        for i in 1..4 {
            let passing = g.0.map(|row| row.0[..i].iter().sum::<f64>());
            along += (PLACES[i] - PLACES[i - 1]) * f64::hypot(passing[0], passing[1]);
        }
        // Ways from one end to the other cost the same with and without stops, which leaves fewer digits.
        assert_within(transport::support(g, line()), along, 1e-10, along);
    }
}

/// With the weights 1 the metric is that of Potts, whose transports another formula gives; weights scale them.
#[test]
fn transports_of_equal_weights_are_those_of_the_envelope() {
    fn check<const M: usize>(accuracy: f64) {
        let (one, twice) = (metric(M, |_, _| 1.0), metric(M, |_, _| 2.0));
        for g in variations::<M>(100, 413) {
            let expected = diameter::support(g);
            assert_within(transport::support(g, one), expected, accuracy, expected);
            assert_within(transport::support(g, twice), 2.0 * expected, accuracy, 2.0 * expected);
        }
    }
    check::<2>(1e-14);
    check::<3>(1e-12);
    check::<5>(1e-12);
    check::<12>(1e-12);
}

/// Regions to which a metric is larger take no part, but those that are near do.
#[test]
fn a_region_without_a_vector_is_passed_where_that_is_shorter() {
    // Three vectors at 120 degrees: by way of the fourth label they cost its distance each, else one over sqrt(3).
    let third = |p: usize| 2.0 * std::f64::consts::FRAC_PI_3 * p as f64;
    let part = |of: fn(f64) -> f64| Row::<4>::from_fn(|p| if p < 3 { of(third(p)) } else { 0.0 });
    let g = Tangent([part(f64::cos), part(f64::sin)]);
    for (distance, per_vector) in
        [(0.5, 0.5), (0.55, 0.55), (0.6, 3.0_f64.sqrt().recip()), (2.0, 3.0_f64.sqrt().recip())]
    {
        let hub = metric(4, |_, b| if b == 3 { distance } else { 1.0 });
        assert_within(transport::support(g, hub), 3.0 * per_vector, 1e-12, 3.0);
    }
}

#[test]
fn weights_that_are_no_metric_are_refused() {
    let refused = |d: &[[f64; 3]; 3]| {
        let d = Array2::from_shape_fn((3, 3), |(a, b)| d[a][b]);
        LabelMetric::new(&d).unwrap_err().to_string()
    };
    for (d, part) in [
        ([[0.0, 1.0, 3.0], [1.0, 0.0, 1.5], [3.0, 1.5, 0.0]], "lower it to 2.5"),
        ([[0.0, 1.0, 2.0], [1.0, 0.0, 1.5], [2.1, 1.5, 0.0]], "no direction"),
        ([[0.0, 1.0, 1.0], [1.0, 0.5, 1.0], [1.0, 1.0, 0.0]], "to itself"),
        ([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [1.0, 1.0, 0.0]], "positive"),
        ([[0.0, -1.0, 1.0], [-1.0, 0.0, 1.0], [1.0, 1.0, 0.0]], "positive"),
        ([[0.0, 1.0, f64::NAN], [1.0, 0.0, 1.0], [f64::NAN, 1.0, 0.0]], "finite"),
        ([[0.0, 1e-7, 1.0], [1e-7, 0.0, 1.0], [1.0, 1.0, 0.0]], "millionth"),
        ([[0.0, 1e160, 1e160], [1e160, 0.0, 1e160], [1e160, 1e160, 0.0]], "1e-60 to 1e60"),
        ([[0.0, 1e-99, 1e-99], [1e-99, 0.0, 1e-99], [1e-99, 1e-99, 0.0]], "1e-60 to 1e60"),
    ] {
        let message = refused(&d);
        assert!(message.contains(part), "{message}");
    }
    assert!(LabelMetric::new(&Array2::zeros((3, 4))).is_err());
    assert!(LabelMetric::new(&Array2::zeros((1, 1))).is_err());
    // Rounding is no direction.
    let mut d = uneven().matrix();
    d[[1, 2]] *= 1.0 + f64::EPSILON;
    let rounded = LabelMetric::new(&d).unwrap();
    assert_eq!(rounded.distance(1, 2), rounded.distance(2, 1));
    // Equal metrics are one.
    assert!(uneven() == uneven() && uneven() != star() && !metric(3, |_, _| 1.0).is_potts());
    assert_eq!(uneven().matrix()[[3, 1]], 1.2);
}

/// What a projection removes is normal to the set: <q - Pq, Pq> = max_r <q - Pq, r>. So Pq is the nearest feasible point, and
/// <q - Pq, r - Pq> <= 0 for all feasible r. It is feasible in floating point, and keeps the sum and regions with q_p = 0.
///
/// Far outside, with many regions, the projection onto the third set ends before: `accuracy` is in units of the vectors.
fn assert_projects<const M: usize>(set: impl DualSet, scales: &[f64], accuracy: f64) {
    let mut feasible = random_dual_in::<M>(set.relaxation(), 100, 1.0, &mut rng(406));
    feasible.push(Tangent::ZERO);
    for q in variations::<M>(60, 407) {
        for &scale in scales {
            let q = q * scale;
            let projected = set.project(q, 1.0);
            assert!(set.gauge(projected) <= 1.0 + 4.0 * f64::EPSILON);
            let removed = q - projected;
            for &r in &feasible {
                assert!(removed.dot(r - projected) <= accuracy * (1.0 + scale), "{M} {scale}");
            }
            let most = set.support(removed);
            assert_within(removed.dot(projected), most, accuracy, 1.0 + most);
            if set.relaxation() != Relaxation::Separate {
                for (a, b) in projected.0.iter().zip(&q.0) {
                    let sums = [a, b].map(|row| row.0.iter().sum::<f64>());
                    assert_within(sums[0], sums[1], 1e-12, scale);
                }
                let regions = match set.relaxation() {
                    // Points of regions without a vector move with those that are near to them.
                    Relaxation::Metric(_) => 0..0,
                    _ => 0..M,
                };
                for p in regions.filter(|&p| squares(q).0[p] == 0.0) {
                    assert!(squares(projected).0[p].sqrt() <= accuracy, "{M} {scale} {p}");
                }
            }
            let again = set.project(projected, 1.0);
            assert!((again - projected).norm() <= 1e-14);
            if set.gauge(q) <= 1.0 {
                assert_eq!(projected, q);
            }
        }
    }
}

#[test]
fn projections_are_onto_the_sets() {
    let scales = [0.3, 1.0, 2.0, 10.0, 100.0];
    assert_projects::<4>(Frobenius, &scales, 1e-13);
    assert_projects::<4>(Separate, &scales, 1e-13);
    assert_projects::<9>(Separate, &scales, 1e-13);
    assert_projects::<2>(Envelope(LabelMetric::POTTS), &scales, 1e-10);
    assert_projects::<3>(Envelope(LabelMetric::POTTS), &scales, 1e-10);
    assert_projects::<4>(Envelope(LabelMetric::POTTS), &scales, 1e-10);
    assert_projects::<9>(Envelope(LabelMetric::POTTS), &scales[..3], 1e-10);
    assert_projects::<16>(Envelope(LabelMetric::POTTS), &scales[..2], 1e-10);
    assert_projects::<16>(Envelope(LabelMetric::POTTS), &scales[..4], 2e-3);
    for metric in [uneven(), star(), line()] {
        assert_projects::<4>(Envelope(metric), &scales, 1e-9);
    }
}

/// The set of lambda is lambda times that of 1; NaN stays NaN; with lambda = 0 there is only the origin.
#[test]
fn sets_scale_with_lambda() {
    for relaxation in Relaxation::iter() {
        with_set!(relaxation, set => for q in variations::<5>(20, 408) {
            for lambda in [1e-8, 0.25, 1e6] {
                let scaled = set.project(q * lambda, lambda);
                assert!((scaled - set.project(q, 1.0) * lambda).norm() <= 1e-10 * lambda);
                assert!((set.gauge(q * lambda) - lambda * set.gauge(q)).abs() <= 1e-12 * lambda);
            }
            assert_eq!(set.project(q, 0.0).norm(), 0.0);
            let mut broken = q;
            broken.0[1].0[2] = f64::NAN;
            assert!(set.project(broken, 1.0).norm().is_nan() && set.support(broken).is_nan());
        });
    }
}

/// The gradient of the smoothed energy, by differences of order 2; near zero it has the curvature 1 / eps_j.
#[test]
fn the_smoothed_gradient_is_that_of_the_smoothed_energy() {
    let mut rng = rng(409);
    for relaxation in Relaxation::iter() {
        with_set!(relaxation, set => for ku in variations::<5>(10, 410) {
            for radius in [0.03, 0.3, 3.0] {
                let direction = random_tangents::<5>(1, &mut rng)[0];
                let q = set.smoothed_dual(ku, radius, 1.0);
                assert!(set.gauge(q) <= 1.0 + 1e-14);
                let at = |h: f64| set.smoothed(ku + direction * h, radius);
                let size = at(0.0).abs() + radius;
                let h = 1e-5 * radius;
                let slope = (at(h) - at(-h)) / (2.0 * h);
                assert_within(slope, q.dot(direction), 1e-6, 1.0 + size);
                // The curvature of a smoothed energy is at most 1 / eps_j.
                let moved = set.smoothed_dual(ku + direction, radius, 1.0) - q;
                assert!(moved.norm() <= direction.norm() / radius * (1.0 + 1e-9));
            }
            let tiny = set.smoothed_dual(ku * 1e-6, 1.0, 1.0);
            assert!((tiny - ku * 1e-6).norm() <= 1e-11);
        });
    }
}

/// Where only two regions change, `separate` is smoothed like `frobenius`.
#[test]
fn two_regions_are_smoothed_alike() {
    for ku in variations::<2>(50, 411) {
        let wide =
            Tangent(ku.0.map(|row| Row::<9>::from_fn(|p| if p < 2 { row.0[p] } else { 0.0 })));
        for radius in [1e-3, 0.3, 30.0] {
            let [a, b] = [Frobenius.smoothed(ku, radius), Separate.smoothed(wide, radius)];
            assert_within(a, b, 1e-14, a);
        }
    }
}
