//! How verbs end and print.

use std::io::{self, Write};

use clap::builder::{PossibleValuesParser, TypedValueParser};

use crate::Error;
use crate::names::Named;

use super::listener::listening;

/// Why a verb failed.
pub(super) enum Failure {
    Input(Error),
    /// Standard output is closed or full.
    Output(io::Error),
    /// The user interrupted the run; its results so far are written.
    Interrupted,
    /// A bound exceeds an energy; the results are written.
    Contradicted,
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Failure::Input(error)
    }
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Failure::Output(error)
    }
}

pub(super) type Outcome = Result<(), Failure>;

pub(super) fn one_line(message: &str) -> String {
    message.replace(['\n', '\r'], " ")
}

pub(super) fn print(text: &str) -> io::Result<()> {
    if listening(|listener| listener.printed += text).is_some() {
        return Ok(());
    }
    let mut stdout = io::stdout().lock();
    stdout.write_all(text.as_bytes())?;
    stdout.flush()
}

/// Prints a line to stderr. If that is closed, as when Ctrl-C ends the other programs of a pipe, work continues.
pub(super) fn note(line: &str) {
    if listening(|listener| listener.notes.push(line.to_owned())).is_some() {
        return;
    }
    let _ = writeln!(io::stderr(), "{line}");
}

pub(super) fn print_json(value: &impl serde::Serialize) -> io::Result<()> {
    print(&(json(value) + "\n"))
}

pub(super) fn json(value: &impl serde::Serialize) -> String {
    serde_json::to_string_pretty(value).expect("maps with text as keys, and no errors of its own")
}

pub(super) fn warn(warnings: &[String]) {
    for warning in warnings {
        tracing::warn!("{warning}");
    }
}

/// Parses a value from one of its names.
pub(super) fn named<T: Named + Send + Sync + 'static>() -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(T::names())
        .map(|name| T::named(&name).expect("one of the possible values"))
}

/// Parses `I/N`: the I-th of N parts.
pub(super) fn shard(text: &str) -> Result<(usize, usize), String> {
    let parsed = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    match parsed {
        Some((i, n)) if (1..=n).contains(&i) => Ok((i, n)),
        _ => Err("must have the form I/N with 1 <= I <= N".into()),
    }
}
