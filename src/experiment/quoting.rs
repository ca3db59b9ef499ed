//! Quoting of file names and labels for a shell, Snakemake and the header of a batch job.

pub use crate::one_line::one_line;

/// One word for a POSIX shell.
pub fn shell(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-:=+,".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// A path as a positional argument; with a leading dash it would be an option.
pub fn operand(path: &str) -> String {
    if path.starts_with('-') { format!("./{path}") } else { path.to_owned() }
}

/// Escapes braces for Snakemake, which uses them for wildcards.
pub fn braces(text: &str) -> String {
    text.replace('{', "{{").replace('}', "}}")
}

/// A Python string literal, which has the same escapes as JSON.
pub fn python(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// A name for contexts without quoting, such as job names: only letters, digits, dots, dashes and underscores.
pub fn plain(name: &str) -> String {
    let keep = |c: char| c.is_ascii_alphanumeric() || "._-".contains(c);
    name.chars().map(|c| if keep(c) { c } else { '-' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAMES: [&str; 7] = [
        "a b",
        "it's",
        "$HOME `ls` \\ \"x\"",
        "{i} {{j}}",
        "50 %\n# x",
        "λ ünï \u{1f42e}",
        "~a*?[b]",
    ];

    #[test]
    fn a_shell_reads_back_every_word() {
        for name in NAMES.into_iter().chain(["", "-n", "a=b"]) {
            let script = format!("printf '%s' {}", shell(name));
            let output = std::process::Command::new("sh").args(["-c", &script]).output().unwrap();
            assert_eq!(String::from_utf8(output.stdout).unwrap(), name);
        }
    }

    #[test]
    fn names_that_cannot_be_quoted_stay_one_word() {
        for name in NAMES {
            assert!(plain(name).chars().all(|c| c.is_ascii_alphanumeric() || "._-".contains(c)));
            assert_eq!(one_line(name).lines().count(), 1);
        }
        assert_eq!(plain("noise sweep"), "noise-sweep");
        assert_eq!(operand("-x.toml"), "./-x.toml");
        assert_eq!(one_line("a\u{1b}[2J\n"), "a\\u{1b}[2J\\u{a}");
    }
}
