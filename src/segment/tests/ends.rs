//! When the alternation ends, and what is said of regions that end empty.

use super::*;

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
