//! `patterns convert`: between the file formats.

use anyhow::{Result, bail};
use std::{path::PathBuf, process::ExitCode};

/// Convert a field (NPY, NPZ, CSV, VTI, NRRD, NIfTI, MRC, TIFF stack, pictures), a mesh (PLY,
/// STL, OBJ, GLB) or an outline (CSV to DXF or SVG), by the file names' endings.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: patterns convert out/rd-1/b.npy b.vti")]
pub(super) struct Args {
    /// File to read.
    input: PathBuf,
    /// File to write.
    output: PathBuf,
    /// Overwrite the output.
    #[arg(long)]
    force: bool,
}

pub(super) fn main(args: &Args) -> Result<ExitCode> {
    if args.output.exists() && !args.force {
        bail!("`{}` exists; --force overwrites it", args.output.display());
    }
    crate::output::convert(&args.input, &args.output)?;
    Ok(ExitCode::SUCCESS)
}
