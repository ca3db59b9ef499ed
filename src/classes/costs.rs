//! Costs of classes from probabilities, scores or labels:
//!
//! ```text
//! probabilities    s_kp = -log max( p_kp / sum_r p_kr, floor )
//! scores           s_kp = -log max( exp x_kp / sum_r exp x_kr, floor )
//! labels           s_kp = -log c if p is the label, -log( (1 - c) / (m - 1) ) otherwise, for a confidence c
//! ```
//!
//! The floor keeps one wrong vote from deciding alone. A row without information, all zeros or all NaN, is unknown.

use ndarray::{Array2, ArrayView1};

use crate::error::{Error, Result};
use crate::regions;

/// Probabilities below this count as this much: a vote against all others costs at most 13.8.
pub const DEFAULT_FLOOR: f64 = 1e-6;

/// How far the sum of a row of probabilities may be from 1 by rounding alone.
const SUM_TOLERANCE: f64 = 1e-3;

/// Costs, and what is worth saying about the numbers they come from.
pub struct Found {
    /// s; a row of NaN is unknown.
    pub s: Array2<f64>,
    /// The number of unknown rows.
    pub unknown: usize,
    /// The number of rows whose sum is not 1, which were divided by it.
    pub divided: usize,
}

/// Fails unless a floor is positive and below 1 / m, above which every class of a row of zeros but one would cost the
/// same as a tie.
pub fn check_floor(floor: f64, m: usize) -> Result<()> {
    if floor > 0.0 && floor < 1.0 / m as f64 {
        return Ok(());
    }
    Err(Error::unsuitable(format!(
        "the floor is {floor:?}: it must be above 0 and below 1/{m}, the probability of each class where nothing is known"
    )))
}

/// Costs of probabilities or of counts of votes, one row per vertex or face.
///
/// # Errors
/// A number of classes that is not from 2 to 64, a floor out of range, negative or infinite entries, rows with NaN and
/// numbers, and rows that are all unknown.
pub fn of_probabilities(p: &Array2<f64>, floor: f64) -> Result<Found> {
    check_columns(p)?;
    check_floor(floor, p.ncols())?;
    let mut divided = 0;
    from_rows(p, "probabilities", |k, row, s| {
        if let Some(c) = row.iter().position(|x| !(*x >= 0.0 && x.is_finite())) {
            let x = row[c];
            return Err(Error::unsuitable(format!(
                "row {k}, column {c} is {x}: probabilities and votes must be 0 or more; if these are scores, use --scores"
            )));
        }
        // Divided by the largest first, so that no sum overflows.
        let largest = row.fold(0.0, |a: f64, &x| a.max(x));
        if largest == 0.0 {
            return Ok(false);
        }
        let sum: f64 = row.iter().map(|x| x / largest).sum();
        divided += usize::from((sum * largest - 1.0).abs() > SUM_TOLERANCE);
        for (s, x) in s.iter_mut().zip(row) {
            *s = -(x / largest / sum).max(floor).ln();
        }
        Ok(true)
    })
    .map(|(s, unknown)| Found { s, unknown, divided })
}

/// Costs of scores such as the logits of a network, by their softmax.
///
/// # Errors
/// As those of [`of_probabilities`]; scores may be negative, and -inf excludes a class.
pub fn of_scores(x: &Array2<f64>, floor: f64) -> Result<Found> {
    check_columns(x)?;
    check_floor(floor, x.ncols())?;
    let highest = -floor.ln();
    from_rows(x, "scores", |k, row, s| {
        if let Some(c) = row.iter().position(|x| *x == f64::INFINITY) {
            return Err(Error::unsuitable(format!(
                "row {k}, column {c} is inf: scores must be finite"
            )));
        }
        let largest = row.fold(f64::NEG_INFINITY, |a: f64, &x| a.max(x));
        if largest == f64::NEG_INFINITY {
            return Ok(false);
        }
        let log_sum = row.iter().map(|x| (x - largest).exp()).sum::<f64>().ln();
        for (s, x) in s.iter_mut().zip(row) {
            // Not below 0 by rounding.
            *s = (log_sum - (x - largest)).clamp(0.0, highest);
        }
        Ok(true)
    })
    .map(|(s, unknown)| Found { s, unknown, divided: 0 })
}

/// Costs of m classes from labels that are right with probability `confidence`; `None` is unknown.
///
/// # Errors
/// A number of classes that is not from 2 to 64, a confidence that is not between 1 / m and 1, labels that are no
/// class, and no label at all.
pub fn of_labels(labels: &[Option<i64>], m: usize, confidence: f64) -> Result<Found> {
    regions::check(m)?;
    let chance = 1.0 / m as f64;
    if !(confidence > chance && confidence < 1.0) {
        return Err(Error::unsuitable(format!(
            "the confidence is {confidence:?}: it must be above 1/{m}, which {m} classes have by chance, and below 1"
        )));
    }
    let [right, wrong] = [confidence, (1.0 - confidence) / (m - 1) as f64].map(|p| -p.ln());
    let mut s = Array2::from_elem((labels.len(), m), f64::NAN);
    let mut unknown = 0;
    for (k, (mut row, &label)) in s.outer_iter_mut().zip(labels).enumerate() {
        let Some(label) = label else {
            unknown += 1;
            continue;
        };
        let p = usize::try_from(label).ok().filter(|&p| p < m).ok_or_else(|| {
            Error::unsuitable(format!(
                "label {label} in row {k} is no class: the {m} classes are numbered from 0; --unknown {label} marks such rows as unknown"
            ))
        })?;
        row.fill(wrong);
        row[p] = right;
    }
    check_known(unknown, labels.len(), "labels")?;
    Ok(Found { s, unknown, divided: 0 })
}

fn check_columns(array: &Array2<f64>) -> Result<()> {
    match array.ncols() {
        1 => Err(Error::unsuitable(
            "there is one column; give one per class, for two classes both p and 1 - p",
        )),
        m => regions::check(m),
    }
}

fn check_known(unknown: usize, rows: usize, what: &str) -> Result<()> {
    if unknown < rows {
        return Ok(());
    }
    Err(Error::unsuitable(format!(
        "the {what} are unknown in every row: at least one must be known"
    )))
}

/// Costs row by row; `fill` returns whether a row is known, and sees no row of NaN.
fn from_rows(
    array: &Array2<f64>,
    what: &str,
    mut fill: impl FnMut(usize, ArrayView1<'_, f64>, &mut [f64]) -> Result<bool>,
) -> Result<(Array2<f64>, usize)> {
    let mut costs = Array2::from_elem(array.dim(), f64::NAN);
    let mut unknown = 0;
    for (k, (row, mut s)) in array.outer_iter().zip(costs.outer_iter_mut()).enumerate() {
        let nan = row.iter().filter(|x| x.is_nan()).count();
        if nan > 0 && nan < row.len() {
            return Err(Error::unsuitable(format!(
                "row {k} of the {what} has NaN and numbers; fill it with NaN if nothing is known there"
            )));
        }
        let known = nan == 0 && fill(k, row, s.as_slice_mut().expect("rows are contiguous"))?;
        unknown += usize::from(!known);
    }
    check_known(unknown, array.nrows(), what)?;
    Ok((costs, unknown))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;

    const NAN: f64 = f64::NAN;

    fn known(found: &Found, k: usize) -> Vec<f64> {
        found.s.row(k).to_vec()
    }

    /// Probabilities, votes in the same ratio and scores that are their logarithms cost the same.
    #[test]
    fn probabilities_votes_and_scores_agree() {
        let p = array![[0.5, 0.25, 0.25], [0.1, 0.2, 0.7]];
        let found = of_probabilities(&p, 1e-6).unwrap();
        assert_eq!((found.unknown, found.divided), (0, 0));
        let votes = of_probabilities(&(&p * 40.0), 1e-6).unwrap();
        assert_eq!((votes.unknown, votes.divided), (0, 2));
        let scores = of_scores(&p.mapv(|p: f64| p.ln() + 300.0), 1e-6).unwrap();
        for ((expected, votes), scores) in found.s.iter().zip(&votes.s).zip(&scores.s) {
            assert!((expected - votes).abs() < 1e-14 && (expected - scores).abs() < 1e-12);
        }
        for (s, p) in found.s.iter().zip(&p) {
            assert!((s + p.ln()).abs() < 1e-15);
        }
    }

    /// Labels with confidence c cost as the probabilities c and (1 - c) / (m - 1).
    #[test]
    fn labels_are_probabilities() {
        let found = of_labels(&[Some(2), None, Some(0)], 3, 0.8).unwrap();
        let p = array![[0.1, 0.1, 0.8], [0.0, 0.0, 0.0], [0.8, 0.1, 0.1]];
        let expected = of_probabilities(&p, 1e-6).unwrap();
        assert_eq!((found.unknown, expected.unknown), (1, 1));
        for (a, b) in found.s.iter().zip(&expected.s) {
            assert!(a.is_nan() && b.is_nan() || (a - b).abs() < 1e-14);
        }
    }

    #[test]
    fn the_floor_bounds_costs() {
        let p = array![[1.0, 0.0], [0.0, 0.0], [NAN, NAN], [1e300, 1e300]];
        let found = of_probabilities(&p, 1e-3).unwrap();
        assert_eq!(known(&found, 0), [0.0, -(1e-3_f64).ln()]);
        assert!(known(&found, 1).iter().chain(&known(&found, 2)).all(|s| s.is_nan()));
        assert_eq!(known(&found, 3), [2.0_f64.ln(); 2]);
        assert_eq!(found.unknown, 2);
        let far = array![[1e4, -1e4], [0.0, f64::NEG_INFINITY], [f64::NEG_INFINITY; 2]];
        let found = of_scores(&far, 1e-3).unwrap();
        assert_eq!(known(&found, 0), [0.0, -(1e-3_f64).ln()]);
        assert_eq!(known(&found, 1), [0.0, -(1e-3_f64).ln()]);
        assert_eq!(found.unknown, 1);
    }

    #[test]
    fn what_is_no_probability_is_refused() {
        let message = |found: Result<Found>| found.err().unwrap().to_string();
        let refused = |p: Array2<f64>| message(of_probabilities(&p, 1e-6));
        assert!(refused(array![[0.5, 0.5], [-0.1, 1.1]]).contains("row 1, column 0 is -0.1"));
        assert!(refused(array![[f64::INFINITY, 0.5]]).contains("inf"));
        assert!(refused(array![[0.5, NAN]]).contains("NaN and numbers"));
        assert!(refused(array![[0.0, 0.0]]).contains("at least one must be known"));
        assert!(refused(array![[0.5], [0.2]]).contains("1 - p"));
        assert!(refused(Array2::zeros((2, 65))).contains("65 regions"));
        for floor in [0.0, 0.5, -1.0, NAN, 1.0] {
            assert!(
                message(of_probabilities(&array![[0.5, 0.5]], floor)).contains("floor"),
                "{floor}"
            );
        }
        for confidence in [0.5, 1.0, 0.0, NAN] {
            assert!(message(of_labels(&[Some(0)], 2, confidence)).contains("confidence"));
        }
        assert!(message(of_labels(&[Some(2)], 2, 0.9)).contains("label 2 in row 0"));
        assert!(message(of_scores(&array![[f64::INFINITY, 0.0]], 1e-6)).contains("finite"));
    }
}
