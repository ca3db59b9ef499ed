//! `--seeds`: vertices or faces whose labels are given.
//!
//! ```text
//! vertex,region      or    face,region       a table (.csv) with this header, one seed per line
//! ```
//!
//! or integers (.npy), one per vertex or per face, -1 where there is no seed. A face is a seed at its corners.

use std::path::Path;

use meshseg::counted::counted;
use meshseg::mesh::Mesh;
use meshseg::seeds::Seeds;
use meshseg::{Error, Result, file, npy};

/// What the indices of a file count.
#[derive(Clone, Copy)]
enum Element {
    Vertex,
    Face,
}

/// Reads the seeds on a mesh with m regions. Fails if an index or a region is out of range, or a vertex
/// would be a seed of two regions.
pub fn read(path: &Path, mesh: &Mesh, m: usize) -> Result<Seeds> {
    let mut collected = Collected { path, mesh, m, regions: vec![None; mesh.vertices.len()] };
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("npy") => collected.add_array()?,
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
    regions: Vec<Option<u8>>,
}

impl Collected<'_> {
    fn add_array(&mut self) -> Result<()> {
        let labels = npy::integers::<ndarray::Ix1>(self.path, &file::read(self.path)?)?;
        let (vertices, faces) = (self.mesh.vertices.len(), self.mesh.faces.len());
        let element = match labels.len() {
            n if n == vertices && n == faces => {
                let message = format!(
                    "has {n} integers, and the mesh has as many vertices as faces; give a .csv with the header \
                     vertex,region or face,region"
                );
                return Err(Error::malformed(self.path, message));
            }
            n if n == vertices => Element::Vertex,
            n if n == faces => Element::Face,
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
            ["vertex", "region"] => Element::Vertex,
            ["face", "region"] => Element::Face,
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
        let (count, name) = match element {
            Element::Vertex => (self.mesh.vertices.len(), "vertices"),
            Element::Face => (self.mesh.faces.len(), "faces"),
        };
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
        let corners = match element {
            Element::Vertex => vec![index],
            Element::Face => self.mesh.faces[index].map(|v| v as usize).to_vec(),
        };
        for v in corners {
            match self.regions[v] {
                Some(other) if usize::from(other) != p => {
                    return Err(wrong(format!("vertex {v} is already a seed of region {other}")));
                }
                _ => self.regions[v] = Some(p as u8),
            }
        }
        Ok(())
    }
}
