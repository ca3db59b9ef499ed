//! `meshseg mesh info|generate|convert`.

use std::path::{Path, PathBuf};

use meshseg::mesh::shapes::MOST_FACES;
use meshseg::mesh::{Mesh, Shape, Source, Statistics, io};
use meshseg::{Error, Result};

use super::{Outcome, note, print, print_json, table, warn, welding};

/// Look at, make, and convert meshes.
#[derive(clap::Subcommand)]
pub enum Verb {
    /// Print counts, topology and defects of a mesh
    Info {
        /// Mesh file, builtin:spot, or a shape such as torus:400x250
        mesh: PathBuf,
        /// As JSON
        #[arg(long)]
        json: bool,
    },
    /// Write a shape: torus:NUxNV (area 1), sphere:LEVEL, grid:NXxNY (cells); .ply and .obj with texture coordinates
    Generate {
        /// For example torus:400x250, sphere:6, grid:100x100
        shape: String,
        /// .ply, .obj, .off or .stl
        #[arg(long, value_name = "FILE")]
        out: PathBuf,
    },
    /// Write a mesh in another format, in the same vertex order
    Convert {
        /// Mesh file, builtin:spot, or a shape such as torus:400x250
        mesh: PathBuf,
        /// .ply, .obj, .off or .stl
        #[arg(long, value_name = "FILE")]
        out: PathBuf,
        /// Split each face into four, so many times; old vertices keep their numbers
        #[arg(long, value_name = "TIMES", default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=8))]
        subdivide: u8,
        /// Merge vertices within this length of each other onto the first of them [default: 0, those at equal
        /// positions], before all else; vertices are renumbered
        #[arg(long, value_name = "TOLERANCE", num_args = 0..=1, default_missing_value = "0", allow_negative_numbers = true)]
        weld: Option<f64>,
    },
}

pub fn run(verb: &Verb) -> Outcome {
    match verb {
        Verb::Info { mesh, json } => info(mesh, *json),
        Verb::Generate { shape, out } => {
            let shape: Shape = shape.parse()?;
            write(out, &if io::holds_texture(out) { shape.textured() } else { shape.mesh() })
        }
        Verb::Convert { mesh, out, subdivide, weld } => {
            let source = Source::parse(mesh)?;
            let mut mesh =
                if io::holds_texture(out) { source.textured_mesh() } else { source.mesh() }?;
            if let Some(tolerance) = *weld {
                mesh = welded(mesh, tolerance)?;
            }
            let faces = (mesh.faces.len() as u64).saturating_mul(4_u64.pow((*subdivide).into()));
            if faces > MOST_FACES {
                return Err(Error::unsuitable(format!(
                    "--subdivide {subdivide}: would give {faces} faces; at most {MOST_FACES} are possible"
                ))
                .into());
            }
            for _ in 0..*subdivide {
                mesh = mesh.subdivided();
            }
            write(out, &mesh)
        }
    }
}

/// The mesh without coincident vertices, and without the faces that collapsed with them.
fn welded(mesh: Mesh, tolerance: f64) -> Result<Mesh> {
    let weld = welding::weld(&mesh, tolerance)?;
    note(&welding::note(weld.as_ref(), tolerance));
    warn(&welding::aftermath(&mesh, weld.as_ref()));
    let Some(weld) = weld else { return Ok(mesh) };
    let mut welded = weld.mesh;
    let collapsed = |j: usize| {
        let [a, b, c] = welded.faces[j];
        let [x, y, z] = mesh.faces[j];
        (a == b || b == c || c == a) && x != y && y != z && z != x
    };
    let keep: Vec<bool> = (0..mesh.faces.len()).map(|j| !collapsed(j)).collect();
    let gone = keep.iter().filter(|&&kept| !kept).count();
    if gone > 0 {
        welded.retain_faces(&keep);
        warn(&[format!("{gone} faces collapsed and were left out")]);
    }
    Ok(welded)
}

fn write(path: &Path, mesh: &Mesh) -> Outcome {
    io::write(path, mesh)?;
    let (vertices, faces) = (mesh.vertices.len(), mesh.faces.len());
    note(&format!("{}: {vertices} vertices, {faces} faces", path.display()));
    Ok(())
}

fn info(path: &Path, json: bool) -> Outcome {
    let mesh = Source::parse(path)?.textured_mesh()?;
    warn(welding::shattered(&mesh, "--weld").as_slice());
    let statistics = Statistics::of(&mesh);
    if json {
        print_json(&statistics)?;
        return Ok(());
    }
    let Statistics {
        vertices,
        faces,
        area,
        edges,
        boundary_edges,
        boundary_loops,
        components,
        euler_characteristic,
        non_manifold_edges,
        inconsistent_edges,
        degenerate_faces,
        duplicate_faces,
        unreferenced_vertices,
        coincident_vertices,
        nearly_coincident_vertices,
        bounding_box,
        has_colors,
        has_face_colors,
        has_uv,
        materials,
        materials_with_images,
    } = statistics;
    let yes_or_no = |yes: bool| if yes { "yes" } else { "no" }.to_owned();
    let painted = match materials {
        0 => "none".to_owned(),
        _ => format!("{materials}, {materials_with_images} with an image"),
    };
    let corners = bounding_box.map_or_else(String::new, |corners| {
        let number = table::together(table::largest(corners.min.iter().chain(&corners.max)), 6);
        let point = |x: [f64; 3]| format!("({})", x.map(&number).join(", "));
        format!("{} to {}", point(corners.min), point(corners.max))
    });
    print(&table::pairs(&[
        ("vertices", vertices.to_string()),
        ("faces", faces.to_string()),
        ("area", table::together(area, 9)(area)),
        ("edges", edges.to_string()),
        ("boundary edges", boundary_edges.to_string()),
        ("boundary loops", boundary_loops.to_string()),
        ("components", components.to_string()),
        ("Euler characteristic", euler_characteristic.to_string()),
        ("non-manifold edges", non_manifold_edges.to_string()),
        ("inconsistently oriented edges", inconsistent_edges.to_string()),
        ("degenerate faces", degenerate_faces.to_string()),
        ("duplicate faces", duplicate_faces.to_string()),
        ("unreferenced vertices", unreferenced_vertices.to_string()),
        ("coincident vertices", coincident_vertices.to_string()),
        ("nearly coincident vertices", nearly_coincident_vertices.to_string()),
        ("bounding box", corners),
        ("vertex colors", yes_or_no(has_colors)),
        ("face colors", yes_or_no(has_face_colors)),
        ("texture coordinates", yes_or_no(has_uv)),
        ("materials", painted),
    ]))?;
    Ok(())
}
