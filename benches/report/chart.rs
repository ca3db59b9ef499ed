//! A chart of the time of a step with 4 regions and two threads; a mark on each bar shows the memory limit of its
//! precision.

use std::path::Path;

use plotters::prelude::*;

use super::limit;
use super::measured::{Measured, Name};

/// Okabe and Ito's colors, which color-blind readers can distinguish.
const BAR: RGBColor = RGBColor(0, 114, 178);
const LIMIT: RGBColor = RGBColor(213, 94, 0);

pub fn draw(all: &[Measured], path: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let mut steps: Vec<&Measured> =
        all.iter().filter(|m| m.group == "step, m = 4" && m.name().threads == "2").collect();
    steps.sort_by(|a, b| a.median.total_cmp(&b.median));
    let longest = steps.iter().map(|m| 1e3 * m.median).fold(0.0, f64::max);
    let (row, left, top) = (34, 300, 46);
    let bottom = top + row * steps.len() as i32;
    let size = (900, bottom as u32 + 62);
    let root = SVGBackend::new(path, size).into_drawing_area();
    root.fill(&WHITE)?;
    let text = |size: u32| ("sans-serif", size).into_font();
    root.draw(&Text::new(
        "Milliseconds a step: 200,000 faces, 4 regions, 2 threads; the mark is the memory limit",
        (12, 14),
        text(17),
    ))?;
    let scale = (f64::from(size.0) - f64::from(left) - 90.0) / longest;
    for (i, step) in steps.iter().enumerate() {
        let y = top + row * i as i32;
        let Name { what, .. } = step.name();
        let x = |milliseconds: f64| left + (scale * milliseconds) as i32;
        let end = x(1e3 * step.median);
        root.draw(&Text::new(what.to_owned(), (12, y + 4), text(16)))?;
        root.draw(&Rectangle::new([(left, y), (end, y + row - 10)], BAR.filled()))?;
        let mut right = end;
        if let Some(limit) = limit(all, step) {
            let at = x(1e3 * limit);
            right = right.max(at);
            root.draw(&Rectangle::new([(at - 1, y - 4), (at + 2, y + row - 6)], LIMIT.filled()))?;
        }
        root.draw(&Text::new(format!("{:.2}", 1e3 * step.median), (right + 8, y + 4), text(16)))?;
    }
    let axis = &BLACK;
    let at = |milliseconds: f64| left + (scale * milliseconds) as i32;
    root.draw(&PathElement::new([(left, bottom), (at(longest) + 60, bottom)], axis))?;
    let spacing = tick_spacing(longest);
    for tick in (0..).map(|k| f64::from(k) * spacing).take_while(|&tick| tick <= longest) {
        let x = at(tick);
        root.draw(&PathElement::new([(x, bottom), (x, bottom + 5)], axis))?;
        root.draw(&Text::new(format!("{tick}"), (x - 4, bottom + 8), text(14)))?;
    }
    root.draw(&Text::new("milliseconds a step", (left, bottom + 32), text(15)))?;
    root.present()?;
    Ok(())
}

/// 1, 2 or 5 times a power of ten, such that an axis of this length has at most eight ticks.
fn tick_spacing(length: f64) -> f64 {
    let unit = 10_f64.powf((length / 8.0).log10().floor());
    [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|factor| factor * unit)
        .find(|it| length / it <= 8.0)
        .unwrap_or(unit)
}
