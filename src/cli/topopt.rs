//! `patterns topopt`: topology optimization.

use super::{run_args::RunArgs, topopt_settings::Settings, topopt_table};
use crate::request::{Request, find_model};
use anyhow::{Context as _, Result, bail};
use clap::ArgGroup;
use std::{io::Write as _, path::PathBuf, process::ExitCode};
use toml::Value;

/// Optimize where material goes in a box, so that a structure is stiff.
#[derive(Debug, clap::Args)]
#[command(
    group = ArgGroup::new("what").args(["table", "problem", "mbb", "cantilever", "list"]),
    after_help = "Examples:\n  \
        patterns topopt --table row-c\n  \
        patterns topopt --table all\n  \
        patterns topopt --mbb 150x50 --filter-radius 3 --filter density\n  \
        patterns topopt --table row-a --compare\n  \
        patterns topopt --problem my-problem.toml"
)]
pub(super) struct Args {
    /// A problem of --list: row-a to row-q of Table 1.1, mbb, cantilever, ...; `all`: every
    /// row on one sheet.
    #[arg(long, value_name = "NAME")]
    table: Option<String>,
    /// A problem as a TOML file of the same form as the database's.
    #[arg(long, value_name = "FILE")]
    problem: Option<PathBuf>,
    /// Half of the MBB beam with that many elements, e.g. 60x20.
    #[arg(long, value_name = "NXxNY")]
    mbb: Option<String>,
    /// Cantilever loaded at its lower corner with that many elements, e.g. 32x20.
    #[arg(long, value_name = "NXxNY")]
    cantilever: Option<String>,
    /// List the problems of the database.
    #[arg(long)]
    list: bool,
    /// Run SIMP and the level set, and measure both in black and white at the same volume.
    #[arg(long, conflicts_with = "method")]
    compare: bool,
    #[command(flatten)]
    settings: Settings,
    #[command(flatten)]
    run: RunArgs,
}

pub(super) fn main(args: &Args) -> Result<ExitCode> {
    if args.list {
        return list();
    }
    let mut request = Request::new("topopt", 0);
    if args.table.as_deref() == Some("all") {
        args.settings.apply(&mut request)?;
        return topopt_table::all(&request, &args.run);
    }
    match (&args.table, &args.problem) {
        (Some(name), _) => request.preset(name)?,
        (None, Some(path)) => request.read_config(path)?,
        (None, None) => args.shortcut(&mut request)?,
    }
    args.settings.apply(&mut request)?;
    if args.compare {
        return topopt_table::compare(&request, &args.run);
    }
    args.run.execute(request)
}

impl Args {
    /// `--mbb` and `--cantilever`: a problem of the database with other numbers of elements.
    fn shortcut(&self, request: &mut Request) -> Result<()> {
        let (name, flag, text) = match (&self.mbb, &self.cantilever) {
            (Some(text), _) => ("mbb", "--mbb", text),
            (None, Some(text)) => ("cantilever", "--cantilever", text),
            (None, None) => return Ok(()),
        };
        let numbers: Option<Vec<i64>> = text.split('x').map(|n| n.trim().parse().ok()).collect();
        let Some([nx, ny]) = numbers.as_deref().filter(|n| n.iter().all(|&n| n > 0 && n < 1 << 30))
        else {
            bail!("{flag} {text}: expected NXxNY, whole numbers above 0");
        };
        request.preset(name)?;
        let list = |a: i64, b: i64| Value::Array(vec![Value::Integer(a), Value::Integer(b)]);
        let corner = list(nx + 1, ny + 1);
        request.set("problem.elements", list(*nx, *ny), flag)?;
        let problem = request.config.get_mut("problem").and_then(Value::as_table_mut);
        let problem =
            problem.with_context(|| format!("`{name}` of the database has no problem"))?;
        let (part, entry) = if name == "mbb" { ("support", 1) } else { ("load", 0) };
        let entries = problem.get_mut(part).and_then(Value::as_array_mut);
        let entry = entries.and_then(|entries| entries.get_mut(entry)?.as_table_mut());
        let entry = entry.with_context(|| format!("`{name}` of the database has no corner"))?;
        entry.insert("node".into(), corner);
        Ok(())
    }
}

fn list() -> Result<ExitCode> {
    let mut out = std::io::stdout().lock();
    for preset in (find_model("topopt")?.presets)() {
        writeln!(out, "{:16} {}", preset.name, preset.about)?;
    }
    Ok(ExitCode::SUCCESS)
}
