//! Pointwise costs as users supply them: numbers, forbidden labels, and unknown vertices.
//!
//! ```text
//! s_kp = +inf            region p is forbidden at vertex k
//! s_k  = NaN ... NaN     vertex k is unknown: it costs nothing and takes the label of its neighbors
//! ```

use std::borrow::Cow;

use ndarray::{Array2, ArrayView1};

use crate::counted::counted;
use crate::error::{Error, Result};
use crate::operator::Mass;
use crate::sweep;
use crate::unreached::INHERIT;

/// The same costs with zeros at unknown vertices, and warnings about unknown vertices and forbidden labels.
///
/// # Errors
/// A row with NaN and numbers; -inf; a row that forbids every label; forbidden labels with the consistent mass, which
/// would spread them to the neighbors; costs that are NaN at every vertex.
pub fn checked(s: &Array2<f64>, mass: Mass) -> Result<(Cow<'_, Array2<f64>>, Vec<String>)> {
    if let Some(numbers) = s.as_slice()
        && sweep::all(
            numbers.len(),
            #[inline(always)]
            |i| numbers[i].is_finite(),
        )
    {
        return Ok((Cow::Borrowed(s), Vec::new()));
    }
    let (mut unknown, mut forbidden) = (0, 0);
    for (k, row) in s.outer_iter().enumerate() {
        check(k, row)?;
        unknown += usize::from(row[0].is_nan());
        forbidden += row.iter().filter(|&&x| x == f64::INFINITY).count();
    }
    if unknown == s.nrows() {
        return Err(Error::unsuitable(
            "the costs are NaN at every vertex: at least one vertex needs known costs",
        ));
    }
    if forbidden > 0 && mass == Mass::Consistent {
        return Err(Error::unsuitable(
            "forbidden labels (costs of +inf) need a lumped mass: --mass barycentric or voronoi",
        ));
    }
    let mut warnings = Vec::new();
    if unknown > 0 {
        warnings.push(unknown_rows(unknown));
    }
    if forbidden > 0 {
        warnings.push(counted(
            forbidden,
            "cost is +inf: this label is forbidden at its vertex",
            "costs are +inf: these labels are forbidden at their vertices",
        ));
    }
    let known = s.mapv(|x| if x.is_nan() { 0.0 } else { x });
    Ok((if unknown > 0 { Cow::Owned(known) } else { Cow::Borrowed(s) }, warnings))
}

/// The warning about unknown rows.
pub(crate) fn unknown_rows(count: usize) -> String {
    format!(
        "the costs of {}; {INHERIT}",
        counted(
            count,
            "vertex are NaN, which marks it as unknown",
            "vertices are NaN, which marks them as unknown"
        )
    )
}

fn check(k: usize, row: ArrayView1<'_, f64>) -> Result<()> {
    let nan = row.iter().filter(|x| x.is_nan()).count();
    let message = if nan > 0 && nan < row.len() {
        let p = row.iter().position(|x| x.is_nan()).expect("one is NaN");
        format!(
            "the costs have NaN in row {k}, column {p} but numbers elsewhere in the row; use +inf to forbid a label, \
             or fill the row with NaN if the vertex is unknown"
        )
    } else if let Some(p) = row.iter().position(|&x| x == f64::NEG_INFINITY) {
        format!(
            "the costs have -inf in row {k}, column {p}; to force a label, forbid the others with +inf"
        )
    } else if row.iter().all(|&x| x == f64::INFINITY) {
        format!(
            "the costs forbid every label in row {k}; allow at least one, or fill the row with NaN if the vertex is \
             unknown"
        )
    } else {
        return Ok(());
    };
    Err(Error::unsuitable(message))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;

    const INF: f64 = f64::INFINITY;
    const NAN: f64 = f64::NAN;

    #[test]
    fn unknown_rows_cost_nothing_and_infinite_costs_stay() {
        let finite = array![[1.0, 2.0], [3.0, 4.0]];
        let (same, warnings) = checked(&finite, Mass::Consistent).unwrap();
        assert!(*same == finite && warnings.is_empty());
        let s = array![[1.0, INF], [NAN, NAN], [-3.0, 4.0]];
        let (known, warnings) = checked(&s, Mass::Barycentric).unwrap();
        assert_eq!(*known, array![[1.0, INF], [0.0, 0.0], [-3.0, 4.0]]);
        assert!(warnings[0].contains("1 vertex are NaN") && warnings[1].contains("1 cost is +inf"));
    }

    #[test]
    fn invalid_rows_are_refused_with_their_position() {
        let message = |s: Array2<f64>, mass| checked(&s, mass).unwrap_err().to_string();
        let lumped = Mass::Barycentric;
        assert!(message(array![[1.0, 2.0], [NAN, 1.0]], lumped).contains("row 1, column 0"));
        assert!(
            message(array![[1.0, 2.0], [1.0, -INF]], lumped).contains("-inf in row 1, column 1")
        );
        assert!(message(array![[INF, INF], [1.0, 1.0]], lumped).contains("every label in row 0"));
        assert!(message(array![[INF, NAN], [1.0, 1.0]], lumped).contains("NaN in row 0"));
        assert!(message(array![[NAN, NAN]], lumped).contains("at every vertex"));
        assert!(message(array![[INF, 1.0]], Mass::Consistent).contains("lumped"));
    }
}
