//! Numbers with a unit that were typed by hand. They can go stale: results are cited by name, and facts from elsewhere are
//! marked together with their source.

use super::source::commands;

/// What makes a number before it a measurement.
const UNITS: [&str; 47] = [
    "%",
    "‰",
    "percent",
    "per cent",
    "percentage",
    "ns",
    "µs",
    "μs",
    "ms",
    "s",
    "sec",
    "second",
    "seconds",
    "Seconds",
    "milliseconds",
    "microseconds",
    "min",
    "minute",
    "minutes",
    "h",
    "hour",
    "hours",
    "day",
    "days",
    "B",
    "byte",
    "bytes",
    "Bytes",
    "kB",
    "KB",
    "MB",
    "GB",
    "TB",
    "kiB",
    "KiB",
    "MiB",
    "GiB",
    "TiB",
    "megabytes",
    "Hz",
    "MHz",
    "GHz",
    "times",
    "fold",
    "x",
    "px",
    "\\times$",
];

/// Commands of packages for units, whose first argument is a number.
const UNIT_COMMANDS: [&str; 5] = ["SI", "qty", "SIrange", "qtyrange", "unit"];

/// Commands whose arguments are not read as text.
const NOT_TEXT: [&str; 43] = [
    "autoref",
    "begin",
    "bibliography",
    "bibliographystyle",
    "cite",
    "citealp",
    "citealt",
    "citep",
    "citet",
    "cref",
    "Cref",
    "definecolor",
    "documentclass",
    "end",
    "eqref",
    "fact",
    "geometry",
    "href",
    "hspace",
    "hypersetup",
    "include",
    "includegraphics",
    "input",
    "label",
    "newcommand",
    "nocite",
    "pageref",
    "pgfplotsset",
    "providecommand",
    "ref",
    "renewcommand",
    "result",
    "resultcaption",
    "resultfigure",
    "resultsof",
    "resulttable",
    "setcounter",
    "setlength",
    "url",
    "usepackage",
    "vspace",
    "SI",
    "qty",
];

/// Environments of formulas on lines of their own.
const FORMULAS: [&str; 7] =
    ["align", "align*", "displaymath", "equation", "equation*", "gather", "multline"];

/// A number with its unit, and its line from 1.
#[derive(Debug, PartialEq)]
pub struct Typed {
    pub text: String,
    pub line: usize,
}

/// All of them in a text without comments.
pub fn typed(text: &str) -> Vec<Typed> {
    let mut found: Vec<Typed> = commands(text)
        .filter(|command| UNIT_COMMANDS.contains(&command.name))
        .filter(|command| {
            command.arguments.first().is_some_and(|it| it.starts_with(|c: char| c.is_ascii_digit()))
        })
        .map(|command| Typed {
            text: format!("\\{}{{{}}}", command.name, command.arguments.join("}{")),
            line: command.line,
        })
        .collect();
    let prose = prose(text);
    let (mut from, mut line, mut in_math, mut seen) = (0, 1, false, 0);
    while let Some(start) = prose[from..].find(|c: char| c.is_ascii_digit()).map(|i| from + i) {
        let length = prose[start..].find(|c: char| !c.is_ascii_digit() && !".,".contains(c));
        let end = length.map_or(prose.len(), |length| start + length);
        let number = prose[start..end].trim_end_matches(['.', ',']);
        from = end;
        line += prose[seen..start].matches('\n').count();
        in_math ^= dollars(&prose[seen..start]) % 2 == 1;
        seen = start;
        // x_2, x_{12}, torus3 are names, and exponents are no measurements.
        let before = prose[..start].trim_end_matches('{');
        if before.ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == '^')
            || before.trim_end().ends_with("\\sqrt")
        {
            continue;
        }
        if let Some(unit) = unit(number, &prose[start + number.len()..], in_math) {
            found
                .push(Typed { text: format!("{number} {}", unit.trim_matches(['\\', '$'])), line });
        } else if before.ends_with("factor of ") {
            found.push(Typed { text: format!("a factor of {number}"), line });
        }
    }
    found
}

fn dollars(text: &str) -> usize {
    text.matches('$').count() - text.matches("\\$").count()
}

/// The unit behind a number, which may be in a formula.
fn unit(number: &str, behind: &str, in_math: bool) -> Option<&'static str> {
    let (rest, left_math, in_words) = after_spaces(behind);
    let unit = UNITS.into_iter().find(|unit| {
        rest.strip_prefix(unit).is_some_and(|after| {
            unit.ends_with(['%', '‰', '$'])
                || !after.starts_with(|c: char| c.is_alphanumeric() || c == '(')
        })
    })?;
    let touches = rest.len() == behind.len();
    let is_variable = in_math && !left_math && !in_words && unit.chars().all(char::is_alphabetic);
    let is_decade = touches && unit == "s" && number.len() == 4;
    let is_product = unit == "times"
        && rest[unit.len()..].trim_start().starts_with(|c: char| c.is_ascii_digit());
    let is_faster = rest[unit.len()..].starts_with(char::is_whitespace);
    let is_name = unit == "x" && !(touches && is_faster);
    (!is_variable && !is_decade && !is_product && !is_name).then_some(unit)
}

/// What follows the spaces, braces, ends of formulas and changes of font behind a number; whether a formula ended, and whether a
/// font for words began.
fn after_spaces(mut text: &str) -> (&str, bool, bool) {
    let (mut left_math, mut in_words) = (false, false);
    const SPACES: [&str; 8] = ["\\,", "\\;", "\\:", "\\ ", "\\quad", "\\thinspace", "\\)", "\\/"];
    const FONTS: [&str; 9] = [
        "\\mathrm",
        "\\textrm",
        "\\textbf",
        "\\textit",
        "\\text",
        "\\mbox",
        "\\operatorname",
        "\\it",
        "\\bf",
    ];
    loop {
        let mut shorter = text.trim_start_matches([
            ' ', '\n', '\t', '~', '}', '{', '-', '\u{a0}', '\u{202f}', '\u{2009}',
        ]);
        if let Some(rest) = shorter.strip_prefix('$') {
            (shorter, left_math) = (rest, true);
        }
        if let Some((space, rest)) =
            SPACES.iter().find_map(|space| Some((space, shorter.strip_prefix(space)?)))
        {
            left_math |= *space == "\\)";
            shorter = rest;
        } else if let Some(rest) = FONTS.iter().find_map(|font| shorter.strip_prefix(font)) {
            (shorter, in_words) = (rest, true);
        }
        if shorter.len() == text.len() {
            // The per cent sign is escaped.
            let plain = text.strip_prefix('\\').filter(|rest| rest.starts_with('%'));
            return (plain.unwrap_or(text), left_math, in_words);
        }
        text = shorter;
    }
}

/// The text with everything that is not prose replaced by blanks, so that places stay the same.
fn prose(text: &str) -> String {
    let mut bytes = text.as_bytes().to_vec();
    let mut blank = |start: usize, end: usize| {
        bytes[start..end].iter_mut().filter(|byte| **byte != b'\n').for_each(|byte| *byte = b' ');
    };
    blank(0, text.find("\\begin{document}").unwrap_or(0));
    for command in commands(text) {
        if NOT_TEXT.contains(&command.name) {
            blank(command.start, command.end);
        }
        let environment = command.arguments.first().filter(|_| command.name == "begin");
        if let Some(environment) = environment.filter(|name| FORMULAS.contains(name)) {
            let end = text[command.start..].find(&format!("\\end{{{environment}}}"));
            blank(command.start, end.map_or(text.len(), |length| command.start + length));
        }
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
            "$12\\,\\mathrm{s}$",
            "$12\\,\\text{s}$",
            "12 \\mbox{s}",
            "\\(12\\)~s",
            "$3\\times$ faster",
            "3x faster",
            "a factor of 3",
            "12\\thinspace s",
            "12\u{a0}s",
            "12\ts",
            "12 KiB",
            "12 µs",
            "\\SI{12}{\\milli\\second}",
            "$95\\,\\%$",
            "12\\textbf{ s}",
            "2 GHz",
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
            "$x_{12} s$",
            "$x_{12}$ s",
            "$2 s + 1$",
            "$2 s_0$",
            "$2s/t$",
            "the 1990s",
            "2 times 3",
            "\\cref{12 s}",
            "\\href{http://a.b/12\\%20}{x}",
            "on $3 \\times 4$ blocks",
            "$\\sqrt 2$ times the length",
            "\\begin{align}K(2x-u) = 3 s\\end{align}",
            "$2x - u$",
            "$4 x$",
        ] {
            assert!(found(text).is_empty(), "{text}");
        }
    }
}
