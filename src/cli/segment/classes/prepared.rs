//! What is read for classes: the surface that counts, the costs on it, and what else bears on the labels.

use ndarray::Array2;

use crate::Result;
use crate::classes::{ClassCosts, most_probable};
use crate::domain::Element;
use crate::mesh::Source;
use crate::mesh::contrast::Contrast;
use crate::operator::Mass;
use crate::relaxation::Relaxation;
use crate::seeds::Seeds;

use super::arguments::{ClassArguments, Given};
use super::contrast;
use super::input::Input;
use super::list::{self, Class};
use super::mask::Mask;
use crate::cli::segment::arguments::Arguments;
use crate::cli::segment::surface::Surface;
use crate::cli::{pairs, seeds, welding};

/// A problem of classes.
pub struct Prepared {
    /// The mesh of the file, and what counts of it.
    pub mask: Mask,
    /// What counts.
    pub surface: Surface,
    /// As in the file.
    pub input: Input,
    pub list: Vec<Class>,
    /// Where the labels are.
    pub on: Element,
    /// The relaxation of weighted pairs, if there are such weights.
    pub metric: Option<Relaxation>,
    /// On the vertices or faces of the welded mesh, as the labels.
    pub seeds: Seeds,
    pub contrast: Option<Contrast>,
    /// On the welded mesh, as given.
    pub costs: ClassCosts,
    /// On the welded mesh, as the labels.
    pub s: Array2<f64>,
}

impl Prepared {
    /// Reads the files.
    ///
    /// # Errors
    /// A file cannot be read, is malformed, or does not fit the mesh.
    pub fn read(arguments: &Arguments, given: &Given) -> Result<Self> {
        let options: &ClassArguments = &arguments.classes;
        let source = Source::parse(&arguments.mesh)?;
        let memory = &arguments.memory;
        let mesh = memory.mesh(&arguments.mesh)?.into_owned();
        let mask = Mask::read(options.mask(), options.on(), mesh, memory)?;
        let surface = Surface::of(source, mask.mesh(), arguments)?;
        let input = Input::read(&mask.whole, given, options, memory)?;
        let m = input.costs.s.ncols();
        let list = list::read(options.list(), m)?;
        let names: Vec<&str> = list.iter().filter_map(|class| class.name.as_deref()).collect();
        let labels = pairs::Labels { count: m, names: &names };
        let metric = pairs::relaxation(arguments.solving.pairs.as_deref(), labels, memory)?;
        let on = options.on().unwrap_or(input.costs.of);
        let seeds = match &arguments.seeds {
            None => Seeds::default(),
            Some(path) => {
                let seeds = mask.seeds(seeds::read(path, &mask.whole, m, on, memory)?, on);
                match (&surface.weld, on) {
                    (Some(weld), Element::Vertices) => {
                        seeds.welded(weld).map_err(|error| error.of_file(path))?
                    }
                    _ => seeds,
                }
            }
        };
        let contrast = options.edge_aware();
        let contrast =
            contrast.map(|choice| contrast::read(choice, &mask.whole, memory)).transpose()?;
        let contrast = contrast.map(|contrast| mask.contrast(contrast));
        let costs = welded(&surface, &mask, &input.costs)?;
        let mut s = costs.on(on, &surface.scaled);
        if mask.left_out() > 0 && on == Element::Vertices {
            // Vertices without faces are left out: they are not unknown.
            let mut inside = vec![false; s.nrows()];
            surface.scaled.faces.iter().flatten().for_each(|&v| inside[v as usize] = true);
            let outside = inside.iter().enumerate().filter(|(_, inside)| !**inside);
            outside.for_each(|(v, _)| s.row_mut(v).fill(0.0));
        }
        Ok(Prepared { mask, surface, input, list, on, metric, seeds, contrast, costs, s })
    }

    /// The costs on the mesh that is drawn, as given.
    pub fn drawn_costs(&self) -> ClassCosts {
        let ClassCosts { s, of } = &self.input.costs;
        ClassCosts { s: self.mask.rows(s.clone(), *of), of: *of }
    }

    /// A warning if the costs leave nothing to decide.
    pub fn one_class_everywhere(&self) -> Option<String> {
        let known = self.input.costs.s.outer_iter().filter(|row| !row[0].is_nan());
        let mut probable = known.map(most_probable);
        let first = probable.next()?;
        probable.all(|p| p == first).then(|| {
            format!(
                "class {first} is the most probable one everywhere, so there is nothing to cut; check the columns"
            )
        })
    }
}

/// The costs on the welded mesh.
fn welded(surface: &Surface, mask: &Mask, costs: &ClassCosts) -> Result<ClassCosts> {
    let s = mask.rows(costs.s.clone(), costs.of);
    let s = match (&surface.weld, costs.of) {
        (Some(weld), Element::Vertices) => {
            let weights = Mass::Barycentric.weights(&surface.mesh);
            welding::costs(weld, &s, &weights)?
        }
        _ => s,
    };
    Ok(ClassCosts { s, of: costs.of })
}
