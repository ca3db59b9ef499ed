//! The types of numbers in GIFTI, as bytes and as text. All become f64.

use crate::mesh::io::text::{parse_float, parse_integer};

/// The type of the numbers of an array.
#[derive(Clone, Copy)]
pub enum Type {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
}

impl Type {
    /// That of a name of NIfTI.
    pub fn named(name: &str) -> Option<Self> {
        Some(match name.strip_prefix("NIFTI_TYPE_")? {
            "UINT8" => Type::U8,
            "INT8" => Type::I8,
            "UINT16" => Type::U16,
            "INT16" => Type::I16,
            "UINT32" => Type::U32,
            "INT32" => Type::I32,
            "UINT64" => Type::U64,
            "INT64" => Type::I64,
            "FLOAT32" => Type::F32,
            "FLOAT64" => Type::F64,
            _ => return None,
        })
    }

    /// In bytes.
    pub fn size(self) -> usize {
        match self {
            Type::U8 | Type::I8 => 1,
            Type::U16 | Type::I16 => 2,
            Type::U32 | Type::I32 | Type::F32 => 4,
            Type::U64 | Type::I64 | Type::F64 => 8,
        }
    }

    /// The numbers in bytes. Integers beyond 2^53, which are no index and no label, are rounded.
    pub fn numbers(self, bytes: &[u8], big: bool) -> Vec<f64> {
        match self {
            Type::U8 => numbers(bytes, big, |b| f64::from(u8::from_le_bytes(b))),
            Type::I8 => numbers(bytes, big, |b| f64::from(i8::from_le_bytes(b))),
            Type::U16 => numbers(bytes, big, |b| f64::from(u16::from_le_bytes(b))),
            Type::I16 => numbers(bytes, big, |b| f64::from(i16::from_le_bytes(b))),
            Type::U32 => numbers(bytes, big, |b| f64::from(u32::from_le_bytes(b))),
            Type::I32 => numbers(bytes, big, |b| f64::from(i32::from_le_bytes(b))),
            Type::U64 => numbers(bytes, big, |b| u64::from_le_bytes(b) as f64),
            Type::I64 => numbers(bytes, big, |b| i64::from_le_bytes(b) as f64),
            Type::F32 => numbers(bytes, big, |b| f64::from(f32::from_le_bytes(b))),
            Type::F64 => numbers(bytes, big, f64::from_le_bytes),
        }
    }

    /// A number written as text, rounded as one in bytes would be.
    pub fn number(self, token: &[u8]) -> Option<f64> {
        match self {
            Type::F64 => parse_float(token),
            Type::F32 => Some(f64::from(std::str::from_utf8(token).ok()?.parse::<f32>().ok()?)),
            _ => parse_integer(token).map(|number| number as f64),
        }
    }
}

fn numbers<const N: usize>(bytes: &[u8], big: bool, number: impl Fn([u8; N]) -> f64) -> Vec<f64> {
    let (chunks, _) = bytes.as_chunks::<N>();
    let ordered = |mut chunk: [u8; N]| {
        if big {
            chunk.reverse();
        }
        number(chunk)
    };
    chunks.iter().map(|&chunk| ordered(chunk)).collect()
}
