//! D + K^T diag(w) K, assembled: the matrix of implicit steps, the same for every region.
//!
//! Assembled by hand: `TriMat::to_csr` of sprs takes five times as long (0.8 s instead of 0.15 s for 200,000 faces),
//! and sums duplicates in no fixed order.

use sprs::CsMat;

use super::Operator;

/// D + K^T diag(w) K in compressed rows, V x V; symmetric, and positive definite for positive D.
pub fn normal_matrix(k: &impl Operator, diagonal: &[f64], weights: &[f64]) -> CsMat<f64> {
    // Every face contributes <K_ja, K_jb> to nine entries. The entries of each row are counted first.
    let n = k.vertices();
    let mut end = vec![1; n];
    for j in 0..k.faces() {
        k.face(j).corners.iter().for_each(|&v| end[v] += 3);
    }
    let mut count = 0;
    for end in &mut end {
        (*end, count) = (count, count + *end);
    }
    let mut entries = vec![(0, 0.0); count];
    let mut add = |row: usize, column: usize, value: f64| {
        entries[end[row]] = (column, value);
        end[row] += 1;
    };
    (0..n).for_each(|v| add(v, v, diagonal[v]));
    for (j, &weight) in weights.iter().enumerate() {
        let face = k.face(j);
        for (&a, [ax, ay]) in face.corners.iter().zip(face.columns) {
            for (&b, [bx, by]) in face.corners.iter().zip(face.columns) {
                add(a, b, weight * (ax * bx + ay * by));
            }
        }
    }
    // Sorted by column; entries of equal columns are summed in the order of the faces.
    let (mut starts, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    let mut begin = 0;
    for end in end {
        let row = &mut entries[begin..end];
        row.sort_by_key(|&(column, _)| column);
        for same in row.chunk_by(|a, b| a.0 == b.0) {
            columns.push(same[0].0);
            values.push(same.iter().map(|&(_, value)| value).sum());
        }
        starts.push(columns.len());
        begin = end;
    }
    CsMat::new((n, n), starts, columns, values)
}
