//! `patterns topopt`: topology optimization.

use super::{run_args::RunArgs, topopt_table, values};
use crate::request::{Request, find_model};
use anyhow::{Context as _, Result, bail};
use clap::ArgGroup;
use std::{io::Write as _, path::PathBuf, process::ExitCode};
use toml::{Table, Value};

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
    /// The problem as its source prints it, without interpretations.
    #[arg(long)]
    as_printed: bool,
    /// All loads at once, as one load case.
    #[arg(long)]
    one_case: bool,
    /// simp: a density per element; level-set: a front that moves [default: simp].
    #[arg(long, value_parser = ["simp", "level-set"])]
    method: Option<String>,
    /// Material as a fraction of the box, in (0, 1) [default: the problem's, 0.5].
    #[arg(long, value_name = "FRACTION")]
    volume: Option<f64>,
    /// What is made small [default: the problem's, compliance].
    #[arg(long, value_parser = ["compliance", "displacement", "stress"])]
    objective: Option<String>,
    /// Load cases: their weighted sum, or the worst (mma, gcmma) [default: sum].
    #[arg(long, value_parser = ["sum", "worst"])]
    cases: Option<String>,
    /// Density limits and bisection as in the 99 or the 88 lines [default: the problem's, 88].
    #[arg(long, value_parser = ["99", "88"])]
    rules: Option<String>,
    /// Stiffness by density [default: modified; simp by the 99 rules].
    #[arg(long, value_parser = ["simp", "modified", "ramp"])]
    interpolation: Option<String>,
    /// Exponent p (q of ramp), in [0, 20] [default: 3].
    #[arg(long, value_name = "P")]
    penalization: Option<f64>,
    /// Filter [default: the problem's, sensitivity].
    #[arg(long, value_parser = ["none", "sensitivity", "density", "helmholtz"])]
    filter: Option<String>,
    /// Radius of the filter, elements, at least 1 [default: the problem's, 1.5].
    #[arg(long, value_name = "ELEMENTS")]
    filter_radius: Option<f64>,
    /// Sharpest step of the filtered densities (beta), doubled from 1 every 50 iterations
    /// [default: no step].
    #[arg(long, value_name = "BETA")]
    projection: Option<f64>,
    /// Robust design: steps at 0.5 - DELTA, 0.5, 0.5 + DELTA, the worst counts (mma, gcmma).
    #[arg(long, value_name = "DELTA", requires = "projection")]
    robust: Option<f64>,
    /// Update of the design [default: oc].
    #[arg(long, value_parser = ["oc", "mma", "gcmma"])]
    optimizer: Option<String>,
    /// Largest change of a density in an iteration, in (0, 1] [default: 0.2].
    #[arg(long, value_name = "CHANGE")]
    move_limit: Option<f64>,
    /// The run ends when no density changes more than this [default: 0.01].
    #[arg(long, value_name = "CHANGE")]
    tolerance: Option<f64>,
    /// Most iterations [default: 1000].
    #[arg(long, value_name = "N")]
    iterations: Option<u64>,
    /// Linear solver [default: auto, by size].
    #[arg(long, value_parser = ["auto", "direct", "multigrid"])]
    solver: Option<String>,
    #[command(flatten)]
    run: RunArgs,
}

pub(super) fn main(args: &Args) -> Result<ExitCode> {
    if args.list {
        return list();
    }
    let mut request = Request::new("topopt", 0);
    if args.table.as_deref() == Some("all") {
        args.settings(&mut request)?;
        return topopt_table::all(&request, &args.run);
    }
    match (&args.table, &args.problem) {
        (Some(name), _) => request.preset(name)?,
        (None, Some(path)) => request.read_config(path)?,
        (None, None) => args.shortcut(&mut request)?,
    }
    args.settings(&mut request)?;
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

    /// The flags that are keys of the configuration.
    fn settings(&self, request: &mut Request) -> Result<()> {
        request.set_flag("as_printed", self.as_printed.then_some(true))?;
        request.set_flag("one_case", self.one_case.then_some(true))?;
        request.set_flag("method", self.method.as_deref())?;
        request.set_flag("volume", self.volume)?;
        request.set_flag("objective", self.objective.as_deref())?;
        request.set_flag("cases", self.cases.as_deref())?;
        request.set_flag("rules", self.rules.as_deref())?;
        request.set_flag("interpolation", self.interpolation.as_deref())?;
        request.set_flag("penalization", self.penalization)?;
        request.set_flag("filter", self.filter.as_deref())?;
        request.set_flag("filter_radius", self.filter_radius)?;
        if self.rules.is_some() && self.interpolation.is_none() {
            let kind = if self.rules.as_deref() == Some("99") { "simp" } else { "modified" };
            request.set("interpolation", Value::String(kind.into()), "--rules")?;
        }
        if let Some(beta) = self.projection {
            let mut table = Table::new();
            table.insert("beta_max".into(), Value::Float(beta));
            table.insert("delta".into(), Value::Float(self.robust.unwrap_or(0.0)));
            request.set("projection", Value::Table(table), "--projection")?;
        }
        request.set_flag("optimizer", self.optimizer.as_deref())?;
        request.set_flag("move_limit", self.move_limit)?;
        request.set_flag("tolerance", self.tolerance)?;
        request.set_flag("iterations", values::integer(self.iterations))?;
        request.set_flag("solver", self.solver.as_deref())
    }
}

fn list() -> Result<ExitCode> {
    let mut out = std::io::stdout().lock();
    for preset in (find_model("topopt")?.presets)() {
        writeln!(out, "{:16} {}", preset.name, preset.about)?;
    }
    Ok(ExitCode::SUCCESS)
}
