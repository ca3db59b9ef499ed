//! The text of a paper: its files, without comments, and the commands in it.

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// A file of the paper.
pub struct Source {
    pub path: PathBuf,
    /// Without comments; lines are kept.
    pub text: String,
}

/// A command with its arguments in braces; those in brackets are skipped.
#[derive(Debug, PartialEq)]
pub struct Command<'a> {
    pub name: &'a str,
    pub arguments: Vec<&'a str>,
    /// Counted from 1.
    pub line: usize,
    /// Where its last argument ends in the text.
    pub end: usize,
}

/// `main.tex` in a folder and all files of the folder that it reads, in their order.
///
/// # Errors
/// A file cannot be read.
pub fn sources(folder: &Path) -> Result<Vec<Source>> {
    let mut all = Vec::new();
    read(folder, &folder.join("main.tex"), &mut all)?;
    Ok(all)
}

fn read(folder: &Path, path: &Path, all: &mut Vec<Source>) -> Result<()> {
    if all.iter().any(|source| source.path == path) {
        return Ok(());
    }
    let bytes = fs::read(path).map_err(|error| Error::io(path, error))?;
    let text =
        String::from_utf8(bytes).map_err(|_| Error::malformed(path, "is not text in UTF-8"))?;
    all.push(Source { path: path.to_owned(), text: without_comments(&text) });
    let included: Vec<PathBuf> = commands(&all[all.len() - 1].text)
        .filter(|command| matches!(command.name, "input" | "include"))
        .filter_map(|command| Some(folder.join(command.arguments.first()?)))
        .map(|path| if path.extension().is_some() { path } else { path.with_extension("tex") })
        .collect();
    included.iter().try_for_each(|path| read(folder, path, all))
}

/// The text without what follows an unescaped per cent sign in a line.
fn without_comments(text: &str) -> String {
    let mut kept = String::new();
    for line in text.split_inclusive('\n') {
        let mut escaped = false;
        let comment = line.find(|c: char| {
            let starts = c == '%' && !escaped;
            escaped = c == '\\' && !escaped;
            starts
        });
        kept.push_str(&line[..comment.unwrap_or(line.len())]);
        if comment.is_some() {
            kept.push('\n');
        }
    }
    kept
}

/// All commands of a text that start with a backslash and letters, also those inside arguments.
pub fn commands(text: &str) -> impl Iterator<Item = Command<'_>> {
    text.match_indices('\\').filter_map(|(start, _)| {
        let rest = &text[start + 1..];
        let length = rest.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(rest.len());
        if length == 0 {
            return None;
        }
        let mut end = start + 1 + length;
        let mut arguments = Vec::new();
        while let Some((kind, argument, after)) = argument(text, end) {
            if kind == '{' {
                arguments.push(argument);
            }
            end = after;
        }
        let line = 1 + text[..start].matches('\n').count();
        Some(Command { name: &rest[..length], arguments, line, end })
    })
}

/// An argument in braces or brackets right at `from`: its kind, its text, and where it ends.
fn argument(text: &str, from: usize) -> Option<(char, &str, usize)> {
    let rest = &text[from..];
    let open = rest.chars().next().filter(|c| matches!(c, '{' | '['))?;
    let close = if open == '{' { '}' } else { ']' };
    let (mut depth, mut escaped) = (0_usize, false);
    for (i, c) in rest.char_indices() {
        match c {
            _ if escaped => {}
            '{' => depth += 1,
            '[' if open == '[' && depth == 0 => depth += 1,
            '}' | ']' if c == close && depth == 1 => {
                return Some((open, &rest[1..i], from + i + 1));
            }
            '}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        escaped = c == '\\' && !escaped;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_are_left_out_and_lines_kept() {
        let text = "a 50\\% b % c\nd\\\\% e\nf";
        assert_eq!(without_comments(text), "a 50\\% b \nd\\\\\nf");
    }

    #[test]
    fn commands_have_their_arguments() {
        let text = "\\result{a/b, \\{c\\}/d}\n\\resultfigure[width=3in]{x}{y} \\fact{200 s}{key}";
        let found: Vec<_> = commands(text)
            .map(|command| (command.name, command.arguments.clone(), command.line))
            .collect();
        assert_eq!(
            found,
            [
                ("result", vec!["a/b, \\{c\\}/d"], 1),
                ("resultfigure", vec!["x", "y"], 2),
                ("fact", vec!["200 s", "key"], 2)
            ]
        );
        let nested: Vec<&str> =
            commands("\\caption{\\textbf{x} \\ref{y}}").map(|c| c.name).collect();
        assert_eq!(nested, ["caption", "textbf", "ref"]);
        assert!(commands("\\open{never closed").next().unwrap().arguments.is_empty());
    }
}
