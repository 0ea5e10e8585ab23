//! `patterns curvature`: textures in space from an energy of curvatures.

use super::{curvature_atlas, curvature_infer, run_args::RunArgs, values};
use crate::request::Request;
use anyhow::{Result, bail};
use std::process::ExitCode;
use toml::{Table, Value};

/// Grow tubes, membranes and sponges from the phase-field energy of curvatubes.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
#[command(after_help = "Examples:\n  \
    patterns curvature --preset tubes\n  \
    patterns curvature --preset bilayers --size 64 --flow paper --evaluations 2000\n  \
    patterns curvature --coefficients 1,2,6,-40,-40,400 --mass=-0.6\n  \
    patterns curvature --squares h2=1,h0=20,t=5 --mass=-0.6\n  \
    patterns curvature --preset tubes --orientation 1000 --direction 0,0,1\n  \
    patterns curvature atlas --count 60 --size 32\n  \
    patterns curvature infer volume.npy")]
pub(super) struct Args {
    #[command(subcommand)]
    task: Option<Task>,
    /// A preset of `patterns list curvature` [default: tubes].
    #[arg(long, value_name = "NAME")]
    preset: Option<String>,
    /// a20,a11,a02,b10,b01,c of the energy a20 k1^2 + a11 k1 k2 + a02 k2^2 + b10 k1 + b01 k2 + c.
    #[arg(long, value_name = "A,..", allow_hyphen_values = true, conflicts_with = "squares")]
    coefficients: Option<String>,
    /// The energy as h2 (H - h0)^2 + k1 K + s (kappa1 - kappa1_0)^2 + t (kappa2 - kappa2_0)^2:
    /// any of these letters, 0 if absent; H = kappa1 + kappa2, kappa1 the larger, in 1/length.
    #[arg(long, value_name = "KEY=VALUE,..", conflicts_with = "preset")]
    squares: Option<String>,
    /// Mean of the phase, in (-1, 1): a part (1 + mass) / 2 of the box is inside
    /// [default: the preset's].
    #[arg(long, value_name = "MASS", allow_hyphen_values = true)]
    mass: Option<f64>,
    /// Voxels: N or NZxNYxNX [default: 100].
    #[arg(long, value_name = "N")]
    size: Option<String>,
    /// Width of a voxel [default: 0.01].
    #[arg(long, value_name = "LENGTH")]
    spacing: Option<f64>,
    /// Width of the phase transition, at least a voxel [default: 0.02].
    #[arg(long, value_name = "LENGTH")]
    epsilon: Option<f64>,
    /// Descent: fast (preconditioned Adam), paper (Adam on a vector potential), l2 (L-BFGS),
    /// l2-mass (L-BFGS, the mass kept) [default: fast].
    #[arg(long, value_parser = ["fast", "paper", "l2", "l2-mass"])]
    flow: Option<String>,
    /// Evaluations of the energy; the fast flow's steps shrink to 0 in as many, and where they are
    /// more it anneals further than the paper, towards ordered textures [default: 800; paper:
    /// 8000].
    #[arg(long, value_name = "N")]
    evaluations: Option<u64>,
    /// Those of the published flow at the beginning of the fast one from noise: they choose the
    /// texture that the paper's would; the longer, the more of it is kept [default: a quarter of
    /// --evaluations, at most 200].
    #[arg(long, value_name = "N")]
    opening: Option<u64>,
    /// Step of the method [default: fast .5, without an opening 1; paper .001]; the fast flow halves
    /// one that lets the energy rise by a quarter after an opening, to twice without.
    #[arg(long, value_name = "RATE")]
    rate: Option<f64>,
    /// The flow ends when the energy changes by less than this fraction in 50 evaluations
    /// [default: 0, never].
    #[arg(long, value_name = "FRACTION")]
    tolerance: Option<f64>,
    /// Standard deviation of the blur, voxels; 0 for none, not from noise [default: 2].
    #[arg(long, value_name = "VOXELS")]
    blur: Option<f64>,
    /// Beyond the box [default: periodic].
    #[arg(long, value_parser = ["periodic", "replicated", "free"])]
    boundary: Option<String>,
    /// Precision of the fields [default: f32].
    #[arg(long, value_parser = ["f32", "f64"])]
    precision: Option<String>,
    /// Weight mu of the penalty on normals along --direction [default: 0].
    #[arg(long, value_name = "MU", requires = "direction")]
    orientation: Option<f64>,
    /// Direction x,y,z that tubes and layers shall follow.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, requires = "orientation")]
    direction: Option<String>,
    /// An array of the box's size whose voxels above 0.5 the shape contains.
    #[arg(long, value_name = "FILE")]
    include: Option<String>,
    /// An array of the box's size whose voxels above 0.5 the shape avoids.
    #[arg(long, value_name = "FILE")]
    exclude: Option<String>,
    /// Start from a phase: an array of the box's size, about -1 outside and 1 inside
    /// [default: noise].
    #[arg(long, value_name = "FILE")]
    start: Option<String>,
    /// Level of the surface that is measured and written, in (-1, 1) [default: 0].
    #[arg(long, value_name = "LEVEL", allow_hyphen_values = true)]
    level: Option<f64>,
    /// Pictures of a film around the final shape, shape.gif; 0 for none [default: 0].
    #[arg(long, value_name = "N")]
    turntable: Option<u64>,
    #[command(flatten)]
    run: RunArgs,
}

/// What else there is to do with textures.
#[derive(Debug, clap::Subcommand)]
enum Task {
    Atlas(Box<curvature_atlas::Args>),
    Infer(Box<curvature_infer::Args>),
}

pub(super) fn main(args: &Args) -> Result<ExitCode> {
    match &args.task {
        Some(Task::Atlas(args)) => return curvature_atlas::main(args),
        Some(Task::Infer(args)) => return curvature_infer::main(args),
        None => {}
    }
    let mut request = Request::new("curvature", 0);
    if let Some(preset) = &args.preset {
        request.preset(preset)?;
    } else if args.coefficients.is_none() && args.squares.is_none() && args.run.resume.is_none() {
        request.preset("tubes")?;
    }
    if let Some(text) = &args.coefficients {
        let list = values::list(text, "--coefficients")?;
        request.set("coefficients", list, "--coefficients")?;
    }
    if let Some(text) = &args.squares {
        request.set("squares", squares(text)?, "--squares")?;
    }
    if let Some(size) = &args.size {
        request.set("size", values::size(size, 3)?, "--size")?;
    }
    if let (Some(weight), Some(direction)) = (args.orientation, &args.direction) {
        let mut table = Table::new();
        table.insert("weight".into(), Value::Float(weight));
        table.insert("direction".into(), values::list(direction, "--direction")?);
        request.set("orientation", Value::Table(table), "--orientation")?;
    }
    if let Some(path) = &args.start {
        let mut table = Table::new();
        table.insert("kind".into(), Value::String("file".into()));
        table.insert("path".into(), Value::String(path.clone()));
        request.set("start", Value::Table(table), "--start")?;
    }
    request.set_flag("mass", args.mass)?;
    request.set_flag("spacing", args.spacing)?;
    request.set_flag("epsilon", args.epsilon)?;
    request.set_flag("flow", args.flow.as_deref())?;
    let paper = (args.flow.as_deref() == Some("paper")).then_some(8000);
    request.set_flag("evaluations", values::integer(args.evaluations.or(paper)))?;
    request.set_flag("opening", values::integer(args.opening))?;
    request.set_flag("rate", args.rate)?;
    request.set_flag("tolerance", args.tolerance)?;
    request.set_flag("blur", args.blur)?;
    request.set_flag("boundary", args.boundary.as_deref())?;
    request.set_flag("precision", args.precision.as_deref())?;
    request.set_flag("include", args.include.as_deref())?;
    request.set_flag("exclude", args.exclude.as_deref())?;
    request.set_flag("level", args.level)?;
    request.set_flag("turntable", values::integer(args.turntable))?;
    args.run.execute(request)
}

/// `key=value,...` as a table; the configuration refuses unknown keys.
fn squares(text: &str) -> Result<Value> {
    let mut table = Table::new();
    for part in text.split(',') {
        let number = part.split_once('=').and_then(|(_, value)| value.trim().parse::<f64>().ok());
        let (Some((key, _)), Some(number)) = (part.split_once('='), number) else {
            bail!("--squares {text}: expected KEY=NUMBER, found `{part}`");
        };
        table.insert(key.trim().into(), Value::Float(number));
    }
    Ok(Value::Table(table))
}
