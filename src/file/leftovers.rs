//! What programs that were killed have left: temporary files and folders that nobody locks.
//!
//! A program locks what it writes under a temporary name. When it ends, however it ends, the system takes the lock
//! away.

use std::collections::HashSet;
use std::fs::{self, DirEntry, File};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// How temporary names begin; [`RANDOM`] letters and digits follow.
pub const PREFIX: &str = ".meshseg-";

/// The number of letters and digits behind [`PREFIX`].
pub const RANDOM: usize = 6;

/// Younger ones may not be locked yet.
const YOUNG: Duration = Duration::from_secs(60);

/// The folders that were looked at: one with many files is read once.
static SWEPT: Mutex<Option<HashSet<PathBuf>>> = Mutex::new(None);

/// Removes what killed programs have left in a folder, the first time that this program writes there. What cannot be
/// removed stays.
pub fn sweep(folder: &Path) {
    let Ok(folder) = folder.canonicalize() else { return };
    let mut swept = SWEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if !swept.get_or_insert_default().insert(folder.clone()) {
        return;
    }
    drop(swept);
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten().filter(is_left) {
        let path = entry.path();
        let _ = fs::remove_file(&path).or_else(|_| fs::remove_dir_all(&path));
    }
}

fn is_left(entry: &DirEntry) -> bool {
    let name = entry.file_name();
    let random = name.to_str().and_then(|name| name.strip_prefix(PREFIX));
    let is_ours = |random: &str| {
        random.len() == RANDOM && random.bytes().all(|byte| byte.is_ascii_alphanumeric())
    };
    let age = || entry.metadata().ok()?.modified().ok()?.elapsed().ok();
    let is_locked = || File::open(entry.path()).is_ok_and(|file| file.try_lock().is_err());
    let is_link = || entry.file_type().is_ok_and(|kind| kind.is_symlink());
    random.is_some_and(is_ours)
        && !is_link()
        && age().is_some_and(|age| age > YOUNG)
        && !is_locked()
}
