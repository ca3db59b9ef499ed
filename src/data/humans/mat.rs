//! The elements of a MATLAB file that hold labels: cells, structs of one element, and images of integers.
//!
//! ```text
//! file     128 bytes of header, then elements        element  type, length (4 bytes each), data, padding to 8 bytes;
//! matrix   elements: flags, dimensions, name, ...             or type and length in 2 bytes each, up to 4 bytes of data
//!          cell: its matrices                         compressed  the stream of zlib of one element
//!          struct: length of a name, names, a matrix for each
//!          numbers: in the smallest type that holds them, column by column
//! ```
//!
//! Versions 5 to 7, little-endian. All lengths are checked against the data, and what is inflated is limited.
//! Reference: The MathWorks, *MAT-File Format*, R2023a, chapter 1.

use std::io::Read;

use flate2::read::ZlibDecoder;
use ndarray::{Array2, ShapeBuilder};

use crate::counted::counted;

/// Compressed elements may inflate to this many bytes together, or to this many times the file if that is more.
const MAX_INFLATED: usize = 1 << 26;
const MAX_RATIO: usize = 64;

/// Images of labels have no more rows or columns.
const MAX_SIDE: usize = 1 << 20;

const INT8: u32 = 1;
const INT32: u32 = 5;
const UINT32: u32 = 6;
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;

const CELL: u8 = 1;
const STRUCT: u8 = 2;
const COMPLEX: u8 = 8;

/// What is wrong, to follow the name of the file.
type Result<T> = std::result::Result<T, String>;

const SHORT: &str = "is damaged: it ends inside an element";

/// A variable, a cell or a field.
pub struct Matrix {
    class: u8,
    complex: bool,
    dimensions: Vec<usize>,
    name: Vec<u8>,
    /// The elements after the name.
    content: Vec<u8>,
}

/// What a matrix holds.
pub enum Value {
    /// The cells of a cell array, column by column.
    Cells(Vec<Matrix>),
    /// The names and values of the fields of a struct of one element.
    Struct(Vec<(String, Matrix)>),
    /// Integers from 0 to 65,535, as rows and columns.
    Labels(Array2<u16>),
}

/// The variable of a name in the content of a file, if there is one.
pub fn find(bytes: &[u8], name: &str) -> Result<Option<Matrix>> {
    let mut rest = after_header(bytes)?;
    let mut budget = MAX_INFLATED.max(bytes.len().saturating_mul(MAX_RATIO));
    while !rest.is_empty() {
        let element = next(&mut rest)?;
        let inflated;
        let element = match element.kind {
            COMPRESSED => {
                inflated = inflate(element.data, budget)?;
                budget -= inflated.len();
                next(&mut inflated.as_slice())?
            }
            _ => element,
        };
        // Elements of other types are not variables.
        if element.kind == MATRIX {
            let matrix = Matrix::new(element.data)?;
            if matrix.name == name.as_bytes() {
                return Ok(Some(matrix));
            }
        }
    }
    Ok(None)
}

fn after_header(bytes: &[u8]) -> Result<&[u8]> {
    if bytes.starts_with(b"MATLAB 7.3") {
        return Err("is a MATLAB file of version 7.3; save it in MATLAB with the option -v7".into());
    }
    match bytes.split_at_checked(128) {
        Some((header, rest)) if header.ends_with(b"\x00\x01IM") => Ok(rest),
        Some((header, _)) if header.ends_with(b"\x01\x00MI") => Err(
            "is a big-endian MATLAB file, which is not supported; save it again on this machine"
                .into(),
        ),
        _ => Err("is not a MATLAB file of version 5 to 7".into()),
    }
}

fn inflate(data: &[u8], most: usize) -> Result<Vec<u8>> {
    let mut inflated = Vec::new();
    let mut decoder = ZlibDecoder::new(data).take(most as u64 + 1);
    decoder
        .read_to_end(&mut inflated)
        .map_err(|_| "is damaged: its compressed data cannot be read".to_owned())?;
    if inflated.len() > most {
        return Err(format!("inflates to more than {most} bytes, which is refused"));
    }
    Ok(inflated)
}

struct Element<'a> {
    kind: u32,
    data: &'a [u8],
}

/// Takes one element from the front.
fn next<'a>(rest: &mut &'a [u8]) -> Result<Element<'a>> {
    let take = |rest: &mut &'a [u8], n: usize| -> Result<&'a [u8]> {
        let (taken, behind) = rest.split_at_checked(n).ok_or(SHORT)?;
        *rest = behind;
        Ok(taken)
    };
    let tag = u32_at(take(rest, 4)?);
    if tag >> 16 != 0 {
        let length = (tag >> 16) as usize;
        let data = take(rest, 4)?.get(..length).ok_or("is damaged: a short element is too long")?;
        return Ok(Element { kind: tag & 0xffff, data });
    }
    let length = u32_at(take(rest, 4)?) as usize;
    let data = take(rest, length)?;
    // Compressed elements have no padding, and the last element of a file may lack it.
    if tag != COMPRESSED {
        *rest = rest.get(length.next_multiple_of(8) - length..).unwrap_or_default();
    }
    Ok(Element { kind: tag, data })
}

fn u32_at(bytes: &[u8]) -> u32 {
    u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
}

/// Takes one element of a known type.
fn next_of<'a>(kind: u32, rest: &mut &'a [u8]) -> Result<&'a [u8]> {
    let element = next(rest)?;
    if element.kind != kind {
        return Err(format!("is damaged: an element has type {}, not {kind}", element.kind));
    }
    Ok(element.data)
}

impl Matrix {
    fn new(data: &[u8]) -> Result<Self> {
        let mut rest = data;
        let flags = next_of(UINT32, &mut rest)?;
        let &[class, bits, ..] = flags else { return Err(SHORT.into()) };
        let dimensions = next_of(INT32, &mut rest)?.chunks_exact(4).map(|n| u32_at(n) as usize);
        let dimensions = dimensions.collect();
        let name = next_of(INT8, &mut rest)?.to_vec();
        let complex = bits & COMPLEX != 0;
        Ok(Matrix { class, complex, dimensions, name, content: rest.to_vec() })
    }

    fn next(rest: &mut &[u8]) -> Result<Self> {
        Matrix::new(next_of(MATRIX, rest)?)
    }

    /// What it holds. Fails if that is something else than [`Value`] has, or damaged.
    pub fn value(&self) -> Result<Value> {
        let mut rest = self.content.as_slice();
        match self.class {
            CELL => {
                let mut cells = Vec::new();
                while !rest.is_empty() {
                    cells.push(Matrix::next(&mut rest)?);
                }
                let declared = self.dimensions.iter().try_fold(1_usize, |n, &d| n.checked_mul(d));
                match declared == Some(cells.len()) {
                    true => Ok(Value::Cells(cells)),
                    false => {
                        Err("is damaged: a cell array does not have the declared cells".into())
                    }
                }
            }
            STRUCT => self.fields(rest).map(Value::Struct),
            6..=15 => self.labels(rest).map(Value::Labels),
            class => Err(format!("an array of class {class} holds no labels")),
        }
    }

    fn fields(&self, mut rest: &[u8]) -> Result<Vec<(String, Matrix)>> {
        if self.dimensions.iter().any(|&n| n != 1) {
            return Err("a struct array must have one element".into());
        }
        let width = next_of(INT32, &mut rest)?;
        let width = if width.len() == 4 { u32_at(width) as usize } else { 0 };
        let names = next_of(INT8, &mut rest)?;
        if width == 0 || names.len() % width != 0 {
            return Err("is damaged: the names of the fields have a wrong length".into());
        }
        let field = |name: &[u8]| {
            let end = name.iter().position(|&byte| byte == 0).unwrap_or(name.len());
            let name = String::from_utf8_lossy(&name[..end]).into_owned();
            Ok((name, Matrix::next(&mut rest)?))
        };
        names.chunks_exact(width).map(field).collect()
    }

    fn labels(&self, mut rest: &[u8]) -> Result<Array2<u16>> {
        let &[rows, columns] = self.dimensions.as_slice() else {
            return Err(format!("an image has {} dimensions, not 2", self.dimensions.len()));
        };
        if self.complex || !(1..=MAX_SIDE).contains(&rows) || !(1..=MAX_SIDE).contains(&columns) {
            return Err(format!(
                "an array of {rows} x {columns} numbers is not an image of labels"
            ));
        }
        let numbers = next(&mut rest)?;
        let labels = numbers.integers()?;
        let count = counted(labels.len(), "label", "labels");
        Array2::from_shape_vec((rows, columns).f(), labels)
            .map_err(|_| format!("is damaged: an image of {rows} x {columns} pixels has {count}"))
    }
}

impl Element<'_> {
    /// The numbers, if all are integers from 0 to 65,535.
    fn integers(&self) -> Result<Vec<u16>> {
        match self.kind {
            1 => self.each(|[a]: [u8; 1]| i64::from(a as i8)),
            2 => self.each(|[a]: [u8; 1]| i64::from(a)),
            3 => self.each(|bytes| i64::from(i16::from_le_bytes(bytes))),
            4 => self.each(|bytes| i64::from(u16::from_le_bytes(bytes))),
            5 => self.each(|bytes| i64::from(i32::from_le_bytes(bytes))),
            6 => self.each(|bytes| i64::from(u32::from_le_bytes(bytes))),
            9 => self.each(|bytes| {
                let x = f64::from_le_bytes(bytes);
                if x.fract() == 0.0 { x as i64 } else { -1 }
            }),
            12 => self.each(i64::from_le_bytes),
            kind => Err(format!("numbers of type {kind} are not labels")),
        }
    }

    fn each<const N: usize>(&self, integer: impl Fn([u8; N]) -> i64) -> Result<Vec<u16>> {
        let (numbers, rest) = self.data.as_chunks();
        if !rest.is_empty() {
            return Err(SHORT.into());
        }
        let label = |&bytes: &[u8; N]| {
            u16::try_from(integer(bytes))
                .map_err(|_| "a label is not an integer from 0 to 65,535".to_owned())
        };
        numbers.iter().map(label).collect()
    }
}
