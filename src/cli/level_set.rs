//! `patterns level-set`: the engine by itself.

use super::{run_args::RunArgs, values};
use crate::request::Request;
use anyhow::{Result, bail};
use std::process::ExitCode;
use toml::{Table, Value};

/// Move the contour of a shape or a picture at a chosen speed.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    patterns level-set --shape star --speed curvature\n  \
    patterns level-set --image drawing.png --speed constant=1 --time 20\n  \
    patterns level-set --shape square --union circle,x=150,size=30 --subtract star,size=20\n  \
    patterns level-set --preset zalesak")]
pub(super) struct Args {
    /// A preset of `patterns list level-set`.
    #[arg(long, value_name = "NAME")]
    preset: Option<String>,
    /// Nodes: N, NYxNX or NZxNYxNX [default: 200x200].
    #[arg(long, value_name = "N")]
    size: Option<String>,
    /// Start: circle, ellipse, square, star, flower, annulus, zalesak, dumbbell [default: star].
    #[arg(long, value_name = "NAME", conflicts_with = "image")]
    shape: Option<String>,
    /// Start from a picture or array; its dark part (below --level) is inside.
    #[arg(long, value_name = "FILE")]
    image: Option<String>,
    /// Grey level of the contour in the picture, 0 black to 1 white [default: 0.5].
    #[arg(long, value_name = "GREY")]
    level: Option<f64>,
    /// Start from a CSV of closed lines: rows x,y (cells from the picture's upper left corner)
    /// with blank lines between loops, or rows loop,x,y as in contour.csv.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["shape", "image"])]
    contour: Option<String>,
    /// Add a shape to the start (repeatable): NAME with any of ,x=CELLS ,y=CELLS ,z=CELLS (its
    /// middle) ,size=CELLS (radius or half side) ,turn=DEGREES
    /// [default: the grid's middle, size 30 % of its least side].
    #[arg(long, value_name = "NAME[,KEY=VALUE]")]
    union: Vec<String>,
    /// Cut the start to a shape, after all --union (repeatable, written as there).
    #[arg(long, value_name = "NAME[,KEY=VALUE]")]
    intersect: Vec<String>,
    /// Take a shape away from the start, after all --intersect (repeatable, written as --union).
    #[arg(long, value_name = "NAME[,KEY=VALUE]")]
    subtract: Vec<String>,
    /// A speed, repeatable and added up: constant=V (cells/time, positive outwards),
    /// curvature[=B] (cells^2/time), image=FILE (0 to 1 cells/time), rotation=RATE
    /// (radians/time), vortex=PERIOD, translation=VX,VY (cells/time)
    /// [default: curvature=1].
    #[arg(long, value_name = "KIND[=VALUE]")]
    speed: Vec<String>,
    /// Time at the end [default: 500].
    #[arg(long, value_name = "T")]
    time: Option<f64>,
    /// Slices of the time, each a frame and a possible checkpoint [default: 200].
    #[arg(long, value_name = "N")]
    iterations: Option<u64>,
    /// Order of the differences [default: weno5].
    #[arg(long, value_parser = ["first", "weno5"])]
    order: Option<String>,
    /// Beyond the border [default: neumann].
    #[arg(long, value_parser = ["neumann", "periodic", "extrapolate"])]
    boundary: Option<String>,
    /// Fraction of the largest stable time step, in (0, 1] [default: 0.5].
    #[arg(long, value_name = "FRACTION")]
    cfl: Option<f64>,
    /// Slices between two redistancings, 0 for none [default: 10].
    #[arg(long, value_name = "N")]
    redistance_every: Option<u64>,
    /// Half-width of the narrow band that moves, at least 6 cells [default: the whole grid].
    #[arg(long, value_name = "CELLS")]
    band: Option<f64>,
    /// Least |grad phi| in the speed term, so that the front can nucleate [default: none].
    #[arg(long, value_name = "SLOPE")]
    gradient_floor: Option<f64>,
    /// Bound on |phi| [default: none].
    #[arg(long, value_name = "CELLS")]
    clip: Option<f64>,
    #[command(flatten)]
    run: RunArgs,
}

pub(super) fn main(args: &Args) -> Result<ExitCode> {
    let mut request = Request::new("level-set", 0);
    if let Some(preset) = &args.preset {
        request.preset(preset)?;
    }
    if let Some(size) = &args.size {
        request.set("size", values::size(size, 2)?, "--size")?;
    }
    if !args.speed.is_empty() {
        let speeds: Result<Vec<Value>> = args.speed.iter().map(|text| speed(text)).collect();
        request.set("speed", Value::Array(speeds?), "--speed")?;
    }
    request.set_flag("shape", args.shape.as_deref())?;
    request.set_flag("image", args.image.as_deref())?;
    request.set_flag("contour", args.contour.as_deref())?;
    for (key, given) in
        [("union", &args.union), ("intersect", &args.intersect), ("subtract", &args.subtract)]
    {
        let flag = format!("--{key}");
        let shapes: Result<Vec<Value>> = given.iter().map(|text| shape(text, &flag)).collect();
        let shapes = shapes?;
        request.set_flag(key, (!shapes.is_empty()).then_some(Value::Array(shapes)))?;
    }
    request.set_flag("level", args.level)?;
    request.set_flag("time", args.time)?;
    request.set_flag("iterations", values::integer(args.iterations))?;
    request.set_flag("order", args.order.as_deref())?;
    request.set_flag("boundary", args.boundary.as_deref())?;
    request.set_flag("cfl", args.cfl)?;
    request.set_flag("redistance_every", values::integer(args.redistance_every))?;
    request.set_flag("band", args.band)?;
    request.set_flag("gradient_floor", args.gradient_floor)?;
    request.set_flag("clip", args.clip)?;
    args.run.execute(request)
}

/// `name[,key=value]` as the table that the configuration wants.
fn shape(text: &str, flag: &str) -> Result<Value> {
    let mut parts = text.split(',').map(str::trim);
    let mut table = Table::new();
    table.insert("name".into(), Value::String(parts.next().unwrap_or_default().into()));
    for part in parts {
        let (key, value) = part.split_once('=').unwrap_or((part, ""));
        if !["x", "y", "z", "size", "turn"].contains(&key) {
            bail!("{flag} {text}: no `{key}`; known: x, y, z, size, turn");
        }
        let Ok(number) = value.parse::<f64>() else {
            bail!("{flag} {text}: expected {key}=NUMBER");
        };
        table.insert(key.into(), Value::Float(number));
    }
    Ok(Value::Table(table))
}

/// `kind[=value]` as the table that the configuration wants.
fn speed(text: &str) -> Result<Value> {
    let (kind, value) = text.split_once('=').map_or((text, None), |(k, v)| (k, Some(v)));
    let number = |default: Option<f64>| -> Result<Value> {
        match value.map(str::parse::<f64>) {
            Some(Ok(v)) => Ok(Value::Float(v)),
            None if default.is_some() => Ok(Value::Float(default.unwrap_or_default())),
            _ => bail!("--speed {text}: expected {kind}=NUMBER"),
        }
    };
    let mut table = Table::new();
    table.insert("kind".into(), Value::String(kind.into()));
    match kind {
        "constant" => table.insert("value".into(), number(Some(1.0))?),
        "curvature" => table.insert("coefficient".into(), number(Some(1.0))?),
        "rotation" => table.insert("rate".into(), number(None)?),
        "vortex" => table.insert("period".into(), number(None)?),
        "translation" => {
            let Some(velocity) = value else { bail!("--speed {text}: expected translation=VX,VY") };
            table.insert("velocity".into(), values::list(velocity, "--speed translation")?)
        }
        "image" => {
            let Some(path) = value else { bail!("--speed {text}: expected image=FILE") };
            table.insert("low".into(), Value::Float(0.0));
            table.insert("high".into(), Value::Float(1.0));
            table.insert("path".into(), Value::String(path.into()))
        }
        _ => bail!(
            "--speed {text}: no speed `{kind}`; known speeds: constant, curvature, image, \
             rotation, vortex, translation"
        ),
    };
    Ok(Value::Table(table))
}
