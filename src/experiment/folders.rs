//! The files of an experiment: where they are, and hashes of their content, on which the IDs of runs depend.

use std::ops::Range;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use tracing::subscriber::{self, NoSubscriber};

use super::choice::DataChoice;
use super::photographs::Photography;
use super::spec::{External, InstanceCell, Task};
use crate::data::input::{self, DataSource, Mapping};
use crate::data::views::{self, ViewOptions};
use crate::error::{Error, Result};
use crate::evolve::start::Choice;
use crate::file;
use crate::mesh::Source;
use crate::solve::check_mesh;

/// The folders in which files are looked up.
pub struct Folders {
    /// The folder of the experiment file, to which paths are relative.
    pub folder: PathBuf,
    /// The folder that `data:` stands for.
    pub data: Option<PathBuf>,
}

/// Why an instance cannot be made.
pub enum InstanceError {
    /// It needs the folder of data that may not be redistributed, but `--data-dir` was not given.
    DataFolder,
    Error(Error),
}

impl From<InstanceError> for Error {
    fn from(missing: InstanceError) -> Self {
        match missing {
            InstanceError::DataFolder => Error::unsuitable(
                "the instance needs the data folder: give --data-dir or set MESHSEG_DATA",
            ),
            InstanceError::Error(error) => error,
        }
    }
}

impl From<Error> for InstanceError {
    fn from(error: Error) -> Self {
        InstanceError::Error(error)
    }
}

impl Folders {
    pub(super) fn path(&self, name: &str) -> std::result::Result<PathBuf, InstanceError> {
        match (name.strip_prefix("data:"), &self.data) {
            (Some(name), Some(data)) => Ok(data.join(name)),
            (Some(_), None) => Err(InstanceError::DataFolder),
            (None, _) => Ok(self.folder.join(name)),
        }
    }

    pub(super) fn mesh(&self, name: &str) -> std::result::Result<Source, InstanceError> {
        let path = self.path(name)?;
        Ok(if path.exists() || name.starts_with("data:") {
            Source::File(path)
        } else {
            match Source::parse(name)? {
                Source::File(_) => Source::File(path),
                other => other,
            }
        })
    }

    pub(super) fn data(
        &self,
        choice: &DataChoice,
    ) -> std::result::Result<DataChoice, InstanceError> {
        let at = |path: &Path| self.path(&path.to_string_lossy());
        Ok(match choice {
            DataChoice::Costs(path) => DataChoice::Costs(at(path)?),
            DataChoice::Probabilities(path) => DataChoice::Probabilities(at(path)?),
            DataChoice::Source(DataSource::Texture(Some(path))) => {
                DataChoice::Source(DataSource::Texture(Some(at(path)?)))
            }
            DataChoice::Source(DataSource::Image(path)) => {
                DataChoice::Source(DataSource::Image(at(path)?))
            }
            DataChoice::Source(DataSource::File(path)) => {
                DataChoice::Source(DataSource::File(at(path)?))
            }
            DataChoice::Source(DataSource::Views(path)) => {
                DataChoice::Source(DataSource::Views(at(path)?))
            }
            other => other.clone(),
        })
    }

    /// How images are mapped to the mesh, and which pixels of views count.
    pub(super) fn mapping(
        &self,
        cell: &InstanceCell,
    ) -> std::result::Result<Mapping, InstanceError> {
        let images = cell.images.as_deref().map(|folder| self.path(folder)).transpose()?;
        let Photography { pure, grazing, .. } = cell.photography;
        let views = ViewOptions { images, pure, grazing, ..ViewOptions::default() };
        Ok(Mapping { project: cell.project, views, ..Mapping::default() })
    }

    /// A hash of the files that an instance is made from; generated meshes and data are identified by their names.
    ///
    /// # Errors
    /// A file is missing or cannot be read.
    pub fn content(&self, cell: &InstanceCell) -> std::result::Result<String, InstanceError> {
        let mut hash = Sha256::new();
        let source = cell.mesh.as_deref().map(|mesh| self.mesh(mesh)).transpose()?;
        if let Some(Source::File(path)) = &source {
            hash.update(file::read(path)?);
        }
        match &self.data(&cell.data)? {
            DataChoice::Costs(path)
            | DataChoice::Probabilities(path)
            | DataChoice::Source(DataSource::File(path)) => {
                hash.update(file::read(path)?);
            }
            DataChoice::Own => paint(&mut hash, source.as_ref(), None, &self.mapping(cell)?)?,
            DataChoice::Source(DataSource::Views(path)) => {
                for path in views::files(path, self.mapping(cell)?.views.images.as_deref())? {
                    add_file(&mut hash, &path, &file::read(&path)?);
                }
            }
            DataChoice::Source(choice) => {
                paint(&mut hash, source.as_ref(), Some(choice), &self.mapping(cell)?)?;
            }
            DataChoice::Waves | DataChoice::Classes | DataChoice::Photographs(_) => {}
        }
        if let Some(name) = &cell.truth {
            hash.update(file::read(&self.path(name)?)?);
        }
        Ok(hex(&hash.finalize()))
    }

    /// A hash of the files that a solver reads: those that its command names, or the mesh that it starts from.
    ///
    /// # Errors
    /// A file is missing or cannot be read.
    pub fn solver(&self, task: &Task) -> Result<Option<String>> {
        if let Some(external) = task.external() {
            return self.command(external).map(Some);
        }
        let Some(Choice::Mesh(path)) = task.evolution().map(|evolution| &evolution.start) else {
            return Ok(None);
        };
        match self.mesh(&path.to_string_lossy())? {
            Source::File(path) => Ok(Some(hex(&Sha256::digest(file::read(&path)?)))),
            _ => Ok(None),
        }
    }

    /// A hash of the files among the words of a command; files that these use in turn are not included.
    ///
    /// # Errors
    /// A file cannot be read.
    fn command(&self, external: &External) -> Result<String> {
        let mut hash = Sha256::new();
        for word in external.command.split_whitespace() {
            let path = self.folder.join(word);
            if path.is_file() {
                hash.update(file::read(&path)?);
            }
        }
        Ok(hex(&hash.finalize()))
    }

    /// The span in the experiment file that is to blame if an instance cannot be made: its mesh, if that alone fails,
    /// otherwise its data.
    pub fn blame<'a>(&self, cell: &'a InstanceCell) -> &'a Range<usize> {
        let mesh = || -> std::result::Result<(), InstanceError> {
            if let Some(name) = &cell.mesh {
                check_mesh(&self.mesh(name)?.mesh()?)?;
            }
            Ok(())
        };
        if mesh().is_err() { &cell.mesh_span } else { &cell.data_span }
    }
}

/// Hashes the inputs that color a mesh but are not in its file: its materials from libraries, and images. A mesh that
/// cannot be read is an error only when the instance is made.
fn paint(
    hash: &mut Sha256,
    source: Option<&Source>,
    choice: Option<&DataSource>,
    mapping: &Mapping,
) -> Result<()> {
    let Some(source) = source else { return Ok(()) };
    let given = match choice {
        Some(DataSource::Curvature(_)) => return Ok(()),
        Some(DataSource::Texture(given)) => given.is_some(),
        Some(DataSource::Image(_)) => true,
        _ => false,
    };
    if !given && !matches!(source, Source::File(_)) {
        return Ok(());
    }
    // Warnings are reported when the instance is made, which reads the mesh again.
    let mesh = subscriber::with_default(NoSubscriber::default(), || source.mesh());
    let Ok(mesh) = mesh else { return Ok(()) };
    for material in mesh.materials.iter().flat_map(|materials| &materials.all) {
        let color = material.color.map(|color| color.map(f64::to_bits));
        hash.update(format!("{color:?} {:?}", material.placement.bits()));
    }
    for path in input::image_files(source, &mesh, choice, mapping) {
        let bytes = match (file::read(&path), choice) {
            (Ok(bytes), _) => bytes,
            // Images that the mesh names may be missing.
            (Err(_), None) => Vec::new(),
            (Err(error), Some(_)) => return Err(error),
        };
        add_file(hash, &path, &bytes);
    }
    Ok(())
}

/// Adds the name of a file, without its folder, and its content.
fn add_file(hash: &mut Sha256, path: &Path, bytes: &[u8]) {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    hash.update(format!("{name} {} ", bytes.len()));
    hash.update(bytes);
}

/// The bytes as hexadecimal digits.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
