//! When the alternation ends, and the warnings about empty regions.

use super::*;

/// Re-estimations end with the first that changes the parameters by no more than the settling threshold.
#[test]
fn re_estimations_end_when_the_parameters_settle() {
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
    // After n estimates the remaining iterations are too few for another.
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
        let little = moved.fold(0.0, f64::max) <= SETTLED_CHANGE * scale.change;
        assert_eq!(little, n + 2 == estimates, "{n}");
    }
}

/// The parameters fit the solved labels, with any solver, fast or slow, and any number of steps between re-estimations.
#[test]
fn settled_parameters_fit_the_labels() {
    let mesh = shape("sphere:3");
    let (data, _) = painted(&mesh, 0.4);
    let model = PiecewiseConstant::new(&data);
    let area = Mass::Barycentric.weights(&mesh);
    let scale = model.scale(&area).change;
    for method in Method::all() {
        for every in [1, 10, 100] {
            let mut request =
                Request { method: method.clone(), ..request(0.02, Mass::Barycentric) };
            request.stop.relative_gap = Some(1e-3);
            let alternation = Alternation { every, ..alternation(Initial::Random, 5) };
            let found = segment(&mesh, &model, &alternation, &request, &mut go).unwrap();
            let (name, Solution { summary, u, .. }) = (method.name(), found.solution);
            assert!(found.estimates > 1, "{name} {every}: {}", found.estimates);
            let weights: Vec<f64> = u.indexed_iter().map(|((k, _), u)| area[k] * u).collect();
            let change =
                model.fit(Weights::new(&weights, 3), &mut found.parameters.clone()).unwrap();
            let fits = change <= 2.0 * UNSETTLED_CHANGE * scale;
            let reported = summary.warnings.iter().any(|w| w.contains("still changed"));
            assert!(fits || reported, "{name} {every}: {}", change / scale);
            let fast = ["chambolle-pock", "douglas-rachford", "alpha-expansion"].contains(&name);
            assert!(!fast || fits && !reported, "{name} {every}: {:?}", summary.warnings);
        }
    }
}

/// The iteration limit counts all steps, before and after re-estimations, and a warning reports unsettled parameters.
#[test]
fn the_iteration_limit_counts_all_steps() {
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
        let reported = summary.warnings.iter().any(|w| w.contains("still changed"));
        assert!(reported || most > 5, "{:?}", summary.warnings);
    }
}

/// The advice is to raise the limit that ended the run, if there is one.
#[test]
fn advice_names_the_limit_that_ended_the_run() {
    let mesh = shape("sphere:3");
    let (data, _) = painted(&mesh, 0.4);
    let alternation = alternation(Initial::Random, 5);
    let advice = |stop: Stop, observe: Observer<'_>| {
        let mut request = request(0.05, Mass::Barycentric);
        request.stop = Stop { relative_gap: Some(0.0), ..stop };
        let found = segment(&mesh, &PiecewiseConstant::new(&data), &alternation, &request, observe)
            .unwrap();
        let warnings = found.solution.summary.warnings;
        let warning = warnings.into_iter().find(|w| w.contains("still changed")).unwrap();
        warning.split_once("raise ").map(|(_, advice)| advice.to_owned())
    };
    let few = Stop { iterations: Some(5), ..Stop::default() };
    assert_eq!(advice(few, &mut go).as_deref(), Some("--max-iterations"));
    let short = Stop { time: Some(Duration::ZERO), ..Stop::default() };
    assert_eq!(advice(short, &mut go).as_deref(), Some("--time-limit"));
    assert_eq!(advice(Stop::default(), &mut |_| ControlFlow::Break(())), None);
}

/// An inactive region has no mass and no dual field from the first step after the merge on.
#[test]
fn inactive_regions_are_zero() {
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
        let zero_field = |p: &usize| q.column(*p).iter().all(|&q| q == 0.0);
        assert!(summary.empty_regions.iter().all(zero_field), "{seed}");
    }
}

/// A merged region is re-estimated and has the mean of both.
#[test]
fn a_merged_region_has_the_mean_of_both() {
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
        assert!((found - mean).abs() <= SETTLED_CHANGE, "{seed}: {found} {mean}");
    }
}

/// The warning about empty regions, if there is one.
fn empty_warning_of(
    data: &Data,
    regions: usize,
    request: &Request,
    observe: Observer<'_>,
) -> String {
    let mesh = shape("sphere:3");
    let alternation = Alternation { regions, ..alternation(Initial::KMeans, 5) };
    let summary = segment(&mesh, &PiecewiseConstant::new(data), &alternation, request, observe)
        .unwrap()
        .solution
        .summary;
    assert!(!summary.empty_regions.is_empty());
    summary.warnings.into_iter().find(|w| w.contains("empty")).unwrap_or_default()
}

/// For data of fewer values than regions, the warning names the number of values if the run converged, says that the
/// run ended early if it did, and is absent if the run was interrupted.
#[test]
fn empty_regions_are_explained_by_few_values() {
    let mesh = shape("sphere:3");
    let values = mesh.vertices.iter().map(|x| f64::from(u8::from(x.z > 0.1)));
    let data = Data::new(1, values.collect()).unwrap();
    let mut request = request(0.02, Mass::Barycentric);
    let warning = empty_warning_of(&data, 4, &request, &mut go);
    let few = "the data have only 2 different values; use --regions 2";
    assert!(warning.contains(few), "{warning}");
    assert_eq!(empty_warning_of(&data, 4, &request, &mut |_| ControlFlow::Break(())), "");
    request.stop = Stop { iterations: Some(5), relative_gap: Some(0.0), ..Stop::default() };
    let warning = empty_warning_of(&data, 4, &request, &mut go);
    assert!(
        warning.ends_with("so far: the run ended before the gap was reached; raise its limit"),
        "{warning}"
    );
}

/// If lambda is too large, the advice is half of the first lambda that keeps all regions, and it does keep them; if
/// regions were merged, the advice is fewer regions.
#[test]
fn the_advice_about_empty_regions_helps() {
    let mesh = shape("sphere:3");
    let (data, _) = painted(&mesh, 0.1);
    let large = request(3.0, Mass::Barycentric);
    let alternation = alternation(Initial::KMeans, 5);
    let half = Request { lambda: 1.5, ..large.clone() };
    let model = PiecewiseConstant::new(&data);
    let estimate = ModelEstimate::new(Cow::Borrowed(&model), Vec::new());
    let found = lambda::find_separating(&mesh, &estimate, &alternation, &half, &mut go).unwrap();
    let first = found.lambda.unwrap();
    let advised = 0.5 * first;
    // The search starts at half of the lambda that was too large.
    for lambda in [3.0, 2.0 * first] {
        let too_large = Request { lambda, ..large.clone() };
        let warning = empty_warning_of(&data, 3, &too_large, &mut go);
        let end = format!(": lambda is too large for these data; try --lambda {advised:.1e}");
        assert!(warning.ends_with(&end) && !warning.contains("merged"), "{warning}");
    }
    let smaller = Request { lambda: advised, ..large };
    let solution = segment(&mesh, &PiecewiseConstant::new(&data), &alternation, &smaller, &mut go)
        .unwrap()
        .solution;
    assert!(solution.summary.empty_regions.is_empty());

    let (data, _) = painted(&mesh, 1e-3);
    let warning = empty_warning_of(&data, 4, &request(0.02, Mass::Barycentric), &mut go);
    let end = ", since regions with the same mean were merged: the data do not separate into 4 regions; \
               use --regions 3";
    assert!(warning.ends_with(end), "{warning}");
}
