//! Segmentation of data: the alternation of the labels U and the region parameters, then a certificate.
//!
//! The parameters are re-estimated every r steps of U (the paper takes r = 10) until they settle. A bound
//! holds for fixed costs only, so it is void at each re-estimation; after the last one the problem is
//! solved to the requested gap, and that gap is a certificate for the parameters found.
//! Delaunoy et al., ICCV 2009, section 3.2.
//!
//! Two regions of one mean become one, and the other is empty: `segment/unions.rs`.
//!
//! Coarse to fine, each coarser mesh goes through the same first, and passes on U, q and the parameters. What lambda is
//! taken where none is given: `segment/lambda.rs`.

mod coarse;
pub mod lambda;
mod unions;

use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::coarse::{Pair, is_certified};
use crate::data::kmeans::kmeans;
use crate::data::{Data, DataModel, PiecewiseConstant, RegionParameters};
use crate::error::Result;
use crate::field::{Row, Tangent};
use crate::mesh::Mesh;
use crate::mesh::order::Order;
use crate::operator::Stencil;
use crate::problem::{NEVER, Problem};
use crate::regions::{self, with_regions};
use crate::remarks::named;
use crate::run::{Run, Status, Stop};
use crate::solve::{Observer, Request, Solution, check_range, check_rows, conclude, model_mesh};
use crate::solver::{Iterate, Setup, Solver};
use crate::sweep::collect;
use crate::unreached::unreached;

use unions::{Unions, united, without};

/// Re-estimations at the most; after them the parameters count as settled.
const MOST_ESTIMATES: usize = 200;

/// Parameters have settled when no one moves by more than this share of the range of the data.
const SETTLED: f64 = 1e-4;

/// Where the region parameters start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Initial {
    /// Area-weighted k-means++ and Lloyd's iteration.
    KMeans,
    /// The means of a random partition of the vertices.
    Random,
}

impl Initial {
    pub const NAMES: [(&'static str, Initial); 2] =
        [("kmeans", Initial::KMeans), ("random", Initial::Random)];

    pub fn name(self) -> &'static str {
        match self {
            Initial::KMeans => "kmeans",
            Initial::Random => "random",
        }
    }
}

/// What is asked besides the [`Request`] to the solver.
#[derive(Clone, Debug)]
pub struct Alternation {
    /// m.
    pub regions: usize,
    pub initial: Initial,
    /// For [`Pcg64`].
    pub seed: u64,
    /// r, the steps of U between re-estimations.
    pub every: u64,
}

pub struct Segmentation {
    pub solution: Solution,
    /// One per region; what the final gap is a certificate for.
    pub parameters: Vec<RegionParameters>,
    /// How often they were re-estimated.
    pub estimates: usize,
}

/// Segments piecewise constant data on a mesh as it is: no scaling.
pub fn segment(
    mesh: &Mesh,
    data: &Data,
    alternation: &Alternation,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Segmentation> {
    request.check()?;
    regions::check(alternation.regions)?;
    assert!(alternation.every > 0);
    check_rows("data", data.len(), mesh)?;
    let (model, mut warnings) = model_mesh(mesh)?;
    warnings.extend(unreached(&model, |k| data.is_known(k)));
    let initial = initial_means(&model, data, alternation, request);
    let order = Order::of(&model);
    let (model, data) = (order.mesh(model), data.in_order(&order));
    let segmentation = with_regions!(
        alternation.regions,
        segment_compiled(&model, warnings, &data, initial, alternation, request, observe)
    )?;
    Ok(Segmentation { solution: segmentation.solution.of(mesh, &order), ..segmentation })
}

fn segment_compiled<const M: usize>(
    mesh: &Mesh,
    warnings: Vec<String>,
    data: &Data,
    means: Vec<Vec<f64>>,
    alternation: &Alternation,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Segmentation> {
    let m = alternation.regions;
    let asked = Asked { alternation, request, stop: request.stop.clone(), unite: true };
    let mass = request.mass.on(mesh);
    let integrate = |s: &[Row<M>]| mass.integrate(s);
    let level = Level { mesh, data, integrate: &integrate };
    let mut first = State { problem: level.problem(&means, &asked)?, means, pair: None };
    let mut record = None;
    if request.coarse_to_fine && !is_certified(&first.problem, request) {
        let (means, pair, spent) = coarse::start(mesh, data, first.means, &asked, observe)?;
        let model = PiecewiseConstant::new(data, means.clone());
        first.problem.set_costs(level.costs(&model, &vec![true; m]));
        (first.means, first.pair, record) = (means, pair, Some(spent));
    }
    let spent = record.as_ref().map_or(Duration::ZERO, |record| record.spent);
    let asked = Asked { stop: request.stop.after(spent), ..asked };
    let Found { problem, run, status, parameters, estimates, settled, open, .. } =
        alternate(&level, first, spent, &asked, observe)?;

    let mut warnings = warnings;
    if !settled || estimates == MOST_ESTIMATES {
        // Contradicted bounds certify nothing.
        let certificate = match status {
            Status::Contradicted => "",
            _ => "; the certificate holds for the last ones",
        };
        // About what ended them, if it can be moved. Who breaks off does not want to wait for advice.
        let advice = match status {
            Status::IterationLimit => "; raise --max-iterations",
            Status::TimeLimit => "; raise --time-limit",
            _ => "",
        };
        warnings.push(format!(
            "the region parameters still moved after {estimates} re-estimations{certificate}{advice}"
        ));
    }
    let mut solution = conclude(mesh, &problem, m, request, run, status, warnings);
    solution.summary.coarse_to_fine = record;
    let empty = &solution.summary.empty_regions;
    let said = match status {
        // Who breaks off does not want to wait for advice.
        Status::Interrupted => None,
        _ if empty.is_empty() => None,
        Status::IterationLimit | Status::TimeLimit => {
            Some(format!("{} so far: the run ended before its gap was reached", named(empty)))
        }
        _ => remark(mesh, data, empty, &open, alternation, request, observe)?,
    };
    solution.summary.warnings.extend(said);
    Ok(Segmentation { solution, parameters, estimates })
}

/// What must be said where the labels are fewer than what was asked for. That all data are the same says who has them,
/// with their name: `data/seen.rs`, `data/curved.rs`.
fn remark(
    mesh: &Mesh,
    data: &Data,
    empty: &[usize],
    open: &[bool],
    alternation: &Alternation,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Option<String>> {
    let different = different(data, alternation.regions);
    if different == 1 {
        return Ok(None);
    }
    if different < alternation.regions {
        return Ok(Some(format!(
            "{}: the data have only {different} different values; ask for {different} regions",
            named(empty)
        )));
    }
    let half = 0.5 * request.lambda;
    let fewer = alternation.regions - empty.len();
    let found = match half > 0.0 {
        true => {
            let wanted = lambda::Wanted { mesh, data, alternation, request, from: half };
            let found = lambda::separating(&wanted, observe)?;
            // No lambda makes regions that the data do not have.
            found.lambda.filter(|_| found.regions == alternation.regions)
        }
        false => None,
    };
    let advice = match found {
        // The coarse mesh may keep a region a little longer than the fine one.
        Some(lambda) => {
            let lambda = 0.5 * lambda;
            format!("lambda is too large for these data; try --lambda {lambda:.1e}")
        }
        None if fewer > 1 => format!(
            "the data do not separate into {} regions; ask for {fewer}",
            alternation.regions
        ),
        None => "the data do not separate into regions; choose other data".into(),
    };
    let one = open.iter().any(|open| !open);
    let cause = if one { ", since regions with one mean became one" } else { "" };
    Ok(Some(format!("{}{cause}: {advice}", named(empty))))
}

/// How many different values the data have, counted up to a number.
fn different(data: &Data, most: usize) -> usize {
    let mut found: Vec<&[f64]> = Vec::new();
    for value in (0..data.len()).filter(|&k| data.is_known(k)).map(|k| data.at(k)) {
        if !found.contains(&value) {
            found.push(value);
            if found.len() == most {
                break;
            }
        }
    }
    found.len()
}

/// What the alternation works on: the mesh itself, or a coarser one with the means of its data.
struct Level<'a, const M: usize> {
    mesh: &'a Mesh,
    data: &'a Data,
    /// s -> M s, with the mass matrix M.
    integrate: &'a dyn Fn(&[Row<M>]) -> Vec<Row<M>>,
}

impl<const M: usize> Level<'_, M> {
    /// f for the parameters of the model, of which regions that are not open take nothing.
    fn costs(&self, model: &PiecewiseConstant, open: &[bool]) -> Vec<Row<M>> {
        let f = (self.integrate)(&DataModel::<M>::costs(model));
        let open: [bool; M] = std::array::from_fn(|p| p < open.len() && open[p]);
        let row = |f: &Row<M>| Row::from_fn(|p| if open[p] { f.0[p] } else { NEVER });
        collect(f.len(), |v| row(&f[v]))
    }

    fn problem(&self, means: &[Vec<f64>], asked: &Asked<'_>) -> Result<Problem<Stencil, M>> {
        let model = PiecewiseConstant::new(self.data, means.to_vec());
        let f = self.costs(&model, &vec![true; means.len()]);
        let problem = Problem::new(Stencil::new(self.mesh), f, asked.request.lambda);
        check_range(&problem)?;
        Ok(problem)
    }
}

/// How it is done, and when it ends.
struct Asked<'a> {
    alternation: &'a Alternation,
    request: &'a Request,
    stop: Stop,
    /// Whether regions of one mean become one: not on a coarse mesh, since a finer one may part them.
    unite: bool,
}

/// Where it starts: the means of the regions and the problem for them, and U and q, if they are known.
struct State<const M: usize> {
    problem: Problem<Stencil, M>,
    means: Vec<Vec<f64>>,
    pair: Option<Pair<M>>,
}

/// What it ends with.
struct Found<const M: usize> {
    problem: Problem<Stencil, M>,
    solver: Box<dyn Solver<Stencil, M>>,
    run: Run<M>,
    status: Status,
    parameters: Vec<RegionParameters>,
    estimates: usize,
    settled: bool,
    /// Which regions have not become one with another.
    open: Vec<bool>,
}

/// Re-estimates until the parameters settle, then solves for the last ones.
fn alternate<const M: usize>(
    level: &Level<'_, M>,
    first: State<M>,
    spent: Duration,
    asked: &Asked<'_>,
    observe: Observer<'_>,
) -> Result<Found<M>> {
    let Asked { alternation, request, stop, unite } = asked;
    let State { mut problem, means, pair } = first;
    let mut model = PiecewiseConstant::new(level.data, means);
    let (start, dual_start) = match pair {
        Some(Pair { u, q }) => (u, Some(q)),
        None => {
            let f = &problem.f;
            (collect(f.len(), |v| Row::one_hot(f[v].argmin())), None)
        }
    };
    let mut run = Run::new(&start);
    run.charge(spent);
    if request.keep_dual {
        run.keep_dual();
    }
    let setup = Setup { mesh: level.mesh, problem: &problem, start, dual_start };
    let mut solver = request.method.build(setup)?;

    let range = range(level.data);
    let deviation = level.data.robust_variance(&request.mass.weights(level.mesh)).sqrt();
    let begin = Instant::now();
    // What is left of the iterations and of the time.
    let rest = |used: u64| Stop {
        iterations: stop.iterations.map(|n| n.saturating_sub(used)),
        ..stop.after(begin.elapsed())
    };
    let mut estimates = 0;
    let mut settled = false;
    let mut unions = Unions::new(alternation.regions, deviation);
    let status = loop {
        let stop = rest(run.iterations());
        if settled || stop.iterations.is_some_and(|left| left <= alternation.every) {
            break run.advance(&mut *solver, &problem, &stop, observe);
        }
        let few = Stop { iterations: Some(alternation.every), time: stop.time, ..Stop::default() };
        match run.advance(&mut *solver, &problem, &few, observe) {
            Status::IterationLimit => {}
            end => break end,
        }
        let weights = (level.integrate)(solver.labels());
        let change = DataModel::<M>::fit(&mut model, &weights);
        estimates += 1;
        settled = change <= SETTLED * range || estimates == MOST_ESTIMATES;
        let pairs = match unite {
            true => unions.unite(&DataModel::<M>::parameters(&model), &weights, settled),
            false => Vec::new(),
        };
        problem.set_costs(level.costs(&model, &unions.open));
        if pairs.is_empty() {
            solver.restart(&problem);
        } else {
            settled = estimates == MOST_ESTIMATES;
            let Iterate { u, q } = solver.iterate();
            let start = u.iter().map(|&u| pairs.iter().fold(u, |u, &pair| united(u, pair)));
            let closed = |row: &Row<M>| pairs.iter().fold(*row, |row, pair| without(row, pair[1]));
            let dual_start = q.iter().map(|q| Tangent([closed(&q.0[0]), closed(&q.0[1])]));
            let setup = Setup {
                mesh: level.mesh,
                problem: &problem,
                start: start.collect(),
                dual_start: Some(dual_start.collect()),
            };
            solver = request.method.build(setup)?;
        }
        run.forget();
    };
    let parameters = DataModel::<M>::parameters(&model);
    Ok(Found { problem, solver, run, status, parameters, estimates, settled, open: unions.open })
}

fn initial_means(
    mesh: &Mesh,
    data: &Data,
    alternation: &Alternation,
    request: &Request,
) -> Vec<Vec<f64>> {
    let area = data.known_area(&request.mass.weights(mesh));
    let mut rng = Pcg64::seed_from_u64(alternation.seed);
    let regions = alternation.regions;
    match alternation.initial {
        Initial::KMeans => kmeans(&data.values, data.dimension, &area, regions, &mut rng),
        Initial::Random => {
            let mut mass = vec![0.0; regions];
            let mut sums = vec![vec![0.0; data.dimension]; regions];
            for (k, &a) in area.iter().enumerate() {
                let p = rng.random_range(0..regions);
                if !data.is_known(k) {
                    continue;
                }
                mass[p] += a;
                for (sum, c) in sums[p].iter_mut().zip(data.at(k)) {
                    *sum += a * c;
                }
            }
            // A region that drew no vertex starts at the mean of all.
            let total: f64 = mass.iter().sum();
            let mean: Vec<f64> = (0..data.dimension)
                .map(|i| sums.iter().map(|sum| sum[i]).sum::<f64>() / total)
                .collect();
            sums.into_iter()
                .zip(mass)
                .map(|(sum, mass)| {
                    if mass > 0.0 {
                        sum.into_iter().map(|sum| sum / mass).collect()
                    } else {
                        mean.clone()
                    }
                })
                .collect()
        }
    }
}

/// The widest range of a coordinate of the data.
fn range(data: &Data) -> f64 {
    (0..data.dimension)
        .map(|i| {
            // f64::min and max take no notice of NaN.
            let column = data.values[i..].iter().step_by(data.dimension).copied();
            let (low, high) = column.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (f64::min(low, x), f64::max(high, x))
            });
            high - low
        })
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests;
