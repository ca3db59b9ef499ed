//! A lambda for data of any kind, and one that saves a region which a given lambda empties.
//!
//! ```text
//! lambda_i = 0.02 (scale of the costs) sqrt(area) / 2^i              for constant data the variance without outliers
//! R(U)     = min_mu int s_mu - min_mu sum_p int u_p s_{mu_p}         what labels explain: less of the costs of one region
//! ```
//!
//! The first weighs cuts as much as a mistake of one standard deviation within a fiftieth of the size of the surface,
//! which suits colors and textures, but empties all regions but one where the data vary over shorter distances, as
//! curvature does. So it is halved until, on a coarse mesh with the model restricted to it, no region that clusters of
//! the data use is empty and the labels explain at least two thirds of what those of the clusters explain, which know no
//! cuts. Data of coarse vertices carry little noise, so that noise is no reason to go on.

use std::borrow::Cow;
use std::time::Instant;

use rand::SeedableRng;
use rand_pcg::Pcg64;

use super::alternation::{Alternation, Level};
use super::coarse::restrict;
use crate::coarse::Hierarchy;
use crate::data::{DataModel, Initial, Scale};
use crate::error::{Error, Result};
use crate::field::Row;
use crate::mesh::Mesh;
use crate::mesh::geometry::barycentric_areas;
use crate::problem::rounded;
use crate::regions::with_regions;
use crate::run::Stop;
use crate::solve::{Observer, Request, model_mesh};

/// Of the mesh that lambdas are tried on.
const MOST_VERTICES: usize = 4000;

/// Labels on it need not be exact.
const GAP: f64 = 1e-2;
const MOST_STEPS: u64 = 200;

/// Lambdas that are tried at the most, each half of the one before.
const TRIED: i32 = 14;

/// Of what clusters explain.
const KEPT: f64 = 2.0 / 3.0;

/// lambda for data of any kind: the first of lambda_0, lambda_1, ... that loses no region, or lambda_0 if all do.
///
/// # Errors
/// Data whose costs leave the range of double precision, and a fit that fails.
pub fn of_data<D: DataModel>(
    mesh: &Mesh,
    model: &D,
    alternation: &Alternation,
    request: &Request,
    observe: Observer<'_>,
) -> Result<f64> {
    let cells = barycentric_areas(mesh);
    let largest = largest(model.scale(&cells).cost, cells.iter().sum());
    if !largest.is_finite() {
        return Err(Error::unsuitable(
            "the costs of the data leave the range of double precision; scale the data down",
        ));
    }
    let (sound, _) = model_mesh(mesh)?;
    let request = Request { lambda: largest, ..request.clone() };
    let found = separating(&sound, model, alternation, &request, observe)?;
    Ok(found.lambda.unwrap_or(largest))
}

/// Where lambdas start, for costs of this scale on a surface of this area.
fn largest(cost: f64, area: f64) -> f64 {
    0.02 * cost * area.sqrt()
}

/// What was found.
pub(super) struct Separation {
    /// How many regions the data have that are more than a speck and differ, before any cut is paid for.
    pub regions: usize,
    /// The first that keeps all of these and explains enough; none if all of them fail.
    pub lambda: Option<f64>,
}

/// Looks for the first of lambda, lambda / 2, ..., from that of the request on, that leaves no region empty and explains
/// enough. The mesh has no faces without area.
///
/// # Errors
/// Numbers that leave the range of double precision, and a fit that fails.
pub(super) fn separating<D: DataModel>(
    mesh: &Mesh,
    model: &D,
    alternation: &Alternation,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Separation> {
    with_regions!(
        alternation.regions,
        separating_compiled::<D>(mesh, model, alternation, request, observe)
    )
}

fn separating_compiled<const M: usize, D: DataModel>(
    finest: &Mesh,
    model: &D,
    alternation: &Alternation,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Separation> {
    let begin = Instant::now();
    let hierarchy = Hierarchy::down_to(finest, MOST_VERTICES);
    let (mut weights, mut model) = (request.mass.weights(finest), Cow::Borrowed(model));
    for level in &hierarchy.levels {
        let (coarse, restricted) = restrict(level, &weights, &*model);
        (weights, model) = (coarse, Cow::Owned(restricted));
    }
    let model = &*model;
    let mesh = hierarchy.levels.last().map_or(finest, |level| &level.mesh);
    let known = |(k, &w): (usize, &f64)| if model.is_known(k) { w } else { 0.0 };
    let known: Vec<f64> = weights.iter().enumerate().map(known).collect();
    let mut rng = Pcg64::seed_from_u64(alternation.seed);
    let mu = model.start(Initial::KMeans, alternation.regions, &known, &mut rng)?;

    let integrate = |s: &[Row<M>]| s.iter().zip(&known).map(|(&s, &w)| s * w).collect();
    let scale = model.scale(&known);
    let stop = Stop {
        relative_gap: Some(GAP),
        iterations: Some(MOST_STEPS),
        ..request.stop.after(begin.elapsed())
    };
    let explained = |labels: &[Row<M>]| Explained::of(labels, model, &mu, &known, scale);
    let most = explained(&without_cuts(model, &mu))?;
    let none = Separation { regions: most.regions, lambda: None };
    if most.costs <= 0.0 {
        return Ok(none);
    }
    for i in 0..TRIED {
        let request = &Request { lambda: request.lambda * 0.5_f64.powi(i), ..request.clone() };
        let level =
            Level { mesh, model, integrate: &integrate, scale, alternation, request, unite: false };
        let problem = level.problem(&mu)?;
        let mut flow = std::ops::ControlFlow::Continue(());
        let mut observe = |_: Option<&_>| {
            flow = observe(None);
            flow
        };
        let spent = begin.elapsed();
        let found = level.alternate(problem, mu.clone(), None, spent, &stop, &mut observe)?;
        if flow.is_break() {
            return Ok(none);
        }
        let reached = explained(&rounded(found.run.best_u()))?;
        if reached.regions >= most.regions && reached.costs >= KEPT * most.costs {
            return Ok(Separation { lambda: Some(request.lambda), ..none });
        }
    }
    Ok(none)
}

/// The labels without any cuts in mind.
fn without_cuts<D: DataModel, const M: usize>(model: &D, mu: &[D::Parameters]) -> Vec<Row<M>> {
    let s: Vec<Row<M>> = model.costs(mu);
    let least = |s: &Row<M>| (0..mu.len()).min_by(|&a, &b| s.0[a].total_cmp(&s.0[b]));
    s.iter().map(|s| Row::one_hot(least(s).expect("there are regions"))).collect()
}

/// What labels tell of the data.
struct Explained {
    /// R.
    costs: f64,
    /// How many are used on more than a speck, and differ in their parameters.
    regions: usize,
}

/// Of the area: a speck.
const SPECK: f64 = 1e-3;

/// Of the scale of distances, the standard deviation for constant data: regions that are closer do not differ. With 0.1
/// two regions of a photograph, and two of six on Spot, that the fine mesh united passed as different; 0.2 and 0.3 part
/// the same ones on all data tried.
const CLOSE: f64 = 0.25;

impl Explained {
    /// For labels without mixtures, and weights w of the vertices; `mu` is where fits start.
    fn of<D: DataModel, const M: usize>(
        labels: &[Row<M>],
        model: &D,
        mu: &[D::Parameters],
        known: &[f64],
        scale: Scale,
    ) -> Result<Self> {
        let fitted = |labels: &dyn Fn(usize) -> Row<M>, mu: &[D::Parameters]| -> Result<_> {
            let weights: Vec<Row<M>> =
                known.iter().enumerate().map(|(k, &w)| labels(k) * w).collect();
            let mut mu = mu.to_vec();
            model.fit(&weights, &mut mu)?;
            let costs: f64 =
                model.costs::<M>(&mu).iter().zip(&weights).map(|(&s, w)| w.dot(s)).sum();
            Ok((mu, costs))
        };
        let (_, one) = fitted(&|_| Row::one_hot(0), &mu[..1])?;
        let (mu, within) = fitted(&|k| labels[k], mu)?;
        let mut mass = vec![0.0; mu.len()];
        labels.iter().zip(known).for_each(|(u, &w)| mass[u.argmax()] += w);
        let total: f64 = mass.iter().sum();
        let mut different: Vec<&D::Parameters> = Vec::new();
        for (mu, mass) in mu.iter().zip(mass) {
            let new = different.iter().all(|other| D::distance(mu, other) > CLOSE * scale.distance);
            if new && mass > SPECK * total {
                different.push(mu);
            }
        }
        Ok(Explained { costs: one - within, regions: different.len() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{Data, L1, PiecewiseConstant};
    use crate::operator::Mass;
    use crate::run::Sample;
    use crate::samples::{rng, shape};
    use crate::segment::segment;
    use rand::RngExt;
    use std::ops::ControlFlow;

    fn explained(labels: &[Row<4>], data: &Data, area: &[f64]) -> Explained {
        let model = PiecewiseConstant::new(data);
        let mut rng = Pcg64::seed_from_u64(0);
        let mu = model.start(Initial::Random, 4, area, &mut rng).unwrap();
        Explained::of(labels, &model, &mu, area, model.scale(area)).unwrap()
    }

    /// What is not within the regions is between them: the variance of their means.
    #[test]
    fn explained_is_what_is_not_within() {
        let mut rng = rng(141);
        let n = 500;
        let data = Data::new(2, (0..2 * n).map(|_| rng.random()).collect()).unwrap();
        let area: Vec<f64> = (0..n).map(|_| rng.random()).collect();
        let labels: Vec<Row<4>> = (0..n).map(|_| Row::one_hot(rng.random_range(0..4))).collect();
        let (mut mass, mut moments) = ([0.0; 4], [[0.0; 2]; 4]);
        for (k, u) in labels.iter().enumerate() {
            let p = u.argmax();
            mass[p] += area[k];
            (0..2).for_each(|i| moments[p][i] += area[k] * data.at(k)[i]);
        }
        let total: f64 = mass.iter().sum();
        let mean = [0, 1].map(|i| moments.iter().map(|moment| moment[i]).sum::<f64>() / total);
        let between: f64 = (0..4)
            .flat_map(|p| [0, 1].map(|i| mass[p] * (moments[p][i] / mass[p] - mean[i]).powi(2)))
            .sum();
        let found = explained(&labels, &data, &area);
        assert!((found.costs - between).abs() < 1e-12 * total, "{} {between}", found.costs);
    }

    /// Lambda times a length is a cost times an area.
    #[test]
    fn the_largest_lambda_has_its_units() {
        let lambda = largest(0.5, 4.0);
        assert!((largest(0.5 * 9.0, 4.0) - 9.0 * lambda).abs() <= 1e-15);
        assert!((largest(0.5, 4.0 * 9.0) - 3.0 * lambda).abs() <= 1e-15);
    }

    fn alternation() -> Alternation {
        Alternation { regions: 3, initial: Initial::KMeans, seed: 0, every: 10 }
    }

    fn request() -> Request {
        Request {
            lambda: 0.0,
            mass: Mass::Barycentric,
            method: crate::solver::Method::default(),
            stop: Stop { relative_gap: Some(1e-4), iterations: Some(5000), ..Stop::default() },
            coarse_to_fine: false,
            keep_dual: false,
        }
    }

    /// Three bands of the unit sphere at 0, 0.5 and 1, with noise.
    fn bands(noise: f64) -> (Mesh, Data) {
        let mesh = shape("sphere:3");
        let mut rng = rng(142);
        let value =
            |z: f64| 0.5 * f64::from(u8::from(z > -0.3)) + 0.5 * f64::from(u8::from(z > 0.3));
        let noisy = mesh.vertices.iter().map(|x| value(x.z) + noise * rng.random_range(-1.0..1.0));
        let values = noisy.collect();
        (mesh, Data::new(1, values).unwrap())
    }

    /// What is found, and how many steps were told.
    fn looked(mesh: &Mesh, data: &Data, request: &Request, from: f64) -> (Separation, u64) {
        let mut told = 0;
        let mut observe = |sample: Option<&Sample>| {
            assert!(sample.is_none());
            told += 1;
            ControlFlow::Continue(())
        };
        let request = Request { lambda: from, ..request.clone() };
        let model = PiecewiseConstant::new(data);
        let found = separating(mesh, &model, &alternation(), &request, &mut observe).unwrap();
        (found, told)
    }

    /// Three bands, one of them narrow: the largest of the halves for which no region is lost, and the first itself if
    /// that is one.
    #[test]
    fn the_first_lambda_that_keeps_all_regions_is_taken() {
        let mesh = crate::samples::shape("sphere:3");
        let band = |z: f64| if z > 0.9 { 1.0 } else { 0.5 * f64::from(z > 0.0) };
        let data = Data::new(1, mesh.vertices.iter().map(|x| band(x.z)).collect()).unwrap();
        let model = PiecewiseConstant::new(&data);
        let (alternation, request) = (alternation(), request());
        let mut go = |_: Option<&crate::run::Sample>| std::ops::ControlFlow::Continue(());
        let mut found = |from: f64| {
            let request = Request { lambda: from, ..request.clone() };
            separating(&mesh, &model, &alternation, &request, &mut go).unwrap().lambda.unwrap()
        };
        assert_eq!(found(1e-3), 1e-3);
        let lambda = found(2.0);
        assert!(lambda < 2.0 && (2.0 / lambda).log2().fract() == 0.0, "{lambda}");
        let mut empty = |lambda: f64| {
            let request = Request { lambda, ..request.clone() };
            let found = segment(&mesh, &model, &alternation, &request, &mut go);
            found.unwrap().solution.summary.empty_regions.len()
        };
        assert_eq!(empty(lambda), 0);
    }

    #[test]
    fn specks_and_twins_are_no_regions() {
        let values = [vec![0.0; 1000], vec![1.0; 1000], vec![1.01; 1000], vec![5.0; 1]].concat();
        let regions = [vec![0; 1000], vec![1; 1000], vec![2; 1000], vec![3; 1]].concat();
        let labels: Vec<Row<4>> = regions.into_iter().map(Row::one_hot).collect();
        let data = Data::new(1, values).unwrap();
        assert_eq!(explained(&labels, &data, &[1.0; 3001]).regions, 2);
    }

    /// A few values far away, such as those that stand for missing ones, make no two regions one.
    #[test]
    fn values_far_away_part_no_less() {
        let values = [vec![0.0; 1000], vec![1.0; 1000], vec![1e3; 2]].concat();
        let regions = [vec![0; 1000], vec![1; 1000], vec![2; 2]].concat();
        let labels: Vec<Row<4>> = regions.into_iter().map(Row::one_hot).collect();
        let data = Data::new(1, values).unwrap();
        let found = explained(&labels, &data, &[1.0; 2002]);
        // Specks are no regions, wherever they lie.
        assert_eq!(found.regions, 2);
        let all = 2002.0 * data.variance(&[1.0; 2002]);
        assert!((found.costs / all - 1.0).abs() <= 1e-9);
    }

    /// What CLOSE is a share of is a length, not its square.
    #[test]
    fn means_differ_from_a_quarter_of_the_deviation_on() {
        // Two halves at 0 and 1, each of two regions: the deviation is a half, a quarter of that an eighth.
        for (apart, regions) in [(0.11, 2), (0.15, 4)] {
            let values = [0.0, apart, 1.0, 1.0 + apart].map(|x| vec![x; 100]).concat();
            let labels: Vec<Row<4>> = (0..400).map(|k| Row::one_hot(k / 100)).collect();
            let data = Data::new(1, values).unwrap();
            assert_eq!(explained(&labels, &data, &[1.0; 400]).regions, regions);
        }
    }

    /// Labels explain less of noisy data than those of k-means, which may follow the noise: two thirds are enough.
    #[test]
    fn two_thirds_of_what_can_be_explained_are_enough() {
        let (mesh, data) = bands(0.4);
        let (found, _) = looked(&mesh, &data, &request(), 0.05);
        let lambda = found.lambda.unwrap();
        let request = Request { lambda, ..request() };
        let mut go = |_: Option<&Sample>| ControlFlow::Continue(());
        let model = PiecewiseConstant::new(&data);
        let labels =
            segment(&mesh, &model, &alternation(), &request, &mut go).unwrap().solution.labels;
        let labels: Vec<Row<4>> = labels.iter().map(|&p| Row::one_hot(p as usize)).collect();
        let cells = barycentric_areas(&mesh);
        let mut rng = Pcg64::seed_from_u64(0);
        let mu = model.start(Initial::KMeans, 3, &cells, &mut rng).unwrap();
        let most = explained(&without_cuts(&model, &mu), &data, &cells);
        let kept = explained(&labels, &data, &cells);
        assert_eq!((most.regions, kept.regions, found.regions), (3, 3, 3));
        assert!(kept.costs < 0.95 * most.costs && kept.costs >= KEPT * most.costs);
    }

    /// On a mesh that is small enough a lambda is tried as `segment` does it, to its own gap.
    #[test]
    fn a_lambda_takes_the_steps_of_a_segmentation() {
        let (mesh, data) = bands(0.4);
        let lambda = looked(&mesh, &data, &request(), 0.05).0.lambda.unwrap();
        let (found, told) = looked(&mesh, &data, &request(), lambda);
        assert_eq!(found.lambda, Some(lambda));
        let stop =
            Stop { relative_gap: Some(GAP), iterations: Some(MOST_STEPS), ..Stop::default() };
        let request = Request { lambda, stop, ..request() };
        let mut steps = 0;
        let mut count = |_: Option<&Sample>| {
            steps += 1;
            ControlFlow::Continue(())
        };
        let model = PiecewiseConstant::new(&data);
        let found = segment(&mesh, &model, &alternation(), &request, &mut count).unwrap();
        assert!(found.solution.summary.empty_regions.is_empty() && found.estimates > 1);
        assert_eq!(told, steps);
    }

    /// Data of one value have one region and no variance that labels could explain: no lambda is tried.
    #[test]
    fn data_of_one_value_have_no_lambda() {
        let mesh = shape("sphere:3");
        let data = Data::new(1, vec![0.25; mesh.vertices.len()]).unwrap();
        let (found, told) = looked(&mesh, &data, &request(), 1.0);
        assert_eq!((found.regions, found.lambda, told), (1, None, 0));
    }

    /// Who breaks off gets the lambda that would have been tried first, of which values far away take no notice.
    #[test]
    fn who_breaks_off_gets_the_first_lambda() {
        let (mesh, mut data) = bands(0.0);
        data.values[5] = 1e4;
        let mut told = 0;
        let mut observe = |_: Option<&Sample>| {
            told += 1;
            ControlFlow::Break(())
        };
        let model = PiecewiseConstant::new(&data);
        let lambda = of_data(&mesh, &model, &alternation(), &request(), &mut observe).unwrap();
        assert!(told <= 2, "{told}");
        let cells = barycentric_areas(&mesh);
        let (robust, all) = (data.robust_variance(&cells), data.variance(&cells));
        assert_eq!(lambda, largest(robust, cells.iter().sum()));
        assert!(all > 100.0 * robust);
        // Labels of a run that was broken off say nothing of its lambda.
        let request = Request { lambda, ..request() };
        let mut observe = |_: Option<&Sample>| ControlFlow::Break(());
        let found = separating(&mesh, &model, &alternation(), &request, &mut observe).unwrap();
        assert_eq!(found.lambda, None);
    }

    /// A time that is up leaves each lambda one step.
    #[test]
    fn lambdas_end_with_the_time() {
        let (mesh, data) = bands(0.4);
        let stop = Stop { time: Some(std::time::Duration::ZERO), ..request().stop };
        let (_, told) = looked(&mesh, &data, &Request { stop, ..request() }, 0.05);
        assert!(told <= TRIED as u64, "{told}");
    }

    /// Vertices of which nothing is known, and faces that have no area, change nothing.
    #[test]
    fn what_is_unknown_or_flat_changes_nothing() {
        let (mesh, data) = bands(0.1);
        let mut go = |_: Option<&Sample>| ControlFlow::Continue(());
        let mut found = |mesh: &Mesh, data: &Data| {
            let model = PiecewiseConstant::new(data);
            of_data(mesh, &model, &alternation(), &request(), &mut go).unwrap()
        };
        let lambda = found(&mesh, &data);
        let mut flat = mesh.clone();
        flat.faces.extend([[0, 0, 1], [2, 3, 3]]);
        assert_eq!(found(&flat, &data), lambda);
        let mut unknown = data.clone();
        unknown.values.iter_mut().step_by(9).for_each(|x| *x = f64::NAN);
        let (found, _) = looked(&mesh, &unknown, &request(), lambda);
        assert_eq!((found.regions, found.lambda), (3, Some(lambda)));
    }

    #[test]
    fn data_too_large_to_be_squared_are_refused() {
        let (mesh, mut data) = bands(0.1);
        data.values.iter_mut().for_each(|x| *x *= 1e200);
        let mut go = |_: Option<&Sample>| ControlFlow::Continue(());
        let model = PiecewiseConstant::new(&data);
        let error = of_data(&mesh, &model, &alternation(), &request(), &mut go).unwrap_err();
        assert!(error.to_string().contains("the costs of the data"), "{error}");
        // Distances are no larger than the data.
        assert!(of_data(&mesh, &L1::new(&data), &alternation(), &request(), &mut go).is_ok());
    }
}
