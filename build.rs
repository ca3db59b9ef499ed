//! What the manifests of experiments tell about the program: the commit, the compiler, the target.

use std::env;
use std::process::Command;

fn main() {
    let tell = |key: &str, value: &str| println!("cargo::rustc-env=MESHSEG_{key}={value}");
    let commit = said("git", &["rev-parse", "HEAD"]);
    let sources =
        ["status", "--porcelain", "--", "src", "assets", "build.rs", "Cargo.toml", "Cargo.lock"];
    let dirty = said("git", &sources).is_none_or(|changes| !changes.is_empty());
    tell("COMMIT", commit.as_deref().unwrap_or("unknown"));
    tell("DIRTY", if dirty { "true" } else { "false" });
    let rustc = env::var("RUSTC").expect("cargo names it");
    tell("RUSTC", said(&rustc, &["--version"]).as_deref().unwrap_or("unknown"));
    let variable = |name: &str| env::var(name).unwrap_or_default();
    tell("TARGET", &variable("TARGET"));
    tell("TARGET_FEATURES", &variable("CARGO_CFG_TARGET_FEATURE"));
}

/// What a program prints, if it ends well.
fn said(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
