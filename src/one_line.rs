//! Text from outside the program on a single line of a comment or a message.

/// Escapes all characters that would end or overwrite a line.
pub fn one_line(text: &str) -> String {
    let mut line = String::new();
    for c in text.chars() {
        // Line and paragraph separators end lines, too.
        if c.is_control() || matches!(c, '\u{2028}' | '\u{2029}') {
            line.extend(c.escape_unicode());
        } else {
            line.push(c);
        }
    }
    line
}
