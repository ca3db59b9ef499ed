//! Texts of others on one line of ours.

/// For a comment or a message: whatever would end or overwrite the line is escaped.
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
