//! Reading of NumPy's `.npz` archives: `.npy` arrays with names, each read completely before its header is parsed.

use std::io::{Cursor, Read};
use std::path::{Path, PathBuf};

use zip::ZipArchive;

use crate::error::{Error, Result};
use crate::file;

/// An entry may have at most this many bytes, or this many times those of the archive: deflate can shrink zeros by a
/// factor of 1000.
const MAX_ENTRY_BYTES: u64 = 1 << 26;
const MAX_INFLATION: u64 = 64;

/// An `.npz` file, whose entries are read completely before their headers are parsed.
pub struct Archive {
    path: PathBuf,
    zip: ZipArchive<Cursor<Vec<u8>>>,
    /// Its size in bytes.
    length: u64,
}

impl Archive {
    /// Opens a file.
    ///
    /// # Errors
    /// The file cannot be read, or is no archive.
    pub fn open(path: &Path) -> Result<Self> {
        let bytes = file::read(path)?;
        let length = bytes.len() as u64;
        let zip = ZipArchive::new(Cursor::new(bytes))
            .map_err(|error| Error::malformed(path, format!("is not an .npz file: {error}")))?;
        Ok(Archive { path: path.to_owned(), zip, length })
    }

    /// Whether there is an array of this name.
    pub fn has(&self, name: &str) -> bool {
        self.zip.index_for_name(&format!("{name}.npy")).is_some()
    }

    /// The names of the arrays, sorted.
    pub fn names(&self) -> Vec<String> {
        let names = self.zip.file_names().filter_map(|name| name.strip_suffix(".npy"));
        let mut names: Vec<String> = names.map(str::to_owned).collect();
        names.sort();
        names
    }

    /// The array of a name.
    ///
    /// # Errors
    /// There is none, it claims to be larger than the archive can hold, or `parse` fails.
    pub fn entry<T>(&mut self, name: &str, parse: impl Fn(&Path, &[u8]) -> Result<T>) -> Result<T> {
        let Archive { path, zip, length: archive_length } = self;
        let place = PathBuf::from(format!("{}: {name}", path.display()));
        let malformed = |message: String| Error::malformed(&place, message);
        let mut entry = zip
            .by_name(&format!("{name}.npy"))
            .map_err(|error| malformed(format!("cannot be read: {error}")))?;
        let most = MAX_ENTRY_BYTES.max(archive_length.saturating_mul(MAX_INFLATION));
        let size = entry.size();
        if size > most {
            return Err(malformed(format!("claims {size} bytes, more than it can hold")));
        }
        let mut bytes = Vec::new();
        (&mut entry).take(size).read_to_end(&mut bytes).map_err(|e| malformed(e.to_string()))?;
        parse(&place, &bytes)
    }
}
