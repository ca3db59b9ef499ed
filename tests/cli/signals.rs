//! Signals and closed pipes: results so far are kept, and nothing panics.

#![cfg(unix)]

use std::fs::{self, File};
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::support::{Folder, HANGS, PROGRAM, costs, names};

/// A process that is killed at the end of its test, even if the test fails.
struct Run(Child);

impl Drop for Run {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Run {
    /// A run in `folder/out` that does not reach its gap, since the smoothed energy has another minimizer.
    fn endless(folder: &Folder, stderr: Stdio) -> Self {
        folder.array("S.npy", &costs(1000, 3));
        let line = "solve torus:40x25 --costs S.npy --lambda 0.02 --gap 0 --max-iterations 100000000000 --solver fista \
            --threads 1 --out out";
        let command = Command::new(PROGRAM)
            .args(line.split_whitespace())
            .current_dir(folder.path(""))
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(stderr)
            .spawn();
        Run(command.unwrap())
    }

    fn signal(&self, name: &str) {
        let status = Command::new("kill").args([name, &self.0.id().to_string()]).status();
        assert!(status.unwrap().success());
    }

    fn end(&mut self) -> ExitStatus {
        let begin = Instant::now();
        loop {
            if let Some(status) = self.0.try_wait().unwrap() {
                return status;
            }
            assert!(begin.elapsed() < HANGS, "the program does not end");
            sleep(Duration::from_millis(10));
        }
    }

    /// Waits for a line of progress, after which the run handles signals.
    fn await_progress(&mut self) -> BufReader<std::process::ChildStderr> {
        let mut stderr = BufReader::new(self.0.stderr.take().unwrap());
        let mut line = String::new();
        stderr.read_line(&mut line).unwrap();
        assert!(line.starts_with("iteration "), "{line}");
        stderr
    }
}

#[test]
fn an_interrupted_run_keeps_its_results_so_far() {
    for signal in ["-INT", "-TERM"] {
        let folder = Folder::new();
        let mut run = Run::endless(&folder, Stdio::piped());
        let mut stderr = run.await_progress();
        run.signal(signal);
        assert_eq!(run.end().code(), Some(130), "{signal}");
        let mut rest = String::new();
        stderr.read_to_string(&mut rest).unwrap();
        assert!(!rest.contains("panicked"), "{rest}");

        assert_eq!(names(&folder.path("")), ["S.npy", "out"].map(String::from).into());
        assert_eq!(names(&folder.path("out")).len(), 6);
        let answer = folder.answer("out");
        assert_eq!(answer.status(), "interrupted");
        answer.assert_consistent();
        answer.assert_monotone_from(0);
        assert!(answer.number("iterations") > 0.0);
    }
}

/// Neither an incomplete file nor an incomplete folder remains.
#[test]
fn a_program_that_is_ended_while_writing_leaves_no_files() {
    let operators = "operators torus:400x250 --out out";
    let convert = "mesh convert torus:400x250 --subdivide 1 --out out.obj";
    for (line, signal) in [
        (operators, "-INT"),
        (operators, "-TERM"),
        (convert, "-INT"),
        ("mesh generate torus:800x500 --out out.off", "-TERM"),
    ] {
        let folder = Folder::new();
        let child = Command::new(PROGRAM)
            .args(line.split_whitespace())
            .current_dir(folder.path(""))
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn();
        let mut run = Run(child.unwrap());
        let begin = Instant::now();
        while names(&folder.path("")).is_empty() {
            assert!(begin.elapsed() < HANGS, "nothing is written");
            sleep(Duration::from_millis(1));
        }
        run.signal(signal);
        assert_eq!(run.end().code(), Some(130), "{line}");
        assert!(names(&folder.path("")).is_empty(), "{line}: {:?}", names(&folder.path("")));
    }
}

#[test]
fn a_killed_run_leaves_nothing() {
    let folder = Folder::new();
    let mut run = Run::endless(&folder, Stdio::piped());
    run.await_progress();
    run.signal("-KILL");
    assert_eq!(run.end().code(), None);
    assert_eq!(names(&folder.path("")), ["S.npy".to_owned()].into());
}

/// Ctrl-C in a terminal ends every program of a pipe, so that neither stream has a reader.
#[test]
fn an_interrupted_run_survives_the_end_of_its_readers() {
    let folder = Folder::new();
    let mut run = Run::endless(&folder, Stdio::piped());
    drop(run.await_progress());
    drop(run.0.stdout.take());
    // Long enough for a line of progress to be written to the closed pipe.
    sleep(Duration::from_secs(6));
    run.signal("-INT");
    assert_eq!(run.end().code(), Some(130));
    assert_eq!(folder.answer("out").status(), "interrupted");
}

#[test]
fn a_closed_pipe_is_not_an_error() {
    let folder = Folder::new();
    fs::write(folder.path("square.obj"), crate::support::SQUARE_OBJ).unwrap();
    for line in [
        "solvers",
        "completions bash",
        "mesh info square.obj",
        "mesh info square.obj --json",
        "operators square.obj --out operators",
        "segment grid:4x4 --data curvature --regions 2 --out out",
        "--help",
    ] {
        let mut child = Command::new(PROGRAM)
            .args(line.split_whitespace())
            .current_dir(folder.path(""))
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(File::create(folder.path("stderr")).unwrap())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let mut run = Run(child);
        assert_eq!(run.end().code(), Some(0), "{line}");
        let stderr = fs::read_to_string(folder.path("stderr")).unwrap();
        assert!(!stderr.contains("panicked") && !stderr.contains("error"), "{line}: {stderr}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_standard_output_is_an_error() {
    let output = Command::new(PROGRAM)
        .arg("solvers")
        .stdout(File::options().write(true).open("/dev/full").unwrap())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1));
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(stderr.starts_with("error: standard output: "), "{stderr}");
}
