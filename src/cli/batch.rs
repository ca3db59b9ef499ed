//! `meshseg batch`: `segment` for many meshes, one line each.
//!
//! Each mesh is a process of its own, so that a mesh that fails, or needs too much memory, ends none of the others.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use clap::Args;
use serde_json::Value;

use crate::counted::counted;
use crate::experiment::{Cluster, Work, operand};
use crate::{Error, Result, file};

use super::output::{Failure, Outcome, note, one_line, print, shard};
use super::solving::percent_or_less;
use super::{interrupt, named, segment};

/// Segment many meshes, one line each, and go on after one that fails.
///
/// LIST.csv has the header mesh,out and further columns named after options of `segment`, such as probabilities or
/// lambda; a row is a mesh with its values, and an empty cell leaves the option out. Paths are relative to the current
/// folder.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Table of meshes
    list: PathBuf,

    /// Only every N-th mesh, starting with the I-th
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<(usize, usize)>,

    /// Leave out meshes whose folder has a result
    #[arg(long)]
    resume: bool,

    /// Segment nothing; print a script that does all meshes on a cluster. Its jobs start in the current folder
    #[arg(long, value_name = "CLUSTER", value_parser = named::<Cluster>(), conflicts_with = "shard")]
    emit: Option<Cluster>,

    /// Number of jobs that --emit divides the meshes among [default: one per mesh, at most 100]
    #[arg(long, value_name = "N", requires = "emit", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    jobs: Option<u32>,

    /// Options of segment for all meshes
    #[arg(last = true, value_name = "OPTIONS")]
    options: Vec<String>,
}

const EXAMPLES: &str = "\
Examples:
  meshseg batch scans.csv -- --on faces --min-area 0.1%
  meshseg batch scans.csv --resume
  meshseg batch scans.csv --resume --emit slurm --jobs 8 -- --on faces > scans.sh; sbatch scans.sh

scans.csv:
  mesh,probabilities,out
  a.ply,a.npy,results/a
  b.ply,b.npy,results/b";

/// A row of the list.
struct Row {
    mesh: String,
    out: PathBuf,
    /// The options with their values.
    options: Vec<String>,
}

/// `program` starts the program anew.
pub fn run(arguments: &Arguments, program: &[OsString]) -> Outcome {
    let rows = rows(&arguments.list)?;
    if let Some(cluster) = arguments.emit {
        let jobs = arguments.jobs.map(|n| n as usize);
        return Ok(print(&arguments.work(rows.len(), program)?.script(cluster, jobs))?);
    }
    let (first, step) = arguments.shard.unwrap_or((1, 1));
    let rows: Vec<&Row> = rows.iter().skip(first - 1).step_by(step).collect();
    interrupt::keep_results();
    let (mut failed, mut skipped) = (0, 0);
    for row in &rows {
        if arguments.resume && row.out.join("summary.json").is_file() {
            skipped += 1;
            continue;
        }
        let line = match labeled(program, row, &arguments.options)? {
            Ended::Done(line) => line,
            Ended::Failed(line) => {
                failed += 1;
                line
            }
            Ended::Interrupted => return Err(Failure::Interrupted),
        };
        print(&(line + "\n"))?;
        if interrupt::requested() {
            return Err(Failure::Interrupted);
        }
    }
    let kept = match skipped {
        0 => String::new(),
        n => format!(", {n} had results before"),
    };
    note(&format!(
        "{} of {}{kept}, {failed} failed",
        rows.len() - failed - skipped,
        counted(rows.len(), "mesh segmented", "meshes segmented")
    ));
    match failed {
        0 => Ok(()),
        _ => Err(Error::unsuitable(format!(
            "{} failed; see the lines above",
            counted(failed, "mesh", "meshes")
        ))
        .into()),
    }
}

impl Arguments {
    /// The batch as work for a cluster.
    fn work(&self, parts: usize, program: &[OsString]) -> Result<Work> {
        let text = |word: &std::ffi::OsStr| {
            word.to_str().map(str::to_owned).ok_or_else(|| {
                let name = word.to_string_lossy();
                Error::unsuitable(format!("{name}: is not UTF-8, as a script must be; rename it"))
            })
        };
        let mut command: Vec<String> =
            program.iter().map(|word| text(word)).collect::<Result<_>>()?;
        let list = operand(&text(self.list.as_os_str())?);
        command.extend(["batch".into(), list.clone()]);
        command.extend(self.resume.then(|| "--resume".into()));
        let stem = self.list.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut behind = self.options.clone();
        if !behind.is_empty() {
            behind.insert(0, "--".into());
        }
        Ok(Work {
            title: format!("All meshes of {list}"),
            name: stem.clone(),
            parts,
            command,
            behind,
            end: None,
            folder: format!("{stem}-batch"),
            threads: None,
        })
    }
}

/// How a mesh ended, with its line.
enum Ended {
    Done(String),
    Failed(String),
    Interrupted,
}

fn labeled(program: &[OsString], row: &Row, common: &[String]) -> Result<Ended> {
    let begin = Instant::now();
    let Some((name, first)) = program.split_first() else {
        return Err(Error::unsuitable(
            "a batch starts the program for each mesh: run it from a shell",
        ));
    };
    let output = Command::new(name)
        .args(first)
        .args(["segment", &row.mesh])
        .args(&row.options)
        .args(common)
        .arg("--out")
        .arg(&row.out)
        .stdin(Stdio::null())
        .output()
        .map_err(|error| Error::unsuitable(format!("segment cannot be started: {error}")))?;
    if output.status.code() == Some(130) {
        return Ok(Ended::Interrupted);
    }
    let messages = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        let error = messages.lines().find(|line| line.starts_with("error: "));
        let reason = match error.or_else(|| messages.lines().last()) {
            Some(line) => line.to_owned(),
            None => format!("error: segment ended with {}", output.status),
        };
        return Ok(Ended::Failed(one_line(&format!("{}: {reason}", row.mesh))));
    }
    let path = row.out.join("summary.json");
    let summary: Value = serde_json::from_slice(&file::read(&path)?)
        .map_err(|error| Error::malformed(&path, format!("is not JSON: {error}")))?;
    let number = |key: &str| summary.get(key).and_then(Value::as_f64);
    let share = number("rounded_relative_gap").map_or_else(
        || "without a bound".to_owned(),
        |share| format!("at most {} above any labeling", percent_or_less(share)),
    );
    let warnings = summary.get("warnings").and_then(Value::as_array).map_or(0, Vec::len);
    let warned = match warnings {
        0 => String::new(),
        n => format!(", {}", counted(n, "warning", "warnings")),
    };
    let status = summary.get("status").and_then(Value::as_str).unwrap_or("unknown");
    let count = |key: &str| summary.get(key).and_then(Value::as_u64).unwrap_or(0);
    Ok(Ended::Done(one_line(&format!(
        "{}: {status}, {} faces, {} regions, labels {share}, {:.1} s{warned}, {}",
        row.mesh,
        count("faces"),
        count("regions"),
        begin.elapsed().as_secs_f64(),
        row.out.display()
    ))))
}

/// The rows of a list.
///
/// # Errors
/// The file cannot be read, has no mesh or out, a column that is no option, or two rows with one folder.
fn rows(path: &Path) -> Result<Vec<Row>> {
    let bytes = file::read(path)?;
    let malformed = |error: csv::Error| Error::malformed(path, error.to_string());
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(&bytes[..]);
    let header: Vec<String> =
        reader.headers().map_err(malformed)?.iter().map(str::to_owned).collect();
    for (column, name) in header.iter().enumerate() {
        check_column(path, name, header[..column].contains(name))?;
    }
    let at = |name: &str| header.iter().position(|column| column == name);
    let (Some(mesh), Some(out)) = (at("mesh"), at("out")) else {
        let message = "must begin with a line that names the columns, among them mesh and out";
        return Err(Error::malformed_line(path, 1, message));
    };
    let mut rows = Vec::new();
    let mut folders: BTreeMap<PathBuf, usize> = BTreeMap::new();
    for record in reader.records() {
        let record = record.map_err(malformed)?;
        let line = record.position().map_or(0, csv::Position::line) as usize;
        let wrong = |message: String| Error::malformed_line(path, line, message);
        if record[mesh].is_empty() || record[out].is_empty() {
            return Err(wrong("needs a mesh and an output folder".into()));
        }
        let folder = PathBuf::from(&record[out]);
        if let Some(other) = folders.insert(folder.clone(), line) {
            return Err(wrong(format!(
                "writes to {}, as line {other} does; choose another folder",
                folder.display()
            )));
        }
        let given = header.iter().zip(&record).enumerate();
        let options = given
            .filter(|&(column, (_, value))| column != mesh && column != out && !value.is_empty())
            .map(|(_, (name, value))| format!("--{name}={value}"));
        rows.push(Row { mesh: record[mesh].to_owned(), out: folder, options: options.collect() });
    }
    if rows.is_empty() {
        return Err(Error::malformed(path, "has no meshes"));
    }
    Ok(rows)
}

fn check_column(path: &Path, name: &str, again: bool) -> Result<()> {
    let wrong = |message: String| Err(Error::malformed_line(path, 1, message));
    if again {
        return wrong(format!("has the column {name} twice"));
    }
    if name == "mesh" {
        return Ok(());
    }
    let segment = segment::Arguments::augment_args(clap::Command::new("segment"));
    let option = segment.get_arguments().find(|option| option.get_long() == Some(name));
    match option {
        Some(option) if option.get_action().takes_values() => Ok(()),
        Some(_) => wrong(format!("{name} has no value; give it for all meshes, behind --")),
        None => wrong(format!(
            "{name:?} is neither mesh nor an option of segment, such as out or probabilities"
        )),
    }
}
