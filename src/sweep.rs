//! One pass over all faces or all vertices, in parallel and without races; the only file that uses rayon.
//!
//! Results are bitwise the same with any number of threads: a sweep writes each element from its own index alone, and a
//! sum is a binary tree whose shape depends only on the length. They do not depend on the instruction set that is
//! chosen at run time (AVX2 or the baseline) either: neither fuses or reorders the operations in the code.
//! Pairwise summation: N. J. Higham, *The Accuracy of Floating Point Summation*, SIAM J. Sci. Comput. 14, 1993.

mod columns;

use std::sync::Mutex;

use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};

use crate::error::{Error, Result};
use columns::Columns;

/// Number of elements below which a second thread does not pay off.
const BLOCK: usize = 1024;

/// Runs `body(index, (column_1[index], column_2[index], ...))` for every index of a tuple of slices of equal length,
/// `&mut` for those that are written: one line of the paper as one fused loop. A body marked
/// `#[inline(always)]` is compiled for each set of vector instructions.
#[inline]
pub fn sweep<C: Columns>(columns: C, body: impl Fn(usize, C::Item) + Sync) {
    let length = columns.length();
    let pointers = columns.pointers();
    let block = BLOCK.max(length.div_ceil(4 * threads()));
    in_parallel(length.div_ceil(block), &|i| {
        let (first, last) = (i * block, length.min((i + 1) * block));
        vectorized(
            #[inline(always)]
            || {
                for index in first..last {
                    // SAFETY: the blocks are disjoint and within the length, so each index comes once.
                    body(index, unsafe { C::at(pointers, index) });
                }
            },
        );
    });
}

/// Runs `body(first, &mut column[first..next])` for any two consecutive `first` and `next` of `cuts`, which run from 0
/// to the length: sequentially within a part, in parallel over the parts.
#[inline]
pub fn sweep_parts<T: Send>(
    mut column: &mut [T],
    cuts: &[usize],
    body: impl Fn(usize, &mut [T]) + Sync,
) {
    let mut pieces = Vec::with_capacity(cuts.len());
    for pair in cuts.windows(2) {
        let (piece, behind) = column.split_at_mut(pair[1] - pair[0]);
        pieces.push((pair[0], piece));
        column = behind;
    }
    each(pieces, &|(first, piece)| {
        vectorized(
            #[inline(always)]
            || body(first, piece),
        );
    });
}

/// Runs `work` on every item; each item is a task of its own.
pub fn each<T: Send>(items: Vec<T>, work: &(dyn Fn(T) + Sync)) {
    let mut slots = Vec::with_capacity(items.len());
    for item in items {
        slots.push(Mutex::new(Some(item)));
    }
    take_each(&slots, work);
}

fn take_each<T: Send>(slots: &[Mutex<Option<T>>], work: &(dyn Fn(T) + Sync)) {
    in_parallel(slots.len(), &|i| {
        let Ok(mut slot) = slots[i].lock() else { unreachable!("no one else takes it") };
        if let Some(item) = slot.take() {
            drop(slot);
            work(item);
        }
    });
}

/// Runs `work` for 0 to n - 1. All other loops use this one, so that it is compiled only once.
fn in_parallel(n: usize, work: &(dyn Fn(usize) + Sync)) {
    if n == 1 {
        return work(0);
    }
    (0..n).into_par_iter().with_max_len(1).for_each(work);
}

/// The results of `task` for the items, in their order; each item is a task of its own.
pub fn results<A: Send, T: Send>(items: Vec<A>, task: impl Fn(A) -> T + Sync) -> Vec<T> {
    let mut results: Vec<Option<T>> = items.iter().map(|_| None).collect();
    let slots = items.into_iter().zip(&mut results).collect();
    each(slots, &|(item, result)| *result = Some(task(item)));
    results.into_iter().map(|result| result.expect("every task has ended")).collect()
}

/// Number of threads.
pub fn threads() -> usize {
    rayon::current_num_threads()
}

/// The values of the indices 0 to n - 1, each from its index alone.
#[inline]
pub fn collect<T: Copy + Send>(n: usize, value: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let mut values = Vec::with_capacity(n);
    sweep(
        &mut values.spare_capacity_mut()[..n],
        #[inline(always)]
        |index, slot| {
            slot.write(value(index));
        },
    );
    // SAFETY: the sweep wrote all n elements, or panicked.
    unsafe { values.set_len(n) };
    values
}

/// A copy of a slice.
pub fn copy<T: Copy + Send + Sync>(values: &[T]) -> Vec<T> {
    collect(
        values.len(),
        #[inline(always)]
        |index| values[index],
    )
}

/// Overwrites a slice with the values of another.
pub fn copy_over<T: Copy + Send + Sync>(target: &mut [T], values: &[T]) {
    sweep(
        (target, values),
        #[inline(always)]
        |_, (target, &value)| *target = value,
    );
}

/// Scatters n terms: adds `shares(term)` at `indices(term)`, in the order of the terms with any number of threads. Each
/// thread reads all indices, but only the shares of those in its range.
pub fn scatter<const N: usize>(
    length: usize,
    n: usize,
    indices: impl Fn(usize) -> [usize; N] + Sync,
    shares: impl Fn(usize) -> [f64; N] + Sync,
) -> Vec<f64> {
    let mut sums = vec![0.0; length];
    sweep_parts(
        &mut sums,
        &ranges(length),
        #[inline(always)]
        |first, sums| {
            for term in 0..n {
                // For indices below the range the difference wraps around.
                let indices = indices(term).map(|index| index.wrapping_sub(first));
                if indices.iter().any(|&index| index < sums.len()) {
                    for (index, share) in indices.into_iter().zip(shares(term)) {
                        if let Some(sum) = sums.get_mut(index) {
                            *sum += share;
                        }
                    }
                }
            }
        },
    );
    sums
}

/// The boundaries of the ranges of about equal length that the threads own, from 0 to `length`.
pub fn ranges(length: usize) -> Vec<usize> {
    let count = threads().min(length.div_ceil(BLOCK)).max(1);
    (0..=count).map(|k| length * k / count).collect()
}

/// Number of independent partial sums of a block, since an addition has to wait for the previous one.
const LANES: usize = 8;

/// sum_{0 <= index < n} term(index): blocks of fixed size are summed in lanes, then pairwise. A term marked
/// `#[inline(always)]` is compiled for each set of vector instructions.
#[inline]
pub fn sum(n: usize, term: impl Fn(usize) -> f64 + Sync) -> f64 {
    sum_blocks(
        n,
        #[inline(always)]
        |first, terms| {
            for (slot, index) in terms.iter_mut().zip(first..) {
                *slot = term(index);
            }
        },
    )
}

/// The same for terms that are computed in blocks: `write(first, terms)` writes those from index `first` on.
#[inline]
pub fn sum_blocks(n: usize, write: impl Fn(usize, &mut [f64]) + Sync) -> f64 {
    let block = |from: usize, to: usize| {
        block_sum(
            from,
            to,
            #[inline(always)]
            |first, terms| write(first, terms),
        )
    };
    tree(&blocks(n, &block), &|a, b| a + b)
}

/// The sum of the terms of one block, which `write` writes.
#[inline(always)]
fn block_sum(from: usize, to: usize, write: impl Fn(usize, &mut [f64])) -> f64 {
    vectorized(
        #[inline(always)]
        || {
            let mut terms = [0.0; BLOCK];
            let terms = &mut terms[..to - from];
            write(from, terms);
            let mut lanes = [0.0; LANES];
            let (whole, rest) = terms.as_chunks::<LANES>();
            for terms in whole {
                for (lane, term) in lanes.iter_mut().zip(terms) {
                    *lane += term;
                }
            }
            for (lane, term) in lanes.iter_mut().zip(rest) {
                *lane += term;
            }
            let [a, b, c, d, e, f, g, h] = lanes;
            ((a + e) + (c + g)) + ((b + f) + (d + h))
        },
    )
}

/// The sums over 0 <= index < n of term(i)(index) for 0 <= i < count, each with the bits of [`sum`], in one pass over the
/// blocks.
pub fn sums<T: Fn(usize) -> f64>(
    n: usize,
    count: usize,
    term: impl Fn(usize) -> T + Sync,
) -> Vec<f64> {
    let block = |k: usize| {
        let sum = |i: usize| {
            let term = term(i);
            block_sum(
                k * BLOCK,
                n.min((k + 1) * BLOCK),
                #[inline(always)]
                |first, terms| {
                    for (slot, index) in terms.iter_mut().zip(first..) {
                        *slot = term(index);
                    }
                },
            )
        };
        (0..count).map(sum).collect::<Vec<f64>>()
    };
    let blocks = results((0..n.div_ceil(BLOCK)).collect(), block);
    let values = |i: usize| blocks.iter().map(|sums| sums[i]).collect::<Vec<f64>>();
    (0..count).map(|i| tree(&values(i), &|a, b| a + b)).collect()
}

/// max_{0 <= index < n} term(index) for terms >= 0; NaN if any of them is NaN.
#[inline]
pub fn max(n: usize, term: impl Fn(usize) -> f64 + Sync) -> f64 {
    let greater = |a: f64, b: f64| if a > b || a.is_nan() { a } else { b };
    let block = |from: usize, to: usize| {
        vectorized(
            #[inline(always)]
            || (from..to).fold(0.0, |most, index| greater(most, term(index))),
        )
    };
    tree(&blocks(n, &block), &greater)
}

/// Whether `holds` is true for every index from 0 to n - 1.
#[inline]
pub fn all(n: usize, holds: impl Fn(usize) -> bool + Sync) -> bool {
    let block = |from: usize, to: usize| {
        vectorized(
            #[inline(always)]
            || f64::from((from..to).fold(true, |all, index| all & holds(index))),
        )
    };
    blocks(n, &block).into_iter().all(|all| all == 1.0)
}

/// Runs `work`, as far as it is inlined, with AVX2 if the machine has it. Rows of four or eight numbers gain nothing
/// from longer vectors, and each instruction set costs compile time: unit tests have only one.
#[inline(always)]
pub(crate) fn vectorized<T>(work: impl FnOnce() -> T) -> T {
    #[cfg(all(target_arch = "x86_64", not(test)))]
    if let Some(avx2) = pulp::x86::V3::try_new() {
        return avx2.vectorize(work);
    }
    work()
}

/// The values of all blocks of [`BLOCK`] indices.
fn blocks(n: usize, block: &(dyn Fn(usize, usize) -> f64 + Sync)) -> Vec<f64> {
    let value = |i: usize| block(i * BLOCK, n.min((i + 1) * BLOCK));
    (0..n.div_ceil(BLOCK)).into_par_iter().map(value).collect()
}

/// The values combined pairwise, 0 if there are none: a binary tree that depends only on their number.
fn tree(values: &[f64], combine: &dyn Fn(f64, f64) -> f64) -> f64 {
    match values {
        [] => 0.0,
        [value] => *value,
        _ => {
            let (left, right) = values.split_at(values.len().div_ceil(2));
            combine(tree(left, combine), tree(right, combine))
        }
    }
}

/// The results of two independent pieces of work, run in parallel.
pub fn join<A: Send, B: Send>(
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    rayon::join(a, b)
}

/// The largest number of threads.
pub const MAX_THREADS: u16 = 1024;

/// Fails if the environment asks for more threads than can be started in a moment.
pub fn check_environment() -> Result<()> {
    let Ok(asked) = std::env::var("RAYON_NUM_THREADS") else { return Ok(()) };
    match asked.parse::<usize>() {
        Ok(threads) if threads > usize::from(MAX_THREADS) => Err(Error::unsuitable(format!(
            "RAYON_NUM_THREADS={asked}: must be at most {MAX_THREADS}; unset it, or use --threads"
        ))),
        _ => Ok(()),
    }
}

/// Runs `work` with the given number of threads, `None` for as many as the machine has. Fails if they cannot be
/// started.
pub fn with_threads<T: Send>(threads: Option<usize>, work: impl FnOnce() -> T + Send) -> Result<T> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build().map_err(
        |error| {
            Error::unsuitable(format!(
                "cannot start the threads: {error}; try fewer with --threads"
            ))
        },
    )?;
    Ok(pool.install(work))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_have_the_same_bits_with_any_number_of_threads() {
        let term = |i: usize| ((i * 7919) as f64).sin() * 1e3;
        let with = |threads| with_threads(Some(threads), || sum(100_003, term)).unwrap();
        let one = with(1);
        assert!([2, 3, 7].iter().all(|&n| with(n).to_bits() == one.to_bits()));
        let plain: f64 = (0..100_003).map(term).sum();
        assert!((one - plain).abs() < 1e-6);
    }

    #[test]
    fn every_index_counts_once_for_any_length() {
        for n in [0, 1, 7, 8, 9, BLOCK - 1, BLOCK + 3, 5 * BLOCK + 13] {
            assert_eq!(sum(n, |i| i as f64), (n * n.saturating_sub(1) / 2) as f64);
            assert_eq!(collect(n, |i| 3 * i), (0..n).map(|i| 3 * i).collect::<Vec<_>>());
            assert!(all(n, |i| i < n));
            assert!((0..n).all(|odd| !all(n, |i| i != odd)));
        }
    }

    #[test]
    fn sums_in_one_pass_have_the_bits_of_each() {
        let term = |i: usize| move |k: usize| ((k * 7919 + i) as f64).sin() * 1e3;
        for n in [0, 5, BLOCK, 100_003] {
            let each: Vec<f64> = (0..3).map(|i| sum(n, term(i))).collect();
            assert_eq!(sums(n, 3, term), each);
        }
    }

    #[test]
    fn scattered_terms_are_added_in_their_order() {
        let n = 30_011;
        let indices = |i: usize| [i * i % 5003, i * 31 % 5003];
        let shares = |i: usize| [1.0, 1e3].map(|size| size * ((i * 7919) as f64).sin());
        let mut plain = vec![0.0; 5003];
        for i in 0..n {
            for (index, share) in indices(i).into_iter().zip(shares(i)) {
                plain[index] += share;
            }
        }
        for threads in [1, 2, 3, 8] {
            let sums = with_threads(Some(threads), || scatter(5003, n, indices, shares)).unwrap();
            assert_eq!(sums, plain);
        }
        assert!(scatter(0, 0, indices, shares).is_empty());
    }

    #[test]
    fn max_reports_nan() {
        let value = max(5000, |i| if i == 4321 { f64::NAN } else { i as f64 });
        assert!(value.is_nan());
        assert_eq!(max(5000, |i| i as f64), 4999.0);
    }
}
