//! The results that a paper cites, held against their runs: complete, of the current experiment file, of one machine and one
//! clean program, and equal to what a report makes of the runs now.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::source::commands;
use crate::counted::counted;
use crate::error::{Error, Result};
use crate::experiment::{Done, Store, report_vector};
use crate::file;

/// The results of one experiment.
pub struct Results {
    pub folder: PathBuf,
    /// The names of its numbers and captions, as they are typed.
    pub names: BTreeSet<String>,
    /// What is wrong with them, a sentence each.
    pub faults: Vec<String>,
    /// The versions of the programs that made its runs.
    pub versions: BTreeSet<String>,
}

/// Reads and checks the results in a folder; `version` is that of this program.
///
/// # Errors
/// The folder has no runs, or a file in it is damaged.
pub fn results(folder: &Path, version: &str) -> Result<Results> {
    let numbers = folder.join("numbers.tex");
    let text = text(&numbers)?;
    let done = Done::all(&Store::open(folder.to_owned())?)?;
    let mut faults = Vec::new();
    faults.extend(experiment_file(folder)?);
    faults.extend(made_again(folder, version)?);
    faults.extend(runs(folder, &done));
    faults.extend(uncommitted(folder));
    let versions = done.iter().map(|run| run.manifest.program.version.clone()).collect();
    let names = commands(&text)
        .filter(|command| command.name == "detokenize")
        .filter_map(|command| command.arguments.first().map(|name| (*name).to_owned()))
        .collect();
    Ok(Results { folder: folder.to_owned(), names, faults, versions })
}

fn text(path: &Path) -> Result<String> {
    String::from_utf8(file::read(path)?).map_err(|_| Error::malformed(path, "is not text in UTF-8"))
}

/// The experiment file beside the results, if there is one, is the one that was run.
fn experiment_file(folder: &Path) -> Result<Option<String>> {
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    let root = folder.parent().and_then(Path::parent).unwrap_or(Path::new("."));
    let path = root.join("experiments").join(format!("{name}.toml"));
    if !path.is_file() || file::read(&path)? == file::read(&folder.join("experiment.toml"))? {
        return Ok(None);
    }
    Ok(Some(format!(
        "{} has changed since {} was made; `meshseg experiment run {0}` and `meshseg experiment report {1}` renew it",
        path.display(),
        folder.display()
    )))
}

/// What a report makes of the runs differs nowhere from what the folder has.
fn made_again(folder: &Path, version: &str) -> Result<Vec<String>> {
    let again =
        tempfile::tempdir().map_err(|error| Error::io(Path::new("a temporary folder"), error))?;
    for part in ["figures", "tables"] {
        // Figures of surfaces that are not there are kept, together with their captions.
        copy(&folder.join(part), &again.path().join(part))?;
    }
    let report = report_vector(folder, again.path(), version)?;
    let renewal = format!("`meshseg experiment report {}` renews it", folder.display());
    let mut faults = Vec::new();
    if report.missing > 0 {
        faults.push(format!(
            "{}: {} of {} runs are missing; `meshseg experiment run` makes them",
            folder.display(),
            report.missing,
            report.missing + report.runs
        ));
    }
    let stem = |path: &Path| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        name.split('.').next().unwrap_or_default().to_owned()
    };
    let mut names = compared(folder)?;
    for made in compared(again.path())? {
        if !names.contains(&made) {
            faults.push(format!("{} is missing; {renewal}", folder.join(&made).display()));
        }
    }
    names.retain(|name| {
        let is_known = name.parent() == Some(Path::new("")) || report.names.contains(&stem(name));
        if !is_known {
            faults.push(format!(
                "{} is not of a figure or table in {}; remove it",
                folder.join(name).display(),
                folder.join("experiment.toml").display()
            ));
        }
        is_known
    });
    for name in names {
        let (kept, made) = (folder.join(&name), again.path().join(&name));
        let (kept_bytes, made_bytes) = (file::read(&kept)?, file::read(&made)?);
        if kept_bytes == made_bytes {
            continue;
        }
        let lines = |bytes: &[u8]| {
            String::from_utf8_lossy(bytes).lines().map(String::from).collect::<Vec<_>>()
        };
        let place = if name.extension().is_some_and(|extension| extension == "pdf") {
            String::new()
        } else {
            let (kept, made) = (lines(&kept_bytes), lines(&made_bytes));
            let first = kept.iter().zip(&made).position(|(kept, made)| kept != made);
            format!(", line {}", 1 + first.unwrap_or(kept.len().min(made.len())))
        };
        faults.push(format!("{}{place}: is not what the runs give; {renewal}", kept.display()));
    }
    Ok(faults)
}

/// The files that are made of the runs and compared, relative to the folder.
fn compared(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut names = vec![PathBuf::from("numbers.tex")];
    for part in ["figures", "tables"] {
        for path in listed(&folder.join(part))? {
            let is_compared = path.extension().is_some_and(|extension| {
                ["svg", "pdf", "tex", "dat", "csv", "md", "txt", "json"]
                    .iter()
                    .any(|known| extension == *known)
            });
            if is_compared {
                names.push(path.strip_prefix(folder).unwrap_or(&path).to_owned());
            }
        }
    }
    Ok(names)
}

fn listed(folder: &Path) -> Result<Vec<PathBuf>> {
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let entries = fs::read_dir(folder).map_err(|error| Error::io(folder, error))?;
    let mut paths = Vec::new();
    for entry in entries {
        paths.push(entry.map_err(|error| Error::io(folder, error))?.path());
    }
    paths.sort();
    Ok(paths)
}

fn copy(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir_all(to).map_err(|error| Error::io(to, error))?;
    for path in listed(from)? {
        let target = to.join(path.file_name().unwrap_or_default());
        fs::copy(&path, &target).map_err(|error| Error::io(&path, error))?;
    }
    Ok(())
}

/// The runs are of one machine and of a clean program.
fn runs(folder: &Path, done: &[Done]) -> Vec<String> {
    let mut faults = Vec::new();
    let hosts: BTreeSet<&str> = done.iter().map(|run| &run.manifest.machine.host[..]).collect();
    if hosts.len() > 1 {
        faults.push(format!(
            "the runs of {} are from {} machines, whose times cannot be compared; `meshseg experiment run --force` makes \
             them on one",
            folder.display(),
            hosts.len()
        ));
    }
    if let Some(run) = done.iter().find(|run| run.manifest.program.dirty) {
        faults.push(format!(
            "run {} of {} was made by a program with changes that are in no commit; make it again after committing them",
            run.manifest.id,
            folder.display()
        ));
    }
    faults
}

/// In a repository, all runs are in the last commit, and nothing in the folder has changed since; without git, or outside a
/// repository, nothing is known.
fn uncommitted(folder: &Path) -> Option<String> {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").arg("-C").arg(folder).args(arguments).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
    };
    git(&["rev-parse", "--is-inside-work-tree"]).filter(|inside| inside.trim() == "true")?;
    let committed = git(&["ls-tree", "-r", "--name-only", "-z", "HEAD", "."]).unwrap_or_default();
    let changed = git(&["status", "--porcelain", "-z", "--", "."]).unwrap_or_default();
    let runs = listed(&folder.join("runs")).unwrap_or_default();
    let is_lost = |run: &&PathBuf| {
        let manifest =
            format!("runs/{}/manifest.json", run.file_name().unwrap_or_default().to_string_lossy());
        run.is_dir() && !committed.split('\0').any(|name| name.ends_with(&manifest))
    };
    let (lost, changed) = (
        runs.iter().filter(is_lost).count(),
        changed.split('\0').filter(|it| !it.is_empty()).count(),
    );
    (lost + changed > 0).then(|| {
        format!(
            "{}: {} and {} not committed; `git add {0}` and commit",
            folder.display(),
            counted(lost, "run", "runs"),
            counted(changed, "changed file is", "changed files are")
        )
    })
}
