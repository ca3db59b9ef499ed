//! From your own costs to certified labels: `cargo run --release --no-default-features --example own_costs`.

use std::ops::ControlFlow;

use meshseg::mesh::source;
use meshseg::operator::Mass;
use meshseg::run::Stop;
use meshseg::solve::{Request, solve};
use meshseg::solver::chambolle_pock::{self, Precision};
use meshseg::start::Start;
use ndarray::Array2;

fn main() -> meshseg::Result<()> {
    // A shape or the path of a file.
    let mesh = source("sphere:5")?;

    // The cost of label p at vertex k, an entry of a V x m array: here the squared distance to its pole.
    // `f64::INFINITY` forbids a label; a row of NaN means that nothing is known about the vertex.
    let poles = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let costs = Array2::from_shape_fn((mesh.vertices.len(), poles.len()), |(k, p)| {
        (0..3).map(|i| (mesh.vertices[k][i] - poles[p][i]).powi(2)).sum()
    });

    let request = Request {
        // The weight of the boundary length relative to the integrated costs.
        lambda: 0.1,
        relaxation: Default::default(),
        mass: Mass::Barycentric,
        // Iterates in single precision need half the memory; certificates use double precision.
        method: chambolle_pock::Settings { precision: Precision::Single, ..Default::default() }
            .into(),
        stop: Stop { relative_gap: Some(1e-4), ..Stop::default() },
        coarse_to_fine: true,
        keep_dual: false,
        rounding: Default::default(),
        label_gap: None,
    };
    let mut go_on = |_: Option<&_>| ControlFlow::Continue(());
    let solution = solve(&mesh, &costs, &Start::Uniform, &request, &mut go_on)?;

    let summary = &solution.summary;
    println!("{} after {} iterations", summary.status_sentence, summary.iterations);
    println!("{:.6} <= E* <= {:.6}", summary.dual_bound, summary.energy);
    println!("labels are at most {:.2} % above any", 100.0 * summary.rounded_relative_gap);
    for p in 0..poles.len() {
        let count = solution.labels.iter().filter(|&&label| label == p as i32).count();
        println!("region {p}: {count} vertices");
    }
    assert!(summary.relative_gap <= 1e-4 && summary.empty_regions.is_empty());
    Ok(())
}

#[test]
fn it_runs() {
    main().unwrap();
}
