//! Optimal assignment: the one-to-one matching of rows and columns with the largest sum of entries.
//!
//! Shortest augmenting paths in reduced costs, the Hungarian method. References: H. W. Kuhn, *The Hungarian Method for
//! the Assignment Problem*, 1955; R. Jonker, A. Volgenant, *A Shortest Augmenting Path Algorithm for Dense and Sparse
//! Linear Assignment Problems*, Computing 38, 1987. For n rows and n' >= n columns it takes O(n^2 n') operations.

use ndarray::ArrayView2;

/// The column of each row so that the sum of the chosen entries is as large as possible. With more rows than columns,
/// the others have none. Entries must be finite.
pub fn assignment(gains: ArrayView2<f64>) -> Vec<Option<usize>> {
    assert!(gains.iter().all(|gain| gain.is_finite()), "entries are finite");
    let (rows, columns) = gains.dim();
    let (transposed, gains) = if rows > columns { (true, gains.t()) } else { (false, gains) };
    let mut duals = Duals { row: vec![0.0; gains.nrows()], column: vec![0.0; gains.ncols()] };
    let mut row_of: Vec<Option<usize>> = vec![None; gains.ncols()];
    for row in 0..gains.nrows() {
        augment(gains, row, &mut duals, &mut row_of);
    }
    if transposed {
        return row_of;
    }
    let mut column_of = vec![None; rows];
    for (column, row) in row_of.into_iter().enumerate() {
        if let Some(row) = row {
            column_of[row] = Some(column);
        }
    }
    column_of
}

/// u_i + v_j <= -g_ij, with equality where i and j are matched.
struct Duals {
    row: Vec<f64>,
    column: Vec<f64>,
}

/// Matches one more row along a shortest alternating path that ends at a column without a row.
fn augment(gains: ArrayView2<f64>, start: usize, duals: &mut Duals, row_of: &mut [Option<usize>]) {
    let columns = gains.ncols();
    // The length of the path to each column, and the column before it; the first follows the start.
    let mut length = vec![f64::INFINITY; columns];
    let mut before: Vec<Option<usize>> = vec![None; columns];
    let mut reached: Vec<usize> = Vec::new();
    let mut open: Vec<usize> = (0..columns).collect();
    let (mut row, mut last, mut shortest) = (start, None, 0.0);
    let end = loop {
        for &j in &open {
            let through = shortest - gains[[row, j]] - duals.row[row] - duals.column[j];
            if through < length[j] {
                (length[j], before[j]) = (through, last);
            }
        }
        let nearest = |a: &usize, b: &usize| length[open[*a]].total_cmp(&length[open[*b]]);
        let at = (0..open.len()).min_by(nearest).expect("there are as many columns as rows");
        let column = open.swap_remove(at);
        shortest = length[column];
        match row_of[column] {
            None => break column,
            Some(next) => {
                reached.push(column);
                (row, last) = (next, Some(column));
            }
        }
    };
    duals.row[start] += shortest;
    for &j in &reached {
        let slack = shortest - length[j];
        duals.row[row_of[j].expect("it was passed through")] += slack;
        duals.column[j] -= slack;
    }
    let mut column = end;
    while let Some(previous) = before[column] {
        row_of[column] = row_of[previous];
        column = previous;
    }
    row_of[column] = Some(start);
}
