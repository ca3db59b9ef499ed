//! External solvers: their input, their output, and the agreement of their results with those of the built-in solvers.

use std::fs;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use meshseg::Mesh;
use meshseg::field::{Row, Tangent};
use meshseg::mesh::io;
use meshseg::operator::{Adjoint, Operator, Stencil};
use meshseg::problem::{Problem, Smoothing, SmoothingMode};
use meshseg::prox::{project_ball, project_simplex};
use nalgebra::Vector3;
use ndarray::{Array0, Array2, arr0};
use ndarray_npy::{NpzReader, read_npy, write_npy};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde_json::Value;

use crate::support::{Folder, PROGRAM, names, stderr};

const M: usize = 4;

/// A torus with displaced vertices, random costs, and a random U in the simplex.
fn folder() -> (Folder, Mesh) {
    let folder = Folder::new();
    let mut rng = Pcg64::seed_from_u64(91);
    let mut mesh = "torus:14x9".parse::<meshseg::mesh::Shape>().unwrap().mesh();
    for x in &mut mesh.vertices {
        *x += Vector3::from_fn(|_, _| rng.random_range(-0.02..0.02));
    }
    io::write(&folder.path("mesh.ply"), &mesh).unwrap();
    // The mesh as it is read: coordinates in the file may have fewer digits.
    let mesh = meshseg::mesh::source(folder.path("mesh.ply")).unwrap();
    let n = mesh.vertices.len();
    let costs = Array2::from_shape_simple_fn((n, M), || rng.random_range(-0.2..1.0));
    folder.array("S.npy", &costs);
    let mut u = Array2::from_shape_simple_fn((n, M), || -rng.random_range(1e-3..1.0_f64).ln());
    for mut row in u.outer_iter_mut() {
        row /= row.sum();
    }
    folder.array("u.npy", &u);
    (folder, mesh)
}

const GIVEN: &str = "mesh.ply --costs S.npy --lambda 0.02";

pub fn reference(words: &[&str]) -> Command {
    let run = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/reference/run");
    let mut command = Command::new(run);
    command.args(words);
    command
}

pub fn succeeded(mut command: Command) -> String {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    assert!(output.status.success(), "{command:?}\n{}", stderr(&output));
    String::from_utf8(output.stdout).unwrap()
}

fn rows(array: &Array2<f64>) -> Vec<Row<M>> {
    array.outer_iter().map(|row| Row::from_fn(|p| row[p])).collect()
}

/// Compares jax.grad, NumPy with the exported matrices, and the projection of jaxopt with the operations of the
/// solvers.
#[test]
fn python_finds_the_same_gradients_energies_and_projections() {
    let (folder, mesh) = folder();
    folder.done(&format!("problem export {GIVEN} --out problem.npz"));
    let mut npz = NpzReader::new(fs::File::open(folder.path("problem.npz")).unwrap()).unwrap();
    let f = rows(&npz.by_name::<ndarray::OwnedRepr<f64>, ndarray::Ix2>("f").unwrap());
    let lambda = 0.02;
    let problem = Problem::new(Stencil::new(&mesh), f.clone(), lambda);
    let k = &problem.k;
    let u = rows(&read_npy(folder.path("u.npy")).unwrap());

    let mut energies = serde_json::Map::new();
    for (name, mode, epsilon) in
        [("paper", SmoothingMode::Paper, 1e-4), ("intrinsic", SmoothingMode::Intrinsic, 1e-2)]
    {
        let smoothing = Smoothing::new(mode, epsilon).unwrap();
        let mut q = vec![Tangent::<M>::ZERO; k.faces()];
        problem.smoothed_dual(&u, smoothing, &mut q);
        let gradient =
            Array2::from_shape_fn((f.len(), M), |(v, p)| (f[v] + k.adjoint().at(&q, v)).0[p]);
        folder.array(&format!("gradient_{name}.npy"), &gradient);
        write_npy(folder.path(&format!("epsilon_{name}.npy")), &arr0(epsilon)).unwrap();
        let line = format!("evaluate {GIVEN} --u u.npy --epsilon {epsilon} --epsilon-mode {name}");
        let evaluation: Value = serde_json::from_str(&folder.done(&line)).unwrap();
        energies.insert(format!("smoothed_{name}"), evaluation["smoothed_energy"].clone());
        energies.insert("energy".into(), evaluation["energy"].clone());
        if mode == SmoothingMode::Intrinsic {
            let bound = problem.baseline + problem.dual_bound(&q);
            energies.insert("dual_bound".into(), bound.into());
            let rows = Array2::from_shape_fn((2 * q.len(), M), |(i, p)| {
                project_ball(q[i / 2], lambda).0[i % 2].0[p]
            });
            folder.array("q.npy", &rows);
        }
    }
    folder.write("energies.json", serde_json::to_string(&energies).unwrap());
    let mut rng = Pcg64::seed_from_u64(92);
    let outside = Array2::from_shape_simple_fn((500, M), || rng.random_range(-2.0..2.0_f64));
    let inside: Vec<Row<M>> = rows(&outside).into_iter().map(project_simplex).collect();
    folder.array("project_in.npy", &outside);
    folder.array(
        "project_out.npy",
        &Array2::from_shape_fn((inside.len(), M), |(i, p)| inside[i].0[p]),
    );

    let path = |name: &str| folder.path(name).display().to_string();
    let printed = succeeded(reference(&["check", &path("problem.npz"), &path("")]));
    let differences: serde_json::Map<String, Value> = serde_json::from_str(&printed).unwrap();
    let expected = [
        "gradient_paper",
        "gradient_intrinsic",
        "energy",
        "smoothed_paper",
        "smoothed_intrinsic",
        "dual_bound",
        "projection",
    ];
    assert_eq!(differences.len(), expected.len(), "{printed}");
    for name in expected {
        assert!(differences[name].as_f64().unwrap() <= 1e-12, "{name}: {printed}");
    }
}

fn experiment(solvers: &str, stop: &str) -> String {
    format!(
        "# Who is right?\nstop = {{ {stop} }}\n\n[[instance]]\nmesh = \"torus:8x6\"\ndata = \"waves\"\n\
         noise = 0.3\nregions = 3\nlambda = 0.02\n\n{solvers}"
    )
}

fn external(label: &str, command: &str, rest: &str) -> String {
    format!(
        "[[solver]]\nname = \"external\"\nlabel = \"{label}\"\ncommand = \"{command}\"\n{rest}\n"
    )
}

/// Summary, manifest and trace by the label of the solver.
fn results(folder: &Folder, name: &str) -> Vec<(String, Value, Value, PathBuf)> {
    let runs = folder.path(&format!("results/{name}/runs"));
    let json =
        |path: PathBuf| -> Value { serde_json::from_slice(&fs::read(path).unwrap()).unwrap() };
    let of = |id: String| {
        let run = runs.join(id);
        let manifest = json(run.join("manifest.json"));
        let label = manifest["solver"].as_str().unwrap().to_owned();
        (label, json(run.join("summary.json")), manifest, run)
    };
    names(&runs).into_iter().map(of).collect()
}

/// All of them solve one small problem; an eps of 1e-7 changes its energy by less than 1e-6.
#[test]
fn all_reference_solvers_agree_with_the_built_in_ones() {
    let run = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/reference/run");
    let run = run.display();
    let clarabel = Path::new(PROGRAM).with_file_name("examples").join("clarabel");
    let folder = Folder::new();
    let solvers = [
        "[[solver]]\nname = \"chambolle-pock\"\n".into(),
        external("clarabel", &clarabel.display().to_string(), ""),
        external("numba", &format!("{run} numba"), "threads = 1"),
        external("scipy", &format!("{run} scipy"), ""),
        external(
            "jaxopt",
            &format!("{run} jaxopt"),
            "options = { epsilon = 1e-7, epsilon-start = 0 }",
        ),
        external("mma", &format!("{run} nlopt"), "options = { algorithm = \"mma\" }"),
        external("slsqp", &format!("{run} nlopt"), "options = { algorithm = \"slsqp\" }"),
    ];
    folder.write(
        "agree.toml",
        experiment(&solvers.join("\n"), "gap = 1e-7, max-iterations = 4000, time-limit = 20"),
    );
    // Creates the environment first, since this minute would count for the first solver.
    succeeded(reference(&["python", "-c", "pass"]));
    succeeded({
        let mut command = Command::new(PROGRAM);
        command.args(["experiment", "run", "agree.toml"]).current_dir(folder.path(""));
        command
    });
    let results = results(&folder, "agree");
    assert_eq!(results.len(), solvers.len());
    let of = |label: &str, key: &str| {
        let found = results.iter().find(|(name, ..)| name == label);
        found.unwrap_or_else(|| panic!("no {label}")).1[key].clone()
    };
    let energy = of("chambolle-pock", "energy").as_f64().unwrap();
    for (label, summary, _, folder) in &results {
        let text = fs::read_to_string(folder.join("trace.csv")).unwrap();
        let found = summary["energy"].as_f64().unwrap();
        let excess = (found - energy) / energy;
        println!("{label:16} {excess:9.2e} {summary:.80}");
        assert!(excess.abs() <= 1e-6, "{label}: {found}, not {energy}");
        let bound = summary["dual_bound"].as_f64().unwrap();
        assert!(bound <= energy * (1.0 + 1e-7), "{label}: {bound} is above {energy}");
        let certificate = match label.as_str() {
            "chambolle-pock" => continue,
            "clarabel" | "numba" | "scipy" => ",offered",
            _ => ",smoothed",
        };
        assert!(text.lines().next_back().unwrap().ends_with(certificate), "{label}: {text}");
    }
    assert_eq!(of("clarabel", "status"), "converged");
    folder.done("experiment report results/agree");
}

/// The example in the README for authors of solvers is the file next to it, and works.
#[test]
fn a_solver_takes_twenty_lines() {
    let home = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/reference");
    let code = fs::read_to_string(home.join("example.py")).unwrap();
    let body = code.split_once("\"\"\"\n\n").unwrap().1;
    assert!(body.lines().filter(|line| !line.is_empty()).count() <= 20);
    let page = fs::read_to_string(home.join("README.md")).unwrap();
    assert!(page.contains(body), "README.md shows another example than example.py");

    let (folder, _) = folder();
    folder.done(&format!("problem export {GIVEN} --out problem.npz"));
    fs::create_dir(folder.path("out")).unwrap();
    // The environment of the reference solvers has what it needs.
    let text = |path: PathBuf| path.display().to_string();
    let [script, problem, out] =
        [home.join("example.py"), folder.path("problem.npz"), folder.path("out")].map(text);
    succeeded(reference(&["python", &script, &problem, &out]));
    folder.done("problem import-trace problem.npz out --gap 1e-3 --out mine");
    folder.solve(&format!("{GIVEN} --gap 1e-6"), "ours");
    let (mine, ours) = (read(&folder, "mine"), folder.answer("ours"));
    let (energy, best) = (mine["energy"].as_f64().unwrap(), ours.number("energy"));
    assert!((energy - best).abs() <= 1e-3 * best.abs(), "{energy} {best}");
    assert_eq!(mine["status"], "converged");
    let trace = fs::read_to_string(folder.path("mine/trace.csv")).unwrap();
    assert!(trace.lines().skip(1).all(|line| line.ends_with(",steps")), "{trace}");
    assert!(folder.path("mine/preview.png").exists());
}

/// The same solver on the faces of a mesh reaches the energy of `segment`, whose result has the same energy when it is
/// imported.
#[test]
fn labels_of_faces_are_solved_elsewhere() {
    let folder = Folder::new();
    let mut rng = Pcg64::seed_from_u64(17);
    let mut p = Array2::from_shape_fn((2 * 16 * 10, 3), |_| rng.random_range(0.05..1.0));
    for mut row in p.outer_iter_mut() {
        let sum = row.sum();
        row /= sum;
    }
    write_npy(folder.path("P.npy"), &p).unwrap();
    write_npy(folder.path("S.npy"), &p.mapv(|p: f64| -p.ln())).unwrap();
    folder.done(
        "segment torus:16x10 --probabilities P.npy --on faces --relaxation frobenius --lambda 0.02 --gap 1e-7 \
         --no-preview --out ours",
    );
    let given = "torus:16x10 --costs S.npy --on faces --relaxation frobenius --lambda 0.02";
    folder.done(&format!("problem export {given} --out problem.npz"));
    let text = |path: PathBuf| path.display().to_string();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/reference/example.py");
    for out in ["example", "back"] {
        fs::create_dir(folder.path(out)).unwrap();
    }
    let [script, problem, out] =
        [script, folder.path("problem.npz"), folder.path("example")].map(text);
    succeeded(reference(&["python", &script, &problem, &out]));
    folder.done("problem import-trace problem.npz example --out theirs");
    fs::copy(folder.path("ours/u.npy"), folder.path("back/u_1.npy")).unwrap();
    folder.write("back/trace.csv", "iteration,seconds\n1,0.25\n");
    folder.done("problem import-trace problem.npz back --no-preview --out again");
    let [ours, theirs, again] =
        ["ours", "theirs", "again"].map(|out| read(&folder, out)["energy"].as_f64().unwrap());
    assert!((theirs - ours).abs() <= 1e-4 * ours.abs(), "{theirs} {ours}");
    assert!((again - ours).abs() <= 1e-9 * ours.abs(), "{again} {ours}");
    assert!(folder.path("theirs/preview.png").exists());
    let output = folder.run(&format!("evaluate {given} --u ours/u.npy"));
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    let evaluated = found["energy"].as_f64().unwrap();
    assert!((evaluated - ours).abs() <= 1e-9 * ours.abs(), "{evaluated} {ours}");
    let labels = |out: &str| {
        let path = folder.path(&format!("{out}/face_labels.npy"));
        read_npy::<_, ndarray::Array1<i32>>(path).unwrap()
    };
    assert_eq!(labels("again").len(), 320);
    assert_eq!(labels("again"), labels("ours"));
}

/// For two classes, minimum cuts find the best labels of faces, and the relaxation is tight: GCO, in integers, and the
/// solver for U agree. The recipe of MeshSegNet has another energy, so its labels have at least this one.
#[test]
fn minimum_cuts_find_the_same_labels_of_faces() {
    let folder = Folder::new();
    let mut rng = Pcg64::seed_from_u64(18);
    let s = Array2::from_shape_fn((2 * 16 * 10, 2), |_| rng.random_range(0.0..1.0));
    write_npy(folder.path("S.npy"), &s).unwrap();
    let given = "torus:16x10 --costs S.npy --on faces --lambda 0.005";
    folder.done(&format!("problem export {given} --out problem.npz"));
    let text = |path: PathBuf| path.display().to_string();
    let imported = |name: &str| {
        fs::create_dir(folder.path(name)).unwrap();
        let [problem, out] = [folder.path("problem.npz"), folder.path(name)].map(text);
        succeeded(reference(&[name, &problem, &out]));
        let out = format!("{name}-scored");
        folder.done(&format!(
            "problem import-trace problem.npz {name} --dual-steps 3000 --gap 1e-6 --no-preview --out {out}"
        ));
        read(&folder, &out)
    };
    let [cut, recipe] = ["gco", "meshsegnet"].map(imported);
    assert_eq!(cut["status"], "converged", "{cut}");
    assert!(cut["energy"].as_f64() <= recipe["energy"].as_f64(), "{cut} {recipe}");
    // Labels of vertices are not theirs.
    let v = Array2::from_shape_fn((160, 2), |(v, p)| ((v + p) % 2) as f64);
    write_npy(folder.path("V.npy"), &v).unwrap();
    folder.done("problem export torus:16x10 --costs V.npy --lambda 0.005 --out vertices.npz");
    let [problem, out] = [folder.path("vertices.npz"), folder.path("gco")].map(text);
    let output = reference(&["gco", &problem, &out]).output().unwrap();
    assert!(stderr(&output).contains("--on faces"), "{}", stderr(&output));
}

fn read(folder: &Folder, out: &str) -> Value {
    let path = folder.path(out).join("summary.json");
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

/// U of `solve`, imported as that of an external solver, has the same energy.
#[test]
fn an_imported_result_of_solve_has_the_same_energy() {
    let (folder, mesh) = folder();
    folder.done(&format!("problem export {GIVEN} --mass voronoi --init uniform --out problem.npz"));
    folder.solve(&format!("{GIVEN} --mass voronoi --gap 1e-6"), "ours");
    fs::create_dir(folder.path("out")).unwrap();
    fs::copy(folder.path("ours/u.npy"), folder.path("out/u_0007.npy")).unwrap();
    folder.write("out/trace.csv", "iteration,seconds\n7,0.25\n9,0.3");
    folder.done("problem import-trace problem.npz out --no-preview --out back");
    let (back, ours) = (read(&folder, "back"), folder.answer("ours"));
    let same = |key: &str, tolerance: f64| {
        let (a, b) = (back[key].as_f64().unwrap(), ours.number(key));
        assert!((a - b).abs() <= tolerance * b.abs(), "{key}: {a} {b}");
    };
    same("energy", 1e-14);
    same("rounded_energy", 1e-14);
    same("dual_bound", 1e-4);
    assert_eq!((back["iterations"].as_u64(), back["seconds"].as_f64()), (Some(7), Some(0.25)));
    assert_eq!(back["mass"], "voronoi");
    // The start, and the only complete line.
    assert_eq!(fs::read_to_string(folder.path("back/trace.csv")).unwrap().lines().count(), 3);
    let mut npz = NpzReader::new(fs::File::open(folder.path("problem.npz")).unwrap()).unwrap();
    let u0: Array2<f64> = npz.by_name("u0").unwrap();
    assert!(u0.iter().all(|&u| u == 1.0 / M as f64));
    let shape: ndarray::Array1<i64> = npz.by_name("K_shape").unwrap();
    assert_eq!(shape.to_vec(), [2 * mesh.faces.len() as i64, mesh.vertices.len() as i64]);
}

/// The failure of a command is the outcome of its run; other runs are not affected.
#[cfg(unix)]
#[test]
fn failures_of_commands_are_outcomes_of_their_runs() {
    let folder = Folder::new();
    let script = |name: &str, body: &str| {
        use std::os::unix::fs::PermissionsExt;
        folder.write(name, format!("#!/bin/sh\nshift 0\nout=$2\n{body}\n"));
        fs::set_permissions(folder.path(name), fs::Permissions::from_mode(0o755)).unwrap();
    };
    let n = 8 * 6;
    folder.array("wrong.npy", &Array2::zeros((n, 2)));
    folder.array("nan.npy", &Array2::from_elem((n, 3), f64::NAN));
    folder.array("far.npy", &Array2::from_elem((n, 3), 0.5));
    let one = "printf 'iteration,seconds\\n1,0.5\\n' > $out/trace.csv";
    script("fails.sh", "echo working; echo 'no luck today' >&2; exit 3");
    script("silent.sh", "sleep 300 & exit 0");
    script("hangs.sh", &format!("cp far.npy $out/u_1.npy; {one}; sleep 300 & sleep 300"));
    script("wrong.sh", &format!("cp wrong.npy $out/u_1.npy; {one}"));
    script("nan.sh", &format!("cp nan.npy $out/u_1.npy; {one}"));
    let nothing = "printf 'iteration,seconds\\n0,0\\n' > $out/trace.csv";
    script("nan0.sh", &format!("cp nan.npy $out/u_0.npy; {nothing}"));
    script(
        "late.sh",
        &format!(
            "cp far.npy $out/u_1.npy; cp wrong.npy $out/u_2.npy; {one}; echo 2,0.6 >> $out/trace.csv"
        ),
    );
    script("far.sh", &format!("cp far.npy $out/u_1.npy; {one}; echo \"$@\" >&2"));
    script(
        "unsorted.sh",
        "printf 'iteration,seconds\\n2,0.5\\n1,0.6\\n' > $out/trace.csv; cp far.npy $out/u_2.npy",
    );
    let solvers: Vec<String> = ["fails", "silent", "wrong", "nan", "nan0", "late", "unsorted"]
        .iter()
        .map(|name| external(name, &format!("./{name}.sh"), ""))
        .chain([
            external("far", "./far.sh", "threads = 1\noptions = { size = 3, mood = \"good\" }"),
            external("hangs", "./hangs.sh", "limit = 1.5"),
            external("missing", "./missing.sh", ""),
            "[[solver]]\nname = \"chambolle-pock\"\n".into(),
        ])
        .collect();
    folder.write(
        "f.toml",
        experiment(&solvers.join("\n"), "gap = 1e-3, max-iterations = 50, time-limit = 9"),
    );
    let begin = Instant::now();
    folder.done("experiment run f.toml");
    assert!(begin.elapsed() < Duration::from_secs(60), "the command that hangs was not ended");
    let results = results(&folder, "f");
    let status = |label: &str| {
        let (_, summary, manifest, run) =
            results.iter().find(|(name, ..)| name == label).unwrap_or_else(|| panic!("no {label}"));
        assert!(!run.join("exchange").exists());
        let log = fs::read_to_string(run.join("stderr.txt")).unwrap_or_default();
        (summary["status"].as_str().unwrap(), manifest["exit"].as_str().unwrap(), log)
    };
    let (ended, why, log) = status("fails");
    assert_eq!((ended, log.as_str()), ("failed", "no luck today\n"));
    assert!(why.contains("no luck today") && why.contains('3'), "{why}");
    assert!(status("silent").1.contains("trace.csv"), "{:?}", status("silent"));
    assert!(status("wrong").1.contains("48 x 2 entries, not 48 x 3"), "{:?}", status("wrong"));
    assert_eq!(status("nan").0, "diverged");
    assert_eq!(status("nan0").0, "diverged");
    // Iterates before the failure count.
    assert_eq!((status("late").0, status("late").1.contains("48 x 2")), ("failed", true));
    let (_, late, ..) = results.iter().find(|(name, ..)| name == "late").unwrap();
    assert_eq!(late["iterations"], 1);
    assert!(status("unsorted").1.contains("must increase"), "{:?}", status("unsorted"));
    assert!(status("missing").1.contains("cannot be started"), "{:?}", status("missing"));
    assert_eq!(status("hangs").0, "time-limit");
    assert_eq!(status("chambolle-pock").0, "converged");
    let (ended, _, log) = status("far");
    assert_eq!(ended, "ended");
    for word in ["--max-iterations=50", "--time-limit=9", "--threads=1", "--size=3", "--mood=good"]
    {
        assert!(log.contains(word), "{log}");
    }
    let (_, far, ..) = results.iter().find(|(name, ..)| name == "far").unwrap();
    assert!(far["warnings"][0].as_str().unwrap().contains("off the simplex"), "{far}");
    assert_eq!(far["iterations"], 1);
    // No run is made twice, but a changed command gives new runs.
    assert!(folder.done("experiment run f.toml").contains("made          0"));
    script("fails.sh", "exit 4");
    assert!(folder.done("experiment run f.toml").contains("made          1"));
    folder.done("experiment report results/f");
}

#[test]
fn errors_of_experiment_files_name_what_an_external_solver_lacks() {
    let folder = Folder::new();
    let refused = |solver: &str, stop: &str, what: &str| {
        folder.write("x.toml", experiment(solver, stop));
        let output = folder.run("experiment list x.toml");
        assert_eq!(output.status.code(), Some(1));
        assert!(stderr(&output).contains(what), "{what}: {}", stderr(&output));
    };
    let all = "gap = 1e-3, time-limit = 1";
    refused("[[solver]]\nname = \"external\"\n", all, "needs command");
    refused("[[solver]]\nname = \"external\"\ncommand = \" \"\n", all, "command is empty");
    refused("[[solver]]\nname = \"external\"\ncommand = \"x\"\n", "gap = 1e-3", "needs limit");
    refused("[[solver]]\nname = \"fista\"\ncommand = \"x\"\n", all, "external");
    refused("[[solver]]\nname = \"fista\"\nlimit = 3\n", all, "external");
    refused("[[solver]]\nname = \"external\"\ncommand = \"x\"\nlimit = -1\n", all, "limit");
    let option = "[[solver]]\nname = \"external\"\ncommand = \"x\"\noptions = { command = 1 }\n";
    refused(option, all, "is not an option");
    refused(
        "[[solver]]\nname = \"external\"\ncommand = \"x\"\ncoarse-to-fine = true\n",
        all,
        "does not apply to an external solver",
    );
    refused("[[solver]]\nname = \"extrenal\"\n", all, "external");
}

#[test]
fn an_instance_of_an_experiment_can_be_exported() {
    let folder = Folder::new();
    let two = "\n[[solver]]\nname = \"fista\"\n";
    folder.write(
        "two.toml",
        experiment(two, "gap = 1e-3").replace("\"torus:8x6\"", "[\"torus:8x6\", \"sphere:1\"]"),
    );
    folder.write("one.toml", experiment(two, "gap = 1e-3"));
    folder.done("problem export one.toml --out one.npz");
    let labels = "--instance sphere:1,%20waves,%203%20regions,%20lambda%200.02";
    let printed = folder.done(&format!("problem export two.toml {labels} --out two.npz"));
    assert!(printed.contains("vertices") && printed.contains("42"), "{printed}");
    let refused = |line: &str, what: &str| {
        let output = folder.run(&format!("problem export {line} --out x.npz"));
        assert_eq!(output.status.code(), Some(1), "{line}");
        assert!(stderr(&output).contains(what), "{line}: {}", stderr(&output));
        assert!(!folder.path("x.npz").exists());
    };
    refused("two.toml", "--instance");
    refused("two.toml --instance nobody", "--instance");
    refused("one.toml --lambda 2", "--lambda is set in the experiment file");
    refused("one.toml --seed 2", "--seed is set in the experiment file");
    refused("torus:8x6", "--costs");
    refused("torus:8x6 --lambda 1 --costs S.npy --data-dir .", "experiment file");
    refused("torus:8x6 --lambda 1 --costs nowhere.npy", "nowhere.npy");
}

/// A valid archive with one entry replaced or left out.
fn damaged(good: &[u8], name: &str, entry: Option<Vec<u8>>) -> Vec<u8> {
    let mut from = zip::ZipArchive::new(Cursor::new(good)).unwrap();
    let mut to = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default();
    for i in 0..from.len() {
        let mut file = from.by_index(i).unwrap();
        let (this, mut bytes) = (file.name().to_owned(), Vec::new());
        std::io::copy(&mut file, &mut bytes).unwrap();
        if this == format!("{name}.npy") {
            match &entry {
                None => continue,
                Some(entry) => bytes.clone_from(entry),
            }
        }
        to.start_file(this, options.compression_method(zip::CompressionMethod::Deflated)).unwrap();
        to.write_all(&bytes).unwrap();
    }
    to.finish().unwrap().into_inner()
}

fn npy<A: ndarray_npy::WritableElement, D: ndarray::Dimension>(
    array: &ndarray::Array<A, D>,
) -> Vec<u8> {
    let mut bytes = Vec::new();
    ndarray_npy::WriteNpyExt::write_npy(array, &mut bytes).unwrap();
    bytes
}

#[test]
fn damaged_problems_are_refused_in_one_line() {
    let (folder, mesh) = folder();
    folder.done(&format!("problem export {GIVEN} --out problem.npz"));
    fs::create_dir(folder.path("out")).unwrap();
    fs::copy(folder.path("u.npy"), folder.path("out/u_1.npy")).unwrap();
    folder.write("out/trace.csv", "iteration,seconds\r\n1,0.5\r\n");
    let good = fs::read(folder.path("problem.npz")).unwrap();
    let n = mesh.vertices.len();
    // Compressed as by `numpy.savez_compressed`, it is valid.
    folder.write("packed.npz", damaged(&good, "nothing", None));
    folder.done("problem import-trace packed.npz out --no-preview --out fine");
    // So it is with 64-bit integers, which other programs may write.
    let wide = Array2::from_shape_fn((mesh.faces.len(), 3), |(j, i)| i64::from(mesh.faces[j][i]));
    folder.write("wide.npz", damaged(&good, "faces", Some(npy(&wide))));
    folder.done("problem import-trace wide.npz out --no-preview --out wide");
    let energy = |out: &str| {
        let summary = fs::read(folder.path(out).join("summary.json")).unwrap();
        serde_json::from_slice::<Value>(&summary).unwrap()["energy"].as_f64().unwrap()
    };
    assert_eq!(energy("wide"), energy("fine"));

    let faces = |corner: i32| npy(&Array2::from_elem((mesh.faces.len(), 3), corner));
    let huge = {
        let mut bytes = npy(&Array2::<f64>::zeros((n, 3)));
        let at = bytes.windows(4).position(|four| four == b"(126").unwrap();
        bytes[at + 1..at + 4].copy_from_slice(b"999");
        bytes
    };
    let mut bad: Vec<(Vec<u8>, &str)> = vec![
        (Vec::new(), "is empty"),
        (b"PK".to_vec(), "not an .npz"),
        (good[..good.len() / 2].to_vec(), "problem"),
        (good[..good.len() - 1].to_vec(), "problem"),
        (damaged(&good, "format", None), "format"),
        (damaged(&good, "format", Some(npy(&arr0(1.0)))), "byte string"),
        (damaged(&good, "version", Some(npy(&arr0(2_i64)))), "version 2"),
        (damaged(&good, "version", Some(npy(&arr0(1.0)))), "version"),
        (damaged(&good, "points", Some(huge)), "does not match its shape"),
        (damaged(&good, "points", Some(npy(&Array2::<f64>::zeros((n, 2))))), "three columns"),
        (damaged(&good, "points", Some(npy(&Array2::<f64>::zeros((n, 3))))), "area"),
        (damaged(&good, "points", Some(npy(&Array2::from_elem((n, 3), f64::NAN)))), "finite"),
        (damaged(&good, "faces", Some(faces(-1))), "indices outside"),
        (damaged(&good, "faces", Some(faces(n as i32))), "indices outside"),
        (damaged(&good, "faces", Some(faces(1))), "area"),
        (
            damaged(&good, "faces", Some(npy(&Array2::<f64>::zeros((4, 3))))),
            "holds <f8, not integers",
        ),
        (damaged(&good, "f", Some(npy(&Array2::<f64>::zeros((n, 1))))), "1 regions"),
        (damaged(&good, "f", Some(npy(&Array2::<f64>::zeros((n + 1, M))))), "rows"),
        (damaged(&good, "f", Some(npy(&Array2::from_elem((n, M), f64::INFINITY)))), "finite"),
        (damaged(&good, "u0", Some(npy(&Array2::<f64>::zeros((n, M))))), "simplex"),
        (damaged(&good, "u0", Some(npy(&Array2::<f64>::zeros((n, M + 1))))), "initial U"),
        (damaged(&good, "f", Some(npy(&Array2::from_elem((n, M), 1e300)))), "range"),
        (
            damaged(&good, "f", Some(npy(&Array2::<f64>::zeros((3_000_000, M))))),
            "more than it can hold",
        ),
        (damaged(&good, "lambda", Some(npy(&arr0(-1.0)))), "lambda"),
        (damaged(&good, "lambda", Some(npy(&Array0::from_elem((), f64::NAN)))), "lambda"),
        (damaged(&good, "mass", None), "mass"),
    ];
    bad.push((damaged(&good, "u0", None), "u0"));
    for (bytes, what) in bad {
        folder.write("problem.npz", bytes);
        let before = folder.listing();
        let output = folder.run("problem import-trace problem.npz out --out x");
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{what}: {message}");
        assert!(message.lines().count() == 1 && message.contains(what), "{what}: {message}");
        assert_eq!(folder.listing(), before, "{what}");
    }
}

#[test]
fn damaged_iterates_are_refused_in_one_line() {
    let (folder, _) = folder();
    folder.done(&format!("problem export {GIVEN} --out problem.npz"));
    let refused = |trace: Option<&str>, what: &str| {
        let _ = fs::remove_dir_all(folder.path("out"));
        fs::create_dir(folder.path("out")).unwrap();
        fs::copy(folder.path("u.npy"), folder.path("out/u_1.npy")).unwrap();
        fs::copy(folder.path("u.npy"), folder.path("out/u_00000002.npy")).unwrap();
        fs::write(folder.path("out/u_3.npy"), b"no array").unwrap();
        fs::write(folder.path("out/u_x.npy"), b"not ours").unwrap();
        if let Some(trace) = trace {
            folder.write("out/trace.csv", trace);
        }
        let output = folder.run("problem import-trace problem.npz out --out x");
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{what}: {message}");
        assert!(message.lines().count() == 1 && message.contains(what), "{what}: {message}");
        assert!(!folder.path("x").exists());
    };
    refused(None, "trace.csv");
    refused(Some(""), "is empty");
    for nothing in ["1,2", "iteration,seconds", "iteration,seconds\n", "iteration,seconds\n4"] {
        refused(Some(nothing), "has no samples; below the line `iteration,seconds`");
    }
    refused(Some("time,seconds\n1,2\n"), "line 1: has no column iteration");
    refused(Some("iteration;seconds\n1;2\n"), "line 1: has no column iteration");
    refused(Some("iteration\tseconds\n1\t2\n"), "separated by commas");
    refused(Some("1,2\n2,3\n"), "line 1: has no column iteration");
    refused(Some("iteration,seconds\n1,soon\n"), "line 2: seconds \"soon\" is not a number");
    refused(Some("iteration,seconds\n1.5,1\n"), "line 2: iteration \"1.5\" is not a whole number");
    refused(
        Some("iteration,seconds,epsilon\n1,1,None\n"),
        "line 2: epsilon \"None\" is not a number",
    );
    refused(Some("iteration,seconds\n1,NaN\n"), "not a time");
    refused(Some("iteration,seconds\n1,-2\n"), "not a time");
    refused(Some("iteration,seconds\n1,1e300\n"), "not a time");
    refused(Some("iteration,seconds\n2,1\n1,2\n"), "must increase");
    refused(Some("iteration,seconds\n1,2\n2,1\n"), "must not decrease");
    refused(Some("iteration,seconds\n4,1\n"), "u_4.npy");
    refused(Some("iteration,seconds\n3,1\n"), "u_3.npy");
    refused(Some("iteration,seconds,epsilon\n1,1,-3\n"), "epsilon");
    refused(Some("iteration,seconds,epsilon,epsilon_mode\n1,1,3,loose\n"), "loose");
    folder.write("out/trace.csv", "iteration,seconds\n1,1\n");
    fs::copy(folder.path("u.npy"), folder.path("out/u_01.npy")).unwrap();
    let output = folder.run("problem import-trace problem.npz out --out x");
    assert_eq!(output.status.code(), Some(1));
    let message = stderr(&output);
    assert!(message.contains("u_01.npy and u_1.npy are both of iteration 1"), "{message}");
}
