//! The scripts for clusters: the Snakefile is run, and the tasks of the Slurm script are run in a shell.

use std::path::Path;
use std::process::{Command, Output};

use ndarray::Array2;

use super::{SMALL_RUNS, outcomes, small};
use crate::support::{Folder, PROGRAM};

/// Runs the Snakefile of a folder by the script that creates the environment of Snakemake where it is missing.
fn snakemake(folder: &Folder) -> Output {
    let project = Path::new(env!("CARGO_MANIFEST_DIR"));
    Command::new(project.join("tests/cli/experiment/snakemake"))
        .env("CARGO_TARGET_DIR", Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap())
        .args(["--cores", "2", "-s", "Snakefile", "--quiet", "all"])
        .current_dir(folder.path(""))
        .env("HOME", folder.path(""))
        .output()
        .unwrap()
}

#[test]
fn the_snakefile_makes_all_runs_and_the_report() {
    let folder = small();
    let snakefile = folder.done("experiment run small.toml --emit snakemake --jobs 3");
    folder.write("Snakefile", &snakefile);
    assert!(!folder.path("results").exists());
    let output = snakemake(&folder);
    assert!(output.status.success(), "{snakefile}\n{}", String::from_utf8_lossy(&output.stderr));
    let made = outcomes(&folder.path("results/small"));
    assert_eq!(made.len(), SMALL_RUNS);
    assert!(folder.path("results/small/report.html").exists());
    folder.done("experiment run small.toml --results alone");
    assert_eq!(outcomes(&folder.path("alone/small")), made);
}

/// The name has blanks, quotes and braces, which a shell, Python or Snakemake could interpret.
#[test]
fn the_snakefile_takes_any_name() {
    let folder = small();
    let name = "noise {i} it's \"50 %\" {wildcards.x} $HOME # λ";
    std::fs::rename(folder.path("small.toml"), folder.path(&format!("{name}.toml"))).unwrap();
    let file = format!("{name}.toml");
    let emit = ["experiment", "run", &file, "--emit", "snakemake", "--jobs", "2"];
    let emitted = Command::new(PROGRAM).args(emit).current_dir(folder.path("")).output().unwrap();
    folder.write("Snakefile", &emitted.stdout);
    let output = snakemake(&folder);
    let messages = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{}\n{messages}", String::from_utf8_lossy(&emitted.stdout));
    assert_eq!(outcomes(&folder.path(&format!("results/{name}"))).len(), SMALL_RUNS);
    assert!(folder.path(&format!("results/{name}/report.html")).exists());
}

/// Starts each task of the array like the scheduler; `sbatch` is replaced by a script that records its arguments.
#[test]
fn the_batch_script_makes_all_runs() {
    let folder = small();
    let script = folder.done("experiment run small.toml --emit slurm --jobs 4");
    folder.write("batch.sh", &script);
    assert!(script.contains("#SBATCH --array=1-4\n"), "{script}");
    std::fs::create_dir(folder.path("bin")).unwrap();
    folder.write("bin/sbatch", "#!/bin/sh\nprintf '%s\\n' \"$@\" > collected\n");
    let chmod = Command::new("chmod").arg("+x").arg(folder.path("bin/sbatch")).status();
    assert!(chmod.unwrap().success());
    let path = format!("{}:{}", folder.path("bin").display(), std::env::var("PATH").unwrap());
    for task in 1..=4 {
        let status = Command::new("bash")
            .arg("batch.sh")
            .current_dir(folder.path(""))
            .env("PATH", &path)
            .env("SLURM_ARRAY_TASK_ID", task.to_string())
            .env("SLURM_ARRAY_JOB_ID", "77")
            .output()
            .unwrap();
        assert!(status.status.success(), "{}", String::from_utf8_lossy(&status.stderr));
    }
    assert_eq!(outcomes(&folder.path("results/small")).len(), SMALL_RUNS);
    let collected = std::fs::read_to_string(folder.path("collected")).unwrap();
    assert!(collected.contains("--dependency=afterok:77"), "{collected}");
    assert!(collected.contains(PROGRAM) && collected.contains("experiment report results/small"));
}

/// The meshes of a batch are divided among jobs by both scripts, with the options for all of them.
#[test]
fn a_batch_is_divided_among_jobs() {
    let folder = Folder::new();
    let p = Array2::from_shape_fn((32, 2), |(j, p)| if (j < 16) == (p == 0) { 0.9 } else { 0.1 });
    folder.array("p.npy", &p);
    let list = "scans {i} it's.csv";
    let rows = |out: &str| {
        let row = |i: usize| format!("grid:4x4,p.npy,{out}-{i}\n");
        format!("mesh,probabilities,out\n{}", (0..3).map(row).collect::<String>())
    };
    let emitted = |cluster: &str| {
        let line = ["batch", list, "--resume", "--emit", cluster, "--jobs", "2", "--"];
        let output = Command::new(PROGRAM)
            .args(line)
            .args(["--on", "faces", "--no-preview"])
            .current_dir(folder.path(""))
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        output.stdout
    };
    let done = |out: &str| {
        for i in 0..3 {
            let found = folder.path(&format!("{out}-{i}/summary.json"));
            assert!(found.exists(), "{}", found.display());
            assert!(!folder.path(&format!("{out}-{i}/preview.png")).exists());
        }
    };
    folder.write(list, rows("slurm"));
    folder.write("batch.sh", emitted("slurm"));
    for task in 1..=2 {
        let output = Command::new("bash")
            .arg("batch.sh")
            .current_dir(folder.path(""))
            .env("SLURM_ARRAY_TASK_ID", task.to_string())
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(String::from_utf8_lossy(&output.stdout).lines().count(), 3 - task);
    }
    done("slurm");

    folder.write(list, rows("snakemake"));
    folder.write("Snakefile", emitted("snakemake"));
    let output = snakemake(&folder);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    done("snakemake");
}
