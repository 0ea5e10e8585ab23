//! `patterns rd`: reaction-diffusion and the curve that follows its pattern.

use super::{run_args::RunArgs, values};
use crate::request::Request;
use anyhow::{Result, bail};
use clap::ArgGroup;
use std::process::ExitCode;
use toml::Value;

/// Grow a reaction-diffusion pattern and let a curve follow it (Algorithm 1).
#[derive(Debug, clap::Args)]
#[command(
    group = ArgGroup::new("pattern").args(["spots", "stripes", "rings", "labyrinth", "literal", "preset"]),
    after_help = "Examples:\n  \
        patterns rd --spots\n  \
        patterns rd --labyrinth --size 256 --seed 3\n  \
        patterns rd --preset gray-scott-kappa --param feed=0.06\n  \
        patterns rd --spots --size 256 --boundary periodic --dispersion\n  \
        patterns rd --kinetics schnakenberg --growth 0.002"
)]
pub(super) struct Args {
    /// Turing's spots: figure 1.5(a) (the default).
    #[arg(long)]
    spots: bool,
    /// Straight stripes from the centre line.
    #[arg(long)]
    stripes: bool,
    /// Rings around the centre: figure 1.5(b).
    #[arg(long)]
    rings: bool,
    /// A labyrinth.
    #[arg(long)]
    labyrinth: bool,
    /// The spots with the paper's own curve speed, the Laplacian of b (1.16).
    #[arg(long)]
    literal: bool,
    /// A preset of `patterns list rd`.
    #[arg(long, value_name = "NAME")]
    preset: Option<String>,
    /// Kinetics, with its default parameters: turing, gray-scott, schnakenberg, ...
    #[arg(long, value_name = "NAME")]
    kinetics: Option<String>,
    /// Cells: N for a square, NX alone with --line, NYxNX or NZxNYxNX [default: the preset's, 80x80].
    #[arg(long, value_name = "N")]
    size: Option<String>,
    /// One row of --size N cells.
    #[arg(long, requires = "size")]
    line: bool,
    /// Time steps [default: the preset's, 8000].
    #[arg(long, value_name = "N")]
    iterations: Option<u64>,
    /// Time step [default: the preset's, 1].
    #[arg(long, value_name = "T")]
    dt: Option<f64>,
    /// Beyond the border [default: the preset's, neumann].
    #[arg(long, value_parser = ["neumann", "periodic"])]
    boundary: Option<String>,
    /// Precision of the concentrations [default: f64].
    #[arg(long, value_parser = ["f32", "f64"])]
    precision: Option<String>,
    /// Time stepping: explicit, semi-implicit or etdrk4 [default: explicit].
    #[arg(long, value_name = "METHOD")]
    stepper: Option<String>,
    /// A parameter of the kinetics: a number or a picture (repeatable).
    #[arg(long, value_name = "NAME=VALUE")]
    param: Vec<String>,
    /// Diffusion of a species, cells^2/time (repeatable) [default: the preset's].
    #[arg(long, value_name = "SPECIES=VALUE")]
    diffusion: Vec<String>,
    /// Growth rate of the domain, 1/time: cells grow with it, their number stays [default: the
    /// preset's, 0].
    #[arg(long, value_name = "RATE")]
    growth: Option<f64>,
    /// How the length of the domain grows with time t at rate r: exp(r t), 1 + r t, or
    /// logistic, which ends at --growth-limit [default: exponential].
    #[arg(long, value_parser = ["exponential", "linear", "logistic"])]
    growth_law: Option<String>,
    /// Length over that of the start at which logistic growth ends, above 1 [default: none].
    #[arg(long, value_name = "SCALE")]
    growth_limit: Option<f64>,
    /// Let growth not dilute the concentrations.
    #[arg(long)]
    no_dilution: bool,
    /// Start of the curve: circle, border, seeds, or a picture whose dark half is inside
    /// [default: circle].
    #[arg(long, value_name = "START")]
    start: Option<String>,
    /// Start of the curve from a CSV of closed lines: rows x,y (cells from the picture's upper
    /// left corner) with blank lines between loops, or rows loop,x,y as in contour.csv.
    #[arg(long, value_name = "FILE", conflicts_with = "start")]
    contour: Option<String>,
    /// Steps between two redistancings of the curve [default: 20].
    #[arg(long, value_name = "N")]
    redistance_every: Option<u64>,
    /// Iterations whose concentrations are kept, e.g. 0,4000,8000.
    #[arg(long, value_name = "N,N")]
    snapshots: Option<String>,
    /// Stop when under 0.2 % of the signs change in 100 iterations.
    #[arg(long)]
    stop_when_settled: bool,
    /// Growth rate against wavenumber, and the predicted beside the measured wavelength.
    #[arg(long)]
    dispersion: bool,
    #[command(flatten)]
    run: RunArgs,
}

pub(super) fn main(args: &Args) -> Result<ExitCode> {
    let mut request = Request::new("rd", 0);
    let modes = [
        ("spots", args.spots),
        ("stripes", args.stripes),
        ("rings", args.rings),
        ("labyrinth", args.labyrinth),
        ("literal", args.literal),
    ];
    if let Some((name, _)) = modes.iter().find(|(_, given)| *given) {
        request.set("preset", Value::String((*name).into()), &format!("--{name}"))?;
    }
    request.set_flag("preset", args.preset.as_deref())?;
    request.set_flag("kinetics", args.kinetics.as_deref())?;
    if let Some(size) = &args.size {
        request.set("size", values::size(size, if args.line { 1 } else { 2 })?, "--size")?;
    }
    request.set_flag("iterations", values::integer(args.iterations))?;
    request.set_flag("dt", args.dt)?;
    request.set_flag("boundary", args.boundary.as_deref())?;
    request.set_flag("precision", args.precision.as_deref())?;
    request.set_flag("stepper", args.stepper.as_deref())?;
    pairs(&mut request, "parameters", "--param", &args.param)?;
    pairs(&mut request, "diffusion", "--diffusion", &args.diffusion)?;
    growth(&mut request, args)?;
    if let Some(start) = &args.start {
        request.set("curve.start", Value::String(start.clone()), "--start")?;
    }
    if let Some(path) = &args.contour {
        request.set("curve.contour", Value::String(path.clone()), "--contour")?;
    }
    if let Some(every) = values::integer(args.redistance_every) {
        request.set("curve.redistance_every", every.into(), "--redistance-every")?;
    }
    if let Some(text) = &args.snapshots {
        request.set("snapshots", values::integers(text, "--snapshots")?, "--snapshots")?;
    }
    for (key, given) in
        [("stop_when_settled", args.stop_when_settled), ("dispersion", args.dispersion)]
    {
        request.set_flag(key, given.then_some(true))?;
    }
    args.run.execute(request)
}

fn growth(request: &mut Request, args: &Args) -> Result<()> {
    if let Some(rate) = args.growth {
        request.set("growth.rate", rate.into(), "--growth")?;
    }
    if let Some(law) = args.growth_law.as_deref() {
        request.set("growth.law", law.into(), "--growth-law")?;
    }
    if let Some(limit) = args.growth_limit {
        request.set("growth.limit", limit.into(), "--growth-limit")?;
    }
    if args.no_dilution {
        request.set("growth.dilution", false.into(), "--no-dilution")?;
    }
    Ok(())
}

/// `name=value` flags into a table of the configuration.
fn pairs(request: &mut Request, table: &str, flag: &str, pairs: &[String]) -> Result<()> {
    for pair in pairs {
        let Some((name, value)) = pair.split_once('=') else {
            bail!("{flag} {pair}: expected NAME=VALUE");
        };
        let value = match value.trim().parse::<f64>() {
            Ok(number) => Value::Float(number),
            Err(_) => Value::String(value.trim().into()),
        };
        request.set(&format!("{table}.{}", name.trim()), value, &format!("{flag} {pair}"))?;
    }
    Ok(())
}
