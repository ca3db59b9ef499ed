//! Images averaged over boxes of 2^k x 2^k pixels while their rows are read, so that the full image is never in memory.

/// A channel of a texel: 8 or 16 bits.
pub trait Channel: Copy + Send + Sync + Into<f64> + Into<u32> {
    /// The value of full intensity, 1.
    const MAX: f64;

    /// The lowest bits of a mean of channels; the others are zero.
    fn of(value: u32) -> Self;
}

impl Channel for u8 {
    const MAX: f64 = 255.0;

    fn of(value: u32) -> Self {
        value as u8
    }
}

impl Channel for u16 {
    const MAX: f64 = 65_535.0;

    fn of(value: u32) -> Self {
        value as u16
    }
}

/// Takes the rows of an image from top to bottom and keeps the means of boxes; k <= 7, so that sums of 16-bit values
/// fit. Boxes at the right and the lower edge may be smaller.
pub struct Shrink<T> {
    k: u32,
    width: usize,
    texels: Vec<[T; 3]>,
    /// Sums of the row of boxes that is being filled.
    sums: Vec<[u32; 3]>,
    rows: u32,
}

impl<T: Channel> Shrink<T> {
    pub fn new(width: u32, height: u32, k: u32) -> Self {
        assert!(k <= 7);
        let boxes = width.div_ceil(1 << k) as usize;
        Shrink {
            k,
            width: width as usize,
            texels: Vec::with_capacity(boxes * height.div_ceil(1 << k) as usize),
            sums: vec![[0; 3]; if k == 0 { 0 } else { boxes }],
            rows: 0,
        }
    }

    /// The next row, `width` pixels.
    pub fn push(&mut self, mut row: impl Iterator<Item = [T; 3]>) {
        if self.k == 0 {
            self.texels.extend(row);
            return;
        }
        for sums in &mut self.sums {
            for pixel in row.by_ref().take(1 << self.k) {
                for (sum, value) in sums.iter_mut().zip(pixel) {
                    *sum += Into::<u32>::into(value);
                }
            }
        }
        self.rows += 1;
        if self.rows == 1 << self.k {
            self.finish_row();
        }
    }

    fn finish_row(&mut self) {
        for (i, sum) in self.sums.iter_mut().enumerate() {
            let columns = (1 << self.k).min(self.width - (i << self.k)) as u32;
            let n = self.rows * columns;
            self.texels.push(sum.map(|sum| T::of((sum + n / 2) / n)));
            *sum = [0; 3];
        }
        self.rows = 0;
    }

    /// The texels of the shrunk image, row by row.
    pub fn finish(mut self) -> Vec<[T; 3]> {
        if self.rows > 0 {
            self.finish_row();
        }
        self.texels
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_averaged_and_those_at_the_edge_are_narrower() {
        let mut shrink = Shrink::<u8>::new(5, 3, 1);
        for row in [[0, 2, 10, 20, 7], [4, 2, 30, 40, 8], [9, 11, 1, 2, 200]] {
            shrink.push(row.into_iter().map(|value| [value, 0, 255]));
        }
        let texels = shrink.finish();
        assert_eq!(texels.iter().map(|t| t[0]).collect::<Vec<_>>(), [2, 25, 8, 10, 2, 200]);
        assert!(texels.iter().all(|t| t[1] == 0 && t[2] == 255));
    }
}
