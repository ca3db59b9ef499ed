//! Points, cells and arrays, as all files of VTK have them, and the mesh that they are.

use std::path::Path;

use nalgebra::Point3;
use ndarray::Array2;

use super::numbers::Numbers;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::mesh::io::colors::Colors;
use crate::mesh::io::occurrences::Occurrences;
use crate::mesh::io::polygon::Polygons;
use crate::mesh::io::scalars::{Properties, Scalars};
use crate::mesh::io::{
    INVALID_TEXTURE, TOO_FEW_CORNERS, check_coordinate, check_faces, fan, uv_of_vertices, valid_uv,
    warn_untextured,
};

/// What a cell is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cell {
    /// Triangle, quadrilateral or polygon.
    Polygon,
    /// Triangles of which each shares an edge with the one before.
    Strip,
    /// The corners 0, 1, 3, 2 of a rectangle.
    Pixel,
    /// Vertices and lines.
    Thin,
}

impl Cell {
    /// The cell of a number of VTK.
    ///
    /// # Errors
    /// It is a volume or curved.
    pub fn of_type(number: i64) -> std::result::Result<Self, String> {
        match number {
            1..=4 => Ok(Cell::Thin),
            5 | 7 | 9 => Ok(Cell::Polygon),
            6 => Ok(Cell::Strip),
            8 => Ok(Cell::Pixel),
            _ => Err(format!(
                "has cells of the type {number}, which are neither triangles nor polygons; extract the surface, as by \
                 extract_surface() of pyvista, and triangulate it"
            )),
        }
    }
}

/// An array with a row for each point or cell.
pub struct Array {
    pub name: String,
    pub components: usize,
    pub numbers: Numbers,
    /// The full intensity, if these are colors.
    pub full: Option<f64>,
}

/// The content of a file.
#[derive(Default)]
pub struct Grid {
    /// 3 V coordinates.
    pub points: Vec<f64>,
    /// The corners of all cells.
    pub corners: Vec<i64>,
    /// Each cell, and where its corners end.
    pub cells: Vec<(Cell, usize)>,
    pub of_points: Vec<Array>,
    pub of_cells: Vec<Array>,
}

/// Names of arrays with colors.
const COLORS: [&str; 4] = ["rgb", "rgba", "color", "colors"];
/// Names of arrays with texture coordinates.
const TEXTURES: [&str; 5] =
    ["texture coordinates", "texturecoordinates", "tcoords", "uv", "texcoords"];

impl Grid {
    /// Cells that follow one another, from their corners and the end of each.
    ///
    /// # Errors
    /// The ends do not ascend to the number of corners.
    pub fn add(
        &mut self,
        cells: impl Iterator<Item = Cell>,
        corners: Vec<i64>,
        ends: impl Iterator<Item = i64>,
    ) -> std::result::Result<(), String> {
        let before = self.corners.len();
        let mut last = 0;
        for (cell, end) in cells.zip(ends) {
            let end = usize::try_from(end).ok().filter(|end| (last..=corners.len()).contains(end));
            last = end.ok_or(
                "the offsets of the cells do not ascend up to the number of their corners",
            )?;
            self.cells.push((cell, before + last));
        }
        if last != corners.len() {
            return Err(format!("the cells have {last} corners, but {} are given", corners.len()));
        }
        self.corners.extend(corners);
        Ok(())
    }

    /// The mesh: polygons in triangles, strips and pixels as well.
    ///
    /// # Errors
    /// A coordinate or a corner is invalid, or there are no faces.
    pub fn mesh(self, path: &Path) -> Result<Mesh> {
        let wrong = |message: String| Error::malformed(path, message);
        let point = |(v, x): (usize, &[f64])| {
            for x in x {
                check_coordinate(*x).map_err(|message| wrong(format!("point {v}: {message}")))?;
            }
            Ok(Point3::new(x[0], x[1], x[2]))
        };
        let vertices = self.points.chunks_exact(3).enumerate().map(point);
        let vertices = vertices.collect::<Result<Vec<_>>>()?;
        let count = vertices.len();
        let (mut faces, mut of_cell) = (Vec::new(), Vec::new());
        let (mut polygons, mut thin) = (Polygons::default(), Occurrences::default());
        let mut first = 0;
        for (i, &(cell, end)) in self.cells.iter().enumerate() {
            let corners = &self.corners[std::mem::replace(&mut first, end)..end];
            let index = |&v: &i64| {
                u32::try_from(v).ok().filter(|&v| (v as usize) < count).ok_or_else(|| {
                    wrong(format!("cell {i} has the point {v}; there are {count}, numbered from 0"))
                })
            };
            let corners = corners.iter().map(index).collect::<Result<Vec<u32>>>()?;
            if cell == Cell::Thin || corners.len() < 3 {
                thin.add(|| format!("cell {i}"));
                continue;
            }
            match (cell, &corners[..]) {
                (Cell::Strip, strip) => faces.extend(strip.windows(3).enumerate().map(turned)),
                (Cell::Pixel, &[a, b, c, d]) => faces.extend([[a, b, d], [a, d, c]]),
                (_, polygon) => {
                    polygons.add(faces.len(), polygon.len());
                    faces.extend(fan(polygon));
                }
            }
            of_cell.resize(faces.len(), i);
        }
        check_faces(path, &faces)?;
        thin.warn(path, TOO_FEW_CORNERS);
        polygons.triangulate::<u32>(path, &vertices, &mut faces, None);
        let uv = self.texture(path, count);
        let uv = uv.and_then(|uv| warn_untextured(path, uv_of_vertices(&faces, &uv)));
        let face_colors = colors(path, &self.of_cells, self.cells.len(), "faces");
        let face_colors = face_colors.map(|colors| of_cell.iter().map(|&i| colors[i]).collect());
        let colors = colors(path, &self.of_points, count, "vertices");
        Ok(Mesh { vertices, faces, colors, face_colors, uv, materials: None })
    }

    fn texture(&self, path: &Path, count: usize) -> Option<Vec<[f64; 2]>> {
        let array = named(&self.of_points, &TEXTURES, &[2, 3])?;
        let mut invalid = Occurrences::default();
        let rows = array.numbers.floats();
        let rows = rows.chunks_exact(array.components).enumerate();
        let uv = rows.map(|(v, t)| valid_uv([t[0], t[1]], &mut invalid, || format!("point {v}")));
        let uv = uv.collect::<Vec<_>>();
        invalid.warn(path, INVALID_TEXTURE);
        (uv.len() == count).then_some(uv)
    }

    /// The arrays of points or of cells whose element, `vertex` or `face`, and name `matches`, a column for each of
    /// their components. Rows of cells are given to their triangles.
    ///
    /// # Errors
    /// Points and cells, or neither, have such arrays.
    pub fn scalars(&self, path: &Path, matches: &dyn Fn(&str, &str) -> bool) -> Result<Scalars> {
        let matching = |element: &str, arrays: &[Array]| {
            arrays
                .iter()
                .enumerate()
                .filter(|(_, a)| matches(element, &a.name))
                .map(|(i, _)| i)
                .collect::<Vec<_>>()
        };
        let of_points = matching("vertex", &self.of_points);
        let of_cells = matching("face", &self.of_cells);
        let (of_faces, chosen, arrays) = match (&of_points[..], &of_cells[..]) {
            ([], []) => {
                let names = |element: &str, arrays: &[Array]| -> Vec<String> {
                    arrays.iter().map(|array| format!("{element}:{}", array.name)).collect()
                };
                let all =
                    [names("vertex", &self.of_points), names("face", &self.of_cells)].concat();
                let all = if all.is_empty() { "none at all".into() } else { all.join(", ") };
                return Err(Error::malformed(
                    path,
                    format!("has no such array at points or cells, but {all}"),
                ));
            }
            (_, []) => (false, of_points, &self.of_points),
            ([], _) => (true, of_cells, &self.of_cells),
            _ => {
                let message =
                    "has such arrays at points and at cells; write vertex:NAME or face:NAME";
                return Err(Error::malformed(path, message));
            }
        };
        let mut names = Vec::new();
        let (mut types, mut columns) = (Vec::new(), Vec::<Vec<f64>>::new());
        for array in chosen.into_iter().map(|i| &arrays[i]) {
            let numbers = array.numbers.floats();
            for c in 0..array.components {
                names.push(if array.components > 1 {
                    format!("{}[{c}]", array.name)
                } else {
                    array.name.clone()
                });
                types.push(array.numbers.scalar());
                columns.push(numbers.iter().skip(c).step_by(array.components).copied().collect());
            }
        }
        let rows: Vec<usize> = match of_faces {
            true => self.triangles().collect(),
            false => (0..columns[0].len()).collect(),
        };
        let numbers =
            Array2::from_shape_fn((rows.len(), columns.len()), |(k, c)| columns[c][rows[k]]);
        Ok(Scalars { of_faces, names, types, numbers })
    }

    /// All arrays of points and of cells.
    pub fn properties(&self, path: &Path) -> Result<Properties> {
        let of = |wanted: &str, arrays: &[Array]| {
            let is_wanted = |element: &str, _: &str| element == wanted;
            (!arrays.is_empty()).then(|| self.scalars(path, &is_wanted)).transpose()
        };
        Ok(Properties {
            of_vertices: of("vertex", &self.of_points)?,
            of_faces: of("face", &self.of_cells)?,
        })
    }

    /// The cell of each face of the mesh.
    fn triangles(&self) -> impl Iterator<Item = usize> + '_ {
        let starts = std::iter::once(0).chain(self.cells.iter().map(|cell| cell.1));
        let cells = starts.zip(&self.cells).enumerate();
        cells.flat_map(|(i, (first, &(cell, end)))| {
            let corners = if cell == Cell::Thin { 0 } else { end - first };
            std::iter::repeat_n(i, corners.saturating_sub(2))
        })
    }
}

/// Every other triangle of a strip is turned.
fn turned((i, corners): (usize, &[u32])) -> [u32; 3] {
    let [a, b, c] = [corners[0], corners[1], corners[2]];
    if i % 2 == 0 { [a, b, c] } else { [b, a, c] }
}

/// The array of one of these names, in upper or lower case, with one of these numbers of components.
fn named<'a>(arrays: &'a [Array], names: &[&str], components: &[usize]) -> Option<&'a Array> {
    arrays.iter().find(|array| {
        names.contains(&array.name.to_ascii_lowercase().as_str())
            && components.contains(&array.components)
    })
}

fn colors(path: &Path, arrays: &[Array], count: usize, what: &str) -> Option<Vec<[f64; 3]>> {
    let array = named(arrays, &COLORS, &[3, 4])?;
    let numbers = array.numbers.floats();
    let mut colors = Colors::new(array.full).with_capacity(count);
    for (i, color) in numbers.chunks_exact(array.components).enumerate().take(count) {
        colors.set(i, [color[0], color[1], color[2]], || format!("row {i} of {}", array.name));
    }
    colors.finish(path, count, what)
}
