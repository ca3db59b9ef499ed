//! The runs of an experiment file, each with the name under which its results are stored.
//!
//! The name is a hash of the specification of the run, the content of the files it reads, its repetition and the
//! version of the program: whatever changes the result changes the name.

use sha2::{Digest, Sha256};
use toml::{Table, Value};

use super::folders::{Folders, InstanceError, hex};
use super::grid::Keys;
use super::spec::{InstanceCell, SolverCell, Spec};
use crate::error::Result;

/// The runs of a file in the order in which they are made: by instance, then by repetition, then by solver, so that a
/// temporary slowdown of the machine affects all solvers.
pub struct Plan<'a> {
    /// The file.
    pub spec: &'a Spec,
    /// All runs, or those of one shard.
    pub runs: Vec<Planned<'a>>,
    /// The labels of the instances that need the data folder.
    pub skipped: Vec<&'a str>,
}

/// One run of the file.
pub struct Planned<'a> {
    /// 16 hexadecimal digits, the name of the folder of its results.
    pub id: String,
    /// The instance that is solved.
    pub instance: &'a InstanceCell,
    /// A hash of the keys and the files of the instance.
    pub instance_id: String,
    /// The solver.
    pub solver: &'a SolverCell,
    /// Which repetition it is, from 0.
    pub repetition: u64,
    /// An experiment file for this run alone.
    pub toml: String,
}

impl<'a> Plan<'a> {
    /// The runs of a file; `version` is that of the program. Fails if files of instances or commands are missing or
    /// cannot be read.
    pub fn of(spec: &'a Spec, folders: &Folders, version: &str) -> Result<Self> {
        let (mut runs, mut skipped) = (Vec::new(), Vec::new());
        for instance in &spec.instances {
            let content = match folders.content(instance) {
                Ok(content) => content,
                Err(InstanceError::DataFolder) => {
                    skipped.push(instance.label.as_str());
                    continue;
                }
                Err(InstanceError::Error(error)) => {
                    return Err(spec.format_error(folders.blame(instance), error));
                }
            };
            let instance_id = identity(&[&instance_toml(instance), &content]);
            for repetition in 0..spec.repetitions {
                for solver in &spec.solvers {
                    if spec.includes(instance, solver) {
                        let toml = run_toml(spec, instance, solver);
                        let repeated = repetition.to_string();
                        let mut parts = vec![&toml[..], &content, &repeated, version];
                        let files = folders.solver(&solver.task)?;
                        parts.extend(files.as_deref());
                        let id = identity(&parts);
                        let instance_id = instance_id.clone();
                        runs.push(Planned { id, instance, instance_id, solver, repetition, toml });
                    }
                }
            }
        }
        Ok(Plan { spec, runs, skipped })
    }

    /// Keeps every N-th run from the i-th on, i counted from 1.
    pub fn shard(&mut self, (i, n): (usize, usize)) {
        let mut index = 0;
        self.runs.retain(|_| {
            index += 1;
            (index - 1) % n == i - 1
        });
    }
}

/// 64 bits of a hash, as hexadecimal digits.
fn identity(parts: &[&str]) -> String {
    let mut hash = Sha256::new();
    for part in parts {
        hash.update(part.len().to_le_bytes());
        hash.update(part);
    }
    hex(&hash.finalize()[..8])
}

fn table(keys: &Keys) -> Table {
    keys.iter()
        .filter(|(key, _)| !key.starts_with("options.") && key != "solver")
        .map(|(key, value)| (key.clone(), value.toml()))
        .collect()
}

fn instance_toml(instance: &InstanceCell) -> String {
    table(&instance.keys).to_string()
}

/// An experiment file for one run.
pub fn run_toml(spec: &Spec, instance: &InstanceCell, solver: &SolverCell) -> String {
    let mut stop = Table::new();
    let float = |x: f64| Value::Float(x);
    let count = |x: u64| Value::Integer(i64::try_from(x).unwrap_or(i64::MAX));
    let entries = [
        ("gap", spec.stop.relative_gap.map(float)),
        ("max-iterations", spec.stop.iterations.map(count)),
        ("time-limit", spec.stop.time.map(|limit| float(limit.as_secs_f64()))),
        ("check-every", spec.stop.interval.map(count)),
    ];
    for (key, value) in entries {
        if let Some(value) = value {
            stop.insert(key.into(), value);
        }
    }
    let mut one = Table::new();
    one.insert("name".into(), Value::String(solver.name.clone()));
    one.extend(table(&solver.keys));
    let options: Table = solver
        .keys
        .iter()
        .filter_map(|(key, value)| Some((key.strip_prefix("options.")?.to_owned(), value.toml())))
        .collect();
    if !options.is_empty() {
        one.insert("options".into(), Value::Table(options));
    }
    let mut all = Table::new();
    all.insert("stop".into(), Value::Table(stop));
    all.insert("instance".into(), Value::Array(vec![Value::Table(table(&instance.keys))]));
    all.insert("solver".into(), Value::Array(vec![Value::Table(one)]));
    all.to_string()
}
