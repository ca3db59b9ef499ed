//! The texts of the program about itself: solvers, help, completions, version.

use meshseg::solver::Method;

use crate::support::Folder;

#[test]
fn solvers_and_their_options() {
    let text = Folder::new().done("solvers");
    for mut method in Method::all() {
        assert!(text.contains(method.name()) && text.contains(method.description().reference));
        for setting in method.settings() {
            assert!(text.contains(&format!("--solver-option {}=", setting.key)), "{}", setting.key);
        }
    }
    insta::assert_snapshot!("solvers", text);
}

#[test]
fn completions_for_the_shells() {
    let folder = Folder::new();
    for (shell, part) in
        [("bash", "complete -F"), ("zsh", "#compdef meshseg"), ("fish", "complete -c meshseg")]
    {
        let script = folder.done(&format!("completions {shell}"));
        assert!(script.contains(part) && script.contains("segment"), "{shell}");
    }
}

#[test]
fn every_verb_has_help_with_examples() {
    let folder = Folder::new();
    for (verb, part) in [
        ("", "meshseg segment builtin:spot --regions 3 --out results/spot"),
        ("segment", "meshseg segment builtin:spot --regions 3 --out results/spot"),
        ("batch", "meshseg batch scans.csv --resume"),
        ("solve", "meshseg solve mesh.ply --costs S.npy --lambda 0.005 --out results/mesh"),
        ("evaluate", "meshseg evaluate mesh.ply --costs S.npy"),
        ("compare", "meshseg compare results/horses horses.mat --mesh grid:480x320"),
        ("render", "meshseg render results/spot --show labels,u:0,uncertainty --views front,back"),
        (
            "reconstruct",
            "meshseg reconstruct --views photographs/views.toml --regions 4 --out results/spot",
        ),
        ("operators", "meshseg operators bunny.ply --out results/bunny"),
        ("mesh", "Inspect, compare, generate and convert meshes"),
        ("mesh info", "Print counts, topology and defects of a mesh"),
        ("mesh distance", "Print how far apart two surfaces are"),
        ("mesh generate", "For example torus:400x250, sphere:6, grid:100x100"),
        ("mesh convert", "in the same vertex order"),
        ("paper", "meshseg paper check other/paper"),
        ("paper check", "measurements that are typed by hand"),
        ("solvers", "List the solvers"),
        ("completions", "meshseg completions bash >"),
    ] {
        let help = folder.done(&format!("{verb} --help"));
        assert!(help.contains(part), "{verb}: {help}");
        assert!(!folder.done(&format!("{verb} -h")).is_empty());
    }
}

#[test]
fn version() {
    let version = Folder::new().done("--version");
    assert_eq!(version, format!("meshseg {}\n", env!("CARGO_PKG_VERSION")));
}
