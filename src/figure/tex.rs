//! Text for LaTeX: escapes special characters and characters that its default fonts lack.

/// Escapes a text for any engine. LaTeX handles accented letters itself; characters without a command appear as their
/// Unicode numbers.
pub fn escaped(text: &str) -> String {
    let mut tex = String::new();
    for c in text.chars() {
        match c {
            '\\' => tex += "\\textbackslash{}",
            '^' => tex += "\\textasciicircum{}",
            '~' => tex += "\\textasciitilde{}",
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => {
                tex.push('\\');
                tex.push(c);
            }
            // After the end of a row, brackets would be read as its options.
            '[' | ']' | '*' => {
                tex.push('{');
                tex.push(c);
                tex.push('}');
            }
            '<' => tex += "\\textless{}",
            '>' => tex += "\\textgreater{}",
            '"' => tex += "''",
            c if c.is_control() => tex.push(' '),
            c => match math(c) {
                Some(symbol) => {
                    tex.push('$');
                    tex += symbol;
                    tex.push('$');
                }
                // Latin letters with and without accents, and quotation marks and dashes.
                None if c.is_ascii() || is_known(c) => tex.push(c),
                None => tex += &format!("U+{:04X}", u32::from(c)),
            },
        }
    }
    tex
}

/// Whether LaTeX has long had the character in its UTF-8 tables.
fn is_known(c: char) -> bool {
    matches!(c, 'À'..='Ö' | 'Ø'..='ö' | 'ø'..='ž' | '¡' | '¿' | '§' | '£' | '©' | '–' | '—' | '‘'..='‚' | '“'..='„' | '…')
        && !matches!(c, 'Ħ' | 'ħ' | 'ĸ' | 'Ŀ' | 'ŀ' | 'ŉ' | 'Ŧ' | 'ŧ')
}

fn math(c: char) -> Option<&'static str> {
    Some(match c {
        '|' => "|",
        '\u{2212}' => "-",
        '±' => "\\pm",
        '×' => "\\times",
        '÷' => "\\div",
        '·' | '⋅' => "\\cdot",
        '≤' => "\\le",
        '≥' => "\\ge",
        '≠' => "\\ne",
        '≈' => "\\approx",
        '→' => "\\to",
        '∞' => "\\infty",
        '√' => "\\surd",
        '∑' => "\\sum",
        '∫' => "\\int",
        '∂' => "\\partial",
        '∇' => "\\nabla",
        '‖' => "\\|",
        '°' => "^\\circ",
        '¹' => "^1",
        '²' => "^2",
        '³' => "^3",
        'α' => "\\alpha",
        'β' => "\\beta",
        'γ' => "\\gamma",
        'δ' => "\\delta",
        'ε' | 'ϵ' => "\\varepsilon",
        'ζ' => "\\zeta",
        'η' => "\\eta",
        'θ' | 'ϑ' => "\\theta",
        'ι' => "\\iota",
        'κ' => "\\kappa",
        'λ' => "\\lambda",
        'μ' | 'µ' => "\\mu",
        'ν' => "\\nu",
        'ξ' => "\\xi",
        'ο' => "o",
        'π' => "\\pi",
        'ρ' => "\\rho",
        'σ' => "\\sigma",
        'ς' => "\\varsigma",
        'τ' => "\\tau",
        'υ' => "\\upsilon",
        'φ' | 'ϕ' => "\\varphi",
        'χ' => "\\chi",
        'ψ' => "\\psi",
        'ω' => "\\omega",
        'Α' => "\\mathrm{A}",
        'Β' => "\\mathrm{B}",
        'Γ' => "\\Gamma",
        'Δ' | '∆' => "\\Delta",
        'Ε' => "\\mathrm{E}",
        'Ζ' => "\\mathrm{Z}",
        'Η' => "\\mathrm{H}",
        'Θ' => "\\Theta",
        'Ι' => "\\mathrm{I}",
        'Κ' => "\\mathrm{K}",
        'Λ' => "\\Lambda",
        'Μ' => "\\mathrm{M}",
        'Ν' => "\\mathrm{N}",
        'Ξ' => "\\Xi",
        'Ο' => "\\mathrm{O}",
        'Π' => "\\Pi",
        'Ρ' => "\\mathrm{P}",
        'Σ' => "\\Sigma",
        'Τ' => "\\mathrm{T}",
        'Υ' => "\\Upsilon",
        'Φ' => "\\Phi",
        'Χ' => "\\mathrm{X}",
        'Ψ' => "\\Psi",
        'Ω' => "\\Omega",
        _ => return None,
    })
}

/// A name as typed in a document between braces: only characters that braces cannot contain are escaped. `^`, `~` and
/// `_` stay as they are.
pub fn typed(name: &str) -> String {
    let mut tex = String::new();
    for c in name.chars() {
        match c {
            '\\' => tex += "\\textbackslash{}",
            '&' | '%' | '$' | '#' | '{' | '}' => {
                tex.push('\\');
                tex.push(c);
            }
            c if c.is_control() => tex.push(' '),
            c => tex.push(c),
        }
    }
    tex
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn special_characters_are_escaped() {
        assert_eq!(
            escaped("50 % of a_b & {c} #1 ~ \\x ^2 [d]*"),
            "50 \\% of a\\_b \\& \\{c\\} \\#1 \\textasciitilde{} \\textbackslash{}x \
             \\textasciicircum{}2 {[}d{]}{*}"
        );
        assert_eq!(escaped("λ ≤ 2 × naïve Ω"), "$\\lambda$ $\\le$ 2 $\\times$ naïve $\\Omega$");
        assert_eq!(escaped("\u{1f42e}\n牛"), "U+1F42E U+725B");
        assert_eq!(typed("50 % of a_b & {c}\\"), "50 \\% of a_b \\& \\{c\\}\\textbackslash{}");
    }
}
