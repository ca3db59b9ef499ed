//! Coarse to fine: the time of the levels, the same regions, and the certificate.

use super::*;

/// The time of the coarse levels counts towards the time limit.
#[test]
fn the_finest_level_has_the_remaining_time() {
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

/// Coarse to fine finds the same regions, certified as without it.
#[test]
fn coarse_to_fine_finds_the_same_regions() {
    let mesh = shape("sphere:5");
    let (data, truth) = painted(&mesh, 0.6);
    for mass in Mass::iter() {
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

/// If no re-estimation is possible on the finest mesh, the certificate is for the parameters of the coarser levels.
#[test]
fn the_certificate_is_for_parameters_of_coarser_levels() {
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
