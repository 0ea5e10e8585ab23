//! `patterns list`: what there is.

use anyhow::Result;
use patterns::MODELS;
use std::{
    io::{self, Write as _},
    process::ExitCode,
};

/// List models, presets and figures.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: patterns list rd")]
pub(super) struct Args {
    /// Only this model.
    model: Option<String>,
}

pub(super) fn main(args: &Args) -> Result<ExitCode> {
    let mut out = io::stdout().lock();
    if let Some(name) = &args.model {
        show(&mut out, crate::request::find_model(name)?)?;
        return Ok(ExitCode::SUCCESS);
    }
    for model in MODELS {
        show(&mut out, model)?;
    }
    writeln!(out, "figures (patterns figure ID)")?;
    for figure in crate::figure::all()? {
        writeln!(out, "  {:24} {}", figure.caption.id, figure.caption.title)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn show(out: &mut impl io::Write, model: &patterns::Model) -> io::Result<()> {
    writeln!(out, "{}: {}", model.name, model.about)?;
    writeln!(out, "  source: {}", model.paper)?;
    for preset in (model.presets)() {
        writeln!(out, "  {:24} {}", preset.name, preset.about)?;
    }
    writeln!(out)
}
