//! Whether data vary by more than rounding.

use crate::data::Data;

/// Differences below this fraction of the data are rounding errors.
const DATA_ROUNDING: f64 = 1e-13;

/// Whether the known values of some coordinate differ by more than rounding.
pub fn varies(data: &Data) -> bool {
    differs(data, DATA_ROUNDING)
}

/// Whether the values of some coordinate differ by more than a fraction of their size.
fn differs(data: &Data, share: f64) -> bool {
    (0..data.dimension).any(|i| {
        let column = data.values.iter().skip(i).step_by(data.dimension).filter(|x| !x.is_nan());
        let extremes = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = column.fold(extremes, |(low, high), &x| (low.min(x), high.max(x)));
        high - low > share * low.abs().max(high.abs())
    })
}

/// If the known data are constant up to rounding in each coordinate, makes them constant and returns a clause that says
/// so; `what` names the values, in the plural.
pub fn flatten(data: &mut Data, what: &str) -> Option<String> {
    let known = |row: &&[f64]| row.iter().all(|x| !x.is_nan());
    let first = data.values.chunks(data.dimension).find(known).map(<[f64]>::to_vec)?;
    if varies(data) {
        return None;
    }
    let found = match differs(data, 0.0) {
        true => {
            format!(
                "the {what} differ by at most {DATA_ROUNDING:.0e} of their size, which is rounding"
            )
        }
        false => format!("all vertices have the same {what}"),
    };
    for row in data.values.chunks_mut(data.dimension).filter(|row| known(&&**row)) {
        row.copy_from_slice(&first);
    }
    Some(found)
}
