//! Valid experiment files, and errors with line and column for invalid ones.

use std::fs;
use std::path::Path;

use super::{SMALL, SMALL_RUNS, small};
use crate::support::{Folder, stderr};

/// `small.toml` with a change: the message contains line, column and the parts.
fn refuse(from: &str, to: &str, parts: &[&str]) {
    assert!(from.is_empty() || SMALL.contains(from), "{from}");
    let folder = Folder::new();
    let text = if from.is_empty() { to.to_owned() } else { SMALL.replacen(from, to, 1) };
    folder.write("e.toml", &text);
    let before = folder.listing();
    for verb in ["run", "list"] {
        let output = folder.run(&format!("experiment {verb} e.toml"));
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{to}: {message}");
        assert_eq!(message.lines().count(), 1, "{message}");
        assert!(message.starts_with("error: e.toml, line "), "{message}");
        for part in parts {
            assert!(message.contains(part), "{part:?} is not in {message}");
        }
    }
    assert_eq!(folder.listing(), before);
}

#[test]
fn unknown_and_impossible_values_are_refused_at_their_positions() {
    refuse(
        "repetitions = 2",
        "repetition = 2",
        &["line 4, column 1", "\"repetition\"", "repetitions"],
    );
    refuse("repetitions = 2", "repetitions = 0", &["line 4, column 15", "whole number, 1 or more"]);
    refuse("repetitions = 2", "repetitions = \"2\"", &["line 4", "whole number"]);
    refuse("repetitions = 2", "repetitions = [1, 2", &["line 5"]);
    refuse("gap = 1e-3", "gap = -1e-3", &["line 5, column 16", "gap must be"]);
    refuse("gap = 1e-3", "gap = nan", &["line 5", "finite"]);
    refuse("gap = 1e-3, max-iterations = 300", "", &["no end"]);
    refuse("gap = 1e-3,", "limit = 3,", &["\"limit\"", "time-limit"]);
    refuse("\"torus:20x12\"", "\"torus:20\"", &["line 8, column 9", "torus"]);
    refuse("\"torus:20x12\"", "\"builtin:bunny\"", &["builtin:spot"]);
    refuse("[\"torus:20x12\", \"torus:24x16\"]", "[]", &["line 8", "empty list"]);
    refuse("[\"torus:20x12\", \"torus:24x16\"]", "[[\"torus:20x12\"]]", &["list of lists"]);
    refuse("data = \"waves\"", "data = \"wave\"", &["line 9, column 8", "curvature"]);
    refuse(
        "data = \"waves\"",
        "data = \"curvature:gauss\"",
        &["line 9, column 8", "mean-quadric", "did you mean \"curvature:gaussian\""],
    );
    refuse("data = \"waves\"", "data = \"costs:S.npy\"", &["regions"]);
    let waves = "data = \"waves\"";
    let photographs = "data = \"photographs:3:40x30\"\n";
    let solver = "name = \"chambolle-pock\"";
    refuse(solver, &format!("{solver}\nrounding = \"best\""), &["expansion", "argmax"]);
    refuse(solver, &format!("{solver}\nlabel-gap = -1.0"), &["label-gap", "0 or more"]);
    refuse(solver, "name = \"kmeans\"\nlabel-gap = 0.1", &["kmeans rounds nothing"]);
    refuse(waves, "data = \"photographs:0\"", &["line 9, column 8", "from 1 to 1000"]);
    refuse(waves, "data = \"photographs:3:40\"", &["line 9, column 8", "WxH"]);
    for (key, parts) in [
        ("light = \"0,1\"", ["line 10, column 9", "three numbers"]),
        ("light = 1.0", ["line 10, column 9", "string"]),
        ("ambient = 0.1", ["line 10, column 11", "ambient needs light"]),
        ("light = \"0,1,0\"\nambient = -0.1", ["line 11, column 11", "0 or more"]),
        ("principal-error = -1.0", ["line 10, column 19", "0 or more"]),
        ("sampling = \"faces\"", ["line 10, column 12", "\"vertices\""]),
        ("pure = 0", ["line 10, column 8", "from 1 to 255"]),
        ("light = \"0,0,0\"", ["line 10, column 9", "not all 0"]),
        ("light = \"nan,0,1\"", ["line 10, column 9", "three numbers"]),
        ("sampling = \"vertices\"\npure = 2", ["line 11, column 8", "sampling = \"pixels\""]),
        ("grazing = [0.5, 1.0]", ["line 10, column 17", "below 1"]),
    ] {
        refuse(waves, &format!("{photographs}{key}"), &parts);
    }
    refuse(waves, "data = \"waves\"\npure = 2", &["line 10, column 8", "photographs:N:WxH"]);
    let views = "data = \"views:v.toml\"";
    refuse(&format!("{waves}\nnoise = 0.3"), views, &["v.toml"]);
    refuse(waves, views, &["line 10, column 9", "noise of their own"]);
    for (key, parts) in [
        ("light = \"0,1,0\"", ["line 10, column 9", "photographs:N:WxH"]),
        ("sampling = \"vertices\"", ["line 10, column 12", "photographs:N:WxH"]),
        ("mass = \"consistent\"", ["line 10, column 8", "leave mass out"]),
        ("project = \"xy\"", ["line 10, column 11", "leave project out"]),
        ("images = 3", ["line 10, column 10", "string"]),
        ("grazing = 1.5", ["line 10, column 11", "below 1"]),
    ] {
        refuse(&format!("{waves}\nnoise = 0.3"), &format!("{views}\n{key}"), &parts);
    }
    refuse(waves, "data = \"waves\"\nimages = \"d\"", &["line 10, column 10", "views:FILE"]);
    refuse("noise = 0.3", "noise = -0.3", &["line 10", "0 or more"]);
    refuse("regions = 4", "regions = [4, 65]", &["line 11, column 15", "from 2 to 64"]);
    refuse("regions = 4", "regions = 2.5", &["whole number"]);
    refuse("regions = 4", "mass = \"lumped\"\nregions = 4", &["barycentric", "consistent"]);
    refuse("lambda = 0.01", "lambda = \"0.01\"", &["line 12, column 10", "number"]);
    refuse("lambda = 0.01", "lambda = -0.01", &["line 12, column 10", "0 or more"]);
    refuse("lambda = 0.01", "lambda = \"1.0.1 auto\"", &["line 12, column 10", "0.5 auto"]);
    refuse("lambda = 0.01", "lambda = [0.01, \"-1 auto\"]", &["line 12, column 17", "0 or more"]);
    refuse(
        "data = \"waves\"\nnoise = 0.3\nregions = 4\nlambda = 0.01",
        "data = \"costs:S.npy\"\nlambda = \"auto\"",
        &["line 10, column 10", "these are costs"],
    );
    refuse("lambda = 0.01\n", "", &["[[instance]] needs lambda"]);
    refuse("name = \"chambolle-pock\"", "name = \"chambolle\"", &["line 15", "fista"]);
    refuse("rho = [1.9, 1.5]", "rho = [1.9, 2.5]", &["line 16, column 25", "rho=2.5", "below 2"]);
    refuse("rho = [1.9, 1.5]", "row = 1", &["line 16", "\"row\"", "rho"]);
    refuse("name = \"fista\"", "name = \"fista\"\nthreads = 0", &["from 1 to 1024"]);
    refuse("name = \"fista\"", "name = \"fista\"\ncoarse-to-fine = 1", &["true or false"]);
    refuse("label = \"FISTA\"", "label = \"FISTA\"\nzip = [\"a\", \"b\"]", &["\"a\"", "solver"]);
    let many = "repetitions = 100000000000";
    refuse("repetitions = 2", many, &["line 4, column 15", "600000000000 runs", "at most 100000"]);
    let lists = format!("noise = {:?}\nseed = {0:?}\nregions = [2, 3, 4]", [1; 200]);
    refuse("noise = 0.3\nregions = 4", &lists, &["line 7, column 1", "make 240000 cells"]);
    refuse(
        "mesh = \"torus:24x16\"\nsolver",
        "mesh = \"torus:24x61\"\nsolver",
        &["line 23, column 8", "no cell has the mesh torus:24x61", "did you mean \"torus:24x16\""],
    );
    refuse(
        "solver = \"fista\"\n",
        "solver = \"fista\"\noptions = { rho = 1.5 }\n",
        &["line 22, column 1", "no cell has all of these values together"],
    );
    refuse("solver = \"fista\"\n", "sover = \"fista\"\n", &["no cell has the key \"sover\""]);
    refuse("name = \"decay\"", "name = \"../decay\"", &["becomes a file"]);
    refuse("kind = \"decay\"", "kind = \"line\"", &["decay", "profile", "relation"]);
    refuse("x = \"options.rho\"", "x = \"rho\"", &["\"rho\"", "options.KEY"]);
    refuse("gaps = [1e-1, 1e-2, 1e-9]", "gaps = [0]", &["positive"]);
    refuse("", "stop = { gap = 1 }\n[[solver]]\nname = \"fista\"\n", &["[[instance]]"]);
    refuse("", "stop = 3", &["stop must be a table"]);
    refuse("", "instance = 3\nstop = { gap = 1 }", &["[[instance]]"]);
    let twice = "label = \"FISTA\"\nname = \"fista\"\n\n[[solver]]\nlabel = \"FISTA\"";
    refuse("label = \"FISTA\"", twice, &["called \"FISTA\""]);
}

#[test]
fn files_that_cannot_be_read_are_refused() {
    let folder = Folder::new();
    folder.write("latin.toml", b"# caf\xe9\n");
    folder.write("empty.toml", "");
    for (file, part) in [
        ("missing.toml", "missing.toml"),
        ("empty.toml", "is empty"),
        ("latin.toml", "UTF-8"),
        (".", "folder"),
    ] {
        let output = folder.run(&format!("experiment list {file}"));
        assert_eq!(output.status.code(), Some(1));
        let message = stderr(&output);
        assert!(message.lines().count() == 1 && message.contains(part), "{message}");
    }
    folder.write("e.toml", super::SMALL.replace("\"torus:24x16\"", "\"no/such.ply\""));
    let output = folder.run("experiment run e.toml");
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("no/such.ply"), "{}", stderr(&output));
    assert!(!folder.path("results").exists());
}

#[test]
fn lists_are_swept_zipped_and_excluded() {
    let folder = small();
    let list = folder.done("experiment list small.toml");
    assert_eq!(missing(&list), SMALL_RUNS, "{list}");
    assert!(list.contains("Which of two solvers is faster on two small tori?"), "{list}");
    assert!(!list.contains("FISTA      torus:24x16"), "{list}");
    let zipped = SMALL
        .replace("lambda = 0.01", "lambda = [0.01, 0.02]\nzip = [\"mesh\", \"lambda\"]")
        .replace("[[exclude]]\nmesh = \"torus:24x16\"", "[[exclude]]\nlambda = 0.02");
    folder.write("zipped.toml", zipped);
    let list = folder.done("experiment list zipped.toml");
    assert_eq!(missing(&list), SMALL_RUNS, "{list}");
    assert!(list.contains("torus:24x16, waves, 4 regions, lambda 0.02"), "{list}");
    assert!(!list.contains("torus:20x12, waves, 4 regions, lambda 0.02"), "{list}");
}

/// Number of runs that a list shows as missing.
fn missing(list: &str) -> usize {
    list.lines().filter(|line| line.ends_with("  missing")).count()
}

/// Instances whose data may not be redistributed are skipped by name, unless their folder is given.
#[test]
fn instances_without_their_data_folder_are_skipped_by_name() {
    let folder = Folder::new();
    let text = SMALL.replace("\"torus:24x16\"]", "\"data:square.obj\"]");
    folder.write(
        "e.toml",
        text.replace(
            "[[exclude]]\nmesh = \"torus:24x16\"",
            "[[exclude]]\nmesh = \"data:square.obj\"",
        ),
    );
    let list = folder.done("experiment list e.toml");
    assert!(list.contains("skipped") && list.contains("data:square.obj"), "{list}");
    assert_eq!(missing(&list), 6, "{list}");
    let output = folder.run("experiment run e.toml");
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stderr(&output).contains("skipped: data:square.obj"), "{}", stderr(&output));

    std::fs::create_dir(folder.path("real")).unwrap();
    folder.write("real/square.obj", crate::support::SQUARE_OBJ);
    let list = folder.done("experiment list e.toml --data-dir real");
    assert!(!list.contains("skipped"), "{list}");
    assert_eq!(missing(&list), 4, "{list}");
    folder.done("experiment run e.toml --data-dir real");
    assert!(folder.done("experiment list e.toml --data-dir real").contains("10, 0 missing"));
}

/// The experiments of the project are valid, and each is in the list of questions.
#[test]
fn the_experiments_of_the_project_are_valid_and_listed() {
    let folder = Folder::new();
    let experiments = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments");
    let questions = fs::read_to_string(experiments.join("README.md")).unwrap();
    let files = fs::read_dir(&experiments).unwrap().map(|entry| entry.unwrap().path());
    let files = files.filter(|path| path.extension().is_some_and(|extension| extension == "toml"));
    for path in files {
        let name = path.file_stem().unwrap().to_str().unwrap();
        assert!(questions.contains(&format!("| {name} |")), "{name}");
        let path = path.to_str().unwrap().replace(' ', "%20");
        assert!(folder.done(&format!("experiment list {path}")).contains("question"), "{name}");
    }
}
