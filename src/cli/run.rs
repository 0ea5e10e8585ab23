//! `patterns run`: a run from a file.

use super::run_args::RunArgs;
use crate::request::Request;
use anyhow::{Result, bail};
use std::{path::PathBuf, process::ExitCode};

/// Run a TOML file, or repeat the run of a run.json.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: patterns run examples/spots.toml --set size=128 --seed 3")]
pub(super) struct Args {
    /// A TOML file with `command`, `seed` and `[config]`, or a run.json.
    #[arg(required_unless_present = "resume")]
    file: Option<PathBuf>,
    #[command(flatten)]
    run: RunArgs,
}

pub(super) fn main(args: &Args) -> Result<ExitCode> {
    let request = match &args.file {
        None => Request::default(),
        Some(file) if args.run.resume.is_some() => {
            bail!("--resume continues a folder by itself; `{}` is not needed", file.display())
        }
        Some(file) => Request::from_file(file)?,
    };
    if request.command == "reconstruct" {
        return super::reconstruct::repeat(request, &args.run);
    }
    args.run.execute(request)
}
