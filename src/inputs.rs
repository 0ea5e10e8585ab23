//! The files that a configuration names: looked up, read, and kept for the output folder.

use patterns::{Error, Inputs};
use solvers::{Field, isosurface::Polyline, mesh::TriangleMesh};
use std::{
    cell::RefCell,
    path::{Path, PathBuf},
};

/// Reads input files and remembers their bytes, so that an output folder can
/// carry copies and be repeated or resumed anywhere.
pub struct FileInputs {
    base: Vec<PathBuf>,
    read: RefCell<Vec<InputFile>>,
}

/// An input file that a run has read.
#[derive(Clone, Debug)]
pub struct InputFile {
    /// The path as the configuration gives it.
    pub given: String,
    /// Name of its copy, relative to the output folder.
    pub copy: String,
    /// Its content.
    pub bytes: Vec<u8>,
}

impl FileInputs {
    /// Relative paths are looked up in each folder of `base`, in order.
    pub fn new(base: Vec<PathBuf>) -> Self {
        Self { base, read: RefCell::default() }
    }

    /// What was read.
    pub fn into_files(self) -> Vec<InputFile> {
        self.read.into_inner()
    }

    fn find(&self, path: &str) -> PathBuf {
        let candidates = self.base.iter().map(|folder| folder.join(path));
        candidates.clone().find(|c| c.exists()).unwrap_or_else(|| Path::new(path).to_path_buf())
    }

    /// Keeps a copy under `inputs/`, numbered if two files have one name.
    fn remember(&self, given: &str, path: &Path, bytes: Vec<u8>) {
        let mut read = self.read.borrow_mut();
        if read.iter().any(|file| file.given == given) {
            return;
        }
        let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let plain = format!("inputs/{name}");
        let taken = |copy: &String| read.iter().any(|file| &file.copy == copy);
        let numbered = (2..).map(|n| format!("inputs/{n}-{name}"));
        let copy = std::iter::once(plain).chain(numbered).find(|c| !taken(c)).unwrap_or_default();
        read.push(InputFile { given: given.into(), copy, bytes });
    }
}

impl Inputs for FileInputs {
    fn field(&self, key: &str, path: &str) -> patterns::Result<Field> {
        let file = self.find(path);
        let values = crate::input::load_field(&file).map_err(|error| broken(key, &error))?;
        let bytes = std::fs::read(&file).map_err(|error| broken(key, &error.into()))?;
        self.remember(path, &file, bytes);
        Field::from_array(values, 1.0).map_err(|error| broken(key, &error.into()))
    }

    fn mesh(&self, key: &str, path: &str) -> patterns::Result<Option<TriangleMesh>> {
        let file = self.find(path);
        let mesh = crate::input::load_mesh(&file).map_err(|error| broken(key, &error))?;
        if mesh.is_some() {
            let bytes = std::fs::read(&file).map_err(|error| broken(key, &error.into()))?;
            self.remember(path, &file, bytes);
        }
        Ok(mesh)
    }

    fn lines(&self, key: &str, path: &str) -> patterns::Result<Vec<Polyline>> {
        let file = self.find(path);
        let (lines, bytes) =
            crate::input::load_lines(&file).map_err(|error| broken(key, &error))?;
        self.remember(path, &file, bytes);
        Ok(lines)
    }
}

fn broken(key: &str, error: &anyhow::Error) -> Error {
    Error::Input { key: key.into(), reason: format!("{error:#}") }
}
