//! `segment` with given parameters and with baselines: their numbers are those that `solve` and `evaluate` compute from
//! the same costs.

use ndarray::{Array1, Array2};
use ndarray_npy::{read_npy, write_npy};

use crate::support::{Folder, stderr};

const MESH: &str = "torus:40x24";

/// Noisy bands of the values 0, 0.5 and 1 around the torus.
fn bands(folder: &Folder) -> Array1<f64> {
    let mut state = 9_u64;
    let mut noise = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as f64 / (1_u64 << 31) as f64 - 0.5
    };
    let data = Array1::from_shape_fn(40 * 24, |k| f64::from((k / 24 / 14) as u8) / 2.0 + noise());
    write_npy(folder.path("data.npy"), &data).unwrap();
    data
}

/// |C(x) - mu_p|^2.
fn write_costs(folder: &Folder, data: &Array1<f64>, mu: &[f64]) {
    let costs = Array2::from_shape_fn((data.len(), mu.len()), |(k, p)| (data[k] - mu[p]).powi(2));
    write_npy(folder.path("costs.npy"), &costs).unwrap();
}

fn means(folder: &Folder, name: &str) -> Vec<f64> {
    let answer = folder.answer(name);
    let regions = answer.summary["region_parameters"].as_array().unwrap();
    regions.iter().map(|region| region["mean"][0].as_f64().unwrap()).collect()
}

fn close(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance * a.abs(), "{a} {b}");
}

/// Given means stay as they are: the problem is that of `solve` with their costs.
#[test]
fn given_means_are_a_problem_with_fixed_costs() {
    let folder = Folder::new();
    let data = bands(&folder);
    let mu = [0.1, 0.4, 0.9];
    write_npy(folder.path("mu.npy"), &Array2::from_shape_fn((3, 1), |(p, _)| mu[p])).unwrap();
    write_costs(&folder, &data, &mu);
    let common = "--lambda 0.01 --normalize none --gap 1e-6 --no-preview";
    folder.done(&format!("segment {MESH} --data data.npy --means mu.npy {common} --out given"));
    let solve = "--lambda 0.01 --gap 1e-6 --relaxation separate --no-preview";
    folder.done(&format!("solve {MESH} --costs costs.npy {solve} --out solved"));
    let [given, solved] = ["given", "solved"].map(|name| folder.answer(name));
    assert_eq!(given.u, solved.u);
    assert_eq!(given.number("energy"), solved.number("energy"));
    assert_eq!((means(&folder, "given"), given.number("re_estimations")), (mu.to_vec(), 0.0));
    assert_eq!(given.summary["init"], "given");
}

/// The parameters of a run, of any model, give its energy again.
#[test]
fn parameters_of_a_run_give_its_energy() {
    let folder = Folder::new();
    bands(&folder);
    for model in ["constant", "l1", "gaussian"] {
        let common = "--lambda 0.01 --gap 1e-5 --no-preview";
        folder.done(&format!(
            "segment {MESH} --data data.npy --regions 3 --model {model} {common} --out run"
        ));
        folder.done(&format!(
            "segment {MESH} --data data.npy --means run/summary.json {common} --out again"
        ));
        let [run, again] = ["run", "again"].map(|name| folder.answer(name));
        assert_eq!(run.summary["model"], again.summary["model"]);
        let scale = run.number("energy") - run.number("baseline");
        let difference = run.number("energy") - again.number("energy");
        assert!(difference.abs() <= 2e-5 * scale, "{model}: {difference}");
        assert!(again.number("dual_bound") <= run.number("energy") + 1e-12 * scale);
        let parameters = |summary: &serde_json::Value| {
            let regions = summary["region_parameters"].as_array().unwrap().clone();
            regions
                .into_iter()
                .map(|mut region| {
                    let map = region.as_object_mut().unwrap();
                    for key in ["area", "share", "color"] {
                        map.remove(key);
                    }
                    region
                })
                .collect::<Vec<_>>()
        };
        assert_eq!(parameters(&run.summary), parameters(&again.summary));
    }
}

/// A baseline has the energy that `evaluate` finds for its labels, and a bound below it that `solve` reaches.
#[test]
fn baselines_are_scored_as_any_labels() {
    let folder = Folder::new();
    let data = bands(&folder);
    for model in ["kmeans", "threshold", "threshold --thresholds 0.2,0.7"] {
        let regions = if model.contains(',') { "" } else { "--regions 3" };
        folder.done(&format!(
            "segment {MESH} --data data.npy --model {model} {regions} --lambda 0.01 --normalize none --out base"
        ));
        let base = folder.answer("base");
        let mu = means(&folder, "base");
        write_costs(&folder, &data, &mu);
        let output = folder.run(&format!(
            "evaluate {MESH} --costs costs.npy --relaxation separate --lambda 0.01 --u base/u.npy --dual-steps 2000"
        ));
        let scores: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        close(scores["energy"].as_f64().unwrap(), base.number("energy"), 1e-12);
        close(scores["dual_bound"].as_f64().unwrap(), base.number("dual_bound"), 1e-3);
        assert!(base.number("dual_bound") <= base.number("energy"));
        assert_eq!(base.number("energy"), base.number("rounded_energy"));
        assert_eq!((base.status(), base.number("iterations")), ("ended", 0.0));
        // Each vertex has the label of its value alone.
        let labels: Array1<i32> = read_npy(folder.path("base/labels.npy")).unwrap();
        for (k, &label) in labels.iter().enumerate() {
            let expected = match model {
                "threshold --thresholds 0.2,0.7" => {
                    i32::from(data[k] >= 0.2) + i32::from(data[k] >= 0.7)
                }
                _ => {
                    let distance = |p: usize| (data[k] - mu[p]).abs();
                    (0..3).min_by(|&a, &b| distance(a).total_cmp(&distance(b))).unwrap() as i32
                }
            };
            assert_eq!(label, expected, "{model}: vertex {k}");
        }
    }
}

/// The classes of least variance have no more variance than those of k-means.
#[test]
fn thresholds_are_a_global_optimum_of_k_means() {
    let folder = Folder::new();
    bands(&folder);
    let energy = |model: &str| {
        folder.done(&format!(
            "segment {MESH} --data data.npy --model {model} --regions 5 --lambda 0 --no-preview --out base"
        ));
        folder.answer("base").number("energy")
    };
    let (otsu, kmeans) = (energy("threshold"), energy("kmeans"));
    assert!(otsu <= kmeans * (1.0 + 1e-12), "{otsu} {kmeans}");
    close(otsu, kmeans, 0.02);
}

/// Means of bytes are in the units of data of bytes.
#[test]
fn means_of_bytes_are_divided_by_255() {
    let folder = Folder::new();
    let data = bands(&folder).mapv(|x| (100.0 + 50.0 * x) as u8);
    write_npy(folder.path("bytes.npy"), &data).unwrap();
    write_npy(folder.path("mu.npy"), &Array1::from(vec![100_u8, 150])).unwrap();
    folder.done(&format!(
        "segment {MESH} --data bytes.npy --means mu.npy --lambda 1e-4 --no-preview --out given"
    ));
    assert_eq!(means(&folder, "given"), [100.0 / 255.0, 150.0 / 255.0]);
    assert_eq!(folder.answer("given").summary["empty_regions"].as_array().unwrap().len(), 0);
}

/// Warnings of a baseline are about its own labels, not about those of the solve for the bound.
#[test]
fn warnings_of_baselines_are_about_their_labels() {
    let folder = Folder::new();
    bands(&folder);
    let warnings = |line: &str| -> Vec<String> {
        folder.done(&format!("segment {MESH} {line} --no-preview --out base"));
        let warnings = folder.answer("base").summary["warnings"].as_array().unwrap().clone();
        warnings.iter().map(|warning| warning.as_str().unwrap().to_owned()).collect()
    };
    let large = "--data data.npy --regions 3 --lambda 10";
    for model in ["kmeans", "threshold"] {
        assert!(warnings(&format!("{large} --model {model}")).is_empty());
    }
    let two = Array1::from_shape_fn(40 * 24, |k| f64::from((k % 2) as u8));
    write_npy(folder.path("two.npy"), &two).unwrap();
    let said = warnings("--data two.npy --regions 4 --lambda 0.01 --model kmeans");
    assert!(said.len() == 1 && said[0].contains("the data have fewer clusters"), "{said:?}");
    let unknown = Array1::from_shape_fn(40 * 24, |k| if k == 5 { f64::NAN } else { two[k] });
    write_npy(folder.path("unknown.npy"), &unknown).unwrap();
    let said = warnings("--data unknown.npy --regions 2 --lambda 0.01 --model kmeans");
    assert!(said.iter().any(|line| line.contains("1 vertex is without data")), "{said:?}");
}

#[test]
fn parameters_that_do_not_fit_are_refused() {
    let folder = Folder::new();
    bands(&folder);
    let write = |name: &str, rows: Array2<f64>| write_npy(folder.path(name), &rows).unwrap();
    write("wide.npy", Array2::zeros((3, 2)));
    write("one.npy", Array2::zeros((1, 1)));
    write("nan.npy", Array2::from_elem((3, 1), f64::NAN));
    std::fs::write(folder.path("text.json"), "{}").unwrap();
    let covariance = r#"{"model": "gaussian", "region_parameters": [{"mean": [0], "covariance": [[1]]},
        {"mean": [1], "covariance": [[-1]]}]}"#;
    std::fs::write(folder.path("negative.json"), covariance).unwrap();
    let unknown = r#"{"model": "l1", "region_parameters": [{"mean": [0]}, {"mean": [1]}]}"#;
    std::fs::write(folder.path("unknown.json"), unknown).unwrap();
    for (arguments, message) in [
        ("--means wide.npy", "data.npy: region 0 has 2 numbers for data of 1 column"),
        ("--means one.npy", "one.npy: 1 regions: must be from 2 to 64"),
        ("--means nan.npy", "nan.npy: row 0 has NaN; means must be finite"),
        ("--means text.json", "text.json: is not the summary.json of `segment`"),
        ("--means negative.json", "data.npy: region 1: the covariance is not positive definite"),
        ("--means unknown.json", "data.npy: the parameters of region 0: unknown field `mean`"),
        ("--means negative.json --model l1", "has the parameters of the model gaussian, not of l1"),
        ("--means missing.npy", "missing.npy: "),
        ("--means wide.npy --model kmeans", "--means does not apply to a baseline"),
        ("--means one.npy --model gaussian", "give the summary.json of a run of this model"),
        ("--thresholds 1,0 --model threshold", "the thresholds must be ascending numbers"),
        ("--thresholds 7,8 --model threshold", "no data lie between the thresholds of region 1"),
        ("--thresholds 0.5", "--thresholds needs --model threshold"),
    ] {
        let output = folder.run(&format!("segment {MESH} --data data.npy {arguments} --out out"));
        assert_eq!(output.status.code(), Some(1), "{arguments}");
        let line = stderr(&output);
        assert!(line.contains(message) && line.lines().count() == 1, "{arguments}: {line}");
        assert!(!folder.path("out").exists());
    }
    let output = folder.run("segment builtin:spot --model threshold --regions 3 --out out");
    assert!(stderr(&output).contains("thresholds need data with one number per vertex"));
}
