//! The program: the command line, one file per verb. The only room that prints: data to stdout, everything else to stderr.
//! [`call`] is the command line for programs in the same process, which get in memory what a shell finds in files.
//!
//! Exit codes: 0 success, 1 bad input or I/O error, 2 usage, 130 interrupted (results so far are written completely).

mod batch;
mod call;
mod compare;
mod completions;
mod cut;
mod evaluate;
mod experiment;
mod inputs;
mod interrupt;
mod listener;
mod means;
mod memory;
mod mesh;
mod operators;
mod output;
mod pairs;
mod paper;
mod preview;
mod problem;
mod progress;
mod reconstruct;
mod render;
mod seeds;
mod segment;
mod solve;
mod solvers;
mod solving;
mod table;
mod views;
mod welding;

use std::ffi::OsString;
use std::io;
use std::iter::once;

use clap::{CommandFactory, Parser, Subcommand};

use crate::run::Status;
use crate::{Error, sweep};

pub use call::{Refused, call};
pub use listener::{Found, Listener};
pub use memory::Memory;
use output::{Failure, Outcome, named, note, one_line, print, print_json, shard, warn};

/// Convex multi-region segmentation of data on triangle meshes, with certified optimality gaps.
#[derive(Parser)]
#[command(name = "meshseg", version, max_term_width = 100, after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

const EXAMPLES: &str = "\
Examples:
  meshseg segment builtin:spot --regions 3 --out results/spot
  meshseg segment person.ply --regions 4 --out results/person
  meshseg segment bunny.ply --data curvature --regions 3 --out results/bunny
  meshseg solve mesh.ply --costs S.npy --lambda 0.01 --gap 1e-5 --out results/mesh

MESH is a file (.obj, .ply, .off, .stl, .vtp, .vtu, .vtk, .gltf, .glb, .surf.gii, lh.white), builtin:spot, or a shape:
torus:400x250, sphere:6, grid:100x100, ellipsoid:6, peanut:6, dent:6, jaw:700x120, city:300x300.";

#[derive(Subcommand)]
enum Verb {
    Segment(Box<segment::Arguments>),
    Batch(batch::Arguments),
    Solve(Box<solve::Arguments>),
    Evaluate(evaluate::Arguments),
    Compare(compare::Arguments),
    Render(render::Arguments),
    Reconstruct(reconstruct::Arguments),
    Operators(operators::Arguments),
    #[command(subcommand)]
    Mesh(mesh::Verb),
    #[command(subcommand)]
    Problem(problem::Verb),
    #[command(subcommand)]
    Experiment(experiment::Verb),
    #[command(subcommand)]
    Paper(paper::Verb),
    Solvers(solvers::Arguments),
    Completions(completions::Arguments),
}

/// Runs the program with the arguments that follow its name, and returns its exit code. Ctrl-C, the log and the standard
/// streams are those of the process. `program` are the words that start the program anew.
pub fn main(program: &[OsString], arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let cli = match Cli::try_parse_from(once("meshseg".into()).chain(arguments)) {
        Ok(cli) => cli,
        // Help and the version are such errors as well.
        Err(error) => {
            // A reader that has seen enough is no error.
            let _ = error.print();
            return error.exit_code() as u8;
        }
    };
    tracing_subscriber::fmt()
        .with_writer(io::stderr)
        .with_target(false)
        .without_time()
        .log_internal_errors(false)
        .with_ansi(io::IsTerminal::is_terminal(&io::stderr()))
        .init();
    interrupt::listen();
    let checked = sweep::check_environment().map_err(Failure::from);
    match checked.and_then(|()| cli.verb.run(program)) {
        Ok(()) => 0,
        Err(Failure::Input(error)) => {
            note(&format!("error: {}", one_line(&error.to_string())));
            if let Error::Format(error) = &error {
                experiment::draw(error);
            }
            1
        }
        // The reader of a pipe has closed it.
        Err(Failure::Output(error)) if error.kind() == io::ErrorKind::BrokenPipe => 0,
        Err(Failure::Output(error)) => {
            note(&format!("error: standard output: {error}"));
            1
        }
        Err(Failure::Interrupted) => 130,
        Err(Failure::Contradicted) => {
            note(&format!("error: {}", Status::Contradicted.sentence()));
            1
        }
    }
}

impl Verb {
    fn run(&self, program: &[OsString]) -> Outcome {
        match self {
            Verb::Segment(arguments) => segment::run(arguments),
            Verb::Batch(arguments) => batch::run(arguments, program),
            Verb::Solve(arguments) => solve::run(arguments),
            Verb::Evaluate(arguments) => evaluate::run(arguments),
            Verb::Compare(arguments) => compare::run(arguments),
            Verb::Render(arguments) => render::run(arguments),
            Verb::Reconstruct(arguments) => reconstruct::run(arguments),
            Verb::Operators(arguments) => operators::run(arguments),
            Verb::Mesh(verb) => mesh::run(verb),
            Verb::Problem(verb) => problem::run(verb),
            Verb::Experiment(verb) => experiment::run(verb),
            Verb::Paper(verb) => paper::run(verb),
            Verb::Solvers(arguments) => solvers::run(arguments),
            Verb::Completions(arguments) => completions::run(arguments, &mut Cli::command()),
        }
    }
}
