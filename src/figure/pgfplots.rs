//! The figure for LaTeX: a picture whose text LaTeX typesets, and the table of its data.
//!
//! The table has a pair of columns for each line, set of marks or area; shorter ones are padded with `nan`, and a row
//! of `nan` breaks a line. pgfplots reads it once. TeX has neither the memory nor the time for all points of a long
//! trace, so lines are thinned and numbers rounded.

use std::fmt::Write as _;

use super::curve::{self, Curve};
use super::layout::{Frame, Layout, PlacedPanel};
use super::range::Range;
use super::style::{self, ARROW, Outline, Style};
use super::tex::escaped;
use super::text::{LABEL_SIZE, LINE_SPACING, SMALL_SIZE};
use super::ticks::{Decimal, Label, MINUS, Ticks};
use super::{Primitive, Scale, Series};

/// pgfplots places the labels of x this much lower than the SVG.
const X_LABEL_DROP: f64 = 5.0;
/// Maximum distance from the end of a logarithmic axis to 1, in lengths of the axis.
const MAX_LENGTHS_TO_ONE: f64 = 25.0;

/// Maximum number of points of a line. TeX draws thirty such lines in about five seconds.
const MAX_LINE_POINTS: usize = 300;

/// The contents of `stem.tex` and `stem.dat`.
pub fn draw(layout: &Layout, stem: &str) -> (String, String) {
    let mut table = Table::default();
    let mut tex = head(layout, stem);
    for (i, placed) in layout.panels.iter().enumerate() {
        let legend = if i == 0 { legend(layout) } else { String::new() };
        let _ = write!(tex, "\\nextgroupplot[{}]\n{legend}", axes(placed, i == 0, stem));
        if !placed.has_data {
            let font = font(LABEL_SIZE);
            let _ = writeln!(tex, "\\node[{font}] at (rel axis cs:0.5,0.5) {{no data}};");
            continue;
        }
        for (k, series) in placed.panel.series.iter().enumerate() {
            let name = format!("p{}s{}", i + 1, k + 1);
            tex.push_str(&plots(series, &placed.frame, &name, &mut table));
        }
    }
    tex.push_str("\\end{groupplot}\n");
    tex.push_str(&above(layout, stem));
    tex.push_str("\\end{tikzpicture}\n");
    (tex, table.text())
}

fn head(layout: &Layout, stem: &str) -> String {
    let tip = ARROW - 2.4;
    let mut tex = format!(
        "% \\input{{{stem}.tex}} in a document with \\usepackage{{pgfplots, pgfplotstable}}, \
         \\pgfplotsset{{compat=1.16}} and \\usepgfplotslibrary{{groupplots}}.\n\
         % Run LaTeX twice for the legend. {stem}.dat is looked for in \\figurefolder.\n\
         \\providecommand\\figurefolder{{.}}\n\
         \\pgfdeclareplotmark{{beyond}}{{\\pgfpathmoveto{{\\pgfpointorigin}}\
         \\pgfpathlineto{{\\pgfqpoint{{0bp}}{{{ARROW}bp}}}}\
         \\pgfpathmoveto{{\\pgfqpoint{{-1.6bp}}{{{tip}bp}}}}\\pgfpathlineto{{\\pgfqpoint{{0bp}}{{{ARROW}bp}}}}\
         \\pgfpathlineto{{\\pgfqpoint{{1.6bp}}{{{tip}bp}}}}\\pgfusepathqstroke}}\n\
         \\begin{{tikzpicture}}\n\
         \\pgfplotstableread{{\\figurefolder/{stem}.dat}}\\figuretable\n"
    );
    let mut colors: Vec<&str> = layout
        .panels
        .iter()
        .flat_map(|placed| &placed.panel.series)
        .map(|series| Style::of(series).color)
        .chain([style::INK, style::GRID_INK, style::WHITE])
        .collect();
    colors.sort_unstable();
    colors.dedup();
    for color in colors {
        let _ = writeln!(tex, "\\definecolor{{figure{color}}}{{HTML}}{{{color}}}");
    }
    let Some(PlacedPanel { frame, .. }) = layout.panels.first() else { return tex };
    let rows = layout.panels.len().div_ceil(layout.columns);
    let _ = write!(
        tex,
        "\\begin{{groupplot}}[\n\
         group style={{group size={} by {rows}, horizontal sep={:.2}bp, vertical sep={:.2}bp}},\n\
         scale only axis, width={:.2}bp, height={:.2}bp,\n\
         unbounded coords=jump, clip=false, scaled ticks=false, grid=major, tick align=outside,\n\
         tick pos=left, major tick length=2.6bp, minor tick length=1.5bp,\n\
         axis line style={{figure{ink}, line width={frame}bp}}, every tick/.style={{figure{ink}, line width={frame}bp}},\n\
         grid style={{figure{grid}, line width={thin}bp}},\n\
         title style={{{label}, yshift=-3bp, align=center}},\n\
         label style={{{label}, align=center}}, tick label style={{{small}}},\n\
         legend columns={}, legend cell align=left,\n\
         legend style={{draw=none, {label}, /tikz/every even column/.append style={{column sep=8bp}}}},\n\
         ]\n",
        layout.columns,
        layout.gaps[0],
        layout.gaps[1] + X_LABEL_DROP,
        frame.width,
        frame.height,
        layout.legend.columns,
        ink = style::INK,
        grid = style::GRID_INK,
        frame = style::FRAME_WIDTH,
        thin = style::GRID_WIDTH,
        label = font(LABEL_SIZE),
        small = font(SMALL_SIZE),
    );
    tex
}

fn font(size: f64) -> String {
    format!("font=\\fontsize{{{size}}}{{{:.1}}}\\selectfont", LINE_SPACING * size)
}

/// The options of a panel; the first one collects the legend.
fn axes(placed: &PlacedPanel, is_first: bool, stem: &str) -> String {
    let mut options = String::new();
    let lines =
        |lines: &[String]| lines.iter().map(|line| escaped(line)).collect::<Vec<_>>().join(r" \\ ");
    for (key, text) in
        [("title", &placed.title), ("xlabel", &placed.x_label), ("ylabel", &placed.y_label)]
    {
        if !text.is_empty() {
            let _ = writeln!(options, "{key}={{{}}},", lines(text));
        }
    }
    let ranges = [('x', &placed.frame.x, &placed.x_ticks), ('y', &placed.frame.y, &placed.y_ticks)];
    for (axis, range, ticks) in ranges {
        axis_options(&mut options, axis, range, ticks);
    }
    if is_first {
        let _ = writeln!(options, "legend to name={{figure-{}}},", name(stem));
    }
    options.insert(0, '\n');
    options
}

fn axis_options(options: &mut String, axis: char, range: &Range, ticks: &Ticks) {
    let mode = if is_logarithmic(range) { "log" } else { "linear" };
    let decimal = |number: Decimal| format!("{}e{}", number.digits, number.exponent);
    let _ = writeln!(
        options,
        "{axis}mode={mode}, {axis}min={}, {axis}max={},",
        end(range, range.low),
        end(range, range.high)
    );
    // Without this option, pgfplots chooses ticks itself.
    if ticks.major.is_empty() {
        let _ = writeln!(options, "{axis}tick=\\empty,");
    } else {
        let at: Vec<String> = ticks.major.iter().map(|tick| decimal(tick.number)).collect();
        let labels: Vec<String> =
            ticks.major.iter().map(|tick| format!("{{{}}}", tick_label(&tick.label))).collect();
        let (at, labels) = (at.join(","), labels.join(","));
        let _ = writeln!(options, "{axis}tick={{{at}}}, {axis}ticklabels={{{labels}}},");
    }
    if ticks.minor.is_empty() {
        let _ = writeln!(options, "{axis}minorticks=false,");
    } else {
        let at: Vec<String> = ticks.minor.iter().map(|&number| decimal(number)).collect();
        let _ = writeln!(options, "minor {axis}tick={{{}}},", at.join(","));
    }
}

/// pgfplots measures a logarithmic axis from 1, and TeX has no lengths above 5.7 m. A range that is so far from 1 and
/// so short is practically linear.
fn is_logarithmic(range: &Range) -> bool {
    let far = range.low.abs().max(range.high.abs());
    range.scale == Scale::Log && far < MAX_LENGTHS_TO_ONE * (range.high - range.low)
}

/// The end of a range as a number, which may be too large or small for a double.
fn end(range: &Range, position: f64) -> String {
    match range.scale {
        Scale::Linear => format!("{position:e}"),
        Scale::Log => format!("{}e{}", 10f64.powf(position - position.floor()), position.floor()),
    }
}

fn tick_label(label: &Label) -> String {
    let text = label.text.replace(MINUS, "-").replace('\u{d7}', "\\times ");
    let exponent = label.exponent.as_ref();
    let exponent = exponent.map_or(String::new(), |e| format!("^{{{}}}", e.replace(MINUS, "-")));
    format!("${text}{exponent}$")
}

fn legend(layout: &Layout) -> String {
    let mut tex = String::new();
    for entry in &layout.legend.entries {
        let style = Style::of(entry.series);
        let look = match entry.series.primitive {
            Primitive::Marks => format!("only marks, {}", marks(&style)),
            Primitive::LineMarks => format!("{}, {}", line(&style), marks(&style)),
            Primitive::Line | Primitive::Steps | Primitive::Reference => {
                format!("{}, mark=none", line(&style))
            }
        };
        let _ = writeln!(
            tex,
            "\\addlegendimage{{{look}}}\\addlegendentry{{{}}}",
            escaped(&entry.series.label)
        );
    }
    tex
}

/// The legend above the panels.
fn above(layout: &Layout, stem: &str) -> String {
    let mut tex = String::new();
    let Some(first) = layout.panels.first() else { return tex };
    if !layout.legend.entries.is_empty() {
        let above = first.frame.top - layout.legend.height;
        let _ = writeln!(
            tex,
            "\\path (group c1r1.north west) -- node[anchor=south, yshift={above:.2}bp] \
             {{\\pgfplotslegendfromname{{figure-{}}}}} (group c{}r1.north east);",
            name(stem),
            layout.columns
        );
    }
    tex
}

fn plots(series: &Series, frame: &Frame, name: &str, table: &mut Table) -> String {
    let curve = Curve::new(series, frame);
    let thin = |lines: &[Vec<[f64; 2]>]| -> Vec<Vec<[f64; 2]>> {
        lines.iter().map(|line| curve::at_most(MAX_LINE_POINTS, line, frame)).collect()
    };
    let style = Style::of(series);
    let color = style.color;
    let mut tex = String::new();
    let mut plot = |look: String, suffix: &str, paths: &[Vec<[f64; 2]>]| {
        if paths.is_empty() {
            return;
        }
        let [x, y] = table.add(&format!("{name}{suffix}"), paths);
        let _ =
            writeln!(tex, "\\addplot[forget plot, {look}] table[x={x}, y={y}] {{\\figuretable}};");
    };
    let cover = style::AREA_OPACITY;
    let area = format!("draw=none, fill=figure{color}, fill opacity={cover}, mark=none");
    plot(area, "area", &thin(&curve.areas));
    plot(format!("{}, mark=none", line(&style)), "", &thin(&curve.lines));
    let points = if curve.marks.is_empty() { Vec::new() } else { vec![curve.marks.clone()] };
    plot(format!("only marks, {}", marks(&style)), "mark", &points);
    let bars: Vec<_> = curve.bars.iter().map(|&[x, low, high]| vec![[x, low], [x, high]]).collect();
    let look = format!(
        "figure{color}, line width={}bp, mark=-, mark size=1.6bp, mark options={{solid}}",
        style::BAR_WIDTH
    );
    plot(look, "bar", &bars);
    let points = if curve.arrows.is_empty() { Vec::new() } else { vec![curve.arrows.clone()] };
    let look =
        format!("only marks, mark=beyond, figure{color}, line width={}bp", style::ARROW_WIDTH);
    plot(look, "beyond", &points);
    tex
}

fn line(style: &Style) -> String {
    let mut look = format!("figure{}, line width={}bp, line join=round", style.color, style.width);
    if !style.dashes.is_empty() {
        look.push_str(", dash pattern=");
        for (i, dash) in style.dashes.iter().enumerate() {
            let _ = write!(look, "{} {dash}bp ", if i % 2 == 0 { "on" } else { "off" });
        }
    }
    look.trim_end().to_owned()
}

fn marks(style: &Style) -> String {
    let mark = match style.mark.outline {
        Outline::Circle => "*",
        Outline::Square => "square*",
        Outline::Triangle => "triangle*",
        Outline::Diamond => "diamond*",
        Outline::Cross => "x",
    };
    let [fill, edge] = style.mark.colors(style.color);
    format!(
        "figure{}, mark={mark}, mark size={:.2}bp, \
         mark options={{solid, fill=figure{fill}, draw=figure{edge}, line width={}bp}}",
        style.color,
        style.mark.size(),
        style.mark.pen()
    )
}

/// The characters that are allowed in the name of a label.
fn name(stem: &str) -> String {
    stem.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect()
}

/// Columns of numbers under their names.
#[derive(Default)]
struct Table {
    columns: Vec<(String, Vec<Option<f64>>)>,
}

impl Table {
    /// Adds columns for x and y; returns their names.
    fn add(&mut self, name: &str, paths: &[Vec<[f64; 2]>]) -> [String; 2] {
        let mut points: Vec<Option<[f64; 2]>> = Vec::new();
        for path in paths {
            if !points.is_empty() {
                points.push(None);
            }
            points.extend(path.iter().copied().map(Some));
        }
        let names = [format!("{name}x"), format!("{name}y")];
        for (i, name) in names.iter().enumerate() {
            let column = points.iter().map(|point| point.map(|point| point[i]));
            self.columns.push((name.clone(), column.collect()));
        }
        names
    }

    fn text(&self) -> String {
        let names: Vec<&str> = self.columns.iter().map(|(name, _)| name.as_str()).collect();
        let mut text = names.join(" ") + "\n";
        let rows = self.columns.iter().map(|(_, column)| column.len()).max().unwrap_or(0);
        for row in 0..rows {
            let cells: Vec<String> = self
                .columns
                .iter()
                .map(|(_, column)| match column.get(row) {
                    Some(Some(number)) => rounded(*number),
                    _ => "nan".to_owned(),
                })
                .collect();
            text += &(cells.join(" ") + "\n");
        }
        text
    }
}

/// Rounds to seven digits, the precision of TeX.
fn rounded(number: f64) -> String {
    let digits = format!("{number:.6e}");
    let (factor, exponent) = digits.split_once('e').expect("an exponent");
    let factor = factor.trim_end_matches('0').trim_end_matches('.');
    format!("{factor}e{exponent}")
}
