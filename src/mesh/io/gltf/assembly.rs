//! The mesh of the primitives of all nodes.
//!
//! ```text
//! vertices of a node: one block per accessor of positions, x = G POSITION
//! faces: those of its primitives, (a, c, b) instead of (a, b, c) if det G < 0
//! ```
//!
//! Reference: Khronos Group, *glTF 2.0 Specification*, section 3.7, "Geometry".

use std::collections::HashMap;
use std::path::Path;

use nalgebra::{Matrix4, Point3};

use super::accessor::Reader;
use super::buffers::Buffers;
use super::document::{Document, Primitive};
use super::nodes::Instance;
use super::paint::{Block, Paint, SharedUv};
use super::parse::{DRACO, compressed};
use super::primitive::Mode;
use crate::error::{self, Error};
use crate::mesh::Mesh;
use crate::mesh::io::occurrences::Occurrences;
use crate::mesh::io::rules::{check_coordinate, check_faces};

/// What the primitives of a mesh at a node share, by accessor.
#[derive(Default)]
struct Shared {
    blocks: HashMap<usize, Block>,
    uv: SharedUv,
}

/// The mesh read so far.
pub struct Assembly<'a> {
    path: &'a Path,
    reader: Reader<'a>,
    vertices: Vec<Point3<f64>>,
    faces: Vec<[u32; 3]>,
    paint: Paint,
    thin: Occurrences,
    posed: Occurrences,
}

impl<'a> Assembly<'a> {
    pub fn new(path: &'a Path, document: &'a Document, buffers: &'a Buffers<'a>) -> Self {
        Assembly {
            path,
            reader: Reader::new(document, buffers),
            vertices: Vec::new(),
            faces: Vec::new(),
            paint: Paint::default(),
            thin: Occurrences::default(),
            posed: Occurrences::default(),
        }
    }

    fn error(&self, message: impl Into<String>) -> Error {
        Error::malformed(self.path, message)
    }

    /// Appends a mesh.
    pub fn add(&mut self, instance: &Instance) -> error::Result<()> {
        let document = self.reader.document;
        let Some(mesh) = document.meshes.get(instance.mesh) else {
            return Err(self.error(format!("mesh {} does not exist", instance.mesh)));
        };
        // The joints of a skin replace the transform of the node.
        let transform = if instance.has_skin { Matrix4::identity() } else { instance.transform };
        let mut shared = Shared::default();
        for (i, primitive) in mesh.primitives.iter().enumerate() {
            let place = format!("mesh {}, primitive {i}", instance.mesh);
            if instance.has_skin || !primitive.targets.is_empty() {
                self.posed.add(|| place.clone());
            }
            self.check_compression(primitive)?;
            self.add_primitive(primitive, &transform, &mut shared, &place)
                .map_err(|message| self.error(format!("{place}: {message}")))?;
        }
        Ok(())
    }

    /// Some programs do not declare that they require the compression.
    fn check_compression(&self, primitive: &Primitive) -> error::Result<()> {
        let positions = primitive.attributes.get("POSITION");
        let positions = positions.and_then(|&index| self.reader.document.accessors.get(index));
        let is_empty = positions.is_some_and(|p| p.buffer_view.is_none() && p.sparse.is_none());
        match primitive.extensions.contains_key(DRACO) && is_empty {
            true => Err(compressed(self.path, DRACO)),
            false => Ok(()),
        }
    }

    fn add_primitive(
        &mut self,
        primitive: &Primitive,
        transform: &Matrix4<f64>,
        shared: &mut Shared,
        place: &str,
    ) -> Result<(), String> {
        self.reader.count(1)?;
        let mode = primitive.mode.map_or(Some(Mode::Triangles), Mode::of);
        let mode = mode.ok_or("the mode is unknown")?;
        if mode == Mode::Thin {
            self.thin.add(|| place.to_owned());
            return Ok(());
        }
        let &positions = primitive.attributes.get("POSITION").ok_or("has no POSITION")?;
        let mut block = match shared.blocks.get(&positions) {
            Some(&block) => block,
            None => self.block(positions, transform)?,
        };
        self.paint.color(&self.reader, primitive, &mut block, place);
        shared.blocks.insert(positions, block);
        let mut faces = self.local_faces(primitive, mode, block.count)?;
        if transform.fixed_view::<3, 3>(0, 0).determinant() < 0.0 {
            faces.iter_mut().for_each(|face| face.swap(1, 2));
        }
        let vertices = block.count;
        self.paint.texture(&self.reader, primitive, vertices, &faces, &mut shared.uv, place);
        self.paint.material(self.reader.document, primitive, faces.len(), place);
        self.faces.extend(faces.iter().map(|face| face.map(|k| block.first + k)));
        Ok(())
    }

    /// Appends vertices.
    fn block(&mut self, positions: usize, transform: &Matrix4<f64>) -> Result<Block, String> {
        let rows = self.reader.rows::<3>(positions, &["VEC3"], false)?;
        let [first, count] = [self.vertices.len(), rows.len()];
        let index =
            |n: usize| u32::try_from(n).map_err(|_| "there are more than 2^32 - 1 vertices");
        index(first + count)?;
        let block = Block { first: index(first)?, count: index(count)?, colors: None };
        let is_moved = *transform != Matrix4::identity();
        self.vertices.reserve(count);
        for (k, row) in rows.into_iter().enumerate() {
            let mut x = checked(Point3::from(row), k)?;
            if is_moved {
                x = checked(Point3::from((transform * x.to_homogeneous()).xyz()), k)?;
            }
            self.vertices.push(x);
        }
        Ok(block)
    }

    /// The faces of a primitive, whose vertices count from 0.
    fn local_faces(
        &self,
        primitive: &Primitive,
        mode: Mode,
        vertices: u32,
    ) -> Result<Vec<[u32; 3]>, String> {
        let corners = match primitive.indices {
            Some(indices) => self.reader.indices(indices)?,
            None => {
                self.reader.count(vertices as usize)?;
                (0..vertices).collect()
            }
        };
        if let Some(k) = corners.iter().find(|&&k| k >= vertices) {
            return Err(format!(
                "refers to vertex {k}, but has {vertices} positions, counted from 0"
            ));
        }
        mode.faces(&corners)
    }

    /// The mesh; `folder` contains the images.
    pub fn finish(self, folder: Option<&Path>) -> error::Result<Mesh> {
        check_faces(self.path, &self.faces)?;
        self.thin.warn(self.path, "primitives of points or lines are left out");
        self.posed
            .warn(self.path, "skins and morph targets are left out: the mesh is in its rest pose");
        let mesh = Mesh { vertices: self.vertices, faces: self.faces, ..Mesh::default() };
        Ok(self.paint.finish(self.path, folder, &self.reader, mesh))
    }
}

/// The position of vertex k, if it is valid.
fn checked(x: Point3<f64>, k: usize) -> Result<Point3<f64>, String> {
    match x.iter().try_for_each(|&x| check_coordinate(x).map(drop)) {
        Ok(()) => Ok(x),
        Err(message) => Err(format!("vertex {k}: {message}")),
    }
}
