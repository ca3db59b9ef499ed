//! The numbers after the header, as text or as bytes, behind one interface.

use std::path::Path;

use super::header::{Element, Header, Kind};
use crate::counted::counted;
use crate::error::{Error, Result};
use crate::mesh::io::scalar::Scalar;
use crate::mesh::io::text::{Text, parse_float, quote};

/// A source of numbers, in the order of the file.
pub trait Values: Sized {
    /// Called before the first element of a kind. Fails if there are more than the file can hold.
    fn expect(&mut self, element: &Element) -> Result<()>;
    /// Splits off the numbers of the next elements, if their size is known; reading continues after them.
    fn split_off(&mut self, element: &Element) -> Result<Option<Self>>;
    /// Called before each element.
    fn begin(&mut self) -> Result<()>;
    /// Called after the last element.
    fn finish(&mut self) -> Result<()>;
    /// A number of any type; it may be NaN or infinite.
    fn number(&mut self, scalar: Scalar) -> Result<f64>;
    /// The same; invalid text is NaN.
    fn number_or_nan(&mut self, scalar: Scalar) -> Result<f64>;
    /// A number of an integer type; unsigned 64-bit values saturate at the largest signed one.
    fn integer(&mut self, scalar: Scalar) -> Result<i64>;
    /// Appends the next n numbers of an integer type to `list`.
    fn integers(&mut self, scalar: Scalar, n: u64, list: &mut Vec<i64>) -> Result<()> {
        for _ in 0..n {
            list.push(self.integer(scalar)?);
        }
        Ok(())
    }
    fn skip(&mut self, scalar: Scalar, n: u64) -> Result<()>;
    /// The number of elements for which memory is reserved at once.
    fn capacity(&self, element: &Element) -> usize;
    fn error(&self, message: String) -> Error;
}

/// Words on any lines: some programs break elements over several lines, or put several on one.
pub struct Ascii<'a> {
    text: Text<'a>,
    /// The element being read, how many were begun, and how many there should be.
    element: String,
    begun: usize,
    count: usize,
}

impl<'a> Ascii<'a> {
    pub fn new(path: &'a Path, bytes: &'a [u8], header: &Header) -> Self {
        Ascii {
            text: Text::new(path, &bytes[header.length..]).behind(header.lines),
            element: String::new(),
            begun: 0,
            count: 0,
        }
    }

    #[inline]
    fn token(&mut self) -> Result<&'a [u8]> {
        if let Some(token) = self.text.token() {
            return Ok(token);
        }
        if !self.text.seek_token() {
            return Err(self.text.error(format!(
                "the file ends within element {} of {} {}; a value is missing",
                self.begun,
                self.count,
                quote(self.element.as_bytes())
            )));
        }
        self.text.expect_token("a value")
    }
}

impl Values for Ascii<'_> {
    fn expect(&mut self, element: &Element) -> Result<()> {
        self.element.clone_from(&element.name);
        self.begun = 0;
        self.count = element.count;
        Ok(())
    }

    fn split_off(&mut self, _: &Element) -> Result<Option<Self>> {
        Ok(None)
    }

    #[inline]
    fn begin(&mut self) -> Result<()> {
        if !self.text.seek_token() {
            return Err(self.text.error(format!(
                "the file ends after {} of {} {} elements",
                self.begun,
                self.count,
                quote(self.element.as_bytes())
            )));
        }
        self.begun += 1;
        Ok(())
    }

    fn finish(&mut self) -> Result<()> {
        if self.text.seek_token() {
            let token = self.text.token().unwrap_or_default();
            return Err(self.text.error(format!(
                "unexpected {}: there are more values than the header declares",
                quote(token)
            )));
        }
        Ok(())
    }

    #[inline]
    fn number(&mut self, _: Scalar) -> Result<f64> {
        let token = self.token()?;
        self.text.number_of(token, "a value")
    }

    #[inline]
    fn number_or_nan(&mut self, _: Scalar) -> Result<f64> {
        // NaN is written in many ways.
        Ok(parse_float(self.token()?).unwrap_or(f64::NAN))
    }

    #[inline]
    fn integer(&mut self, _: Scalar) -> Result<i64> {
        let token = self.token()?;
        self.text.integer_of(token, "a value")
    }

    fn skip(&mut self, _: Scalar, n: u64) -> Result<()> {
        for _ in 0..n {
            // Not parsed, since these values are not needed.
            self.token()?;
        }
        Ok(())
    }

    fn capacity(&self, element: &Element) -> usize {
        // In bytes, with a blank after each value.
        const SHORTEST_ELEMENT: usize = 6;
        element.count.min(self.text.remaining() / SHORTEST_ELEMENT + 1)
    }

    fn error(&self, message: String) -> Error {
        self.text.error(message)
    }
}

/// A number that does not fit becomes the largest, which is no valid index or length either.
fn signed(n: u64) -> i64 {
    i64::try_from(n).unwrap_or(i64::MAX)
}

/// Packed bytes of either order.
pub struct Binary<'a, const BIG_ENDIAN: bool> {
    path: &'a Path,
    rest: &'a [u8],
}

impl<'a, const BIG_ENDIAN: bool> Binary<'a, BIG_ENDIAN> {
    pub fn new(path: &'a Path, bytes: &'a [u8], header: &Header) -> Self {
        Binary { path, rest: &bytes[header.length..] }
    }

    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N]> {
        let Some((bytes, rest)) = self.rest.split_first_chunk() else {
            return Err(self.too_short());
        };
        self.rest = rest;
        let mut bytes = *bytes;
        if BIG_ENDIAN {
            bytes.reverse();
        }
        Ok(bytes)
    }

    fn take_list<const N: usize>(
        &mut self,
        n: u64,
        list: &mut Vec<i64>,
        number: impl Fn([u8; N]) -> i64,
    ) -> Result<()> {
        let size = usize::try_from(n).ok().and_then(|n| n.checked_mul(N));
        let split = size.and_then(|size| self.rest.split_at_checked(size));
        let Some((items, rest)) = split else { return Err(self.too_short()) };
        self.rest = rest;
        let numbers = items.as_chunks().0.iter().map(|&item| {
            let mut bytes: [u8; N] = item;
            if BIG_ENDIAN {
                bytes.reverse();
            }
            number(bytes)
        });
        list.extend(numbers);
        Ok(())
    }

    fn too_short(&self) -> Error {
        Error::malformed(
            self.path,
            "ends before the last element; it is truncated, or its header is wrong",
        )
    }
}

impl<const BIG_ENDIAN: bool> Values for Binary<'_, BIG_ENDIAN> {
    fn expect(&mut self, element: &Element) -> Result<()> {
        match element.count.checked_mul(element.min_size()) {
            Some(size) if size <= self.rest.len() => Ok(()),
            _ => Err(Error::malformed(
                self.path,
                format!(
                    "the header declares {} {} elements, for which the file is too short",
                    element.count,
                    quote(element.name.as_bytes())
                ),
            )),
        }
    }

    fn split_off(&mut self, element: &Element) -> Result<Option<Self>> {
        if element.properties.iter().any(|property| matches!(property.kind, Kind::List { .. })) {
            return Ok(None);
        }
        self.expect(element)?;
        let (own, behind) = self.rest.split_at(element.count * element.min_size());
        self.rest = behind;
        Ok(Some(Binary { path: self.path, rest: own }))
    }

    #[inline]
    fn begin(&mut self) -> Result<()> {
        Ok(())
    }

    fn finish(&mut self) -> Result<()> {
        let padding = |&b: &u8| b == 0 || b.is_ascii_whitespace();
        if self.rest.iter().all(padding) {
            return Ok(());
        }
        Err(Error::malformed(
            self.path,
            format!(
                "{} the last element that the header declares; the header is wrong",
                counted(self.rest.len(), "byte follows", "bytes follow")
            ),
        ))
    }

    #[inline]
    fn number(&mut self, scalar: Scalar) -> Result<f64> {
        Ok(match scalar {
            Scalar::F32 => f64::from(f32::from_le_bytes(self.take()?)),
            Scalar::F64 => f64::from_le_bytes(self.take()?),
            // Exact up to 53 bits.
            _ => self.integer(scalar)? as f64,
        })
    }

    #[inline]
    fn number_or_nan(&mut self, scalar: Scalar) -> Result<f64> {
        self.number(scalar)
    }

    #[inline]
    fn integer(&mut self, scalar: Scalar) -> Result<i64> {
        Ok(match scalar {
            Scalar::I8 => i8::from_le_bytes(self.take()?).into(),
            Scalar::U8 => u8::from_le_bytes(self.take()?).into(),
            Scalar::I16 => i16::from_le_bytes(self.take()?).into(),
            Scalar::U16 => u16::from_le_bytes(self.take()?).into(),
            Scalar::I32 => i32::from_le_bytes(self.take()?).into(),
            Scalar::U32 => u32::from_le_bytes(self.take()?).into(),
            Scalar::I64 => i64::from_le_bytes(self.take()?),
            Scalar::U64 => signed(u64::from_le_bytes(self.take()?)),
            Scalar::F32 | Scalar::F64 => unreachable!("the header refuses them as integers"),
        })
    }

    #[inline]
    fn integers(&mut self, scalar: Scalar, n: u64, list: &mut Vec<i64>) -> Result<()> {
        match scalar {
            Scalar::I8 => self.take_list(n, list, |b| i8::from_le_bytes(b).into()),
            Scalar::U8 => self.take_list(n, list, |b| u8::from_le_bytes(b).into()),
            Scalar::I16 => self.take_list(n, list, |b| i16::from_le_bytes(b).into()),
            Scalar::U16 => self.take_list(n, list, |b| u16::from_le_bytes(b).into()),
            Scalar::I32 => self.take_list(n, list, |b| i32::from_le_bytes(b).into()),
            Scalar::U32 => self.take_list(n, list, |b| u32::from_le_bytes(b).into()),
            Scalar::I64 => self.take_list(n, list, i64::from_le_bytes),
            Scalar::U64 => self.take_list(n, list, |b| signed(u64::from_le_bytes(b))),
            Scalar::F32 | Scalar::F64 => unreachable!("the header refuses them as integers"),
        }
    }

    fn skip(&mut self, scalar: Scalar, n: u64) -> Result<()> {
        let size = usize::try_from(n).ok().and_then(|n| n.checked_mul(scalar.size()));
        match size.and_then(|size| self.rest.get(size..)) {
            Some(rest) => {
                self.rest = rest;
                Ok(())
            }
            None => Err(self.too_short()),
        }
    }

    /// All elements: `expect` has checked that the file is long enough.
    fn capacity(&self, element: &Element) -> usize {
        element.count
    }

    fn error(&self, message: String) -> Error {
        Error::malformed(self.path, message)
    }
}
