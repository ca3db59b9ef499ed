//! An image and its successive halvings. A face is sampled at the level whose texels are about as far apart as its
//! samples.

use std::io::{Cursor, Read};
use std::path::Path;

use super::decode::{self, Decoded, Texels, Turn};
use super::sample::{Footprint, MipLevel, Texel};
use super::shrink::{Channel, Shrink};
use crate::error::{Error, Result};
use crate::file;

/// The size limit of JPEG files, which are read as a whole.
const MAX_FILE_BYTES: u64 = 1 << 28;

/// An image and its successive halvings: level l has means of 2^l x 2^l texels.
pub struct Texture {
    /// Pixels along the width of the image in the file.
    pub width: u32,
    /// Pixels along its height.
    pub height: u32,
    /// The texels of level 0 are means of 2^k x 2^k pixels.
    k: u32,
    levels: Levels,
    /// Whether its edges extend beyond [0, 1], instead of repeated copies.
    pub clamp: bool,
}

enum Levels {
    Eight(Vec<MipLevel<u8>>),
    Sixteen(Vec<MipLevel<u16>>),
}

/// Reads a PNG or JPEG file; its content decides which, not its name. Fails if the file cannot be read, is neither, is
/// damaged or is too large.
pub fn decode_file(path: &Path, turn: Turn) -> Result<Decoded> {
    let (mut file, length) = file::open(path)?;
    let mut magic = Vec::new();
    let io = |source| Error::io(path, source);
    (&mut file).take(PNG_SIGNATURE.len() as u64).read_to_end(&mut magic).map_err(io)?;
    if magic == PNG_SIGNATURE {
        return decode::png(Cursor::new(magic).chain(file), length, path);
    }
    if !magic.starts_with(JPEG_SIGNATURE) {
        return Err(Error::malformed(path, UNKNOWN_FORMAT));
    }
    if length > MAX_FILE_BYTES {
        return Err(Error::malformed(path, "is larger than 256 MiB; save it as PNG, or shrink it"));
    }
    file.read_to_end(&mut magic).map_err(io)?;
    decode::jpeg(&magic, path, turn)
}

impl Texture {
    /// Reads a PNG or JPEG file.
    pub fn open(path: &Path, turn: Turn) -> Result<Self> {
        Texture::new(decode_file(path, turn)?, path)
    }

    /// Decodes the content of a PNG or JPEG file; `name` is for error messages. Fails if it is neither, damaged or too
    /// large.
    pub fn decode(bytes: &[u8], name: &Path) -> Result<Self> {
        let decoded = if bytes.starts_with(PNG_SIGNATURE) {
            decode::png(bytes, bytes.len() as u64, name)
        } else if bytes.starts_with(JPEG_SIGNATURE) {
            decode::jpeg(bytes, name, Turn::AsStored)
        } else {
            Err(Error::malformed(name, UNKNOWN_FORMAT))
        };
        Texture::new(decoded?, name)
    }

    fn new(Decoded { width, height, k, texels }: Decoded, name: &Path) -> Result<Self> {
        if k > 0 {
            tracing::warn!(
                "{}: the image of {width} x {height} pixels was shrunk by a factor of {} in each direction",
                name.display(),
                1 << k
            );
        }
        let levels = match texels {
            Texels::Eight(texels) => Levels::Eight(vec![level(width, height, k, texels)]),
            Texels::Sixteen(texels) => Levels::Sixteen(vec![level(width, height, k, texels)]),
        };
        Ok(Texture { width, height, k, levels, clamp: false })
    }

    /// k, for texels of level 0 that are means of 2^k x 2^k pixels.
    #[cfg(test)]
    pub fn shrunk(&self) -> u32 {
        self.k
    }

    /// The length of [0, 1] in texels of level 0, along both axes.
    pub fn extent(&self) -> [f64; 2] {
        [self.width, self.height].map(|n| f64::from(n) / f64::from(1_u32 << self.k))
    }

    /// Computes the levels up to the given one, as long as they have more than one texel.
    pub fn reach(&mut self, last: usize) {
        let (width, height, k) = (self.width, self.height, self.k);
        match &mut self.levels {
            Levels::Eight(levels) => halve(levels, last, width, height, k),
            Levels::Sixteen(levels) => halve(levels, last, width, height, k),
        }
    }

    /// The colors in [0, 1] of the corners of a face, whose level must have been computed by [`Texture::reach`].
    #[inline(always)]
    pub fn of_corners(&self, footprint: &Footprint, texel: Texel) -> [[f64; 3]; 3] {
        match &self.levels {
            Levels::Eight(levels) => of_corners(levels, footprint, texel),
            Levels::Sixteen(levels) => of_corners(levels, footprint, texel),
        }
    }
}

const PNG_SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";
const JPEG_SIGNATURE: &[u8] = b"\xff\xd8\xff";
const UNKNOWN_FORMAT: &str = "is neither a PNG nor a JPEG image; convert it to one";

fn level<T>(width: u32, height: u32, k: u32, texels: Vec<[T; 3]>) -> MipLevel<T> {
    let extent = [width, height].map(|n| f64::from(n) / (1_u64 << k) as f64);
    let [width, height] = [width, height].map(|n| u64::from(n).div_ceil(1 << k) as usize);
    MipLevel { width, height, texels, extent }
}

fn halve<T: Channel>(levels: &mut Vec<MipLevel<T>>, last: usize, width: u32, height: u32, k: u32) {
    while levels.len() <= last {
        let fine = &levels[levels.len() - 1];
        if fine.width.max(fine.height) == 1 {
            return;
        }
        let mut shrink = Shrink::new(fine.width as u32, fine.height as u32, 1);
        for row in fine.texels.chunks(fine.width) {
            shrink.push(row.iter().copied());
        }
        let texels = shrink.finish();
        levels.push(level(width, height, k + levels.len() as u32, texels));
    }
}

#[inline(always)]
fn of_corners<T: Channel>(
    levels: &[MipLevel<T>],
    footprint: &Footprint,
    texel: Texel,
) -> [[f64; 3]; 3] {
    let colors = match texel {
        Texel::Mean => {
            let level = &levels[footprint.level.min(levels.len() - 1)];
            [0, 1, 2].map(|i| footprint.mean(level, i))
        }
        Texel::Vertex => [0, 1, 2].map(|i| footprint.corner(&levels[0], i)),
    };
    colors.map(|color| color.map(|value| value / T::MAX))
}
