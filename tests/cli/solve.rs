//! `solve`: costs in any layout, every solver, every start, every stopping rule.

use std::fs;

use ndarray::{Array2, ShapeBuilder};
use ndarray_npy::write_npy;

use crate::support::{Folder, costs, names, stderr};

const TORUS: &str = "torus:40x25";
const V: usize = 1000;

/// A torus and costs of three regions.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.array("S.npy", &costs(V, 3));
    folder
}

const PROBLEM: &str = "torus:40x25 --costs S.npy --lambda 0.02 --no-preview";

#[test]
fn costs_in_any_layout_give_the_same_labels() {
    let folder = folder();
    let exact = costs(V, 3);
    // The same numbers in every type.
    let single = exact.mapv(|x| x as f32);
    let c = single.mapv(f64::from);
    let mut fortran = Array2::<f64>::zeros((V, 3).f());
    fortran.assign(&c);
    write_npy(folder.path("c.npy"), &c).unwrap();
    write_npy(folder.path("fortran.npy"), &fortran).unwrap();
    write_npy(folder.path("single.npy"), &single).unwrap();
    assert_ne!(
        fs::read(folder.path("c.npy")).unwrap(),
        fs::read(folder.path("fortran.npy")).unwrap()
    );
    let [c, fortran, single] = ["c", "fortran", "single"].map(|name| {
        folder.solve(&format!("{TORUS} --costs {name}.npy --lambda 0.02 --no-preview"), name)
    });
    c.assert_consistent();
    assert_eq!((&c.u, &c.labels), (&fortran.u, &fortran.labels));
    assert_eq!((&c.u, &c.labels), (&single.u, &single.labels));
}

#[test]
fn every_mass_gives_a_certified_result() {
    let folder = folder();
    for mass in ["barycentric", "voronoi", "consistent"] {
        let answer = folder.solve(&format!("{PROBLEM} --mass {mass}"), mass);
        answer.assert_consistent();
        answer.assert_monotone_from(0);
        assert_eq!((answer.status(), answer.summary["mass"].as_str()), ("converged", Some(mass)));
    }
}

/// All solvers minimize the same energy: the certified intervals of any two overlap.
#[test]
fn every_solver_with_every_option() {
    let folder = folder();
    let mut best = f64::INFINITY;
    let mut bound = f64::NEG_INFINITY;
    for line in [
        "chambolle-pock",
        "chambolle-pock steps=diagonal rho=1",
        "chambolle-pock steps=plain",
        "chambolle-pock steps=local step-ratio=3",
        "douglas-rachford",
        "douglas-rachford inner=cholesky rho=1",
        "douglas-rachford reach=1 step-ratio=1.5 balance=fixed",
        "fista",
        "fista mass-metric=barycentric epsilon=0.1",
        "fista mass-metric=voronoi epsilon=1e-6 epsilon-mode=paper",
        "fista mass-metric=none restart=never",
        "fista restart=always",
        "fista mass-metric=local continuation=10",
        "projected-gradient",
        "projected-gradient mass-metric=voronoi epsilon=0.1 epsilon-mode=intrinsic",
        "projected-gradient mass-metric=none epsilon-mode=paper",
        "projected-gradient mass-metric=consistent",
        "projected-gradient tau=1e-3",
        "alpha-expansion",
        "alpha-expansion weights=cotangent",
        "alpha-expansion weights=crofton",
    ] {
        let (solver, options) = line.split_once(' ').unwrap_or((line, ""));
        let options: String =
            options.split_whitespace().map(|option| format!(" --solver-option {option}")).collect();
        let answer = folder.solve(
            &format!("{PROBLEM} --solver {solver}{options} --gap 1e-3 --max-iterations 300"),
            "out",
        );
        answer.assert_consistent();
        answer.assert_monotone_from(0);
        assert!(["converged", "iteration-limit", "settled"].contains(&answer.status()), "{line}");
        let smoothed = ["fista", "projected-gradient"].contains(&solver);
        assert_eq!(answer.header.len(), if smoothed { 8 } else { 7 }, "{line}");
        if smoothed {
            assert_eq!(answer.header[7], "smoothed_energy");
            assert!(answer.column("smoothed_energy").iter().all(Option::is_some));
        }
        best = best.min(answer.number("energy"));
        bound = bound.max(answer.number("dual_bound"));
        assert!(bound <= best, "{line}");
    }
}

#[test]
fn every_start() {
    let folder = folder();
    let first = folder.solve(PROBLEM, "first");
    for init in ["uniform", "argmin", "random", "random --seed 5", "first/u.npy"] {
        let answer = folder.solve(&format!("{PROBLEM} --init {init}"), "out");
        answer.assert_consistent();
        assert!(answer.number("energy") <= first.number("energy") * (1.0 + 2e-4), "{init}");
        assert!(answer.number("dual_bound") <= first.number("energy"), "{init}");
    }
    let start = |init: &str| {
        folder.solve(&format!("{PROBLEM} --init {init} --max-iterations 0"), "start").u
    };
    assert_eq!(start("random --seed 3"), start("random --seed 3"));
    assert_ne!(start("random --seed 3"), start("random --seed 4"));
    assert!(start("uniform").iter().all(|&x| (x - 1.0 / 3.0).abs() < 1e-15));
    assert!(start("argmin").iter().all(|&x| x == 0.0 || x == 1.0));
    let given = start("first/u.npy");
    assert!(given.iter().zip(&first.u).all(|(a, b)| (a - b).abs() < 1e-12));
}

/// The levels are reported and their time counts; the result is certified as usual.
#[test]
fn coarse_to_fine() {
    let folder = Folder::new();
    folder.array("S.npy", &costs(4000, 3));
    folder.array("small.npy", &costs(1000, 3));
    for solver in ["chambolle-pock", "fista", "projected-gradient"] {
        let problem = format!(
            "torus:80x50 --costs S.npy --lambda 0.02 --no-preview --solver {solver} --gap 1e-3 --max-iterations 2000"
        );
        let [without, with] =
            ["", "--coarse-to-fine"].map(|flag| folder.solve(&format!("{problem} {flag}"), "out"));
        with.assert_consistent();
        with.assert_monotone_from(0);
        assert!(with.number("dual_bound") <= without.number("energy"), "{solver}");
        assert!(without.number("dual_bound") <= with.number("energy"), "{solver}");
        assert!(without.summary["coarse_to_fine"].is_null());
        let record = &with.summary["coarse_to_fine"];
        let levels = record["levels"].as_array().unwrap();
        assert!(!levels.is_empty());
        for level in levels {
            assert!(level["vertices"].as_u64().unwrap() < 4000 && level["faces"].is_u64());
            assert!(level["iterations"].as_u64().unwrap() > 0);
        }
        let spent = record["seconds"].as_f64().unwrap();
        assert!(0.0 < spent && Some(spent) == with.column("seconds")[0]);
    }
    let small = "torus:40x25 --costs small.npy --lambda 0.02 --no-preview";
    let [without, with] =
        ["", "--coarse-to-fine"].map(|flag| folder.solve(&format!("{small} {flag}"), "out"));
    assert_eq!((without.u, without.labels), (with.u, with.labels));
    assert_eq!(with.summary["coarse_to_fine"]["levels"].as_array().unwrap().len(), 0);
}

#[test]
fn every_way_to_stop() {
    let folder = folder();
    for (stop, status, iterations) in [
        ("--max-iterations 0", "iteration-limit", Some(0)),
        ("--max-iterations 5", "iteration-limit", Some(5)),
        ("--time-limit 0", "time-limit", None),
        ("--gap 0 --max-iterations 50", "iteration-limit", Some(50)),
        ("--gap 0 --stop-change 0.01", "stalled", None),
        ("--gap 0.5", "converged", None),
        ("--max-iterations 9 --check-every 3 --gap 0", "iteration-limit", Some(9)),
    ] {
        let answer = folder.solve(&format!("{PROBLEM} {stop}"), "out");
        answer.assert_consistent();
        assert_eq!(answer.status(), status, "{stop}");
        if let Some(iterations) = iterations {
            assert_eq!(answer.summary["iterations"], iterations, "{stop}");
        }
        let change = answer.column("change");
        assert!(change[0].is_none() && change[1..].iter().all(Option::is_some));
    }
    let answer =
        folder.solve(&format!("{PROBLEM} --gap 0 --max-iterations 9 --check-every 3"), "out");
    assert_eq!(answer.column("iteration"), [0.0, 3.0, 6.0, 9.0].map(Some));
}

#[test]
fn the_folder() {
    let folder = folder();
    let few = "torus:40x25 --costs S.npy --lambda 0.02 --max-iterations 2";
    folder.solve(few, "new/and/deep");
    let files = names(&folder.path("new/and/deep"));
    assert!(files.contains("preview.png") && files.len() == 6);

    // Files that a run does not write stay; files that it writes replace those of the same name.
    fs::create_dir(folder.path("old")).unwrap();
    folder.write("old/notes.txt", "mine");
    folder.write("old/summary.json", "not yet");
    folder.solve(&format!("{few} --no-preview"), "old");
    let files = names(&folder.path("old"));
    assert!(files.contains("notes.txt") && !files.contains("preview.png") && files.len() == 6);
    folder.solve(&format!("{few} --no-preview"), "old/");
    folder.solve(&format!("{few} --no-preview"), ".");
    let absolute = folder.path("absolute").display().to_string();
    folder.solve(&format!("{few} --no-preview"), &absolute);
}

#[test]
fn a_folder_in_the_way_of_a_file_leaves_the_old_results() {
    let folder = folder();
    fs::create_dir_all(folder.path("old/u.npy")).unwrap();
    folder.write("old/summary.json", "mine");
    let output = folder.run(&format!("solve {PROBLEM} --max-iterations 2 --out old"));
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("u.npy: is a folder"), "{}", stderr(&output));
    assert_eq!(fs::read(folder.path("old/summary.json")).unwrap(), b"mine");
    assert_eq!(names(&folder.path("old")).len(), 2);
}

#[cfg(unix)]
#[test]
fn the_folder_gets_the_permissions_of_any_new_folder() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder();
    folder.solve(&format!("{PROBLEM} --max-iterations 1"), "out");
    fs::create_dir(folder.path("any")).unwrap();
    folder.write("any/file", "");
    let mode = |name: &str| fs::metadata(folder.path(name)).unwrap().permissions().mode();
    assert_eq!(mode("out"), mode("any"));
    assert_eq!(mode("out/u.npy"), mode("any/file"));
}

/// A component without known vertices has no neighbors from which to inherit labels.
#[test]
fn meaningless_labels_are_counted() {
    let folder = Folder::new();
    let two = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 5 0 0\nv 7 0 0\nv 5 3 0\nf 1 2 3\nf 1 3 4\nf 5 6 7\nf 1 2 2\n";
    folder.write("two.obj", two);
    let rows = |unknown: &[usize]| {
        Array2::from_shape_fn((7, 2), |(k, p)| {
            if unknown.contains(&k) { f64::NAN } else { f64::from((k % 2 + p) as u8) }
        })
    };
    let solve = "solve two.obj --costs S.npy --lambda 0.01 --no-preview --out solved";
    let segment = "segment two.obj --data d.npy --regions 2 --no-preview --out segmented";
    let experiment = "# ?\nstop = { gap = 1e-2, max-iterations = 50 }\n[[instance]]\nmesh = \"two.obj\"\n\
        data = \"costs:S.npy\"\nlambda = 0.01\n[[solver]]\nname = \"chambolle-pock\"\n[[figure]]\n\
        name = \"f\"\nkind = \"decay\"\n";
    folder.write("e.toml", experiment);
    for (unknown, count) in [(vec![4, 5, 6], Some(3)), (vec![4, 6], None), (vec![], None)] {
        folder.array("S.npy", &rows(&unknown));
        folder.array("d.npy", &rows(&unknown).slice_move(ndarray::s![.., ..1]));
        for line in [solve, segment] {
            let output = folder.run(line);
            let messages = stderr(&output);
            assert_eq!(output.status.code(), Some(0), "{messages}");
            let expected = count.map(|n| format!("{n} vertices (75.00 % of the area) are unknown"));
            match expected {
                Some(text) => assert!(messages.contains(&text), "{line}: {messages}"),
                None => {
                    assert!(
                        !messages.contains("not connected to any known vertex"),
                        "{line}: {messages}"
                    )
                }
            }
            // This is not claimed for vertices without known neighbors.
            let inherit = "where they are connected to known vertices, they take the labels of their neighbors";
            assert_eq!(messages.contains(inherit), !unknown.is_empty(), "{line}: {messages}");
        }
        // An exported problem has the same warnings.
        let export = "problem export two.obj --costs S.npy --lambda 0.01 --out problem.npz";
        let messages = stderr(&folder.run(export));
        assert_eq!(
            messages.contains("which marks them as unknown"),
            !unknown.is_empty(),
            "{messages}"
        );
        assert!(messages.contains("1 face without area was left out"), "{messages}");
        folder.done("experiment run e.toml");
        let runs = folder.path("results/e/runs");
        let is_reported = crate::support::names(&runs).iter().any(|id| {
            let summary = std::fs::read_to_string(runs.join(id).join("summary.json")).unwrap();
            summary.contains("their labels mean nothing")
        });
        // Experiments store the same warnings.
        assert!(is_reported, "{unknown:?}");
    }
}

/// Files of an earlier run do not belong to the results of a later one.
#[test]
fn files_that_only_an_earlier_run_wrote_are_removed() {
    let folder = folder();
    folder.done(&format!("solve {TORUS} --costs S.npy --lambda 0.02 --save q --out o"));
    let first = names(&folder.path("o"));
    folder.done(&format!("solve {PROBLEM} --out o"));
    let second = names(&folder.path("o"));
    let gone: Vec<&String> = first.difference(&second).collect();
    assert_eq!(gone, ["preview.png", "q.npy"]);
    assert!(second.is_subset(&first) && second.len() > 3, "{second:?}");
}
