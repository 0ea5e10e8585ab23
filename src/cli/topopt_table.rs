//! Several problems of `patterns topopt` on one sheet and in one table.

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
use toml::Value;

/// Panels side by side on the sheet.
const COLUMNS: usize = 4;

/// Every row of Table 1.1 with the settings of `request`; rows that are refused are listed
/// with the reason.
pub(super) fn all(request: &Request, args: &RunArgs) -> Result<ExitCode> {
    let mut runs = Vec::new();
    for preset in (find_model("topopt")?.presets)() {
        if preset.name.starts_with("row-") {
            let mut row = request.clone();
            row.config.insert("table".into(), Value::String(preset.name.into()));
            runs.push((preset.name.to_owned(), row));
        }
    }
    sheet_of(runs, args)
}

/// SIMP and the level set on the problem of `request`, both measured in black and white.
pub(super) fn compare(request: &Request, args: &RunArgs) -> Result<ExitCode> {
    let runs = ["simp", "level-set"].map(|method| {
        let mut run = request.clone();
        run.config.insert("method".into(), Value::String(method.into()));
        (method.to_owned(), run)
    });
    sheet_of(runs.into(), args)
}

fn sheet_of(runs: Vec<(String, Request)>, args: &RunArgs) -> Result<ExitCode> {
    if args.resume.is_some() || args.json {
        bail!("a sheet of several runs takes neither --resume nor --json");
    }
    let pool = thread_pool(args.threads)?;
    let mut folder = Folder::create(args.out.as_deref(), "topopt", args.force)?;
    let result = pool.install(|| write(runs, args, &mut folder));
    if result.is_err() {
        folder.discard();
    }
    result
}

fn write(runs: Vec<(String, Request)>, args: &RunArgs, folder: &mut Folder) -> Result<ExitCode> {
    let mut out = std::io::stdout().lock();
    let mut panels = Vec::new();
    let mut table = String::from(
        "run,compliance,compliance_final,compliance_thresholded,volume,iterations,status\n",
    );
    for (name, mut request) in runs {
        for assignment in &args.set {
            request.set_text(assignment)?;
        }
        let to = folder.path().join(&name);
        let options =
            Options { out: Some(to.clone()), force: true, frames: 0, ..Options::default() };
        match runner::run(&request, &options) {
            Ok(outcome) => {
                let manifest = &outcome.manifest;
                let value = |name: &str| manifest.metrics.get(name).copied().unwrap_or(f64::NAN);
                let [c, last, black, volume] =
                    ["compliance", "compliance_final", "compliance_thresholded", "volume"]
                        .map(value);
                let n = manifest.iterations;
                let done = manifest.status == RunStatus::Done;
                let status = if done { "done" } else { "not converged" };
                writeln!(table, "{name},{c:.4},{last:.4},{black:.4},{volume:.4},{n},{status}")?;
                writeln!(
                    out,
                    "{name:10} c {c:9.4}  black and white {black:9.4}  volume {volume:.3}  \
                     {n:4} iterations  {status}"
                )?;
                let file = to.join("ink.png");
                let picture = std::fs::read(&file)
                    .with_context(|| format!("cannot read `{}`", file.display()))?;
                panels.push((format!("{name}: c = {c:.4}"), picture));
            }
            Err(error) => {
                let reason = format!("{error:#}");
                writeln!(table, "{name},,,,,,refused: {}", reason.replace(',', ";"))?;
                writeln!(out, "{name:10} refused: {reason}")?;
            }
        }
    }
    if panels.is_empty() {
        bail!("every run was refused");
    }
    folder.write("table.csv", table.as_bytes())?;
    let rows: Vec<_> = panels.chunks(COLUMNS).map(<[_]>::to_vec).collect();
    folder.write("table.png", &sheet::encode(&rows, None)?)?;
    writeln!(out, "sheet: {}", folder.path().join("table.png").display())?;
    Ok(ExitCode::SUCCESS)
}
