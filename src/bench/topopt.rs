//! Seconds per iteration of topology optimization.

use super::{pool, processor_seconds};
use anyhow::{Context as _, Result};
use patterns::{Context, NoInputs, Status, topology};
use std::{fs, time::Instant};
use toml::Table;

/// Iterations before the clock starts, and while it runs.
const WARM: usize = 10;
const TIMED: usize = 20;

/// A problem to time.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name in the table.
    pub name: &'static str,
    config: &'static str,
    warm: usize,
    timed: usize,
}

/// Time and memory of a case.
#[derive(Clone, Copy, Debug)]
pub struct Cost {
    /// Wall seconds per iteration.
    pub wall: f64,
    /// Processor seconds per iteration, over all threads; NaN where the system does not tell.
    pub cpu: f64,
    /// Unknowns of the linear system.
    pub unknowns: usize,
    /// Greatest memory of the process so far (MiB); NaN where the system does not tell.
    pub memory: f64,
}

/// The published benchmark, first; with `large`, millions of unknowns too.
pub fn cases(large: bool) -> Vec<Case> {
    let mut cases = vec![Case {
        name: "MBB 300x100, rmin 4",
        config: include_str!("mbb-300x100.toml"),
        warm: WARM,
        timed: TIMED,
    }];
    if large {
        cases.push(Case {
            name: "MBB 1000x1000, rmin 4",
            config: include_str!("mbb-1000x1000.toml"),
            warm: 4,
            timed: 6,
        });
        cases.push(Case {
            name: "cantilever 96x48x48, rmin 1.5",
            config: include_str!("cantilever-96x48x48.toml"),
            warm: 4,
            timed: 6,
        });
    }
    cases
}

/// Runs a case with `threads` threads.
///
/// # Errors
/// If it does not fit in memory, or a step fails.
pub fn measure(case: &Case, threads: usize) -> Result<Cost> {
    let config: Table = case.config.parse().context("a problem of the benchmark")?;
    let unknowns = unknowns(&config);
    pool(threads)?.install(|| {
        let context = Context { seed: 0, inputs: &NoInputs, memory: crate::memory::available() };
        let mut run = (topology::MODEL.start)(&config, &context)?;
        let mut steps = |count: usize| -> Result<()> {
            for _ in 0..count {
                if run.step()? != Status::Running {
                    anyhow::bail!("{} ended within {count} iterations", case.name);
                }
            }
            Ok(())
        };
        steps(case.warm)?;
        let (start, busy) = (Instant::now(), processor_seconds());
        steps(case.timed)?;
        let each = 1.0 / case.timed as f64;
        let wall = start.elapsed().as_secs_f64() * each;
        let cpu = (processor_seconds() - busy) * each;
        Ok(Cost { wall, cpu, unknowns, memory: peak_memory() })
    })
}

/// Unknowns of a problem's displacements.
fn unknowns(config: &Table) -> usize {
    let elements = config.get("problem").and_then(|p| p.get("elements")?.as_array().cloned());
    let elements = elements.unwrap_or_default();
    let nodes = elements.iter().filter_map(toml::Value::as_integer).map(|n| n as usize + 1);
    nodes.product::<usize>() * elements.len()
}

/// Greatest memory of the process so far (MiB).
fn peak_memory() -> f64 {
    let text = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = line.and_then(|rest| rest.split_whitespace().next()?.parse::<f64>().ok());
    kib.map_or(f64::NAN, |kib| kib / 1024.0)
}
