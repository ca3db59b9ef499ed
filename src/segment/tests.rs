//! The alternation recovers what was painted, repeats itself, and ends with a valid certificate.

use std::borrow::Cow;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::Duration;

use rand::RngExt;

use super::*;
use crate::data::constant::Mean;
use crate::data::l1::Median;
use crate::data::{Data, L1, PiecewiseConstant};
use crate::mesh::coarsen::Coarsening;
use crate::operator::Mass;
use crate::run::Sample;
use crate::samples::{assert_within, rng, shape};
use crate::solve::problem_of;
use crate::solver::Method;

const PALETTE: [[f64; 3]; 3] = [[0.9, 0.1, 0.1], [0.1, 0.8, 0.2], [0.2, 0.1, 0.7]];

fn go(_: Option<&Sample>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// The unit sphere in three bands of equal area, with noise of the given amplitude.
fn painted(mesh: &Mesh, noise: f64) -> (Data, Vec<usize>) {
    let mut rng = rng(111);
    let band = |z: f64| {
        if z < -1.0 / 3.0 {
            0
        } else if z < 1.0 / 3.0 {
            1
        } else {
            2
        }
    };
    let truth: Vec<usize> = mesh.vertices.iter().map(|x| band(x.z)).collect();
    let values = truth
        .iter()
        .flat_map(|&p| PALETTE[p])
        .map(|c| c + noise * rng.random_range(-1.0..1.0))
        .collect();
    (Data::new(3, values).unwrap(), truth)
}

fn request(lambda: f64, mass: Mass) -> Request {
    Request {
        lambda,
        mass,
        method: Method::default(),
        stop: Stop { relative_gap: Some(1e-4), iterations: Some(20_000), ..Stop::default() },
        coarse_to_fine: false,
        keep_dual: false,
    }
}

fn alternation(initial: Initial, seed: u64) -> Alternation {
    Alternation { regions: 3, initial, seed, every: 10 }
}

/// The region of each color of the palette, by the nearest mean; all three must be different.
fn matched<D: DataModel>(parameters: &[D::Parameters], tolerance: f64) -> [usize; 3] {
    let found = PALETTE.map(|color| {
        let distance = |mean: &[f64]| -> f64 {
            mean.iter().zip(color).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
        };
        let of = |p: usize| distance(D::told(&parameters[p]));
        let best = (0..3).min_by(|&a, &b| of(a).total_cmp(&of(b))).unwrap();
        assert!(of(best) <= tolerance, "{color:?} is missing in {parameters:?}");
        best
    });
    assert!(found[0] != found[1] && found[1] != found[2] && found[0] != found[2]);
    found
}

#[test]
fn three_colors_are_recovered() {
    let mesh = shape("sphere:4");
    let (data, truth) = painted(&mesh, 0.25);
    for mass in Mass::NAMES.map(|(_, mass)| mass) {
        for initial in [Initial::KMeans, Initial::Random] {
            let request = request(0.03, mass);
            let found = segment(
                &mesh,
                &PiecewiseConstant::new(&data),
                &alternation(initial, 5),
                &request,
                &mut go,
            )
            .unwrap();
            let region = matched::<PiecewiseConstant>(&found.parameters, 0.03);
            let labels = &found.solution.labels;
            let right =
                truth.iter().zip(labels).filter(|&(&t, &l)| region[t] == l as usize).count();
            assert!(right as f64 > 0.97 * truth.len() as f64, "{mass:?}, {initial:?}: {right}");
            let summary = &found.solution.summary;
            assert_eq!(summary.status, Status::Converged, "{mass:?}, {initial:?}");
            assert!(summary.dual_bound <= summary.energy && summary.relative_gap <= 1e-4);
            assert!(found.estimates > 0);
        }
    }
}

/// The final energy is the one of the parameters that are reported, and so is the bound.
#[test]
fn the_certificate_is_for_the_reported_parameters() {
    let mesh = shape("sphere:3");
    let (data, _) = painted(&mesh, 0.2);
    for mass in Mass::NAMES.map(|(_, mass)| mass) {
        let request = request(0.05, mass);
        let found = segment(
            &mesh,
            &PiecewiseConstant::new(&data),
            &alternation(Initial::KMeans, 1),
            &request,
            &mut go,
        )
        .unwrap();
        let costs = || PiecewiseConstant::new(&data).costs::<3>(&found.parameters);
        let problem = problem_of::<3>(&mesh, 3, costs(), &request).unwrap();
        let u = regions::rows::<3>(found.solution.u.view());
        let summary = &found.solution.summary;
        let energy = problem.baseline + problem.energy(&u);
        assert_within(energy, summary.energy, 1e-12, summary.energy);
        let s = regions::array(&costs(), 3);
        let start = crate::start::Start::Uniform;
        let exact = crate::solve::solve(&mesh, &s, &start, &request, &mut go).unwrap().summary;
        assert!(summary.dual_bound <= exact.energy && exact.dual_bound <= summary.energy);
    }
}

/// U and mu in turn: neither step raises the energy, the steps of U but for the gap they leave.
fn the_energy_of_a_model_does_not_rise<D: DataModel>(
    mesh: &Mesh,
    model: &D,
    first: &[D::Parameters],
) {
    for mass in Mass::NAMES.map(|(_, mass)| mass) {
        let request = request(0.05, mass);
        let mut mu = first.to_vec();
        let mut before = f64::INFINITY;
        for _ in 0..6 {
            let s = regions::array(&model.costs::<3>(&mu), 3);
            let start = crate::start::Start::Uniform;
            let solution = crate::solve::solve(mesh, &s, &start, &request, &mut go).unwrap();
            let energy = solution.summary.energy;
            assert!(energy <= before * (1.0 + 1e-4), "{mass:?}: {before} {energy}");
            let u = regions::rows::<3>(solution.u.view());
            model.fit::<3>(&mass.on(mesh).integrate(&u), &mut mu).unwrap();
            let problem = problem_of::<3>(mesh, 3, model.costs(&mu), &request).unwrap();
            before = problem.baseline + problem.energy(&u);
            assert!(before <= energy * (1.0 + 1e-12), "{mass:?}: {energy} {before}");
        }
    }
}

#[test]
fn the_energy_does_not_rise() {
    let mesh = shape("sphere:3");
    let (data, _) = painted(&mesh, 0.4);
    let first = [[0.4; 3], [0.5; 3], [0.6, 0.4, 0.5]].map(|mu| mu.to_vec());
    let means = first.clone().map(|mean| Mean { mean });
    the_energy_of_a_model_does_not_rise(&mesh, &PiecewiseConstant::new(&data), &means);
    let medians = first.map(|median| Median { median });
    the_energy_of_a_model_does_not_rise(&mesh, &L1::new(&data), &medians);
}

#[test]
fn the_same_seed_gives_the_same_result() {
    let mesh = shape("sphere:3");
    let (data, _) = painted(&mesh, 0.3);
    for initial in [Initial::KMeans, Initial::Random] {
        let result = |seed: u64| {
            let request = request(0.03, Mass::Barycentric);
            let found = segment(
                &mesh,
                &PiecewiseConstant::new(&data),
                &alternation(initial, seed),
                &request,
                &mut go,
            )
            .unwrap();
            (found.solution.u, found.parameters, found.estimates)
        };
        assert_eq!(result(3), result(3));
        assert_ne!(result(3).0, result(4).0, "{initial:?}: the seed has no effect");
    }
}

/// Means are those of integrals: where vertices lie densely each counts less.
#[test]
fn parameters_are_means_by_area() {
    let mut mesh = shape("grid:60x20");
    mesh.vertices.iter_mut().for_each(|x| x.x = x.x.powi(3));
    let data = Data::new(1, mesh.vertices.iter().map(|x| x.x).collect()).unwrap();
    for mass in Mass::NAMES.map(|(_, mass)| mass) {
        let alternation = Alternation { regions: 2, ..alternation(Initial::KMeans, 5) };
        let found = segment(
            &mesh,
            &PiecewiseConstant::new(&data),
            &alternation,
            &request(1e-3, mass),
            &mut go,
        )
        .unwrap();
        let u = regions::rows::<2>(found.solution.u.view());
        let weights = mass.on(&mesh).integrate(&u);
        for (p, region) in found.parameters.iter().enumerate() {
            let total: f64 = weights.iter().map(|w| w.0[p]).sum();
            let mean =
                weights.iter().zip(&data.values).map(|(w, c)| w.0[p] * c).sum::<f64>() / total;
            assert!((region.mean[0] - mean).abs() < 2e-3, "{mass:?}: {region:?} {mean}");
        }
    }
}

/// Data in another unit, and lambda with it, take the same way to the same labels.
#[test]
fn the_unit_of_the_data_does_not_matter() {
    let mesh = shape("sphere:3");
    let (data, _) = painted(&mesh, 0.4);
    let found = |unit: f64, regions: usize| {
        let values = data.values.iter().map(|c| c * unit).collect();
        let alternation = Alternation { regions, ..alternation(Initial::Random, 5) };
        let request = request(0.05 * unit * unit, Mass::Barycentric);
        let data = Data::new(3, values).unwrap();
        let found = segment(&mesh, &PiecewiseConstant::new(&data), &alternation, &request, &mut go)
            .unwrap();
        (found.estimates, found.solution.labels)
    };
    for regions in [3, 5] {
        let one = found(1.0, regions);
        // Powers of two round nothing.
        for exponent in [-14, 14] {
            assert_eq!(found(2.0_f64.powi(exponent), regions), one, "{exponent}");
        }
    }
}

/// The parameters are estimated until they move by no more than the share of their range that counts as settled, and no
/// longer.
#[test]
fn estimates_end_with_the_first_that_moves_little() {
    let mesh = shape("sphere:3");
    let (data, _) = painted(&mesh, 0.4);
    let data = Data::new(1, data.values.iter().copied().step_by(3).collect()).unwrap();
    let alternation = Alternation { regions: 2, ..alternation(Initial::Random, 5) };
    let found = |iterations: u64| {
        let mut request = request(0.05, Mass::Barycentric);
        request.stop.iterations = Some(iterations);
        let found = segment(&mesh, &PiecewiseConstant::new(&data), &alternation, &request, &mut go)
            .unwrap();
        (found.estimates, found.parameters)
    };
    let (estimates, settled) = found(20_000);
    assert!(estimates >= 3);
    // What is left after so many estimates is too little for another.
    let after = |n: usize| {
        let (estimates, parameters) = found(alternation.every * (n as u64 + 1));
        assert_eq!(estimates, n);
        parameters
    };
    let parameters: Vec<_> = (1..=estimates).map(after).collect();
    let scale = PiecewiseConstant::new(&data).scale(&Mass::Barycentric.weights(&mesh));
    assert_eq!(*parameters.last().unwrap(), settled);
    for (n, pair) in parameters.windows(2).enumerate() {
        let moved = pair[0].iter().zip(&pair[1]).map(|(a, b)| (a.mean[0] - b.mean[0]).abs());
        let little = moved.fold(0.0, f64::max) <= SETTLED * scale.change;
        assert_eq!(little, n + 2 == estimates, "{n}");
    }
}

/// The limit is one for all steps, before and after re-estimations; and parameters that still move are said.
#[test]
fn the_limit_of_iterations_counts_all() {
    let mesh = shape("sphere:3");
    let (data, _) = painted(&mesh, 0.4);
    for most in [5, 25, 95] {
        let mut request = request(0.05, Mass::Barycentric);
        request.stop = Stop { relative_gap: Some(0.0), iterations: Some(most), ..Stop::default() };
        let alternation = Alternation { every: 3, ..alternation(Initial::Random, 5) };
        let found = segment(&mesh, &PiecewiseConstant::new(&data), &alternation, &request, &mut go)
            .unwrap();
        let summary = found.solution.summary;
        assert!(summary.iterations <= most, "{} of {most}", summary.iterations);
        let said = summary.warnings.iter().any(|warning| warning.contains("still moved"));
        assert!(said || most > 5, "{:?}", summary.warnings);
    }
}

/// What ended the run is what could be raised, if anything.
#[test]
fn advice_is_about_what_ended_the_run() {
    let mesh = shape("sphere:3");
    let (data, _) = painted(&mesh, 0.4);
    let alternation = alternation(Initial::Random, 5);
    let advice = |stop: Stop, observe: Observer<'_>| {
        let mut request = request(0.05, Mass::Barycentric);
        request.stop = Stop { relative_gap: Some(0.0), ..stop };
        let found = segment(&mesh, &PiecewiseConstant::new(&data), &alternation, &request, observe)
            .unwrap();
        let warnings = found.solution.summary.warnings;
        let said = warnings.into_iter().find(|warning| warning.contains("still moved")).unwrap();
        said.split_once("raise ").map(|(_, advice)| advice.to_owned())
    };
    let few = Stop { iterations: Some(5), ..Stop::default() };
    assert_eq!(advice(few, &mut go).as_deref(), Some("--max-iterations"));
    let short = Stop { time: Some(Duration::ZERO), ..Stop::default() };
    assert_eq!(advice(short, &mut go).as_deref(), Some("--time-limit"));
    assert_eq!(advice(Stop::default(), &mut |_| ControlFlow::Break(())), None);
}

/// Regions that became one are one: the one that is left has nothing, from its first step on.
#[test]
fn regions_that_became_one_share_nothing() {
    let mesh = shape("sphere:3");
    let values = mesh.vertices.iter().map(|x| f64::from(u8::from(x.z > 0.1)));
    let data = Data::new(1, values.collect()).unwrap();
    for seed in 0..4 {
        let alternation = Alternation { regions: 4, ..alternation(Initial::Random, seed) };
        let request = Request { keep_dual: true, ..request(0.02, Mass::Barycentric) };
        let found = segment(&mesh, &PiecewiseConstant::new(&data), &alternation, &request, &mut go)
            .unwrap();
        let Solution { summary, trace, u, q, .. } = found.solution;
        assert_eq!(summary.status, Status::Converged, "{seed}");
        assert!(trace.iter().all(|sample| sample.energy < 1e3 && sample.gap >= 0.0), "{seed}");
        assert_eq!(summary.empty_regions.len(), 2, "{seed}");
        let mass = |p: &usize| u.column(*p).sum();
        assert!(summary.empty_regions.iter().all(|p| mass(p) == 0.0), "{seed}");
        let q = q.unwrap();
        let closed = |p: &usize| q.column(*p).iter().all(|&q| q == 0.0);
        assert!(summary.empty_regions.iter().all(closed), "{seed}");
    }
}

/// What two regions with one mean become is estimated once more: it has the mean of both.
#[test]
fn a_union_has_the_mean_of_both() {
    let mesh = shape("sphere:3");
    let band = |z: f64| if z > 0.3 { 1.0 } else { 0.02 * f64::from(u8::from(z > -0.4)) };
    let data = Data::new(1, mesh.vertices.iter().map(|x| band(x.z)).collect()).unwrap();
    let cells = Mass::Barycentric.weights(&mesh);
    for seed in 0..3 {
        let request = request(1e-7, Mass::Barycentric);
        let alternation = alternation(Initial::KMeans, seed);
        let found = segment(&mesh, &PiecewiseConstant::new(&data), &alternation, &request, &mut go)
            .unwrap();
        let Solution { summary, labels, .. } = found.solution;
        assert_eq!((summary.status, summary.empty_regions.len()), (Status::Converged, 1));
        let p = labels[data.values.iter().position(|&c| c == 0.0).unwrap()];
        let both = (0..labels.len()).filter(|&k| labels[k] == p);
        let (mass, sum) = both
            .fold((0.0, 0.0), |(mass, sum), k| (mass + cells[k], sum + cells[k] * data.values[k]));
        let mean = sum / mass;
        assert!((0.005..0.015).contains(&mean), "{seed}: {mean}");
        let found = found.parameters[p as usize].mean[0];
        assert!((found - mean).abs() <= SETTLED, "{seed}: {found} {mean}");
    }
}

/// What is said of empty regions, if anything.
fn said_of_empty(data: &Data, regions: usize, request: &Request, observe: Observer<'_>) -> String {
    let mesh = shape("sphere:3");
    let alternation = Alternation { regions, ..alternation(Initial::KMeans, 5) };
    let summary = segment(&mesh, &PiecewiseConstant::new(data), &alternation, request, observe)
        .unwrap()
        .solution
        .summary;
    assert!(!summary.empty_regions.is_empty());
    summary.warnings.into_iter().find(|warning| warning.contains("empty")).unwrap_or_default()
}

/// Data of fewer values than regions: how many they have is said at the end, that it is not the end where it is not, and
/// nothing to who breaks off.
#[test]
fn empty_regions_of_few_values_are_said_at_the_end() {
    let mesh = shape("sphere:3");
    let values = mesh.vertices.iter().map(|x| f64::from(u8::from(x.z > 0.1)));
    let data = Data::new(1, values.collect()).unwrap();
    let mut request = request(0.02, Mass::Barycentric);
    let said = said_of_empty(&data, 4, &request, &mut go);
    let few = "the data have only 2 different values; ask for 2 regions";
    assert!(said.contains(few), "{said}");
    assert_eq!(said_of_empty(&data, 4, &request, &mut |_| ControlFlow::Break(())), "");
    request.stop = Stop { iterations: Some(5), relative_gap: Some(0.0), ..Stop::default() };
    let said = said_of_empty(&data, 4, &request, &mut go);
    assert!(said.ends_with("so far: the run ended before its gap was reached"), "{said}");
}

/// Where lambda is too large, half of the first that keeps all regions is advised, and keeps them; where two means are
/// one, fewer regions.
#[test]
fn empty_regions_are_said_with_what_fills_them() {
    let mesh = shape("sphere:3");
    let (data, _) = painted(&mesh, 0.1);
    let large = request(3.0, Mass::Barycentric);
    let alternation = alternation(Initial::KMeans, 5);
    let half = Request { lambda: 1.5, ..large.clone() };
    let model = PiecewiseConstant::new(&data);
    let found = lambda::separating(&mesh, &model, &alternation, &half, &mut go).unwrap();
    let advised = 0.5 * found.lambda.unwrap();
    let said = said_of_empty(&data, 3, &large, &mut go);
    let end = format!(": lambda is too large for these data; try --lambda {advised:.1e}");
    assert!(said.ends_with(&end) && !said.contains("one mean"), "{said}");
    let smaller = Request { lambda: advised, ..large };
    let solution = segment(&mesh, &PiecewiseConstant::new(&data), &alternation, &smaller, &mut go)
        .unwrap()
        .solution;
    assert!(solution.summary.empty_regions.is_empty());

    let (data, _) = painted(&mesh, 1e-3);
    let said = said_of_empty(&data, 4, &request(0.02, Mass::Barycentric), &mut go);
    let end = ", since regions with one mean became one: the data do not separate into 4 regions; ask for 3";
    assert!(said.ends_with(end), "{said}");
}

/// Time that the levels take is the finest alternation's no more.
#[test]
fn the_finest_has_the_time_that_is_left() {
    let mesh = shape("sphere:5");
    let (data, _) = painted(&mesh, 0.6);
    let mut request = Request { coarse_to_fine: true, ..request(0.05, Mass::Barycentric) };
    request.stop.time = Some(Duration::from_millis(1));
    let alternation = alternation(Initial::KMeans, 5);
    let found =
        segment(&mesh, &PiecewiseConstant::new(&data), &alternation, &request, &mut go).unwrap();
    let summary = found.solution.summary;
    assert!(summary.iterations <= 1 && summary.status == Status::TimeLimit, "{summary:?}");
}

/// From coarser meshes: the same regions, certified as ever.
#[test]
fn coarse_to_fine_finds_the_same_regions() {
    let mesh = shape("sphere:5");
    let (data, truth) = painted(&mesh, 0.6);
    for mass in Mass::NAMES.map(|(_, mass)| mass) {
        let without = request(0.05, mass);
        let with = Request { coarse_to_fine: true, ..without.clone() };
        let alternation = alternation(Initial::KMeans, 5);
        let [without, with] = [without, with].map(|request| {
            segment(&mesh, &PiecewiseConstant::new(&data), &alternation, &request, &mut go).unwrap()
        });
        let summary = &with.solution.summary;
        assert_eq!(summary.status, Status::Converged, "{mass:?}");
        assert!(summary.coarse_to_fine.as_ref().unwrap().levels.len() >= 2);
        let spent = summary.coarse_to_fine.as_ref().unwrap().spent.as_secs_f64();
        assert!(0.0 < spent && spent <= with.solution.trace[0].seconds);
        let energy = without.solution.summary.energy;
        assert_within(summary.energy, energy, 1e-3, energy);
        let same = without.solution.labels.iter().zip(&with.solution.labels);
        let share = same.filter(|(a, b)| a == b).count() as f64 / truth.len() as f64;
        assert!(share > 0.99, "{mass:?}: {share}");
    }
}

/// Also where no step is left for a re-estimation, the certificate is for the parameters that came up from below.
#[test]
fn what_comes_up_is_certified_for_its_own_parameters() {
    let mesh = shape("sphere:5");
    let (data, _) = painted(&mesh, 0.6);
    let mut request = Request { coarse_to_fine: true, ..request(0.05, Mass::Barycentric) };
    request.stop.iterations = Some(5);
    let alternation = alternation(Initial::KMeans, 5);
    let found =
        segment(&mesh, &PiecewiseConstant::new(&data), &alternation, &request, &mut go).unwrap();
    assert_eq!(found.estimates, 0);
    let costs = PiecewiseConstant::new(&data).costs::<3>(&found.parameters);
    let problem = problem_of::<3>(&mesh, 3, costs, &request).unwrap();
    let u = regions::rows::<3>(found.solution.u.view());
    let energy = problem.baseline + problem.energy(&u);
    assert_within(energy, found.solution.summary.energy, 1e-12, energy);
}

/// More regions than colors, in a padded row: the surplus does no harm.
#[test]
fn nine_regions_for_three_colors() {
    let mesh = shape("sphere:3");
    let (data, _) = painted(&mesh, 0.0);
    let alternation = Alternation { regions: 9, ..alternation(Initial::KMeans, 2) };
    let request = request(0.01, Mass::Barycentric);
    let found =
        segment(&mesh, &PiecewiseConstant::new(&data), &alternation, &request, &mut go).unwrap();
    assert_eq!((found.parameters.len(), found.solution.u.dim().1), (9, 9));
    assert!(found.solution.summary.energy.is_finite());
    assert!(found.solution.u.outer_iter().all(|row| (row.sum() - 1.0).abs() < 1e-12));
}

#[test]
fn what_does_not_fit_is_refused() {
    let mesh = shape("sphere:1");
    let (data, _) = painted(&mesh, 0.0);
    let short = Data::new(3, vec![0.0; 9]).unwrap();
    let cases = [
        (&short, 3, 0.1, "vertices"),
        (&data, 1, 0.1, "regions"),
        (&data, 65, 0.1, "regions"),
        (&data, 3, -1.0, "lambda"),
        (&data, 3, f64::NAN, "lambda"),
    ];
    for (data, regions, lambda, word) in cases {
        let alternation = Alternation { regions, ..alternation(Initial::KMeans, 0) };
        let request = request(lambda, Mass::Barycentric);
        let Err(error) =
            segment(&mesh, &PiecewiseConstant::new(data), &alternation, &request, &mut go)
        else {
            panic!("{word} passes");
        };
        let message = error.to_string();
        assert!(message.contains(word) && !message.contains('\n'), "{message}");
    }
}

/// Where a tenth of the data are anything, medians stay in the middle of the rest and labels follow them.
#[test]
fn medians_take_no_notice_of_outliers() {
    let mesh = shape("sphere:4");
    let (mut data, truth) = painted(&mesh, 0.1);
    let mut rng = rng(112);
    for color in data.values.chunks_mut(3) {
        if rng.random_range(0..10) == 0 {
            color.iter_mut().for_each(|c| *c = rng.random_range(-4.0..4.0));
        }
    }
    for coarse_to_fine in [false, true] {
        let alternation = alternation(Initial::KMeans, 5);
        let model = L1::new(&data);
        let request = Request { coarse_to_fine, ..request(0.0, Mass::Barycentric) };
        let lambda = lambda::of_data(&mesh, &model, &alternation, &request, &mut go).unwrap();
        let request = Request { lambda, ..request };
        let found = segment(&mesh, &model, &alternation, &request, &mut go).unwrap();
        assert_eq!(found.solution.summary.status, Status::Converged);
        let region = matched::<L1>(&found.parameters, 0.05);
        let labels = &found.solution.labels;
        let right = truth.iter().zip(labels).filter(|&(&t, &l)| region[t] == l as usize).count();
        assert!(right as f64 > 0.97 * truth.len() as f64, "{right}");
    }
}

/// Costs of any sign that differ from the squared distances by what is the same for all regions, and a fit that fails
/// after a number of times: what other models may do.
#[derive(Clone)]
struct Odd<'a> {
    model: PiecewiseConstant<'a>,
    fits: &'a AtomicUsize,
}

impl DataModel for Odd<'_> {
    type Parameters = Mean;

    const TOLD: &'static str = "mean";

    fn told(mu: &Mean) -> &[f64] {
        &mu.mean
    }

    fn vertices(&self) -> usize {
        self.model.vertices()
    }

    fn is_known(&self, k: usize) -> bool {
        self.model.is_known(k)
    }

    fn different(&self, most: usize) -> usize {
        self.model.different(most)
    }

    fn in_order(&self, order: &Order) -> Cow<'_, Self> {
        Cow::Owned(Odd { model: self.model.in_order(order).into_owned(), fits: self.fits })
    }

    fn restricted(&self, level: &Coarsening, weights: &[f64], coarse: &[f64]) -> Self {
        Odd { model: self.model.restricted(level, weights, coarse), fits: self.fits }
    }

    fn scale(&self, weights: &[f64]) -> Scale {
        self.model.scale(weights)
    }

    fn start(&self, initial: Initial, m: usize, w: &[f64], rng: &mut Pcg64) -> Result<Vec<Mean>> {
        self.model.start(initial, m, w, rng)
    }

    fn costs<const M: usize>(&self, mu: &[Mean]) -> Vec<Row<M>> {
        let s: Vec<Row<M>> = self.model.costs(mu);
        let lower = |k: usize| f64::from(u8::from(self.is_known(k))) * (2.0 + (k as f64).sin());
        (0..s.len()).map(|k| s[k] - Row([lower(k); M])).collect()
    }

    fn fit<const M: usize>(&self, weights: &[Row<M>], mu: &mut [Mean]) -> Result<f64> {
        match self.fits.fetch_sub(1, Relaxed) {
            0 => Err(crate::Error::unsuitable("the fit failed")),
            _ => self.model.fit(weights, mu),
        }
    }

    fn distance(a: &Mean, b: &Mean) -> f64 {
        PiecewiseConstant::distance(a, b)
    }
}

/// Negative costs end with the same labels and gaps.
#[test]
fn what_is_the_same_for_all_regions_changes_nothing() {
    let mesh = shape("sphere:4");
    let (mut data, _) = painted(&mesh, 0.4);
    data.values[..30].fill(f64::NAN);
    let fits = AtomicUsize::new(usize::MAX);
    let model = PiecewiseConstant::new(&data);
    let odd = Odd { model: model.clone(), fits: &fits };
    let alternation = alternation(Initial::KMeans, 5);
    for coarse_to_fine in [false, true] {
        let request = Request { coarse_to_fine, ..request(0.05, Mass::Barycentric) };
        let found = segment(&mesh, &model, &alternation, &request, &mut go).unwrap();
        let same = segment(&mesh, &odd, &alternation, &request, &mut go).unwrap();
        let (one, other) = (&found.solution, &same.solution);
        assert!(other.summary.energy < 0.0 && other.summary.status == Status::Converged);
        let agree = one.labels.iter().zip(&other.labels).filter(|(a, b)| a == b).count();
        assert!(agree as f64 > 0.999 * one.labels.len() as f64, "{agree}");
        let above = |solution: &Solution| solution.summary.energy - solution.summary.baseline;
        assert_within(above(one), above(other), 1e-3, above(one));
    }
    let request = request(0.0, Mass::Barycentric);
    let one = lambda::of_data(&mesh, &model, &alternation, &request, &mut go).unwrap();
    let other = lambda::of_data(&mesh, &odd, &alternation, &request, &mut go).unwrap();
    assert_eq!(one, other);
}

/// Wherever a fit fails, its error is that of the segmentation.
#[test]
fn a_fit_that_fails_ends_it() {
    let mesh = shape("sphere:4");
    let (data, _) = painted(&mesh, 0.4);
    let alternation = alternation(Initial::Random, 5);
    for (coarse_to_fine, after) in [(false, 0), (false, 2), (true, 0), (true, 2)] {
        let fits = AtomicUsize::new(after);
        let model = Odd { model: PiecewiseConstant::new(&data), fits: &fits };
        let request = Request { coarse_to_fine, ..request(0.05, Mass::Barycentric) };
        let error = segment(&mesh, &model, &alternation, &request, &mut go).err().unwrap();
        assert_eq!(error.to_string(), "the fit failed");
    }
    let fits = AtomicUsize::new(1);
    let model = Odd { model: PiecewiseConstant::new(&data), fits: &fits };
    let request = request(0.0, Mass::Barycentric);
    assert!(lambda::of_data(&mesh, &model, &alternation, &request, &mut go).is_err());
}
