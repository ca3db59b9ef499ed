//! The text sizes of figures, and line breaking.

pub use crate::font::width;

/// Axis labels, titles and the legend.
pub const LABEL_SIZE: f64 = 8.0;
/// Tick labels and the note.
pub const SMALL_SIZE: f64 = 7.0;
/// Size of the exponent of a tick label, and how far it is raised.
pub const EXPONENT_SIZE: f64 = 5.2;
pub const EXPONENT_RAISE: f64 = 2.7;
/// Distance between baselines, in font sizes.
pub const LINE_SPACING: f64 = 1.2;
/// Extent of the font above and below its baseline, in font sizes.
pub const ASCENT: f64 = 1.03;
pub const DESCENT: f64 = 0.41;
/// The height of digits, in font sizes.
pub const DIGIT_HEIGHT: f64 = 0.65;

/// Breaks a text into as few lines as possible that are no wider than `room`, of similar lengths.
pub fn wrap(text: &str, size: f64, room: f64) -> Vec<String> {
    let widest = broken(text, size, room);
    let mut narrower = (1..10).map(|tenths| broken(text, size, room * f64::from(tenths) / 10.0));
    narrower.find(|lines| lines.len() == widest.len()).unwrap_or(widest)
}

/// Breaks lines between words, and within words that are wider than a line.
fn broken(text: &str, size: f64, room: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(|c: char| c.is_whitespace() || c.is_control()).filter(|w| !w.is_empty())
    {
        if let Some(line) = lines.last_mut() {
            let longer = format!("{line} {word}");
            if width(&longer, size) <= room {
                *line = longer;
                continue;
            }
        }
        let mut line = String::new();
        for c in word.chars() {
            line.push(c);
            if width(&line, size) > room && line.len() > c.len_utf8() {
                line.pop();
                lines.push(std::mem::replace(&mut line, c.to_string()));
            }
        }
        lines.push(line);
    }
    lines
}
