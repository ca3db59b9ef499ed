//! `meshseg completions SHELL`.

use clap::Command;
use clap_complete::Shell;

use super::{Outcome, print};

/// Print a shell completion script.
///
/// For example: meshseg completions bash > ~/.local/share/bash-completion/completions/meshseg
#[derive(clap::Args)]
pub struct Arguments {
    shell: Shell,
}

/// `program` defines the whole command line.
pub fn run(arguments: &Arguments, program: &mut Command) -> Outcome {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, program, "meshseg", &mut script);
    print(&String::from_utf8_lossy(&script))?;
    Ok(())
}
