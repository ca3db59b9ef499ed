//! The program: parses the arguments, runs one verb and returns an exit code.

use std::env::{args_os, current_exe};
use std::process::ExitCode;

use mimalloc::MiMalloc;

#[global_allocator]
static ALLOCATOR: MiMalloc = MiMalloc;

fn main() -> ExitCode {
    let program = current_exe().map(Into::into).unwrap_or_else(|_| "meshseg".into());
    meshseg::cli::main(&[program], args_os().skip(1)).into()
}
