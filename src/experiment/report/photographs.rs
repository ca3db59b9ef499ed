//! Figures of photographs: silhouettes and cuts of reconstructed surfaces, as each run kept them, one run below the other.

use std::path::Path;

use super::super::figures::FigureSpec;
use super::super::store::PHOTOGRAPHS;
use super::caption;
use super::page::PageFigure;
use super::pool::{Cell, Pool};
use super::written::{WrittenFigures, write_sources};
use crate::error::{Error, Result};
use crate::file;
use crate::outcome::write_png;
use crate::render::photographs::below_each_other;

/// Writes the photographs of the cells as a PNG file. Without any the figure stays as it is.
///
/// # Errors
/// A file is not an image, or one cannot be written.
pub fn write(
    pool: &Pool<'_>,
    cells: &[&Cell<'_>],
    figure: &FigureSpec,
    folder: &Path,
    written: &mut WrittenFigures,
) -> Result<()> {
    let (mut images, mut sources) = (Vec::new(), Vec::new());
    for cell in cells.iter().filter(|cell| pool.solver(cell).task.evolution().is_some()) {
        for &run in &cell.runs {
            let path = run.folder.join(PHOTOGRAPHS);
            if path.is_file() {
                let image = image::load_from_memory(&file::read(&path)?);
                let image = image.map_err(|error| Error::malformed(&path, error.to_string()))?;
                images.push(image.into_rgb8());
                sources.push(run);
            }
        }
    }
    let path = folder.join(format!("{}.png", figure.name));
    if images.is_empty() {
        written.kept.push(format!(
            "{} {}: it needs {PHOTOGRAPHS} of the runs; `meshseg experiment run --force` makes them",
            path.display(),
            if path.is_file() { "is unchanged" } else { "is left out" }
        ));
        if !path.is_file() {
            return Ok(());
        }
    } else {
        write_png(&path, &below_each_other(&images))?;
        write_sources(folder, &figure.name, &sources)?;
        caption::write(folder, &figure.name, &caption::of_pictures(pool, figure, &sources))?;
    }
    written.shown.push(PageFigure::picture(figure, &path)?);
    written.paths.push(path);
    Ok(())
}
