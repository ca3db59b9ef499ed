//! A paper that cites results by name: everything it names exists, comes from the runs, and no measurement is typed by hand.
//!
//! ```text
//! \resultsof{EXPERIMENT}                   reads numbers.tex
//! \result{EXPERIMENT/...}                  a number, a caption, how the runs were made
//! \resultfigure[...]{EXPERIMENT}{FIGURE}   a figure
//! \resultcaption{EXPERIMENT}{FIGURE}       its caption
//! \resulttable{EXPERIMENT}{TABLE}          a table
//! \fact{12 s}{KEY}                         a number from elsewhere, with the entry of the bibliography that has it
//! ```

mod results;
mod source;
mod typed;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::file;
use results::Results;
use source::{Missing, Source, commands};

/// Commands that cite.
const CITATIONS: [&str; 14] = [
    "autocite",
    "cite",
    "citealp",
    "citealt",
    "citeauthor",
    "citep",
    "citet",
    "Citet",
    "citeyear",
    "footcite",
    "nocite",
    "parencite",
    "textcite",
    "Cite",
];

/// What a paper cites, and what is wrong.
#[derive(Debug, Default)]
pub struct Checked {
    /// Number of different numbers, captions and other texts.
    pub names: usize,
    /// Number of figures.
    pub figures: usize,
    /// Number of tables.
    pub tables: usize,
    /// Number of experiments.
    pub experiments: usize,
    /// A sentence for each fault, with file and line.
    pub faults: Vec<String>,
}

/// Checks the paper whose text starts in `main.tex` of a folder, against the results in `../results` beside it; `version`
/// is that of this program.
///
/// # Errors
/// A file of the paper, or of results that it names, cannot be read.
pub fn check(folder: &Path, version: &str) -> Result<Checked> {
    let (sources, missing) = source::sources(folder)?;
    let results = without_parents(&folder.join("..").join("results"));
    let mut paper = Paper { folder, results, cited: BTreeMap::new(), checked: Checked::default() };
    for Missing { path, line, message } in missing {
        paper.checked.faults.push(format!("{}, line {line}: {message}", path.display()));
    }
    paper.read_results(&sources, version)?;
    for source in &sources {
        paper.check_commands(source);
        for number in typed::typed(&source.text) {
            paper.fault(
                source,
                number.line,
                &format!(
                    "{:?} is typed by hand; cite it as \\result{{EXPERIMENT/TABLE/INSTANCE/SOLVER/COLUMN}}, or mark a fact \
                     from elsewhere: \\fact{{{}}}{{KEY}}",
                    number.text, number.text
                ),
            );
        }
    }
    paper.check_versions(&sources);
    paper.check_keys(&sources)?;
    Ok(paper.checked)
}

/// A path without `name/..`.
fn without_parents(path: &Path) -> PathBuf {
    let mut short = PathBuf::new();
    for part in path.components() {
        let is_up = part == std::path::Component::ParentDir;
        let has_name =
            matches!(short.components().next_back(), Some(std::path::Component::Normal(_)));
        if is_up && has_name {
            short.pop();
        } else {
            short.push(part);
        }
    }
    short
}

struct Paper<'a> {
    folder: &'a Path,
    results: PathBuf,
    /// The results by the name of their experiment.
    cited: BTreeMap<String, Results>,
    checked: Checked,
}

impl Paper<'_> {
    fn fault(&mut self, source: &Source, line: usize, message: &str) {
        self.checked.faults.push(format!("{}, line {line}: {message}", source.path.display()));
    }

    fn read_results(&mut self, sources: &[Source], version: &str) -> Result<()> {
        for source in sources {
            for command in commands(&source.text).filter(|command| command.name == "resultsof") {
                let Some(&name) = command.arguments.first() else { continue };
                if name.starts_with('#') {
                    continue;
                }
                let folder = self.results.join(name);
                let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
                if name.is_empty() || name.starts_with('.') || !name.chars().all(is_plain) {
                    let message =
                        format!("{name:?} is not the name of an experiment, a folder in results");
                    self.fault(source, command.line, &message);
                } else if !folder.join("numbers.tex").is_file() {
                    let message = format!(
                        "there are no results of {name:?}; `meshseg experiment run experiments/{name}.toml` and \
                         `meshseg experiment report {}` make them",
                        folder.display()
                    );
                    self.fault(source, command.line, &message);
                } else if !self.cited.contains_key(name) {
                    let mut results = results::results(&folder, version)?;
                    self.checked.faults.append(&mut results.faults);
                    self.cited.insert(name.to_owned(), results);
                }
            }
        }
        self.checked.experiments = self.cited.len();
        Ok(())
    }

    fn check_commands(&mut self, source: &Source) {
        let mut names = BTreeSet::new();
        for command in commands(&source.text) {
            let named: &[&str] = &command.arguments;
            let is_ours =
                ["result", "resultfigure", "resultcaption", "resulttable"].contains(&command.name);
            let fault = match (command.name, named) {
                (name, arguments) if is_ours && arguments.iter().any(|it| it.contains('#')) => {
                    Some(format!(
                        "\\{name} with an argument of a macro cannot be checked; write it out where it is used"
                    ))
                }
                ("result", [name, ..]) => {
                    names.insert(one_spaced(name));
                    self.name_fault(&one_spaced(name))
                }
                ("resultcaption", [experiment, figure, ..]) => {
                    let name = format!("{experiment}/{figure}/caption");
                    names.insert(name.clone());
                    self.name_fault(&name)
                }
                ("resultfigure", [experiment, figure, ..]) => {
                    self.checked.figures += 1;
                    self.file_fault(experiment, "figures", figure, &["pdf", "png"])
                        .or_else(|| self.file_fault(experiment, "figures", figure, &["runs.json"]))
                }
                ("resulttable", [experiment, table, ..]) => {
                    self.checked.tables += 1;
                    self.file_fault(experiment, "tables", table, &["tex"])
                }
                (name, _) if is_ours => Some(format!("\\{name} has no arguments in braces")),
                ("includegraphics", [path, ..]) if !path.contains(['#', '\\']) => {
                    let path = self.folder.join(path);
                    let has =
                        |ending: &str| Path::new(&format!("{}{ending}", path.display())).is_file();
                    (!["", ".pdf", ".png", ".jpg"].into_iter().any(has))
                        .then(|| format!("there is no {}", path.display()))
                }
                ("subfile" | "import" | "subimport" | "InputIfFileExists", _) => Some(format!(
                    "\\{} is not followed; read files with \\input{{FILE}}",
                    command.name
                )),
                _ => None,
            };
            if let Some(fault) = fault {
                self.fault(source, command.line, &fault);
            }
        }
        self.checked.names += names.len();
    }

    fn name_fault(&self, name: &str) -> Option<String> {
        let experiment = name.split('/').next().unwrap_or_default();
        match self.cited.get(experiment) {
            None => Some(format!(
                "\\result{{{name}}} needs \\resultsof{{{experiment}}} in the preamble"
            )),
            Some(results) if !results.names.contains(name) => Some(format!(
                "there is no result {name:?}; {} lists all names",
                results.folder.join("numbers.tex").display()
            )),
            Some(_) => None,
        }
    }

    /// A fault unless a file with one of the endings exists.
    fn file_fault(
        &self,
        experiment: &str,
        part: &str,
        stem: &str,
        endings: &[&str],
    ) -> Option<String> {
        let Some(results) = self.cited.get(experiment) else {
            return Some(format!(
                "what it shows needs \\resultsof{{{experiment}}} in the preamble"
            ));
        };
        let path = |ending: &&str| results.folder.join(part).join(format!("{stem}.{ending}"));
        if endings.iter().any(|ending| path(ending).is_file()) {
            return None;
        }
        Some(format!(
            "there is no {}; `meshseg experiment report {}` writes all of its experiment file",
            path(&endings[0]).display(),
            results.folder.display()
        ))
    }

    /// All runs are of one version, which the text names.
    fn check_versions(&mut self, sources: &[Source]) {
        let versions: BTreeSet<&str> =
            self.cited.values().flat_map(|results| &results.versions).map(|v| &v[..]).collect();
        if versions.len() > 1 {
            let versions: Vec<&str> = versions.into_iter().collect();
            self.checked.faults.push(format!(
                "the results are of the versions {}; make the older ones again with `meshseg experiment run --force`",
                versions.join(" and ")
            ));
        }
        let names_version =
            sources.iter().flat_map(|source| commands(&source.text)).any(|command| {
                command.name == "result"
                    && command.arguments.iter().any(|it| it.ends_with("/made/version"))
            });
        if self.cited.is_empty() {
            self.checked.faults.push(
                "the paper cites no results; \\resultsof{EXPERIMENT} in the preamble names them"
                    .to_owned(),
            );
        } else if !names_version {
            self.checked.faults.push(
                "the paper does not name the version of the program; cite \\result{EXPERIMENT/made/version}".to_owned(),
            );
        }
    }

    /// Citations and the sources of facts are in the bibliography.
    fn check_keys(&mut self, sources: &[Source]) -> Result<()> {
        let path = self.folder.join("references.bib");
        let bibliography = if path.is_file() {
            String::from_utf8(file::read(&path)?)
                .map_err(|_| Error::malformed(&path, "is not text in UTF-8"))?
        } else {
            String::new()
        };
        // @article{known, or @article ( known ,
        let entries: BTreeSet<&str> = bibliography
            .split('@')
            .filter_map(|entry| entry.split_once(['{', '(']))
            .filter(|(kind, _)| kind.trim().chars().all(|c| c.is_ascii_alphabetic()))
            .map(|(_, key)| key.split([',', '}', ')']).next().unwrap_or("").trim())
            .collect();
        for source in sources {
            for command in commands(&source.text) {
                let keys = match (command.name, &command.arguments[..]) {
                    ("fact", [_, keys]) => *keys,
                    ("fact", _) => {
                        self.fault(
                            source,
                            command.line,
                            "\\fact needs two arguments: \\fact{TEXT}{KEY}",
                        );
                        continue;
                    }
                    (name, [keys, ..]) if CITATIONS.contains(&name) => *keys,
                    _ => continue,
                };
                for key in keys.split(',').map(str::trim).filter(|key| !key.is_empty()) {
                    if !entries.contains(key) && !key.starts_with('#') {
                        let message = format!("{} has no entry {key:?}", path.display());
                        self.fault(source, command.line, &message);
                    }
                }
            }
        }
        Ok(())
    }
}

/// Line breaks and repeated spaces are one space, as in LaTeX.
fn one_spaced(name: &str) -> String {
    name.split_whitespace().collect::<Vec<_>>().join(" ")
}
