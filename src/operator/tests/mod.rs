//! Theorems about the operators on every mesh, one kind per file.

mod bounds;
mod gradient;
mod implicit;
mod mass;
mod symmetry;
mod variation;

use crate::field::Row;
use crate::operator::{Matrix, Operator, Stencil};

/// The values of a function at the vertices, as the first of two regions.
fn column(values: impl IntoIterator<Item = f64>) -> Vec<Row<2>> {
    values.into_iter().map(|value| Row([value, 0.0])).collect()
}

/// A test for any operator, run with both.
trait OnAny {
    fn check<K: Operator>(&self, name: &str, k: &K);

    fn on_both(&self, name: &str, mesh: &crate::mesh::Mesh) {
        self.check(&format!("{name}, stencil"), &Stencil::new(mesh));
        self.check(&format!("{name}, matrix"), &Matrix::new(mesh));
    }
}
