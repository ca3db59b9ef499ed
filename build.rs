//! What the manifests of experiments tell about the program: the commit, the compiler, the target.

use std::env;
use std::path::Path;
use std::process::Command;

/// What the program is made of.
const SOURCES: [&str; 5] = ["src", "assets", "build.rs", "Cargo.toml", "Cargo.lock"];

fn main() {
    // Cargo would look at every file here otherwise, and results that a user leaves in the folder would rebuild all.
    let branch = said("git", &["symbolic-ref", "--quiet", "HEAD"]);
    let git = ["HEAD", "packed-refs"]
        .into_iter()
        .chain(branch.as_deref())
        .filter_map(|path| said("git", &["rev-parse", "--git-path", path]));
    for path in git.chain(SOURCES.map(String::from)) {
        if Path::new(&path).exists() {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    let tell = |key: &str, value: &str| println!("cargo::rustc-env=MESHSEG_{key}={value}");
    let commit = said("git", &["rev-parse", "HEAD"]);
    let status = [&["status", "--porcelain", "--"][..], &SOURCES].concat();
    let dirty = said("git", &status).is_none_or(|changes| !changes.is_empty());
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
