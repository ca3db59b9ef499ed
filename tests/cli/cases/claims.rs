//! The claims of the program are true: gaps are invariant under constants, labels can be forbidden, vertices can be
//! unknown, numbers have any type, empty regions are reported, and bounds of given U are valid.

use std::path::PathBuf;

use ndarray::{Array2, s};
use ndarray_npy::{read_npy, write_npy};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use serde_json::Value;

use crate::support::{Answer, Folder, costs, stderr};

fn case(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/cases").join(name)
}

const VERTICES: usize = 60 * 40;

fn torus() -> Folder {
    let folder = Folder::new();
    folder.done("mesh generate torus:60x40 --out m.ply");
    folder
}

/// A constant added to the costs of each vertex changes neither where a solver stops nor its gaps.
#[test]
fn constants_in_the_costs_change_no_gap() {
    let folder = torus();
    let own = costs(VERTICES, 3);
    let ramp = Array2::from_shape_fn((VERTICES, 3), |(k, _)| 1e4 * (k as f64).sin());
    for (name, costs) in
        [("s", own.clone()), ("high", &own + 1e5), ("low", &own - 1e3), ("ramp", &own + &ramp)]
    {
        folder.array(&format!("{name}.npy"), &costs);
    }
    for options in
        ["", "--precision f32", "--solver fista --max-iterations 200", "--mass consistent"]
    {
        let solve = |name: &str| {
            folder.solve(
                &format!("m.ply --costs {name}.npy --lambda 0.05 --no-preview {options}"),
                name,
            )
        };
        let known = solve("s");
        assert!(known.number("iterations") > 0.0);
        for name in ["high", "low", "ramp"] {
            let other = solve(name);
            assert_eq!(other.labels, known.labels, "{name} {options}");
            assert_eq!(other.number("iterations"), known.number("iterations"), "{name} {options}");
            for key in ["gap", "relative_gap", "rounded_relative_gap"] {
                let (a, b) = (other.number(key), known.number(key));
                // The costs lose five digits, differences of them more.
                assert!((a - b).abs() <= 1e-5 * b + 1e-7, "{name} {options}, {key}: {a} {b}");
            }
            let above = |answer: &Answer| answer.number("energy") - answer.number("baseline");
            assert!((above(&other) - above(&known)).abs() <= 1e-7 * above(&known), "{name}");
        }
    }
}

/// The gap of the labels is (R - D) / (D - B), on the screen and in the summary.
#[test]
fn the_gap_of_the_labels_is_the_same_everywhere() {
    let folder = torus();
    folder.array("s.npy", &costs(VERTICES, 3));
    let screen = folder.done("solve m.ply --costs s.npy --lambda 0.05 --no-preview --out o");
    let answer = folder.answer("o");
    let [r, d, b] = ["rounded_energy", "dual_bound", "baseline"].map(|key| answer.number(key));
    let share = answer.number("rounded_relative_gap");
    assert!((share - (r - d) / (d - b)).abs() <= 1e-9 * share);
    assert!(
        screen.contains(&format!("at most {:.2} % above any labeling", 100.0 * share)),
        "{screen}"
    );
    let e = answer.number("energy");
    let gap = answer.number("relative_gap");
    assert!((gap - (e - d) / (e - b)).abs() <= 1e-9 + 1e-6 * gap);
}

/// +inf forbids a label for every solver; the optimum is that with a prohibitively large cost.
#[test]
fn infinite_costs_forbid_labels() {
    let folder = torus();
    let mut s = costs(VERTICES, 3);
    let mut dear = s.clone();
    for k in (0..VERTICES).filter(|k| k % 5 == 0 || *k < 500) {
        (s[[k, k % 3]], dear[[k, k % 3]]) = (f64::INFINITY, 1e4);
    }
    folder.array("s.npy", &s);
    folder.array("dear.npy", &dear);
    let dear = folder.solve("m.ply --costs dear.npy --lambda 0.01 --gap 1e-5 --no-preview", "dear");
    for options in [
        "--gap 1e-5",
        "--gap 1e-5 --solver-option engine=rows",
        "--precision f32",
        "--gap 1e-5 --init uniform",
        "--gap 1e-5 --init random --coarse-to-fine",
        "--gap 1e-5 --solver douglas-rachford",
        "--solver fista --max-iterations 1000",
        "--solver projected-gradient --max-iterations 1000",
        "--mass voronoi",
    ] {
        let options = options.replace(" --init random --coarse-to-fine", " --coarse-to-fine");
        let line = format!("m.ply --costs s.npy --lambda 0.01 --no-preview {options}");
        let found = folder.solve(&line, "found");
        found.assert_consistent();
        for ((k, p), cost) in s.indexed_iter() {
            assert!(cost.is_finite() || found.u[[k, p]] == 0.0, "{options}");
        }
        if options.contains("1e-5") {
            let (a, b) = (found.number("energy"), dear.number("energy"));
            assert!((a - b).abs() <= 2e-5 * b, "{options}: {a} {b}");
        }
        let warnings = found.summary["warnings"].to_string();
        assert!(warnings.contains("forbidden"), "{warnings}");
    }
    let evaluate = folder.done("evaluate m.ply --costs s.npy --lambda 0.01 --u dear/u.npy");
    let evaluation: Value = serde_json::from_str(&evaluate).unwrap();
    assert!((evaluation["energy"].as_f64().unwrap() - dear.number("energy")).abs() < 1e-9);
    let refused = |line: &str, what: &str| {
        let output = folder.run(line);
        assert_eq!(output.status.code(), Some(1), "{line}");
        let message = stderr(&output);
        assert!(message.contains(what) && message.lines().count() == 1, "{message}");
    };
    refused("solve m.ply --costs s.npy --lambda 0.01 --mass consistent --out x", "lumped");
    refused("problem export m.ply --costs s.npy --lambda 0.01 --out x.npz", "forbidden");
    let mut u = Array2::zeros((VERTICES, 3));
    u.column_mut(0).fill(1.0);
    folder.array("u.npy", &u);
    refused("evaluate m.ply --costs s.npy --lambda 0.01 --u u.npy", "forbid");
    for (name, row, what) in [
        ("all", [f64::INFINITY; 3], "every label in row 7"),
        ("minus", [0.0, f64::NEG_INFINITY, 1.0], "-inf in row 7, column 1"),
        ("some", [0.0, 1.0, f64::NAN], "NaN in row 7, column 2"),
    ] {
        let mut wrong = costs(VERTICES, 3);
        wrong.row_mut(7).assign(&ndarray::arr1(&row));
        folder.array(&format!("{name}.npy"), &wrong);
        refused(&format!("solve m.ply --costs {name}.npy --lambda 0.01 --out x"), what);
    }
}

/// A row of NaN has no costs: the result is that with a row of zeros.
#[test]
fn rows_of_nan_are_unknown() {
    let folder = torus();
    let mut s = costs(VERTICES, 3);
    s.slice_mut(s![300..350, ..]).fill(0.0);
    folder.array("zero.npy", &s);
    s.slice_mut(s![300..350, ..]).fill(f64::NAN);
    folder.array("nan.npy", &s);
    let solve = |name: &str| folder.solve(&format!("m.ply --costs {name}.npy --lambda 0.02"), name);
    let (zero, nan) = (solve("zero"), solve("nan"));
    assert_eq!((zero.u, zero.labels), (nan.u, nan.labels));
    assert!(nan.summary["warnings"][0].as_str().unwrap().contains("50 vertices"));

    let (mesh, data) = (case("27-nan-mask/m.ply"), case("27-nan-mask/thickness.npy"));
    let line = format!(
        "segment {} --data {} --regions 2 --no-preview --out o",
        mesh.display(),
        data.display()
    );
    folder.done(&line);
    let known: ndarray::Array1<f64> = read_npy(&data).unwrap();
    let unknown = known.iter().filter(|x| x.is_nan()).count();
    let answer = folder.answer("o");
    assert!(unknown > 0);
    let warnings = answer.summary["warnings"].to_string();
    assert!(warnings.contains(&format!("{unknown} vertices have no data")), "{warnings}");
    let means = answer.summary["region_parameters"].as_array().unwrap();
    assert!(means.iter().all(|region| region["mean"][0].as_f64().is_some()), "{means:?}");
}

#[test]
fn arrays_of_all_kinds_of_numbers_are_read() {
    let folder = Folder::new();
    let file = |name: &str| case(&format!("35-npy-kinds/{name}")).display().to_string();
    let mesh = file("m.ply");
    for kind in ["i8", "i4", "bool", "f2", "be", "u2", "u1", "fort", "v2", "v3", "be_u1col"] {
        let data = file(&format!("{kind}.npy"));
        folder.done(&format!("segment {mesh} --data {data} --regions 2 --no-preview --out {kind}"));
    }
    for kind in ["S_i8", "S_be4", "Sfort"] {
        let costs = file(&format!("{kind}.npy"));
        folder
            .done(&format!("solve {mesh} --costs {costs} --lambda 0.01 --no-preview --out {kind}"));
    }
    for (kind, what) in
        [("obj", "not plain numbers"), ("struct", "plain numbers"), ("perface", "rows")]
    {
        let output = folder.run(&format!(
            "segment {mesh} --data {} --regions 2 --out x",
            file(&format!("{kind}.npy"))
        ));
        assert_eq!(output.status.code(), Some(1), "{kind}");
        assert!(stderr(&output).contains(what), "{}", stderr(&output));
    }
    // Labels written by the program can be read as data.
    folder
        .done(&format!("segment {mesh} --data i4/labels.npy --regions 2 --no-preview --out again"));
}

/// The warning names a lambda for which no region is empty.
#[test]
fn a_warning_about_empty_regions_names_a_remedy() {
    let folder = torus();
    folder.array("s.npy", &costs(VERTICES, 3));
    let line = "m.ply --costs s.npy --no-preview --lambda";
    let output = folder.run(&format!("solve {line} 3 --out lost"));
    let answer = folder.answer("lost");
    let warnings = answer.summary["warnings"].to_string();
    let lambda = warnings.split("--lambda ").nth(1).unwrap_or_else(|| panic!("{warnings}"));
    let lambda: String = lambda.chars().take_while(|c| "0123456789.e-".contains(*c)).collect();
    assert!(warnings.contains("empty"), "{warnings}");
    assert!(String::from_utf8(output.stdout).unwrap().contains("are empty"));
    let found = folder.solve(&format!("{line} {lambda}"), "found");
    assert!((0..3).all(|p| found.labels.iter().any(|&label| label == p)), "{lambda}");
    // A region that is nowhere the cheapest is not emptied by lambda.
    let mut dear = costs(VERTICES, 3);
    dear.column_mut(1).fill(1e3);
    folder.array("s.npy", &dear);
    let warnings = folder.solve(&format!("{line} 1e-3"), "dear").summary["warnings"].to_string();
    assert!(
        warnings.contains("region 1 is empty: no vertex has its smallest cost there"),
        "{warnings}"
    );
}

/// Regions with equal means are merged quickly; for data of one value, all regions are.
#[test]
fn a_warning_reports_data_with_too_few_values() {
    let folder = torus();
    let two = Array2::from_shape_fn((VERTICES, 1), |(k, _)| f64::from(u8::from(k < VERTICES / 2)));
    write_npy(folder.path("two.npy"), &two).unwrap();
    write_npy(folder.path("one.npy"), &(two * 0.0 + 0.7)).unwrap();
    let segment = |data: &str, regions: usize| {
        let line =
            format!("segment m.ply --data {data}.npy --regions {regions} --no-preview --out o");
        let screen = folder.done(&line);
        (screen, folder.answer("o"))
    };
    let (screen, answer) = segment("two", 4);
    let warnings = answer.summary["warnings"].to_string();
    assert!(warnings.contains("empty") && warnings.contains("use --regions 2"), "{warnings}");
    assert!(screen.contains("empty"), "{screen}");
    assert!(answer.number("iterations") < 5000.0);
    let (screen, answer) = segment("one", 2);
    let warnings = answer.summary["warnings"].to_string();
    assert_eq!(warnings.matches("nothing to segment").count(), 1, "{warnings}");
    assert!(screen.contains("empty"), "{screen}");
}

/// The bound of a given U: that of the solver from its q, close to it from steps, and always valid.
#[test]
fn evaluate_bounds_an_optimum() {
    let folder = torus();
    folder.array("s.npy", &costs(VERTICES, 3));
    let solved =
        folder.solve("m.ply --costs s.npy --lambda 0.05 --gap 1e-5 --save q --no-preview", "o");
    let evaluate = |options: &str| -> Value {
        let line = format!("evaluate m.ply --costs s.npy --lambda 0.05 --u o/u.npy {options}");
        serde_json::from_str(&folder.done(&line)).unwrap()
    };
    let number =
        |value: &Value, key: &str| value[key].as_f64().unwrap_or_else(|| panic!("{key}: {value}"));
    let own = evaluate("--q o/q.npy");
    assert_eq!(own["certificate"], "offered");
    assert!((number(&own, "dual_bound") - solved.number("dual_bound")).abs() <= 1e-12);
    assert!((number(&own, "relative_gap") - solved.number("relative_gap")).abs() <= 1e-9);
    let steps = evaluate("");
    assert_eq!(steps["certificate"], "steps");
    assert!(number(&steps, "relative_gap") < 0.02, "{steps}");
    assert!(number(&steps, "dual_bound") <= solved.number("energy") + 1e-12);
    let none = evaluate("--dual-steps 0");
    assert_eq!(number(&none, "dual_bound"), number(&none, "baseline"));
    // A given q is projected onto the ball of radius lambda, so that the bound is always valid.
    let q: Array2<f64> = read_npy(folder.path("o/q.npy")).unwrap();
    write_npy(folder.path("q.npy"), &(q * 1e3)).unwrap();
    assert!(number(&evaluate("--q q.npy"), "dual_bound") <= solved.number("energy") + 1e-12);
    let output = folder.run("evaluate m.ply --costs s.npy --lambda 0.05 --u o/u.npy --q o/u.npy");
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("two rows for each"), "{}", stderr(&output));
    // A folder that is written again without q contains none.
    folder.solve("m.ply --costs s.npy --lambda 0.05 --no-preview", "o");
    assert!(!folder.path("o/q.npy").exists());
}

/// Without `--lambda`, data of every kind give the requested number of regions, with a certificate: colors, textures,
/// images on surfaces, curvature, from constant pieces to noise of twice the contrast.
#[test]
fn the_default_lambda_suits_every_kind_of_data() {
    let folder = Folder::new();
    let asset = |name: &str| {
        PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("assets").join(name).display().to_string()
    };
    let (human, cat) = (asset("human/human.ply"), asset("images/chelsea.png"));
    let (spot, texture) = (asset("spot/spot_triangulated.obj"), asset("spot/spot_texture.png"));
    for line in [
        "builtin:spot --regions 2".into(),
        "builtin:spot --regions 3".into(),
        "builtin:spot --regions 6".into(),
        format!("{spot} --data texture:{texture} --regions 3"),
        "builtin:spot --data curvature --regions 2".into(),
        "builtin:spot --data curvature --regions 3".into(),
        format!("{human} --regions 4"),
        format!("{human} --data curvature --regions 2"),
        "torus:200x125 --data curvature --regions 3".into(),
        format!("grid:225x150 --data image:{cat} --regions 2"),
        format!("grid:225x150 --data image:{cat} --regions 4"),
        format!("sphere:5 --data image:{cat} --project sphere --regions 3"),
        format!("torus:200x125 --data image:{cat} --project xy --regions 3"),
    ] {
        folder.done(&format!("segment {line} --gap 1e-3 --no-preview --out o"));
        let answer = folder.answer("o");
        assert_eq!(answer.summary["empty_regions"], serde_json::json!([]), "{line}");
        assert_eq!(answer.status(), "converged", "{line}");
        assert!(answer.number("iterations") < 3000.0, "{line}: {}", answer.number("iterations"));
    }

    let (n, m) = (200, 125);
    let label = |k: usize| {
        let u = (k / m) as f64 / n as f64 * std::f64::consts::TAU;
        let v = (k % m) as f64 / m as f64 * std::f64::consts::TAU;
        let first = (3.0 * u + (2.0 * v).sin()).sin() > 0.0;
        let second = (2.0 * v + (3.0 * u).cos()).sin() > 0.0;
        2 * usize::from(first) + usize::from(second)
    };
    let palette = [[0.85, 0.2, 0.2], [0.2, 0.7, 0.3], [0.2, 0.3, 0.85], [0.9, 0.85, 0.2]];
    let mut rng = Pcg64::seed_from_u64(31);
    for noise in [0.0, 0.1, 0.3, 0.6, 1.0] {
        let mut gauss = || -> f64 { StandardNormal.sample(&mut rng) };
        let color =
            Array2::from_shape_fn((n * m, 3), |(k, i)| palette[label(k)][i] + noise * gauss());
        folder.array("c.npy", &color);
        folder
            .done("segment torus:200x125 --data c.npy --regions 4 --gap 1e-3 --no-preview --out o");
        let found = folder.answer("o").labels;
        let mut seen = [[0; 4]; 4];
        (0..n * m).for_each(|k| seen[label(k)][found[k] as usize] += 1);
        // Every region is nearly one of the four, each a different one.
        let best = seen.map(|counts| (0..4).max_by_key(|&p| counts[p]).unwrap());
        let right: usize = (0..4).map(|t| seen[t][best[t]]).sum();
        assert!((0..4).all(|p| best.contains(&p)), "noise {noise}: {seen:?}");
        let least = if noise < 1.0 { 0.97 } else { 0.93 };
        assert!(right as f64 > least * (n * m) as f64, "noise {noise}: {seen:?}");
    }
}

/// With seeds alone, or among costs that are small compared to lambda, the problem is that for lambda = 1 and is solved
/// as quickly.
#[test]
fn problems_with_seeds_do_not_depend_on_lambda() {
    let folder = torus();
    for (name, small) in [("seeds", 0.0), ("among", 1e-6)] {
        let mut s = costs(VERTICES, 3) * small;
        for k in (0..VERTICES).step_by(61) {
            s.row_mut(k).fill(f64::INFINITY);
            s[[k, (k / 61) % 3]] = 0.0;
        }
        folder.array("s.npy", &s);
        let solve = |lambda: f64| {
            let line = format!("m.ply --costs s.npy --lambda {lambda} --no-preview");
            let found = folder.solve(&line, "o");
            found.assert_consistent();
            assert_eq!(found.status(), "converged", "{name} {lambda}");
            (found.number("iterations"), found.number("energy") / lambda)
        };
        let (steps, known) = solve(1.0);
        assert!(steps < 5000.0, "{name}: {steps}");
        for lambda in [0.05, 20.0, 1e4] {
            let (iterations, energy) = solve(lambda);
            assert!(iterations < 1.5 * steps, "{name} {lambda}: {iterations} {steps}");
            assert!((energy - known).abs() < 1e-3 * known, "{name} {lambda}: {energy} {known}");
        }
    }
}

/// Huge costs that no label pays do not loosen the tolerance for rounding: the gap is that of the stated numbers.
#[test]
fn huge_costs_do_not_affect_the_certificate() {
    let folder = torus();
    let own = costs(VERTICES, 3);
    for (name, huge) in [("1e9", 1e9), ("1e20", 1e20), ("inf", f64::INFINITY)] {
        let mut s = own.clone();
        (0..VERTICES).step_by(37).for_each(|k| s[[k, (k / 37) % 3]] = huge);
        folder.array(&format!("{name}.npy"), &s);
    }
    let solve = |name: &str| {
        folder
            .solve(&format!("m.ply --costs {name}.npy --lambda 0.02 --gap 1e-5 --no-preview"), name)
    };
    let known = solve("inf");
    for name in ["1e9", "1e20"] {
        let found = solve(name);
        let [e, d, b] = ["energy", "dual_bound", "baseline"].map(|key| found.number(key));
        assert!((found.number("relative_gap") - (e - d) / (e - b)).abs() <= 1e-9, "{name}");
        assert!((e - known.number("energy")).abs() <= 1e-5 * (e - b), "{name}");
        assert_eq!(found.labels, known.labels, "{name}");
        let line = format!(
            "evaluate m.ply --costs {name}.npy --lambda 0.02 --u {name}/u.npy --dual-steps 0"
        );
        let evaluation: Value = serde_json::from_str(&folder.done(&line)).unwrap();
        assert_eq!(evaluation["relative_gap"].as_f64(), Some(1.0));
        assert!(evaluation["rounded_relative_gap"].is_null());
    }
}

/// Rows with negative entries only are rounded to an existing label that is not forbidden.
#[test]
fn evaluate_rounds_to_labels_that_exist() {
    let folder = torus();
    let mut s = costs(VERTICES, 3);
    s[[0, 1]] = f64::INFINITY;
    folder.array("s.npy", &s);
    let mut u = Array2::from_elem((VERTICES, 3), -1.0);
    u[[0, 1]] = 0.0;
    folder.array("u.npy", &u);
    let line = "evaluate m.ply --costs s.npy --lambda 0.01 --u u.npy";
    let evaluation: Value = serde_json::from_str(&folder.done(line)).unwrap();
    assert_eq!(evaluation["feasible"], false);
    assert!(evaluation["rounded_energy"].as_f64().unwrap() < 10.0, "{evaluation}");
}

/// Neither a placeholder for missing values nor data far from zero hide regions.
#[test]
fn outliers_and_large_offsets_hide_no_regions() {
    let folder = torus();
    let mut rng = Pcg64::seed_from_u64(32);
    let mut gauss = || -> f64 { StandardNormal.sample(&mut rng) };
    let half = |k: usize| f64::from(u8::from(k < VERTICES / 2));
    let own = Array2::from_shape_fn((VERTICES, 1), |(k, _)| half(k) + 0.1 * gauss());
    folder.array("far.npy", &(&own + 1e10));
    let mut outlier = own;
    outlier[[VERTICES / 4, 0]] = -9999.0;
    folder.array("outlier.npy", &outlier);
    for (name, regions) in [("far", 2), ("outlier", 3)] {
        let line =
            format!("segment m.ply --data {name}.npy --regions {regions} --no-preview --out o");
        folder.done(&line);
        let answer = folder.answer("o");
        assert_eq!(answer.summary["empty_regions"], serde_json::json!([]), "{name}");
        let [first, second] = [VERTICES / 8, 3 * VERTICES / 4].map(|k| answer.labels[k]);
        let wrong = (0..VERTICES)
            .filter(|&k| answer.labels[k] != if half(k) == 1.0 { first } else { second })
            .count();
        assert!(first != second && wrong < VERTICES / 50, "{name}: {wrong}");
    }
}
