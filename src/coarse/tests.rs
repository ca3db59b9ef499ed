//! Coarse to fine: prolonged pairs are feasible and allowed, the same optimum is certified in fewer steps, and limits
//! hold.

use std::borrow::Cow;
use std::ops::ControlFlow;

use ndarray::Array2;
use rand::RngExt;

use super::*;
use crate::mesh::geometry::barycentric_areas;
use crate::mesh::order::Order;
use crate::operator::Mass;
use crate::problem::FORBIDDEN_COST;
use crate::regions;
use crate::run::FIRST_INTERVAL;
use crate::samples::{
    bumpy, disjoint, flipped, known_optimum, needles, random_problem, random_rows, rng, shape,
    soup, with_isolated_vertices, zoo,
};
use crate::solve::{Solution, solve};
use crate::solver::fista;
use crate::start::Start;
use crate::sweep::with_threads;

fn request(lambda: f64, gap: f64, method: Method) -> Request {
    Request {
        lambda,
        relaxation: Default::default(),
        mass: Mass::Barycentric,
        method,
        stop: Stop { relative_gap: Some(gap), iterations: Some(20_000), ..Stop::default() },
        coarse_to_fine: true,
        keep_dual: false,
        rounding: Default::default(),
        label_gap: None,
    }
}

fn go(_: Option<&crate::run::Sample>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn solved(mesh: &Mesh, s: &Array2<f64>, request: &Request) -> Solution {
    solve(mesh, s, &Start::Argmin, request, &mut go).unwrap()
}

/// Meshes with a hierarchy, from good to terrible.
fn large() -> Vec<(&'static str, Mesh)> {
    let sphere = shape("sphere:4");
    let parts = [shape("sphere:3"), shape("grid:30x20").scaled(0.1), shape("torus:40x20")];
    vec![
        ("sphere", sphere.clone()),
        ("grid", shape("grid:50x40")),
        ("bumpy", bumpy(40)),
        ("components", disjoint(parts)),
        ("flipped", flipped(sphere.clone())),
        ("needles", needles(30, 1e-6)),
        ("small", bumpy(40).scaled(1e-4)),
        ("large", sphere.clone().scaled(1e4)),
        ("soup", soup(1200, 6000, 21)),
        ("isolated", with_isolated_vertices(sphere)),
    ]
}

/// A label that only some of the finer vertices forbid is expensive, not forbidden, at a coarse vertex; one that all of
/// them forbid stays forbidden. Prolonged labels are allowed everywhere.
#[test]
fn forbidden_labels_stay_forbidden() {
    let mesh = shape("torus:60x40");
    let n = mesh.vertices.len();
    let mut rng = rng(40);
    let mut s = Array2::from_shape_fn((n, 3), |_| rng.random_range(0.0..1.0));
    for v in 0..n {
        let x = mesh.vertices[v].x;
        if x > 0.0 {
            s[[v, 0]] = f64::INFINITY;
        } else if v % 7 == 0 {
            s[[v, 1]] = f64::INFINITY;
        }
    }
    for method in Method::all() {
        for coarse_to_fine in [true, false] {
            let request = Request { coarse_to_fine, ..request(0.01, 1e-3, method.clone()) };
            let solution = solved(&mesh, &s, &request);
            for ((v, p), &cost) in s.indexed_iter() {
                assert!(cost < f64::INFINITY || solution.u[[v, p]] == 0.0, "{}", method.name());
            }
            // From the start on.
            assert!(solution.trace.iter().all(|sample| sample.energy.abs() < 1e3));
            let summary = solution.summary;
            assert!(summary.energy.abs() < 1e3 && summary.gap >= 0.0, "{}", method.name());
            // The bound of alpha-expansion is B.
            let has_bound = method.name() != "alpha-expansion";
            let gap = if has_bound { 0.1 } else { 1.0 };
            assert!(summary.relative_gap <= gap, "{}: {}", method.name(), summary.relative_gap);
        }
    }
}

#[test]
fn only_large_meshes_have_levels() {
    assert!(zoo().iter().all(|(_, mesh)| Hierarchy::new(mesh).levels.is_empty()));
    let dust = disjoint((0..800).map(|_| shape("grid:1x1")));
    let levels = Hierarchy::new(&dust).levels;
    assert!(levels.iter().all(|level| !level.mesh.faces.is_empty()));
    for (name, mesh) in large() {
        let levels = Hierarchy::new(&mesh).levels;
        assert!(!levels.is_empty(), "{name}");
        let mut before = mesh.vertices.len();
        for level in levels {
            assert!(level.mesh.vertices.len() as f64 <= MAX_KEPT_SHARE * before as f64, "{name}");
            before = level.mesh.vertices.len();
        }
    }
}

/// On any mesh, as without the hierarchy: D <= E* <= E, and the gap is reached.
#[test]
fn the_known_optimum_is_certified() {
    for (name, mesh) in large() {
        let areas =
            Array2::from_shape_vec((mesh.vertices.len(), 1), barycentric_areas(&mesh)).unwrap();
        // Vertices without area have no pointwise costs that give f.
        if areas.iter().any(|&a| a == 0.0) {
            continue;
        }
        let lambda = 0.05 * mesh.area().sqrt();
        let known = known_optimum::<3>(&mesh, 3, lambda, 1.0, 34);
        let s = regions::array(&known.problem.f, 3) / &areas;
        let solution = solved(&mesh, &s, &request(lambda, 1e-4, Method::default()));
        let summary = &solution.summary;
        let slack = 1e-12 * known.problem.spread();
        assert_eq!(summary.status, Status::Converged, "{name}: {summary:?}");
        assert!(summary.dual_bound <= known.energy + slack, "{name}: {summary:?}");
        assert!(summary.energy >= known.energy - slack, "{name}: {summary:?}");
        let record = summary.coarse_to_fine.as_ref().unwrap();
        let ordered = Order::of(&mesh).mesh(Cow::Borrowed(&mesh));
        assert_eq!(record.levels.len(), Hierarchy::new(&ordered).levels.len(), "{name}");
        let spent = record.spent.as_secs_f64();
        assert!(0.0 < spent && spent <= solution.trace[0].seconds);
    }
}

/// With random costs, every solver on every mesh gets bounds that are consistent with those without the hierarchy.
#[test]
fn every_solver_can_start_from_coarser_levels() {
    for (name, mesh) in large() {
        let rows = random_rows::<3>(mesh.vertices.len(), &mut rng(35));
        let s = regions::array(&rows, 3);
        for method in Method::all() {
            let with = Request {
                stop: Stop { iterations: Some(40), ..Stop::default() },
                ..request(0.02 * mesh.area().sqrt(), 0.0, method.clone())
            };
            let without = Request { coarse_to_fine: false, ..with.clone() };
            let [with, without] = [with, without].map(|request| solved(&mesh, &s, &request));
            let slack = 1e-12 * without.summary.energy.abs();
            let (with, without) = (with.summary, without.summary);
            assert!(with.dual_bound <= without.energy + slack, "{name}, {}", method.name());
            assert!(without.dual_bound <= with.energy + slack, "{name}, {}", method.name());
            assert!(with.coarse_to_fine.is_some() && without.coarse_to_fine.is_none());
        }
    }
}

/// Noisy stripes that are smoothed over many faces take at most half of the iterations.
#[test]
fn the_hierarchy_saves_iterations() {
    let mesh = shape("torus:160x100");
    let mut rng = rng(39);
    let stripes = |v: usize| f64::from((30.0 * mesh.vertices[v].x).sin() > 0.0);
    let color: Vec<f64> =
        (0..mesh.vertices.len()).map(|v| stripes(v) + rng.random_range(-1.0..1.0)).collect();
    let s = Array2::from_shape_fn((color.len(), 2), |(v, p)| (color[v] - p as f64).powi(2));
    let with = request(0.02, 2.5e-2, Method::default());
    let without = Request { coarse_to_fine: false, ..with.clone() };
    let [with, without] =
        [with, without].map(|request| solved(&mesh, &s, &request).summary.iterations);
    assert!(2 * with <= without, "{with} {without}");
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let mesh = shape("torus:90x60");
    let problem = random_problem::<4>(&mesh, 0.02, 36);
    let bits = |threads| {
        with_threads(Some(threads), || {
            let request = request(problem.lambda, 1e-4, Method::default());
            let pair = start(&mesh, &problem, &request, &mut go).unwrap().pair.unwrap();
            let rows = pair.q.iter().flat_map(|q| q.0).chain(pair.u);
            rows.flat_map(|row| row.0.map(f64::to_bits)).collect::<Vec<_>>()
        })
        .unwrap()
    };
    assert!(bits(1) == bits(3));
}

/// The time limit and the observer end the coarse levels, too.
#[test]
fn coarse_levels_end_at_the_time_limit_and_when_interrupted() {
    let mesh = shape("torus:90x60");
    let problem = random_problem::<3>(&mesh, 0.02, 37);
    let mut request = request(problem.lambda, 0.0, Method::default());
    let most = |record: Record| record.levels.iter().map(|level| level.iterations).max().unwrap();
    let interrupted = start(&mesh, &problem, &request, &mut |_| ControlFlow::Break(())).unwrap();
    assert!(interrupted.pair.is_some() && most(interrupted.record) <= FIRST_INTERVAL);
    request.stop.time = Some(Duration::ZERO);
    let late = start(&mesh, &problem, &request, &mut go).unwrap();
    assert!(late.pair.is_some() && most(late.record) <= 1);
}

/// The time of the coarse levels counts towards the time limit, and a diverged level is not used as a start.
#[test]
fn the_finest_level_has_the_remaining_time() {
    let mut request = request(0.02, 0.0, Method::default());
    request.stop.time = Some(Duration::from_secs(3));
    assert_eq!(level_stop(&request, Duration::from_secs(1)).time, Some(Duration::from_secs(2)));
    assert_eq!(level_stop(&request, Duration::from_secs(4)).time, Some(Duration::ZERO));
    let mesh = shape("torus:120x80");
    let s = regions::array(&random_rows::<3>(mesh.vertices.len(), &mut rng(43)), 3);
    request.stop.time = Some(Duration::from_millis(1));
    let summary = solved(&mesh, &s, &request).summary;
    assert!(summary.iterations <= 1 && summary.status == Status::TimeLimit, "{summary:?}");
    let spent = summary.coarse_to_fine.unwrap().spent;
    assert!(spent >= Duration::from_millis(1) && summary.seconds >= spent.as_secs_f64());
    let (u, q) = (vec![Row([1.0, 0.0])], vec![Tangent::ZERO]);
    let level = |status| final_pair(Iterate { u: &u, q: &q }, status).is_some();
    assert!(level(Status::IterationLimit) && !level(Status::Diverged));
}

/// For lambda = 0 the cheapest labels are certified at once, without levels.
#[test]
fn no_levels_are_solved_for_zero_lambda() {
    let mesh = shape("torus:60x40");
    let s = regions::array(&random_rows::<3>(mesh.vertices.len(), &mut rng(38)), 3);
    let summary = solved(&mesh, &s, &request(0.0, 1e-4, Method::default())).summary;
    assert!(summary.coarse_to_fine.is_none() && summary.iterations == 0);
    assert_eq!(summary.energy, summary.dual_bound);
}

/// Up to noise, labels 1 and 2 are the cheapest on two caps of the unit sphere, the second of them smaller, and label 0
/// is the cheapest elsewhere.
fn caps(noise: f64) -> (Mesh, Array2<f64>) {
    let mesh = shape("sphere:4");
    let mut rng = rng(44);
    let cheapest = |z: f64| {
        if z > 0.8 {
            1
        } else if z < -0.95 {
            2
        } else {
            0
        }
    };
    let s = Array2::from_shape_fn((mesh.vertices.len(), 3), |(v, p)| {
        let cost = f64::from(u8::from(cheapest(mesh.vertices[v].z) != p));
        cost + noise * rng.random_range(-1.0..1.0)
    });
    (mesh, s)
}

/// The lambda that keeps two regions is the smaller one of those that keep each of them.
#[test]
fn every_wanted_region_is_kept() {
    let (mesh, s) = caps(0.0);
    let request = request(2.0, 1e-3, Method::default());
    let problem = crate::solve::problem_of::<3>(&mesh, 3, regions::rows(s.view()), &request);
    let problem = problem.unwrap();
    let keeping = |wanted: &[usize]| {
        separating_lambda(&mesh, &problem, wanted, &request, &mut go).unwrap().unwrap()
    };
    let (large, small) = (keeping(&[1]), keeping(&[2]));
    assert!(small < large && large < 1.0, "{small} {large}");
    assert_eq!(keeping(&[1, 2]), small);
    assert_eq!(keeping(&[2, 1]), small);
    // The lambda of the request is halved at least once.
    assert_eq!((2.0 / large).log2().fract(), 0.0);
    assert_eq!(keeping(&[0]), 1.0);
}

/// A trial takes the steps of a solve with that lambda to the requested gap, clamped to [`LEVEL_GAPS`].
#[test]
fn a_trial_is_solved_to_the_requested_gap() {
    let (mesh, s) = caps(1.0);
    let each_step = |request: Request| {
        let stop = Stop { interval: Some(1), ..request.stop };
        Request { stop, ..request }
    };
    let taken = |gap: f64| {
        let request = each_step(request(0.1, gap, Method::default()));
        let problem = crate::solve::problem_of::<3>(&mesh, 3, regions::rows(s.view()), &request);
        let mut samples = 0;
        let mut count = |sample: Option<&crate::run::Sample>| {
            assert!(sample.is_none());
            samples += 1;
            ControlFlow::Continue(())
        };
        let found =
            separating_lambda(&mesh, &problem.unwrap(), &[1], &request, &mut count).unwrap();
        assert_eq!(found, Some(0.05));
        // The observer is not called with the sample that reaches the gap.
        samples + 1
    };
    let solving = |gap: f64| {
        let request = each_step(request(0.05, gap, Method::default()));
        solved(&mesh, &s, &Request { coarse_to_fine: false, ..request }).summary.iterations
    };
    assert_eq!(taken(1e-3), solving(1e-3));
    assert_eq!(taken(1e-6), solving(LEVEL_GAPS[0]));
    assert_eq!(taken(1.0), solving(LEVEL_GAPS[1]));
    assert!(solving(LEVEL_GAPS[1]) < solving(1e-3) && solving(1e-3) < solving(LEVEL_GAPS[0]));
}

/// A trial that ends at the time limit keeps no region for certain, and an interrupted search returns no lambda.
#[test]
fn only_converged_trials_count() {
    let (mesh, s) = caps(1.0);
    let mut request = request(0.1, 1e-3, Method::default());
    let problem = crate::solve::problem_of::<3>(&mesh, 3, regions::rows(s.view()), &request);
    let problem = problem.unwrap();
    let mut steps = 0;
    let mut interrupted = |_: Option<&_>| {
        steps += 1;
        ControlFlow::Break(())
    };
    assert_eq!(separating_lambda(&mesh, &problem, &[1], &request, &mut interrupted).unwrap(), None);
    assert!(steps <= 2, "{steps}");
    assert_eq!(separating_lambda(&mesh, &problem, &[1], &request, &mut go).unwrap(), Some(0.05));
    request.stop.time = Some(Duration::ZERO);
    // Trials that converge in a single step still count.
    let hurried = separating_lambda(&mesh, &problem, &[1], &request, &mut go).unwrap();
    assert!(hurried.is_none_or(|lambda| lambda < 0.05), "{hurried:?}");
}

/// A level is solved to ten times the gap, clamped to [`LEVEL_GAPS`], and in at most [`MAX_LEVEL_STEPS`] steps.
#[test]
fn levels_stop_early() {
    let gap = |requested: Option<f64>| {
        let mut request = request(0.02, 0.0, Method::default());
        request.stop = Stop { relative_gap: requested, change: Some(1.0), ..request.stop };
        let stop = level_stop(&request, Duration::ZERO);
        assert_eq!(
            (stop.iterations, stop.change, stop.interval),
            (Some(MAX_LEVEL_STEPS), None, None)
        );
        stop.relative_gap.unwrap()
    };
    assert_eq!(gap(Some(1e-4)), 10.0 * 1e-4);
    assert_eq!([gap(None), gap(Some(0.0)), gap(Some(1e-6))], [LEVEL_GAPS[0]; 3]);
    assert_eq!(gap(Some(1e-2)), LEVEL_GAPS[1]);
}

/// Each level starts with the prolonged labels and field of the coarser one, without forbidden labels; the observer
/// gets no samples.
#[test]
fn a_level_starts_where_the_coarser_one_ends() {
    let mesh = shape("torus:120x80");
    let mut problem = random_problem::<3>(&mesh, 0.02, 45);
    let mut f = problem.f.clone();
    f.iter_mut().zip(&mesh.vertices).for_each(|(f, x)| {
        if x.x > 0.0 {
            f.0[1] = FORBIDDEN_COST;
        }
    });
    problem.set_costs(f);
    let request = request(problem.lambda, 1e-4, Method::default());
    let mut calls = 0;
    let mut observe = |sample: Option<&crate::run::Sample>| {
        calls += 1;
        assert!(sample.is_none());
        ControlFlow::Break(())
    };
    let CoarseStart { pair, record } = start(&mesh, &problem, &request, &mut observe).unwrap();
    assert!(
        record.levels.len() >= 2
            && record.levels.iter().all(|level| level.iterations == FIRST_INTERVAL)
    );
    assert_eq!(calls, record.levels.len());

    let hierarchy = Hierarchy::new(&mesh);
    let mut costs = vec![problem.f.clone()];
    for level in &hierarchy.levels {
        costs.push(restrict(level, costs.last().unwrap()));
    }
    let mut forbidden = 0;
    let mut allowed_only = |mut u: Vec<Row<3>>, f: &[Row<3>]| {
        let given = u.clone();
        remove_forbidden(&mut u, f);
        forbidden += u32::from(u != given);
        u
    };
    let expected = hierarchy.climb((problem.lambda, problem.relaxation), |l, pair| {
        let mesh = &hierarchy.levels[l].mesh;
        let problem = Problem::new(Stencil::new(mesh), costs[l + 1].clone(), problem.lambda);
        let (start, dual_start) = match pair {
            Some(Pair { u, q }) => (allowed_only(u, &problem.f), Some(q)),
            None => (cheapest_labels(&problem.f), None),
        };
        let setup = Setup { domain: mesh.into(), problem: &problem, start, dual_start };
        let mut solver = Method::default().build(setup)?;
        solver.advance(&problem, FIRST_INTERVAL, &mut || true);
        Ok(final_pair(solver.iterate(), Status::Interrupted))
    });
    let (found, expected) = (pair.unwrap(), expected.unwrap().unwrap());
    assert!(found.u == allowed_only(expected.u, &problem.f) && found.q == expected.q);
    // Forbidden labels are removed on coarse levels as well as on the finest.
    assert!(forbidden >= 2, "{forbidden}");
}

/// A level without a result ends the climb.
#[test]
fn a_level_without_a_result_ends_the_climb() {
    let mesh = shape("torus:120x80");
    let hierarchy = Hierarchy::new(&mesh);
    assert!(hierarchy.levels.len() >= 2);
    let mut calls = Vec::new();
    let result = hierarchy.climb::<2>((1.0, Relaxation::Frobenius), |l, pair| {
        calls.push(l);
        assert!(pair.is_none());
        Ok(None)
    });
    assert!(result.unwrap().is_none());
    assert_eq!(calls, [hierarchy.levels.len() - 1]);
}

/// Coarsening ends at the given number of vertices, or where most vertices would stay.
#[test]
fn a_hierarchy_ends_at_the_given_size_or_where_most_vertices_stay() {
    let mesh = shape("torus:60x40");
    let levels = |vertices| Hierarchy::down_to(&mesh, vertices).levels.len();
    assert_eq!((levels(2400), levels(2399)), (0, 1));
    let mut dotted = mesh.clone();
    dotted.vertices.extend([mesh.vertices[0]; 2400]);
    assert!(dotted.coarsened().mesh.vertices.len() as f64 <= MAX_KEPT_SHARE * 4800.0);
    assert_eq!(Hierarchy::new(&dotted).levels.len(), 1);
    dotted.vertices.extend([mesh.vertices[0]; 2400]);
    assert!(Hierarchy::new(&dotted).levels.is_empty());
}

/// Trials use the default solver, whatever the requested solver and its settings are.
#[test]
fn trials_do_not_depend_on_the_requested_solver() {
    let (mesh, s) = caps(0.0);
    let default = request(2.0, 1e-3, Method::default());
    let settings = fista::Settings { epsilon: Some(0.01), ..Default::default() };
    let smoothed = request(2.0, 1e-3, settings.into());
    smoothed.check().unwrap();
    let problem =
        crate::solve::problem_of::<3>(&mesh, 3, regions::rows(s.view()), &default).unwrap();
    let keeping = |request| separating_lambda(&mesh, &problem, &[1], request, &mut go).unwrap();
    assert!(keeping(&default).is_some());
    assert_eq!(keeping(&smoothed), keeping(&default));
}
