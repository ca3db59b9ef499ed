//! What verbs share: how they end, and what they print.

use std::io::{self, Write};

use clap::builder::{PossibleValuesParser, TypedValueParser};
use meshseg::Error;
use meshseg::names::Named;

/// Why a verb did not end well.
pub(super) enum Failure {
    Input(Error),
    /// Standard output is gone or full.
    Output(io::Error),
    /// The user broke off; what was reached is written.
    Interrupted,
    /// A bound exceeded an energy; what was reached is written.
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
    let mut stdout = io::stdout().lock();
    stdout.write_all(text.as_bytes())?;
    stdout.flush()
}

/// A line on stderr. If that is closed, as when Ctrl-C ends the rest of a pipe, the work still goes on.
pub(super) fn note(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}

pub(super) fn print_json(value: &impl serde::Serialize) -> io::Result<()> {
    let json = serde_json::to_string_pretty(value).map_err(io::Error::from)?;
    print(&(json + "\n"))
}

pub(super) fn warn(warnings: &[String]) {
    for warning in warnings {
        tracing::warn!("{warning}");
    }
}

/// A value given by one of its names.
pub(super) fn named<T: Named + Send + Sync + 'static>() -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(T::names())
        .map(|name| T::named(&name).expect("one of the possible values"))
}
