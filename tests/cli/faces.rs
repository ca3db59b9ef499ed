//! Labels of faces for given costs: `solve`, `evaluate`, `compare`, `render` and experiments say the same of them.

use std::fs;

use ndarray::{Array1, Array2};
use ndarray_npy::{read_npy, write_npy};
use serde_json::Value;

use crate::support::{Folder, costs, names, stderr};

/// A torus of 480 faces.
const MESH: &str = "torus:20x12";

fn folder() -> Folder {
    let folder = Folder::new();
    folder.array("S.npy", &costs(480, 3));
    folder
}

fn face_labels(folder: &Folder, out: &str) -> Array1<i32> {
    read_npy(folder.path(&format!("{out}/face_labels.npy"))).unwrap()
}

fn json(folder: &Folder, line: &str) -> Value {
    let output = folder.run(line);
    assert!(output.status.success(), "{}", stderr(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The same problem by `solve`, by an experiment and, with probabilities exp(-s), by `segment` has the same labels, and
/// `evaluate` finds the energy of the solution.
#[test]
fn all_doors_lead_to_the_same_labels() {
    let folder = folder();
    let given = format!("{MESH} --costs S.npy --on faces --lambda 0.01");
    folder.done(&format!("solve {given} --gap 1e-7 --out solved"));
    let solved: Value =
        serde_json::from_slice(&fs::read(folder.path("solved/summary.json")).unwrap()).unwrap();
    assert_eq!((&solved["on"], &solved["relaxation"]), (&"faces".into(), &"separate".into()));
    let number = |value: &Value, key: &str| value[key].as_f64().unwrap();
    let u: Array2<f64> = read_npy(folder.path("solved/u.npy")).unwrap();
    assert_eq!(u.dim(), (480, 3));
    let evaluated = json(&folder, &format!("evaluate {given} --u solved/u.npy"));
    let (energy, ours) = (number(&evaluated, "energy"), number(&solved, "energy"));
    assert!((energy - ours).abs() <= 1e-12 * ours, "{energy} {ours}");

    folder.write(
        "faces.toml",
        format!(
            "# Faces?\n\nstop = {{ gap = 1e-7, max-iterations = 20000 }}\n\n[[instance]]\nmesh = \"{MESH}\"\n\
             data = \"costs:S.npy\"\non = \"faces\"\nlambda = 0.01\nnormalize = \"none\"\n\n[[solver]]\n\
             name = \"chambolle-pock\"\nrounding = \"expansion\"\n\n[[table]]\nname = \"all\"\nkind = \"cells\"\n\
             columns = [\"energy\", \"cut-length\", \"label-seconds\"]\n"
        ),
    );
    folder.done("experiment run faces.toml");
    folder.done("experiment report results/faces");
    let run = names(&folder.path("results/faces/runs")).into_iter().next().unwrap();
    let run = format!("results/faces/runs/{run}");
    let summary: Value =
        serde_json::from_slice(&fs::read(folder.path(&format!("{run}/summary.json"))).unwrap())
            .unwrap();
    for key in ["energy", "dual_bound", "rounded_energy"] {
        assert_eq!(summary[key], solved[key], "{key}");
    }
    let manifest: Value =
        serde_json::from_slice(&fs::read(folder.path(&format!("{run}/manifest.json"))).unwrap())
            .unwrap();
    // Of the edges between regions.
    let length = number(&manifest, "cut_length");
    assert!((length - number(&solved, "cut_length")).abs() <= 1e-12 * length, "{length} {solved}");
    folder.done("problem export faces.toml --out exported.npz");
    folder.done(&format!("problem export {given} --out given.npz"));
    let bytes = |name: &str| fs::read(folder.path(name)).unwrap();
    assert_eq!(bytes("exported.npz"), bytes("given.npz"));

    write_npy(folder.path("P.npy"), &costs(480, 3).mapv(|s| (-s).exp())).unwrap();
    folder.done(&format!(
        "segment {MESH} --probabilities P.npy --on faces --lambda 0.01 --gap 1e-7 --out segmented"
    ));
    let labels = face_labels(&folder, "solved");
    assert_eq!(labels, face_labels(&folder, "segmented"));

    // Labels of runs on faces are compared as such, with their areas.
    write_npy(folder.path("L.npy"), &labels).unwrap();
    let of_run = format!("{run} L.npy");
    for pair in ["solved segmented", "solved L.npy", "L.npy solved", &of_run] {
        let found = json(&folder, &format!("compare {pair} --mesh {MESH} --json"));
        assert_eq!((&found["faces"], found.get("vertices")), (&480.into(), None), "{pair}");
        assert_eq!(found["mean"]["accuracy"], 1.0, "{pair}");
    }
    let mut changed = labels.clone();
    changed[7] = (changed[7] + 1) % 3;
    write_npy(folder.path("changed.npy"), &changed).unwrap();
    let found = json(&folder, &format!("compare solved changed.npy --mesh {MESH} --json"));
    let mesh = meshseg::mesh::source(MESH).unwrap();
    let wrong = mesh.face_area(7) / mesh.area();
    let accuracy = number(&found["mean"], "accuracy");
    assert!((accuracy - (1.0 - wrong)).abs() <= 1e-12, "{accuracy} {wrong}");
    let said = folder.done(&format!("compare solved changed.npy --mesh {MESH}"));
    assert!(said.contains("on 480 faces, weighted by their areas"), "{said}");
    // Those of its vertices are there, too.
    let vertices = json(&folder, &format!("compare solved solved/labels.npy --mesh {MESH} --json"));
    assert_eq!(vertices["vertices"], 240);

    // The same picture of the run, of the experiment, and of the labels.
    for (line, out) in [
        ("solved --show labels", "a.png"),
        (&format!("{run} --show labels"), "b.png"),
        (&format!("{MESH} --labels L.npy --show labels"), "c.png"),
    ] {
        folder.done(&format!("render {line} --width 300px --out {out}"));
    }
    let picture = |name: &str| image::open(folder.path(name)).unwrap().into_rgb8();
    assert_eq!(picture("a.png"), picture("c.png"));
    assert_eq!(picture("a.png"), picture("b.png"));
    folder.done(&format!("render {run} --show data,labels --width 300px --out d.png"));
}

/// Merged vertices join faces, which keep their costs and labels.
#[test]
fn faces_are_joined_by_welding() {
    let folder = Folder::new();
    // The square of two triangles that share no vertex.
    folder.write(
        "apart.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 4 5 6\n",
    );
    folder.array("S.npy", &ndarray::array![[0.0, 1.0], [0.8, 0.0]]);
    let given = "solve apart.obj --costs S.npy --on faces --lambda 1 --no-preview";
    folder.done(&format!("{given} --out apart"));
    folder.done(&format!("{given} --weld --out joined"));
    assert_eq!(face_labels(&folder, "apart").to_vec(), [0, 1]);
    assert_eq!(face_labels(&folder, "joined").to_vec(), [0, 0]);
    let vertices: Array1<i32> = read_npy(folder.path("joined/labels.npy")).unwrap();
    assert_eq!(vertices.to_vec(), [0; 6]);
    // A seed decides for both, too.
    folder.write("seeds.csv", "face,region\n0,1\n");
    folder.done(&format!("{given} --weld --seeds seeds.csv --out seeded"));
    assert_eq!(face_labels(&folder, "seeded").to_vec(), [1, 1]);
}

#[test]
fn what_faces_do_not_have_is_refused() {
    let folder = folder();
    folder.array("V.npy", &costs(240, 3));
    for (line, message) in [
        (
            "solve {} --costs V.npy --on faces",
            "V.npy: the costs have 240 rows, but the mesh has 480 faces",
        ),
        ("solve {} --costs S.npy", "S.npy: has 480 rows, one per face: add --on faces"),
        ("solve {} --costs S.npy --on faces --mass voronoi", "another mass than barycentric"),
        ("solve {} --costs S.npy --on faces --coarse-to-fine", "from coarse to fine"),
        ("solve {} --costs S.npy --on faces --save q", "saving the dual field"),
        ("evaluate {} --costs S.npy --on faces --mass voronoi --u S.npy", "leave mass out"),
        (
            "problem export {} --costs S.npy --on faces --mass voronoi",
            "--mass: faces count with their areas",
        ),
    ] {
        let line = line.replace("{}", MESH);
        let output = folder.run(&format!(
            "{line} --lambda 0.01{}",
            match line.starts_with("evaluate") {
                true => "",
                false => " --out out",
            }
        ));
        assert_eq!(output.status.code(), Some(1), "{line}");
        assert!(stderr(&output).contains(message), "{line}: {}", stderr(&output));
        assert!(!folder.path("out").exists());
    }
}

/// A folder that is no result keeps its files, and the mesh itself is kept in any folder.
#[test]
fn files_of_others_are_kept() {
    let folder = folder();
    fs::create_dir(folder.path("mine")).unwrap();
    folder.write("mine/q.npy", "mine");
    folder.write("mine/labels.json", "mine");
    let given = "--costs S.npy --on faces --lambda 0.01 --no-preview";
    folder.done(&format!("solve {MESH} {given} --also vtp --out mine"));
    for name in ["mine/q.npy", "mine/labels.json"] {
        assert_eq!(fs::read(folder.path(name)).unwrap(), b"mine", "{name}");
    }
    folder.done(&format!("solve mine/segmented.vtp {given} --out mine"));
    assert!(folder.path("mine/segmented.vtp").exists());
    // What an earlier run wrote is removed.
    folder.done(&format!("solve {MESH} {given} --out mine"));
    assert!(!folder.path("mine/segmented.vtp").exists());
}
