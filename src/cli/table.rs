//! Short tables: names on the left, values aligned.

/// One `name  value` line each, names padded to the longest.
pub fn pairs(lines: &[(&str, String)]) -> String {
    let width = lines.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    lines.iter().map(|(name, value)| format!("{name:<width$}  {value}\n")).collect()
}

/// Columns separated by two spaces, all but the first right-aligned.
pub fn columns(rows: &[Vec<String>]) -> String {
    let count = rows.first().map_or(0, Vec::len);
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max();
    let widths: Vec<usize> = (0..count).filter_map(width).collect();
    rows.iter()
        .map(|row| {
            let cells = row.iter().zip(&widths).enumerate().map(|(column, (cell, width))| {
                if column == 0 { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
            });
            cells.collect::<Vec<_>>().join("  ").trim_end().to_owned() + "\n"
        })
        .collect()
}

/// A common format for numbers of which `largest` has the largest magnitude: `digits` digits after the point, or
/// `digits` significant ones if half of the former would be zeros or there are too many before the point.
pub fn common_format(largest: f64, digits: usize) -> impl Fn(f64) -> String {
    let least = 0.1_f64.powf(0.5 * digits as f64);
    let plain = largest == 0.0 || (least..1e7).contains(&largest);
    move |x| if plain { format!("{x:.digits$}") } else { format!("{x:.*e}", digits - 1) }
}

/// The largest magnitude of the numbers.
pub fn largest<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> f64 {
    numbers.into_iter().fold(0.0, |largest, x| f64::max(largest, x.abs()))
}

/// Nine significant digits, plain where that reads well.
pub fn number(x: f64) -> String {
    if x == 0.0 || !(1e-3..1e7).contains(&x.abs()) {
        return format!("{x:.8e}");
    }
    let before_point = x.abs().log10().floor() as i32 + 1;
    format!("{x:.*}", (9 - before_point).max(0) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_any_size_are_short() {
        let text = |x: f64, digits| common_format(x, digits)(x);
        assert_eq!(text(1.0, 9), "1.000000000");
        assert_eq!(text(0.0, 3), "0.000");
        assert_eq!(text(0.25, 3), "0.250");
        assert_eq!(text(3.5e-4, 3), "3.50e-4");
        assert_eq!(text(6.25e60, 9), "6.25000000e60");
        assert_eq!(text(5_411_900.5, 6), "5411900.500000");
        // Numbers next to a large one have its format.
        assert_eq!(common_format(1e30, 3)(-2.5e-3), "-2.50e-3");
        assert_eq!(common_format(largest(&[-4.0, 1.0]), 3)(1e-9), "0.000");
        assert_eq!(number(1e300), "1.00000000e300");
    }
}
