//! The number of regions: a number outside, a type inside. The one place where one becomes the other.
//!
//! Sizes that are not compiled are rounded up, with regions that cost [`FORBIDDEN`]
//! and start with no mass; the projection onto the simplex then keeps them at exactly zero.

use ndarray::{Array2, ArrayView2};

use crate::error::{Error, Result};
use crate::field::{Row, Tangent};
use crate::problem::FORBIDDEN;
use crate::sweep::{collect, sweep};

/// What users may ask for.
pub const REGIONS: std::ops::RangeInclusive<usize> = 2..=64;

/// Refuses a number of regions out of range.
pub fn check(m: usize) -> Result<()> {
    if REGIONS.contains(&m) {
        Ok(())
    } else {
        Err(Error::unsuitable(format!(
            "{m} regions: must be {} to {}",
            REGIONS.start(),
            REGIONS.end()
        )))
    }
}

/// Calls `function::<M>(arguments)`, or `function::<M, T>(arguments)` for `function::<T>`, with the smallest compiled M
/// that holds m regions. Nine as twelve would take a tenth more time; 13 take as long as 16.
#[cfg(not(test))]
macro_rules! with_regions {
    ($m:expr, $function:ident $(::<$type:ty>)? ($($argument:expr),* $(,)?)) => {
        match $m {
            2 => $function::<2 $(, $type)?>($($argument),*),
            3 => $function::<3 $(, $type)?>($($argument),*),
            4 => $function::<4 $(, $type)?>($($argument),*),
            5 => $function::<5 $(, $type)?>($($argument),*),
            6 => $function::<6 $(, $type)?>($($argument),*),
            7 => $function::<7 $(, $type)?>($($argument),*),
            8 => $function::<8 $(, $type)?>($($argument),*),
            9 => $function::<9 $(, $type)?>($($argument),*),
            10 => $function::<10 $(, $type)?>($($argument),*),
            11 => $function::<11 $(, $type)?>($($argument),*),
            12 => $function::<12 $(, $type)?>($($argument),*),
            13..=16 => $function::<16 $(, $type)?>($($argument),*),
            17..=32 => $function::<32 $(, $type)?>($($argument),*),
            33..=64 => $function::<64 $(, $type)?>($($argument),*),
            m => panic!("{m} regions: must be 2 to 64"),
        }
    };
}
/// The same with fewer lengths: unit tests would else compile all of them once more. `tests/optimum.rs` asks for
/// every number of regions.
#[cfg(test)]
macro_rules! with_regions {
    ($m:expr, $function:ident $(::<$type:ty>)? ($($argument:expr),* $(,)?)) => {
        match $m {
            2..=4 => $function::<4 $(, $type)?>($($argument),*),
            5..=16 => $function::<16 $(, $type)?>($($argument),*),
            17..=64 => $function::<64 $(, $type)?>($($argument),*),
            m => panic!("{m} regions: must be 2 to 64"),
        }
    };
}
pub(crate) use with_regions;

/// The rows of a V x m array, filled up with zeros to M columns.
pub fn rows<const M: usize>(array: ArrayView2<f64>) -> Vec<Row<M>> {
    let m = array.ncols();
    match array.as_slice() {
        Some(numbers) => collect(
            array.nrows(),
            #[inline(always)]
            |k| {
                let row = &numbers[k * m..][..m];
                Row::from_fn(|p| if p < m { row[p] } else { 0.0 })
            },
        ),
        None => {
            collect(array.nrows(), |k| Row::from_fn(|p| if p < m { array[[k, p]] } else { 0.0 }))
        }
    }
}

/// The tangents of a 2F x m array, whose rows 2j and 2j + 1 are those of face j.
pub fn tangents<const M: usize>(array: ArrayView2<f64>) -> Vec<Tangent<M>> {
    let rows = rows::<M>(array);
    collect(rows.len() / 2, |j| Tangent([rows[2 * j], rows[2 * j + 1]]))
}

/// The first m columns of rows.
pub fn array<const M: usize>(rows: &[Row<M>], m: usize) -> Array2<f64> {
    let shape = (rows.len(), m);
    if m < M {
        return Array2::from_shape_fn(shape, |(k, p)| rows[k].0[p]);
    }
    let numbers = collect(
        rows.len(),
        #[inline(always)]
        |k| rows[k].0,
    );
    Array2::from_shape_vec(shape, numbers.into_flattened()).expect("V rows of m numbers")
}

/// Closes the regions from m on: no one can afford them.
pub fn close_from<const M: usize>(m: usize, f: &mut [Row<M>]) {
    sweep(f, |_, row| row.0[m..].fill(FORBIDDEN));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_out_of_range_are_refused() {
        for m in [0, 1, 65, usize::MAX] {
            let message = check(m).unwrap_err().to_string();
            assert!(message.contains("2 to 64") && !message.contains('\n'), "{message}");
        }
        assert!(REGIONS.into_iter().all(|m| check(m).is_ok()));
    }

    #[test]
    fn rows_and_arrays_are_the_same_numbers() {
        let array_9 = Array2::from_shape_fn((4, 9), |(k, p)| (10 * k + p) as f64);
        let mut padded = rows::<12>(array_9.view());
        assert!(padded.iter().all(|row| row.0[9..] == [0.0; 3]));
        assert_eq!(array(&padded, 9), array_9);
        close_from(9, &mut padded);
        assert!(padded.iter().all(|row| row.0[9..] == [FORBIDDEN; 3]));
        assert_eq!(array(&padded, 9), array_9);
    }
}
