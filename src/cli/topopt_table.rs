//! `patterns topopt --table all`: every row of Table 1.1, on one sheet and in one table.

use super::run_args::{RunArgs, thread_pool};
use crate::{
    figure::sheet,
    folder::Folder,
    manifest::RunStatus,
    request::{Request, find_model},
    runner::{self, Options},
};
use anyhow::{Context as _, Result, bail};
use std::{fmt::Write as _, io::Write as _, process::ExitCode};

/// Panels side by side on the sheet.
const COLUMNS: usize = 4;

/// Runs every row with the settings of `request`; rows that are refused are listed with
/// the reason.
pub(super) fn main(request: &Request, args: &RunArgs) -> Result<ExitCode> {
    if args.resume.is_some() || args.json {
        bail!("--table all runs every row anew: --resume and --json are for a single problem");
    }
    let pool = thread_pool(args.threads)?;
    let mut folder = Folder::create(args.out.as_deref(), "topopt", args.force)?;
    let result = pool.install(|| rows(request, args, &mut folder));
    if result.is_err() {
        folder.discard();
    }
    result
}

fn rows(request: &Request, args: &RunArgs, folder: &mut Folder) -> Result<ExitCode> {
    let mut out = std::io::stdout().lock();
    let mut panels = Vec::new();
    let mut table = String::from("row,compliance,compliance_final,volume,iterations,status\n");
    for preset in (find_model("topopt")?.presets)() {
        if !preset.name.starts_with("row-") {
            continue;
        }
        let mut row = request.clone();
        row.preset(preset.name)?;
        row.config.extend(request.config.clone());
        for assignment in &args.set {
            row.set_text(assignment)?;
        }
        let to = folder.path().join(preset.name);
        let options =
            Options { out: Some(to.clone()), force: true, frames: 0, ..Options::default() };
        match runner::run(&row, &options) {
            Ok(outcome) => {
                let metrics = &outcome.manifest.metrics;
                let value = |name: &str| metrics.get(name).copied().unwrap_or(f64::NAN);
                let (c, last, volume) =
                    (value("compliance"), value("compliance_final"), value("volume"));
                let n = outcome.manifest.iterations;
                let done = outcome.manifest.status == RunStatus::Done;
                let status = if done { "done" } else { "not converged" };
                writeln!(table, "{},{c:.4},{last:.4},{volume:.4},{n},{status}", preset.name)?;
                writeln!(
                    out,
                    "{}  c {c:9.4}  volume {volume:.3}  {n:4} iterations  {status}",
                    preset.name
                )?;
                let file = to.join("ink.png");
                let picture = std::fs::read(&file)
                    .with_context(|| format!("cannot read `{}`", file.display()))?;
                panels.push((format!("{}: c = {c:.4}", preset.name), picture));
            }
            Err(error) => {
                let reason = format!("{error:#}");
                writeln!(table, "{},,,,,refused: {}", preset.name, reason.replace(',', ";"))?;
                writeln!(out, "{}  refused: {reason}", preset.name)?;
            }
        }
    }
    if panels.is_empty() {
        bail!("every row was refused");
    }
    folder.write("table.csv", table.as_bytes())?;
    folder.write("table.png", &sheet::encode(&panels, COLUMNS)?)?;
    writeln!(out, "sheet: {}", folder.path().join("table.png").display())?;
    Ok(ExitCode::SUCCESS)
}
