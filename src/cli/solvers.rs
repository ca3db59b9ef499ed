//! `meshseg solvers`: lists the solvers.

use std::fmt::Write;

use crate::solver::Method;

use super::{Outcome, print};

/// List the solvers: references, step rules, options and their defaults.
#[derive(clap::Args)]
pub struct Arguments {}

pub fn run(_: &Arguments) -> Outcome {
    let mut text = String::new();
    for mut method in Method::all() {
        let description = method.description();
        let default = if method == Method::default() { " (default)" } else { "" };
        let _ = writeln!(text, "{}{default}", description.name);
        let _ = writeln!(text, "    {}", description.summary);
        let _ = writeln!(text, "    reference  {}", description.reference);
        let _ = writeln!(text, "    steps      {}", description.steps);
        for setting in method.settings() {
            let _ = writeln!(
                text,
                "    --solver-option {}={}  [default: {}]",
                setting.key,
                setting.values(),
                setting.value()
            );
            let _ = writeln!(text, "               {}", setting.help);
        }
        text.push('\n');
    }
    text.push_str(
        "Every solver is certified: each sample has an energy E(U) and a true lower bound D(q) of all energies,\n\
         and a run stops by their relative gap, whatever the solver minimizes internally.\n",
    );
    print(&text)?;
    Ok(())
}
