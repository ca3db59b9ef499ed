//! Numbers that the file of a mesh had, written with the mesh in their own types.

use crate::mesh::io::scalar::Scalar;
use crate::mesh::io::scalars::Scalars;

/// The numbers of vertices or of faces, behind those that are written in any case.
pub struct Others<'a>(Option<&'a Scalars>);

impl<'a> Others<'a> {
    /// Those of a file, if it had some.
    pub fn new(scalars: &'a Option<Scalars>) -> Self {
        Others(scalars.as_ref())
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_none()
    }

    /// The lines of the header. Names have no blanks.
    pub fn header(&self) -> String {
        let Some(scalars) = self.0 else { return String::new() };
        let names = scalars.free_names(&["x", "y", "z", "red", "green", "blue", "label"]);
        let property = |(name, scalar): (String, &Scalar)| {
            format!("property {} {}\n", scalar.ply(), name.replace(char::is_whitespace, "_"))
        };
        names.into_iter().zip(&scalars.types).map(property).collect()
    }

    /// The size of a record.
    pub fn bytes(&self) -> usize {
        self.0.map_or(0, |scalars| scalars.types.iter().map(|scalar| scalar.size()).sum())
    }

    /// Writes the numbers of a vertex or face into a record of this size.
    pub fn write(&self, row: usize, mut record: &mut [u8]) {
        let Some(scalars) = self.0 else { return };
        for (&x, scalar) in scalars.numbers.row(row).iter().zip(&scalars.types) {
            let (field, rest) = record.split_at_mut(scalar.size());
            match scalar {
                Scalar::I8 => field.copy_from_slice(&(x as i8).to_le_bytes()),
                Scalar::U8 => field.copy_from_slice(&(x as u8).to_le_bytes()),
                Scalar::I16 => field.copy_from_slice(&(x as i16).to_le_bytes()),
                Scalar::U16 => field.copy_from_slice(&(x as u16).to_le_bytes()),
                Scalar::I32 => field.copy_from_slice(&(x as i32).to_le_bytes()),
                Scalar::U32 => field.copy_from_slice(&(x as u32).to_le_bytes()),
                Scalar::F32 => field.copy_from_slice(&(x as f32).to_le_bytes()),
                Scalar::I64 | Scalar::U64 | Scalar::F64 => field.copy_from_slice(&x.to_le_bytes()),
            }
            record = rest;
        }
    }
}

impl Scalar {
    /// The name of the type in PLY, where integers of 64 bits become doubles.
    fn ply(self) -> &'static str {
        match self {
            Scalar::I8 => "char",
            Scalar::U8 => "uchar",
            Scalar::I16 => "short",
            Scalar::U16 => "ushort",
            Scalar::I32 => "int",
            Scalar::U32 => "uint",
            Scalar::F32 => "float",
            Scalar::I64 | Scalar::U64 | Scalar::F64 => "double",
        }
    }
}
