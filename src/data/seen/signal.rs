//! Whether there is anything in data but rounding.

use super::super::Data;

/// Differences below this share of the data are rounding.
const ROUNDING: f64 = 1e-13;

/// Whether one of the coordinates has more than one value where it is known.
pub fn varies(data: &Data) -> bool {
    (0..data.dimension).any(|i| {
        let column = data.values.iter().skip(i).step_by(data.dimension).filter(|x| !x.is_nan());
        let extremes = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = column.fold(extremes, |(low, high), &x| (low.min(x), high.max(x)));
        high - low > ROUNDING * low.abs().max(high.abs())
    })
}

/// Makes data constant that are so up to rounding, in each coordinate and where they are known.
pub fn flatten(data: &mut Data) -> bool {
    let known = |row: &&[f64]| row.iter().all(|x| !x.is_nan());
    let Some(first) = data.values.chunks(data.dimension).find(known).map(<[f64]>::to_vec) else {
        return false;
    };
    if varies(data) {
        return false;
    }
    for row in data.values.chunks_mut(data.dimension).filter(|row| known(&&**row)) {
        row.copy_from_slice(&first);
    }
    true
}
