//! Segments a colored mesh into regions: `cargo run --release --no-default-features --example colored_mesh`.

use std::ops::ControlFlow;

use meshseg::colormap::categorical;
use meshseg::data::input::{self, Mapping};
use meshseg::data::{Initial, PiecewiseConstant};
use meshseg::mesh::{Source, io};
use meshseg::operator::Mass;
use meshseg::run::Stop;
use meshseg::seeds::Seeds;
use meshseg::segment::{Alternation, segment};
use meshseg::solve::Request;
use meshseg::solver::Method;

fn main() -> meshseg::Result<()> {
    let source = Source::parse(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/human/human.ply"))?;
    let mesh = source.mesh()?;
    // Lambda has units of cost times length; with a total area of 1 it means the same for every mesh.
    let scale = mesh.area().sqrt().recip();
    let mesh = mesh.scaled(scale);

    // The mesh's own texture or vertex colors, in [0, 1].
    let input = input::read(&source, &mesh, None, None, &Mapping::default())?;
    println!("{}: {} vertices", input.name, input.data.len());

    let alternation = Alternation {
        regions: 4,
        initial: Initial::KMeans,
        seed: 1,
        every: 10,
        labels: None,
        seeds: Seeds::default(),
    };
    let request = Request {
        lambda: 1e-3,
        relaxation: Default::default(),
        mass: Mass::Barycentric,
        method: Method::default(),
        stop: Stop { relative_gap: Some(1e-3), ..Stop::default() },
        coarse_to_fine: true,
        keep_dual: false,
        rounding: Default::default(),
        label_gap: None,
    };
    let mut go_on = |_: Option<&_>| ControlFlow::Continue(());
    let model = PiecewiseConstant::new(&input.data);
    let segmentation = segment(&mesh, &model, &alternation, &request, &mut go_on)?;

    for (p, region) in segmentation.parameters.iter().enumerate() {
        println!("region {p}: mean color {:.3?}", region.mean);
    }
    let summary = &segmentation.solution.summary;
    println!("relative gap {:.1e}", summary.relative_gap);
    assert!(summary.relative_gap <= 1e-3);

    let labels: Vec<u8> = segmentation.solution.labels.iter().map(|&label| label as u8).collect();
    let palette: Vec<[f64; 3]> = (0..alternation.regions).map(categorical).collect();
    let path = std::env::temp_dir().join("colored_mesh.ply");
    io::write_labeled(&path, &mesh, &labels, None, &palette, &io::Properties::default())?;
    println!("{}", path.display());
    Ok(())
}

#[test]
fn it_runs() {
    main().unwrap();
}
