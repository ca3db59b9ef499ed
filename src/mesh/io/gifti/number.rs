//! The types of numbers in GIFTI, as bytes and as text. All become f64.

use crate::mesh::io::scalar::Scalar;
use crate::mesh::io::text::{parse_float, parse_integer};

impl Scalar {
    /// That of a name of NIfTI.
    pub fn of_nifti(name: &str) -> Option<Self> {
        Some(match name.strip_prefix("NIFTI_TYPE_")? {
            "UINT8" => Scalar::U8,
            "INT8" => Scalar::I8,
            "UINT16" => Scalar::U16,
            "INT16" => Scalar::I16,
            "UINT32" => Scalar::U32,
            "INT32" => Scalar::I32,
            "UINT64" => Scalar::U64,
            "INT64" => Scalar::I64,
            "FLOAT32" => Scalar::F32,
            "FLOAT64" => Scalar::F64,
            _ => return None,
        })
    }

    /// The numbers in bytes. Integers beyond 2^53, which are no index and no label, are rounded.
    pub fn numbers(self, bytes: &[u8], big: bool) -> Vec<f64> {
        match self {
            Scalar::U8 => numbers(bytes, big, |b| f64::from(u8::from_le_bytes(b))),
            Scalar::I8 => numbers(bytes, big, |b| f64::from(i8::from_le_bytes(b))),
            Scalar::U16 => numbers(bytes, big, |b| f64::from(u16::from_le_bytes(b))),
            Scalar::I16 => numbers(bytes, big, |b| f64::from(i16::from_le_bytes(b))),
            Scalar::U32 => numbers(bytes, big, |b| f64::from(u32::from_le_bytes(b))),
            Scalar::I32 => numbers(bytes, big, |b| f64::from(i32::from_le_bytes(b))),
            Scalar::U64 => numbers(bytes, big, |b| u64::from_le_bytes(b) as f64),
            Scalar::I64 => numbers(bytes, big, |b| i64::from_le_bytes(b) as f64),
            Scalar::F32 => numbers(bytes, big, |b| f64::from(f32::from_le_bytes(b))),
            Scalar::F64 => numbers(bytes, big, f64::from_le_bytes),
        }
    }

    /// A number written as text, rounded as one in bytes would be.
    pub fn number(self, token: &[u8]) -> Option<f64> {
        match self {
            Scalar::F64 => parse_float(token),
            Scalar::F32 => Some(f64::from(std::str::from_utf8(token).ok()?.parse::<f32>().ok()?)),
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
