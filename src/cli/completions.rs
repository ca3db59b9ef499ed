//! `meshseg completions SHELL`.

use clap::CommandFactory;
use clap_complete::Shell;

use super::{Cli, Outcome, print};

/// Print the completion script of a shell.
///
/// For example: meshseg completions bash > ~/.local/share/bash-completion/completions/meshseg
#[derive(clap::Args)]
pub struct Arguments {
    shell: Shell,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Cli::command(), "meshseg", &mut script);
    print(&String::from_utf8_lossy(&script))?;
    Ok(())
}
