//! Experiments that estimate region parameters: starts, baselines, truths, scores, and figures of surfaces.

use std::collections::BTreeMap;

use ndarray::Array1;
use ndarray_npy::{read_npy, write_npy};
use serde_json::Value;

use super::outcomes;
use crate::support::{Folder, stderr};

const FILE: &str = r#"# Does the start matter?

stop = { gap = 1e-5, max-iterations = 3000 }

[[instance]]
label = "torus"
mesh = "torus:60x40"
data = "waves"
noise = 0.3
regions = 4
lambda = 0.004

[[solver]]
label = "k-means"
name = "kmeans"

[[solver]]
label = "fixed"
name = "chambolle-pock"

[[solver]]
label = "from"
name = "chambolle-pock"
every = 10
init = ["kmeans", "slabs", "opposite-slabs"]

[[solver]]
label = "start"
name = "chambolle-pock"
every = 10
init = "slabs"
max-iterations = 0

[[figure]]
name = "surfaces"
kind = "surface"
show = ["data", "labels"]
views = ["front", "back"]

[[table]]
name = "all"
kind = "cells"
columns = ["init", "excess", "labels-changed", "mislabeled", "rand-index", "binary", "cut-length", "parameters"]
"#;

/// The rows of a table by the label of the solver.
fn rows(folder: &Folder, experiment: &str) -> BTreeMap<String, Vec<String>> {
    let path = folder.path(&format!("results/{experiment}/tables/all.csv"));
    let mut csv = csv::Reader::from_path(path).unwrap();
    let rows = csv.records().map(|record| record.unwrap());
    rows.map(|row| (row[1].to_owned(), row.iter().skip(2).map(str::to_owned).collect())).collect()
}

fn number(text: &str) -> f64 {
    text.parse().unwrap()
}

/// The baselines and the estimation are those of `segment`; runs with parameters of their own are compared with the best
/// of them, under the best matching of their regions.
#[test]
fn parameters_are_estimated_from_several_starts() {
    let folder = Folder::new();
    folder.write("starts.toml", FILE);
    folder.done("experiment run starts.toml");
    folder.done("experiment report results/starts");
    let rows = rows(&folder, "starts");
    assert_eq!(rows.len(), 6);
    let of = |label: &str, column: usize| rows[label][column].as_str();
    // k-means ignores cuts and is mostly wrong; all starts end in the same labels, whatever their regions are called.
    assert!(number(of("k-means", 3)) > 0.15);
    for init in ["kmeans", "slabs", "opposite-slabs"] {
        let label = format!("from, init {init}");
        assert_eq!(of(&label, 0), init);
        assert!(number(of(&label, 1)) < 1e-4, "{rows:?}");
        assert!(number(of(&label, 2)) < 1e-3 && number(of(&label, 3)) < 0.03, "{rows:?}");
        assert!(number(of(&label, 4)) > 0.97, "{rows:?}");
        assert_eq!(of(&label, 7).split(" / ").count(), 4);
    }
    assert!(number(of("k-means", 6)) > 2.0 * number(of("from, init slabs", 6)), "{rows:?}");
    // Fixed costs have a bound of their own, and no parameters.
    assert_eq!(of("fixed", 7), "");
    assert!(number(of("fixed", 4)) > 0.97, "{rows:?}");
    // The start itself: four slabs of labels.
    assert_eq!(of("start", 5), "1");

    let figures = folder.path("results/starts/figures");
    let page = std::fs::read_to_string(figures.join("surfaces.html")).unwrap();
    assert!(page.contains("\"row_headings\":") && page.len() < 2_000_000, "{}", page.len());
    let picture = image::open(figures.join("surfaces.png")).unwrap();
    assert_eq!(picture.width(), 2008);
    let sources: Value =
        serde_json::from_slice(&std::fs::read(figures.join("surfaces.runs.json")).unwrap())
            .unwrap();
    assert_eq!(sources["runs"].as_array().unwrap().len(), 6);
    let page = std::fs::read_to_string(folder.path("results/starts/report.html")).unwrap();
    assert!(page.contains("data:image/png;base64,"));

    // Without the labels of a run the picture stays as it is.
    let labels: Vec<_> = glob(&folder, "results/starts/runs", "labels.npy");
    std::fs::remove_file(&labels[0]).unwrap();
    let before = std::fs::read(figures.join("surfaces.png")).unwrap();
    let said = stderr(&folder.run("experiment report results/starts"));
    assert!(said.contains("surfaces.png is unchanged"), "{said}");
    assert_eq!(std::fs::read(figures.join("surfaces.png")).unwrap(), before);
}

/// The files of this name in the folders of a folder.
fn glob(folder: &Folder, of: &str, name: &str) -> Vec<std::path::PathBuf> {
    let folders = std::fs::read_dir(folder.path(of)).unwrap().map(|entry| entry.unwrap().path());
    folders.map(|path| path.join(name)).filter(|path| path.exists()).collect()
}

/// The estimation of an experiment is that of `segment` with the same lambda.
#[test]
fn an_estimation_is_that_of_segment() {
    let folder = Folder::new();
    let file = "stop = { gap = 1e-4 }\n[[instance]]\nmesh = \"torus:40x24\"\ndata = \"data.npy\"\nmodel = \"gaussian\"\n\
                truth = \"truth.npy\"\nregions = 2\nlambda = 0.02\n[[solver]]\nname = \"chambolle-pock\"\nevery = 10\n";
    // Equal means, different spreads.
    let mut state = 7_u64;
    let mut uniform = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as f64 / (1_u64 << 31) as f64
    };
    let truth = Array1::from_shape_fn(960, |k| i32::from(k >= 480));
    let data = truth.mapv(|p| (uniform() + uniform() - 1.0) * if p == 0 { 0.2 } else { 2.0 });
    write_npy(folder.path("data.npy"), &data).unwrap();
    write_npy(folder.path("truth.npy"), &truth).unwrap();
    folder.write("e.toml", file);
    folder.done("experiment run e.toml");
    let segment = "segment torus:40x24 --data data.npy --model gaussian --regions 2 --lambda 0.02 --rounding argmax --no-preview --out s";
    folder.done(segment);
    let answer = folder.answer("s");
    let runs = outcomes(&folder.path("results/e"));
    let id = runs.first_key_value().unwrap().0;
    let read = |name: &str| -> Value {
        let path = folder.path(&format!("results/e/runs/{id}/{name}"));
        serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
    };
    assert_eq!(read("summary.json")["energy"], answer.summary["energy"]);
    let manifest = read("manifest.json");
    assert!(manifest["mislabeled"].as_f64().unwrap() < 0.03, "{manifest}");
    // The scores are those of `compare`.
    let output = folder.run("compare s truth.npy --mesh torus:40x24 --json");
    let compared: Value = serde_json::from_slice(&output.stdout).unwrap();
    for (own, other) in [
        ("rand_index", "rand_index"),
        ("variation_of_information", "variation_of_information"),
        ("covering", "covering"),
    ] {
        let [own, other] = [&manifest["scores"][own], &compared["mean"][other]]
            .map(|number| number.as_f64().unwrap());
        assert!((own - other).abs() <= 1e-12, "{own} {other}");
    }
    let labels: Array1<u8> =
        read_npy(folder.path(&format!("results/e/runs/{id}/labels.npy"))).unwrap();
    assert!(labels.iter().zip(&answer.labels).all(|(&a, &b)| i32::from(a) == b));
}

#[test]
fn impossible_estimations_are_refused_at_their_positions() {
    let folder = Folder::new();
    for (from, to, message) in [
        ("every = 10\ninit = [", "init = [", "a start needs every = STEPS"),
        ("name = \"kmeans\"", "name = \"kmeans\"\nevery = 10", "kmeans estimates no parameters"),
        (
            "name = \"kmeans\"",
            "name = \"kmeans\"\noptions = { rho = 1.5 }",
            "kmeans has no options",
        ),
        ("name = \"kmeans\"", "name = \"kmeens\"", "did you mean \"kmeans\""),
        ("init = \"slabs\"", "init = \"slab\"", "did you mean \"slabs\""),
        ("every = 10", "every = 0", "every must be a whole number, 1 or more"),
        ("regions = 4", "regions = 4\nmodel = \"gauss\"", "did you mean \"gaussian\""),
        (
            "regions = 4",
            "regions = 4\ntruth = \"labels.txt\"",
            "truth must be \"FILE.npy\" or \"FILE.mat\"",
        ),
        ("regions = 4", "regions = 4\nproject = \"xx\"", "project must be"),
        (
            "data = \"waves\"\nnoise = 0.3\nregions = 4",
            "data = \"costs:c.npy\"",
            "costs have no parameters",
        ),
        ("show = [\"data\", \"labels\"]", "", "a figure of surfaces needs show"),
        ("\"labels\"]", "\"u:0\"]", "runs keep U for two regions only"),
        ("regions = 4", "regions = 4\nmodel = \"l1\"", "is scored by the model constant"),
        ("name = \"kmeans\"", "name = \"kmeans\"\nthresholds = 5", "without every"),
        ("\"labels\"]", "\"label\"]", "show must be"),
        ("\"back\"]", "\"behind\"]", "views must be"),
    ] {
        let text = FILE.replacen(from, to, 1);
        assert_ne!(text, FILE, "{from}");
        folder.write("bad.toml", text);
        let output = folder.run("experiment list bad.toml");
        assert_eq!(output.status.code(), Some(1), "{to}");
        let said = stderr(&output);
        assert!(said.starts_with("error: bad.toml, line "), "{to}: {said}");
        assert!(said.contains(message), "{to}: {said}");
    }
}

/// Waves that are photographed are found again: by both models, from pixels and from vertices, in the light only by the
/// model albedo.
#[test]
fn photographs_of_waves_are_segmented() {
    let folder = Folder::new();
    let text = r#"# Do photographs show the waves?

stop = { gap = 1e-3, max-iterations = 3000 }

[[instance]]
label = "flat"
mesh = "torus:60x40"
data = "photographs:8:160x120"
sampling = ["pixels", "vertices"]
noise = 0.1
regions = 4
lambda = 0.0003

[[instance]]
label = "lit"
mesh = "torus:60x40"
data = "photographs:8:160x120"
model = ["constant", "albedo"]
light = "1,1,2"
ambient = 0.3
noise = 0.05
regions = 4
lambda = 0.0003

[[solver]]
label = "from"
name = "chambolle-pock"
every = 10

[[table]]
name = "all"
kind = "cells"
columns = ["mislabeled"]
"#;
    folder.write("views.toml", text);
    folder.done("experiment run views.toml");
    folder.done("experiment report results/views");
    let path = folder.path("results/views/tables/all.csv");
    let mut csv = csv::Reader::from_path(path).unwrap();
    let wrong: BTreeMap<String, f64> = csv
        .records()
        .map(|row| row.unwrap())
        .map(|row| (row[0].to_owned(), number(&row[2])))
        .collect();
    let of = |label: &str| wrong[label];
    assert!(of("flat, sampling pixels") < 0.02, "{wrong:?}");
    assert!(of("flat, sampling vertices") < 0.03, "{wrong:?}");
    assert!(of("lit, model albedo") < 0.03, "{wrong:?}");
    assert!(of("lit, model constant") > 0.2, "{wrong:?}");
}

/// Data of views are those of `segment`, and a run belongs to the content of every image.
#[test]
fn views_are_those_of_segment() {
    let folder = Folder::new();
    let truth = Array1::from_shape_fn(1000, |k| i32::from(k >= 500));
    write_npy(folder.path("L.npy"), &truth).unwrap();
    let line = "render torus:40x25 --labels L.npy --views sphere:8:80x60 --noise 0.1 --out";
    folder.done(&format!("{line} p"));
    std::fs::create_dir(folder.path("cameras")).unwrap();
    std::fs::rename(folder.path("p/views.toml"), folder.path("cameras/v.toml")).unwrap();
    let file = "stop = { gap = 1e-4 }\n[[instance]]\nmesh = \"torus:40x25\"\ndata = \"views:cameras/v.toml\"\n\
                images = \"p\"\npure = 2\ntruth = \"L.npy\"\nregions = 2\nlambda = 0.02\nnormalize = \"area\"\n\
                [[solver]]\nname = \"chambolle-pock\"\nevery = 10\n[[table]]\nname = \"all\"\nkind = \"cells\"\n\
                columns = [\"mislabeled\"]\n";
    folder.write("e.toml", file);
    folder.done("experiment run e.toml");
    folder.done(
        "segment torus:40x25 --data views:cameras/v.toml --images p --pure 2 --regions 2 --lambda 0.02 \
         --rounding argmax --no-preview --out s",
    );
    let labels = glob(&folder, "results/e/runs", "labels.npy");
    let [of_run] = &labels[..] else { panic!("{labels:?}") };
    let of_run: Array1<u8> = read_npy(of_run).unwrap();
    let of_segment = folder.answer("s").labels;
    assert!(of_run.iter().zip(&of_segment).all(|(&a, &b)| i32::from(a) == b));
    folder.done("experiment report results/e");
    let mislabeled = number(&rows(&folder, "e").into_values().next().unwrap()[0]);
    assert!(mislabeled < 0.01, "{mislabeled}");

    // Nothing is left to run, until one pixel of one image differs.
    let again = folder.done("experiment run e.toml");
    assert_eq!(glob(&folder, "results/e/runs", "labels.npy").len(), 1, "{again}");
    let path = folder.path("p/view-005.png");
    let mut image = image::open(&path).unwrap().into_rgb8();
    image.put_pixel(0, 0, image::Rgb([1, 2, 3]));
    image.save(&path).unwrap();
    folder.done("experiment run e.toml");
    assert_eq!(glob(&folder, "results/e/runs", "labels.npy").len(), 2);

    std::fs::remove_file(&path).unwrap();
    let said = stderr(&folder.run("experiment run e.toml"));
    assert!(said.contains("view-005.png") && said.contains("does not exist"), "{said}");
}
