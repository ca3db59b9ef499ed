//! The text of a paper: its files, without what LaTeX does not typeset, and the commands in it.

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// An argument ends within this many bytes, or not at all.
const LONGEST_ARGUMENT: usize = 20_000;

/// Environments whose text is not read.
const UNREAD: [&str; 4] = ["verbatim", "verbatim*", "lstlisting", "comment"];

/// A file of the paper.
pub struct Source {
    pub path: PathBuf,
    /// Without comments, verbatim text and what follows the end of the document; lines are kept.
    pub text: String,
}

/// A file that is read, but cannot be.
pub struct Missing {
    /// The file that reads it.
    pub path: PathBuf,
    /// Counted from 1.
    pub line: usize,
    pub message: String,
}

/// A command with its arguments in braces; those in brackets are skipped.
#[derive(Debug, PartialEq)]
pub struct Command<'a> {
    pub name: &'a str,
    pub arguments: Vec<&'a str>,
    /// Counted from 1.
    pub line: usize,
    /// Where it begins and where its last argument ends in the text.
    pub start: usize,
    pub end: usize,
}

/// `main.tex` in a folder and all files of the folder that it reads, in their order, and those that cannot be read.
///
/// # Errors
/// `main.tex` cannot be read.
pub fn sources(folder: &Path) -> Result<(Vec<Source>, Vec<Missing>)> {
    let main = folder.join("main.tex");
    let text = text(&main).map_err(|message| Error::malformed(&main, message))?;
    let (mut all, mut missing) = (Vec::new(), Vec::new());
    include(folder, main, &text, &mut all, &mut missing);
    Ok((all, missing))
}

fn text(path: &Path) -> std::result::Result<String, String> {
    let bytes = fs::read(path).map_err(|error| error.to_string())?;
    let text = String::from_utf8(bytes).map_err(|_| "is not text in UTF-8".to_owned())?;
    Ok(text.trim_start_matches('\u{feff}').replace("\r\n", "\n"))
}

fn include(
    folder: &Path,
    path: PathBuf,
    text: &str,
    all: &mut Vec<Source>,
    missing: &mut Vec<Missing>,
) {
    let typeset = typeset(text);
    all.push(Source { path: path.clone(), text: typeset.clone() });
    for command in commands(&typeset) {
        let name = match (command.name, &command.arguments[..]) {
            ("input" | "include", [name, ..]) if !name.contains(['#', '\\']) => name.trim(),
            ("input" | "include", []) => {
                typeset[command.end..].split_whitespace().next().unwrap_or("")
            }
            _ => continue,
        };
        let with_ending = folder.join(format!("{name}.tex"));
        let file = if with_ending.is_file() { with_ending } else { folder.join(name) };
        if all.iter().any(|source| source.path == file) {
            continue;
        }
        match self::text(&file) {
            Ok(text) => include(folder, file, &text, all, missing),
            Err(message) => missing.push(Missing {
                path: path.clone(),
                line: command.line,
                message: format!("{} cannot be read: {message}", file.display()),
            }),
        }
    }
}

/// The text with comments, verbatim text and what follows the end of the document replaced by blanks.
fn typeset(text: &str) -> String {
    let mut kept = without_comments(text);
    for environment in UNREAD {
        blank(&mut kept, &format!("\\begin{{{environment}}}"), &format!("\\end{{{environment}}}"));
    }
    blank(&mut kept, "\\iffalse", "\\fi");
    let mut from = 0;
    while let Some(start) = kept[from..].find("\\verb").map(|i| from + i) {
        from = start + 5;
        let mark = kept[from..].trim_start_matches('*').chars().next();
        let Some(mark) = mark.filter(|c| !c.is_ascii_alphabetic()) else { continue };
        let end = kept[from..].find(mark).and_then(|i| {
            let inside = from + i + mark.len_utf8();
            kept[inside..].find(mark).map(|length| inside + length + mark.len_utf8())
        });
        if let Some(end) = end {
            wipe(&mut kept, start, end);
            from = end;
        }
    }
    if let Some(end) = kept.find("\\end{document}") {
        let length = kept.len();
        wipe(&mut kept, end, length);
    }
    kept
}

/// Blanks everything from each `begin` to the `end` behind it.
fn blank(text: &mut String, begin: &str, end: &str) {
    let mut from = 0;
    while let Some(start) = text[from..].find(begin).map(|i| from + i) {
        let behind = text[start..].find(end).map_or(text.len(), |i| start + i + end.len());
        wipe(text, start, behind);
        from = behind;
    }
}

/// Replaces a range by blanks of the same length; lines are kept.
fn wipe(text: &mut String, start: usize, end: usize) {
    let blanks: String =
        text[start..end].bytes().map(|byte| if byte == b'\n' { '\n' } else { ' ' }).collect();
    text.replace_range(start..end, &blanks);
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
    let mut counted = (0, 1);
    text.match_indices('\\').filter_map(move |(start, _)| {
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
        let (from, line) = counted;
        counted = (start, line + text[from..start].matches('\n').count());
        Some(Command { name: &rest[..length], arguments, line: counted.1, start, end })
    })
}

/// An argument in braces or brackets behind `from`, perhaps after a space or the end of a line: its kind, its text, and where
/// it ends.
fn argument(text: &str, from: usize) -> Option<(char, &str, usize)> {
    let behind = &text[from..];
    let skipped = behind.len() - behind.trim_start_matches([' ', '\t', '\n']).len();
    if behind[..skipped].matches('\n').count() > 1 {
        return None;
    }
    let from = from + skipped;
    let rest = &text[from..];
    let open = rest.chars().next().filter(|c| matches!(c, '{' | '['))?;
    let close = if open == '{' { '}' } else { ']' };
    let (mut depth, mut escaped) = (0_usize, false);
    for (i, c) in rest.char_indices().take_while(|(i, _)| *i <= LONGEST_ARGUMENT) {
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
    fn what_is_not_typeset_is_left_out_and_lines_are_kept() {
        let text = "a 50\\% b % c\nd\\\\% e\nf";
        assert_eq!(without_comments(text), "a 50\\% b \nd\\\\\nf");
        let text = "\\verb|a| b\n\\begin{verbatim}\nc\n\\end{verbatim} d\\iffalse e\\fi f\\end{document} g";
        let kept = typeset(text);
        assert_eq!(kept.split_whitespace().collect::<Vec<_>>(), ["b", "d", "f"]);
        assert_eq!((kept.len(), kept.matches('\n').count()), (text.len(), 3));
    }

    #[test]
    fn commands_have_their_arguments() {
        let text =
            "\\result{a/b, \\{c\\}/d}\n\\resultfigure[width=3in] {x}\n{y} \\fact{200 s}{key}";
        let found: Vec<_> = commands(text)
            .map(|command| (command.name, command.arguments.clone(), command.line))
            .collect();
        assert_eq!(
            found,
            [
                ("result", vec!["a/b, \\{c\\}/d"], 1),
                ("resultfigure", vec!["x", "y"], 2),
                ("fact", vec!["200 s", "key"], 3)
            ]
        );
        let nested: Vec<&str> =
            commands("\\caption{\\textbf{x} \\ref{y}}").map(|command| command.name).collect();
        assert_eq!(nested, ["caption", "textbf", "ref"]);
        assert!(commands("\\open{never closed").next().unwrap().arguments.is_empty());
        assert!(commands("\\maketitle\n\n{a group}").next().unwrap().arguments.is_empty());
    }
}
