//! `report.html`: the data of an experiment inside the page that shows them, one file that needs no network.

use std::collections::BTreeMap;
use std::path::Path;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value, json};

use super::super::figures::FigureSpec;
use super::super::results::{Done, Point};
use super::super::store::{MAX_SHOWN_VERTICES, Store};
use super::caption;
use super::draw::Drawn;
use super::pool::{Cell, Pool};
use super::table::{Table, TableEntry};
use crate::classes::carry::labels_of_vertices;
use crate::domain::Element;
use crate::error::{Error, Result};
use crate::file;
use crate::mesh::{Mesh, io};
use crate::render::web;

/// Maximum number of rows of a trace that are shown; a screen cannot resolve more.
const MAX_TRACE_POINTS: usize = 600;

/// The content of the page in addition to the runs.
pub struct PageContent<'a> {
    pub figures: Vec<PageFigure>,
    pub tables: &'a [Table<'a>],
    pub program: &'a str,
    pub written: String,
}

pub struct PageFigure {
    title: String,
    caption: String,
    svg: String,
    /// The stem of its files.
    stem: String,
    /// The page of its surfaces, relative to the page of the report.
    surfaces: Option<String>,
}

impl PageFigure {
    pub fn drawn(figure: &FigureSpec, drawn: &Drawn<'_>) -> Result<Self> {
        Ok(PageFigure::new(figure, crate::figure::svg(&drawn.figure)?, drawn.caption.clone()))
    }

    /// A figure that was not drawn again.
    pub fn kept(figure: &FigureSpec, path: &Path) -> Result<Self> {
        let svg = String::from_utf8(file::read(path)?)
            .map_err(|error| Error::malformed(path, error.to_string()))?;
        Ok(PageFigure::new(
            figure,
            svg,
            caption::kept(path.parent().unwrap_or(Path::new("")), &figure.name)?,
        ))
    }

    /// A picture in a PNG file.
    pub fn picture(figure: &FigureSpec, path: &Path) -> Result<Self> {
        let bytes = file::read(path)?;
        let decoder = png::Decoder::new(std::io::Cursor::new(&bytes[..]));
        let reader =
            decoder.read_info().map_err(|error| Error::malformed(path, error.to_string()))?;
        let (width, height) = (reader.info().width, reader.info().height);
        // 300 pixels per inch, 96 CSS pixels per inch.
        let [shown_width, shown_height] = [width, height].map(|x| f64::from(x) * 96.0 / 300.0);
        let data = BASE64_STANDARD.encode(&bytes);
        let svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{shown_width}\" height=\"{shown_height}\" \
             viewBox=\"0 0 {width} {height}\"><image width=\"{width}\" height=\"{height}\" \
             href=\"data:image/png;base64,{data}\"/></svg>"
        );
        let page = path.with_extension("html");
        let surfaces = page.is_file().then(|| format!("figures/{}.html", figure.name));
        let caption = caption::kept(path.parent().unwrap_or(Path::new("")), &figure.name)?;
        Ok(PageFigure { surfaces, ..PageFigure::new(figure, svg, caption) })
    }

    /// A picture that is not drawn.
    pub fn unseen(figure: &FigureSpec, caption: String) -> Self {
        PageFigure::new(figure, String::new(), caption)
    }

    fn new(figure: &FigureSpec, svg: String, caption: String) -> Self {
        PageFigure {
            title: figure.title.as_ref().unwrap_or(&figure.name).clone(),
            caption,
            svg,
            stem: figure.name.clone(),
            surfaces: None,
        }
    }

    pub fn stem(&self) -> &str {
        &self.stem
    }

    pub fn caption(&self) -> &str {
        &self.caption
    }

    fn json(&self) -> Value {
        let PageFigure { title, caption, svg, stem, surfaces } = self;
        // The page shows the title, with which the caption starts, above the figure.
        let more =
            caption.strip_prefix(&title[..]).unwrap_or(caption).trim_start_matches(['.', ' ']);
        json!({ "title": title, "caption": more, "svg": svg, "stem": stem, "surfaces": surfaces })
    }
}

/// The page as HTML.
///
/// # Errors
/// A surface cannot be read.
pub fn page(pool: &Pool<'_>, store: &Store, content: &PageContent<'_>) -> Result<String> {
    let hosts = hosts(pool);
    let machines = hosts.iter().enumerate().map(|(h, (host, run))| {
        let machine = &run.manifest.machine;
        json!({
            "id": format!("m{h}"), "cpu": machine.cpu, "cores": machine.cores,
            "memory_gib": machine.memory_gib, "first": *host == pool.host,
        })
    });
    let solvers = pool.spec.solvers.iter().enumerate();
    let solvers = solvers
        .map(|(s, solver)| json!({ "id": format!("s{s}"), "label": solver.label, "style": s }));
    let runs = pool.cells.iter().flat_map(|cell| {
        let host =
            |run: &Done| hosts.iter().position(|(host, _)| *host == run.manifest.machine.host);
        cell.runs.iter().map(move |run| run_json(pool, cell, run, host(run)))
    });
    let (instances, scenes) = instances(pool, store)?;
    let data = json!({
        "name": pool.spec.name, "question": pool.spec.question, "program": content.program,
        "written": content.written, "machines": machines.collect::<Vec<_>>(),
        "solvers": solvers.collect::<Vec<_>>(), "instances": instances, "runs": runs.collect::<Vec<_>>(),
        "tables": content.tables.iter().map(table_json).collect::<Vec<_>>(),
        "figures": content.figures.iter().map(PageFigure::json).collect::<Vec<_>>(), "scenes": scenes,
    });
    Ok(web::page(&data))
}

/// The hosts in the order of the runs, each with its first run.
fn hosts<'a>(pool: &Pool<'a>) -> Vec<(&'a str, &'a Done)> {
    let mut hosts: Vec<(&str, &Done)> = Vec::new();
    for run in pool.runs() {
        let host = run.manifest.machine.host.as_str();
        if hosts.iter().all(|(known, _)| *known != host) {
            hosts.push((host, run));
        }
    }
    hosts
}

/// The instances that have runs, and the scenes of those whose surface was kept, by their ids.
fn instances(pool: &Pool<'_>, store: &Store) -> Result<(Vec<Value>, BTreeMap<String, Value>)> {
    let (mut instances, mut scenes) = (Vec::new(), BTreeMap::new());
    for (i, instance) in pool.spec.instances.iter().enumerate() {
        // Runs with the costs of the instance have a common bound.
        let of_instance =
            || pool.cells.iter().filter(|cell| cell.instance == i && !cell.runs.is_empty());
        let solved = of_instance().find(|cell| pool.solver(cell).task.has_fixed_costs());
        let Some(cell) = solved.or_else(|| of_instance().next()) else { continue };
        let (run, peers) = (cell.runs[0], pool.peers(cell));
        let labels = run.summary.labels();
        let scene = scene(pool, store, i, run)?;
        let id = format!("g{i}");
        instances.push(json!({
            "id": format!("i{i}"), "label": instance.label, "mesh": instance.mesh,
            "vertices": run.summary.vertices(), "faces": run.summary.faces(), "regions": run.summary.regions(),
            "lambda": labels.map(|summary| summary.lambda), "mass": labels.map(|summary| &summary.mass),
            "best_bound": peers.bound(), "best_energy": peers.energy(), "scene": scene.is_some().then_some(&id),
        }));
        if let Some(mut scene) = scene {
            share_mesh(&mut scene, &scenes);
            scenes.insert(id, scene);
        }
    }
    Ok((instances, scenes))
}

fn run_json<'a>(pool: &Pool<'a>, cell: &Cell<'a>, run: &Done, host: Option<usize>) -> Value {
    let step = run.trace.len().div_ceil(MAX_TRACE_POINTS).max(1);
    let last = run.trace.len().saturating_sub(1);
    let points = run.trace.iter().enumerate().filter(|(i, _)| i % step == 0 || *i == last);
    let points: Vec<&Point> = points.map(|(_, point)| point).collect();
    let peers = pool.peers(cell);
    let labels = run.summary.labels();
    let column = |value: &dyn Fn(&Point) -> Option<f64>| -> Vec<Option<f64>> {
        points.iter().map(|point| value(point)).collect()
    };
    json!({
        "id": run.manifest.id, "instance": format!("i{}", cell.instance), "solver": format!("s{}", cell.solver),
        "repetition": run.manifest.repetition, "machine": host.map(|host| format!("m{host}")),
        "loaded": run.manifest.loaded, "status": run.summary.status(),
        "iterations": run.summary.iterations(), "seconds": run.summary.seconds(),
        "energy": run.summary.energy(), "dual_bound": labels.map(|summary| summary.dual_bound),
        "relative_gap": labels.map(|summary| summary.relative_gap), "manifest": flat(run),
        "trace": {
            "iteration": column(&|point| Some(point.iteration as f64)), "seconds": column(&|point| Some(point.seconds)),
            "energy": column(&|point| Some(point.energy)), "relative_gap": column(&|point| point.relative_gap),
            "suboptimality": column(&|point| Some(peers.suboptimality(point.energy))),
            "distance": column(&|point| point.distance), "mislabeled": column(&|point| point.mislabeled),
            "silhouette_iou": column(&|point| point.silhouette_iou),
        },
    })
}

fn table_json(table: &Table<'_>) -> Value {
    let column = |(i, label)| json!({ "label": label, "numeric": table.is_numeric(i) });
    let entry = |entry: &TableEntry| match entry {
        TableEntry::Number(x) => json!(x),
        TableEntry::Nothing => Value::Null,
        entry => json!(entry.text()),
    };
    let row = |row: &Vec<TableEntry>| row.iter().map(entry).collect::<Value>();
    json!({
        "title": table.title,
        "columns": table.columns.iter().enumerate().map(column).collect::<Value>(),
        "rows": table.rows.iter().map(row).collect::<Value>(),
    })
}

/// The manifest with one level of keys.
fn flat(run: &Done) -> Value {
    let manifest = serde_json::to_value(&run.manifest).expect("it came from JSON");
    let mut all = serde_json::Map::new();
    for (key, value) in manifest.as_object().expect("a table of keys") {
        match value.as_object() {
            Some(inner) => all
                .extend(inner.iter().map(|(name, value)| (format!("{key}.{name}"), value.clone()))),
            None => drop(all.insert(key.clone(), value.clone())),
        }
    }
    Value::Object(all)
}

/// Removes positions and faces that another scene on the page already has, and refers to it instead.
fn share_mesh(scene: &mut Value, scenes: &BTreeMap<String, Value>) {
    let same = |other: &Value| ["positions", "faces"].iter().all(|key| other[key] == scene[key]);
    let Some(first) = scenes.iter().find_map(|(id, other)| same(other).then(|| id.clone())) else {
        return;
    };
    let scene = scene.as_object_mut().expect("a scene is a table of keys");
    scene.remove("positions");
    scene.remove("faces");
    scene.insert("mesh".into(), first.into());
}

/// The surface of an instance with its data and the kept labels of its solvers.
fn scene(pool: &Pool<'_>, store: &Store, instance: usize, run: &Done) -> Result<Option<Value>> {
    let path = store.folder.join("instances").join(format!("{}.ply", run.manifest.instance_id));
    if !path.exists() {
        return Ok(None);
    }
    let mesh = io::read(&path)?;
    if mesh.vertices.len() > MAX_SHOWN_VERTICES {
        return Ok(None);
    }
    let Some(colors) = &mesh.colors else { return Ok(None) };
    let encode = |bytes: &[u8]| BASE64_STANDARD.encode(bytes);
    let mut solutions = serde_json::Map::new();
    for cell in pool.cells.iter().filter(|cell| cell.instance == instance) {
        let kept = cell.runs.iter().find_map(|run| run.labels.as_ref().zip(run.certainty.as_ref()));
        if let Some((labels, certainty)) = kept {
            let [labels, certainty] = match run.on() {
                Element::Vertices => [encode(labels), encode(certainty)],
                Element::Faces => {
                    let labels = at_vertices(&mesh, labels, run.summary.regions());
                    [encode(&labels), encode(&vec![u8::MAX; labels.len()])]
                }
            };
            solutions.insert(
                format!("s{}", cell.solver),
                json!({ "labels": labels, "certainty": certainty }),
            );
        }
    }
    if solutions.is_empty() {
        return Ok(None);
    }
    // The page centers the surface anyway; single precision is not enough for large map coordinates.
    let first = mesh.vertices[0];
    let positions: Vec<u8> = mesh
        .vertices
        .iter()
        .map(|x| x - first)
        .flat_map(|x| [x.x, x.y, x.z])
        .flat_map(|x| (x as f32).to_le_bytes())
        .collect();
    let faces: Vec<u8> = mesh.faces.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
    let data: Vec<u8> = colors.iter().flatten().map(|c| (255.0 * c).round() as u8).collect();
    let palette: Vec<[f64; 3]> =
        (0..run.summary.regions()).map(crate::colormap::categorical).collect();
    let [towards, up] = crate::render::default_view(&mesh);
    Ok(Some(json!({
        "positions": encode(&positions), "faces": encode(&faces), "data": encode(&data),
        "palette": palette, "solutions": solutions, "view": { "towards": towards, "up": up },
    })))
}

/// Labels of faces as the page shows them.
fn at_vertices(mesh: &Mesh, labels: &[u8], m: usize) -> Vec<u8> {
    let labels = labels.iter().map(|&p| i32::from(p)).collect();
    labels_of_vertices(mesh, &labels, m).into_iter().map(|p| p as u8).collect()
}
