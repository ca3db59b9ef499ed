//! Segmentation of data: the alternation of the labels U and the region parameters, then a certificate.
//!
//! The parameters are re-estimated every r steps of U (the paper takes r = 10) until they settle. A bound
//! holds for fixed costs only, so it is void at each re-estimation; after the last one the problem is
//! solved to the requested gap, and that gap is a certificate for the parameters found.
//! Delaunoy et al., ICCV 2009, section 3.2.
//!
//! What the parameters are, what they cost and how they are fitted is the business of a [`DataModel`].
//!
//! Two regions with the same parameters become one, and the other is empty: `segment/unions.rs`.
//!
//! Coarse to fine, each coarser mesh goes through the same first, and passes on U, q and the parameters. What lambda is
//! taken where none is given: `segment/lambda.rs`.

mod coarse;
pub mod lambda;
mod unions;

use std::time::{Duration, Instant};

use rand::SeedableRng;
use rand_pcg::Pcg64;

use crate::coarse::{Pair, is_certified};
use crate::data::{DataModel, Initial, Scale};
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
use crate::start::cheapest;
use crate::sweep::collect;
use crate::unreached::unreached;

use unions::{Unions, united, without};

/// Re-estimations at the most; after them the parameters count as settled.
const MOST_ESTIMATES: usize = 200;

/// Parameters have settled when no one changes by more than this share of the scale of changes.
const SETTLED: f64 = 1e-4;

/// What is asked besides the [`Request`] to the solver.
#[derive(Clone, Debug)]
pub struct Alternation {
    /// m, from 2 to 64.
    pub regions: usize,
    /// Where the region parameters start.
    pub initial: Initial,
    /// For [`Pcg64`], which draws what starts at random.
    pub seed: u64,
    /// r, the steps of U between re-estimations; at least 1.
    pub every: u64,
}

/// What a segmentation ends with; P are the parameters of its model.
pub struct Segmentation<P> {
    /// Labels, energies and bounds, for the final parameters.
    pub solution: Solution,
    /// mu, one per region; what the final gap is a certificate for.
    pub parameters: Vec<P>,
    /// How often they were re-estimated.
    pub estimates: usize,
}

/// Segments data on a mesh as it is: no scaling. The model has a datum for each vertex of the mesh. `observe` is called
/// as [`Observer`] says. Panics if `every` is 0.
///
/// Fails if lambda, a setting of the solver or the number of regions is out of range, the model has another number of
/// vertices than the mesh, no face has an area, the integrated costs leave the range of double precision, or a fit of
/// the model fails.
pub fn segment<D: DataModel>(
    mesh: &Mesh,
    model: &D,
    alternation: &Alternation,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Segmentation<D::Parameters>> {
    request.check()?;
    regions::check(alternation.regions)?;
    assert!(alternation.every > 0);
    check_rows("data", model.vertices(), mesh)?;
    let (sound, mut warnings) = model_mesh(mesh)?;
    warnings.extend(unreached(&sound, |k| model.is_known(k)));
    let mut rng = Pcg64::seed_from_u64(alternation.seed);
    let weights = request.mass.weights(&sound);
    let mu = model.start(alternation.initial, alternation.regions, &weights, &mut rng)?;
    let order = Order::of(&sound);
    let (sound, model) = (order.mesh(sound), model.in_order(&order));
    let segmentation = with_regions!(
        alternation.regions,
        segment_compiled::<D>(&sound, warnings, &*model, mu, alternation, request, observe)
    )?;
    Ok(Segmentation { solution: segmentation.solution.of(mesh, &order), ..segmentation })
}

fn segment_compiled<const M: usize, D: DataModel>(
    mesh: &Mesh,
    mut warnings: Vec<String>,
    model: &D,
    mut mu: Vec<D::Parameters>,
    alternation: &Alternation,
    request: &Request,
    observe: Observer<'_>,
) -> Result<Segmentation<D::Parameters>> {
    let m = alternation.regions;
    let mass = request.mass.on(mesh);
    let integrate = |s: &[Row<M>]| mass.integrate(s);
    let scale = model.scale(&request.mass.weights(mesh));
    let level =
        Level { mesh, model, integrate: &integrate, scale, alternation, request, unite: true };
    let mut problem = level.problem(&mu)?;
    let (mut pair, mut record) = (None, None);
    if request.coarse_to_fine && !is_certified(&problem, request) {
        let spent;
        (mu, pair, spent) = coarse::start(&level, mu, observe)?;
        problem.set_costs(level.costs(&mu, &vec![true; m]));
        record = Some(spent);
    }
    let spent = record.as_ref().map_or(Duration::ZERO, |record| record.spent);
    let stop = request.stop.after(spent);
    let Found { problem, run, status, mu, estimates, settled, open, .. } =
        level.alternate(problem, mu, pair, spent, &stop, observe)?;

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
        _ => remark(&level, empty, &open, observe)?,
    };
    solution.summary.warnings.extend(said);
    Ok(Segmentation { solution, parameters: mu, estimates })
}

/// What must be said where the labels are fewer than what was asked for. That all data are the same says who has them,
/// with their name: `data/seen.rs`, `data/curved.rs`.
fn remark<D: DataModel, const M: usize>(
    level: &Level<'_, D, M>,
    empty: &[usize],
    open: &[bool],
    observe: Observer<'_>,
) -> Result<Option<String>> {
    let &Level { mesh, model, alternation, request, .. } = level;
    let different = model.different(alternation.regions);
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
            let request = Request { lambda: half, ..request.clone() };
            let found = lambda::separating(mesh, model, alternation, &request, observe)?;
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
    let cause = match one {
        true => format!(", since regions with one {} became one", D::TOLD),
        false => String::new(),
    };
    Ok(Some(format!("{}{cause}: {advice}", named(empty))))
}

/// The energy on one mesh, as one of U and mu: the mesh itself, or a coarser one with the model restricted to it.
struct Level<'a, D, const M: usize> {
    mesh: &'a Mesh,
    model: &'a D,
    /// s -> M s, with the mass matrix M.
    integrate: &'a dyn Fn(&[Row<M>]) -> Vec<Row<M>>,
    scale: Scale,
    alternation: &'a Alternation,
    /// Its `stop` is that of the whole, not of one level.
    request: &'a Request,
    /// Whether regions with the same parameters become one: not on a coarse mesh, since a finer one may part them.
    unite: bool,
}

/// What the alternation ends with.
struct Found<P, const M: usize> {
    problem: Problem<Stencil, M>,
    solver: Box<dyn Solver<Stencil, M>>,
    run: Run<M>,
    status: Status,
    mu: Vec<P>,
    estimates: usize,
    settled: bool,
    /// Which regions have not become one with another.
    open: Vec<bool>,
}

impl<D: DataModel, const M: usize> Level<'_, D, M> {
    /// f for given parameters, of which regions that are not open take nothing.
    fn costs(&self, mu: &[D::Parameters], open: &[bool]) -> Vec<Row<M>> {
        let f = (self.integrate)(&self.model.costs(mu));
        let open: [bool; M] = std::array::from_fn(|p| p < open.len() && open[p]);
        let row = |f: &Row<M>| Row::from_fn(|p| if open[p] { f.0[p] } else { NEVER });
        collect(f.len(), |v| row(&f[v]))
    }

    fn problem(&self, mu: &[D::Parameters]) -> Result<Problem<Stencil, M>> {
        let f = self.costs(mu, &vec![true; mu.len()]);
        let problem = Problem::new(Stencil::new(self.mesh), f, self.request.lambda);
        check_range(&problem)?;
        Ok(problem)
    }

    /// Re-estimates until the parameters settle, then solves for the last ones. Starts at `mu`, for which the problem
    /// is, and at U and q, if they are known; `spent` has gone by before.
    fn alternate(
        &self,
        mut problem: Problem<Stencil, M>,
        mut mu: Vec<D::Parameters>,
        pair: Option<Pair<M>>,
        spent: Duration,
        stop: &Stop,
        observe: Observer<'_>,
    ) -> Result<Found<D::Parameters, M>> {
        let Level { mesh, alternation, request, .. } = *self;
        let (start, dual_start) = match pair {
            Some(Pair { u, q }) => (u, Some(q)),
            None => (cheapest(&problem.f), None),
        };
        let mut run = Run::new(&start);
        run.charge(spent);
        if request.keep_dual {
            run.keep_dual();
        }
        let setup = Setup { mesh, problem: &problem, start, dual_start };
        let mut solver = request.method.build(setup)?;

        let begin = Instant::now();
        // What is left of the iterations and of the time.
        let rest = |used: u64| Stop {
            iterations: stop.iterations.map(|n| n.saturating_sub(used)),
            ..stop.after(begin.elapsed())
        };
        let mut estimates = 0;
        let mut settled = false;
        let mut unions = Unions::new(alternation.regions, self.scale.distance);
        let status = loop {
            let stop = rest(run.iterations());
            if settled || stop.iterations.is_some_and(|left| left <= alternation.every) {
                break run.advance(&mut *solver, &problem, &stop, observe);
            }
            let few =
                Stop { iterations: Some(alternation.every), time: stop.time, ..Stop::default() };
            match run.advance(&mut *solver, &problem, &few, observe) {
                Status::IterationLimit => {}
                end => break end,
            }
            let weights = (self.integrate)(solver.labels());
            let change = self.model.fit(&weights, &mut mu)?;
            estimates += 1;
            settled = change <= SETTLED * self.scale.change || estimates == MOST_ESTIMATES;
            let distance = |a: usize, b: usize| D::distance(&mu[a], &mu[b]);
            let pairs = match self.unite {
                true => unions.unite(distance, &weights, settled),
                false => Vec::new(),
            };
            problem.set_costs(self.costs(&mu, &unions.open));
            if pairs.is_empty() {
                solver.restart(&problem);
            } else {
                settled = estimates == MOST_ESTIMATES;
                let Iterate { u, q } = solver.iterate();
                let start = u.iter().map(|&u| pairs.iter().fold(u, |u, &pair| united(u, pair)));
                let closed =
                    |row: &Row<M>| pairs.iter().fold(*row, |row, pair| without(row, pair[1]));
                let dual_start = q.iter().map(|q| Tangent([closed(&q.0[0]), closed(&q.0[1])]));
                let setup = Setup {
                    mesh,
                    problem: &problem,
                    start: start.collect(),
                    dual_start: Some(dual_start.collect()),
                };
                solver = request.method.build(setup)?;
            }
            run.forget();
        };
        Ok(Found { problem, solver, run, status, mu, estimates, settled, open: unions.open })
    }
}

#[cfg(test)]
mod tests;
