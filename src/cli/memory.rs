//! A mesh and arrays in memory, each of which stands for the file of its name.
//!
//! In a shell there are none. A program that calls a verb, such as Python, has them in place of files.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use ndarray::Array2;

use crate::mesh::{Mesh, source};
use crate::{Result, npy};

/// What is in memory.
#[derive(Clone, Default)]
pub struct Memory {
    /// The mesh that the argument MESH stands for.
    pub mesh: Option<Mesh>,
    /// The arrays, by the names of their files.
    pub arrays: BTreeMap<PathBuf, Array2<f64>>,
}

impl Memory {
    /// The mesh, or else that of the argument.
    ///
    /// # Errors
    /// Those of [`source`].
    pub fn mesh(&self, argument: &Path) -> Result<Cow<'_, Mesh>> {
        match &self.mesh {
            Some(mesh) => Ok(Cow::Borrowed(mesh)),
            None => source(argument).map(Cow::Owned),
        }
    }

    /// The file of the mesh, if it comes from one.
    pub fn file<'a>(&self, argument: &'a Path) -> Option<&'a Path> {
        (self.mesh.is_none() && argument.is_file()).then_some(argument)
    }

    /// The array of this name.
    pub fn array(&self, path: &Path) -> Option<&Array2<f64>> {
        self.arrays.get(path)
    }

    /// The array of this name, or else the rows in the file, see [`npy::read_rows`].
    ///
    /// # Errors
    /// The file cannot be read, or is no such array.
    pub fn rows(&self, path: &Path) -> Result<Cow<'_, Array2<f64>>> {
        match self.array(path) {
            Some(array) => Ok(Cow::Borrowed(array)),
            None => npy::read_rows(path).map(Cow::Owned),
        }
    }

    /// The array of this name, or else the matrix in the file, see [`npy::read_matrix`].
    ///
    /// # Errors
    /// The file cannot be read, is no such array, or has an entry that is not finite.
    pub fn matrix(&self, path: &Path) -> Result<Cow<'_, Array2<f64>>> {
        match self.array(path) {
            Some(array) => npy::check_matrix(path, array).map(|()| Cow::Borrowed(array)),
            None => npy::read_matrix(path).map(Cow::Owned),
        }
    }
}
