//! Experiments with class probabilities: labels of faces by us and by others, against the truth.

use std::collections::BTreeMap;
use std::path::Path;

use ndarray_npy::write_npy;

use crate::support::{Folder, costs, stderr};

const FILE: &str = r#"# Who labels faces best?

stop = { gap = 1e-3, max-iterations = 2000 }

[[instance]]
label = "teeth"
mesh = "jaw:98x24"
data = "classes"
noise = 0.5
lambda = "auto"

[[solver]]
label = "most probable"
name = "chambolle-pock"
max-iterations = 0

[[solver]]
label = "ours"
name = "chambolle-pock"
rounding = "expansion"

[[solver]]
label = "GCO"
name = "external"
command = "RUN gco"
limit = 100

[[figure]]
name = "labels"
kind = "surface"
show = ["data", "labels"]

[[table]]
name = "all"
kind = "cells"
columns = ["mislabeled", "cut-length", "regions-used", "label-excess", "rounded-gap", "label-seconds"]
"#;

/// Certified labels are right where the most probable classes are not, and a graph cut of others, certified as well,
/// costs no less than the bound.
#[test]
fn labels_of_classes_are_certified_and_right() {
    let folder = Folder::new();
    let run = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/reference/run");
    folder.write("teeth.toml", FILE.replace("RUN", run.to_str().unwrap()));
    folder.done("experiment run teeth.toml");
    folder.done("experiment report results/teeth");
    let path = folder.path("results/teeth/tables/all.csv");
    let mut csv = csv::Reader::from_path(path).unwrap();
    let rows: BTreeMap<String, Vec<f64>> = (csv.records().map(Result::unwrap))
        .map(|row| (row[1].to_owned(), row.iter().skip(2).map(|x| x.parse().unwrap()).collect()))
        .collect();
    let [noisy, ours, gco] = ["most probable", "ours", "GCO"].map(|label| &rows[label]);
    assert!(noisy[0] > 0.2 && ours[0] < 0.03 && gco[0] < 0.03, "{rows:?}");
    assert!(noisy[1] > 5.0 * ours[1], "{rows:?}");
    // Both certificates hold against both labelings.
    for labels in [ours, gco] {
        assert!(labels[3] >= 0.0 && labels[4] < 1e-2, "{rows:?}");
        assert!(labels[5] > 0.0, "{rows:?}");
    }
    assert!(ours[2] == 15.0 && ours[3] <= gco[3] + 1e-9, "{rows:?}");
    let picture = image::open(folder.path("results/teeth/figures/labels.png")).unwrap();
    assert!(picture.width() > 1000);
    let page = std::fs::read_to_string(folder.path("results/teeth/report.html")).unwrap();
    assert!(page.contains("\"certainty\""));
}

/// Class probabilities of a file, on vertices, with the lambda that `segment` chooses for them.
#[test]
fn probabilities_of_files_have_the_lambda_of_segment() {
    let folder = Folder::new();
    write_npy(folder.path("P.npy"), &costs(240, 3).mapv(|s| (-4.0 * s).exp())).unwrap();
    folder.write(
        "file.toml",
        "# A file?\n\nstop = { gap = 1e-4, max-iterations = 5000 }\n\n[[instance]]\nmesh = \"torus:20x12\"\n\
         data = \"probabilities:P.npy\"\nlambda = \"auto\"\nrelaxation = \"separate\"\n\n[[solver]]\nname = \"chambolle-pock\"\n\n\
         [[table]]\nname = \"all\"\nkind = \"cells\"\ncolumns = [\"energy\"]\n",
    );
    let output = folder.run("experiment run file.toml");
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stderr(&output).contains("P.npy: the probabilities of 240 vertices do not sum to 1"));
    folder.done("experiment report results/file");
    folder.done(
        "segment torus:20x12 --probabilities P.npy --relaxation separate --gap 1e-4 --out ours",
    );
    let path = folder.path("results/file/tables/all.csv");
    let mut csv = csv::Reader::from_path(path).unwrap();
    let energy: f64 = csv.records().next().unwrap().unwrap()[2].parse().unwrap();
    let ours = folder.answer("ours").number("energy");
    assert!((energy - ours).abs() <= 1e-5 * ours, "{energy} {ours}");
}

#[test]
fn keys_that_do_not_fit_are_refused() {
    let folder = Folder::new();
    for (from, to, message) in [
        ("noise = 0.5\n", "", "\"classes\" need noise above 0"),
        ("noise = 0.5", "noise = 0.0", "\"classes\" need noise above 0"),
        ("noise = 0.5", "noise = 0.5\nregions = 4", "15 parts of its own"),
        ("jaw:98x24", "torus:20x12", "need the key regions"),
        ("jaw:98x24", "jaw:98", "write a jaw with its cells as jaw:100x100"),
        ("noise = 0.5", "noise = 0.5\non = \"vertices\"", "probabilities of faces: leave on out"),
        ("noise = 0.5", "noise = 0.5\nmass = \"voronoi\"", "leave mass out"),
        ("noise = 0.5", "noise = 0.5\nmodel = \"l1\"", "class probabilities need no model"),
        (
            "data = \"classes\"",
            "data = \"waves\"\nregions = 4\non = \"faces\"",
            "labels of faces need data",
        ),
        (
            "data = \"classes\"\nnoise = 0.5\nlambda = \"auto\"",
            "data = \"costs:S.npy\"\nnoise = 0.5\nlambda = 0.1",
            "are taken as they are: leave noise out",
        ),
        (
            "data = \"classes\"\nnoise = 0.5",
            "data = \"probabilities:P.npy\"\nregions = 3",
            "class probabilities have one column per region",
        ),
        ("rounding = \"expansion\"", "coarse-to-fine = true", "goes from coarse to fine"),
        ("rounding = \"expansion\"", "thresholds = 5", "has thresholds"),
        ("\"data\", \"labels\"", "\"data\", \"uncertainty\"", "runs on faces keep their labels"),
        ("noise = 0.5", "noise = 0.5\nproject = \"xy\"", "leave project out"),
        ("rounding = \"expansion\"", "every = 10", "class probabilities have no parameters"),
    ] {
        let text = FILE.replacen(from, to, 1);
        assert_ne!(text, FILE, "{from}");
        folder.write("bad.toml", text);
        let output = folder.run("experiment list bad.toml");
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{to}: {said}");
        assert!(
            said.starts_with("error: bad.toml, line ") && said.contains(message),
            "{to}: {said}"
        );
    }
}
