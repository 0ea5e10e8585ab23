//! The classes that pictures are compared with: those that the program carries and a folder's.

use crate::inputs::FileInputs;
use anyhow::{Context as _, Result};
use patterns::disocclusion::{self, Calibration, Class, Database};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// The carried classes and those of `folder`: a TOML file each, and beside it, for a class whose
/// seed is free, the calibration that `patterns database add` makes.
///
/// # Errors
/// With the file's name, if one cannot be read or is wrong, or a calibration is missing.
pub fn load(folder: Option<&Path>) -> Result<(Database, Calibration)> {
    let (mut database, mut calibration) = (Database::built_in()?, disocclusion::built_in()?);
    let Some(folder) = folder else { return Ok((database, calibration)) };
    let entries = fs::read_dir(folder)
        .with_context(|| format!("--database {}: cannot read the folder", folder.display()))?;
    let mut files: Vec<PathBuf> = entries.filter_map(|e| Some(e.ok()?.path())).collect();
    files.retain(|path| path.extension().is_some_and(|e| e == "toml"));
    files.sort();
    for file in files {
        let text = read(&file, fs::read_to_string)?;
        let free = database.add(&file.display().to_string(), &text, &inputs_of(&file))?.free_seeds;
        if free {
            let bin = file.with_extension("bin");
            let own = Calibration::from_bytes(&read(&bin, fs::read)?)
                .with_context(|| format!("`{}`", bin.display()))?;
            calibration.classes.extend(own.classes);
        }
    }
    Ok((database, calibration))
}

/// Reads a class from a file and runs it at the ends of its ranges.
///
/// # Errors
/// With the file's name and the key that is wrong.
pub fn check(file: &Path) -> Result<Class> {
    let text = read(file, fs::read_to_string)?;
    let inputs = inputs_of(file);
    let checked = Class::parse(&text, &inputs).and_then(|class| {
        class.check(&inputs)?;
        Ok(class)
    });
    checked.with_context(|| format!("`{}`", file.display()))
}

/// Files that a class names are looked up beside it.
pub fn inputs_of(file: &Path) -> FileInputs {
    FileInputs::new(vec![file.parent().unwrap_or(Path::new(".")).to_path_buf()])
}

fn read<T>(file: &Path, how: impl Fn(PathBuf) -> std::io::Result<T>) -> Result<T> {
    how(file.to_path_buf()).with_context(|| format!("cannot read `{}`", file.display()))
}
