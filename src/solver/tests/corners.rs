//! Corner cases: no total variation, dominant total variation, isolated vertices, padding regions, NaN, invalid
//! settings.

use std::collections::BTreeSet;
use std::ops::ControlFlow;

use super::{all_variants, exact, run, solver, uniform, variants};
use crate::field::Row;
use crate::operator::Stencil;
use crate::problem::{Problem, rounded};
use crate::regions::pad_costs;
use crate::run::{Run, Status, Stop};
use crate::samples::{bumpy, disjoint, random_problem, shape, with_isolated_vertices};
use crate::solver::{
    Method, Options, Setup, chambolle_pock, douglas_rachford, fista, projected_gradient,
};

/// With lambda = 0 every vertex takes argmin f, and the gap is exactly zero.
#[test]
fn without_total_variation_the_cheapest_region_wins() {
    for mesh in [bumpy(7), bumpy(7).scaled(1e-4), bumpy(7).scaled(1e4)] {
        let problem = random_problem::<4>(&mesh, 0.0, 91);
        let cheapest: Vec<Row<4>> = problem.f.iter().map(|f| Row::one_hot(f.argmin())).collect();
        for variant in variants() {
            let mut solver = solver(variant, &mesh, &problem, uniform(mesh.vertices.len(), 4));
            let (run, status) = run(&mut *solver, &problem, 0.0, 2_000);
            assert_eq!(status, Status::Converged, "{variant:?}: {:?}", run.trace.last());
            assert_eq!(run.best_u(), cheapest, "{variant:?}");
            assert_eq!(run.energy(), run.bound(), "{variant:?}");
        }
    }
}

/// A large lambda allows no cut: the best constant wins, on each component separately.
#[test]
fn a_large_lambda_gives_constants() {
    let mesh = disjoint([shape("sphere:1"), shape("grid:5x5"), bumpy(4).scaled(0.1)]);
    let problem = random_problem::<3>(&mesh, 100.0 * mesh.area().sqrt(), 92);
    let components = [0..42, 42..78, 78..103];
    let best: f64 = components
        .iter()
        .map(|component| {
            let sum = problem.f[component.clone()].iter().fold(Row::ZERO, |sum, &f| sum + f);
            sum.min()
        })
        .sum();
    for variant in exact() {
        let mut solver = solver(variant, &mesh, &problem, uniform(mesh.vertices.len(), 3));
        let (run, status) = run(&mut *solver, &problem, 1e-6, 100_000);
        assert_eq!(status, Status::Converged, "{variant:?}: {:?}", run.trace.last());
        assert!((run.energy() - best).abs() <= 2e-6 * best.abs(), "{variant:?}");
        let labels = rounded(run.best_u());
        for component in &components {
            assert!(labels[component.clone()].windows(2).all(|pair| pair[0] == pair[1]));
        }
    }
}

/// Vertices without faces do not affect other rows of U, and their own rows stay in the simplex.
#[test]
fn isolated_vertices_do_not_affect_others() {
    let bare = bumpy(6);
    let mesh = with_isolated_vertices(bare.clone());
    let problem = random_problem::<3>(&bare, 0.05, 93);
    let mut f = problem.f.clone();
    f.insert(0, Row::ZERO);
    f.push(Row::ZERO);
    let padded = Problem::new(Stencil::new(&mesh), f, problem.lambda);
    for variant in all_variants() {
        let mut alone = solver(variant, &bare, &problem, uniform(bare.vertices.len(), 3));
        let mut among = solver(variant, &mesh, &padded, uniform(mesh.vertices.len(), 3));
        let (expected, _) = run(&mut *alone, &problem, 0.0, 100);
        let (run, _) = run(&mut *among, &padded, 0.0, 100);
        assert!(run.best_u().iter().all(|u| (u.0.iter().sum::<f64>() - 1.0).abs() < 1e-12));
        let size = problem.spread();
        assert!((run.energy() - expected.energy()).abs() <= 1e-9 * size, "{variant:?}");
        assert!((run.bound() - expected.bound()).abs() <= 1e-9 * size, "{variant:?}");
    }
}

/// Padding regions never receive mass, not even at intermediate iterates.
#[test]
fn padding_regions_stay_empty() {
    let mesh = bumpy(6).scaled(1e-4);
    let mut problem = random_problem::<12>(&mesh, 0.02 * mesh.area().sqrt(), 94);
    pad_costs(9, &mut problem.f);
    for variant in all_variants() {
        let mut solver = solver(variant, &mesh, &problem, uniform(mesh.vertices.len(), 9));
        for n in 1..=30 {
            solver.advance(&problem, 1 + n % 4, &mut || true);
            let iterate = solver.iterate();
            let empty = iterate.u.iter().all(|u| u.0[9..].iter().all(|&x| x == 0.0));
            assert!(empty, "{variant:?}, {n}");
            let zero =
                iterate.q.iter().flat_map(|q| q.0).all(|q| q.0[9..].iter().all(|&x| x == 0.0));
            assert!(zero, "{variant:?}, {n}");
        }
        let energy = problem.energy(solver.iterate().u);
        assert!(energy.abs() < 1.0 && problem.dual_bound(solver.iterate().q) <= energy);
    }
}

/// NaN in the costs ends a run as diverged, and the best U so far is kept.
#[test]
fn nan_in_the_costs_ends_the_run() {
    let mesh = bumpy(6);
    for variant in all_variants() {
        let mut problem = random_problem::<3>(&mesh, 0.05, 95);
        let mut solver = solver(variant, &mesh, &problem, uniform(mesh.vertices.len(), 3));
        let mut run = Run::new(solver.iterate().u);
        let stop = Stop { iterations: Some(40), ..Stop::default() };
        let go = &mut |_: Option<&_>| ControlFlow::Continue(());
        let status = run.advance(&mut *solver, &problem, &stop, go);
        assert!(matches!(status, Status::IterationLimit | Status::Settled), "{variant:?}");
        let (energy, u) = (run.energy(), run.best_u().to_vec());
        problem.f[11].0[1] = f64::NAN;
        assert_eq!(run.advance(&mut *solver, &problem, &stop, go), Status::Diverged, "{variant:?}");
        assert_eq!((run.energy(), run.best_u()), (energy, &u[..]), "{variant:?}");
    }
}

/// With NaN in the costs from the start, no sample is valid, and the run returns its start.
#[test]
fn a_run_with_nan_from_the_start_returns_its_start() {
    let mesh = bumpy(4);
    let mut problem = random_problem::<3>(&mesh, 0.05, 96);
    problem.f[2].0[0] = f64::NAN;
    let start = uniform::<3>(mesh.vertices.len(), 3);
    for variant in variants() {
        let mut solver = solver(variant, &mesh, &problem, start.clone());
        let (run, status) = run(&mut *solver, &problem, 1e-3, 100);
        assert_eq!((status, run.iterations()), (Status::Diverged, 0), "{variant:?}");
        assert_eq!(run.best_u(), start);
    }
}

/// With a step far beyond 2/L, whatever happens, the bound stays below the energy and neither is NaN.
#[test]
fn too_long_steps_keep_bounds_valid() {
    let mesh = bumpy(6);
    let problem = random_problem::<3>(&mesh, 0.05, 97);
    for tau in ["tau=1e6", "tau=1e200"] {
        let options: &[&str] = &[tau];
        let mut solver = solver(
            ("projected-gradient", options),
            &mesh,
            &problem,
            uniform(mesh.vertices.len(), 3),
        );
        let (run, status) = run(&mut *solver, &problem, 1e-9, 200);
        assert!(matches!(status, Status::IterationLimit | Status::Diverged));
        assert!(run.bound() <= run.energy());
    }
}

#[test]
fn unknown_names_keys_and_values_are_refused() {
    let refusal = |name: &str, option: &str| {
        let options = Options::parse(&[option]).unwrap();
        Method::parse(name, &options).unwrap_err().to_string()
    };
    for method in Method::all() {
        let name = method.name();
        assert_eq!(Method::named(name).unwrap(), method);
        let keys: Vec<&str> = method.clone().settings().iter().map(|setting| setting.key).collect();
        let message = refusal(name, "no-such-key=1");
        assert!(message.contains("no-such-key") && !message.contains('\n'), "{message}");
        assert!(keys.iter().all(|key| message.contains(key)), "{message}");
        for key in keys {
            for value in ["", "nonsense", "nan", "-1"] {
                let message = refusal(name, &format!("{key}={value}"));
                assert!(message.contains(key) && !message.contains('\n'), "{message}");
            }
        }
    }
    let message = refusal("simplex", "rho=1");
    assert!(Method::all().iter().all(|m| message.contains(m.name())) && !message.contains('\n'));
}

/// Typed settings can hold any number, but no solver is built from one that is out of range.
#[test]
fn settings_out_of_range_are_refused() {
    let mesh = bumpy(3);
    let problem = random_problem::<3>(&mesh, 0.05, 98);
    let wrong: [(Method, &str); 4] = [
        (chambolle_pock::Settings { rho: 2.0, ..Default::default() }.into(), "rho=2"),
        (douglas_rachford::Settings { reach: Some(-1.0), ..Default::default() }.into(), "reach=-1"),
        (fista::Settings { continuation: 0.5, ..Default::default() }.into(), "continuation=0.5"),
        (
            projected_gradient::Settings { tau: Some(f64::NAN), ..Default::default() }.into(),
            "tau=NaN",
        ),
    ];
    for (method, setting) in wrong {
        let start = uniform(mesh.vertices.len(), 3);
        let setup = Setup { domain: (&mesh).into(), problem: &problem, start, dual_start: None };
        let message = method.build(setup).err().expect("it is refused").to_string();
        assert!(message.contains(setting) && message.contains("must be a number"), "{message}");
    }
}

/// Settings of all kinds survive a round trip through text, and exactly those that differ from the defaults are
/// reported as changed.
#[test]
fn settings_survive_a_round_trip_through_text() {
    for mut method in Method::all() {
        assert!(method.changed().is_empty());
        let texts: Vec<String> = (method.settings().iter())
            .map(|setting| match setting.values().as_str() {
                "NUMBER" => format!("{}=1.25", setting.key),
                names => format!("{}={}", setting.key, names.split('|').next_back().unwrap()),
            })
            .filter(|text| text != "ratio=1.25")
            .collect();
        let changed = Method::parse(method.name(), &Options::parse(&texts).unwrap()).unwrap();
        let reported: Vec<String> =
            changed.changed().iter().map(|(key, value)| format!("{key}={value}")).collect();
        let again = Method::parse(method.name(), &Options::parse(&reported).unwrap()).unwrap();
        assert_eq!(changed, again);
        assert_eq!(BTreeSet::from_iter(reported), BTreeSet::from_iter(texts));
    }
}

#[test]
fn options_are_pairs_with_unique_keys() {
    for texts in [&["rho"][..], &["rho=1", "rho=1.5"]] {
        let message = Options::parse(texts).unwrap_err().to_string();
        assert!(message.contains("rho") && !message.contains('\n'), "{message}");
    }
    let options = Options::parse(&[" rho = 1.25 "]).unwrap();
    let method = Method::parse("chambolle-pock", &options).unwrap();
    let expected = chambolle_pock::Settings { rho: 1.25, ..Default::default() };
    assert_eq!(method, expected.into());
    let message = Method::parse("chambolle-pock", &Options::parse(&["rho=2"]).unwrap());
    let message = message.unwrap_err().to_string();
    assert_eq!(message, "solver option rho=2: must be a number above 0 and below 2");
}
