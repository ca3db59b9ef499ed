//! Text as outlines of the bundled font, which every viewer shows alike: each letter is defined once and used by number.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use rustybuzz::ttf_parser::{GlyphId, OutlineBuilder};

use crate::font::{self, FACE};

/// The letters of a page.
#[derive(Default)]
pub struct Outlines {
    used: BTreeSet<u16>,
}

impl Outlines {
    /// A text that starts at the origin, in units of the font, y upward; `&mut self` remembers its letters.
    pub fn uses(&mut self, text: &str) -> String {
        let glyphs = font::shape(text);
        let (mut uses, mut pen) = (String::new(), 0);
        for (glyph, position) in glyphs.glyph_infos().iter().zip(glyphs.glyph_positions()) {
            let id = glyph.glyph_id as u16;
            if !outline(id).is_empty() {
                self.used.insert(id);
                let _ = write!(uses, "<use href=\"#{}\"", name(id));
                for (key, place) in [("x", pen + position.x_offset), ("y", position.y_offset)] {
                    if place != 0 {
                        let _ = write!(uses, " {key}=\"{place}\"");
                    }
                }
                uses.push_str("/>");
            }
            pen += position.x_advance;
        }
        uses
    }

    /// The definitions of all letters.
    pub fn definitions(&self) -> String {
        let mut text = String::new();
        for &id in &self.used {
            let _ = writeln!(text, "<path id=\"{}\" d=\"{}\"/>", name(id), outline(id));
        }
        text
    }
}

/// The same letter has the same name on every page, since a page of HTML may hold several.
fn name(id: u16) -> String {
    format!("letter{id}")
}

/// Empty for a space.
fn outline(id: u16) -> String {
    let mut path = Path::default();
    let _ = FACE.outline_glyph(GlyphId(id), &mut path);
    path.0
}

/// Commands of an SVG path.
#[derive(Default)]
struct Path(String);

impl Path {
    fn command(&mut self, letter: char, numbers: &[f32]) {
        self.0.push(letter);
        let numbers: Vec<String> = numbers.iter().map(f32::to_string).collect();
        self.0.push_str(&numbers.join(" "));
    }
}

impl OutlineBuilder for Path {
    fn move_to(&mut self, x: f32, y: f32) {
        self.command('M', &[x, y]);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.command('L', &[x, y]);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.command('Q', &[x1, y1, x, y]);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.command('C', &[x1, y1, x2, y2, x, y]);
    }

    fn close(&mut self) {
        self.0.push('Z');
    }
}
