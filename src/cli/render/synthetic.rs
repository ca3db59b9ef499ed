//! `render MESH --views FILE|sphere:N`: synthetic photographs of a mesh, as a folder that `segment --data views:` reads.

use std::path::Path;

use image::RgbImage;

use crate::colormap::{categorical, sequential};
use crate::counted::counted;
use crate::data::views::synthetic::{Light, Paint, Photograph, Studio};
use crate::data::views::{View, cameras, to_toml};
use crate::domain::Element;
use crate::mesh::{Mesh, Source};
use crate::solve::check_mesh;
use crate::triple::Triple;
use crate::{Error, Result, file, outcome, regions};

use super::arguments::Arguments;
use super::data::Data;
use super::input::labels;
use super::viewpoints::Viewpoints;
use crate::cli::memory::Memory;
use crate::cli::{Outcome, means, note, one_line, print, table, warn};

/// The color of the surface.
enum Colors {
    OfVertices(Vec<[f64; 3]>),
    OfRegions { labels: Vec<usize>, colors: Vec<[f64; 3]> },
}

pub fn run(arguments: &Arguments) -> Outcome {
    let synthetic = &arguments.synthetic;
    check_options(arguments)?;
    let Some(out) = &arguments.out else {
        return Err(Error::unsuitable("name the folder of the photographs with --out DIR").into());
    };
    file::check_folder(out)?;
    let source = Source::parse(&arguments.surface)?;
    let mesh = source.mesh()?;
    check_mesh(&mesh).map_err(|error| error.of_file(&arguments.surface))?;
    let colors = colors(arguments, &source, &mesh)?;
    let (views, warnings) = views(arguments, &mesh)?;
    warn(&warnings);
    let direction = synthetic.light.map(|Triple(direction)| direction);
    let ambient = synthetic.ambient.unwrap_or(if direction.is_some() { 0.0 } else { 1.0 });
    let studio = Studio {
        mesh: &mesh,
        paint: match &colors {
            Colors::OfVertices(colors) => Paint::Vertices(colors),
            Colors::OfRegions { labels, colors } => Paint::Regions { labels, colors },
        },
        light: Light { direction, ambient },
        background: synthetic.background.map_or([0.5; 3], |Triple(color)| color),
        samples: synthetic.samples.map_or(4, usize::from),
        noise: synthetic.noise.unwrap_or(0.0),
        seed: synthetic.noise_seed.unwrap_or(0),
    };
    let mut seen = Vec::new();
    file::write_folder(out, |folder| {
        seen = studio.each(&views, |i, photograph| {
            outcome::write_png(&folder.join(&views[i].image), &image(&photograph))?;
            Ok((photograph.shows_surface, photograph.behind))
        })?;
        if !seen.iter().any(|(shows_surface, _)| *shows_surface) {
            return Err(Error::unsuitable(
                "no view shows the mesh; check that the cameras and the mesh have the same coordinates",
            ));
        }
        file::write(&folder.join("views.toml"), |out| out.write_all(to_toml(&views).as_bytes()))
    })?;
    warn(&unseen(&seen));
    let count = counted(views.len(), "photograph", "photographs");
    print(&table::pairs(&[("views", count), ("written to", out.display().to_string())]))?;
    Ok(())
}

/// Options of pictures do not apply.
fn check_options(arguments: &Arguments) -> Result<()> {
    let given = [
        ("--show", !arguments.show.is_empty()),
        ("--u", arguments.u.is_some()),
        ("--width", arguments.width.is_some()),
        ("--columns", arguments.columns.is_some()),
        ("--transparent", arguments.transparent),
    ];
    if let Some((name, _)) = given.iter().find(|(_, given)| *given) {
        let message =
            format!("{name} does not apply to photographs, which --views with cameras makes");
        return Err(Error::unsuitable(message));
    }
    if arguments.surface.is_dir() {
        let message = "is a folder; photographs are made of a mesh file, builtin:spot or a shape";
        return Err(Error::malformed(&arguments.surface, message));
    }
    match (&arguments.labels, &arguments.data, &arguments.synthetic.means) {
        (Some(_), Some(_), _) => {
            Err(Error::unsuitable("give either --data or --labels: a vertex has one color"))
        }
        (None, _, Some(_)) => Err(Error::unsuitable("--means needs --labels LABELS.npy")),
        _ => Ok(()),
    }
}

fn colors(arguments: &Arguments, source: &Source, mesh: &Mesh) -> Result<Colors> {
    let Some(path) = &arguments.labels else {
        let (data, notes) =
            Data::read(source, mesh, arguments.data.as_ref(), &arguments.mapping())?;
        notes.iter().for_each(|line| note(&one_line(line)));
        return Ok(Colors::OfVertices(of_vertices(data)));
    };
    let labels = labels(path, Element::Vertices, mesh.vertices.len())?;
    let colors = match &arguments.synthetic.means {
        Some(means) => of_means(means)?,
        None => (0..*regions::REGIONS.end()).map(categorical).collect(),
    };
    Ok(Colors::OfRegions { labels, colors })
}

/// Numbers are shown by the color map of pictures, and unknown vertices in gray.
fn of_vertices(data: Data) -> Vec<[f64; 3]> {
    match data {
        Data::Colors(colors) => {
            let known = |color: &[f64; 3]| color.iter().all(|c| !c.is_nan());
            colors.into_iter().map(|c| if known(&c) { c } else { sequential(f64::NAN) }).collect()
        }
        Data::Numbers { values, range: [low, high], .. } => {
            let length = if low < high { high - low } else { 1.0 };
            values.into_iter().map(|t| sequential((t - low) / length)).collect()
        }
    }
}

/// The colors of regions from their parameters.
fn of_means(path: &Path) -> Result<Vec<[f64; 3]>> {
    let color = |(p, parameters): (usize, &serde_json::Value)| {
        let mean = ["mean", "median"].iter().find_map(|key| parameters.get(key)?.as_array());
        let numbers = mean.map(|mean| mean.iter().filter_map(|c| c.as_f64()).collect::<Vec<_>>());
        let color = numbers.and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
        color.filter(|color| color.iter().all(|c| (0.0..=1.0).contains(c))).ok_or_else(|| {
            let message = format!("region {p} has no color: three numbers from 0 to 1");
            Error::malformed(path, message)
        })
    };
    means::read(path, None, &Memory::default())?.parameters.iter().enumerate().map(color).collect()
}

/// The cameras, with the names of their photographs, and what was left out.
fn views(arguments: &Arguments, mesh: &Mesh) -> Result<(Vec<View>, Vec<String>)> {
    match &arguments.views {
        Viewpoints::Named(_) => unreachable!("these are viewpoints of pictures"),
        Viewpoints::Sphere(cameras) => {
            let views = cameras.views(mesh).map_err(|error| error.of_file(&arguments.surface))?;
            Ok((views, Vec::new()))
        }
        Viewpoints::File(path) => {
            let (views, warnings) = cameras(path, arguments.images.as_deref())?;
            let renamed = |(i, view)| View {
                image: format!("view-{i:03}.png"),
                mask: None,
                background: None,
                ..view
            };
            Ok((views.into_iter().enumerate().map(renamed).collect(), warnings))
        }
    }
}

fn image(photograph: &Photograph) -> RgbImage {
    let [width, height] = [photograph.width, photograph.height].map(|n| n as u32);
    let image = RgbImage::from_raw(width, height, photograph.bytes().into_flattened());
    image.expect("three bytes per pixel")
}

/// Views that show nothing, and faces that could not be drawn.
fn unseen(seen: &[(bool, usize)]) -> Vec<String> {
    let mut warnings = Vec::new();
    let blind = seen.iter().filter(|(shows_surface, _)| !shows_surface).count();
    if blind > 0 {
        let first = seen.iter().position(|(shows_surface, _)| !shows_surface).unwrap_or(0);
        let count = counted(blind, "photograph shows", "photographs show");
        warnings.push(format!("{count} nothing of the mesh, first view-{first:03}.png"));
    }
    let cameras = seen.iter().filter(|(_, behind)| *behind > 0).count();
    if cameras > 0 {
        let faces: usize = seen.iter().map(|(_, behind)| behind).sum();
        let faces = counted(faces, "face reaches", "faces reach");
        warnings.push(format!(
            "{faces} behind {} and cannot be seen there",
            counted(cameras, "camera", "cameras")
        ));
    }
    warnings
}
