//! `--seeds`: vertices or faces whose labels are given.
//!
//! ```text
//! vertex,region      or    face,region       a table (.csv) with this header, one seed per line
//! ```
//!
//! or integers (.npy), one per vertex or per face, -1 where there is no seed. For labels of vertices a face is a seed
//! at its corners, for labels of faces a vertex is one at the faces around it.

use std::cell::OnceCell;
use std::path::Path;

use ndarray::{Array2, Ix1};

use crate::counted::counted;
use crate::domain::Element;
use crate::mesh::Mesh;
use crate::seeds::Seeds;
use crate::{Error, Result, file, npy};

use super::memory::Memory;

/// Reads the seeds of the vertices or faces of a mesh with m regions. Fails if an index or a region is out of range, or
/// a vertex or face would be a seed of two regions.
pub fn read(path: &Path, mesh: &Mesh, m: usize, on: Element, memory: &Memory) -> Result<Seeds> {
    let regions = vec![None; on.count(mesh)];
    let mut collected = Collected { path, mesh, m, on, around: OnceCell::new(), regions };
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("npy") => collected.add_array(memory.array(path))?,
        _ => collected.add_table()?,
    }
    let seeds = Seeds::new(collected.regions);
    match seeds.is_empty() {
        true => Err(Error::malformed(path, "has no seeds")),
        false => Ok(seeds),
    }
}

struct Collected<'a> {
    path: &'a Path,
    mesh: &'a Mesh,
    m: usize,
    on: Element,
    /// The faces around each vertex, once they are needed.
    around: OnceCell<Vec<Vec<usize>>>,
    regions: Vec<Option<u8>>,
}

impl Collected<'_> {
    fn add_array(&mut self, array: Option<&Array2<f64>>) -> Result<()> {
        let labels: Vec<i64> = match array {
            None => npy::integers::<Ix1>(self.path, &file::read(self.path)?)?.to_vec(),
            Some(array) => {
                let column = array.iter().map(|&x| (x.fract() == 0.0).then_some(x as i64));
                let whole = column.collect::<Option<_>>().filter(|_| array.ncols() == 1);
                whole.ok_or_else(|| {
                    Error::malformed(self.path, "must be integers, one per vertex or face")
                })?
            }
        };
        let (vertices, faces) = (self.mesh.vertices.len(), self.mesh.faces.len());
        let element = match labels.len() {
            n if n == vertices && n == faces => {
                let message = format!(
                    "has {n} integers, and the mesh has as many vertices as faces; give a .csv with the header \
                     vertex,region or face,region"
                );
                return Err(Error::malformed(self.path, message));
            }
            n if n == vertices => Element::Vertices,
            n if n == faces => Element::Faces,
            n => {
                let message = format!(
                    "has {n} integers; the mesh has {vertices} vertices and {faces} faces, each of which needs one \
                     (-1: no seed)"
                );
                return Err(Error::malformed(self.path, message));
            }
        };
        for (index, &region) in labels.iter().enumerate().filter(|&(_, &region)| region != -1) {
            self.add(element, index as i64, region, None)?;
        }
        Ok(())
    }

    fn add_table(&mut self) -> Result<()> {
        let bytes = file::read(self.path)?;
        let malformed = |error: csv::Error| Error::malformed(self.path, error.to_string());
        let mut table =
            csv::ReaderBuilder::new().trim(csv::Trim::All).flexible(true).from_reader(&bytes[..]);
        let header = table.headers().map_err(malformed)?;
        let element = match header.iter().collect::<Vec<_>>()[..] {
            ["vertex", "region"] => Element::Vertices,
            ["face", "region"] => Element::Faces,
            _ => {
                let message = "must begin with the line `vertex,region` or `face,region`";
                return Err(Error::malformed_line(self.path, 1, message));
            }
        };
        for row in table.records() {
            let row = row.map_err(malformed)?;
            let line = row.position().map_or(0, csv::Position::line) as usize;
            if row.len() != 2 {
                let message = format!(
                    "has {}; it must have two numbers",
                    counted(row.len(), "number", "numbers")
                );
                return Err(Error::malformed_line(self.path, line, message));
            }
            let number = |column: usize| {
                row[column].parse::<i64>().map_err(|_| {
                    let message = format!("`{}` is not an integer", &row[column]);
                    Error::malformed_line(self.path, line, message)
                })
            };
            let (index, region) = (number(0)?, number(1)?);
            self.add(element, index, region, Some(line))?;
        }
        Ok(())
    }

    fn add(
        &mut self,
        element: Element,
        index: i64,
        region: i64,
        line: Option<usize>,
    ) -> Result<()> {
        let wrong = |message: String| match line {
            Some(line) => Error::malformed_line(self.path, line, message),
            None => Error::malformed(self.path, format!("entry {index}: {message}")),
        };
        let (count, [_, name]) = (element.count(self.mesh), element.nouns());
        let Some(index) = usize::try_from(index).ok().filter(|&index| index < count) else {
            return Err(wrong(format!(
                "{index} is out of range; the {count} {name} are numbered from 0"
            )));
        };
        let Some(p) = usize::try_from(region).ok().filter(|&p| p < self.m) else {
            return Err(wrong(format!(
                "region {region} is out of range; the {} regions are numbered from 0",
                self.m
            )));
        };
        let seeds = match (element, self.on) {
            (Element::Faces, Element::Vertices) => {
                self.mesh.faces[index].map(|v| v as usize).to_vec()
            }
            (Element::Vertices, Element::Faces) => self.faces_around(index).to_vec(),
            _ => vec![index],
        };
        let [noun, _] = self.on.nouns();
        for k in seeds {
            match self.regions[k] {
                Some(other) if usize::from(other) != p => {
                    let from = match (element, self.on) {
                        (Element::Vertices, Element::Faces) => {
                            format!("vertex {index} stands for the faces around it, of which ")
                        }
                        _ => String::new(),
                    };
                    let message = format!("{from}{noun} {k} is already a seed of region {other}");
                    return Err(wrong(message));
                }
                _ => self.regions[k] = Some(p as u8),
            }
        }
        Ok(())
    }

    fn faces_around(&self, v: usize) -> &[usize] {
        let around = self.around.get_or_init(|| {
            let mut around = vec![Vec::new(); self.mesh.vertices.len()];
            for (j, face) in self.mesh.faces.iter().enumerate() {
                face.iter().for_each(|&v| around[v as usize].push(j));
            }
            around
        });
        &around[v]
    }
}
