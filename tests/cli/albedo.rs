//! `segment --model albedo`: regions of a lit surface.

use ndarray::{Array1, Array2};
use ndarray_npy::{read_npy, write_npy};

use crate::support::{Folder, stderr};

const RHO: [[f64; 3]; 2] = [[0.8, 0.3, 0.2], [0.2, 0.4, 0.9]];

/// A unit sphere in two halves, x < 0 and x > 0, lit from (0, 0.6, 0.8) with ambient light 0.2.
fn lit_sphere() -> (Folder, Vec<bool>) {
    let folder = Folder::new();
    folder.done("mesh generate sphere:4 --out sphere.off");
    let text = std::fs::read_to_string(folder.path("sphere.off")).unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    let n: usize = lines.next().unwrap().split_whitespace().next().unwrap().parse().unwrap();
    let mut colors = Array2::zeros((n, 3));
    let mut right = Vec::new();
    for (k, line) in lines.take(n).enumerate() {
        let x: Vec<f64> = line.split_whitespace().map(|x| x.parse().unwrap()).collect();
        // The normal of a sphere is its position.
        let h = 0.2 + (0.6 * x[1] + 0.8 * x[2]).max(0.0);
        right.push(x[0] > 0.0);
        for i in 0..3 {
            colors[[k, i]] = h * RHO[usize::from(x[0] > 0.0)][i];
        }
    }
    write_npy(folder.path("colors.npy"), &colors).unwrap();
    (folder, right)
}

fn wrong(folder: &Folder, out: &str, right: &[bool]) -> usize {
    let labels: Array1<i32> = read_npy(folder.path(out).join("labels.npy")).unwrap();
    let agree = labels.iter().zip(right).filter(|(p, right)| (**p == 1) == **right).count();
    agree.min(right.len() - agree)
}

#[test]
fn regions_and_light_of_a_lit_sphere_are_found() {
    let (folder, right) = lit_sphere();
    let line = "segment sphere.off --data colors.npy --regions 2 --lambda 0.001 --no-preview";
    folder.done(&format!("{line} --out radiance"));
    assert!(wrong(&folder, "radiance", &right) > right.len() / 10);
    let printed = folder.done(&format!("{line} --model albedo --out albedo"));
    // The cut runs along vertices on x = 0.
    assert!(wrong(&folder, "albedo", &right) <= 40);
    assert!(printed.contains("ambient light 0.2"), "{printed}");
    let answer = folder.answer("albedo");
    assert_eq!(answer.summary["model"], "albedo");
    assert!(answer.number("relative_gap") <= 1e-4);
    let regions = answer.summary["region_parameters"].as_array().unwrap();
    let near = |found: &serde_json::Value, expected: f64| {
        assert!((found.as_f64().unwrap() - expected).abs() < 0.02, "{found} {expected}");
    };
    for region in regions {
        [0.0, 0.6, 0.8].iter().enumerate().for_each(|(i, x)| near(&region["light"][i], *x));
        near(&region["ambient"], 0.2);
    }
    let first = usize::from(regions[0]["albedo"][0].as_f64().unwrap() < 0.5);
    for (p, rho) in [first, 1 - first].into_iter().zip(RHO) {
        rho.iter().enumerate().for_each(|(i, x)| near(&regions[p]["albedo"][i], *x));
    }

    // The parameters of a run, and a light that is given.
    folder.done(
        "segment sphere.off --data colors.npy --means albedo/summary.json --lambda 0.001 --no-preview --out given",
    );
    assert_eq!(folder.answer("given").summary["model"], "albedo");
    assert!(wrong(&folder, "given", &right) <= 40);
    folder.done(&format!("{line} --model albedo --light 0,3,4 --ambient 0.2 --out known"));
    let known = folder.answer("known").summary["region_parameters"][0].clone();
    assert_eq!((&known["light"][1], &known["ambient"]), (&0.6.into(), &0.2.into()));
    assert!(wrong(&folder, "known", &right) <= 40);
}

#[test]
fn impossible_lights_are_refused() {
    let (folder, _) = lit_sphere();
    write_npy(folder.path("dark.npy"), &Array2::<f64>::zeros((2562, 3))).unwrap();
    let line = "segment sphere.off --data colors.npy --regions 2 --no-preview --out r";
    for (options, clause) in [
        ("--light 0,0,1", "--light needs --model albedo"),
        ("--ambient 0.1 --model l1", "--ambient needs --model albedo"),
        ("--model albedo --light 0,0,0", "not all 0"),
        ("--model albedo --light 1,2", "three numbers"),
        ("--model albedo --light 1,2,inf", "three numbers"),
        ("--model albedo --ambient -0.1", "at least 0"),
        ("--model albedo --ambient nan", "at least 0"),
        ("--model albedo --data dark.npy", "no datum is above 0"),
    ] {
        let line = match options.contains("--data") {
            true => line.replace("--data colors.npy ", ""),
            false => line.to_owned(),
        };
        let before = folder.listing();
        let output = folder.run(&format!("{line} {options}"));
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{options}: {message}");
        assert_eq!(message.lines().count(), 1, "{options}: {message}");
        assert!(message.contains(clause), "{options}: {message}");
        assert_eq!(folder.listing(), before);
    }
}
