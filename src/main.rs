//! Arguments, one call, an exit code.

mod cli;

#[cfg(target_os = "linux")]
#[global_allocator]
static ALLOCATOR: meshseg::memory::LargePages = meshseg::memory::LargePages;

fn main() -> std::process::ExitCode {
    cli::main()
}
