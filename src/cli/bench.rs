//! `patterns bench`: how fast this machine runs the engines.

use crate::bench;
use anyhow::{Result, bail};
use std::{
    io::{self, Write as _},
    process::ExitCode,
};

/// Measure throughput, and the fraction of the machine's copy bandwidth that it is.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  patterns bench --size 1024\n  patterns bench topopt --large")]
pub(super) struct Args {
    /// What: engines (explicit steps, signed distance) or topopt (topology optimization).
    #[arg(value_name = "WHAT", default_value = "engines", value_parser = ["engines", "topopt"])]
    what: String,
    /// topopt: also 1000x1000 and 96x48x48 elements (minutes).
    #[arg(long)]
    large: bool,
    /// Cells along each side of the square, 16 to 8192.
    #[arg(long, value_name = "N", default_value_t = 1024)]
    size: usize,
}

pub(super) fn main(args: &Args) -> Result<ExitCode> {
    if args.what == "topopt" {
        return topopt(args.large);
    }
    let n = args.size;
    if !(16..=8192).contains(&n) {
        bail!("--size {n} is outside its range [16, 8192]");
    }
    let mut out = io::stdout().lock();
    let copy = [bench::copy_bandwidth(1)?, bench::copy_bandwidth(2)?];
    let gb = copy.map(|c| c / 1e9);
    writeln!(
        out,
        "copy of 256 MB, read + written: {:.1} GB/s with 1 thread, {:.1} with 2",
        gb[0], gb[1]
    )?;
    writeln!(out, "\nexplicit steps on {n} x {n} cells, million cell updates per second")?;
    writeln!(
        out,
        "{:16} {:>9} {:>10} {:>7} {:>15}",
        "", "1 thread", "2 threads", "ratio", "of copy (1)"
    )?;
    for row in bench::reaction_diffusion(n, copy[0])? {
        let [one, two] = row.rate;
        let (ratio, of_copy) = (two / one, row.of_copy);
        writeln!(out, "{:16} {one:9.0} {two:10.0} {ratio:7.2} {of_copy:15.2}", row.name)?;
    }
    let [one, two] = [bench::redistance(n, 1)?, bench::redistance(n, 2)?];
    writeln!(
        out,
        "\nsigned distance of a circle on {n} x {n} nodes: {one:.1} ms with 1 thread, {two:.1} with 2"
    )?;
    Ok(ExitCode::SUCCESS)
}

fn topopt(large: bool) -> Result<ExitCode> {
    let mut out = io::stdout().lock();
    writeln!(out, "topology optimization, seconds per iteration")?;
    for case in bench::topopt::cases(large) {
        for threads in [1, 2] {
            let cost = bench::topopt::measure(&case, threads)?;
            let each = 1e6 * cost.cpu / cost.unknowns as f64;
            writeln!(
                out,
                "{:32} {threads} threads: cpu {:.4} wall {:.4}, {each:.3} us per unknown, \
                 memory {:.0} MiB",
                case.name, cost.cpu, cost.wall, cost.memory
            )?;
        }
    }
    Ok(ExitCode::SUCCESS)
}
