//! `meshseg render`: pictures for papers, or a page in 3-D, of a mesh or of the result of a run.

mod arguments;
mod data;
mod input;
mod mesh;
mod run_folder;

use std::path::Path;

use meshseg::render::panels::{Panel, Panels, Shown};
use meshseg::{Error, Result, file, sweep};

use super::{Outcome, note, one_line, print, table};
use input::Input;

pub use arguments::Arguments;

pub fn run(arguments: &Arguments) -> Outcome {
    sweep::with_threads(arguments.threads.map(usize::from), || run_here(arguments))?
}

fn run_here(arguments: &Arguments) -> Outcome {
    check_out(&arguments.out)?;
    let folder = arguments.surface.is_dir();
    let input = if folder { run_folder::read(arguments) } else { mesh::read(arguments) }?;
    input.notes.iter().for_each(|line| note(&one_line(line)));
    let drawn = drawn(&input, arguments)?;
    file::write(&arguments.out, |out| out.write_all(&drawn))?;
    print(&table::pairs(&[("written to", arguments.out.display().to_string())]))?;
    Ok(())
}

fn check_out(path: &Path) -> Result<()> {
    if is_page(path) || ends_in(path, "png") {
        return Ok(());
    }
    let message = format!("{}: name a file that ends in .png or .html with --out", path.display());
    Err(Error::unsuitable(message))
}

/// Whether the output is a page, not a picture.
fn is_page(path: &Path) -> bool {
    ends_in(path, "html")
}

fn ends_in(path: &Path, end: &str) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(end))
}

fn drawn(input: &Input, arguments: &Arguments) -> Result<Vec<u8>> {
    let shown = if arguments.show.is_empty() { input.default() } else { arguments.show.clone() };
    let surface = input.surface();
    for &shown in &shown {
        input.check(&surface, shown)?;
    }
    let panel = |shown: &Shown| Panel { surface: 0, shown: *shown, caption: Some(shown.caption()) };
    let panels = Panels {
        surfaces: &[surface],
        panels: &shown.iter().map(panel).collect::<Vec<_>>(),
        views: &arguments.views.0,
        columns: arguments.columns.map(|n| usize::from(n).min(shown.len())),
        row_headings: &[],
        column_headings: &[],
        width: arguments.width.unwrap_or_default(),
        transparent: arguments.transparent,
    };
    if is_page(&arguments.out) {
        let title = one_line(&arguments.surface.display().to_string());
        let program = concat!("meshseg ", env!("CARGO_PKG_VERSION"));
        return Ok(panels.html(&title, program)?.into_bytes());
    }
    panels.png()
}
