//! tmp
use anyhow::Result;
use std::process::ExitCode;
/// tmp
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: x")]
pub(super) struct Args {}
pub(super) fn main(_: &Args) -> Result<ExitCode> {
    Ok(ExitCode::SUCCESS)
}
