//! Tests of figures: labels, legend, layout and file formats.

use super::layout::Frame;
use super::range::Range;
use super::ticks::{Decimal, Label, MINUS, Ticks, ticks};
use super::*;
use resvg::usvg::{Group, Node, Tree};

fn axis(label: &str, scale: Scale) -> Axis {
    Axis { label: label.to_owned(), scale }
}

fn series(label: &str, style: usize, primitive: Primitive, points: Vec<[f64; 2]>) -> Series {
    Series::new(label, style, primitive, points)
}

fn panel(scales: [Scale; 2], series: Vec<Series>) -> Panel {
    let [x, y] = scales;
    Panel { title: None, x: axis("time [s]", x), y: axis("relative gap", y), series }
}

fn figure(width: Width, columns: usize, panels: Vec<Panel>) -> Figure {
    Figure { panels, width, columns, shared: false }
}

const SCALES: [[Scale; 2]; 4] = [
    [Scale::Linear, Scale::Linear],
    [Scale::Linear, Scale::Log],
    [Scale::Log, Scale::Linear],
    [Scale::Log, Scale::Log],
];
const PRIMITIVES: [Primitive; 5] = [
    Primitive::Line,
    Primitive::Steps,
    Primitive::Marks,
    Primitive::LineMarks,
    Primitive::Reference,
];

/// Six solvers on four problems, with every primitive, breaks, bands, long texts and special characters of XML and
/// LaTeX.
fn crowded(width: Width, columns: usize) -> Figure {
    let panels = SCALES.iter().enumerate().map(|(p, &scales)| {
        let all = (0..11).map(|k| {
            let point = |i: i32| {
                let t = 0.01 * f64::from(i) * (1.0 + k as f64);
                [t, 0.5 * 1e3f64.powi(p as i32) * (1.0 + 9.0 * t).powf(-1.0 - 0.3 * k as f64)]
            };
            let mut points: Vec<[f64; 2]> = (0..300).map(point).collect();
            points[40][1] = [f64::NAN, 0.0, f64::INFINITY, -1.0][p];
            let label = if k == 10 { "" } else { &format!("solver <{k}> of 100% & more_or_less") };
            let mut series = series(label, k, PRIMITIVES[k % 5], points.clone());
            series.band = points.iter().map(|&[x, y]| [x, 0.8 * y, 1.3 * y]).collect();
            series.beyond = vec![points[70], points[299]];
            series
        });
        let mut panel = panel(scales, all.collect());
        panel.title = Some(format!("({p}) a problem with a title that is rather long, λ = 0.0{p}"));
        panel.y.label =
            "share of the problems that were solved to the wanted gap, in percent".to_owned();
        panel
    });
    figure(width, columns, panels.collect())
}

fn label_room(label: &Label) -> f64 {
    layout::label_width(label) + 5.0
}

fn ticks_of(scale: Scale, values: &[f64], length: f64) -> (Range, Ticks) {
    let range = Range::holding(scale, values.iter().copied()).unwrap();
    (range, ticks(&range, length, &label_room))
}

/// A label as plain text.
fn plain_text(label: &Label) -> String {
    let exponent = label.exponent.as_ref().map_or(String::new(), |e| format!("^{e}"));
    format!("{}{exponent}", label.text).replace(MINUS, "-").replace('\u{d7}', "*")
}

fn labels(scale: Scale, values: &[f64], length: f64) -> Vec<String> {
    ticks_of(scale, values, length).1.major.iter().map(|tick| plain_text(&tick.label)).collect()
}

/// The position that a label states, in units of the axis; the number itself may exceed a double.
fn stated_position(label: &Label, scale: Scale) -> f64 {
    let text = plain_text(label);
    let number = |text: &str| text.parse::<f64>().unwrap();
    let (factor, exponent) = match text.split_once('^') {
        None => (text.as_str(), "0"),
        Some((power, exponent)) => match power.strip_suffix("10").unwrap() {
            "" => ("1", exponent),
            factor => (factor.strip_suffix('*').unwrap(), exponent),
        },
    };
    match scale {
        Scale::Linear => number(&format!("{factor}e{exponent}")),
        Scale::Log => number(factor).log10() + number(exponent),
    }
}

#[test]
fn linear_ticks_have_as_few_digits_as_needed() {
    let labels = |values: &[f64]| labels(Scale::Linear, values, 130.0);
    assert_eq!(labels(&[0.0, 1.0]), ["0", "0.2", "0.4", "0.6", "0.8", "1"]);
    assert_eq!(labels(&[-3.0, 3.0]), ["-3", "-2", "-1", "0", "1", "2", "3"]);
    assert_eq!(labels(&[1000.0, 4000.0]), ["0", "1000", "2000", "3000", "4000"]);
    assert_eq!(labels(&[0.0, 2e6]), ["0", "0.5*10^6", "1*10^6", "1.5*10^6", "2*10^6"]);
    assert_eq!(labels(&[0.0, 4e-7]), ["0", "1*10^-7", "2*10^-7", "3*10^-7", "4*10^-7"]);
    assert_eq!(labels(&[5.0]), ["4.6", "4.8", "5", "5.2", "5.4"]);
    assert_eq!(labels(&[0.0]), ["-1", "-0.5", "0", "0.5", "1"]);
}

#[test]
fn logarithmic_ticks_are_decades_or_divide_a_few_decades() {
    let labels = |values: &[f64]| labels(Scale::Log, values, 130.0);
    assert_eq!(labels(&[1e-3, 1.0]), ["10^-3", "10^-2", "10^-1", "10^0"]);
    assert_eq!(labels(&[1.0, 20.0]), ["1", "2", "5", "10", "20"]);
    assert_eq!(labels(&[1e-7, 8e-7]), ["10^-7", "2*10^-7", "5*10^-7"]);
    assert_eq!(
        labels(&[1e-12, 1.0]),
        ["10^-12", "10^-10", "10^-8", "10^-6", "10^-4", "10^-2", "10^0"]
    );
    assert_eq!(labels(&[100.0, 102.0]), ["100", "100.5", "101", "101.5", "102"]);
    assert_eq!(labels(&[7.0]), ["5", "10", "20"]);
    let (_, three_decades) = ticks_of(Scale::Log, &[1e-3, 1.0], 130.0);
    let number = |digits, exponent| Decimal { digits, exponent };
    assert_eq!(three_decades.minor[..2], [number(8, -4), number(9, -4)]);
    assert_eq!(three_decades.minor.len(), 3 * 8 + 2);
}

/// On axes of every size there are at least two labels, which do not overlap and are at their true positions, inside
/// the axis and in order; minor ticks are inside.
#[test]
fn ticks_of_any_range_are_legible() {
    let sizes = (-42..=42).map(|e| 10f64.powi(7 * e));
    for size in sizes {
        for spread in [1.0, 1.0001, 1.01, 1.1, 1.7, 3.0, 9.0, 40.0, 1e3, 1e9, 1e30] {
            for (scale, sign) in [(Scale::Linear, 1.0), (Scale::Linear, -1.0), (Scale::Log, 1.0)] {
                let values = [sign * 1.23 * size, sign * 1.23 * (size * spread).min(1e299)];
                let (range, ticks) = ticks_of(scale, &values, 130.0);
                let description = format!("{scale:?} {values:?} {ticks:?}");
                assert!(ticks.major.len() >= 2, "{description}");
                let mut end = f64::NEG_INFINITY;
                for tick in &ticks.major {
                    let share = range.share(stated_position(&tick.label, scale));
                    assert!((-1e-6..=1.0 + 1e-6).contains(&share), "{description}");
                    assert!(
                        (range.share(tick.number.position(scale)) - share).abs() < 1e-6,
                        "{description}"
                    );
                    let half = layout::label_width(&tick.label) / 2.0;
                    assert!(130.0 * share - half > end, "{description}");
                    end = 130.0 * share + half;
                }
                for minor in &ticks.minor {
                    assert!((-1e-6..=1.0 + 1e-6).contains(&range.share(minor.position(scale))));
                }
            }
        }
    }
}

#[test]
fn a_range_contains_its_data_with_padding() {
    let range = |scale, values: &[f64]| Range::holding(scale, values.iter().copied());
    for scale in [Scale::Linear, Scale::Log] {
        assert!(range(scale, &[f64::NAN, f64::INFINITY, f64::NEG_INFINITY]).is_none());
        assert!(range(scale, &[]).is_none());
        for values in [&[2.0, 3.0][..], &[3.0], &[f64::NAN, 1.0, 2.0], &[1e-300, 1e300]] {
            let range = range(scale, values).unwrap();
            let from_zero = scale == Scale::Linear && range.low == 0.0;
            for share in values.iter().filter_map(|&v| scale.position(v)).map(|p| range.share(p)) {
                assert!(share < 1.0 && (share > 0.0 || from_zero), "{values:?}");
            }
        }
    }
    assert!(range(Scale::Log, &[0.0, -1.0]).is_none());
    assert_eq!(range(Scale::Linear, &[0.2, 1.0]).unwrap().low, 0.0);
    assert!(range(Scale::Linear, &[0.5, 1.0]).unwrap().low > 0.4);
}

fn frame(scales: [Scale; 2]) -> Frame {
    let range = |scale| Range::holding(scale, [1.0, 1000.0].into_iter()).unwrap();
    let [x, y] = scales.map(range);
    Frame { left: 0.0, top: 0.0, width: 200.0, height: 100.0, x, y }
}

#[test]
fn a_point_without_a_position_breaks_the_line() {
    let points = vec![[1.0, 1.0], [200.0, 0.0], [300.0, 10.0], [500.0, f64::NAN], [900.0, 1e3]];
    let line = series("", 0, Primitive::Line, points);
    let drawn = |scales| curve::Curve::new(&line, &frame(scales));
    let linear = drawn(SCALES[0]).lines;
    assert_eq!(linear, [vec![[1.0, 1.0], [200.0, 0.0], [300.0, 10.0]], vec![[900.0, 1e3]]]);
    let log = drawn(SCALES[3]);
    assert_eq!(log.lines.len(), 3);
    // Single points between two breaks are visible nevertheless.
    assert_eq!(log.marks, [[1.0, 1.0], [300.0, 10.0], [900.0, 1e3]]);
}

#[test]
fn steps_keep_their_value_until_the_next_x() {
    let steps = series("", 0, Primitive::Steps, vec![[1.0, 1.0], [100.0, 500.0], [200.0, 700.0]]);
    let corners = [[1.0, 1.0], [100.0, 1.0], [100.0, 500.0], [200.0, 500.0], [200.0, 700.0]];
    assert_eq!(curve::Curve::new(&steps, &frame(SCALES[0])).lines, [corners.to_vec()]);
}

#[test]
fn long_lines_have_about_eight_marks_at_different_positions_for_each_style() {
    let frame = frame(SCALES[3]);
    let points: Vec<[f64; 2]> =
        (10..=10_000).map(|i| [f64::from(i) / 10.0, 1e4 / f64::from(i)]).collect();
    let marks = |style| {
        let line = series("", style, Primitive::LineMarks, points.clone());
        curve::Curve::new(&line, &frame).marks
    };
    for style in 0..16 {
        assert!((7..=9).contains(&marks(style).len()), "{}", marks(style).len());
        assert!(marks(style).iter().all(|mark| points.contains(mark)));
    }
    for style in 0..7 {
        assert!(!marks(style).contains(&marks(style + 1)[0]));
    }
}

#[test]
fn styles_differ_with_color_and_without() {
    let styles: Vec<style::Style> = (0..32)
        .map(|k| style::Style::of(&series("", k, Primitive::LineMarks, Vec::new())))
        .collect();
    for (i, a) in styles.iter().enumerate() {
        for (k, b) in styles.iter().enumerate().skip(i + 1) {
            assert!(a.dashes != b.dashes || a.mark != b.mark, "{i} and {k}");
        }
    }
    for eight in styles.chunks(8) {
        for (i, a) in eight.iter().enumerate() {
            for b in &eight[i + 1..] {
                assert!(a.color != b.color && a.dashes != b.dashes && a.mark != b.mark);
            }
        }
    }
}

#[test]
fn the_legend_has_each_label_once() {
    let line = |label| series(label, 0, Primitive::Line, vec![[1.0, 1.0], [2.0, 2.0]]);
    let panels = vec![
        panel(SCALES[0], vec![line("b"), line(""), line("a"), line("b")]),
        panel(SCALES[0], vec![line("c"), line("a"), line(" ")]),
    ];
    let figure = figure(Width::Page, 2, panels);
    let layout = Layout::new(&figure).unwrap();
    let entries = &layout.legend.entries;
    let labels: Vec<&str> = entries.iter().map(|entry| entry.series.label.as_str()).collect();
    assert_eq!(labels, ["b", "a", "c"]);
}

/// Five columns fit, since both long labels are in one of them; four, which would suffice for two rows, do not.
#[test]
fn the_legend_fits_its_page() {
    let long = "x".repeat(22);
    let labels = [&long, "a", "b", "c", "d", &long.replace('x', "y"), "e"];
    let all = labels.map(|label| series(label, 0, Primitive::Marks, Vec::new()));
    let panels = [panel(SCALES[0], all.into())];
    let legend = legend::Legend::new(&panels, 0.0, 240.0);
    assert_eq!(legend.columns, 5);
    for entry in legend.entries {
        assert!(entry.sample[0] >= 0.0 && entry.at[0] + entry.width <= 240.0);
    }
}

/// A text of a figure with its left, top, right and bottom, as measured by the SVG reader.
#[derive(Debug)]
struct DrawnText {
    text: String,
    line: [f32; 4],
    /// A line is higher than its letters, so that lines are separated.
    letters: [f32; 4],
}

fn texts(group: &Group, drawn: &mut Vec<DrawnText>) {
    for node in group.children() {
        match node {
            Node::Group(group) => texts(group, drawn),
            Node::Text(node) => {
                let text = node.chunks().iter().map(|chunk| chunk.text()).collect();
                let at = node.abs_bounding_box();
                let line = [at.left(), at.top(), at.right(), at.bottom()];
                let mut letters = line;
                // Rotated text has its top on the left.
                let i = if node.abs_transform().has_skew() { 0 } else { 1 };
                letters[i] += 0.2 * (line[i + 2] - line[i]);
                letters[i + 2] -= 0.12 * (line[i + 2] - line[i]);
                drawn.push(DrawnText { text, line, letters });
            }
            _ => {}
        }
    }
}

/// Parses the SVG of a figure; returns the tree and its texts.
fn read(figure: &Figure) -> (Tree, Vec<DrawnText>) {
    let svg = svg::draw(&Layout::new(figure).unwrap(), Text::Typeset);
    let tree = convert::tree(&svg).unwrap();
    let mut drawn = Vec::new();
    texts(tree.root(), &mut drawn);
    (tree, drawn)
}

fn all_widths() -> impl Iterator<Item = Figure> {
    let sizes = [(Width::Column, 1), (Width::Column, 2), (Width::Page, 2), (Width::Page, 4)];
    sizes.into_iter().map(|(width, columns)| crowded(width, columns))
}

#[test]
fn no_text_leaves_the_page() {
    for figure in all_widths() {
        let (tree, texts) = read(&figure);
        assert!(texts.len() > 50);
        for DrawnText { text, line: [left, top, right, bottom], .. } in texts {
            let inside = left >= 0.0
                && top >= 0.0
                && right <= tree.size().width()
                && bottom <= tree.size().height();
            assert!(inside, "{text:?} at {left} {top} {right} {bottom} in {:?}", tree.size());
        }
    }
}

#[test]
fn texts_do_not_overlap() {
    for figure in all_widths() {
        let (_, texts) = read(&figure);
        for (i, one) in texts.iter().enumerate() {
            for other in &texts[i + 1..] {
                let (a, b) = (one.letters, other.letters);
                let disjoint = a[2] <= b[0] || b[2] <= a[0] || a[3] <= b[1] || b[3] <= a[1];
                assert!(disjoint, "{one:?} and {other:?}");
            }
        }
    }
}

/// The legend is above every plot, and all plots have equal sizes.
#[test]
fn plots_are_aligned_below_the_legend() {
    for figure in all_widths() {
        let layout = Layout::new(&figure).unwrap();
        let first = layout.panels[0].frame;
        assert!(layout.legend.height < first.top);
        for (i, placed) in layout.panels.iter().enumerate() {
            let frame = placed.frame;
            assert_eq!([frame.width, frame.height], [first.width, first.height]);
            assert_eq!(frame.left, layout.panels[i % layout.columns].frame.left);
            assert!(frame.right() < layout.width && frame.bottom() < layout.height);
        }
    }
}

#[test]
fn there_are_fewer_columns_if_plots_would_be_too_narrow() {
    let line = || series("a", 0, Primitive::Line, vec![[1.0, 1e-9], [2.0, 1.0]]);
    let panels = |n| (0..n).map(|_| panel(SCALES[3], vec![line()])).collect::<Vec<_>>();
    let columns = |width, n| Layout::new(&figure(width, n, panels(n))).unwrap().columns;
    assert_eq!(columns(Width::Page, 4), 4);
    assert!((1..4).contains(&columns(Width::Column, 12)));
    assert_eq!(columns(Width::Column, 1), 1);
    assert!(Layout::new(&figure(Width::Page, 2, Vec::new())).is_err());
    assert_eq!(Layout::new(&figure(Width::Page, 0, panels(1))).unwrap().columns, 1);
}

#[test]
fn compared_panels_have_the_same_ranges() {
    let line = |high| series("a", 0, Primitive::Line, vec![[1.0, 1.0], [high, high]]);
    let panels = || [10.0, 1000.0].map(|high| panel(SCALES[3], vec![line(high)])).to_vec();
    let ends = |shared| {
        let figure = Figure { shared, ..figure(Width::Page, 2, panels()) };
        let layout = Layout::new(&figure).unwrap();
        [0, 1].map(|i| (layout.panels[i].frame.x.high, layout.panels[i].frame.y.high))
    };
    let [own, wide] = ends(false);
    assert!(own.0 < wide.0 && own.1 < wide.1);
    assert_eq!(ends(true), [wide; 2]);
}

#[test]
fn panels_without_data_say_so() {
    let none = vec![[0.0, 1.0], [f64::NAN, 1.0], [1.0, -1.0]];
    let figure = figure(
        Width::Column,
        1,
        vec![
            panel(SCALES[3], Vec::new()),
            panel(SCALES[3], vec![series("a", 0, Primitive::LineMarks, none)]),
        ],
    );
    let (_, texts) = read(&figure);
    assert_eq!(texts.iter().filter(|texts| texts.text == "no data").count(), 2);
    assert_eq!(
        pgfplots::draw(&Layout::new(&figure).unwrap(), "stem").0.matches("no data").count(),
        2
    );
}

#[test]
fn numbers_of_any_size_are_drawn_or_left_out() {
    let odd = [0.0, -0.0, 1.0, -1.0, 5e-324, 1e-310, 1e-300, f64::MAX, f64::MIN, f64::EPSILON];
    let odd = [&odd[..], &[f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e299, -1e299]].concat();
    for scales in SCALES {
        for &a in &odd {
            let points: Vec<[f64; 2]> =
                odd.iter().flat_map(|&b| [[a, b], [b, a], [b, b]]).collect();
            let all = PRIMITIVES.map(|primitive| {
                let mut series = series("a", 3, primitive, points.clone());
                series.band = odd.iter().map(|&b| [a, b, a]).collect();
                series
            });
            let figure = figure(Width::Column, 1, vec![panel(scales, all.into())]);
            let layout = Layout::new(&figure).unwrap();
            let svg = svg::draw(&layout, Text::Typeset);
            let table = pgfplots::draw(&layout, "stem").1;
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
            assert!(!table.contains("NaN") && !table.contains("inf"), "{table}");
        }
    }
}

#[test]
fn text_is_measured_as_it_is_drawn() {
    for text in ["chambolle-pock", "AVATAR, fi ffl To.", "λ ≤ 10 − ε", "1.5\u{d7}10"] {
        let mut figure = figure(Width::Page, 1, vec![panel(SCALES[0], Vec::new())]);
        figure.panels[0].title = Some(text.to_owned());
        let (_, texts) = read(&figure);
        let [left, _, right, _] = texts.iter().find(|texts| texts.text == text).unwrap().line;
        let measured = text::width(text, text::LABEL_SIZE);
        assert!(
            (f64::from(right - left) - measured).abs() < 1e-3,
            "{text}: {left} {right} {measured}"
        );
        // Invisible text, which is searched, is as long as the outlines in any font.
        let svg = svg(&figure).unwrap();
        let line = svg.lines().find(|line| line.contains(&format!(">{text}</text>"))).unwrap();
        let (_, rest) = line.split_once(" textLength=\"").unwrap();
        let (length, _) = rest.split_once("\" lengthAdjust=\"spacingAndGlyphs\"").unwrap();
        assert!((length.parse::<f64>().unwrap() - measured).abs() <= 0.005, "{line}");
        assert!(line.contains(" fill-opacity=\"0\""), "{line}");
    }
}

/// A reader without any font shows what one with the bundled font does.
#[test]
fn outlines_need_no_font() {
    for figure in all_widths() {
        let outlined = resvg::usvg::Tree::from_str(
            &svg(&figure).unwrap(),
            &resvg::usvg::Options { dpi: 72.0, ..Default::default() },
        );
        let pixels = |tree: &Tree| {
            let bytes = convert::png(tree).unwrap();
            image::load_from_memory(&bytes).unwrap().into_luma8().into_raw()
        };
        let [typeset, outlined] = [pixels(&read(&figure).0), pixels(&outlined.unwrap())];
        assert_eq!(typeset.len(), outlined.len());
        let pairs = || typeset.iter().zip(&outlined);
        let different = pairs().filter(|(a, b)| a.abs_diff(**b) > 64).count();
        let dark = typeset.iter().filter(|&&gray| gray < 128).count();
        assert!(different * 1000 < dark, "{different} of {dark}");
    }
}

#[test]
fn lines_are_broken_to_fit_the_room() {
    let room = text::width("to a gap of", 8.0);
    for text in ["to a gap of 1e-5, to a gap", "incomprehensibilities", "a\nb\tc \u{7}", ""] {
        let lines = text::wrap(text, 8.0, room);
        assert!(lines.iter().all(|line| text::width(line, 8.0) <= room), "{lines:?}");
        let letters = |text: &str| text.replace(|c: char| c.is_whitespace() || c.is_control(), "");
        assert_eq!(letters(&lines.concat()), letters(text));
    }
    assert_eq!(text::wrap("a title of two lines", 8.0, 50.0), ["a title of", "two lines"]);
}

#[test]
fn the_png_has_300_dots_per_inch_and_is_opaque() {
    let figure = crowded(Width::Column, 2);
    let (tree, _) = read(&figure);
    let bytes = convert::png(&tree).unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
    let info = reader.info();
    assert_eq!(info.width, 999);
    assert_eq!(info.height, (tree.size().height() * 300.0 / 72.0).round() as u32);
    assert_eq!(info.pixel_dims.unwrap().xppu, 11811);
    assert_eq!(info.color_type, png::ColorType::Rgb);
    let mut pixels = vec![0; reader.output_buffer_size()];
    reader.next_frame(&mut pixels).unwrap();
    // White margins, also in the last row, which the page may cover only partially.
    let row = 3 * 999;
    assert!(pixels[pixels.len() - row..].iter().all(|&byte| byte == 255));
    // And colors inside.
    assert!(pixels.chunks_exact(3).any(|pixel| pixel == [0, 0x72, 0xB2]));
}

#[test]
fn the_pdf_has_the_requested_size_and_embeds_its_font() {
    let (tree, _) = read(&crowded(Width::Page, 2));
    let pdf = convert::pdf(&tree).unwrap();
    assert!(pdf.starts_with(b"%PDF"));
    let has = |what: &str| pdf.windows(what.len()).any(|window| window == what.as_bytes());
    assert!(has("/FontFile2") && has("SourceSans3"));
    let text = String::from_utf8_lossy(&pdf);
    let (_, size) = text.split_once("/MediaBox [0 0 ").unwrap();
    let width: f32 = size.split(' ').next().unwrap().parse().unwrap();
    // Sizes are in single precision.
    assert!((width - 6.9 * 72.0).abs() < 1e-4);
}

#[test]
fn equal_figures_give_equal_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let figure = crowded(Width::Page, 2);
    for stem in ["a", "b"] {
        let folder = folder.path().join(stem);
        std::fs::create_dir(&folder).unwrap();
        write(&figure, &folder, "fig_1", Formats::All).unwrap();
    }
    for extension in ["svg", "png", "pdf", "tex", "dat"] {
        let read = |stem: &str| {
            let path = folder.path().join(stem).join(format!("fig_1.{extension}"));
            std::fs::read(path).unwrap()
        };
        assert!(!read("a").is_empty());
        assert!(read("a") == read("b"), "{extension}");
    }
}

#[test]
fn latex_special_characters_are_escaped() {
    let escaped = tex::escaped;
    assert_eq!(escaped(r"50% of {a_b} & #1 for $2"), r"50\% of \{a\_b\} \& \#1 for \$2");
    assert_eq!(escaped(r"\x^2~"), r"\textbackslash{}x\textasciicircum{}2\textasciitilde{}");
    assert_eq!(escaped("λ ≤ 1 − ε"), r"$\lambda$ $\le$ 1 $-$ $\varepsilon$");
    assert_eq!(escaped("chambolle-pock"), "chambolle-pock");
}

/// Every column that the picture names is in the table, all rows have equal lengths, and braces are balanced.
#[test]
fn the_latex_picture_matches_its_table() {
    for figure in all_widths() {
        let layout = Layout::new(&figure).unwrap();
        let (tex, dat) = pgfplots::draw(&layout, "stem");
        let mut rows = dat.lines().map(|line| line.split(' ').collect::<Vec<_>>());
        let names = rows.next().unwrap();
        for cells in rows {
            assert_eq!(cells.len(), names.len());
            assert!(cells.iter().all(|cell| cell.parse::<f64>().is_ok()));
        }
        let mut named = 0;
        for plot in tex.split("table[").skip(1) {
            let (columns, _) = plot.split_once(']').unwrap();
            let mut columns = columns.split(", ").map(|column| column.split_once('=').unwrap().1);
            assert!(columns.all(|column| names.contains(&column)));
            named += 2;
        }
        assert_eq!(named, names.len());
        assert_eq!(tex.matches('{').count(), tex.matches('}').count());
        assert_eq!(tex.matches("\\nextgroupplot").count(), 4);
    }
}
