//! Several programs at once, and environments that ask for too much.

use std::process::{Child, Command, Stdio};

use meshseg::mesh::Shape;
use ndarray::{Array1, Array2};
use ndarray_npy::read_npy;

use crate::support::{Folder, PROGRAM, costs, stderr};

const MESH: &str = "torus:20x12";

fn program(folder: &Folder, line: &str) -> Command {
    let mut command = Command::new(PROGRAM);
    command.args(line.split_whitespace()).current_dir(folder.path(""));
    command
}

/// Four programs write to one folder, first to none: in each round, the files there are those of one run, and no
/// program fails.
#[test]
fn of_several_writers_the_last_one_is_whole() {
    let folder = Folder::new();
    let n = MESH.parse::<Shape>().unwrap().mesh().vertices.len();
    folder.array("S.npy", &costs(n, 3));
    for round in 0..12 {
        let _ = std::fs::remove_dir_all(folder.path("out"));
        let start = |k: usize| -> Child {
            // The third one writes fewer files.
            let more = if k == 3 { "" } else { "--save q --also vtp" };
            program(&folder, &format!(
                "solve {MESH} --costs S.npy --lambda 0.0{} --threads 1 --no-preview {more} --out out",
                k + 1
            ))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
        };
        for child in [0, 1, 2, 3].map(start) {
            let output = child.wait_with_output().unwrap();
            assert!(output.status.success(), "round {round}: {}", stderr(&output));
        }
        let answer = folder.answer("out");
        let k = (100.0 * answer.number("lambda")).round() as usize - 1;
        let labels: Array1<i32> = read_npy(folder.path("out/labels.npy")).unwrap();
        let u: Array2<f64> = read_npy(folder.path("out/u.npy")).unwrap();
        folder.done(&format!(
            "solve {MESH} --costs S.npy --lambda 0.0{} --threads 1 --no-preview --out alone",
            k + 1
        ));
        assert_eq!(u, read_npy::<_, Array2<f64>>(folder.path("alone/u.npy")).unwrap());
        assert_eq!(labels, read_npy::<_, Array1<i32>>(folder.path("alone/labels.npy")).unwrap());
        for name in ["q.npy", "segmented.vtp"] {
            assert_eq!(folder.path("out").join(name).exists(), k != 3, "round {round}: {name}");
        }
        let left = std::fs::read_dir(folder.path("out")).unwrap();
        let hidden = left.filter(|entry| {
            entry.as_ref().unwrap().file_name().to_string_lossy().starts_with(".meshseg")
        });
        assert_eq!(hidden.count(), 0);
    }
}

#[test]
fn an_environment_that_asks_for_too_many_threads_is_refused() {
    let folder = Folder::new();
    let output = program(&folder, "mesh info torus:20x12")
        .env("RAYON_NUM_THREADS", "100000")
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(
        stderr(&output),
        "error: RAYON_NUM_THREADS=100000: must be at most 1024; unset it, or use --threads\n"
    );
    let output =
        program(&folder, "mesh info torus:20x12").env("RAYON_NUM_THREADS", "3").output().unwrap();
    assert!(output.status.success());
}

/// What a killed program has left is removed by the next one that writes there; what is in use, young, or somebody
/// else's stays.
#[test]
fn leftovers_of_killed_programs_are_removed() {
    let folder = Folder::new();
    let age = |name: &str, seconds: u64| {
        let file = std::fs::File::open(folder.path(name)).unwrap();
        file.set_modified(std::time::SystemTime::now() - std::time::Duration::from_secs(seconds))
            .unwrap();
        file
    };
    for name in
        [".meshseg-AbCd12", ".meshseg-used99", ".meshseg-young1", ".meshseg-ofauser", "mine"]
    {
        std::fs::create_dir(folder.path(name)).unwrap();
        folder.write(&format!("{name}/u.npy"), "part");
        age(name, if name.ends_with("young1") { 5 } else { 3600 });
    }
    folder.write(".meshseg-file00", "part");
    age(".meshseg-file00", 3600);
    let in_use = age(".meshseg-used99", 3600);
    in_use.lock().unwrap();
    folder.done("mesh generate grid:3x2 --out grid.ply");
    let left = crate::support::names(&folder.path(""));
    let expected = [".meshseg-ofauser", ".meshseg-used99", ".meshseg-young1", "grid.ply", "mine"];
    assert!(left.iter().eq(expected), "{left:?}");
    drop(in_use);
    folder.array("S.npy", &costs(12, 2));
    folder.done("solve grid:3x2 --costs S.npy --lambda 0.1 --no-preview --out results");
    assert!(!folder.path(".meshseg-used99").exists() && folder.path("mine/u.npy").exists());
}
