//! Numbers with a unit that were typed by hand. They can go stale: results are cited by name, and facts from elsewhere are
//! marked together with their source.

use super::source::commands;

/// What makes a number before it a measurement.
const UNITS: [&str; 20] = [
    "%", "percent", "per cent", "ms", "s", "seconds", "second", "minutes", "minute", "hours",
    "hour", "kB", "MB", "GB", "kiB", "MiB", "GiB", "times", "fold", "bytes",
];

/// Commands whose arguments are not read as text.
const NOT_TEXT: [&str; 29] = [
    "begin",
    "bibliography",
    "bibliographystyle",
    "cite",
    "citep",
    "citet",
    "definecolor",
    "documentclass",
    "end",
    "eqref",
    "fact",
    "geometry",
    "hspace",
    "hypersetup",
    "include",
    "includegraphics",
    "input",
    "label",
    "newcommand",
    "pgfplotsset",
    "providecommand",
    "ref",
    "result",
    "resultfigure",
    "resultsof",
    "resulttable",
    "setlength",
    "usepackage",
    "vspace",
];

/// A number with its unit, and its line from 1.
#[derive(Debug, PartialEq)]
pub struct Typed {
    pub text: String,
    pub line: usize,
}

/// All of them in a text without comments.
pub fn typed(text: &str) -> Vec<Typed> {
    let prose = prose(text);
    let mut found = Vec::new();
    let mut from = 0;
    while let Some(start) = prose[from..].find(|c: char| c.is_ascii_digit()).map(|i| from + i) {
        let length = prose[start..].find(|c: char| !c.is_ascii_digit() && !".,".contains(c));
        let end = length.map_or(prose.len(), |length| start + length);
        let number = prose[start..end].trim_end_matches(['.', ',']);
        from = end;
        // x_2 and torus3 are names.
        let before = prose[..start].chars().next_back();
        if before.is_some_and(|c| c.is_alphanumeric() || c == '_') {
            continue;
        }
        let rest = &prose[start + number.len()..];
        if let Some(unit) = unit(after_spaces(rest)) {
            let line = 1 + prose[..start].matches('\n').count();
            found.push(Typed { text: format!("{number} {unit}"), line });
        }
    }
    found
}

/// What follows the spaces, braces and ends of formulas behind a number.
fn after_spaces(mut text: &str) -> &str {
    loop {
        let shorter = text.trim_start_matches([' ', '\n', '~', '$', '}', '{', '-']);
        let shorter = ["\\,", "\\;", "\\ "]
            .iter()
            .find_map(|space| shorter.strip_prefix(space))
            .unwrap_or(shorter);
        if shorter.len() == text.len() {
            // The per cent sign is escaped.
            return text.strip_prefix('\\').filter(|rest| rest.starts_with('%')).unwrap_or(text);
        }
        text = shorter;
    }
}

/// The unit at the start of a text.
fn unit(text: &str) -> Option<&'static str> {
    UNITS.into_iter().find(|unit| {
        text.strip_prefix(unit).is_some_and(|after| {
            *unit == "%" || !after.starts_with(|c: char| c.is_alphanumeric() || c == '(')
        })
    })
}

/// The text with everything that is not prose replaced by blanks, so that places stay the same.
fn prose(text: &str) -> String {
    let mut bytes = text.as_bytes().to_vec();
    let body = text.find("\\begin{document}").unwrap_or(0);
    bytes[..body].iter_mut().filter(|byte| **byte != b'\n').for_each(|byte| *byte = b' ');
    for command in commands(text).filter(|command| NOT_TEXT.contains(&command.name)) {
        let start =
            text[..command.end].rfind(&format!("\\{}", command.name)).unwrap_or(command.end);
        bytes[start..command.end]
            .iter_mut()
            .filter(|byte| **byte != b'\n')
            .for_each(|byte| *byte = b' ');
    }
    String::from_utf8(bytes).expect("whole characters were replaced")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> Vec<String> {
        typed(text).into_iter().map(|typed| typed.text).collect()
    }

    #[test]
    fn numbers_with_units_are_found() {
        for text in [
            "takes 12 s in",
            "takes 12\\,s.",
            "takes $12$~s",
            "is 12.5\\,\\% above",
            "12.5 per cent",
            "is 4.1 times as",
            "12-fold",
            "needs 1,024 MB",
            "{\\bf 3} seconds",
            "in 1.5\nminutes",
        ] {
            assert_eq!(found(text).len(), 1, "{text}");
        }
        assert_eq!(found("12 s and 3\\,ms"), ["12 s", "3 ms"]);
        assert_eq!(typed("a\nb\n7 s")[0].line, 3);
    }

    #[test]
    fn other_numbers_are_not() {
        for text in [
            "section 2 says",
            "the 4 solvers",
            "\\result{a/12 s/b} s",
            "\\fact{200 s}{paper}",
            "\\begin{document} none",
            "\\vspace{2 s}",
            "x_2 s",
            "torus3 s",
            "in 1975, seconds",
            "2009",
            "\\newcommand{\\x}{3 s}\\begin{document}",
            "$2 s(t)$",
            "$\\R^{2\\times m}$",
        ] {
            assert!(found(text).is_empty(), "{text}");
        }
    }
}
