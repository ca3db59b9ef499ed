//! The loop: what it records, when it stops, and that it can be resumed.

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
    let setup = Setup { mesh, problem, start: uniform(mesh), dual_start: None };
    Method::named(name).unwrap().build(setup).unwrap()
}

fn every(interval: u64, iterations: u64) -> Stop {
    Stop { interval: Some(interval), iterations: Some(iterations), ..Stop::default() }
}

const NAMES: [&str; 4] = ["chambolle-pock", "douglas-rachford", "fista", "projected-gradient"];

#[test]
fn ten_and_ten_are_twenty() {
    let mesh = bumpy(7);
    let problem = random_problem::<3>(&mesh, 0.05, 101);
    for name in NAMES {
        let through = |parts: &[u64]| {
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
        assert_eq!(through(&[20]), through(&[10, 10]), "{name}");
        assert_eq!(through(&[20]).0.iter().map(|s| s.0).collect::<Vec<_>>(), [0, 5, 10, 15, 20]);
    }
}

#[test]
fn the_first_sample_is_the_start() {
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

/// Between the samples the intervals grow; the last iteration is sampled in any case.
#[test]
fn samples_thin_out() {
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

/// On the way to a gap samples are as far apart as the gap needs, but not much farther than a fifth of the way.
#[test]
fn samples_are_where_the_gap_is_expected() {
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
    let (every, some) = (solve(Some(4)), solve(None));
    assert!(every.iterations() > 100, "{}", every.iterations());
    assert!(some.trace.len() < every.trace.len() / 2, "{}", some.trace.len());
    assert!(some.iterations() <= every.iterations() * 5 / 4, "{}", some.iterations());
    let far = |pair: &[Sample]| {
        pair[1].iteration - pair[0].iteration <= (2 * FIRST_INTERVAL).max(pair[0].iteration / 4)
    };
    assert!(some.trace.windows(2).all(far));
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

/// A solver by script: the rows of step n are `rows[n]`, its dual field zero.
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
fn the_change_is_the_largest_of_all_entries() {
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

/// The best U is kept when the iterates become worse, and the sample says the best.
#[test]
fn an_interrupt_keeps_the_best() {
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

/// Broken off between two passes of eight steps, a run makes one step more: an over-relaxed iterate is no answer.
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
    // Before each pass but the first, and with each sample: 8, 16, 24, [25], 33, 41.
    assert_eq!((status, run.iterations()), (Status::Interrupted, 42));
    assert_eq!(run.trace.last().unwrap().iteration, 42);
    assert!(solver.iterate().u.iter().all(|u| u.min() >= 0.0));
}

#[test]
fn each_bound_stops_by_itself() {
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
    // At the first gap that is no larger, and at none before.
    let to = |gap| end(Stop { relative_gap: Some(gap), interval: Some(4), ..Stop::default() });
    let (_, run) = to(1e-3);
    let gap = run.trace[run.trace.len() - 2].relative_gap;
    let (status, run) = to(gap);
    assert_eq!((status, run.trace.last().unwrap().relative_gap), (Status::Converged, gap));
    assert!(to(0.99 * gap).1.iterations() > run.iterations());
    // The start may be good enough.
    let (status, run) = end(Stop { relative_gap: Some(1e9), ..Stop::default() });
    assert_eq!((status, run.iterations()), (Status::Converged, 0));
}

/// What was seen of other costs counts no more, neither the energy nor the bound: for these costs any of the former
/// bounds would be false. The sample of the new ones takes the old one's place.
#[test]
fn forgetting_voids_the_bounds() {
    let mesh = bumpy(6);
    let dear = random_problem::<3>(&mesh, 0.05, 107);
    let cheap = || dear.f.iter().map(|&f| f * 1e-3).collect();
    for name in NAMES {
        let mut problem = Problem::new(Stencil::new(&mesh), dear.f.clone(), dear.lambda);
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
        // The least energy of the new costs lies below the bound of the old ones.
        let least = (0..3).map(|p| problem.energy(&vec![Row::one_hot(p); mesh.vertices.len()]));
        let least = least.fold(f64::INFINITY, f64::min);
        assert!(before > least, "{name}: {before} {least}");
        assert!(run.bound() <= least, "{name}: {} {least}", run.bound());
    }
}

/// The field that is kept has the bound that is stated.
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

/// What a solver never finds: the best constant labels and the field that certifies them; for other costs anew.
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
        let least = constant.map(|u| problem.energy(&u)).fold(f64::INFINITY, f64::min);
        assert_eq!((run.energy(), problem.energy(run.best_u())), (least, least));
        let (q, size) = (run.best_q().unwrap(), problem.spread());
        assert!(q.iter().all(|q| q.norm() <= problem.lambda * (1.0 + 1e-14)));
        assert!((problem.dual_bound(q) - run.bound()).abs() <= 1e-12 * size);
        assert!(least - run.bound() <= 1e-9 * size, "{least} {}", run.bound());
        let turned = |f: &Row<3>| Row([f.0[2], f.0[0], f.0[1]]) * 0.1;
        problem.set_costs(problem.f.iter().map(turned).collect());
        run.forget();
    }
}

/// Labels that are the best constant ones already are certified, too.
#[test]
fn constant_labels_that_were_found_get_their_field() {
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

/// A field of no numbers bounds nothing, and ends the run before any gap does.
#[test]
fn what_is_no_number_ends_a_run() {
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

/// Of foreign bounds the best counts, too; one above the energy is settled where rounding put it there, and else
/// contradicts, however little it is above.
#[test]
fn foreign_bounds_are_kept_settled_or_contradict() {
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
fn time_that_was_spent_is_gone() {
    let seconds = Duration::from_secs;
    let stop = Stop { time: Some(seconds(3)), iterations: Some(7), ..Stop::default() };
    assert_eq!(stop.after(seconds(1)).time, Some(seconds(2)));
    assert_eq!(stop.after(seconds(5)).time, Some(Duration::ZERO));
    assert_eq!(
        (stop.after(seconds(5)).iterations, Stop::default().after(seconds(5)).time),
        (Some(7), None)
    );
}

/// A solver whose field leaves the ball claims what is false: that is said, and nothing is certified.
#[test]
fn a_bound_above_an_energy_is_a_contradiction() {
    let mesh = bumpy(6);
    let problem = random_problem::<3>(&mesh, 0.05, 110);
    let mut solver = solver("chambolle-pock", &mesh, &problem);
    let mut run = Run::new(&uniform(&mesh));
    let stop = Stop { relative_gap: Some(1e-6), ..Stop::default() };
    assert_eq!(run.advance(&mut *solver, &problem, &stop, &mut go), Status::Converged);
    // Twice the optimal field is infeasible; the same costs with a lambda of none are bounded by B.
    let wrong = Problem::new(Stencil::new(&mesh), problem.f.clone(), 0.0);
    let argmin: Vec<Row<3>> = problem.f.iter().map(|f| Row::one_hot(f.argmin())).collect();
    let q = solver.iterate().q.to_vec();
    let liar = Script { rows: vec![[1.0, 0.0, 0.0]], step: 0, u: argmin.clone(), q };
    let mut run = Run::new(&argmin);
    let status = run.advance(&mut OneByOne::new(liar), &wrong, &every(1, 5), &mut go);
    assert_eq!(status, Status::Contradicted);
    let last = run.trace.last().unwrap();
    assert!(last.gap < 0.0 && run.is_contradicted(), "{}", last.gap);
}

/// Seconds of a day on which time passes by what is done, in [`only_work_is_on_the_clock`] alone.
static TIME: AtomicU64 = AtomicU64::new(0);
static COLUMNS: AtomicU64 = AtomicU64::new(0);

const STEP: u64 = 1000;
const LOOK: u64 = 1_000_000;

fn now() -> Instant {
    static DAWN: LazyLock<Instant> = LazyLock::new(Instant::now);
    *DAWN + Duration::from_secs(TIME.load(Relaxed))
}

/// An operator of which each look at the columns of a face takes a second, and a solver that stays where it is: a step
/// takes [`STEP`], a look at its iterate [`LOOK`].
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
        COLUMNS.fetch_add(1, Relaxed);
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
        TIME.fetch_add(STEP * made, Relaxed);
        made
    }

    fn change(&mut self) -> f64 {
        0.0
    }

    fn iterate(&mut self) -> Iterate<'_, 3> {
        TIME.fetch_add(LOOK, Relaxed);
        Iterate { u: &self.0.u, q: &self.0.q }
    }
}

/// Steps count, and the labels that are tried for them; what is looked at and certified does not. A limit of time is one
/// of all.
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
    COLUMNS.store(0, Relaxed);
    let status =
        run.advance(&mut solver, &problem, &every(10, STEPS_BEFORE_CONSTANT + 10), &mut go);
    assert_eq!(
        (status, run.trace.len() as u64),
        (Status::IterationLimit, STEPS_BEFORE_CONSTANT / 10 + 2)
    );
    // Nobody but the constant labels asks for columns.
    let columns = COLUMNS.load(Relaxed);
    assert!(columns >= mesh.faces.len() as u64);
    let seconds: Vec<f64> = run.trace.iter().map(|sample| sample.seconds).collect();
    assert_eq!(seconds[..3], [7.0, 10_007.0, 20_007.0]);
    assert_eq!(run.clock, Duration::from_secs(7 + STEP * (STEPS_BEFORE_CONSTANT + 10) + columns));
    assert_eq!(run.seconds(), *seconds.last().unwrap());

    let mut run = started();
    let stop = Stop { time: Some(Duration::from_secs(LOOK)), ..every(10, 50) };
    let status = run.advance(&mut solver, &problem, &stop, &mut go);
    assert_eq!((status, run.iterations()), (Status::TimeLimit, 1));
    assert_eq!(run.clock, Duration::from_secs(STEP));
}
