//! Reading and writing of NumPy's `.npy` files.
//!
//! Format: NEP 1, <https://numpy.org/neps/nep-0001-npy-format.html>. The header is checked against the size of the file
//! before any of its numbers is trusted.

use std::path::Path;

use ndarray::{Array2, ArrayBase, Axis, Data, Dimension, Ix1, Ix2, OwnedRepr};
use ndarray_npy::{ReadNpyExt, ReadableElement, WritableElement, WriteNpyExt};

use crate::counted::counted;
use crate::error::{Error, Result};
use crate::file;

/// A well-formed header has few brackets; this limits the recursion of the parser.
const MAX_BRACKETS: usize = 16;

/// A V x m array of numbers of any kind (floats of 16 to 64 bits, integers, bool; either endianness), in C or Fortran
/// order, every entry finite.
///
/// # Errors
/// The file cannot be read, is truncated, has another type or shape, or an entry that is not finite.
pub fn read_matrix(path: &Path) -> Result<Array2<f64>> {
    let matrix = read_rows(path)?;
    check_matrix(path, &matrix)?;
    Ok(matrix)
}

/// The same, but entries may be infinite or NaN.
///
/// # Errors
/// The file cannot be read, is truncated, or has another type or shape.
pub fn read_rows(path: &Path) -> Result<Array2<f64>> {
    numbers(path, &file::read(path)?)
}

/// The array in the content of a `.npy` file or of an entry of an `.npz` file; `path` is for error messages. Fails if
/// it is truncated, does not have the number of axes of D, or holds anything but numbers.
pub fn numbers<D: Dimension>(path: &Path, bytes: &[u8]) -> Result<ArrayBase<OwnedRepr<f64>, D>> {
    let header = Header::of(path, bytes)?;
    header.check_axes::<D>(path)?;
    header.numbers(path, bytes)
}

/// The number of axes of the array in the content of a `.npy` file. Fails if its header is malformed.
pub fn axes(path: &Path, bytes: &[u8]) -> Result<usize> {
    Ok(Header::of(path, bytes)?.shape.len())
}

/// The same for integers of any width; uint64 values beyond the range of i64 become its maximum. Also fails if the
/// entries are not integers.
pub fn integers<D: Dimension>(path: &Path, bytes: &[u8]) -> Result<ArrayBase<OwnedRepr<i64>, D>> {
    let header = Header::of(path, bytes)?;
    header.check_axes::<D>(path)?;
    header.integers(path, bytes)
}

/// The text in an array of one byte string, without trailing zeros. Fails if the array is truncated or holds anything
/// else.
pub fn byte_string(path: &Path, bytes: &[u8]) -> Result<String> {
    let header = Header::of(path, bytes)?;
    if !header.element.starts_with("|S") || !header.shape.is_empty() {
        return Err(Error::malformed(path, "is not a byte string"));
    }
    let width: usize = header.element[2..].parse().expect("its size was checked");
    let text = &bytes[bytes.len() - width..];
    Ok(String::from_utf8_lossy(text).trim_end_matches('\0').to_owned())
}

/// Data at vertices: V or V x d, numbers of any kind, where uint8 is divided by 255; NaN where unknown.
///
/// Fails if the file cannot be read or is truncated, if it has another type, no column, or not 1 or 2 axes, or if an
/// entry is infinite.
pub fn read_data(path: &Path) -> Result<Array2<f64>> {
    let bytes = file::read(path)?;
    let header = Header::of(path, &bytes)?;
    let data = match (header.shape.len(), header.element.as_str()) {
        (1, "|u1") => {
            parse::<u8, Ix1>(path, &bytes)?.insert_axis(Axis(1)).mapv(|x| f64::from(x) / 255.0)
        }
        (2, "|u1") => parse::<u8, Ix2>(path, &bytes)?.mapv(|x| f64::from(x) / 255.0),
        (1, _) => header.numbers::<Ix1>(path, &bytes)?.insert_axis(Axis(1)),
        (2, _) => header.numbers::<Ix2>(path, &bytes)?,
        (axes, _) => {
            return Err(Error::malformed(
                path,
                format!("has {}; it must have 1 or 2", counted(axes, "axis", "axes")),
            ));
        }
    };
    check_data(path, &data)?;
    Ok(data)
}

/// Fails if the data of a file have no column, or an entry is infinite.
pub fn check_data(path: &Path, data: &Array2<f64>) -> Result<()> {
    if data.ncols() == 0 {
        return Err(Error::malformed(path, "has no columns"));
    }
    match data.indexed_iter().find(|(_, x)| x.is_infinite()) {
        None => Ok(()),
        Some(((row, column), x)) => Err(Error::malformed(
            path,
            format!(
                "the entry in row {row}, column {column} is {x}; data must be finite, or NaN where unknown"
            ),
        )),
    }
}

/// One uint8 per vertex. Fails if the file cannot be read, is truncated, or has another type or shape.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    Ok(parse::<u8, Ix1>(path, &file::read(path)?)?.to_vec())
}

/// Writes one array. The file is written completely or not at all. Fails if it cannot be written.
pub fn write<A: WritableElement, D: Dimension>(
    path: &Path,
    array: &ArrayBase<impl Data<Elem = A>, D>,
) -> Result<()> {
    file::write(path, |out| array.write_npy(out).map_err(std::io::Error::other))
}

/// Fails if an entry of the array of a file is not finite.
pub fn check_matrix(path: &Path, array: &Array2<f64>) -> Result<()> {
    match array.indexed_iter().find(|(_, x)| !x.is_finite()) {
        None => Ok(()),
        Some(((row, column), x)) => Err(Error::malformed(
            path,
            format!("the entry in row {row}, column {column} is {x}; it must be a finite number"),
        )),
    }
}

/// The element type and the shape that a header declares.
struct Header {
    /// NumPy's type string, such as `<f8`.
    element: String,
    shape: Vec<usize>,
}

impl Header {
    /// Parses the header and checks that the file has the declared length.
    fn of(path: &Path, bytes: &[u8]) -> Result<Self> {
        let malformed = |message: &str| Error::malformed(path, message);
        let rest = bytes
            .strip_prefix(b"\x93NUMPY")
            .ok_or_else(|| malformed("is not a .npy file; save it with numpy.save"))?;
        let (length, start) = match rest {
            [1, _, a, b, ..] => (u64::from(u16::from_le_bytes([*a, *b])), 10),
            [2 | 3, _, a, b, c, d, ..] => (u64::from(u32::from_le_bytes([*a, *b, *c, *d])), 12),
            [1..=3, ..] => return Err(malformed("ends inside its header")),
            _ => return Err(malformed("has an unknown .npy version")),
        };
        let end = usize::try_from(length)
            .ok()
            .and_then(|length| length.checked_add(start))
            .filter(|&end| end <= bytes.len())
            .ok_or_else(|| malformed("ends inside its header"))?;
        let text = std::str::from_utf8(&bytes[start..end])
            .map_err(|_| malformed("has a header that is not text"))?;
        if text.matches(['(', '[', '{']).count() > MAX_BRACKETS {
            return Err(malformed(
                "does not hold plain numbers; convert it with numpy's astype(float)",
            ));
        }
        let element = after(text, "descr")
            .and_then(|rest| rest.trim_start().strip_prefix(['\'', '"']))
            .and_then(|rest| rest.split(['\'', '"']).next())
            .ok_or_else(|| {
                malformed("does not hold plain numbers; convert it with numpy's astype(float)")
            })?;
        let shape = after(text, "shape")
            .and_then(|rest| rest.trim_start().strip_prefix('('))
            .and_then(|rest| rest.split_once(')'))
            .and_then(|(shape, _)| {
                let axes = shape.split(',').map(str::trim).filter(|axis| !axis.is_empty());
                axes.map(|axis| axis.parse().ok()).collect::<Option<Vec<usize>>>()
            })
            .ok_or_else(|| malformed("has a header without a valid shape"))?;
        let header = Header { element: element.to_owned(), shape };
        header.check_size(path, bytes.len() - end)?;
        Ok(header)
    }

    fn check_axes<D: Dimension>(&self, path: &Path) -> Result<()> {
        match D::NDIM {
            Some(axes) if axes != self.shape.len() => {
                let message = format!(
                    "has {}; it must have {axes}",
                    counted(self.shape.len(), "axis", "axes")
                );
                Err(Error::malformed(path, message))
            }
            _ => Ok(()),
        }
    }

    fn check_size(&self, path: &Path, available: usize) -> Result<()> {
        // The digits count bytes, or characters of four bytes in Unicode strings.
        let unit = if self.element.get(1..2) == Some("U") { 4 } else { 1 };
        let digits = self.element.get(2..).and_then(|digits| digits.parse::<usize>().ok());
        let Some(width) = digits.and_then(|digits| digits.checked_mul(unit)) else {
            return Err(self.wrong_type(path));
        };
        let promised = self.shape.iter().try_fold(width, |size, &n| size.checked_mul(n));
        // An axis of length 0 makes the size 0 whatever the others are, but strides are products of these.
        let strides = self.shape.iter().try_fold(width, |size, &n| size.checked_mul(n.max(1)));
        match promised {
            Some(promised)
                if promised == available
                    && strides.is_some_and(|strides| isize::try_from(strides).is_ok()) =>
            {
                Ok(())
            }
            _ => Err(Error::malformed(
                path,
                format!(
                    "has {} of data, which does not match its shape {:?}",
                    counted(available, "byte", "bytes"),
                    self.shape
                ),
            )),
        }
    }

    fn wrong_type(&self, path: &Path) -> Error {
        Error::malformed(
            path,
            format!(
                "holds {}, not plain numbers; convert it with numpy's astype(float)",
                self.element.escape_debug()
            ),
        )
    }

    fn numbers<D: Dimension>(
        &self,
        path: &Path,
        bytes: &[u8],
    ) -> Result<ArrayBase<OwnedRepr<f64>, D>> {
        let kind = self.element.get(1..).unwrap_or_default();
        Ok(match kind {
            "f8" => parse::<f64, D>(path, bytes)?,
            "f4" => parse::<f32, D>(path, bytes)?.mapv(f64::from),
            "f2" => {
                let at = bytes.windows(3).position(|three| three == b"f2'" || three == b"f2\"");
                let mut bits = bytes.to_vec();
                bits[at.expect("the header names the type")] = b'u';
                parse::<u16, D>(path, &bits)?.mapv(|bits| half::f16::from_bits(bits).to_f64())
            }
            "i1" | "i2" | "i4" | "i8" | "u1" | "u2" | "u4" => {
                self.integers::<D>(path, bytes)?.mapv(|x| x as f64)
            }
            "u8" => parse::<u64, D>(path, bytes)?.mapv(|x| x as f64),
            "b1" => parse::<bool, D>(path, bytes)?.mapv(|x| f64::from(u8::from(x))),
            _ => return Err(self.wrong_type(path)),
        })
    }

    fn integers<D: Dimension>(
        &self,
        path: &Path,
        bytes: &[u8],
    ) -> Result<ArrayBase<OwnedRepr<i64>, D>> {
        let kind = self.element.get(1..).unwrap_or_default();
        Ok(match kind {
            "i1" => parse::<i8, D>(path, bytes)?.mapv(i64::from),
            "i2" => parse::<i16, D>(path, bytes)?.mapv(i64::from),
            "i4" => parse::<i32, D>(path, bytes)?.mapv(i64::from),
            "i8" => parse(path, bytes)?,
            "u1" => parse::<u8, D>(path, bytes)?.mapv(i64::from),
            "u2" => parse::<u16, D>(path, bytes)?.mapv(i64::from),
            "u4" => parse::<u32, D>(path, bytes)?.mapv(i64::from),
            // A value that is too large remains too large for any index.
            "u8" => parse::<u64, D>(path, bytes)?.mapv(|x| i64::try_from(x).unwrap_or(i64::MAX)),
            _ => {
                let message = format!(
                    "holds {}, not integers; convert it with numpy's astype('int32')",
                    self.element.escape_debug()
                );
                return Err(Error::malformed(path, message));
            }
        })
    }
}

/// The text after a quoted key and its colon.
fn after<'a>(header: &'a str, key: &str) -> Option<&'a str> {
    let (_, rest) = header.split_once(&format!("'{key}'"))?;
    rest.trim_start().strip_prefix(':')
}

fn parse<A: ReadableElement, D: Dimension>(
    path: &Path,
    bytes: &[u8],
) -> Result<ArrayBase<OwnedRepr<A>, D>> {
    ArrayBase::read_npy(bytes)
        .map_err(|error| Error::malformed(path, error.to_string().replace(['\n', '\r'], " ")))
}

/// Fails if the array of a file does not have one row for each vertex of a mesh, naming the file and both numbers.
pub fn check_rows(path: &Path, array: &Array2<f64>, vertices: usize) -> Result<()> {
    let rows = array.nrows();
    if rows == vertices {
        return Ok(());
    }
    let message = format!(
        "has {}, but the mesh has {}; supply one row per vertex",
        counted(rows, "row", "rows"),
        counted(vertices, "vertex", "vertices")
    );
    Err(Error::malformed(path, message))
}

#[cfg(test)]
mod tests {
    use ndarray::{Array, ShapeBuilder, array};

    use super::*;

    fn written(name: &str, bytes: &[u8]) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        (folder, path)
    }

    fn npy<A: WritableElement, D: Dimension>(array: &Array<A, D>) -> Vec<u8> {
        let mut bytes = Vec::new();
        array.write_npy(&mut bytes).unwrap();
        bytes
    }

    #[test]
    fn memory_order_and_width_do_not_change_values() {
        let c = array![[1.0, 2.0, 3.5], [4.0, -5.0, 6.0]];
        let mut fortran = Array2::<f64>::zeros((2, 3).f());
        fortran.assign(&c);
        for bytes in [npy(&c), npy(&fortran), npy(&c.mapv(|x| x as f32))] {
            let (_folder, path) = written("s.npy", &bytes);
            assert_eq!(read_matrix(&path).unwrap(), c);
        }
    }

    #[test]
    fn all_numeric_types_are_read() {
        fn read<A: WritableElement>(numbers: [A; 2]) -> [f64; 2] {
            let (_folder, path) =
                written("s.npy", &npy(&Array::from(Vec::from(numbers)).insert_axis(Axis(0))));
            let array = read_matrix(&path).unwrap();
            [array[[0, 0]], array[[0, 1]]]
        }
        assert_eq!(read([-7i8, 3]), [-7.0, 3.0]);
        assert_eq!(read([-700i16, 3]), [-700.0, 3.0]);
        assert_eq!(read([-70_000i32, 3]), [-70_000.0, 3.0]);
        assert_eq!(read([-(1i64 << 40), 3]), [-((1u64 << 40) as f64), 3.0]);
        assert_eq!(read([200u8, 3]), [200.0, 3.0]);
        assert_eq!(read([60_000u16, 3]), [60_000.0, 3.0]);
        assert_eq!(read([4_000_000_000u32, 3]), [4e9, 3.0]);
        assert_eq!(read([1u64 << 40, 3]), [(1u64 << 40) as f64, 3.0]);
        assert_eq!(read([true, false]), [1.0, 0.0]);
        assert_eq!(read([0.1f32, 3.0]), [f64::from(0.1f32), 3.0]);
        // 1.5 and -2^-14, as halves.
        let mut halves = npy(&array![[0x3e00u16, 0x8400]]);
        let at = halves.windows(2).position(|two| two == b"u2").unwrap();
        halves[at] = b'f';
        let (_folder, path) = written("s.npy", &halves);
        assert_eq!(read_matrix(&path).unwrap(), array![[1.5, -(0.5f64.powi(14))]]);
    }

    #[test]
    fn big_endian_numbers_are_read() {
        let mut bytes = npy(&array![[1.5f64, -2.0]]);
        let at = bytes.windows(3).position(|three| three == b"<f8").unwrap();
        bytes[at] = b'>';
        let start = bytes.len() - 16;
        bytes[start..].chunks_mut(8).for_each(<[u8]>::reverse);
        let (_folder, path) = written("s.npy", &bytes);
        assert_eq!(read_matrix(&path).unwrap(), array![[1.5, -2.0]]);
    }

    #[test]
    fn unknown_data_are_nan_and_infinite_ones_refused() {
        let (_folder, path) = written("c.npy", &npy(&array![1.0, f64::NAN]));
        assert!(read_data(&path).unwrap()[[1, 0]].is_nan());
        let (_folder, path) = written("c.npy", &npy(&array![1.0, f64::INFINITY]));
        assert!(read_data(&path).unwrap_err().to_string().contains("row 1, column 0"));
    }

    #[test]
    fn data_may_have_one_axis_or_bytes() {
        let (_folder, path) = written("c.npy", &npy(&array![0u8, 51, 255]));
        assert_eq!(read_data(&path).unwrap(), array![[0.0], [0.2], [1.0]]);
    }

    #[test]
    fn every_truncation_and_wrong_header_is_one_clear_line() {
        let good = npy(&array![[1.0, 2.0], [3.0, 4.0]]);
        let huge = String::from_utf8_lossy(&good).into_owned();
        assert!(huge.contains("(2, 2)"));
        let replaced = |from: &[u8], to: &[u8]| {
            let at = good.windows(from.len()).position(|window| window == from).unwrap();
            let mut bytes = good.clone();
            bytes.splice(at..at + from.len(), to.iter().copied());
            bytes
        };
        let mut bad: Vec<Vec<u8>> = (0..good.len()).map(|n| good[..n].to_vec()).collect();
        bad.push([good.as_slice(), b"x"].concat());
        bad.push(replaced(b"(2, 2)", b"(9, 9)"));
        bad.push(replaced(b"(2, 2)", b"(9999)"));
        bad.push(replaced(b"<f8", b"|O8"));
        bad.push(replaced(b"'<f8'", b"[[[[["));
        bad.push(npy(&array![1.0, 2.0]));
        bad.push(npy(&array![[1.0, f64::NAN]]));
        bad.push(npy(&array![[1.0, f64::INFINITY]]));
        bad.push(replaced(b"<f8", b"<c8"));
        bad.push(replaced(b"<f8", b"<U2"));
        bad.push(b"\x93NUMPY\x02\x00\xff\xff\xff\xff{".to_vec());
        bad.push(vec![b'('; 100_000]);
        for bytes in bad {
            let (_folder, path) = written("s.npy", &bytes);
            let message = read_matrix(&path).unwrap_err().to_string();
            assert!(!message.contains('\n') && message.contains("s.npy"), "{message}");
        }
        // Strings of five characters of four bytes: complete, but not numbers.
        let texts = [&replaced(b"<f8", b"<U5")[..], &[0; 4 * 20 - 4 * 8]].concat();
        let (_folder, path) = written("s.npy", &texts);
        let message = read_matrix(&path).unwrap_err().to_string();
        assert!(message.contains("holds <U5, not plain numbers"), "{message}");
    }
}
