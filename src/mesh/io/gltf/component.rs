//! The types of the numbers of accessors.
//!
//! ```text
//! 5120 i8   5121 u8   5122 i16   5123 u16   5125 u32   5126 f32      little endian
//! normalized: max(c / 127, -1), c / 255, max(c / 32767, -1), c / 65535
//! ```
//!
//! Reference: Khronos Group, *glTF 2.0 Specification*, section 3.6.2.2, "Accessor Data Types".

/// The type of a component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    pub fn of(code: u32) -> Result<Self, String> {
        match code {
            5120 => Ok(Component::I8),
            5121 => Ok(Component::U8),
            5122 => Ok(Component::I16),
            5123 => Ok(Component::U16),
            5125 => Ok(Component::U32),
            5126 => Ok(Component::F32),
            _ => Err(format!("the componentType {code} is unknown")),
        }
    }

    pub fn size(self) -> usize {
        match self {
            Component::I8 | Component::U8 => 1,
            Component::I16 | Component::U16 => 2,
            Component::U32 | Component::F32 => 4,
        }
    }

    /// The number at the beginning of the bytes.
    pub fn number(self, bytes: &[u8], normalized: bool) -> f64 {
        let (c, full): (f64, f64) = match (self, bytes) {
            (Component::I8, &[a, ..]) => (i8::from_le_bytes([a]).into(), i8::MAX.into()),
            (Component::U8, &[a, ..]) => (a.into(), u8::MAX.into()),
            (Component::I16, &[a, b, ..]) => (i16::from_le_bytes([a, b]).into(), i16::MAX.into()),
            (Component::U16, &[a, b, ..]) => (u16::from_le_bytes([a, b]).into(), u16::MAX.into()),
            (Component::U32, &[a, b, c, d, ..]) => {
                (u32::from_le_bytes([a, b, c, d]).into(), u32::MAX.into())
            }
            (Component::F32, &[a, b, c, d, ..]) => {
                return f32::from_le_bytes([a, b, c, d]).into();
            }
            _ => unreachable!("elements have all their bytes"),
        };
        if normalized { (c / full).max(-1.0) } else { c }
    }

    /// An unsigned number at the beginning of the bytes.
    pub fn index(self, bytes: &[u8]) -> u32 {
        match (self, bytes) {
            (Component::U8, &[a, ..]) => a.into(),
            (Component::U16, &[a, b, ..]) => u16::from_le_bytes([a, b]).into(),
            (Component::U32, &[a, b, c, d, ..]) => u32::from_le_bytes([a, b, c, d]),
            _ => {
                unreachable!("only unsigned numbers are indices, and elements have all their bytes")
            }
        }
    }

    pub fn is_index(self) -> bool {
        matches!(self, Component::U8 | Component::U16 | Component::U32)
    }
}
