//! The header of a PLY file: its encoding, its elements, and the types of their properties.
//!
//! ```text
//! ply
//! format ascii|binary_little_endian|binary_big_endian 1.0
//! comment ... | comment TextureFile NAME | obj_info ...
//! element NAME COUNT
//! property TYPE NAME | property list TYPE TYPE NAME
//! end_header
//! ```

use std::path::Path;

use crate::error::{Error, Result};
use crate::mesh::io::scalar::Scalar;
use crate::mesh::io::text::{BYTE_ORDER_MARK, file_name, quote};

/// The maximum number of elements that a header may declare.
const MAX_ELEMENTS: usize = 1000;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

impl Scalar {
    fn parse(name: &[u8]) -> Option<Self> {
        match name {
            b"char" | b"int8" => Some(Scalar::I8),
            b"uchar" | b"uint8" => Some(Scalar::U8),
            b"short" | b"int16" => Some(Scalar::I16),
            b"ushort" | b"uint16" => Some(Scalar::U16),
            b"int" | b"int32" => Some(Scalar::I32),
            b"uint" | b"uint32" => Some(Scalar::U32),
            b"int64" | b"longlong" | b"long" => Some(Scalar::I64),
            b"uint64" | b"ulonglong" | b"ulong" => Some(Scalar::U64),
            b"float" | b"float32" => Some(Scalar::F32),
            b"double" | b"float64" => Some(Scalar::F64),
            _ => None,
        }
    }

    /// The value of full intensity of a color component, if the type determines it.
    pub fn full_intensity(self) -> Option<f64> {
        match self {
            Scalar::F32 | Scalar::F64 => None,
            Scalar::U16 => Some(65535.0),
            _ => Some(255.0),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Scalar(Scalar),
    /// First the number of items, then the items.
    List {
        count: Scalar,
        item: Scalar,
    },
}

#[derive(Debug)]
pub struct Property {
    name: String,
    pub kind: Kind,
}

impl Property {
    pub fn name(&self) -> &str {
        &self.name
    }
}

#[derive(Debug)]
pub struct Element {
    pub name: String,
    pub count: usize,
    pub properties: Vec<Property>,
}

impl Element {
    /// The minimum number of bytes of the element in a binary file.
    pub fn min_size(&self) -> usize {
        let sizes = self.properties.iter().map(|property| match property.kind {
            Kind::Scalar(scalar) => scalar.size(),
            Kind::List { count, .. } => count.size(),
        });
        sizes.sum()
    }

    /// The index and kind of the property with the given name.
    fn find(&self, path: &Path, name: &str) -> Result<Option<(usize, Kind)>> {
        let mut found =
            self.properties.iter().enumerate().filter(|(_, property)| property.name == name);
        let first = found.next().map(|(at, property)| (at, property.kind));
        if found.next().is_some() {
            return Err(self.error(path, name, "is declared twice"));
        }
        Ok(first)
    }

    fn error(&self, path: &Path, name: &str, message: &str) -> Error {
        Error::malformed(path, format!("{} property {name} {message}", self.name))
    }

    /// The index of a required scalar property.
    pub fn scalar(&self, path: &Path, name: &str) -> Result<usize> {
        match self.find(path, name)? {
            None => Err(Error::malformed(
                path,
                format!("the element {} has no property {name}", self.name),
            )),
            Some((at, Kind::Scalar(_))) => Ok(at),
            Some((_, Kind::List { .. })) => {
                Err(self.error(path, name, "is a list; it must be a number"))
            }
        }
    }

    /// The index and type of the first property with the given name, if it is a scalar.
    pub fn any_scalar(&self, name: &str) -> Option<(usize, Scalar)> {
        let mut named = self.properties.iter().enumerate().filter(|(_, p)| p.name == name);
        named.find_map(|(at, property)| match property.kind {
            Kind::Scalar(scalar) => Some((at, scalar)),
            Kind::List { .. } => None,
        })
    }

    /// The index of the first property with the given name, if it is a list.
    pub fn any_list(&self, name: &str) -> Option<usize> {
        self.properties.iter().position(|p| p.name == name && matches!(p.kind, Kind::List { .. }))
    }

    /// The index of an optional list property, which must not be a scalar, and the type of its items.
    fn list(&self, path: &Path, name: &str) -> Result<Option<(usize, Scalar)>> {
        match self.find(path, name)? {
            None => Ok(None),
            Some((at, Kind::List { item, .. })) => Ok(Some((at, item))),
            Some((_, Kind::Scalar(_))) => {
                Err(self.error(path, name, "is a number; it must be a list"))
            }
        }
    }

    /// The index of the list of vertex indices.
    pub fn indices(&self, path: &Path) -> Result<usize> {
        let names = ["vertex_indices", "vertex_index"];
        for name in names {
            if let Some((at, item)) = self.list(path, name)? {
                return if item.is_integer() {
                    Ok(at)
                } else {
                    Err(self.error(path, name, "must have items of an integer type"))
                };
            }
        }
        let message = format!("the element {} has no list property {}", self.name, names[0]);
        Err(Error::malformed(path, message))
    }

    /// The first group of names that are all scalar properties.
    pub fn first_complete<const N: usize>(
        &self,
        groups: &[[&str; N]],
    ) -> Option<[(usize, Scalar); N]> {
        groups.iter().find_map(|group| {
            let found = group.map(|name| self.any_scalar(name));
            let complete = found.iter().all(Option::is_some);
            complete.then(|| found.map(|found| found.expect("all are there")))
        })
    }
}

#[derive(Debug)]
pub struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// The images named by comments, `comment TextureFile NAME`.
    pub textures: Vec<String>,
    /// The length of the header in bytes and lines.
    pub length: usize,
    pub lines: usize,
}

/// Whether the first line is `ply`.
pub fn recognizes(bytes: &[u8]) -> bool {
    line_end(&bytes[mark_length(bytes)..]).is_some()
}

fn mark_length(bytes: &[u8]) -> usize {
    if bytes.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len() } else { 0 }
}

/// The line end after the first line, which the whole header must use: binary data after a lone CR may begin with the
/// byte of an LF.
fn line_end(bytes: &[u8]) -> Option<&'static [u8]> {
    let rest = bytes.strip_prefix(b"ply")?;
    let blanks = rest.iter().take_while(|&&b| b == b' ' || b == b'\t');
    let rest = &rest[blanks.count()..];
    [b"\r\n".as_slice(), b"\n", b"\r"].into_iter().find(|end| rest.starts_with(end))
}

impl Header {
    pub fn parse(path: &Path, bytes: &[u8]) -> Result<Self> {
        let mark = mark_length(bytes);
        let end = line_end(&bytes[mark..]).ok_or_else(|| {
            Error::malformed_line(path, 1, "expected ply; this is not a PLY file")
        })?;
        let mut declared = Declared::default();
        let (mut at, mut number) = (mark, 0);
        loop {
            let rest = &bytes[at..];
            let Some(length) = find(rest, end) else {
                return Err(Error::malformed(path, "ends before end_header"));
            };
            at += length + end.len();
            number += 1;
            let line = &rest[..length];
            let words: Vec<&[u8]> =
                line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).collect();
            match words[..] {
                [b"ply"] if number == 1 => {}
                [b"end_header"] => break,
                _ => declared
                    .add(line, &words)
                    .map_err(|message| Error::malformed_line(path, number, message))?,
            }
        }
        let Declared { encoding, elements, textures } = declared;
        let encoding =
            encoding.ok_or_else(|| Error::malformed(path, "the header has no format line"))?;
        Ok(Header { encoding, elements, textures, length: at, lines: number })
    }
}

/// The declarations in the lines of a header.
#[derive(Default)]
struct Declared {
    encoding: Option<Encoding>,
    elements: Vec<Element>,
    textures: Vec<String>,
}

impl Declared {
    /// Adds a line; fails with a message if it is invalid.
    fn add(&mut self, line: &[u8], words: &[&[u8]]) -> std::result::Result<(), String> {
        match *words {
            [b"comment", b"TextureFile", _, ..] => self.textures.push(texture_file(line)),
            [] | [b"comment" | b"obj_info", ..] => {}
            [b"format", _, version] if version != b"1.0" => {
                return Err(format!("the version is {}; it must be 1.0", quote(version)));
            }
            [b"format", name, _] if self.encoding.is_none() => {
                self.encoding = Some(match name {
                    b"ascii" => Encoding::Ascii,
                    b"binary_little_endian" => Encoding::LittleEndian,
                    b"binary_big_endian" => Encoding::BigEndian,
                    _ => {
                        return Err(format!(
                            "the format {} is unknown; use ascii, binary_little_endian or binary_big_endian",
                            quote(name)
                        ));
                    }
                });
            }
            [b"element", name, count] => self.add_element(name, count)?,
            [b"property", ..] => self.add_property(words)?,
            _ => return Err(format!("{} is not a valid line of a PLY header", quote(line))),
        }
        Ok(())
    }

    fn add_element(&mut self, name: &[u8], count: &[u8]) -> std::result::Result<(), String> {
        let name = String::from_utf8_lossy(name).into_owned();
        if self.elements.len() == MAX_ELEMENTS || self.elements.iter().any(|e| e.name == name) {
            return Err(format!(
                "the element {} is declared twice, or there are too many elements",
                quote(name.as_bytes())
            ));
        }
        let count = parse_count(&name, count)?;
        self.elements.push(Element { count, name, properties: Vec::new() });
        Ok(())
    }

    fn add_property(&mut self, words: &[&[u8]]) -> std::result::Result<(), String> {
        let property = parse_property(words)?;
        let element =
            self.elements.last_mut().ok_or("a property is declared before the first element")?;
        element.properties.push(property);
        Ok(())
    }
}

/// The file name in a `TextureFile` comment, which may contain blanks.
fn texture_file(line: &[u8]) -> String {
    const KEYWORD: &[u8] = b"TextureFile";
    let at = line.windows(KEYWORD.len()).position(|window| window == KEYWORD).unwrap_or_default();
    file_name(&line[at + KEYWORD.len()..])
}

fn find(bytes: &[u8], end: &[u8]) -> Option<usize> {
    bytes.windows(end.len()).position(|window| window == end)
}

fn parse_count(element: &str, token: &[u8]) -> std::result::Result<usize, String> {
    let count = std::str::from_utf8(token)
        .ok()
        .and_then(|token| token.parse::<usize>().ok())
        .ok_or_else(|| format!("{} is not a valid number of elements", quote(token)))?;
    if element == "vertex" && u32::try_from(count).is_err() {
        return Err(format!("{count} vertices are too many; at most 2^32 - 1 are possible"));
    }
    Ok(count)
}

fn parse_property(words: &[&[u8]]) -> std::result::Result<Property, String> {
    let scalar = |name: &[u8]| {
        Scalar::parse(name).ok_or_else(|| format!("the property type {} is unknown", quote(name)))
    };
    let (kind, name) = match *words {
        [_, b"list", count, item, name] => {
            let count = scalar(count)?;
            if !count.is_integer() {
                return Err("the length of a list must be of an integer type".into());
            }
            let item = scalar(item)?;
            (Kind::List { count, item }, name)
        }
        [_, kind, name] => (Kind::Scalar(scalar(kind)?), name),
        _ => return Err("a property needs a type and a name".into()),
    };
    Ok(Property { name: String::from_utf8_lossy(name).into_owned(), kind })
}
