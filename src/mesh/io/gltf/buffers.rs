//! The buffers of a glTF file: its binary chunk, data URIs, and other files.
//!
//! ```text
//! {byteLength}                    the binary chunk, of which up to 3 more bytes are padding; only the first buffer
//! {byteLength, uri}               a data URI or a file
//! ```
//!
//! All must have their declared length. A file that several buffers name is read once.
//!
//! Reference: Khronos Group, *glTF 2.0 Specification*, section 3.6.1, "Buffers and Buffer Views".

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::Path;

use super::document::{Buffer, Document};
use super::uri::{self, Target};
use crate::counted::counted;
use crate::error::{Error, Result};
use crate::file;
use crate::mesh::io::text::quote;

pub struct Buffers<'a> {
    contents: Vec<Cow<'a, [u8]>>,
    /// For each buffer its content and its length.
    all: Vec<(usize, usize)>,
}

impl<'a> Buffers<'a> {
    /// `folder` contains the files.
    pub fn load(
        path: &Path,
        folder: Option<&Path>,
        document: &'a Document,
        binary: Option<&'a [u8]>,
    ) -> Result<Self> {
        let mut buffers = Buffers { contents: Vec::new(), all: Vec::new() };
        let mut loaded = HashMap::new();
        for (i, buffer) in document.buffers.iter().enumerate() {
            let key = buffer.uri.as_deref();
            let content = match loaded.get(&key) {
                Some(&content) => content,
                None => {
                    let chunk = binary.filter(|_| i == 0);
                    buffers.contents.push(content(path, folder, i, buffer, chunk)?);
                    let content = buffers.contents.len() - 1;
                    key.is_some().then(|| loaded.insert(key, content));
                    content
                }
            };
            let (has, declared) = (buffers.contents[content].len(), buffer.byte_length);
            if has < declared {
                let message = format!(
                    "buffer {i} declares {} but has {has}; it is truncated",
                    counted(declared, "byte", "bytes")
                );
                return Err(Error::malformed(path, message));
            }
            buffers.all.push((content, declared));
        }
        Ok(buffers)
    }

    pub fn get(&self, index: usize) -> Option<&[u8]> {
        let &(content, length) = self.all.get(index)?;
        self.contents[content].get(..length)
    }

    /// The number of bytes of all.
    pub fn size(&self) -> usize {
        self.contents.iter().map(|content| content.len()).sum()
    }
}

fn content<'a>(
    path: &Path,
    folder: Option<&Path>,
    i: usize,
    buffer: &Buffer,
    chunk: Option<&'a [u8]>,
) -> Result<Cow<'a, [u8]>> {
    let refused = |message: String| Err(Error::malformed(path, format!("buffer {i} {message}")));
    let Some(uri) = &buffer.uri else {
        return match chunk {
            Some(chunk) => Ok(Cow::Borrowed(chunk)),
            None if buffer.byte_length == 0 => Ok(Cow::Borrowed(&[])),
            None => refused("has neither a URI nor a binary chunk".into()),
        };
    };
    match (Target::of(uri), folder) {
        (Target::Inside(data), _) => match uri::bytes(data) {
            Some(bytes) => Ok(Cow::Owned(bytes)),
            None => refused("has a data URI that is not valid".into()),
        },
        (Target::File(name), Some(folder)) => Ok(Cow::Owned(file::read(&folder.join(name))?)),
        (Target::File(name), None) => {
            let name = quote(name.as_bytes());
            refused(format!(
                "is the file {name}, and no other files are read here; save it as .glb"
            ))
        }
        (Target::Elsewhere, _) => {
            refused(format!("is at {}; download it next to the file", quote(uri.as_bytes())))
        }
    }
}
