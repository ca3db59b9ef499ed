//! Numbers of the types that VTK has, as text and as bytes.

use crate::counted::counted;
use crate::mesh::io::scalar::Scalar;

/// Integers, or numbers of floating point.
#[derive(Clone, Debug, PartialEq)]
pub enum Numbers {
    Integers(Vec<i64>),
    Floats(Vec<f64>),
}

impl Scalar {
    /// The type of a name in files of XML, such as `Float32`.
    pub fn of_xml(name: &str) -> Option<Self> {
        Some(match name {
            "Int8" => Scalar::I8,
            "UInt8" => Scalar::U8,
            "Int16" => Scalar::I16,
            "UInt16" => Scalar::U16,
            "Int32" => Scalar::I32,
            "UInt32" => Scalar::U32,
            "Int64" => Scalar::I64,
            "UInt64" => Scalar::U64,
            "Float32" => Scalar::F32,
            "Float64" => Scalar::F64,
            _ => return None,
        })
    }

    /// The type of a name in legacy files, such as `float`. `long` has 64 bits, and `vtkIdType` is written as `int`.
    pub fn of_legacy(name: &str) -> Option<Self> {
        Some(match name.to_ascii_lowercase().as_str() {
            "char" | "signed_char" => Scalar::I8,
            "unsigned_char" => Scalar::U8,
            "short" => Scalar::I16,
            "unsigned_short" => Scalar::U16,
            "int" | "vtkidtype" => Scalar::I32,
            "unsigned_int" => Scalar::U32,
            "long" | "vtktypeint64" => Scalar::I64,
            "unsigned_long" | "vtktypeuint64" => Scalar::U64,
            "float" => Scalar::F32,
            "double" => Scalar::F64,
            _ => return None,
        })
    }

    /// The full intensity of a color.
    pub fn full(self) -> Option<f64> {
        (self == Scalar::U8).then_some(255.0)
    }

    /// The numbers in bytes, whose length is a multiple of the size.
    pub fn of_bytes(self, bytes: &[u8], little: bool) -> Numbers {
        macro_rules! all {
            ($type:ty, $kind:ident, $wide:ty) => {
                Numbers::$kind(
                    bytes
                        .chunks_exact(size_of::<$type>())
                        .map(|chunk| {
                            let chunk = chunk.try_into().expect("a chunk of this size");
                            let number = match little {
                                true => <$type>::from_le_bytes(chunk),
                                false => <$type>::from_be_bytes(chunk),
                            };
                            number as $wide
                        })
                        .collect(),
                )
            };
        }
        match self {
            Scalar::I8 => all!(i8, Integers, i64),
            Scalar::U8 => all!(u8, Integers, i64),
            Scalar::I16 => all!(i16, Integers, i64),
            Scalar::U16 => all!(u16, Integers, i64),
            Scalar::I32 => all!(i32, Integers, i64),
            Scalar::U32 => all!(u32, Integers, i64),
            Scalar::I64 => all!(i64, Integers, i64),
            // Beyond 2^63 - 1 is no index and no size.
            Scalar::U64 => match all!(i64, Integers, i64) {
                Numbers::Integers(all) if all.iter().any(|&x| x < 0) => all!(u64, Floats, f64),
                numbers => numbers,
            },
            Scalar::F32 => all!(f32, Floats, f64),
            Scalar::F64 => all!(f64, Floats, f64),
        }
    }

    /// The numbers in text, separated by blanks; those of `Int8` and `UInt8` are numbers as well.
    ///
    /// # Errors
    /// A word is not such a number.
    pub fn of_words<'a>(
        self,
        words: impl Iterator<Item = &'a str>,
    ) -> std::result::Result<Numbers, String> {
        let wrong = |word: &str| {
            format!(
                "`{}` is not a number",
                word.chars().take(20).collect::<String>().escape_debug()
            )
        };
        if !self.is_integer() {
            // As VTK has it: what is written with fewer digits is rounded to the type when it is read.
            let narrow = |x: f64| if self == Scalar::F32 { f64::from(x as f32) } else { x };
            let number = |word: &'a str| word.parse().map(narrow).map_err(|_| wrong(word));
            return words.map(number).collect::<std::result::Result<_, _>>().map(Numbers::Floats);
        }
        let number = |word: &'a str| word.parse().map_err(|_| wrong(word));
        words.map(number).collect::<std::result::Result<_, _>>().map(Numbers::Integers)
    }
}

impl Numbers {
    pub fn extend(&mut self, others: Numbers) {
        match (&mut *self, others) {
            (Numbers::Integers(all), Numbers::Integers(others)) => all.extend(others),
            (_, others) => {
                let mut all = self.floats();
                all.extend(others.floats());
                *self = Numbers::Floats(all);
            }
        }
    }

    pub fn len(&self) -> usize {
        match self {
            Numbers::Integers(all) => all.len(),
            Numbers::Floats(all) => all.len(),
        }
    }

    /// A type that holds all of them.
    pub fn scalar(&self) -> Scalar {
        match self {
            Numbers::Integers(all) if all.iter().all(|&x| i32::try_from(x).is_ok()) => Scalar::I32,
            Numbers::Integers(_) => Scalar::I64,
            Numbers::Floats(_) => Scalar::F64,
        }
    }

    /// All of them; integers beyond 2^53 are rounded.
    pub fn floats(&self) -> Vec<f64> {
        match self {
            Numbers::Integers(all) => all.iter().map(|&x| x as f64).collect(),
            Numbers::Floats(all) => all.clone(),
        }
    }

    /// All of them, if they are integers.
    ///
    /// # Errors
    /// They are not.
    pub fn integers(self, what: &str) -> std::result::Result<Vec<i64>, String> {
        match self {
            Numbers::Integers(all) => Ok(all),
            Numbers::Floats(all) => Err(format!(
                "the {what} are {} that are not integers",
                counted(all.len(), "number", "numbers")
            )),
        }
    }
}
