//! `patterns curvature atlas`: many textures of random parameters on one map.

use super::{run_args::RunArgs, values};
use crate::request::Request;
use anyhow::Result;
use std::process::ExitCode;

/// Grow textures of random parameters, and lay them out by how alike their curvatures are.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  \
    patterns curvature atlas --count 1000\n  \
    patterns curvature atlas --count 60 --size 32 --evaluations 150 --cluster 5\n  \
    patterns curvature atlas --set ranges.mass=[-0.5,-0.3]\n\
    Ranges of parameters (a20 = 1): a11 -4 to 4, a02 1/15 to 15, b10 and b01 -200 to 200,\n\
    c -3000 to 3000, mass -0.75 to -0.15; --set ranges.NAME=[LOW,HIGH] changes one.")]
pub(super) struct Args {
    /// Shapes of the atlas, 3 to 20000 [default: 1000].
    #[arg(long, value_name = "N")]
    count: Option<u64>,
    /// Most draws of parameters; those that make no clean shape are refused [default: 20 for each shape].
    #[arg(long, value_name = "N")]
    draws: Option<u64>,
    /// Voxels of each shape: N or NZxNYxNX [default: 64].
    #[arg(long, value_name = "N")]
    size: Option<String>,
    /// Evaluations of the energy for each shape [default: 300].
    #[arg(long, value_name = "N")]
    evaluations: Option<u64>,
    /// Shapes of a greater normalized discrepancy are refused, in (0, 1] [default: 0.75].
    #[arg(long, value_name = "ND")]
    max_discrepancy: Option<f64>,
    /// Side of the bins of curvature diagrams, 1/length: 1 is within 1 % of the exact distance,
    /// 2 within 2 % and four times faster [default: 2].
    #[arg(long, value_name = "SIDE")]
    cell: Option<f64>,
    /// Neighbours that make up the surroundings of a shape on the map [default: 25].
    #[arg(long, value_name = "N")]
    neighbors: Option<u64>,
    /// Fewest shapes of a cluster [default: 10].
    #[arg(long, value_name = "N")]
    cluster: Option<u64>,
    /// Shapes that are shown, 0 to 30 [default: 20].
    #[arg(long, value_name = "N")]
    pictures: Option<u64>,
    #[command(flatten)]
    run: RunArgs,
}

pub(super) fn main(args: &Args) -> Result<ExitCode> {
    let mut request = Request::new("curvature-atlas", 0);
    if let Some(size) = &args.size {
        request.set("growth.size", values::size(size, 3)?, "--size")?;
    }
    request.set_at("count", values::integer(args.count), "--count")?;
    request.set_at("draws", values::integer(args.draws), "--draws")?;
    let evaluations = values::integer(args.evaluations);
    request.set_at("growth.evaluations", evaluations, "--evaluations")?;
    request.set_at("growth.max_discrepancy", args.max_discrepancy, "--max-discrepancy")?;
    request.set_at("distance.cell", args.cell, "--cell")?;
    request.set_at("map.neighbors", values::integer(args.neighbors), "--neighbors")?;
    request.set_at("map.cluster", values::integer(args.cluster), "--cluster")?;
    request.set_at("map.samples", values::integer(args.cluster), "--cluster")?;
    request.set_at("map.pictures", values::integer(args.pictures), "--pictures")?;
    args.run.execute(request)
}
