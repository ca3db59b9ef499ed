//! The cut of U as a curve through the faces.
//!
//! ```text
//! cell p = { x : u_p(x) >= u_r(x) for all r },   u linear on each face        contour = the boundaries between cells
//! ```
//!
//! Cuts along edges zigzag: labels of a smooth region are up to a fifth too long, however fine the mesh. The contour of U
//! converges to the boundary. Its cells are those of U, not of labels that were found by moves. For two regions the cells
//! are {u_0 >= t} and {u_0 < t}, with a [threshold] at which their energy is at most that of U. One-hot U has cuts
//! through the midpoints of edges, which meet at the centroid of a face with three labels.
//!
//! [`Cells`] divides every face exactly (`contour/face.rs`), for U rounded to multiples of 2^-41. Hence faces agree on the
//! points where the cut crosses their common edge, whatever is degenerate: of regions that tie, the first has the cell, and
//! where they tie along an edge with different cells on both sides, the edge is part of the contour.

mod cells;
mod cut_mesh;
mod edges;
mod face;
mod labels;
mod level;
mod polylines;
mod record;
#[cfg(test)]
mod tests;

pub use cells::{Cells, compared_rows};
pub use labels::cut_length;
pub use level::{LevelLine, threshold};
pub use polylines::{Contours, Polyline};
pub use record::CutRecord;
