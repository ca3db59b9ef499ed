//! Data models other than `constant`: robust ones, costs of either sign, fits that fail.

use super::*;

/// With a tenth of outliers, medians and labels are those of the other data.
#[test]
fn medians_are_robust_to_outliers() {
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

/// A model as others may write it: its costs are squared distances minus a number per vertex, so they may be negative,
/// and its fit fails after a given number of calls, or never settles.
#[derive(Clone)]
struct Odd<'a> {
    model: PiecewiseConstant<'a>,
    fits: &'a AtomicUsize,
    settles: bool,
}

impl DataModel for Odd<'_> {
    type Parameters = Mean;

    type Datum = [f64];

    const VALUE_NAME: &'static str = "mean";

    fn value(mu: &Mean) -> &[f64] {
        &mu.mean
    }

    fn vertices(&self) -> usize {
        self.model.vertices()
    }

    fn at(&self, k: usize) -> Option<&[f64]> {
        self.model.at(k)
    }

    fn in_order(&self, order: &Order) -> Cow<'_, Self> {
        Cow::Owned(Odd { model: self.model.in_order(order).into_owned(), ..*self })
    }

    fn restricted(&self, level: &Coarsening, weights: &[f64], coarse: &[f64]) -> Self {
        Odd { model: self.model.restricted(level, weights, coarse), ..*self }
    }

    fn scale(&self, weights: &[f64]) -> Scale {
        self.model.scale(weights)
    }

    fn start(&self, initial: Initial, m: usize, w: &[f64], rng: &mut Pcg64) -> Result<Vec<Mean>> {
        self.model.start(initial, m, w, rng)
    }

    fn check(&self, mu: &[Mean]) -> Result<()> {
        self.model.check(mu)
    }

    fn cost<'a>(&'a self, mu: &'a [Mean]) -> Cost<'a> {
        let cost = self.model.cost(mu);
        Box::new(move |k, s| {
            cost(k, s);
            s.iter_mut().for_each(|s| *s -= 2.0 + (k as f64).sin());
        })
    }

    fn fit(&self, weights: Weights<'_>, mu: &mut [Mean]) -> Result<f64> {
        match self.fits.fetch_sub(1, Relaxed) {
            0 => Err(crate::Error::unsuitable("the fit failed")),
            _ => self.model.fit(weights, mu).map(|change| if self.settles { change } else { 1e9 }),
        }
    }

    fn distance(a: &Mean, b: &Mean) -> f64 {
        PiecewiseConstant::distance(a, b)
    }
}

/// Negative costs give the same labels and gaps.
#[test]
fn a_constant_per_vertex_does_not_change_the_result() {
    let mesh = shape("sphere:4");
    let (mut data, _) = painted(&mesh, 0.4);
    data.values[..30].fill(f64::NAN);
    let fits = AtomicUsize::new(usize::MAX);
    let model = PiecewiseConstant::new(&data);
    let odd = Odd { model: model.clone(), fits: &fits, settles: true };
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

/// Wherever a fit fails, the segmentation returns its error.
#[test]
fn a_failing_fit_ends_the_segmentation() {
    let mesh = shape("sphere:4");
    let (data, _) = painted(&mesh, 0.4);
    let alternation = alternation(Initial::Random, 5);
    for (coarse_to_fine, after) in [(false, 0), (false, 2), (true, 0), (true, 2)] {
        let fits = AtomicUsize::new(after);
        let model = Odd { model: PiecewiseConstant::new(&data), fits: &fits, settles: true };
        let request = Request { coarse_to_fine, ..request(0.05, Mass::Barycentric) };
        let error = segment(&mesh, &model, &alternation, &request, &mut go).err().unwrap();
        assert_eq!(error.to_string(), "the fit failed");
    }
    let fits = AtomicUsize::new(1);
    let model = Odd { model: PiecewiseConstant::new(&data), fits: &fits, settles: true };
    let request = request(0.0, Mass::Barycentric);
    assert!(lambda::of_data(&mesh, &model, &alternation, &request, &mut go).is_err());
}

/// Parameters that never settle are re-estimated a limited number of times, and a warning says so; the gap is certified
/// for the last ones.
#[test]
fn parameters_that_never_settle_are_reported() {
    let mesh = shape("sphere:3");
    let (data, _) = painted(&mesh, 0.1);
    let alternation = alternation(Initial::KMeans, 5);
    let fits = AtomicUsize::new(usize::MAX);
    for settles in [true, false] {
        let model = Odd { model: PiecewiseConstant::new(&data), fits: &fits, settles };
        let request = request(0.05, Mass::Barycentric);
        let found = segment(&mesh, &model, &alternation, &request, &mut go).unwrap();
        assert_eq!(found.solution.summary.status, Status::Converged);
        assert_eq!(found.estimates == 200, !settles);
        let warning = "the region parameters still changed after 200 re-estimations; the certificate holds for the \
                       last estimate";
        let warnings = &found.solution.summary.warnings;
        assert_eq!(warnings.iter().any(|given| given == warning), !settles, "{warnings:?}");
    }
}
