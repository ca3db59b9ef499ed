//! A `DataArray` of GIFTI: its attributes, and its numbers in any encoding.
//!
//! ```text
//! <DataArray Intent="NIFTI_INTENT_..." DataType="NIFTI_TYPE_..." ArrayIndexingOrder="RowMajorOrder|ColumnMajorOrder"
//!            Dimensionality="n" Dim0="..." ... Encoding="..." Endian="LittleEndian|BigEndian">
//!   <MetaData>...</MetaData> <CoordinateSystemTransformMatrix>...</CoordinateSystemTransformMatrix>     skipped
//!   <Data>numbers as text (ASCII), or bytes (Base64Binary), or their zlib stream (GZipBase64Binary)</Data>
//! </DataArray>
//! ```
//!
//! Some files have the names of the C library as values instead, such as `GIFTI_ENCODING_B64BIN`.

use std::io::Read;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use flate2::read::ZlibDecoder;

use crate::counted::counted;
use crate::error::Result;
use crate::mesh::io::scalar::Scalar;
use crate::mesh::io::text::{decode, quote};
use crate::mesh::io::xml::{Tag, Xml};

/// Some programs leave the padding out.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Compressed arrays may have this many bytes together as f64, or this many times those of the file if that is more.
const MOST_INFLATED: usize = 1 << 26;
const MOST_RATIO: usize = 64;

/// An array, row by row.
pub struct Array {
    pub intent: String,
    pub rows: usize,
    pub columns: usize,
    pub values: Vec<f64>,
}

/// How many bytes compressed arrays may still have.
pub struct Budget(usize);

impl Budget {
    /// That of a file of this length.
    pub fn of(length: usize) -> Self {
        Budget(MOST_INFLATED.max(length.saturating_mul(MOST_RATIO)))
    }
}

/// The attributes of an array.
struct Header {
    intent: String,
    of: Scalar,
    rows: usize,
    columns: usize,
    by_columns: bool,
    encoding: String,
    endian: Option<String>,
}

impl Header {
    fn read(xml: &Xml, tag: &Tag) -> Result<Self> {
        let need = |name: &str| {
            tag.get(name).ok_or_else(|| xml.error(format!("an array has no attribute {name}")))
        };
        let wrong = |name: &str, value: &str| {
            xml.error(format!("{} is not a valid {name}", quote(value.as_bytes())))
        };
        let name = need("DataType")?;
        let of = Scalar::of_nifti(&name).ok_or_else(|| wrong("DataType", &name))?;
        let length = |name: &str| {
            let value = need(name)?;
            value.parse().ok().filter(|&n: &usize| n > 0).ok_or_else(|| wrong(name, &value))
        };
        let axes = length("Dimensionality")?;
        if !(1..=6).contains(&axes) {
            return Err(wrong("Dimensionality", &axes.to_string()));
        }
        let rows = length("Dim0")?;
        let mut columns = 1;
        for axis in 1..axes {
            match (columns, length(&format!("Dim{axis}"))?) {
                (_, 1) => {}
                (1, n) => columns = n,
                _ => return Err(xml.error("an array has more than rows and columns")),
            }
        }
        let by_columns = match tag.get("ArrayIndexingOrder").as_deref() {
            None | Some("RowMajorOrder") => false,
            Some("ColumnMajorOrder") => true,
            Some(order) => return Err(wrong("ArrayIndexingOrder", order)),
        };
        let intent = tag.get("Intent").unwrap_or_default();
        let (encoding, endian) = (need("Encoding")?, tag.get("Endian"));
        Ok(Header { intent, of, rows, columns, by_columns, encoding, endian })
    }

    /// The number of values and of their bytes.
    fn sizes(&self, xml: &Xml) -> Result<(usize, usize)> {
        let count = self.rows.checked_mul(self.columns);
        let bytes = count.and_then(|count| count.checked_mul(self.of.size()));
        count.zip(bytes).ok_or_else(|| {
            let (rows, columns) = (self.rows, self.columns);
            xml.error(format!("an array of {rows} x {columns} numbers is too large"))
        })
    }

    fn is_big_endian(&self, xml: &Xml) -> Result<bool> {
        match self.endian.as_deref() {
            Some("LittleEndian" | "GIFTI_ENDIAN_LITTLE") => Ok(false),
            Some("BigEndian" | "GIFTI_ENDIAN_BIG") => Ok(true),
            Some(other) => {
                Err(xml.error(format!("{} is not a valid Endian", quote(other.as_bytes()))))
            }
            None => Err(xml.error("an array has no attribute Endian")),
        }
    }

    fn numbers(&self, xml: &Xml, text: &[u8], budget: &mut Budget) -> Result<Vec<f64>> {
        let (count, length) = self.sizes(xml)?;
        let bytes = match self.encoding.as_str() {
            "ASCII" | "GIFTI_ENCODING_ASCII" => return self.words(xml, text, count),
            "Base64Binary" | "GIFTI_ENCODING_B64BIN" => base64(xml, text)?,
            "GZipBase64Binary" | "GIFTI_ENCODING_B64GZ" => {
                inflated(xml, &base64(xml, text)?, count, length, budget)?
            }
            "ExternalFileBinary" => {
                let message = "the numbers of an array are in another file, which is not supported; convert this file \
                               to GZipBase64Binary";
                return Err(xml.error(message));
            }
            other => {
                let message = format!("{} is not a valid Encoding", quote(other.as_bytes()));
                return Err(xml.error(message));
            }
        };
        if bytes.len() != length {
            let has = counted(bytes.len(), "byte", "bytes");
            let (rows, columns) = (self.rows, self.columns);
            return Err(xml.error(format!(
                "an array has {has}, but its {rows} x {columns} numbers take {length}"
            )));
        }
        Ok(self.of.numbers(&bytes, self.is_big_endian(xml)?))
    }

    /// Numbers separated by blanks.
    fn words(&self, xml: &Xml, text: &[u8], count: usize) -> Result<Vec<f64>> {
        let mut values = Vec::with_capacity(count.min(text.len() / 2 + 1));
        let mut tokens = text.split(u8::is_ascii_whitespace).filter(|token| !token.is_empty());
        for token in tokens.by_ref().take(count) {
            values.push(self.of.number(token).ok_or_else(|| {
                xml.error(format!("{} is not a number of its type", quote(token)))
            })?);
        }
        if values.len() < count || tokens.next().is_some() {
            let has = if values.len() < count { values.len().to_string() } else { "more".into() };
            let message = format!("an array must have {count} numbers, but has {has}");
            return Err(xml.error(message));
        }
        Ok(values)
    }
}

/// Enters a `DataArray`, reads it and leaves it.
pub fn read(xml: &mut Xml, tag: &Tag, budget: &mut Budget) -> Result<Array> {
    let header = Header::read(xml, tag)?;
    let mut values = None;
    while let Some(child) = xml.child()? {
        match child.name {
            b"Data" if values.is_none() => {
                let text = xml.text()?;
                values = Some(header.numbers(xml, &text, budget)?);
            }
            _ => xml.skip()?,
        }
    }
    let mut values = values.ok_or_else(|| xml.error("an array has no element Data"))?;
    let Header { intent, rows, columns, by_columns, .. } = header;
    if by_columns && columns > 1 {
        values = (0..values.len()).map(|k| values[k % columns * rows + k / columns]).collect();
    }
    Ok(Array { intent, rows, columns, values })
}

fn base64(xml: &Xml, text: &[u8]) -> Result<Vec<u8>> {
    let packed: Vec<u8> = text.iter().copied().filter(|b| !b.is_ascii_whitespace()).collect();
    BASE64.decode(packed).map_err(|error| xml.error(format!("an array is not Base64: {error}")))
}

/// The content of a zlib stream, of which no more is inflated than there must be.
fn inflated(
    xml: &Xml,
    stream: &[u8],
    count: usize,
    length: usize,
    budget: &mut Budget,
) -> Result<Vec<u8>> {
    let left = count.checked_mul(size_of::<f64>()).and_then(|bytes| budget.0.checked_sub(bytes));
    let Some(left) = left else {
        return Err(xml.error(format!("{count} compressed numbers are too many for this file")));
    };
    budget.0 = left;
    let mut bytes = Vec::new();
    let most = u64::try_from(length).unwrap_or(u64::MAX).saturating_add(1);
    ZlibDecoder::new(stream)
        .take(most)
        .read_to_end(&mut bytes)
        .map_err(|_| xml.error("the compressed numbers of an array are damaged"))?;
    Ok(bytes)
}

/// The text of the current element as a name.
pub fn name(xml: &mut Xml) -> Result<String> {
    Ok(decode(xml.text()?.trim_ascii()))
}
