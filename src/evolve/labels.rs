//! The labels of a surface for the colors of its regions: the convex problem in U, from the last U and q.

use crate::error::Result;
use crate::field::{Row, Tangent};
use crate::mesh::Mesh;
use crate::operator::Stencil;
use crate::problem::{FORBIDDEN_COST, Problem};
use crate::regions::with_regions;
use crate::run::{Run, Stop};
use crate::solve::{Observer, check_range};
use crate::solver::{Method, Setup};
use crate::start::cheapest_labels;
use crate::sweep::collect;

/// U, and the dual field of the last solve on the same faces.
#[derive(Clone, Debug, Default)]
pub struct Labels {
    /// V x m numbers in row order.
    pub u: Vec<f64>,
    /// Two rows of m numbers per face; empty before a solve.
    pub q: Vec<f64>,
}

/// Improves the labels for integrated costs f (V x m) of m >= 2 regions, until `stop`. With lambda = 0 they are the
/// cheapest ones. No face of the mesh is degenerate.
///
/// # Errors
/// Costs beyond double precision.
pub fn improve(
    mesh: &Mesh,
    f: &[f64],
    m: usize,
    lambda: f64,
    labels: &mut Labels,
    stop: &Stop,
    observe: Observer<'_>,
) -> Result<()> {
    with_regions!(m, improve_compiled(mesh, f, m, lambda, labels, stop, observe))
}

fn improve_compiled<const M: usize>(
    mesh: &Mesh,
    f: &[f64],
    m: usize,
    lambda: f64,
    labels: &mut Labels,
    stop: &Stop,
    observe: Observer<'_>,
) -> Result<()> {
    let rows = |numbers: &[f64], padding: f64| -> Vec<Row<M>> {
        collect(numbers.len() / m, |k| {
            Row::from_fn(|p| if p < m { numbers[k * m + p] } else { padding })
        })
    };
    let f = rows(f, FORBIDDEN_COST);
    let flat =
        |rows: &[Row<M>]| -> Vec<f64> { rows.iter().flat_map(|row| row.0[..m].to_vec()).collect() };
    if lambda == 0.0 {
        labels.u = flat(&cheapest_labels(&f));
        return Ok(());
    }
    let problem = Problem::new(Stencil::new(mesh), f, lambda);
    check_range(&problem)?;
    let start = match labels.u.len() == m * mesh.vertices.len() {
        true => rows(&labels.u, 0.0),
        false => cheapest_labels(&problem.f),
    };
    let dual_start = (labels.q.len() == 2 * m * mesh.faces.len()).then(|| {
        let rows = rows(&labels.q, 0.0);
        rows.chunks(2).map(|pair| Tangent([pair[0], pair[1]])).collect()
    });
    let mut run = Run::new(&start);
    let setup = Setup { domain: mesh.into(), problem: &problem, start, dual_start };
    let mut solver = Method::default().build(setup)?;
    run.advance(&mut *solver, &problem, stop, observe);
    labels.u = flat(run.best_u());
    let q = solver.iterate().q.iter().flat_map(|q| q.0);
    labels.q = flat(&q.collect::<Vec<_>>());
    Ok(())
}
