//! The loop: what it records, when it stops, and that it is resumable.

use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use super::*;
use crate::field::Tangent;
use crate::mesh::Mesh;
use crate::operator::{Face, Stencil};
use crate::samples::{bumpy, random_problem};
use crate::solver::{Iterate, Method, OneByOne, Setup, Step};

fn go(_: Option<&Sample>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn uniform(mesh: &Mesh) -> Vec<Row<3>> {
    vec![Row([1.0 / 3.0; 3]); mesh.vertices.len()]
}

fn solver(name: &str, mesh: &Mesh, problem: &Problem<Stencil, 3>) -> Box<dyn Solver<Stencil, 3>> {
    let setup = Setup { domain: mesh.into(), problem, start: uniform(mesh), dual_start: None };
    Method::named(name).unwrap().build(setup).unwrap()
}

fn every(interval: u64, iterations: u64) -> Stop {
    Stop { interval: Some(interval), iterations: Some(iterations), ..Stop::default() }
}

const NAMES: [&str; 4] = ["chambolle-pock", "douglas-rachford", "fista", "projected-gradient"];

#[test]
fn a_run_can_be_resumed() {
    let mesh = bumpy(7);
    let problem = random_problem::<3>(&mesh, 0.05, 101);
    for name in NAMES {
        let run_in_parts = |parts: &[u64]| {
            let mut solver = solver(name, &mesh, &problem);
            let mut run = Run::new(&uniform(&mesh));
            for &part in parts {
                let status = run.advance(&mut *solver, &problem, &every(5, part), &mut go);
                assert_eq!(status, Status::IterationLimit);
            }
            let trace: Vec<_> = (run.trace.iter())
                .map(|s| (s.iteration, s.energy, s.dual_bound, s.change, s.smoothed_energy))
                .collect();
            (trace, run.best_u().to_vec(), run.iterations())
        };
        assert_eq!(run_in_parts(&[20]), run_in_parts(&[10, 10]), "{name}");
        assert_eq!(
            run_in_parts(&[20]).0.iter().map(|s| s.0).collect::<Vec<_>>(),
            [0, 5, 10, 15, 20]
        );
    }
}

#[test]
fn the_first_sample_is_that_of_the_start() {
    let mesh = bumpy(6);
    let problem = random_problem::<3>(&mesh, 0.05, 102);
    for name in NAMES {
        let mut run = Run::new(&uniform(&mesh));
        run.advance(&mut *solver(name, &mesh, &problem), &problem, &every(1, 1), &mut go);
        let first = &run.trace[0];
        assert_eq!((first.iteration, first.seconds, first.change), (0, 0.0, None));
        assert_eq!(first.energy, problem.baseline + problem.energy(&uniform(&mesh)));
        assert_eq!(first.dual_bound, problem.baseline);
        assert_eq!(first.gap, problem.energy(&uniform(&mesh)));
        assert_eq!(first.relative_gap, 1.0);
        let exact = ["chambolle-pock", "douglas-rachford"].contains(&name);
        let smoothing = solver(name, &mesh, &problem).smoothing();
        assert_eq!(smoothing.is_none(), exact);
        let smoothed = |s| problem.baseline + problem.smoothed_energy(&uniform(&mesh), s);
        assert_eq!(first.smoothed_energy, smoothing.map(smoothed));
    }
}

/// The intervals between samples grow; the last iteration is always sampled.
#[test]
fn samples_become_sparser() {
    let mesh = bumpy(4);
    let problem = random_problem::<3>(&mesh, 0.5, 103);
    let mut run = Run::new(&uniform(&mesh));
    let stop = Stop { iterations: Some(1003), ..Stop::default() };
    run.advance(&mut *solver("fista", &mesh, &problem), &problem, &stop, &mut go);
    let at: Vec<u64> = run.trace.iter().map(|sample| sample.iteration).collect();
    assert_eq!(at[..4], [0, 4, 8, 12]);
    assert_eq!(at.last(), Some(&1003));
    assert!(at.windows(2).all(|pair| pair[1] - pair[0] <= 40));
    assert!(at.len() < 120, "{}", at.len());
}

/// With a requested gap, the intervals follow the predicted number of steps, but are at most a quarter of the steps so
/// far.
#[test]
fn samples_are_taken_where_the_gap_is_predicted() {
    let mesh = bumpy(12);
    let problem = random_problem::<3>(&mesh, 0.02, 108);
    let solve = |interval| {
        let mut run = Run::new(&uniform(&mesh));
        let stop = Stop { relative_gap: Some(1e-6), interval, ..Stop::default() };
        let status =
            run.advance(&mut *solver("chambolle-pock", &mesh, &problem), &problem, &stop, &mut go);
        assert_eq!(status, Status::Converged);
        run
    };
    let (dense, sparse) = (solve(Some(4)), solve(None));
    assert!(dense.iterations() > 100, "{}", dense.iterations());
    assert!(sparse.trace.len() < dense.trace.len() / 2, "{}", sparse.trace.len());
    assert!(sparse.iterations() <= dense.iterations() * 5 / 4, "{}", sparse.iterations());
    let far = |pair: &[Sample]| {
        pair[1].iteration - pair[0].iteration <= (2 * FIRST_INTERVAL).max(pair[0].iteration / 4)
    };
    assert!(sparse.trace.windows(2).all(far));
}

#[test]
fn best_bounds_only_improve() {
    let mesh = bumpy(8);
    let problem = random_problem::<3>(&mesh, 0.05, 104);
    for name in NAMES {
        let mut run = Run::new(&uniform(&mesh));
        run.advance(&mut *solver(name, &mesh, &problem), &problem, &every(1, 200), &mut go);
        for pair in run.trace.windows(2) {
            assert!(pair[1].energy <= pair[0].energy && pair[1].dual_bound >= pair[0].dual_bound);
            assert!(pair[1].gap >= 0.0 && pair[1].relative_gap <= pair[0].relative_gap + 1e-12);
        }
        let last = run.trace.last().unwrap();
        assert_eq!(run.energy(), problem.energy(run.best_u()));
        let above = |x: f64| problem.baseline + x;
        assert_eq!((last.energy, last.dual_bound), (above(run.energy()), above(run.bound())));
    }
}

/// A scripted solver: all rows of step n are `rows[n]`, and the dual field is zero.
struct Script {
    rows: Vec<[f64; 3]>,
    step: usize,
    u: Vec<Row<3>>,
    q: Vec<Tangent<3>>,
}

impl Script {
    fn new(mesh: &Mesh, rows: &[[f64; 3]]) -> Self {
        let u = vec![Row(rows[0]); mesh.vertices.len()];
        Script { rows: rows.to_vec(), step: 0, u, q: vec![Tangent::ZERO; mesh.faces.len()] }
    }
}

impl Step<Stencil, 3> for Script {
    fn step(&mut self, _: &Problem<Stencil, 3>) {
        self.step = (self.step + 1).min(self.rows.len() - 1);
        self.u.fill(Row(self.rows[self.step]));
    }

    fn iterate(&self) -> Iterate<'_, 3> {
        Iterate { u: &self.u, q: &self.q }
    }
}

/// Costs 0, 1, 2 at every vertex of a mesh of area 1.
fn ladder(mesh: &Mesh) -> Problem<Stencil, 3> {
    let share = 1.0 / mesh.vertices.len() as f64;
    let f = vec![Row([0.0, share, 2.0 * share]); mesh.vertices.len()];
    Problem::new(Stencil::new(mesh), f, 1.0)
}

#[test]
fn the_change_is_the_maximum_over_all_entries() {
    let mesh = bumpy(3);
    let script = Script::new(
        &mesh,
        &[[0.0, 0.0, 1.0], [0.0, 0.25, 0.75], [0.5, 0.25, 0.25], [0.5, 0.2, 0.3]],
    );
    let mut run = Run::new(&script.u.clone());
    let stop = Stop { change: Some(0.2), interval: Some(1), ..Stop::default() };
    assert_eq!(
        run.advance(&mut OneByOne::new(script), &ladder(&mesh), &stop, &mut go),
        Status::Stalled
    );
    let changes: Vec<f64> = run.trace.iter().filter_map(|sample| sample.change).collect();
    assert_eq!(changes.len(), 3);
    for (change, expected) in changes.iter().zip([0.25, 0.5, 0.05]) {
        assert!((change - expected).abs() < 1e-15);
    }
}

/// The best U is kept when the iterates become worse, and the sample reports its energy.
#[test]
fn an_interrupted_run_keeps_the_best_u() {
    let mesh = bumpy(3);
    let script = Script::new(&mesh, &[[0.0, 0.0, 1.0], [0.0, 0.9, 0.1], [0.0, 0.5, 0.5]]);
    let mut run = Run::new(&script.u.clone());
    let mut seen = 0;
    let mut observe = |_: Option<&Sample>| {
        seen += 1;
        if seen < 7 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    let stop = Stop { interval: Some(1), ..Stop::default() };
    let status = run.advance(&mut OneByOne::new(script), &ladder(&mesh), &stop, &mut observe);
    assert_eq!((status, run.iterations()), (Status::Interrupted, 7));
    assert!((run.energy() - 1.1).abs() < 1e-12 && run.best_u()[0] == Row([0.0, 0.9, 0.1]));
    // B = 0.
    assert_eq!(run.trace.last().unwrap().energy, run.energy());
}

/// Interrupted between two passes of eight steps, a run makes one more step: an over-relaxed iterate may be infeasible.
#[test]
fn an_interrupt_between_samples_ends_with_a_feasible_pair() {
    let mesh = bumpy(6);
    let problem = random_problem::<3>(&mesh, 0.05, 105);
    let mut solver = solver("chambolle-pock", &mesh, &problem);
    let mut run = Run::new(&uniform(&mesh));
    let mut seen = 0;
    let mut observe = |_: Option<&Sample>| {
        seen += 1;
        if seen == 6 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let status = run.advance(&mut *solver, &problem, &every(25, 1000), &mut observe);
    // Calls come before each pass but the first, and with each sample: 8, 16, 24, [25], 33, 41.
    assert_eq!((status, run.iterations()), (Status::Interrupted, 42));
    assert_eq!(run.trace.last().unwrap().iteration, 42);
    assert!(solver.iterate().u.iter().all(|u| u.min() >= 0.0));
}

#[test]
fn each_criterion_stops_by_itself() {
    let mesh = bumpy(6);
    let problem = random_problem::<3>(&mesh, 0.05, 106);
    let end = |stop: Stop| {
        let mut run = Run::new(&uniform(&mesh));
        let status =
            run.advance(&mut *solver("chambolle-pock", &mesh, &problem), &problem, &stop, &mut go);
        (status, run)
    };
    let (status, run) = end(Stop { relative_gap: Some(1e-3), ..Stop::default() });
    assert_eq!(status, Status::Converged);
    assert!(run.trace.last().unwrap().relative_gap <= 1e-3);
    let before = &run.trace[run.trace.len() - 2];
    assert!(before.relative_gap > 1e-3);
    let (status, run) = end(Stop { time: Some(Duration::ZERO), ..Stop::default() });
    assert_eq!((status, run.iterations()), (Status::TimeLimit, 1));
    let (status, run) = end(Stop { iterations: Some(0), ..Stop::default() });
    assert_eq!((status, run.iterations(), run.trace.len()), (Status::IterationLimit, 0, 1));
    // The run stops at the first sample within the gap, not before.
    let to = |gap| end(Stop { relative_gap: Some(gap), interval: Some(4), ..Stop::default() });
    let (_, run) = to(1e-3);
    let gap = run.trace[run.trace.len() - 2].relative_gap;
    let (status, run) = to(gap);
    assert_eq!((status, run.trace.last().unwrap().relative_gap), (Status::Converged, gap));
    assert!(to(0.99 * gap).1.iterations() > run.iterations());
    // The start may already be within the gap.
    let (status, run) = end(Stop { relative_gap: Some(1e9), ..Stop::default() });
    assert_eq!((status, run.iterations()), (Status::Converged, 0));
}

/// After the costs change, neither the old energy nor the old bound counts: the old bounds would be false here. The
/// first sample of the new costs replaces the last one of the old costs.
#[test]
fn changed_costs_void_energies_and_bounds() {
    let mesh = bumpy(6);
    let expensive = random_problem::<3>(&mesh, 0.05, 107);
    let cheap = || expensive.f.iter().map(|&f| f * 1e-3).collect();
    for name in NAMES {
        let mut problem = Problem::new(Stencil::new(&mesh), expensive.f.clone(), expensive.lambda);
        let mut solver = solver(name, &mesh, &problem);
        let mut run = Run::new(&uniform(&mesh));
        run.keep_dual();
        run.advance(&mut *solver, &problem, &every(10, 50), &mut go);
        let (rows, before) = (run.trace.len(), run.bound());
        problem.set_costs(cheap());
        solver.restart(&problem);
        run.forget();
        assert!(run.best_q().unwrap().is_empty());
        run.advance(&mut *solver, &problem, &every(10, 0), &mut go);
        assert_eq!(run.trace.len(), rows);
        let last = run.trace.last().unwrap();
        let energy = problem.baseline + problem.energy(run.best_u());
        assert_eq!((last.iteration, last.energy), (50, energy), "{name}");
        assert_eq!(run.best_u(), solver.iterate().u);
        // The minimum energy of the new costs lies below the bound of the old ones.
        let minimum = (0..3).map(|p| problem.energy(&vec![Row::one_hot(p); mesh.vertices.len()]));
        let minimum = minimum.fold(f64::INFINITY, f64::min);
        assert!(before > minimum, "{name}: {before} {minimum}");
        assert!(run.bound() <= minimum, "{name}: {} {minimum}", run.bound());
    }
}

/// After the costs change, a call with a gap to reach evaluates the iterate at once, one without it after its steps.
#[test]
fn changed_costs_are_evaluated_at_once_for_a_gap() {
    let mesh = bumpy(6);
    let mut problem = random_problem::<3>(&mesh, 0.05, 108);
    for (relative_gap, at_once) in [(None, false), (Some(0.0), true)] {
        let mut solver = solver(NAMES[0], &mesh, &problem);
        let mut run = Run::new(&uniform(&mesh));
        run.advance(&mut *solver, &problem, &every(10, 10), &mut go);
        let f = problem.f.iter().map(|&f| f * 0.5).collect();
        problem.set_costs(f);
        solver.follow(&problem);
        run.forget();
        let before = run.trace.clone();
        run.advance(&mut *solver, &problem, &Stop { relative_gap, ..every(10, 10) }, &mut go);
        let kept = run.trace[1].energy == before[1].energy;
        assert_eq!((run.trace.len(), kept), (3, !at_once));
    }
}

/// The kept field has the reported bound.
#[test]
fn the_kept_field_certifies_the_bound() {
    let mesh = bumpy(8);
    let problem = random_problem::<3>(&mesh, 0.05, 109);
    for name in NAMES {
        let mut run = Run::new(&uniform(&mesh));
        run.keep_dual();
        run.advance(&mut *solver(name, &mesh, &problem), &problem, &every(7, 300), &mut go);
        let q = run.best_q().unwrap();
        assert!(q.iter().all(|q| q.norm() <= problem.lambda * (1.0 + 1e-14)), "{name}");
        let bound = problem.dual_bound(q);
        assert!(
            (bound - run.bound()).abs() <= 1e-12 * problem.spread(),
            "{name}: {bound} {}",
            run.bound()
        );
    }
}

/// A run keeps the best constant labels and their field, which its solver never finds, and does so again for other
/// costs.
#[test]
fn constant_labels_and_their_field_are_kept() {
    let mesh = bumpy(6);
    let mut problem = random_problem::<3>(&mesh, 1e3, 111);
    let mut script = OneByOne::new(Script::new(&mesh, &[[0.2, 0.3, 0.5]]));
    let mut run = Run::new(Solver::<Stencil, 3>::labels(&mut script));
    run.keep_dual();
    for _ in 0..2 {
        let status =
            run.advance(&mut script, &problem, &every(10, STEPS_BEFORE_CONSTANT + 10), &mut go);
        assert_eq!(status, Status::IterationLimit);
        let constant = (0..3).map(|p| vec![Row::one_hot(p); mesh.vertices.len()]);
        let minimum = constant.map(|u| problem.energy(&u)).fold(f64::INFINITY, f64::min);
        assert_eq!((run.energy(), problem.energy(run.best_u())), (minimum, minimum));
        let (q, size) = (run.best_q().unwrap(), problem.spread());
        assert!(q.iter().all(|q| q.norm() <= problem.lambda * (1.0 + 1e-14)));
        assert!((problem.dual_bound(q) - run.bound()).abs() <= 1e-12 * size);
        assert!(minimum - run.bound() <= 1e-9 * size, "{minimum} {}", run.bound());
        let turned = |f: &Row<3>| Row([f.0[2], f.0[0], f.0[1]]) * 0.1;
        problem.set_costs(problem.f.iter().map(turned).collect());
        run.forget();
    }
}

/// If the best U already is the best constant labeling, it is still certified by its field.
#[test]
fn constant_labels_of_the_solver_get_their_field() {
    let mesh = bumpy(6);
    let problem = random_problem::<3>(&mesh, 1e3, 114);
    let constant = |p: usize| problem.energy(&vec![Row::one_hot(p); mesh.vertices.len()]);
    let best = (0..3).min_by(|&a, &b| constant(a).total_cmp(&constant(b))).unwrap();
    let script = Script::new(&mesh, &[Row::<3>::one_hot(best).0]);
    let mut run = Run::new(&script.u.clone());
    run.advance(&mut OneByOne::new(script), &problem, &every(10, STEPS_BEFORE_CONSTANT), &mut go);
    assert_eq!(run.energy(), constant(best));
    assert!(run.energy() - run.bound() <= 1e-9 * problem.spread(), "{}", run.bound());
}

/// NaN in U or q gives no bound, and ends the run before any gap does.
#[test]
fn nan_ends_a_run() {
    let mesh = bumpy(3);
    let problem = ladder(&mesh);
    let stop = Stop { relative_gap: Some(2.0), interval: Some(1), ..every(1, 5) };
    for (row, x) in [([f64::NAN; 3], 0.0), ([0.0, 0.0, 1.0], f64::NAN)] {
        let mut script = Script::new(&mesh, &[row]);
        script.q.fill(Tangent([Row([x; 3]); 2]));
        let start = vec![Row([0.0, 1.0, 0.0]); mesh.vertices.len()];
        let mut run = Run::new(&start);
        assert_eq!(
            run.advance(&mut OneByOne::new(script), &problem, &stop, &mut go),
            Status::Diverged
        );
        assert_eq!(run.bound(), 0.0);
        assert!(run.best_u().iter().all(|u| u.max() == 1.0));
    }
}

/// The best bound of an external solver is kept; one above the energy is clamped if rounding can cause the excess, and
/// is a contradiction otherwise, however small the excess is.
#[test]
fn bounds_of_external_solvers_are_kept_clamped_or_contradict() {
    let mesh = bumpy(6);
    let problem = random_problem::<3>(&mesh, 0.05, 112);
    let u = uniform(&mesh);
    let energy = problem.energy(&u);
    let record = |shares: &[f64]| {
        let mut run = Run::new(&u);
        for (iteration, share) in (1..).zip(shares) {
            run.record(
                &problem,
                &Reached {
                    iteration,
                    seconds: 0.0,
                    u: &u,
                    dual_bound: share * energy,
                    certificate: Certificate::Offered,
                    smoothed_energy: None,
                },
            );
        }
        run
    };
    assert_eq!(record(&[0.3, 0.7, 0.5]).bound(), 0.7 * energy);
    let run = record(&[1.0 + 4.0 * f64::EPSILON]);
    assert!(!run.is_contradicted() && run.bound() == energy && run.trace[0].gap == 0.0);
    for excess in [1e-9, 1e-5, 1.0] {
        let run = record(&[1.0 + excess]);
        assert!(run.is_contradicted() && run.trace[0].gap < 0.0, "{excess:e}");
    }
}

#[test]
fn spent_time_reduces_the_time_limit() {
    let seconds = Duration::from_secs;
    let stop = Stop { time: Some(seconds(3)), iterations: Some(7), ..Stop::default() };
    assert_eq!(stop.after(seconds(1)).time, Some(seconds(2)));
    assert_eq!(stop.after(seconds(5)).time, Some(Duration::ZERO));
    assert_eq!(
        (stop.after(seconds(5)).iterations, Stop::default().after(seconds(5)).time),
        (Some(7), None)
    );
}

/// A solver with an infeasible field yields a false bound: the status reports it, and nothing is certified.
#[test]
fn a_bound_above_an_energy_is_a_contradiction() {
    let mesh = bumpy(6);
    let problem = random_problem::<3>(&mesh, 0.05, 110);
    let mut solver = solver("chambolle-pock", &mesh, &problem);
    let mut run = Run::new(&uniform(&mesh));
    let stop = Stop { relative_gap: Some(1e-6), ..Stop::default() };
    assert_eq!(run.advance(&mut *solver, &problem, &stop, &mut go), Status::Converged);
    // The optimal field is infeasible for lambda = 0, whose optimal bound is B.
    let wrong = Problem::new(Stencil::new(&mesh), problem.f.clone(), 0.0);
    let argmin: Vec<Row<3>> = problem.f.iter().map(|f| Row::one_hot(f.argmin())).collect();
    let q = solver.iterate().q.to_vec();
    let false_solver = Script { rows: vec![[1.0, 0.0, 0.0]], step: 0, u: argmin.clone(), q };
    let mut run = Run::new(&argmin);
    let status = run.advance(&mut OneByOne::new(false_solver), &wrong, &every(1, 5), &mut go);
    assert_eq!(status, Status::Contradicted);
    let last = run.trace.last().unwrap();
    assert!(last.gap < 0.0 && run.is_contradicted(), "{}", last.gap);
}

/// A simulated clock in seconds that advances with the work done, used only by [`only_work_is_on_the_clock`].
static TIME: AtomicU64 = AtomicU64::new(0);
static COLUMN_READS: AtomicU64 = AtomicU64::new(0);

const STEP_SECONDS: u64 = 1000;
const EVALUATION_SECONDS: u64 = 1_000_000;

fn now() -> Instant {
    static ORIGIN: LazyLock<Instant> = LazyLock::new(Instant::now);
    *ORIGIN + Duration::from_secs(TIME.load(Relaxed))
}

/// An operator whose column reads take a second per face, and a solver that stays at its start: a step takes
/// [`STEP_SECONDS`], an evaluation of its iterate [`EVALUATION_SECONDS`].
struct Slow<T>(T);

impl Operator for Slow<Stencil> {
    type Adjoint<'a> = <Stencil as Operator>::Adjoint<'a>;

    fn faces(&self) -> usize {
        self.0.faces()
    }

    fn vertices(&self) -> usize {
        self.0.vertices()
    }

    fn area(&self, j: usize) -> f64 {
        self.0.area(j)
    }

    fn face(&self, j: usize) -> Face {
        TIME.fetch_add(1, Relaxed);
        COLUMN_READS.fetch_add(1, Relaxed);
        self.0.face(j)
    }

    fn at<const M: usize>(&self, u: &[Row<M>], j: usize) -> Tangent<M> {
        self.0.at(u, j)
    }

    fn adjoint(&self) -> Self::Adjoint<'_> {
        self.0.adjoint()
    }
}

impl Solver<Slow<Stencil>, 3> for Slow<Script> {
    fn advance(
        &mut self,
        _: &Problem<Slow<Stencil>, 3>,
        steps: u64,
        go_on: &mut dyn FnMut() -> bool,
    ) -> u64 {
        let made = (1..steps).find(|_| !go_on()).unwrap_or(steps);
        TIME.fetch_add(STEP_SECONDS * made, Relaxed);
        made
    }

    fn change(&mut self) -> f64 {
        0.0
    }

    fn iterate(&mut self) -> Iterate<'_, 3> {
        TIME.fetch_add(EVALUATION_SECONDS, Relaxed);
        Iterate { u: &self.0.u, q: &self.0.q }
    }
}

/// Steps and the trial of constant labels are on the clock; evaluations and certificates are not. The time limit counts
/// everything.
#[test]
fn only_work_is_on_the_clock() {
    let mesh = bumpy(6);
    let f = random_problem::<3>(&mesh, 1e3, 113).f;
    let problem = Problem::new(Slow(Stencil::new(&mesh)), f, 1e3);
    let mut solver = Slow(Script::new(&mesh, &[[0.2, 0.3, 0.5]]));
    let started = || {
        let mut run = Run::new(&uniform(&mesh));
        run.now = now;
        run
    };
    let mut run = started();
    run.keep_dual();
    run.charge(Duration::from_secs(7));
    COLUMN_READS.store(0, Relaxed);
    let status =
        run.advance(&mut solver, &problem, &every(10, STEPS_BEFORE_CONSTANT + 10), &mut go);
    assert_eq!(
        (status, run.trace.len() as u64),
        (Status::IterationLimit, STEPS_BEFORE_CONSTANT / 10 + 2)
    );
    // Only the trial of constant labels reads columns.
    let columns = COLUMN_READS.load(Relaxed);
    assert!(columns >= mesh.faces.len() as u64);
    let seconds: Vec<f64> = run.trace.iter().map(|sample| sample.seconds).collect();
    assert_eq!(seconds[..3], [7.0, 10_007.0, 20_007.0]);
    assert_eq!(
        run.clock,
        Duration::from_secs(7 + STEP_SECONDS * (STEPS_BEFORE_CONSTANT + 10) + columns)
    );
    assert_eq!(run.seconds(), *seconds.last().unwrap());

    let mut run = started();
    let stop = Stop { time: Some(Duration::from_secs(EVALUATION_SECONDS)), ..every(10, 50) };
    let status = run.advance(&mut solver, &problem, &stop, &mut go);
    assert_eq!((status, run.iterations()), (Status::TimeLimit, 1));
    assert_eq!(run.clock, Duration::from_secs(STEP_SECONDS));
}
