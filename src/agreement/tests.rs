//! Measures against sums over all pairs and permutations, against values by hand, and their invariances.

use ndarray::Array2;
use rand::RngExt;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64;

use super::bipartite::{disk, matched};
use super::boundary::edges;
use super::thin::thin;
use super::*;
use crate::samples::rng;

const CLOSE: f64 = 1e-13;

fn random_labels(n: usize, m: i64, rng: &mut Pcg64) -> Vec<i64> {
    (0..n).map(|_| rng.random_range(0..m)).collect()
}

fn random_weights(n: usize, rng: &mut Pcg64) -> Vec<f64> {
    (0..n).map(|_| rng.random_range(0.1..2.0)).collect()
}

fn scores(it: &Agreement) -> [f64; 5] {
    [it.accuracy, it.rand_index, it.adjusted_rand_index, it.variation_of_information, it.covering]
}

fn assert_equal_scores(a: &Agreement, b: &Agreement) {
    for (x, y) in scores(a).into_iter().zip(scores(b)) {
        assert!((x - y).abs() < CLOSE, "{a:?}\n{b:?}");
    }
}

/// All one-to-one maps of rows to columns, as the best sum of entries.
fn best_by_search(gains: &Array2<f64>, row: usize, taken: &mut Vec<bool>) -> f64 {
    if row == gains.nrows() {
        return 0.0;
    }
    // A row may stay without a column where there are more rows.
    let skipped = match gains.nrows() > gains.ncols() {
        true => best_by_search(gains, row + 1, taken),
        false => f64::NEG_INFINITY,
    };
    let mut best = skipped;
    for column in 0..gains.ncols() {
        if !taken[column] {
            taken[column] = true;
            best = best.max(gains[[row, column]] + best_by_search(gains, row + 1, taken));
            taken[column] = false;
        }
    }
    best
}

fn assigned(gains: &Array2<f64>) -> f64 {
    let columns = assignment(gains.view());
    let mut used: Vec<usize> = columns.iter().flatten().copied().collect();
    assert_eq!(used.len(), gains.nrows().min(gains.ncols()));
    used.sort_unstable();
    used.dedup();
    assert_eq!(used.len(), gains.nrows().min(gains.ncols()), "one to one");
    columns.iter().enumerate().filter_map(|(i, j)| j.map(|j| gains[[i, j]])).sum()
}

#[test]
fn the_assignment_is_the_best_of_all_permutations() {
    let mut rng = rng(1);
    for rows in 1..=6 {
        for columns in 1..=6 {
            for _ in 0..20 {
                // Gains of any sign, with many ties.
                let gains = Array2::from_shape_fn((rows, columns), |_| {
                    f64::from(rng.random_range(-3..8)) / 4.0
                });
                let mut gains = gains;
                if rows > columns {
                    // Rows that stay free must not pay off.
                    gains.mapv_inplace(f64::abs);
                }
                let best = best_by_search(&gains, 0, &mut vec![false; columns]);
                assert_eq!(assigned(&gains), best, "{gains}");
            }
        }
    }
}

/// With g_ij = u_i + v_j - slack and a permutation without slack, the optimum is sum u + sum v.
#[test]
fn the_assignment_attains_the_dual_bound_of_hundreds_of_regions() {
    let mut rng = rng(2);
    for (rows, columns) in [(64, 64), (300, 300), (200, 350), (350, 200)] {
        let few = rows.min(columns);
        let mut order: Vec<usize> = (0..rows.max(columns)).collect();
        order.shuffle(&mut rng);
        let u: Vec<f64> = (0..few).map(|_| f64::from(rng.random_range(0..1000))).collect();
        let mut gains = Array2::from_shape_fn((few, rows.max(columns)), |(i, j)| {
            u[i] - f64::from(rng.random_range(0..50)) * if order[i] == j { 0.0 } else { 1.0 }
        });
        if rows > columns {
            gains = gains.reversed_axes();
        }
        assert_eq!(assigned(&gains), u.iter().sum::<f64>(), "{rows} x {columns}");
    }
}

/// Labels 0 0 1 1 and truth 0 0 0 1: p = 1/2, 1/4 and 1/4.
#[test]
fn four_vertices_agree_with_hand_computation() {
    let it = Agreement::new(&[0, 0, 1, 1], &[0, 0, 0, 1], &[1.0; 4]).unwrap();
    assert_eq!((it.regions, it.truth_regions, it.unknown), (2, 2, 0));
    let information = 0.5 + 0.75 * (1.5_f64.log2() * 2.0 / 3.0 + 3.0_f64.log2() / 3.0);
    for (found, exact) in scores(&it).into_iter().zip([0.75, 0.625, 0.25, information, 0.625]) {
        assert!((found - exact).abs() < CLOSE, "{it:?}: {exact}");
    }
    // Among the 6 pairs of distinct vertices 3 disagree: 1 - RI times N / (N - 1).
    assert!(((1.0 - it.rand_index) * 4.0 / 3.0 - 0.5).abs() < CLOSE);
    // One region covers the larger half; three labels against two leave one without a partner.
    let single = Agreement::new(&[7, 7, 7, 7], &[0, 0, 0, 1], &[1.0; 4]).unwrap();
    for (found, exact) in scores(&single).into_iter().zip([0.75, 0.625, 0.0, 0.811_278, 0.625]) {
        assert!((found - exact).abs() < 1e-6, "{single:?}: {exact}");
    }
    let three = Agreement::new(&[0, 1, 2, 2], &[0, 0, 3, 3], &[1.0; 4]).unwrap();
    assert_eq!(three.accuracy, 0.75);
}

#[test]
fn equal_partitions_agree_perfectly_whatever_their_names() {
    let mut rng = rng(3);
    for m in [1, 2, 5, 40] {
        let labels = random_labels(300, m, &mut rng);
        let weights = random_weights(300, &mut rng);
        let mut names: Vec<i64> = (0..m).map(|p| 17 * p + 3).collect();
        names.shuffle(&mut rng);
        let renamed: Vec<i64> = labels.iter().map(|&p| names[p as usize]).collect();
        let it = Agreement::new(&labels, &renamed, &weights).unwrap();
        let [accuracy, rand, adjusted, information, covering] = scores(&it);
        assert_eq!((rand, adjusted, information), (1.0, 1.0, 0.0), "{m}");
        assert!(1.0 - accuracy < CLOSE && 1.0 - covering < CLOSE, "{m}");
    }
}

#[test]
fn names_and_order_of_the_labels_do_not_matter() {
    let mut rng = rng(4);
    for _ in 0..20 {
        let (a, b) = (random_labels(200, 6, &mut rng), random_labels(200, 4, &mut rng));
        let weights = random_weights(200, &mut rng);
        let it = Agreement::new(&a, &b, &weights).unwrap();
        let mut order: Vec<usize> = (0..200).collect();
        order.shuffle(&mut rng);
        let renamed = |labels: &[i64]| order.iter().map(|&k| 100 - labels[k]).collect::<Vec<_>>();
        let weights: Vec<f64> = order.iter().map(|&k| 1e-9 * weights[k]).collect();
        let same = Agreement::new(&renamed(&a), &renamed(&b), &weights).unwrap();
        assert_equal_scores(&it, &same);
    }
}

/// The definition: the weight of all pairs of points on which both agree.
#[test]
fn the_rand_index_is_the_share_of_pairs() {
    let mut rng = rng(5);
    for (m, n) in [(2, 2), (3, 7), (9, 4)] {
        let (a, b) = (random_labels(60, m, &mut rng), random_labels(60, n, &mut rng));
        let weights = random_weights(60, &mut rng);
        let (mut agree, mut all) = (0.0, 0.0);
        for i in 0..60 {
            for j in 0..60 {
                let pair = weights[i] * weights[j];
                all += pair;
                if (a[i] == a[j]) == (b[i] == b[j]) {
                    agree += pair;
                }
            }
        }
        let found = Agreement::new(&a, &b, &weights).unwrap().rand_index;
        assert!((found - agree / all).abs() < CLOSE, "{found}, {}", agree / all);
    }
}

/// With c_ij = 1 if the labels of i and j are equal and p_ij the fraction of truths in which they are, the mean over
/// the truths is the mean over pairs of c_ij p_ij + (1 - c_ij) (1 - p_ij).
#[test]
fn the_mean_rand_index_is_the_probabilistic_one() {
    let mut rng = rng(6);
    let labels = random_labels(50, 3, &mut rng);
    let truths: Vec<Vec<i64>> = (2..7).map(|m| random_labels(50, m, &mut rng)).collect();
    let agreements: Vec<Agreement> =
        truths.iter().map(|truth| Agreement::new(&labels, truth, &[1.0; 50]).unwrap()).collect();
    let mut sum = 0.0;
    for i in 0..50 {
        for j in 0..50 {
            let equal = truths.iter().filter(|truth| truth[i] == truth[j]).count();
            let p = equal as f64 / truths.len() as f64;
            sum += if labels[i] == labels[j] { p } else { 1.0 - p };
        }
    }
    let found = MeanAgreement::of(&agreements).rand_index;
    assert!((found - sum / 2500.0).abs() < CLOSE);
}

/// On a product, every label meets every other in proportion: the expected value of the adjusted index.
#[test]
fn independent_labelings_have_no_adjusted_agreement() {
    let (rows, columns): (Vec<i64>, Vec<i64>) =
        (0..6).flat_map(|a| (0..5).map(move |b| (a, b))).unzip();
    let weights: Vec<f64> =
        rows.iter().zip(&columns).map(|(&a, &b)| (1 + a * a) as f64 * (2 + b) as f64).collect();
    let it = Agreement::new(&rows, &columns, &weights).unwrap();
    assert!(it.adjusted_rand_index.abs() < CLOSE && it.rand_index > 0.5, "{it:?}");
}

#[test]
fn the_variation_of_information_is_a_metric() {
    let mut rng = rng(7);
    let entropy = |shares: Vec<f64>| -> f64 { shares.iter().map(|p| -p * p.log2()).sum() };
    for trial in 0..200 {
        let n = 5 + trial % 40;
        let weights = random_weights(n, &mut rng);
        let [a, b, c] = [2, 4, 3].map(|m| random_labels(n, m, &mut rng));
        let distance =
            |a: &[i64], b: &[i64]| Agreement::new(a, b, &weights).unwrap().variation_of_information;
        let (ab, bc, ac) = (distance(&a, &b), distance(&b, &c), distance(&a, &c));
        assert!(ac <= ab + bc + CLOSE, "{ac} > {ab} + {bc}");
        assert!((ab - distance(&b, &a)).abs() < CLOSE);
        // 2 H(a, b) - H(a) - H(b), another formula.
        let confusion = Confusion::new(&a, &b, &weights).unwrap();
        let joint: Vec<f64> = confusion.shares.iter().copied().filter(|&p| p > 0.0).collect();
        let (h_a, h_b) = (entropy(confusion.row_sums()), entropy(confusion.column_sums()));
        assert!((ab - (2.0 * entropy(joint) - h_a - h_b)).abs() < CLOSE);
    }
}

#[test]
fn a_weight_of_two_is_a_vertex_twice() {
    let mut rng = rng(8);
    let (a, b) = (random_labels(80, 4, &mut rng), random_labels(80, 5, &mut rng));
    let times: Vec<usize> = (0..80).map(|_| rng.random_range(0..4)).collect();
    let repeated = |labels: &[i64]| -> Vec<i64> {
        labels.iter().zip(&times).flat_map(|(&p, &n)| vec![p; n]).collect()
    };
    let weights: Vec<f64> = times.iter().map(|&n| n as f64).collect();
    let weighted = Agreement::new(&a, &b, &weights).unwrap();
    let (a, b) = (repeated(&a), repeated(&b));
    assert_equal_scores(&weighted, &Agreement::new(&a, &b, &vec![1.0; a.len()]).unwrap());
}

#[test]
fn unknown_vertices_are_left_out_and_counted() {
    let mut rng = rng(9);
    let (a, b) = (random_labels(90, 3, &mut rng), random_labels(90, 3, &mut rng));
    let weights = random_weights(90, &mut rng);
    let known = Agreement::new(&a, &b, &weights).unwrap();
    let with = |labels: &[i64], more: [i64; 3]| [labels, &more].concat();
    let weights = [weights.as_slice(), &[3.0, 4.0, 5.0]].concat();
    let it = Agreement::new(&with(&a, [-1, 2, -7]), &with(&b, [0, -1, -1]), &weights).unwrap();
    assert_eq!(it, Agreement { unknown: 3, ..known });
}

#[test]
fn labelings_without_a_common_vertex_or_with_too_many_labels_are_refused() {
    let error = |a: &[i64], b: &[i64], weights: &[f64]| {
        Agreement::new(a, b, weights).unwrap_err().to_string()
    };
    assert!(error(&[-1, 0], &[0, -1], &[1.0; 2]).contains("known label"));
    assert!(error(&[0, 0], &[0, 1], &[0.0; 2]).contains("no vertex has a weight"));
    let many: Vec<i64> = (0..=MAX_LABELS as i64).collect();
    let (one, weights) = (vec![0; many.len()], vec![1.0; many.len()]);
    assert!(error(&many, &one, &weights).starts_with("the labeling has more than 1024"));
    assert!(error(&one, &many, &weights).starts_with("the truth has more than 1024"));
    let most = &many[1..];
    let it = Agreement::new(most, most, &weights[1..]).unwrap();
    assert!((it.accuracy - 1.0).abs() < CLOSE && it.variation_of_information == 0.0);
}

/// Labels of an image whose regions are vertical stripes that begin at these columns.
fn stripes([width, height]: [usize; 2], begins: &[usize]) -> Vec<i64> {
    let label = |i: usize| begins.iter().filter(|&&begin| begin <= i % width).count() as i64;
    (0..width * height).map(label).collect()
}

/// The diagonal of 200 x 100 pixels is 223.6, the tolerance 1.68 pixels.
#[test]
fn boundaries_match_within_the_tolerance() {
    let size = [200, 100];
    let truth = stripes(size, &[80]);
    let score = |begins: &[usize]| {
        let it = boundaries(&stripes(size, begins), &[&truth], size).unwrap();
        assert_eq!(it.each, [it.all]);
        [it.all.precision, it.all.recall, it.all.f]
    };
    assert_eq!(score(&[80]), [1.0, 1.0, 1.0]);
    assert_eq!(score(&[81]), [1.0, 1.0, 1.0]);
    assert_eq!(score(&[78]), [0.0, 0.0, 0.0]);
    assert_eq!(score(&[20, 60, 80, 140]), [0.25, 1.0, 0.4]);
    assert_eq!(score(&[]), [1.0, 0.0, 0.0]);
    let flat = stripes(size, &[]);
    let it = boundaries(&flat, &[&flat], size).unwrap().all;
    assert_eq!([it.precision, it.recall, it.f], [1.0; 3]);
}

/// Within 2.7 pixels, both of two lines are near the one of the truth, but one finds no partner.
#[test]
fn boundary_pixels_match_one_to_one() {
    let size = [300, 200];
    let (two, one) = (stripes(size, &[80, 82]), stripes(size, &[81]));
    let it = boundaries(&two, &[&one], size).unwrap().all;
    assert_eq!([it.precision, it.recall, it.f], [0.5, 1.0, 2.0 / 3.0]);
}

#[test]
fn several_truths_share_precision_and_average_recall() {
    let size = [200, 100];
    let [left, right, both] = [&[40][..], &[150], &[40, 150]].map(|begins| stripes(size, begins));
    let it = boundaries(&both, &[&left, &right], size).unwrap();
    assert_eq!(it.all, Boundary { precision: 1.0, recall: 1.0, f: 1.0 });
    assert_eq!(it.each, [Boundary { precision: 0.5, recall: 1.0, f: 2.0 / 3.0 }; 2]);
    let it = boundaries(&left, &[&left, &right], size).unwrap();
    assert_eq!(it.all, Boundary { precision: 1.0, recall: 0.5, f: 2.0 / 3.0 });
}

/// A single pixel is seen from itself, from the left, from above and from the upper left.
#[test]
fn edges_are_left_and_above_of_where_labels_change() {
    let mut dot = vec![0; 25];
    dot[12] = 1;
    let on_edge = |labels: &[i64]| {
        let edges = edges(labels, 5);
        (0..25).filter(|&at| edges[at]).collect::<Vec<usize>>()
    };
    assert_eq!(on_edge(&dot), [6, 7, 11, 12]);
    assert_eq!(on_edge(&grid_image(&dot, 5)), [6, 7, 11, 12]);
    dot[12] = -1;
    assert!(on_edge(&dot).is_empty());
    assert_eq!(grid_image(&[1, 2, 3, 4, 5, 6], 2), [5, 6, 3, 4, 1, 2]);
}

/// The number of parts of a set of pixels that are connected by their eight neighbors.
fn parts(set: &[bool], width: usize) -> usize {
    let mut left = set.to_vec();
    let mut parts = 0;
    for start in 0..set.len() {
        let mut stack = vec![start];
        parts += usize::from(left[start]);
        while let Some(at) = stack.pop() {
            if std::mem::take(&mut left[at]) {
                for dy in [-1, 0, 1] {
                    for dx in [-1, 0, 1] {
                        let (x, y) = ((at % width) as i64 + dx, (at / width) as i64 + dy);
                        if x >= 0 && y >= 0 && (x as usize) < width {
                            let next = y as usize * width + x as usize;
                            stack.extend((next < set.len()).then_some(next));
                        }
                    }
                }
            }
        }
    }
    parts
}

#[test]
fn thinning_keeps_connected_parts_and_ends_at_lines() {
    let mut rng = rng(12);
    for trial in 0..100 {
        let (width, height) = (rng.random_range(1..40), rng.random_range(1..30));
        let density = 0.1 + 0.008 * f64::from(trial);
        let set: Vec<bool> = (0..width * height).map(|_| rng.random::<f64>() < density).collect();
        let mut thinned = set.clone();
        thin(&mut thinned, width);
        assert!(thinned.iter().zip(&set).all(|(&thinned, &was)| was || !thinned));
        assert_eq!(parts(&thinned, width), parts(&set, width));
        let mut again = thinned.clone();
        thin(&mut again, width);
        assert_eq!(again, thinned);
    }
    // A bar becomes a line.
    let mut bar: Vec<bool> = (0..60 * 20).map(|at| (8..13).contains(&(at / 60))).collect();
    thin(&mut bar, 60);
    let rows: Vec<usize> = bar.chunks(60).map(|row| row.iter().filter(|&&it| it).count()).collect();
    assert!(rows[10] > 50 && rows.iter().sum::<usize>() == rows[10], "{rows:?}");
    // A line stays.
    let line: Vec<bool> = (0..60 * 20).map(|at| at % 60 == 31).collect();
    let mut thinned = line.clone();
    thin(&mut thinned, 60);
    assert_eq!(thinned, line);
}

#[test]
fn exchanging_labels_and_truth_exchanges_precision_and_recall() {
    let mut rng = rng(10);
    let size = [150, 120];
    let mut blobs = || {
        let centers: Vec<[f64; 2]> =
            (0..9).map(|_| [rng.random_range(0.0..150.0), rng.random_range(0.0..120.0)]).collect();
        let nearest = |at: usize| {
            let [x, y] = [(at % 150) as f64, (at / 150) as f64];
            let distance = |c: &[f64; 2]| (c[0] - x).hypot(c[1] - y);
            let by_distance =
                |&a: &usize, &b: &usize| distance(&centers[a]).total_cmp(&distance(&centers[b]));
            (0..9).min_by(by_distance).unwrap() as i64
        };
        (0..150 * 120).map(nearest).collect::<Vec<i64>>()
    };
    let (a, b) = (blobs(), blobs());
    let forth = boundaries(&a, &[&b], size).unwrap().all;
    let back = boundaries(&b, &[&a], size).unwrap().all;
    assert!(forth.f > 0.0 && forth.f < 1.0);
    assert_eq!((forth.precision, forth.recall), (back.recall, back.precision));
    assert_eq!(forth.f, back.f);
}

/// The size of a largest matching is the value of the optimal assignment with gain 1 for each pair that may match.
#[test]
fn pixels_are_matched_as_often_as_possible() {
    let mut rng = rng(11);
    for trial in 0..60 {
        let (width, height) = (rng.random_range(1..14), rng.random_range(1..10));
        let distance = [0.0, 1.0, 1.5, 2.0, 3.2][trial % 5];
        let mut random = |density: f64| -> Vec<bool> {
            (0..width * height).map(|_| rng.random::<f64>() < density).collect()
        };
        let (first, second) = (random(0.3), random(0.25));
        let pixels = |set: &[bool]| -> Vec<usize> { (0..set.len()).filter(|&i| set[i]).collect() };
        let (a, b) = (pixels(&first), pixels(&second));
        let gains = Array2::from_shape_fn((a.len(), b.len()), |(i, j)| {
            let [dx, dy] = [
                (a[i] % width) as f64 - (b[j] % width) as f64,
                (a[i] / width) as f64 - (b[j] / width) as f64,
            ];
            f64::from(u8::from(dx.hypot(dy) <= distance))
        });
        let most = match gains.is_empty() {
            true => 0.0,
            false => assigned(&gains),
        };
        let matched = matched(&first, &second, width, &disk(distance, [width, height]));
        assert_eq!(matched.len(), a.len());
        assert_eq!(matched.iter().filter(|&&it| it).count() as f64, most, "{width} x {height}");
    }
}

#[test]
fn noise_over_a_large_image_is_refused() {
    let size = [4000, 3000];
    let noise: Vec<i64> = (0..12_000_000).map(|i| i64::from(i % 3 == 0)).collect();
    let error = boundaries(&noise, &[&noise], size).unwrap_err().to_string();
    assert!(error.contains("boundary pixels in 4000 x 3000 pixels, too many"), "{error}");
}
