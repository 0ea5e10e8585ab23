//! Files that people open: pictures, plots, animations, arrays, meshes.
//!
//! Every writer is a pure function from a value to bytes (or to `impl Write`);
//! [`save`] alone touches the disk.

pub mod animation;
mod axes;
pub mod canvas;
pub mod colormap;
pub mod convert;
pub mod csv;
pub mod dxf;
pub(crate) mod font;
pub mod glb;
pub mod mesh;
pub mod mrc;
pub mod nifti;
pub mod npy;
pub mod nrrd;
pub mod picture;
pub mod plot;
mod slice;
pub mod surface;
pub mod svg;
pub mod tiff;
pub mod volume;
pub mod vti;

use anyhow::{Context as _, Result};
use std::{
    fs::{self, File},
    io::{BufWriter, Write as _},
    path::Path,
};

pub use animation::Animation;
pub use convert::convert;

/// What a writer of [`save`] writes to: buffered, seekable.
pub type Sink = BufWriter<File>;

/// Writes `path` so that it holds either all of what `write` writes or what it held before.
///
/// `write` fills a file of a temporary name in the same folder, which then replaces `path`.
///
/// # Errors
/// If `write` fails or the disk does (full, read-only, no such folder); the temporary
/// file is gone then, and the message names `path`.
pub fn save(path: &Path, write: impl FnOnce(&mut Sink) -> Result<()>) -> Result<()> {
    let name = path.file_name().with_context(|| format!("`{}` is no file name", path.display()))?;
    let mut temporary = name.to_os_string();
    temporary.push(format!(".{}.partial", std::process::id()));
    let temporary = path.with_file_name(temporary);
    let result = fill(&temporary, write)
        .and_then(|()| fs::rename(&temporary, path).context("replacing the old file"));
    result.map_err(|error| {
        // It may not have come to exist; the first error is the one to report.
        let _ = fs::remove_file(&temporary);
        error.context(format!("cannot write `{}`", path.display()))
    })
}

/// [`save`] of bytes.
///
/// # Errors
/// As [`save`].
pub fn save_bytes(path: &Path, bytes: &[u8]) -> Result<()> {
    save(path, |sink| Ok(sink.write_all(bytes)?))
}

/// Creates `path` and writes it, with the errors that only a flush reports.
fn fill(path: &Path, write: impl FnOnce(&mut Sink) -> Result<()>) -> Result<()> {
    let mut sink = BufWriter::with_capacity(1 << 16, File::create(path)?);
    write(&mut sink)?;
    sink.flush()?;
    Ok(())
}
