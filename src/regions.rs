//! The number of regions m: a number outside, a compile-time constant M inside. Only this file converts between the
//! two.
//!
//! An m that is not compiled is rounded up by padding regions, which cost [`FORBIDDEN_COST`] and start with no mass;
//! the projection onto the simplex then keeps them at exactly zero.

use ndarray::{Array2, ArrayView2};

use crate::error::{Error, Result};
use crate::field::{Row, Tangent};
use crate::problem::FORBIDDEN_COST;
use crate::relaxation::LabelMetric;
use crate::sweep::{collect, sweep};

/// The numbers of regions that users may request.
pub const REGIONS: std::ops::RangeInclusive<usize> = 2..=64;

const _: () = assert!(*REGIONS.end() <= LabelMetric::MAX_LABELS);

/// Fails if the number of regions is not in [`REGIONS`].
pub fn check(m: usize) -> Result<()> {
    if REGIONS.contains(&m) {
        Ok(())
    } else {
        Err(Error::unsuitable(format!(
            "{m} regions: must be from {} to {}",
            REGIONS.start(),
            REGIONS.end()
        )))
    }
}

/// Calls `function::<M>(arguments)` with the smallest compiled M that holds m regions. Running 9 regions as 12 would take a tenth more time; 13 take as long as 16.
#[cfg(not(test))]
macro_rules! with_regions {
    ($m:expr, $function:ident ($($argument:expr),* $(,)?)) => {
        match $m {
            2 => $function::<2>($($argument),*),
            3 => $function::<3>($($argument),*),
            4 => $function::<4>($($argument),*),
            5 => $function::<5>($($argument),*),
            6 => $function::<6>($($argument),*),
            7 => $function::<7>($($argument),*),
            8 => $function::<8>($($argument),*),
            9 => $function::<9>($($argument),*),
            10 => $function::<10>($($argument),*),
            11 => $function::<11>($($argument),*),
            12 => $function::<12>($($argument),*),
            13..=16 => $function::<16>($($argument),*),
            17..=32 => $function::<32>($($argument),*),
            33..=64 => $function::<64>($($argument),*),
            m => panic!("{m} regions: must be from 2 to 64"),
        }
    };
}
/// The same with fewer values of M, since unit tests would otherwise compile all of them again. `tests/optimum.rs` runs
/// every number of regions.
#[cfg(test)]
macro_rules! with_regions {
    ($m:expr, $function:ident ($($argument:expr),* $(,)?)) => {
        match $m {
            2..=4 => $function::<4>($($argument),*),
            5..=16 => $function::<16>($($argument),*),
            17..=64 => $function::<64>($($argument),*),
            m => panic!("{m} regions: must be from 2 to 64"),
        }
    };
}
pub(crate) use with_regions;

/// The rows of a V x m array, padded with zeros to M columns.
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

/// The V x m array of the first m columns of V rows.
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

/// Sets the costs of the padding regions, those from m on, to [`FORBIDDEN_COST`].
pub fn pad_costs<const M: usize>(m: usize, f: &mut [Row<M>]) {
    sweep(f, |_, row| row.0[m..].fill(FORBIDDEN_COST));
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
        pad_costs(9, &mut padded);
        assert!(padded.iter().all(|row| row.0[9..] == [FORBIDDEN_COST; 3]));
        assert_eq!(array(&padded, 9), array_9);
    }
}
