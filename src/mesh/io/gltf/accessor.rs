//! Accessors: the numbers of attributes and indices.
//!
//! ```text
//! element i = buffer[view.byteOffset + accessor.byteOffset + stride i ...], 0 <= i < count, little endian
//! stride = view.byteStride, or the size of an element
//! sparse: element indices[k] = values[k]; without a view, all others are 0
//! ```
//!
//! Nothing is reserved before the bytes of all elements are known to be there. Errors are messages without the name of
//! the file.
//!
//! Reference: Khronos Group, *glTF 2.0 Specification*, section 3.6.2, "Accessors".

use std::array;
use std::cell::Cell;

use super::buffers::Buffers;
use super::component::Component;
use super::document::{Accessor, Document, Sparse};
use crate::counted::counted;
use crate::mesh::io::text::quote;

/// The most elements that are read from a file with fewer bytes.
const MOST_ELEMENTS: usize = 50_000_000;

/// Reads accessors.
pub struct Reader<'a> {
    pub document: &'a Document,
    buffers: &'a Buffers<'a>,
    /// How many elements were read.
    read: Cell<usize>,
}

impl<'a> Reader<'a> {
    pub fn new(document: &'a Document, buffers: &'a Buffers<'a>) -> Self {
        Reader { document, buffers, read: Cell::new(0) }
    }

    /// Limits what is read: nodes may repeat meshes, so that a small file can have many vertices.
    pub fn count(&self, elements: usize) -> Result<(), String> {
        let read = self.read.get().saturating_add(elements);
        self.read.set(read);
        match read > MOST_ELEMENTS.max(self.buffers.size()) {
            true => Err(format!(
                "its nodes repeat meshes to more than {MOST_ELEMENTS} elements; save fewer copies"
            )),
            false => Ok(()),
        }
    }

    /// The first N numbers of each element, which must have one of the given types. Integers are over their largest
    /// value if the accessor or `normalized` says so.
    pub fn rows<const N: usize>(
        &self,
        index: usize,
        types: &[&str],
        normalized: bool,
    ) -> Result<Vec<[f64; N]>, String> {
        self.of_accessor(index, |accessor| {
            let component = Component::of(accessor.component_type)?;
            if component == Component::U32 {
                return Err("integers of 32 bits are not possible here".into());
            }
            let normalized = normalized || accessor.normalized;
            let width = width(accessor, types)?;
            let row = |element: &[u8]| {
                array::from_fn(|c| component.number(&element[c * component.size()..], normalized))
            };
            self.elements(accessor, width * component.size(), [0.0; N], row)
        })
    }

    /// The indices of vertices.
    pub fn indices(&self, index: usize) -> Result<Vec<u32>, String> {
        self.of_accessor(index, |accessor| {
            width(accessor, &["SCALAR"])?;
            let component = Component::of(accessor.component_type)?;
            if !component.is_index() {
                return Err("indices must be unsigned integers".into());
            }
            self.elements(accessor, component.size(), 0, |element| component.index(element))
        })
    }

    fn of_accessor<T>(
        &self,
        index: usize,
        read: impl FnOnce(&Accessor) -> Result<T, String>,
    ) -> Result<T, String> {
        let accessor = self.document.accessors.get(index).ok_or_else(|| "does not exist".into());
        accessor.and_then(read).map_err(|message| format!("accessor {index}: {message}"))
    }

    /// All elements of `size` bytes.
    fn elements<T: Copy>(
        &self,
        accessor: &Accessor,
        size: usize,
        zero: T,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, String> {
        let count = accessor.count;
        let mut values = match accessor.buffer_view {
            Some(view) => {
                let stride = self.document.buffer_views.get(view).and_then(|view| view.byte_stride);
                // Some programs write 0 instead of nothing.
                let stride = stride.filter(|&stride| stride > 0).unwrap_or(size);
                let bytes = self.range(view, accessor.byte_offset, [size, stride], count)?;
                self.count(count)?;
                bytes.chunks(stride).map(|element| decode(&element[..size])).collect()
            }
            // They take no bytes, so something else must limit their number.
            None if count > self.buffers.size() => {
                return Err(format!("has {count} elements without a bufferView"));
            }
            None => {
                self.count(count)?;
                vec![zero; count]
            }
        };
        if let Some(sparse) = &accessor.sparse {
            self.replace(sparse, &mut values, size, decode)?;
        }
        Ok(values)
    }

    /// Replaces some elements.
    fn replace<T>(
        &self,
        Sparse { count, indices, values }: &Sparse,
        elements: &mut [T],
        size: usize,
        decode: impl Fn(&[u8]) -> T,
    ) -> Result<(), String> {
        let component = Component::of(indices.component_type.unwrap_or_default())?;
        if !component.is_index() {
            return Err("sparse indices must be unsigned integers".into());
        }
        let tight = |size| [size, size];
        let (at, length) = (indices.byte_offset, component.size());
        let indices = self.range(indices.buffer_view, at, tight(length), *count)?;
        let values = self.range(values.buffer_view, values.byte_offset, tight(size), *count)?;
        self.count(*count)?;
        let of = elements.len();
        for (index, value) in indices.chunks(length).zip(values.chunks(size)) {
            let index = component.index(index);
            let element = usize::try_from(index).ok().and_then(|index| elements.get_mut(index));
            *element.ok_or_else(|| {
                format!(
                    "a sparse index is {index}, but there are {}",
                    counted(of, "element", "elements")
                )
            })? = decode(value);
        }
        Ok(())
    }

    /// The bytes from the first to the last element, of which each has `size` bytes and begins `stride` after the one
    /// before.
    fn range(
        &self,
        view: usize,
        offset: usize,
        [size, stride]: [usize; 2],
        count: usize,
    ) -> Result<&'a [u8], String> {
        let bytes = self.view(view)?;
        if count == 0 {
            return Ok(&[]);
        }
        if stride < size {
            return Err(format!("elements of {size} bytes overlap at a byteStride of {stride}"));
        }
        let length = stride.checked_mul(count - 1).and_then(|length| length.checked_add(size));
        let end = length.and_then(|length| offset.checked_add(length));
        end.and_then(|end| bytes.get(offset..end)).ok_or_else(|| {
            format!(
                "{} of {size} bytes do not fit into bufferView {view} of {} bytes",
                counted(count, "element", "elements"),
                bytes.len()
            )
        })
    }

    /// The bytes of a bufferView.
    pub fn view(&self, index: usize) -> Result<&'a [u8], String> {
        let views = &self.document.buffer_views;
        let view = views.get(index).ok_or_else(|| format!("bufferView {index} does not exist"))?;
        let buffer = self.buffers.get(view.buffer);
        let buffer = buffer.ok_or_else(|| format!("buffer {} does not exist", view.buffer))?;
        let end = view.byte_offset.checked_add(view.byte_length);
        end.and_then(|end| buffer.get(view.byte_offset..end)).ok_or_else(|| {
            format!(
                "bufferView {index} reaches beyond the {} of buffer {}",
                counted(buffer.len(), "byte", "bytes"),
                view.buffer
            )
        })
    }
}

/// The number of components of an element, which must have one of the given types.
fn width(accessor: &Accessor, types: &[&str]) -> Result<usize, String> {
    let kind = accessor.kind.as_str();
    let width = match kind {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        _ => 0,
    };
    if types.contains(&kind) {
        return Ok(width);
    }
    Err(format!("expected the type {}, not {}", types.join(" or "), quote(kind.as_bytes())))
}
