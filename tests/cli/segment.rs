//! `segment`: from a mesh with its data to a results folder.

use std::fs;

use meshseg::colormap::categorical;
use meshseg::mesh::io;

use crate::support::{Answer, Folder, names, stderr};

const FILES: [&str; 6] =
    ["labels.npy", "preview.png", "segmented.ply", "summary.json", "trace.csv", "u.npy"];

#[test]
fn spot_in_three_regions() {
    let folder = Folder::new();
    let output = folder.run("segment builtin:spot --regions 3 --out spot");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stderr(&output).contains("to total area 1"));
    assert!(String::from_utf8(output.stdout).unwrap().contains("converged"));
    assert_eq!(names(&folder.path("")), ["spot".to_owned()].into());
    assert_eq!(names(&folder.path("spot")), FILES.map(String::from).into());

    let answer = folder.answer("spot");
    answer.assert_consistent();
    assert_eq!(answer.u.dim(), (46_850, 3));
    assert_eq!(answer.status(), "converged");
    assert!(answer.number("relative_gap") <= 1e-4);
    assert_eq!(
        answer.header,
        ["iteration", "seconds", "energy", "dual_bound", "gap", "relative_gap", "change"]
    );
    // The parameters, and thus the problem, are fixed after the last re-estimation.
    let fixed = answer.number("re_estimations") * answer.number("every");
    let iterations = answer.column("iteration");
    let first = iterations.iter().position(|&iteration| iteration == Some(fixed)).unwrap();
    answer.assert_monotone_from(first);
    assert!(iterations.windows(2).all(|pair| pair[0] < pair[1]));

    summary_has_every_key(&answer.summary);
    let shares = answer.summary["region_parameters"].as_array().unwrap().iter();
    let whole: f64 = shares.map(|region| region["share"].as_f64().unwrap()).sum();
    assert!((whole - 1.0).abs() < 1e-12);

    let image = image::open(folder.path("spot/preview.png")).unwrap();
    // Two views of the data and two of the regions, side by side or stacked.
    let size = (image.width(), image.height());
    assert!((700..=1600).contains(&size.0) && (500..=1200).contains(&size.1), "{size:?}");
    assert_ply_has_labels(&folder, &answer);
}

fn summary_has_every_key(summary: &serde_json::Value) {
    for key in ["solver", "status", "status_sentence", "mass", "data", "model", "init", "normalize"]
    {
        assert!(summary[key].is_string(), "{key}");
    }
    for key in ["iterations", "vertices", "faces", "regions", "seed", "every", "re_estimations"] {
        assert!(summary[key].is_u64(), "{key}");
    }
    for key in [
        "seconds",
        "energy",
        "dual_bound",
        "gap",
        "relative_gap",
        "rounded_energy",
        "rounded_relative_gap",
        "lambda",
        "area",
        "scale",
    ] {
        assert!(summary[key].is_f64(), "{key}");
    }
    assert!(summary["warnings"].is_array() && summary["solver_options"].is_object());
    assert!(summary["data_unit_range"].is_null());
    let regions = summary["region_parameters"].as_array().unwrap();
    assert_eq!(regions.len(), 3);
    for region in regions {
        assert_eq!(region["mean"].as_array().unwrap().len(), 3);
        assert_eq!(region["color"].as_array().unwrap().len(), 3);
        assert_eq!(region["palette"].as_array().unwrap().len(), 3);
        assert!(region["area"].is_f64() && region["share"].is_f64());
    }
}

/// Each vertex has three doubles and four bytes, the last of which is the label.
fn assert_ply_has_labels(folder: &Folder, answer: &Answer) {
    const END: &[u8] = b"end_header\n";
    let path = folder.path("spot/segmented.ply");
    let bytes = fs::read(&path).unwrap();
    let end = bytes.windows(END.len()).position(|window| window == END).unwrap() + END.len();
    let header = std::str::from_utf8(&bytes[..end]).unwrap();
    assert!(header.contains("property uchar label\nelement face"), "{header}");
    for (vertex, &label) in bytes[end..].chunks(3 * 8 + 4).zip(&answer.labels) {
        assert_eq!(i32::from(vertex[27]), label);
    }
    let mesh = io::read(&path).unwrap();
    assert_eq!((mesh.vertices.len(), mesh.faces.len()), (46_850, 93_696));
    assert!(mesh.uv.is_some());
    // The colors are those of the picture, so that regions with equal means differ.
    for (color, &label) in mesh.colors.unwrap().iter().zip(&answer.labels) {
        let byte = |c: f64| (255.0 * c).round() as u8;
        assert_eq!(color.map(byte), categorical(label as usize).map(byte));
    }
}

#[test]
fn the_same_bytes_with_one_and_two_threads() {
    let folder = Folder::new();
    for flag in ["", "--coarse-to-fine"] {
        for threads in [1, 2] {
            folder.done(&format!(
                "segment builtin:spot --regions 3 --gap 1e-3 --no-preview --threads {threads} --out {threads} {flag}"
            ));
        }
        assert!(!folder.path("1/preview.png").exists());
        for name in ["u.npy", "labels.npy", "segmented.ply"] {
            let [one, two] = ["1", "2"].map(|n| fs::read(folder.path(n).join(name)).unwrap());
            assert_eq!(one, two, "{name}");
        }
    }
}

/// Without `--relaxation`, labels of more than two regions have the one with the tightest bound for them; the relaxations of two
/// regions are the same.
#[test]
fn the_relaxation_that_certifies_labels_best() {
    let folder = Folder::new();
    let found = |regions: usize, flags: &str| {
        let line = format!("segment torus:40x25 --data curvature --regions {regions} {flags}");
        let output = folder.run(&format!("{line} --lambda 0.002 --no-preview --out out"));
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        (String::from_utf8(output.stdout).unwrap(), folder.answer("out"))
    };
    let name = |answer: &Answer| answer.summary["relaxation"].as_str().unwrap().to_owned();
    let labels = |answer: &Answer| answer.number("rounded_relative_gap");
    let [(text, default), (given, of_paper)] =
        ["", "--relaxation frobenius"].map(|flags| found(4, flags));
    assert_eq!([name(&default), name(&of_paper)], ["separate", "frobenius"]);
    assert!(
        text.contains("separate, which certifies labels of more than two regions best"),
        "{text}"
    );
    assert!(!given.contains("relaxation"), "{given}");
    assert!(labels(&default) < labels(&of_paper));
    let [(text, default), (_, separate)] =
        ["", "--relaxation separate"].map(|flags| found(2, flags));
    assert_eq!([name(&default), name(&separate)], ["frobenius", "separate"]);
    assert!(text.contains("frobenius, all relaxations are the same for two regions"), "{text}");
    let energies = [&default, &separate].map(|answer| answer.number("energy"));
    assert!((energies[0] - energies[1]).abs() <= 1e-4 * energies[0], "{energies:?}");
}

/// Coarse meshes provide the parameters, so that the finest mesh re-estimates them less often.
#[test]
fn coarse_to_fine() {
    let folder = Folder::new();
    let [without, with] = ["", "--coarse-to-fine"].map(|flag| {
        folder.done(&format!("segment builtin:spot --regions 3 --no-preview --out out {flag}"));
        folder.answer("out")
    });
    with.assert_consistent();
    assert_eq!(with.status(), "converged");
    assert!(with.number("re_estimations") < without.number("re_estimations"));
    // The alternation has many local minima; this one differs, but is not worse.
    assert!(with.number("energy") <= (1.0 + 1e-3) * without.number("energy"));
    assert!(with.summary["coarse_to_fine"]["levels"].as_array().unwrap().len() >= 3);
}

/// A segmentation, bitwise equal for one and two threads, whose table names one kind of parameter and not the other.
fn by_model(folder: &Folder, line: &str, named: &str, other: &str) -> Answer {
    for threads in [1, 2] {
        let output = folder.run(&format!("{line} --threads {threads} --out {threads}"));
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        let text = String::from_utf8(output.stdout).unwrap();
        let (_, table) = text.split_once("\nregion ").unwrap();
        assert!(table.contains(named) && !table.contains(other), "{text}");
    }
    let [one, two] = ["1", "2"].map(|n| fs::read(folder.path(n).join("u.npy")).unwrap());
    assert_eq!(one, two, "{line}");
    let answer = folder.answer("1");
    answer.assert_consistent();
    answer
}

/// Medians instead of means, in the summary and on the screen, for any start.
#[test]
fn regions_have_medians() {
    let folder = Folder::new();
    let line = "segment torus:40x25 --data curvature --regions 3 --model l1 --no-preview";
    for flags in ["", "--coarse-to-fine", "--init random --seed 3", "--mass consistent"] {
        let answer = by_model(&folder, &format!("{line} {flags}"), "median", " mean");
        assert_eq!((answer.status(), answer.summary["model"].as_str()), ("converged", Some("l1")));
        for region in answer.summary["region_parameters"].as_array().unwrap() {
            let median = region["median"].as_array().unwrap();
            assert!(median.len() == 1 && region["mean"].is_null(), "{region}");
            assert!((0.0..=1.0).contains(&median[0].as_f64().unwrap()));
        }
    }
}

/// Means and covariances in the summary, means on the screen, from any start and on any machine the same.
#[test]
fn regions_have_covariances() {
    let folder = Folder::new();
    folder.array("d.npy", &crate::support::costs(1000, 2));
    folder.array("wide.npy", &crate::support::costs(1000, 17));
    let line = "segment torus:40x25 --data d.npy --regions 3 --model gaussian --no-preview";
    for flags in ["", "--coarse-to-fine", "--init random --seed 3", "--mass consistent"] {
        let answer = by_model(&folder, &format!("{line} {flags}"), " mean", "median");
        let model = answer.summary["model"].as_str();
        assert_eq!((answer.status(), model), ("converged", Some("gaussian")));
        for region in answer.summary["region_parameters"].as_array().unwrap() {
            assert_eq!(region["mean"].as_array().unwrap().len(), 2, "{region}");
            let entry = |i: usize, j: usize| region["covariance"][i][j].as_f64().unwrap();
            assert_eq!(entry(0, 1), entry(1, 0));
            assert!(entry(0, 0) > 0.0 && entry(0, 0) * entry(1, 1) > entry(0, 1).powi(2));
        }
    }
    let output = folder.run(&line.replace("d.npy", "wide.npy --out wide"));
    let message = stderr(&output);
    assert_eq!((output.status.code(), message.lines().count()), (Some(1), 1), "{message}");
    assert!(message.contains("wide.npy") && message.contains("at most 16"), "{message}");
}

#[test]
fn the_same_bytes_for_the_same_seed() {
    let folder = Folder::new();
    for (seed, out) in [(7, "a"), (7, "b")] {
        folder.done(&format!(
            "segment sphere:4 --data curvature --regions 4 --init random --seed {seed} --gap 1e-2 \
             --max-iterations 200 --no-preview --out {out}"
        ));
    }
    let [a, b] = ["a/u.npy", "b/u.npy"].map(|name| fs::read(folder.path(name)).unwrap());
    assert_eq!(a, b);
}

#[test]
fn data_of_every_kind() {
    let folder = Folder::new();
    folder.array("d.npy", &crate::support::costs(36, 2));
    folder.write(
        "colored.off",
        "COFF\n4 2 0\n0 0 0 255 0 0\n1 0 0 255 0 0\n1 1 0 0 0 255\n0 1 0 0 0 255\n3 0 1 2\n3 0 2 3\n",
    );
    folder.write(
        "textured.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n",
    );
    image::RgbImage::from_fn(2, 2, |x, _| image::Rgb([if x == 0 { 255 } else { 0 }; 3]))
        .save(folder.path("texture.png"))
        .unwrap();
    for (arguments, data) in [
        ("grid:5x5 --data d.npy", "d.npy"),
        ("grid:5x5 --data d.npy --normalize none --lambda 0.01", "d.npy"),
        ("grid:5x5 --data curvature", "mean curvature"),
        ("sphere:2 --data curvature:gaussian", "Gaussian curvature"),
        ("colored.off", "colors"),
        ("colored.off --data colors --mass voronoi", "colors"),
        ("textured.obj --data texture:texture.png --mass consistent", "texture texture.png"),
    ] {
        folder.done(&format!("segment {arguments} --regions 2 --out out"));
        let answer = folder.answer("out");
        answer.assert_consistent();
        let named = answer.summary["data"].as_str().unwrap();
        assert_eq!(named, data, "{arguments}");
    }
}
