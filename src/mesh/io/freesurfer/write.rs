//! Writing of annotations of FreeSurfer, with a table of version 2, see `annotation.rs`.
//!
//! Colors are what tells labels apart in such a file. So the code 0 is that of vertices without a label, and of equal
//! colors all but the first are moved to the nearest blue that is free, as is black.

use std::collections::HashSet;
use std::io::{self, Write};

use super::annotation::code;

/// Writes labels of vertices, -1 where there is none, with the names and colors of the regions.
///
/// Region p is row p of the table, named by its name or `region p`. Vertices with the label -1 have the code 0, which
/// is not in the table. Black, and colors that an earlier region has, are changed by the least step of blue. Panics if
/// a label has no color.
///
/// # Errors
/// `out` cannot be written, there are more than 2^31 - 1 vertices, or the colors cannot be made different.
pub fn write_annotation(
    out: &mut dyn Write,
    labels: &[i32],
    names: &[Option<String>],
    colors: &[[f64; 3]],
) -> io::Result<()> {
    let colors = distinct(colors)?;
    int(out, length(labels.len())?)?;
    for (v, &label) in (0_i32..).zip(labels) {
        let color = match label {
            -1 => 0,
            _ => {
                let color = usize::try_from(label).ok().and_then(|p| colors.get(p));
                code(*color.unwrap_or_else(|| panic!("no color of {label}")))
            }
        };
        int(out, v)?;
        int(out, color)?;
    }
    let rows = length(colors.len())?;
    int(out, 1)?;
    int(out, -2)?;
    int(out, rows)?;
    text(out, "NOFILE")?;
    int(out, rows)?;
    for ((p, rgb), row) in colors.iter().enumerate().zip(0..) {
        int(out, row)?;
        match names.get(p) {
            Some(Some(name)) => text(out, name)?,
            _ => text(out, &format!("region {p}"))?,
        }
        for &channel in rgb {
            int(out, channel.into())?;
        }
        int(out, 0)?;
    }
    Ok(())
}

/// The colors in bytes, all different and none black.
fn distinct(colors: &[[f64; 3]]) -> io::Result<Vec<[u8; 3]>> {
    // Unknown colors are black, since `as` makes NaN 0.
    let byte = |channel: f64| (channel.clamp(0.0, 1.0) * 255.0).round() as u8;
    let mut taken = HashSet::from([[0; 3]]);
    let free = |taken: &HashSet<[u8; 3]>, [red, green, blue]: [u8; 3]| {
        let mut steps =
            (0..=u8::MAX).flat_map(|step| [blue.checked_add(step), blue.checked_sub(step)]);
        steps.find_map(|blue| {
            let color = [red, green, blue?];
            (!taken.contains(&color)).then_some(color)
        })
    };
    let mut all = Vec::with_capacity(colors.len());
    for color in colors {
        let color = free(&taken, color.map(byte)).ok_or_else(|| {
            io::Error::other("an annotation cannot hold so many labels of nearly the same color")
        })?;
        taken.insert(color);
        all.push(color);
    }
    Ok(all)
}

fn length(n: usize) -> io::Result<i32> {
    i32::try_from(n).map_err(|_| io::Error::other("an annotation holds less than 2^31 vertices"))
}

fn int(out: &mut dyn Write, n: i32) -> io::Result<()> {
    out.write_all(&n.to_be_bytes())
}

/// Without zeros, which end it.
fn text(out: &mut dyn Write, text: &str) -> io::Result<()> {
    let text = text.replace('\0', " ");
    int(out, length(text.len() + 1)?)?;
    out.write_all(text.as_bytes())?;
    out.write_all(&[0])
}
