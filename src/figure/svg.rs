//! The figure as SVG, in points.

use std::fmt::Write as _;

use super::curve::Curve;
use super::layout::{Frame, Layout, PlacedPanel, TICK_GAP, TICK_LENGTH};
use super::legend::LegendEntry;
use super::outlines::Outlines;
use super::style::{self, Mark, Outline, Style};
use super::text::{
    DIGIT_HEIGHT, EXPONENT_RAISE, EXPONENT_SIZE, LABEL_SIZE, LINE_SPACING, SMALL_SIZE, width,
};
use super::ticks::{Decimal, Label};
use super::{Primitive, Series};
use crate::font;

const MINOR_TICK_LENGTH: f64 = 1.5;

/// How text is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Text {
    /// In the bundled font, which the reader must have.
    Typeset,
    /// As outlines, for viewers with any fonts; an invisible copy can be searched and selected.
    Outlined,
}

pub fn draw(layout: &Layout, text: Text) -> String {
    let (width, height) = (number(layout.width), number(layout.height));
    let head = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}pt\" height=\"{height}pt\" \
         viewBox=\"0 0 {width} {height}\" font-family=\"'{}', 'Source Sans Pro', sans-serif\" \
         fill=\"#{}\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n",
        font::FAMILY,
        style::INK
    );
    let mut page = Page { svg: head, text, outlines: Outlines::default() };
    for panel in &layout.panels {
        page.panel(panel);
    }
    for entry in &layout.legend.entries {
        page.entry(entry);
    }
    if text == Text::Outlined {
        let _ = write!(page.svg, "<defs>\n{}</defs>\n", page.outlines.definitions());
    }
    page.svg + "</svg>\n"
}

#[derive(Clone, Copy)]
enum Anchor {
    Start,
    Middle,
    End,
}

struct Page {
    svg: String,
    text: Text,
    outlines: Outlines,
}

/// A line of text, with an exponent or without.
struct Line<'a> {
    text: &'a str,
    exponent: &'a str,
    size: f64,
    anchor: Anchor,
    /// Whether it runs upward.
    upward: bool,
}

impl Page {
    fn panel(&mut self, placed: &PlacedPanel) {
        let frame = &placed.frame;
        self.axes(placed);
        let middle = frame.left + frame.width / 2.0;
        self.lines(&placed.title, LABEL_SIZE, [middle, placed.title_at], Anchor::Middle);
        self.lines(&placed.x_label, LABEL_SIZE, [middle, placed.x_label_at], Anchor::Middle);
        let center = frame.top + frame.height / 2.0;
        for (i, line) in placed.y_label.iter().enumerate() {
            let x = placed.y_label_at + LINE_SPACING * LABEL_SIZE * i as f64;
            let upward = Line { upward: true, ..Line::plain(line, LABEL_SIZE, Anchor::Middle) };
            self.put(&upward, [x, center]);
        }
        if !placed.has_data {
            let at = [middle, center + DIGIT_HEIGHT * LABEL_SIZE / 2.0];
            self.put(&Line::plain("no data", LABEL_SIZE, Anchor::Middle), at);
            return;
        }
        let series = &placed.panel.series;
        let curves: Vec<(&Series, Curve)> =
            series.iter().map(|series| (series, Curve::new(series, frame))).collect();
        for (series, curve) in &curves {
            self.areas(curve, &Style::of(series), frame);
        }
        // A fit is drawn below its data.
        let (references, data): (Vec<_>, Vec<_>) =
            curves.iter().partition(|(series, _)| series.primitive == Primitive::Reference);
        for (series, curve) in references.into_iter().chain(data) {
            self.curve(curve, &Style::of(series), frame);
        }
    }

    fn axes(&mut self, placed: &PlacedPanel) {
        let frame = &placed.frame;
        let (left, top, bottom, right) = (frame.left, frame.top, frame.bottom(), frame.right());
        let across = |number: &Decimal| frame.across(number.position(frame.x.scale));
        let up = |number: &Decimal| frame.up(number.position(frame.y.scale));
        let (mut grid, mut ticks) = (String::new(), String::new());
        for tick in &placed.x_ticks.major {
            let x = across(&tick.number);
            segment(&mut grid, [x, top], [x, bottom]);
            segment(&mut ticks, [x, bottom], [x, bottom + TICK_LENGTH]);
        }
        for tick in &placed.y_ticks.major {
            let y = up(&tick.number);
            segment(&mut grid, [left, y], [right, y]);
            segment(&mut ticks, [left, y], [left - TICK_LENGTH, y]);
        }
        for minor in &placed.x_ticks.minor {
            segment(
                &mut ticks,
                [across(minor), bottom],
                [across(minor), bottom + MINOR_TICK_LENGTH],
            );
        }
        for minor in &placed.y_ticks.minor {
            segment(&mut ticks, [left, up(minor)], [left - MINOR_TICK_LENGTH, up(minor)]);
        }
        self.stroke(&grid, style::GRID_INK, style::GRID_WIDTH, &[]);
        let corners = [[left, top], [right, top], [right, bottom], [left, bottom]];
        self.stroke(&format!("{}Z{ticks}", path(corners)), style::INK, style::FRAME_WIDTH, &[]);
        for tick in &placed.x_ticks.major {
            let y = bottom + TICK_LENGTH + TICK_GAP + DIGIT_HEIGHT * SMALL_SIZE + 0.8;
            self.tick_label(&tick.label, [across(&tick.number), y], Anchor::Middle);
        }
        for tick in &placed.y_ticks.major {
            let at =
                [left - TICK_LENGTH - TICK_GAP, up(&tick.number) + DIGIT_HEIGHT * SMALL_SIZE / 2.0];
            self.tick_label(&tick.label, at, Anchor::End);
        }
    }

    fn areas(&mut self, curve: &Curve, style: &Style, frame: &Frame) {
        for area in &curve.areas {
            let outline = path(area.iter().map(|&point| frame.at(point)));
            let (color, cover) = (style.color, style::AREA_OPACITY);
            let _ = writeln!(
                self.svg,
                "<path d=\"{outline}Z\" fill=\"#{color}\" fill-opacity=\"{cover}\"/>"
            );
        }
    }

    fn curve(&mut self, curve: &Curve, style: &Style, frame: &Frame) {
        let lines: String =
            curve.lines.iter().map(|line| path(line.iter().map(|&p| frame.at(p)))).collect();
        self.stroke(&lines, style.color, style.width, style.dashes);
        for &point in &curve.marks {
            self.mark(style.mark, style.color, frame.at(point));
        }
        // Bars are above the marks, whose white outlines would hide short ones.
        let mut bars = String::new();
        for &[x, low, high] in &curve.bars {
            let ([x, low], [_, high]) = (frame.at([x, low]), frame.at([x, high]));
            segment(&mut bars, [x, low], [x, high]);
            for end in [low, high] {
                segment(&mut bars, [x - 1.6, end], [x + 1.6, end]);
            }
        }
        self.stroke(&bars, style.color, style::BAR_WIDTH, &[]);
        let mut arrows = String::new();
        for &point in &curve.arrows {
            let [x, y] = frame.at(point);
            segment(&mut arrows, [x, y], [x, y - style::ARROW]);
            let tip = y - style::ARROW;
            arrows.push_str(&path([[x - 1.6, tip + 2.4], [x, tip], [x + 1.6, tip + 2.4]]));
        }
        self.stroke(&arrows, style.color, style::ARROW_WIDTH, &[]);
    }

    fn entry(&mut self, entry: &LegendEntry) {
        let style = Style::of(entry.series);
        let [left, right] = entry.sample;
        let y = entry.at[1] - DIGIT_HEIGHT * LABEL_SIZE / 2.0;
        if entry.series.primitive != Primitive::Marks {
            let sample = path([[left, y], [right, y]]);
            self.stroke(&sample, style.color, style.width, style.dashes);
        }
        if matches!(entry.series.primitive, Primitive::Marks | Primitive::LineMarks) {
            self.mark(style.mark, style.color, [(left + right) / 2.0, y]);
        }
        self.lines(&entry.lines, LABEL_SIZE, entry.at, Anchor::Start);
    }

    fn stroke(&mut self, path: &str, color: &str, width: f64, dashes: &[f64]) {
        if path.is_empty() {
            return;
        }
        let _ = write!(
            self.svg,
            "<path d=\"{path}\" fill=\"none\" stroke=\"#{color}\" stroke-width=\"{width}\" \
             stroke-linejoin=\"round\""
        );
        if !dashes.is_empty() {
            let dashes: Vec<String> = dashes.iter().map(|&dash| number(dash)).collect();
            let _ = write!(self.svg, " stroke-dasharray=\"{}\"", dashes.join(" "));
        }
        self.svg.push_str("/>\n");
    }

    fn mark(&mut self, mark: Mark, color: &str, [x, y]: [f64; 2]) {
        let size = mark.size();
        let closed = |corners: &[[f64; 2]]| {
            path(corners.iter().map(|[dx, dy]| [x + size * dx, y + size * dy])) + "Z"
        };
        let d = match mark.outline {
            Outline::Circle => {
                let (from, to, r) = (number(x - size), number(x + size), number(size));
                let y = number(y);
                format!("M{from} {y}A{r} {r} 0 1 1 {to} {y}A{r} {r} 0 1 1 {from} {y}Z")
            }
            Outline::Square => closed(&[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]),
            Outline::Triangle => closed(&[[0.0, -1.0], [0.87, 0.6], [-0.87, 0.6]]),
            Outline::Diamond => closed(&[[0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]]),
            Outline::Cross => {
                let mut d = String::new();
                segment(&mut d, [x - size, y - size], [x + size, y + size]);
                segment(&mut d, [x - size, y + size], [x + size, y - size]);
                d
            }
        };
        let ([fill, edge], pen) = (mark.colors(color), mark.pen());
        let _ = writeln!(
            self.svg,
            "<path d=\"{d}\" fill=\"#{fill}\" stroke=\"#{edge}\" stroke-width=\"{pen}\"/>"
        );
    }

    fn tick_label(&mut self, label: &Label, at: [f64; 2], anchor: Anchor) {
        let exponent = label.exponent.as_deref().unwrap_or("");
        self.put(&Line { exponent, ..Line::plain(&label.text, SMALL_SIZE, anchor) }, at);
    }

    fn lines(&mut self, lines: &[String], size: f64, [x, y]: [f64; 2], anchor: Anchor) {
        for (i, line) in lines.iter().enumerate() {
            self.put(&Line::plain(line, size, anchor), [x, y + LINE_SPACING * size * i as f64]);
        }
    }

    fn put(&mut self, line: &Line<'_>, at: [f64; 2]) {
        match self.text {
            Text::Typeset => self.typeset(line, at, ""),
            Text::Outlined => {
                self.outlined(line, at);
                let length = number(line.width());
                let hidden = format!(
                    " fill-opacity=\"0\" textLength=\"{length}\" lengthAdjust=\"spacingAndGlyphs\""
                );
                self.typeset(line, at, &hidden);
            }
        }
    }

    /// `more` are attributes.
    fn typeset(&mut self, line: &Line<'_>, [x, y]: [f64; 2], more: &str) {
        let anchor = match line.anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let (x, y) = (number(x), number(y));
        let turn = match line.upward {
            true => format!(" transform=\"rotate(-90 {x} {y})\""),
            false => String::new(),
        };
        let exponent = match line.exponent {
            "" => String::new(),
            exponent => format!(
                "<tspan dy=\"-{EXPONENT_RAISE}\" font-size=\"{EXPONENT_SIZE}\">{exponent}</tspan>"
            ),
        };
        let (size, text) = (line.size, escaped(line.text));
        let _ = writeln!(
            self.svg,
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\"{anchor}{turn}{more}>{text}{exponent}</text>"
        );
    }

    fn outlined(&mut self, line: &Line<'_>, [x, y]: [f64; 2]) {
        let shift = line.width()
            * match line.anchor {
                Anchor::Start => 0.0,
                Anchor::Middle => -0.5,
                Anchor::End => -1.0,
            };
        let turn = if line.upward { "rotate(-90)" } else { "" };
        let (x, y) = (number(x), number(y));
        let _ = write!(self.svg, "<g transform=\"translate({x} {y}){turn}\">");
        let exponent_at = [shift + width(line.text, line.size), -EXPONENT_RAISE];
        let parts =
            [(line.text, line.size, [shift, 0.0]), (line.exponent, EXPONENT_SIZE, exponent_at)];
        for (text, size, [x, y]) in parts {
            let uses = self.outlines.uses(text);
            if !uses.is_empty() {
                let scale = font::scale(size);
                let (x, y) = (number(x), number(y));
                let _ = write!(
                    self.svg,
                    "<g transform=\"matrix({scale} 0 0 -{scale} {x} {y})\">{uses}</g>"
                );
            }
        }
        self.svg.push_str("</g>\n");
    }
}

impl<'a> Line<'a> {
    fn plain(text: &'a str, size: f64, anchor: Anchor) -> Self {
        Line { text, exponent: "", size, anchor, upward: false }
    }

    fn width(&self) -> f64 {
        width(self.text, self.size) + width(self.exponent, EXPONENT_SIZE)
    }
}

/// A number with two decimals, which is enough for print.
fn number(value: f64) -> String {
    let rounded = format!("{value:.2}");
    let short = rounded.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" { "0".to_owned() } else { short.to_owned() }
}

fn path(points: impl IntoIterator<Item = [f64; 2]>) -> String {
    let mut path = String::new();
    for [x, y] in points {
        let command = if path.is_empty() { 'M' } else { 'L' };
        let _ = write!(path, "{command}{} {}", number(x), number(y));
    }
    path
}

fn segment(path: &mut String, from: [f64; 2], to: [f64; 2]) {
    path.push_str(&self::path([from, to]));
}

/// Escapes a text for XML, which cannot represent control characters.
fn escaped(text: &str) -> String {
    let text = text.replace(|c: char| c.is_control() || "\u{fffe}\u{ffff}".contains(c), " ");
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
