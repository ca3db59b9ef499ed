//! Writing of labels as GIFTI (`.label.gii`).
//!
//! nibabel and Connectome Workbench call vertices without a label `???` and give them the key 0. So region p is written
//! as the key p + 1, with its name or `region p`, and -1 as the key 0.

use std::borrow::Cow;
use std::io::{self, Write};

use base64::prelude::BASE64_STANDARD;
use base64::write::EncoderWriter;
use flate2::Compression;
use flate2::write::ZlibEncoder;

use crate::one_line::one_line;

/// The name of vertices without a label.
pub const UNKNOWN: &str = "???";

/// Writes labels of vertices, -1 where there is none, with the names and colors of the regions.
///
/// Region p has the key p + 1, and -1 the key 0, whose name is `???`. Panics if a label has no color.
///
/// # Errors
/// `out` cannot be written.
pub fn write_labels(
    out: &mut dyn Write,
    labels: &[i32],
    names: &[Option<String>],
    colors: &[[f64; 3]],
) -> io::Result<()> {
    writeln!(out, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>")?;
    writeln!(
        out,
        "<!DOCTYPE GIFTI SYSTEM \"http://www.nitrc.org/frs/download.php/115/gifti.dtd\">"
    )?;
    writeln!(out, "<GIFTI Version=\"1.0\" NumberOfDataArrays=\"1\">\n<MetaData/>\n<LabelTable>")?;
    row(out, 0, [1.0, 1.0, 1.0, 0.0], UNKNOWN)?;
    for (p, &[red, green, blue]) in colors.iter().enumerate() {
        let name = match names.get(p) {
            Some(Some(name)) => Cow::Borrowed(name.as_str()),
            _ => Cow::Owned(format!("region {p}")),
        };
        row(out, p + 1, [red, green, blue, 1.0], &name)?;
    }
    writeln!(
        out,
        "</LabelTable>\n<DataArray Intent=\"NIFTI_INTENT_LABEL\" DataType=\"NIFTI_TYPE_INT32\" \
         ArrayIndexingOrder=\"RowMajorOrder\" Dimensionality=\"1\" Dim0=\"{}\" \
         Encoding=\"GZipBase64Binary\" Endian=\"LittleEndian\" ExternalFileName=\"\" ExternalFileOffset=\"0\">\n\
         <MetaData/>",
        labels.len()
    )?;
    write!(out, "<Data>")?;
    data(out, labels, colors.len())?;
    writeln!(out, "</Data>\n</DataArray>\n</GIFTI>")
}

fn row(out: &mut dyn Write, key: usize, rgba: [f64; 4], name: &str) -> io::Result<()> {
    // Unknown colors are black.
    let [red, green, blue, alpha] =
        rgba.map(|channel| if channel > 0.0 { channel.min(1.0) } else { 0.0 });
    let name = escaped(name);
    writeln!(
        out,
        "<Label Key=\"{key}\" Red=\"{red}\" Green=\"{green}\" Blue=\"{blue}\" Alpha=\"{alpha}\">{name}</Label>"
    )
}

fn data(out: &mut dyn Write, labels: &[i32], m: usize) -> io::Result<()> {
    let text = EncoderWriter::new(out, &BASE64_STANDARD);
    let mut stream = ZlibEncoder::new(text, Compression::default());
    for &label in labels {
        assert!(label == -1 || usize::try_from(label).is_ok_and(|p| p < m), "no color of {label}");
        stream.write_all(&(label + 1).to_le_bytes())?;
    }
    stream.finish()?.finish()?;
    Ok(())
}

/// A name as XML text. Characters that XML does not have are written as escapes, or as the replacement character.
fn escaped(name: &str) -> String {
    let mut text = String::new();
    for c in one_line(name).chars() {
        match c {
            '&' => text.push_str("&amp;"),
            '<' => text.push_str("&lt;"),
            '>' => text.push_str("&gt;"),
            '"' => text.push_str("&quot;"),
            '\u{fffe}' | '\u{ffff}' => text.push('\u{fffd}'),
            _ => text.push(c),
        }
    }
    text
}
