//! File names as written inside files.

use std::path::{Component, Path, PathBuf};

/// `path` as written in a file in `folder`: relative if both are on one drive, with slashes.
pub fn relative(path: &Path, folder: &Path) -> String {
    let path = match (path.parent(), path.file_name()) {
        (Some(above), Some(name)) => absolute(above).join(name),
        _ => absolute(path),
    };
    let folder = absolute(folder);
    let common = path.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    let separated = |path: &Path| path.to_string_lossy().replace(std::path::MAIN_SEPARATOR, "/");
    if common == 0 {
        return separated(&path);
    }
    let up = folder.components().skip(common).map(|_| Component::ParentDir);
    separated(&up.chain(path.components().skip(common)).collect::<PathBuf>())
}

/// The absolute path of a folder, with links resolved if it exists: after a link, `..` is another folder.
fn absolute(folder: &Path) -> PathBuf {
    let here = if folder == Path::new("") { Path::new(".") } else { folder };
    let path = std::path::absolute(here).unwrap_or_else(|_| folder.to_owned());
    let existing = path.ancestors().find_map(|above| Some((above, above.canonicalize().ok()?)));
    match existing {
        Some((above, canonical)) => {
            let rest = path.strip_prefix(above).unwrap_or(Path::new(""));
            if rest.as_os_str().is_empty() { canonical } else { canonical.join(rest) }
        }
        None => path,
    }
}
