//! Files are read whole (images row by row), and appear whole or not at all: they are written under a temporary name
//! next to their destination, then renamed. A program that is interrupted calls [`abandon`], so that no partial file
//! stays; what a killed one leaves is removed by the next one that writes to the folder (`file/leftovers.rs`).

mod leftovers;

use std::borrow::Cow;
use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::error::{Error, Result};

/// The content of a regular file. Fails if it cannot be read, is empty, or is not a regular file: a device or a pipe
/// may never end.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    check_regular(path)?;
    let bytes = fs::read(path).map_err(|source| Error::io(path, source))?;
    if bytes.is_empty() {
        return Err(Error::malformed(path, "is empty"));
    }
    Ok(bytes)
}

/// Opens a file that is not read whole, and returns its length in bytes. Fails like [`read`].
pub fn open(path: &Path) -> Result<(BufReader<File>, u64)> {
    match check_regular(path)? {
        0 => Err(Error::malformed(path, "is empty")),
        length => {
            let file = File::open(path).map_err(|source| Error::io(path, source))?;
            Ok((BufReader::with_capacity(1 << 16, file), length))
        }
    }
}

/// The length of a regular file.
fn check_regular(path: &Path) -> Result<u64> {
    let metadata = fs::metadata(path).map_err(|source| Error::io(path, source))?;
    if metadata.is_dir() {
        return Err(Error::malformed(path, "is a folder; name a file"));
    }
    if !metadata.is_file() {
        return Err(Error::malformed(path, "is not a regular file; copy its content to one"));
    }
    Ok(metadata.len())
}

/// The temporary paths of files and folders being written, the oldest first.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Registers a temporary path for as long as it lives.
struct Unfinished(PathBuf);

impl Unfinished {
    /// Creates and registers a file or folder under one lock, so that [`abandon`] knows of everything that exists.
    fn make<T>(
        make: impl FnOnce() -> io::Result<T>,
        path: fn(&T) -> &Path,
    ) -> io::Result<(T, Self)> {
        let mut all = unfinished();
        let made = make()?;
        let path = path(&made).to_owned();
        all.push(path.clone());
        Ok((made, Unfinished(path)))
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        unfinished().retain(|path| *path != self.0);
    }
}

/// Removes all partial files and folders. The program must exit afterwards, since other writers block forever.
pub fn abandon() {
    let all = unfinished();
    for path in all.iter().rev() {
        // Meanwhile another thread may put one more file into a folder, but it cannot begin a second one.
        let gone = || fs::remove_file(path).is_ok() || fs::remove_dir_all(path).is_ok();
        let _ = gone() || gone();
    }
    std::mem::forget(all);
}

/// Writes one file. An existing file at `path` stays until the new content is complete; of a link, the file that it
/// leads to. Fails if `content` fails, or if the file cannot be written, flushed or renamed.
pub fn write(path: &Path, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<()> {
    let write = || {
        let path = &*followed(path)?;
        let folder = match path.parent() {
            Some(parent) if parent != Path::new("") => parent,
            _ => Path::new("."),
        };
        fs::metadata(folder.join("."))?;
        // The original message would name the temporary file.
        let mut builder = tempfile::Builder::new();
        builder.prefix(leftovers::PREFIX).rand_bytes(leftovers::RANDOM).permissions(permissions());
        leftovers::sweep(folder);
        let make = || builder.tempfile_in(folder).map_err(|error| io::Error::from(error.kind()));
        let (mut file, _unfinished) = Unfinished::make(make, |file| file.path())?;
        // Without locks on this system, leftovers stay.
        let _ = file.as_file().lock();
        let mut writer = BufWriter::new(&mut file);
        content(&mut writer)?;
        writer.flush()?;
        drop(writer);
        file.persist(path)?;
        Ok(())
    };
    write().map_err(|source| Error::io(path, source))
}

/// What a path leads to, by way of links; a link may lead to a file that does not exist yet.
fn followed(path: &Path) -> io::Result<Cow<'_, Path>> {
    /// As many as Linux follows.
    const MAX_LINKS: usize = 40;
    let mut path = Cow::Borrowed(path);
    for _ in 0..MAX_LINKS {
        if !path.is_symlink() {
            return Ok(path);
        }
        let target = fs::read_link(&path)?;
        // A path from the root replaces what it is joined to.
        path = Cow::Owned(path.parent().unwrap_or(Path::new("")).join(target));
    }
    Err(io::Error::other("too many links"))
}

/// The permissions of an ordinary new file, before the umask applies.
#[cfg(unix)]
fn permissions() -> fs::Permissions {
    use std::os::unix::fs::PermissionsExt;
    fs::Permissions::from_mode(0o666)
}

/// Checks, before long work starts, that a folder can be written at `path`: it exists or can be created. Fails if
/// `path` is a file or a dangling link, if a folder above it is a file, or if no file can be created there.
pub fn check_folder(path: &Path) -> Result<()> {
    match fs::metadata(path) {
        Ok(metadata) if metadata.is_dir() => check_writable(path, path),
        Ok(_) => Err(Error::unsuitable(format!(
            "{}: is a file; name a folder with --out",
            path.display()
        ))),
        Err(_) if path.is_symlink() => Err(Error::unsuitable(format!(
            "{}: is a dangling link; name a folder with --out",
            path.display()
        ))),
        Err(_) => {
            let made = path
                .ancestors()
                .skip(1)
                .find(|ancestor| ancestor.exists() || *ancestor == Path::new(""));
            match made {
                Some(parent) if parent == Path::new("") => check_writable(path, Path::new(".")),
                Some(parent) if parent.is_dir() => check_writable(path, parent),
                _ => Err(Error::unsuitable(format!(
                    "{}: cannot be created: a folder above it is a file; name another folder with --out",
                    path.display()
                ))),
            }
        }
    }
}

/// Checks, before long work starts, that a file can be written at `path`. Fails if it is a folder, or if the folder above
/// it does not exist or cannot be written.
pub fn check_file(path: &Path) -> Result<()> {
    if path.is_dir() {
        return Err(Error::malformed(path, "is a folder; name a file"));
    }
    match path.parent() {
        Some(parent) if parent != Path::new("") => {
            if !parent.is_dir() {
                return Err(Error::malformed(
                    path,
                    "cannot be written: its folder does not exist; create it first",
                ));
            }
            check_writable(path, parent)
        }
        _ => check_writable(path, Path::new(".")),
    }
}

/// Creates an anonymous file in an existing folder; it is removed at once.
fn check_writable(path: &Path, existing: &Path) -> Result<()> {
    tempfile::tempfile_in(existing).map(drop).map_err(|error| {
        Error::unsuitable(format!(
            "{}: cannot be written: {}",
            path.display(),
            io::Error::from(error.kind())
        ))
    })
}

/// Writes a folder of files: `fill` puts them into an empty temporary folder, which is then renamed to
/// `path`. If `path` already exists, its other files stay and each new file replaces the one of the same name.
///
/// The temporary folder is created inside an existing `path`: the folder above may be on another file system or not
/// writable.
///
/// Of several programs that write to `path`, one after the other replaces files, so that those of the last one are
/// together.
///
/// Fails if `fill` fails, if the folder cannot be created, read or renamed, or if a subfolder of `path` has the name of
/// a new file; in that case no file of `path` was replaced.
pub fn write_folder(path: &Path, fill: impl FnOnce(&Path) -> Result<()>) -> Result<()> {
    write_folder_over(path, fill, || Ok(()))
}

/// The same; `clear` removes from an existing folder what must not stay, before the new files come.
pub fn write_folder_over(
    path: &Path,
    fill: impl FnOnce(&Path) -> Result<()>,
    clear: impl FnOnce() -> Result<()>,
) -> Result<()> {
    let io = |source| Error::io(path, source);
    let exists = path.is_dir();
    let parent = match path.parent() {
        _ if exists => path,
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    fs::create_dir_all(parent).map_err(io)?;
    let mut builder = tempfile::Builder::new();
    builder.prefix(leftovers::PREFIX).rand_bytes(leftovers::RANDOM);
    leftovers::sweep(parent);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o777));
    }
    let make = || builder.tempdir_in(parent);
    let (folder, _unfinished) = Unfinished::make(make, |folder| folder.path()).map_err(io)?;
    let _in_use = locked(folder.path());
    fill(folder.path())?;
    // Another program may have made it meanwhile.
    let renamed = if exists { Ok(false) } else { renamed(folder.path(), path) };
    if !renamed.map_err(io)? {
        let _lock = locked(path);
        let names = || -> io::Result<Vec<_>> {
            fs::read_dir(folder.path())?.map(|entry| Ok(entry?.file_name())).collect()
        };
        let names = names().map_err(io)?;
        // Checked before the first file is replaced: all or none.
        if let Some(name) = names.iter().find(|name| path.join(name).is_dir()) {
            return Err(Error::malformed(
                &path.join(name),
                "is a folder, but a file of this name must be written; move it away",
            ));
        }
        clear()?;
        for name in names {
            fs::rename(folder.path().join(&name), path.join(&name)).map_err(io)?;
        }
    } else {
        // There is nothing to remove.
        let _ = folder.keep();
    }
    Ok(())
}

/// Renames a folder, unless there is one of that name.
fn renamed(folder: &Path, path: &Path) -> io::Result<bool> {
    match fs::rename(folder, path) {
        Ok(()) => Ok(true),
        Err(_) if path.is_dir() => Ok(false),
        Err(error) => Err(error),
    }
}

/// Waits until no other program has locked a folder, and keeps others waiting while the result lives; `None` where the
/// system has no such locks.
fn locked(path: &Path) -> Option<File> {
    let folder = File::open(path).ok()?;
    folder.lock().ok().map(|()| folder)
}
