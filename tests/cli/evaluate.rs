//! `evaluate` compared with `solve`, and with numbers computed by hand.

use ndarray::array;
use serde_json::Value;

use crate::support::{Folder, SQUARE_OBJ, costs, stderr};

fn evaluate(folder: &Folder, arguments: &str) -> Value {
    serde_json::from_str(&folder.done(&format!("evaluate {arguments}"))).unwrap()
}

fn assert_close(a: &Value, b: f64, what: &str) {
    let a = a.as_f64().unwrap();
    assert!((a - b).abs() <= 1e-12 * b.abs().max(1.0), "{what}: {a} and {b}");
}

#[test]
fn the_energies_of_a_result_are_those_of_its_summary() {
    let folder = Folder::new();
    folder.array("S.npy", &costs(1000, 3));
    for mass in ["barycentric", "voronoi", "consistent"] {
        let problem = format!("torus:40x25 --costs S.npy --lambda 0.02 --mass {mass}");
        let answer = folder.solve(&format!("{problem} --rounding argmax --no-preview"), "out");
        let evaluation = evaluate(&folder, &format!("{problem} --u out/u.npy"));
        for key in ["energy", "rounded_energy", "lambda", "area"] {
            assert_close(&evaluation[key], answer.number(key), key);
        }
        for key in ["vertices", "faces", "regions", "mass"] {
            assert_eq!(evaluation[key], answer.summary[key], "{key}");
        }
        assert_eq!(evaluation["feasible"], true);
        assert!(evaluation["smoothed_energy"].is_null());
        assert!(evaluation["dual_bound"].as_f64().unwrap() <= answer.number("energy"));
        // Not the bound of the solver, but a bound of the same minimum.
        assert!(evaluation["dual_bound"].as_f64() <= evaluation["energy"].as_f64());
    }
}

/// Summary and evaluation state the relaxation. Its field has the bound of the solve in the same relaxation; tighter ones have
/// higher energies and bounds. Other names, and the engine that has no envelope, are refused in one line.
#[test]
fn relaxations_are_stated_and_evaluated() {
    let folder = Folder::new();
    folder.array("S.npy", &costs(1000, 6));
    let mut last = (0.0, 0.0);
    for relaxation in ["frobenius", "separate", "envelope"] {
        let problem = format!("torus:40x25 --costs S.npy --lambda 0.02 --relaxation {relaxation}");
        let options = "--gap 1e-5 --rounding argmax --save q --no-preview";
        let answer = folder.solve(&format!("{problem} {options}"), relaxation);
        assert_eq!(answer.summary["relaxation"], relaxation);
        assert_eq!(answer.summary["status"], "converged");
        let files = format!("--u {relaxation}/u.npy --q {relaxation}/q.npy");
        let evaluation = evaluate(&folder, &format!("{problem} {files}"));
        assert_eq!(evaluation["relaxation"], relaxation);
        for key in ["energy", "dual_bound", "rounded_energy"] {
            assert_close(&evaluation[key], answer.number(key), key);
        }
        // With q = 0 and without steps, the bound is the baseline; steps improve it.
        let steps = evaluate(&folder, &format!("{problem} --u {relaxation}/u.npy"));
        assert!(steps["dual_bound"].as_f64() > answer.summary["baseline"].as_f64());
        assert!(steps["dual_bound"].as_f64() <= steps["energy"].as_f64());
        assert!(answer.number("energy") > last.0 && answer.number("dual_bound") > last.1);
        last = (answer.number("energy"), answer.number("dual_bound"));
    }
    let problem = "solve torus:40x25 --costs S.npy --lambda 0.02 --out x";
    for (options, message) in [
        ("--relaxation tight", "frobenius, separate, envelope"),
        ("--relaxation envelope --precision f32", "precision=f64"),
        ("--relaxation envelope --solver-option engine=fused", "engine=auto"),
    ] {
        let output = folder.run(&format!("{problem} {options}"));
        let error = stderr(&output);
        assert!(!output.status.success() && error.contains(message), "{error}");
    }
}

/// The unit square of two triangles of area 1/2 with u_1 = x, so that the gradient of U is (1, -1) along x,
/// of norm sqrt(2): |(K U)_j| = sqrt(2) / 2 and xi_j = 4 |(K U)_j|^2 = 2 on both.
#[test]
fn smoothed_energies_agree_with_hand_computation() {
    let folder = Folder::new();
    folder.write("square.obj", SQUARE_OBJ);
    folder.array("U.npy", &array![[0.0, 1.0], [1.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    folder.array("S.npy", &array![[1.0, 2.0], [3.0, 5.0], [7.0, 11.0], [13.0, 17.0]]);
    let lambda = 0.25;
    let epsilon = 0.36_f64;
    // Vertices 0 and 2 lie in both faces: a third of 1, the others a third of 1/2.
    let barycentric = 2.0 / 3.0 + 3.0 / 6.0 + 7.0 / 3.0 + 17.0 / 6.0;
    // Right triangles: every cell is a quarter of the square.
    let voronoi = (2.0 + 3.0 + 7.0 + 17.0) / 4.0;
    // Per face A/12 (sum of s + s_k) at each corner k; the costs per face of region 1, 2 are these sums.
    let row = |s: [f64; 3], k: usize| (s.iter().sum::<f64>() + s[k]) / 24.0;
    let consistent = row([2.0, 5.0, 11.0], 0)
        + row([1.0, 3.0, 7.0], 1)
        + row([1.0, 3.0, 7.0], 2)
        + row([2.0, 11.0, 17.0], 0)
        + row([1.0, 7.0, 13.0], 1)
        + row([2.0, 11.0, 17.0], 2);
    let variation = 2.0_f64.sqrt();
    let paper = 2.0 * 0.5 * (2.0 + epsilon).sqrt();
    let intrinsic = 2.0 * 0.5 * (2.0 + epsilon).sqrt();
    for (mass, data) in
        [("barycentric", barycentric), ("voronoi", voronoi), ("consistent", consistent)]
    {
        for (mode, smoothed) in [("paper", paper), ("intrinsic", intrinsic)] {
            let evaluation = evaluate(
                &folder,
                &format!(
                    "square.obj --costs S.npy --u U.npy --lambda {lambda} --mass {mass} \
                     --epsilon {epsilon} --epsilon-mode {mode}"
                ),
            );
            assert_close(&evaluation["data_term"], data, mass);
            assert_close(&evaluation["total_variation"], variation, mass);
            assert_close(&evaluation["energy"], data + lambda * variation, mass);
            assert_close(&evaluation["rounded_energy"], data + lambda * variation, mass);
            assert_close(&evaluation["smoothed_energy"], data + lambda * smoothed, mode);
            assert_eq!(evaluation["epsilon"], epsilon);
            assert_eq!(evaluation["epsilon_mode"], mode);
        }
    }
    // A square of twice the size distinguishes the modes: gradients halve, areas are four times as large.
    folder.write("large.obj", SQUARE_OBJ.replace("v 1", "v 2").replace("1 0\n", "2 0\n"));
    let smoothed = |mode: &str| {
        let line = format!(
            "large.obj --costs S.npy --u U.npy --lambda 1 --epsilon {epsilon} --epsilon-mode {mode}"
        );
        evaluate(&folder, &line)["smoothed_energy"].clone()
    };
    // A = 2, |grad U|^2 = 1/2, xi = 4 (2 sqrt(1/2))^2 = 8.
    assert_close(&smoothed("intrinsic"), 4.0 * barycentric + 4.0 * (0.5 + epsilon).sqrt(), "large");
    assert_close(&smoothed("paper"), 4.0 * barycentric + (8.0 + epsilon).sqrt(), "large");
}

#[test]
fn an_infeasible_u_is_reported() {
    let folder = Folder::new();
    folder.write("square.obj", SQUARE_OBJ);
    folder.array("S.npy", &array![[1.0, 2.0], [3.0, 5.0], [7.0, 11.0], [13.0, 17.0]]);
    for (u, feasible) in [
        (array![[0.5, 0.5], [1.0, 0.0], [0.25, 0.75], [0.0, 1.0]], true),
        (array![[0.5, 0.5], [1.0, 1e-3], [0.25, 0.75], [0.0, 1.0]], false),
        (array![[0.5, 0.5], [1.5, -0.5], [0.25, 0.75], [0.0, 1.0]], false),
        (array![[0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]], false),
    ] {
        folder.array("U.npy", &u);
        let evaluation = evaluate(&folder, "square.obj --costs S.npy --u U.npy --lambda 0.1");
        assert_eq!(evaluation["feasible"], feasible, "{u}");
    }
    assert_eq!(
        evaluate(&folder, "square.obj --costs S.npy --u U.npy --lambda 0")["smallest_entry"],
        0.0
    );
}
