//! Labels that are given: seeds are hard constraints of the problem that is certified.

use super::*;
use crate::solve::solve_seeded;
use crate::start::Start;
use ndarray::Array2;

/// Seeds of region 0 at the left end of a grid and of region 1 at the right end, in a square of side 1.
fn ends(mesh: &Mesh) -> Seeds {
    let [low, high] =
        [f64::min, f64::max].map(|end| mesh.vertices.iter().map(|x| x.x).reduce(end).unwrap());
    let seed = |x: f64| if x == low { Some(0) } else { (x == high).then_some(1) };
    Seeds::new(mesh.vertices.iter().map(|x| seed(x.x)).collect())
}

fn side(mesh: &Mesh) -> f64 {
    mesh.area().sqrt()
}

/// Without data, two regions that contain opposite sides of a square are separated by the shortest cut, a straight line:
/// E* = sqrt(2) lambda times the side, which a u that is linear between the sides attains.
#[test]
fn seeds_at_opposite_sides_of_a_square_are_separated_by_the_shortest_cut() {
    let mesh = shape("grid:12x12");
    let s = Array2::zeros((mesh.vertices.len(), 2));
    for mass in Mass::iter() {
        for coarse_to_fine in [false, true] {
            let lambda = 0.7;
            let request = Request { coarse_to_fine, ..request(lambda, mass) };
            let found =
                solve_seeded(&mesh, &s, &ends(&mesh), &Start::Argmin, &request, &mut go).unwrap();
            let exact = 2.0_f64.sqrt() * lambda * side(&mesh);
            let summary = &found.summary;
            assert!(summary.dual_bound <= exact * (1.0 + 1e-12), "{}", summary.dual_bound);
            assert!(summary.energy >= exact * (1.0 - 1e-12), "{}", summary.energy);
            assert!(summary.relative_gap <= 1e-4);
            // A straight cut along grid lines is optimal among the labelings, too.
            assert_within(summary.rounded_energy, exact, 2e-4, exact);
            check_agreement(&found.labels, &ends(&mesh));
        }
    }
}

fn check_agreement(labels: &ndarray::Array1<i32>, seeds: &Seeds) {
    for (k, &label) in labels.iter().enumerate() {
        assert!(seeds.region(k).is_none_or(|p| p == label as usize), "{k}");
    }
}

/// The bound is below, and the energy of the labels above, the best of all labelings that agree with the seeds, some of
/// which contradict the data.
#[test]
fn the_certificate_holds_for_all_labelings_that_agree_with_the_seeds() {
    let mesh = shape("grid:2x2");
    let n = mesh.vertices.len();
    let mut rng = rng(11);
    for _ in 0..20 {
        let s = Array2::from_shape_fn((n, 2), |_| rng.random_range(-1.0..1.0));
        let seeds = Seeds::new(
            (0..n).map(|_| [None, None, Some(0), Some(1)][rng.random_range(0..4)]).collect(),
        );
        let request = request(0.3, Mass::Consistent);
        let found = solve_seeded(&mesh, &s, &seeds, &Start::Argmin, &request, &mut go).unwrap();
        let rows = |s: &Array2<f64>| regions::rows::<2>(s.view());
        let problem = problem_of::<2>(&mesh, 2, rows(&s), &request).unwrap();
        let energy = |code: usize| {
            let u: Vec<Row<2>> = (0..n).map(|k| Row::one_hot(code >> k & 1)).collect();
            problem.baseline + problem.energy(&u)
        };
        let agrees =
            |code: &usize| (0..n).all(|k| seeds.region(k).is_none_or(|p| p == code >> k & 1));
        let least = (0..1 << n).filter(agrees).map(energy).fold(f64::INFINITY, f64::min);
        let summary = &found.summary;
        assert!(summary.dual_bound <= least + 1e-12 && summary.rounded_energy >= least - 1e-12);
        check_agreement(&found.labels, &seeds);
    }
}

/// One seed per region is enough to number the regions, also if another seed contradicts its datum.
#[test]
fn seeds_number_the_regions() {
    let mesh = shape("sphere:4");
    let (data, truth) = painted(&mesh, 0.25);
    let region = [2, 0, 1];
    let mut given = vec![None; truth.len()];
    for (t, &p) in region.iter().enumerate() {
        let first = truth.iter().position(|&other| other == t).unwrap();
        given[first] = Some(p as u8);
    }
    let contrary = truth.iter().rposition(|&t| t == 0).unwrap();
    given[contrary] = Some(1);
    let seeds = Seeds::new(given);
    for coarse_to_fine in [false, true] {
        let labels = truth.iter().map(|&t| region[t]).collect();
        let alternation = Alternation {
            seeds: seeds.clone(),
            labels: Some(labels),
            ..alternation(Initial::KMeans, 5)
        };
        let request = Request { coarse_to_fine, ..request(0.03, Mass::Barycentric) };
        let model = PiecewiseConstant::new(&data);
        let found = segment(&mesh, &model, &alternation, &request, &mut go).unwrap();
        let labels = &found.solution.labels;
        check_agreement(labels, &seeds);
        let right = truth.iter().zip(labels).filter(|&(&t, &l)| region[t] == l as usize).count();
        assert!(right as f64 > 0.97 * truth.len() as f64, "{right}");
        assert!(found.solution.summary.relative_gap <= 1e-4);
    }
}

/// Regions with seeds are not merged although their data are the same.
#[test]
fn regions_of_the_same_data_are_separated_by_their_seeds() {
    let mesh = shape("grid:12x12");
    let data = Data::new(1, vec![0.5; mesh.vertices.len()]).unwrap();
    let seeds = ends(&mesh);
    let alternation =
        Alternation { regions: 2, seeds: seeds.clone(), ..alternation(Initial::KMeans, 5) };
    let model = PiecewiseConstant::new(&data);
    let request = request(0.1, Mass::Barycentric);
    let found = segment(&mesh, &model, &alternation, &request, &mut go).unwrap();
    check_agreement(&found.solution.labels, &seeds);
    let exact = 2.0_f64.sqrt() * 0.1 * side(&mesh);
    assert_within(found.solution.summary.energy, exact, 1e-4, exact);
}

#[test]
fn wrong_seeds_are_refused() {
    let mesh = shape("grid:2x2");
    let n = mesh.vertices.len();
    let with = |k: usize, p: u8, count: usize| {
        let mut given = vec![None; count];
        given[k] = Some(p);
        Seeds::new(given)
    };
    let mut s = Array2::zeros((n, 2));
    let request = request(0.1, Mass::Barycentric);
    let message = |s: &Array2<f64>, seeds: Seeds| {
        let found = solve_seeded(&mesh, s, &seeds, &Start::Argmin, &request, &mut go);
        found.err().expect("it is refused").to_string()
    };
    assert!(message(&s, with(3, 2, n)).contains("vertex 3 is a seed of region 2"));
    assert!(message(&s, with(3, 1, n + 1)).contains("the seeds are those of 10 vertices"));
    s[[3, 1]] = f64::INFINITY;
    assert!(message(&s, with(3, 1, n)).contains("that its costs forbid"));
}
