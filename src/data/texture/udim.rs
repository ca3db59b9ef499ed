//! Images in tiles, by the UDIM numbers in their names: tile (i, j) of the plane of texture coordinates is the image
//! 1001 + i + 10 j, 0 <= i <= 9.

use std::path::{Path, PathBuf};

use super::sample::tile;

/// The UDIM number of a tile.
pub fn number_of([i, j]: [f64; 2]) -> Option<u32> {
    ((0.0..10.0).contains(&i) && (0.0..900.0).contains(&j)).then(|| 1001 + i as u32 + 10 * j as u32)
}

/// An image in tiles: the parts of its name before and after the number.
pub struct Tiled {
    pub folder: PathBuf,
    pub before: String,
    /// `None` if the name has `<UDIM>` instead.
    pub number: Option<u32>,
    pub behind: String,
}

impl Tiled {
    /// Parses a name: it contains `<UDIM>` in any case, or a four-digit number from 1001 to 1999 between `.`, `_`, `-`
    /// or the ends, of which the last counts.
    pub fn of(image: &Path) -> Option<Self> {
        const MARK: &str = "<UDIM>";
        let name = image.file_name()?.to_str()?;
        let parts = |at: usize, length: usize, number| Tiled {
            folder: image.parent().unwrap_or(Path::new("")).to_owned(),
            before: name[..at].into(),
            number,
            behind: name[at + length..].into(),
        };
        if let Some(at) = name.to_ascii_uppercase().find(MARK) {
            return Some(parts(at, MARK.len(), None));
        }
        let between = |byte: Option<&u8>| byte.is_none_or(|byte| b"._-".contains(byte));
        let bytes = name.as_bytes();
        (0..bytes.len().saturating_sub(3)).rev().find_map(|at| {
            let digits = &bytes[at..at + 4];
            let number = std::str::from_utf8(digits).ok()?.parse().ok()?;
            let is_number = digits.iter().all(u8::is_ascii_digit) && (1001..2000).contains(&number);
            let stands_alone =
                between(at.checked_sub(1).map(|i| &bytes[i])) && between(bytes.get(at + 4));
            (is_number && stands_alone).then(|| parts(at, 4, Some(number)))
        })
    }

    /// The tiles of an image, if it has any, for the texture coordinates of its faces: its name contains `<UDIM>`, or
    /// coordinates leave [0, 1] and the number is the first one or another tile exists. (The number of
    /// `brick_1024.png` may be its size, and the image repeated.) A clamped image is repeated nowhere.
    pub fn in_use<'a>(
        image: &Path,
        clamp: bool,
        uv: impl Iterator<Item = &'a [[f64; 2]; 3]>,
    ) -> Option<Self> {
        let tiled = Tiled::of(image)?;
        let Some(number) = tiled.number else { return Some(tiled) };
        if clamp {
            return None;
        }
        let mut numbers: Vec<_> = uv.map(|uv| number_of(tile(uv))).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let leaves = numbers.iter().any(|&other| other != Some(1001));
        let other =
            || numbers.iter().flatten().any(|&other| other != number && tiled.path(other).exists());
        (leaves && (number == 1001 || other())).then_some(tiled)
    }

    /// The image of a tile.
    pub fn path(&self, number: u32) -> PathBuf {
        self.folder.join(format!("{}{number}{}", self.before, self.behind))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_tiles_stand_alone() {
        let parts = |name: &str| {
            Tiled::of(Path::new(name)).map(|tiled| (tiled.before, tiled.number, tiled.behind))
        };
        for (name, before, number, behind) in [
            ("a/skin.1001.png", "skin.", Some(1001), ".png"),
            ("skin_1012.jpg", "skin_", Some(1012), ".jpg"),
            ("1001.png", "", Some(1001), ".png"),
            ("skin.1001_4k-2048.png", "skin.", Some(1001), "_4k-2048.png"),
            ("skin.<udim>.png", "skin.", None, ".png"),
        ] {
            assert_eq!(parts(name), Some((before.into(), number, behind.into())), "{name}");
        }
        for name in ["skin.png", "skin1001.png", "skin_0999.png", "skin.10010.png", "é100.png"] {
            assert!(parts(name).is_none(), "{name}");
        }
    }

    #[test]
    fn tiles_count_from_1001_in_rows_of_ten() {
        assert_eq!(number_of([0.0, 0.0]), Some(1001));
        assert_eq!(number_of([9.0, 2.0]), Some(1030));
        assert_eq!(number_of([10.0, 0.0]), None);
        assert_eq!(number_of([-1.0, 0.0]), None);
    }
}
