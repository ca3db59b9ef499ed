//! The verbs for a program in the same process: `segment` and `solve` need no `--out`, files may be in memory, and what
//! is printed, warned of and found is returned.

use std::ffi::OsString;
use std::ops::ControlFlow;
use std::path::Path;

use clap::{CommandFactory, FromArgMatches};

use crate::Error;
use crate::run::{Sample, Status};

use super::listener::{Listener, with_threads};
use super::memory::Memory;
use super::output::{Failure, one_line};
use super::{Cli, Verb};

/// Why a verb has no result.
#[derive(Debug)]
pub enum Refused {
    /// The arguments are wrong, in one line.
    Usage(String),
    /// The input is wrong.
    Input(Error),
    /// `observe` ended the run before there was a result.
    Interrupted,
}

/// Runs a verb with the arguments of the command line, from the name of the verb on. All threads are those of the
/// call. `observe` is called between the passes of a solver, with a sample where one was taken; it may end the run.
///
/// # Errors
/// Wrong arguments, wrong input, and an end by `observe` before there is a result.
pub fn call(
    arguments: impl IntoIterator<Item = OsString>,
    memory: Memory,
    observe: impl FnMut(Option<&Sample>) -> ControlFlow<()> + Send + 'static,
) -> Result<Listener, Refused> {
    let verb = parsed(arguments, memory)?;
    let listener = Listener::new(observe);
    let (outcome, listener) = listener.hear(|| with_threads(None, || verb.run(&[])));
    match outcome.map_err(Refused::Input)? {
        Ok(()) => Ok(listener),
        Err(Failure::Interrupted) if listener.found.is_some() => Ok(listener),
        Err(Failure::Interrupted) => Err(Refused::Interrupted),
        Err(Failure::Input(error)) => Err(Refused::Input(error)),
        Err(Failure::Output(error)) => {
            Err(Refused::Input(Error::io(Path::new("standard output"), error)))
        }
        Err(Failure::Contradicted) => {
            Err(Refused::Input(Error::unsuitable(Status::Contradicted.sentence())))
        }
    }
}

/// The verb, with what is in memory.
fn parsed(arguments: impl IntoIterator<Item = OsString>, memory: Memory) -> Result<Verb, Refused> {
    let mut command = Cli::command();
    for name in ["segment", "solve"] {
        command =
            command.mut_subcommand(name, |verb| verb.mut_arg("out", |out| out.required(false)));
    }
    let arguments = std::iter::once("meshseg".into()).chain(arguments);
    let parsed = command
        .try_get_matches_from(arguments)
        .and_then(|matches| Cli::from_arg_matches(&matches))
        .map_err(|error| Refused::Usage(sentence(&error)))?;
    let mut verb = parsed.verb;
    match &mut verb {
        Verb::Segment(arguments) => arguments.memory = memory,
        Verb::Solve(arguments) => arguments.memory = memory,
        Verb::Evaluate(arguments) => arguments.memory = memory,
        _ => {}
    }
    Ok(verb)
}

/// What is wrong with arguments, without how to use them.
fn sentence(error: &clap::Error) -> String {
    let text = error.render().to_string();
    let parts = text.split("\n\n").map(one_line);
    let parts =
        parts.take_while(|part| !part.starts_with("Usage") && !part.starts_with("For more"));
    let words: Vec<String> =
        parts.map(|part| part.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
    words.join("; ").trim_start_matches("error: ").to_owned()
}
