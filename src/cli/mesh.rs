//! `meshseg mesh info|distance|generate|convert`.

use std::path::{Path, PathBuf};

use crate::counted::counted;
use crate::data::input::density;
use crate::mesh::distance::{Distances, between};
use crate::mesh::shapes::MAX_FACES;
use crate::mesh::{BoundingBox, Mesh, Shape, Source, Statistics, TooFine, io};
use crate::solve::check_mesh;
use crate::{Error, Result};

use super::{Outcome, note, print, print_json, table, warn, welding};

/// Inspect, compare, generate and convert meshes.
#[derive(clap::Subcommand)]
pub enum Verb {
    /// Print counts, topology and defects of a mesh
    Info {
        /// Mesh file, builtin:spot, or a shape such as torus:400x250
        mesh: PathBuf,
        /// Print JSON
        #[arg(long)]
        json: bool,
    },
    /// Print how far apart two surfaces are
    Distance {
        /// Mesh file, builtin:spot, or a shape such as peanut:5
        mesh: PathBuf,
        /// The surface to compare with, such as the truth; distances are relative to the diagonal of its bounding box
        truth: PathBuf,
        /// Print JSON
        #[arg(long)]
        json: bool,
    },
    /// Write a shape: torus:NUxNV (area 1), sphere:LEVEL, ellipsoid:LEVEL, peanut:LEVEL, dent:LEVEL, grid:NXxNY (cells);
    /// .ply and .obj with texture coordinates
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
        /// Number of times each face is split into four; the original vertices keep their indices
        #[arg(long, value_name = "TIMES", default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=8))]
        subdivide: u8,
        /// Divide edges at their midpoints until none is longer than N texels of the image of its material [default N:
        /// 1]; faces without an image stay. The original vertices keep their indices
        #[arg(long, value_name = "N", num_args = 0..=1, default_missing_value = "1", conflicts_with = "subdivide",
              allow_negative_numbers = true)]
        to_texel: Option<f64>,
        /// First merge vertices within this distance of each other into one [default: 0, equal positions only];
        /// vertices are renumbered
        #[arg(long, value_name = "TOLERANCE", num_args = 0..=1, default_missing_value = "0", allow_negative_numbers = true)]
        weld: Option<f64>,
    },
}

pub fn run(verb: &Verb) -> Outcome {
    match verb {
        Verb::Info { mesh, json } => info(mesh, *json),
        Verb::Distance { mesh, truth, json } => distance(mesh, truth, *json),
        Verb::Generate { shape, out } => {
            let shape: Shape = shape.parse()?;
            write(out, &if io::holds_texture(out) { shape.textured() } else { shape.mesh() })
        }
        Verb::Convert { mesh, out, subdivide, to_texel, weld } => {
            let source = Source::parse(mesh)?;
            let mut mesh =
                if io::holds_texture(out) { source.textured_mesh() } else { source.mesh() }?;
            if let Some(tolerance) = *weld {
                mesh = welded(mesh, tolerance)?;
            }
            let faces = (mesh.faces.len() as u64).saturating_mul(4_u64.pow((*subdivide).into()));
            if faces > MAX_FACES {
                return Err(Error::unsuitable(format!(
                    "--subdivide {subdivide}: would give {faces} faces; at most {MAX_FACES} are possible"
                ))
                .into());
            }
            for _ in 0..*subdivide {
                mesh = mesh.subdivided();
            }
            if let Some(most) = *to_texel {
                mesh = resolved(&source, &mesh, most)?;
            }
            write(out, &mesh)
        }
    }
}

/// The mesh with no edge longer than the given number of texels.
fn resolved(source: &Source, mesh: &Mesh, most: f64) -> Result<Mesh> {
    let option = format!("--to-texel {most:?}");
    if !(most > 0.0 && most.is_finite()) {
        return Err(Error::unsuitable(format!("{option}: must be a finite number above 0")));
    }
    let density = density(source, mesh).map_err(|error| {
        Error::unsuitable(format!("{option}: {error}; --subdivide TIMES divides any mesh"))
    })?;
    mesh.subdivided_to_texels(density, most).map_err(|TooFine { possible }| {
        Error::unsuitable(format!(
            "{option}: would give more than {MAX_FACES} faces; --to-texel {possible} is possible"
        ))
    })
}

/// The mesh without coincident vertices and without the faces that collapse when they are merged.
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
        warn(&[counted(
            gone,
            "face collapsed and was left out",
            "faces collapsed and were left out",
        )]);
    }
    Ok(welded)
}

fn write(path: &Path, mesh: &Mesh) -> Outcome {
    io::write(path, mesh)?;
    let (vertices, faces) = (mesh.vertices.len(), mesh.faces.len());
    note(&format!(
        "{}: {}, {}",
        path.display(),
        counted(vertices, "vertex", "vertices"),
        counted(faces, "face", "faces")
    ));
    Ok(())
}

fn info(path: &Path, json: bool) -> Outcome {
    let mesh = Source::parse(path)?.textured_mesh()?;
    warn(welding::shattered(&mesh, "--weld").as_slice());
    let statistics = Statistics::of(&mesh);
    if json {
        print_json(&statistics)?;
    } else {
        print(&table::pairs(&lines(&statistics)))?;
    }
    Ok(())
}

fn distance(mesh: &Path, truth: &Path, json: bool) -> Outcome {
    let read = |path: &Path| -> Result<Mesh> {
        let mesh = Source::parse(path)?.mesh()?;
        check_mesh(&mesh).map_err(|error| error.of_file(path))?;
        Ok(mesh)
    };
    let distances = between(&read(mesh)?, &read(truth)?);
    if json {
        print_json(&distances)?;
        return Ok(());
    }
    let Distances { mean, back, percentile_95, largest } = distances;
    let percent = |share: f64| format!("{:.4} %", 100.0 * share);
    print(&table::pairs(&[
        ("mean distance to the truth", percent(mean)),
        ("mean distance back", percent(back)),
        ("95 % of the area are within", percent(percentile_95)),
        ("largest distance", percent(largest)),
    ]))?;
    Ok(())
}

fn lines(statistics: &Statistics) -> Vec<(&'static str, String)> {
    let counts = [
        ("edges", statistics.edges),
        ("boundary edges", statistics.boundary_edges),
        ("boundary loops", statistics.boundary_loops),
        ("components", statistics.components),
    ];
    let defects = [
        ("non-manifold edges", statistics.non_manifold_edges),
        ("inconsistently oriented edges", statistics.inconsistent_edges),
        ("degenerate faces", statistics.degenerate_faces),
        ("duplicate faces", statistics.duplicate_faces),
        ("unreferenced vertices", statistics.unreferenced_vertices),
        ("coincident vertices", statistics.coincident_vertices),
        ("nearly coincident vertices", statistics.nearly_coincident_vertices),
    ];
    let count = |(name, count): (&'static str, usize)| (name, count.to_string());
    let mut lines =
        [("vertices", statistics.vertices), ("faces", statistics.faces)].map(count).to_vec();
    lines.push(("area", table::common_format(statistics.area, 9)(statistics.area)));
    lines.extend(counts.map(count));
    lines.push(("Euler characteristic", statistics.euler_characteristic.to_string()));
    lines.extend(defects.map(count));
    lines
        .push(("bounding box", statistics.bounding_box.as_ref().map_or_else(String::new, corners)));
    lines.extend(looks(statistics));
    lines
}

fn corners(bounding_box: &BoundingBox) -> String {
    let BoundingBox { min, max } = bounding_box;
    let number = table::common_format(table::largest(min.iter().chain(max)), 6);
    let point = |x: &[f64; 3]| format!("({})", x.map(&number).join(", "));
    format!("{} to {}", point(min), point(max))
}

fn looks(statistics: &Statistics) -> [(&'static str, String); 4] {
    let yes_or_no = |yes: bool| if yes { "yes" } else { "no" }.to_owned();
    let materials = match statistics.materials {
        0 => "none".to_owned(),
        materials => format!("{materials}, {} with an image", statistics.materials_with_images),
    };
    [
        ("vertex colors", yes_or_no(statistics.has_colors)),
        ("face colors", yes_or_no(statistics.has_face_colors)),
        ("texture coordinates", yes_or_no(statistics.has_uv)),
        ("materials", materials),
    ]
}
