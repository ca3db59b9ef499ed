//! `meshseg render`: pictures for papers, or a page in 3-D, of a mesh or of the result of a run; synthetic photographs of a
//! mesh, and the photographs of a run with its cut.

mod arguments;
mod data;
mod input;
mod mesh;
mod photographs;
mod run_folder;
mod synthetic;
mod viewpoints;

use crate::render::Views;
use crate::render::panels::{Panel, Panels, Shown};
use crate::{Error, Result, file, sweep};

use super::{Outcome, note, one_line, print, table};
pub use arguments::Arguments;
use input::Input;
use viewpoints::Viewpoints;

pub fn run(arguments: &Arguments) -> Outcome {
    sweep::with_threads(arguments.threads.map(usize::from), || run_here(arguments))?
}

fn run_here(arguments: &Arguments) -> Outcome {
    if arguments.photographs {
        return photographs::run(arguments);
    }
    match &arguments.views {
        Viewpoints::Named(views) => picture(arguments, views),
        Viewpoints::Sphere(_) | Viewpoints::File(_) => synthetic::run(arguments),
    }
}

fn picture(arguments: &Arguments, views: &Views) -> Outcome {
    arguments.synthetic.check_unused()?;
    check_out(arguments)?;
    let folder = arguments.surface.is_dir();
    let input = if folder { run_folder::read(arguments) } else { mesh::read(arguments) }?;
    input.notes.iter().for_each(|line| note(&one_line(line)));
    let drawn = drawn(&input, views, arguments)?;
    let out = arguments.out();
    file::write(out, |out| out.write_all(&drawn))?;
    print(&table::pairs(&[("written to", out.display().to_string())]))?;
    Ok(())
}

fn check_out(arguments: &Arguments) -> Result<()> {
    if is_page(arguments) || arguments.out_ends_in("png") {
        return Ok(());
    }
    let out = arguments.out().display();
    let message = format!("{out}: name a file that ends in .png or .html with --out");
    Err(Error::unsuitable(message))
}

/// Whether the output is a page, not a picture.
fn is_page(arguments: &Arguments) -> bool {
    arguments.out_ends_in("html")
}

fn drawn(input: &Input, views: &Views, arguments: &Arguments) -> Result<Vec<u8>> {
    let shown = if arguments.show.is_empty() { input.default() } else { arguments.show.clone() };
    let surface = input.surface();
    for &shown in &shown {
        input.check(&surface, shown)?;
    }
    let panel = |shown: &Shown| Panel { surface: 0, shown: *shown, caption: Some(shown.caption()) };
    let panels = Panels {
        surfaces: &[surface],
        panels: &shown.iter().map(panel).collect::<Vec<_>>(),
        views: &views.0,
        columns: arguments.columns.map(|n| usize::from(n).min(shown.len())),
        row_headings: &[],
        column_headings: &[],
        width: arguments.width.unwrap_or_default(),
        transparent: arguments.transparent,
    };
    if is_page(arguments) {
        let title = one_line(&arguments.surface.display().to_string());
        let program = concat!("meshseg ", env!("CARGO_PKG_VERSION"));
        return Ok(panels.html(&title, program)?.into_bytes());
    }
    panels.png()
}
