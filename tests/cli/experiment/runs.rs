//! Runs are made once, are written completely or not at all, and survive the death of the program.

use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde_json::Value;

use super::{SMALL, SMALL_RUNS, outcomes, small};
use crate::support::{Folder, PROGRAM, names};

#[test]
fn runs_are_made_once() {
    let folder = small();
    let first = folder.done("experiment run small.toml");
    assert!(first.contains("made          10"), "{first}");
    let made = outcomes(&folder.path("results/small"));
    assert_eq!(made.len(), SMALL_RUNS);
    let before = folder.listing();
    let second = folder.done("experiment run small.toml");
    assert!(second.contains("made          0") && second.contains("already done  10"), "{second}");
    assert_eq!(folder.listing(), before);

    // After a change, only the affected runs are made.
    folder.write("small.toml", SMALL.replace("rho = [1.9, 1.5]", "rho = [1.9, 1.4]"));
    let third = folder.done("experiment run small.toml");
    assert!(third.contains("made          4"), "{third}");
    assert_eq!(outcomes(&folder.path("results/small")).len(), SMALL_RUNS + 4);

    folder.write("small.toml", SMALL);
    let again = folder.done("experiment run small.toml --force");
    assert!(again.contains("made          10"), "{again}");
    let all = outcomes(&folder.path("results/small"));
    assert!(made.iter().all(|(id, run)| all[id] == *run));
}

#[test]
fn a_run_stores_everything_needed_to_repeat_it() {
    let folder = small();
    folder.done("experiment run small.toml");
    let runs = folder.path("results/small/runs");
    for id in names(&runs) {
        let read = |name: &str| std::fs::read(runs.join(&id).join(name)).unwrap();
        let manifest: Value = serde_json::from_slice(&read("manifest.json")).unwrap();
        assert_eq!(manifest["id"], Value::from(id.as_str()));
        for key in ["commit", "dirty", "lock", "rustc", "target", "target_features", "version"] {
            assert!(!manifest["program"][key].is_null(), "{key}: {manifest}");
        }
        for key in ["cpu", "cores", "memory_gib", "host"] {
            assert!(!manifest["machine"][key].is_null(), "{key}: {manifest}");
        }
        let keys =
            ["load_average", "loaded", "seed", "generator", "start", "end", "exit", "threads"];
        assert!(keys.iter().all(|key| !manifest[key].is_null()), "{manifest}");
        // The run can be made separately from its own specification.
        folder.write("alone.toml", read("spec.toml"));
        let alone = folder.done(&format!("experiment run alone.toml --results alone-{id}"));
        assert!(alone.contains("made          1"), "{alone}");
        let made = outcomes(&folder.path(&format!("alone-{id}/alone")));
        let (_, (summary, _)) = made.first_key_value().unwrap();
        assert_eq!(*summary, outcomes(&folder.path("results/small"))[&id].0);
    }
}

/// "auto" is the lambda that `segment` chooses for the same data, optionally times a factor; synthetic data have true
/// labels.
#[test]
fn lambda_can_be_chosen_automatically() {
    let folder = Folder::new();
    let file = |data: &str, lambda: &str| {
        format!(
            "stop = {{ gap = 1e-3 }}\n[[instance]]\nmesh = \"torus:60x40\"\n{data}\nregions = 2\nlambda = {lambda}\n\
             [[solver]]\nname = \"chambolle-pock\"\n[[table]]\nname = \"all\"\nkind = \"cells\"\n\
             columns = [\"lambda\", \"regions-used\", \"mislabeled\"]\n"
        )
    };
    folder.write("a.toml", file("data = \"curvature\"", "[\"auto\", \"0.5 auto\", \"1e6auto\"]"));
    folder.done("segment torus:60x40 --data curvature --regions 2 --no-preview --out o");
    let taken = folder.answer("o").number("lambda");
    folder.write("b.toml", file("data = \"waves\"\nnoise = 0.1", "[\"auto\", 1e3]"));
    let rows = |name: &str| -> Vec<Vec<f64>> {
        folder.done(&format!("experiment run {name}.toml"));
        folder.done(&format!("experiment report results/{name}"));
        let table = folder.path(&format!("results/{name}/tables/all.csv"));
        let text = std::fs::read_to_string(table).unwrap();
        let row = |line: &str| {
            let entries = line.rsplit(',').take(3).map(|entry| entry.parse().unwrap_or(f64::NAN));
            entries.collect::<Vec<f64>>().into_iter().rev().collect()
        };
        text.lines().skip(1).map(row).collect()
    };
    let found = rows("a");
    for (row, factor) in found.iter().zip([1.0, 0.5, 1e6]) {
        assert!((row[0] - factor * taken).abs() <= 1e-12 * row[0], "{found:?} {taken}");
        assert!(row[2].is_nan(), "{found:?}");
    }
    assert_eq!([found[0][1], found[1][1], found[2][1]], [2.0, 2.0, 1.0]);
    let found = rows("b");
    assert_eq!([found[0][1], found[1][1]], [2.0, 1.0]);
    assert!(found[0][2] < 0.02 && found[1][2] > 0.3, "{found:?}");

    // The page contains a shared mesh only once.
    let page = std::fs::read_to_string(folder.path("results/a/report.html")).unwrap();
    assert_eq!(page.matches("\"positions\":\"").count(), 1);
    assert_eq!(page.matches("\"mesh\":\"g0\"").count(), 2);
}

/// Shards, and processes that run at the same time, make the same runs as one process.
#[test]
fn shards_and_concurrent_processes_make_the_same_runs() {
    let folder = small();
    folder.done("experiment run small.toml");
    let expected = outcomes(&folder.path("results/small"));
    for i in 1..=3 {
        folder.done(&format!("experiment run small.toml --shard {i}/3 --results sharded"));
    }
    assert_eq!(outcomes(&folder.path("sharded/small")), expected);
    let rivals = [0; 4].map(|_| {
        Command::new(PROGRAM)
            .args("experiment run small.toml --results rivals".split(' '))
            .current_dir(folder.path(""))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap()
    });
    for mut rival in rivals {
        assert!(rival.wait().unwrap().success());
    }
    assert_eq!(outcomes(&folder.path("rivals/small")), expected);
}

/// Killed at random moments, the program leaves only complete runs, and the final results are the same.
#[test]
fn killing_the_program_harms_nothing() {
    let expected = {
        let folder = small();
        folder.done("experiment run small.toml");
        outcomes(&folder.path("results/small"))
    };
    let folder = small();
    let mut rng = Pcg64::seed_from_u64(7);
    let (mut killed, mut seen) = (0, 0);
    for round in 0..200 {
        let mut run = Command::new(PROGRAM)
            .args("experiment run small.toml".split(' '))
            .current_dir(folder.path(""))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        sleep(Duration::from_micros(rng.random_range(1_000..60_000)));
        if run.try_wait().unwrap().is_none() {
            run.kill().unwrap();
            killed += 1;
        }
        run.wait().unwrap();
        let runs = folder.path("results/small/runs");
        if runs.exists() {
            let whole = names(&runs).into_iter().filter(|name| !name.starts_with('.'));
            for id in whole {
                let files = names(&runs.join(&id));
                for name in ["spec.toml", "trace.csv", "summary.json", "manifest.json"] {
                    assert!(files.contains(name), "round {round}, {id}: {files:?}");
                }
                seen += 1;
            }
        }
        if killed >= 20 {
            break;
        }
        if killed < 20 && round % 3 == 2 {
            // All runs may be done by now; starts over, so that there is something to kill.
            std::fs::remove_dir_all(folder.path("results")).unwrap_or_default();
        }
    }
    assert!(killed >= 20 && seen > 0, "{killed} kills, {seen} runs seen");
    folder.done("experiment run small.toml");
    assert_eq!(outcomes(&folder.path("results/small")), expected);
}

#[test]
fn damaged_runs_are_named() {
    let folder = small();
    folder.done("experiment run small.toml");
    let runs = folder.path("results/small/runs");
    let id = names(&runs).pop_first().unwrap();
    for (file, content) in [
        ("summary.json", "{"),
        ("manifest.json", ""),
        ("trace.csv", "iteration\nx\n"),
        ("spec.toml", "["),
    ] {
        let path = runs.join(&id).join(file);
        let whole = std::fs::read(&path).unwrap();
        std::fs::write(&path, content).unwrap();
        refused(&folder, "experiment report results/small", file);
        refused(&folder, "experiment list small.toml", file);
        refused(&folder, "experiment report results/small", "remove the folder of the run");
        std::fs::write(&path, whole).unwrap();
    }
}

/// Copying and cleaning may lose single files; an incomplete run does not count.
#[test]
fn runs_that_lost_a_file_are_made_again() {
    let folder = small();
    folder.done("experiment run small.toml");
    folder.done("experiment report results/small");
    let made = outcomes(&folder.path("results/small"));
    let runs = folder.path("results/small/runs");
    let id = names(&runs).pop_first().unwrap();
    for file in ["spec.toml", "trace.csv", "summary.json", "manifest.json"] {
        std::fs::remove_file(runs.join(&id).join(file)).unwrap();
        for line in
            ["experiment report results/small", "experiment why results/small/figures/decay.svg"]
        {
            refused(&folder, line, &format!("lacks {file}; `meshseg experiment run` makes"));
        }
        let list = folder.done("experiment list small.toml");
        assert!(list.contains("10, 1 missing") && list.contains("missing\n"), "{list}");
        let again = folder.done("experiment run small.toml");
        assert!(again.contains("made          1"), "{again}");
        assert_eq!(outcomes(&folder.path("results/small")), made);
    }
}

fn refused(folder: &Folder, line: &str, part: &str) {
    let output = folder.run(line);
    let message = crate::support::stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{line}: {message}");
    assert!(message.lines().count() == 1 && message.contains(part), "{line}: {message}");
}
