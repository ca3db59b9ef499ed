//! Implements your own solver: `cargo run --release --no-default-features --example own_solver`.
//!
//! The projected subgradient method with step sizes that decrease like 1 / sqrt(n). The method implements no clock,
//! samples or certificates; the crate provides all of them. Its gap is compared with that of the default solver.

use std::ops::ControlFlow;

use meshseg::field::{Row, Tangent};
use meshseg::mesh::geometry::barycentric_areas;
use meshseg::mesh::source;
use meshseg::operator::{Adjoint, Mass, Operator, Stencil};
use meshseg::problem::Problem;
use meshseg::prox::project_simplex;
use meshseg::run::{Run, Stop};
use meshseg::solver::{Iterate, Method, OneByOne, Setup, Solver, Step};
use meshseg::sweep::sweep;

/// Regions.
const M: usize = 3;

struct Subgradient {
    u: Vec<Row<M>>,
    q: Vec<Tangent<M>>,
    /// The area of each vertex.
    area: Vec<f64>,
    n: u64,
}

impl<K: Operator> Step<K, M> for Subgradient {
    fn step(&mut self, Problem { k, f, lambda, .. }: &Problem<K, M>) {
        self.n += 1;
        let tau = 0.1 / (self.n as f64).sqrt();
        let Self { u, q, area, .. } = self;
        let kt = k.adjoint();
        // q_j = lambda (K u)_j / |(K u)_j|, or 0
        sweep(&mut q[..], |j, q| {
            let ku = k.at(u, j);
            let norm = ku.norm();
            *q = if norm > 0.0 { lambda / norm * ku } else { Tangent::ZERO };
        });
        // u <- Proj_simplex( u - tau D^-1 (f + K^T q) )
        sweep((&mut u[..], &f[..], &area[..]), |v, (u, &f, &d)| {
            *u = project_simplex(*u - tau / d * (f + kt.at(q, v)));
        });
    }

    fn iterate(&self) -> Iterate<'_, M> {
        Iterate { u: &self.u, q: &self.q }
    }
}

fn main() -> meshseg::Result<()> {
    let mesh = source("sphere:4")?;
    let costs: Vec<Row<M>> = (mesh.vertices.iter())
        .map(|x| Row::from_fn(|p| -x[p] + 0.3 * (40.0 * x[(p + 1) % 3]).sin()))
        .collect();
    let f = Mass::Barycentric.on(&mesh).integrate(&costs);
    let problem = Problem::new(Stencil::new(&mesh), f, 0.05);
    let start = vec![Row([1.0 / M as f64; M]); mesh.vertices.len()];

    let stop = Stop { relative_gap: Some(1e-3), iterations: Some(2000), ..Stop::default() };
    let gap = |solver: &mut dyn Solver<Stencil, M>| {
        let mut run = Run::new(&start);
        run.advance(solver, &problem, &stop, &mut |_| ControlFlow::Continue(()));
        let last = run.trace[run.trace.len() - 1];
        println!("{:5} iterations to a certified gap of {:.1e}", last.iteration, last.relative_gap);
        last.relative_gap
    };
    let q = vec![Tangent::ZERO; mesh.faces.len()];
    let own = Subgradient { u: start.clone(), q, area: barycentric_areas(&mesh), n: 0 };
    let own = gap(&mut OneByOne::new(own));
    let setup =
        Setup { domain: (&mesh).into(), problem: &problem, start: start.clone(), dual_start: None };
    let default = gap(&mut *Method::default().build(setup)?);
    assert!(default <= 1e-3 && default <= own && own < 0.5);
    Ok(())
}

#[test]
fn it_runs() {
    main().unwrap();
}
