//! `patterns figure`: the published figures and the README's pictures.

use crate::figure;
use anyhow::{Result, bail};
use std::{path::PathBuf, process::ExitCode};

/// Regenerate a published figure, or all of them, from examples/*.toml.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: patterns figure 1.5 --out figures")]
pub(super) struct Args {
    /// Id of the figure as in `patterns list`, or `all`.
    id: String,
    /// Folder for the pictures.
    #[arg(long, value_name = "DIR", default_value = "out/figures")]
    out: PathBuf,
    /// Small and short versions, to see that they work.
    #[arg(long)]
    quick: bool,
    /// Print nothing but errors.
    #[arg(long)]
    quiet: bool,
}

pub(super) fn main(args: &Args) -> Result<ExitCode> {
    let figures = figure::all()?;
    let chosen: Vec<_> =
        figures.iter().filter(|f| args.id == "all" || f.caption.id == args.id).collect();
    if chosen.is_empty() {
        let known: Vec<_> = figures.iter().map(|f| f.caption.id.as_str()).collect();
        bail!("no figure `{}`; known figures: {}, all", args.id, known.join(", "));
    }
    for figure in chosen {
        let path = figure::make(figure, &args.out, args.quick)?;
        if !args.quiet {
            println!("{}: {}", path.display(), figure.caption.title);
        }
    }
    Ok(ExitCode::SUCCESS)
}
