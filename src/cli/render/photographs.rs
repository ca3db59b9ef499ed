//! `render RUN --photographs`: the photographs that a run segmented, with its cut.

use std::path::{Path, PathBuf};

use crate::counted::counted;
use crate::data::input::DataSource;
use crate::data::views::ViewFolder;
use crate::mesh::io;
use crate::render::photographs::RegionsInViews;
use crate::{Error, Result, file, npy, outcome, regions, sweep};

use super::arguments::Arguments;
use super::run_folder;
use crate::cli::{Outcome, note, print, table, warn};

pub fn run(arguments: &Arguments) -> Outcome {
    arguments.synthetic.check_unused()?;
    let out = arguments.out();
    let as_sheet = arguments.out_ends_in("png");
    if arguments.out_ends_in("html") {
        let message = "photographs are a .png file, or a folder; name one of them with --out";
        return Err(Error::malformed(out, message).into());
    }
    if !as_sheet {
        file::check_folder(out)?;
    }
    let run = arguments.surface.as_path();
    let mesh = io::read(&run_folder::mesh(run)?)?;
    let file = views(arguments)?;
    let path = run.join("u.npy");
    let u = npy::read_matrix(&path)?;
    npy::check_rows(&path, &u, mesh.vertices.len())?;
    regions::check(u.ncols()).map_err(|error| error.of_file(&path))?;
    let folder = ViewFolder::open(&file, arguments.images.as_deref())?;
    warn(&folder.warnings);
    if arguments.data.is_none() {
        note(&format!("the views are read again: views:{}", file.display()));
    }
    let m = u.ncols();
    let u: Vec<f64> = u.as_standard_layout().iter().copied().collect();
    let drawn = RegionsInViews::new(&mesh, &u, m);
    let mut written = vec![("written to", out.display().to_string())];
    if as_sheet {
        outcome::write_png(out, &drawn.sheet(&folder)?)?;
    } else {
        file::write_folder(out, |to| write_each(to, &folder, &drawn))?;
        let count = counted(folder.views.len(), "photograph", "photographs");
        written.insert(0, ("views", count));
    }
    print(&table::pairs(&written))?;
    Ok(())
}

/// The file of the views: the given one, or that of the run.
fn views(arguments: &Arguments) -> Result<PathBuf> {
    let run = &arguments.surface;
    let summary = match &arguments.data {
        Some(DataSource::Views(file)) => return Ok(file.clone()),
        Some(_) => return Err(Error::unsuitable("--photographs needs --data views:FILE")),
        None => run_folder::json(&run.join("summary.json"))?,
    };
    let data = summary.get("data").and_then(|data| data.as_str());
    let file = data.and_then(|data| data.strip_prefix("views ")).map(PathBuf::from);
    let message = match file {
        Some(file) if file.exists() => return Ok(file),
        Some(file) => {
            let file = file.display();
            format!(
                "segmented the views {file}, which are not there; name them with --data views:FILE"
            )
        }
        None => "did not segment views; name some of its mesh with --data views:FILE".into(),
    };
    Err(Error::malformed(run, message))
}

/// `regions-000.png`, ..., in the order of the views: no names of photographs, which may be in the same folder.
fn write_each(to: &Path, folder: &ViewFolder, drawn: &RegionsInViews) -> Result<()> {
    let write = |i: usize| {
        let image = drawn.draw(&folder.views[i].camera, &folder.picture(i)?);
        outcome::write_png(&to.join(format!("regions-{i:03}.png")), &image)
    };
    sweep::results((0..folder.views.len()).collect(), write).into_iter().collect()
}
