//! Throughput of the engines, beside the machine's own copy bandwidth.

pub mod topopt;

use anyhow::{Context as _, Result};
use patterns::reaction_diffusion::{
    kinetics,
    stepper::{Precision, Setup},
};
use rayon::{ThreadPool, ThreadPoolBuilder};
use solvers::{
    Boundary, Field, Grid,
    diffusion::explicit::{Parameter, Stencil},
    level_set::{Redistance, RedistanceOptions},
};
use std::{hint::black_box, time::Instant};

/// Repetitions of which the fastest counts: other programs only ever make one slower.
const REPETITIONS: usize = 5;

/// Cell updates of one repetition.
const UPDATES: usize = 1 << 26;

/// Explicit steps of one model.
#[derive(Clone, Debug)]
pub struct Row {
    /// Model and precision.
    pub name: String,
    /// Million cell updates per second with 1 and 2 threads.
    pub rate: [f64; 2],
    /// `rate` as a fraction of what the copy bandwidth of one thread would carry.
    pub of_copy: f64,
}

/// Bytes read and written per second by a copy of 256 MB in `threads` threads.
///
/// # Errors
/// If the system has no more threads.
pub fn copy_bandwidth(threads: usize) -> Result<f64> {
    let count = 32 << 20;
    let (source, mut target) = (vec![1.0_f64; count], vec![0.0_f64; count]);
    let pool = pool(threads)?;
    let part = count.div_ceil(threads);
    let seconds = best(|| {
        pool.scope(|scope| {
            for (target, source) in target.chunks_mut(part).zip(source.chunks(part)) {
                scope.spawn(|_| target.copy_from_slice(black_box(source)));
            }
        });
        black_box(&target);
    });
    Ok(16.0 * count as f64 / seconds)
}

/// Explicit steps of Turing's and Gray and Scott's models on `n` x `n` cells, nine-point
/// stencil, in both precisions; `copy` is the bandwidth of one thread (bytes/s).
///
/// # Errors
/// If `n` is 0 or the system has no more threads.
pub fn reaction_diffusion(n: usize, copy: f64) -> Result<Vec<Row>> {
    let grid = Grid::new(&[n, n], 1.0)?;
    let xi = Field::from_fn(grid, |[x, y, _]| 12.0 + 0.4 * (1.3 * x + 2.1 * y).sin());
    let uniform = Parameter::Uniform;
    let models = [
        ("turing", vec![uniform(0.03125), Parameter::Map(xi)], [0.25, 0.0625], [4.0, 4.0]),
        ("gray-scott", vec![uniform(0.058), uniform(0.063)], [0.2097152, 0.1048576], [0.5, 0.25]),
    ];
    let mut rows = Vec::new();
    for (name, parameters, diffusion, start) in models {
        for precision in [Precision::F32, Precision::F64] {
            let setup = Setup {
                grid,
                boundary: Boundary::Periodic,
                stencil: Stencil::NinePoint,
                precision,
                dt: 1.0,
                diffusion: diffusion.to_vec(),
                parameters: parameters.clone(),
                clamp: true,
            };
            let one = rate(name, &setup, start, 1)?;
            let two = rate(name, &setup, start, 2)?;
            // Two species, each read and written once per step.
            let carried = copy / (4 * precision.bytes()) as f64 / 1e6;
            let name =
                format!("{name} {}", if precision == Precision::F32 { "f32" } else { "f64" });
            rows.push(Row { name, rate: [one, two], of_copy: one / carried });
        }
    }
    Ok(rows)
}

fn rate(name: &str, setup: &Setup, start: [f64; 2], threads: usize) -> Result<f64> {
    let kinetics = kinetics::find(name).context("a kinetics of the registry")?;
    let mut stepper = (kinetics.explicit)(setup)?;
    for (species, value) in start.into_iter().enumerate() {
        let wave = |[x, y, _]: [f64; 3]| value * (1.0 + 0.01 * (0.7 * x + 0.9 * y).sin());
        stepper.set(species, &Field::from_fn(setup.grid, wave));
    }
    let steps = (UPDATES / setup.grid.len()).max(8) as u64;
    let pool = pool(threads)?;
    let mut result = Ok(());
    let seconds = best(|| {
        if result.is_ok() {
            result = pool.install(|| stepper.advance(steps));
        }
    });
    result?;
    Ok((steps as usize * setup.grid.len()) as f64 / seconds / 1e6)
}

/// Milliseconds of redistancing a circle on `n` x `n` nodes with `threads` threads.
///
/// # Errors
/// If `n` is 0 or the system has no more threads.
pub fn redistance(n: usize, threads: usize) -> Result<f64> {
    let grid = Grid::new(&[n, n], 1.0)?;
    let [cx, cy, _] = grid.center();
    let circle =
        |[x, y, _]: [f64; 3]| (x - cx).powi(2) + (y - cy).powi(2) - (0.3 * n as f64).powi(2);
    let phi = Field::from_fn(grid, circle);
    let mut work = phi.clone();
    let mut redistance = Redistance::new(grid, RedistanceOptions::default())?;
    let pool = pool(threads)?;
    let mut result = Ok(());
    let seconds = best(|| {
        work.copy_from(&phi);
        if result.is_ok() {
            result = pool.install(|| redistance.apply(&mut work));
        }
    });
    result?;
    Ok(1e3 * seconds)
}

/// Seconds that the process has spent on processors, ended threads included; NaN where the
/// system does not tell.
pub fn processor_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The name of the program, in brackets, may hold spaces.
    let after = text.rsplit(')').next().unwrap_or_default();
    let ticks: Vec<f64> =
        after.split_whitespace().skip(11).take(2).filter_map(|t| t.parse().ok()).collect();
    // Linux counts in hundredths of a second.
    if ticks.len() == 2 { ticks.iter().sum::<f64>() / 100.0 } else { f64::NAN }
}

fn pool(threads: usize) -> Result<ThreadPool> {
    Ok(ThreadPoolBuilder::new().num_threads(threads).build()?)
}

/// Least seconds of several runs.
fn best(mut work: impl FnMut()) -> f64 {
    let run = |_| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    };
    (0..REPETITIONS).map(run).fold(f64::INFINITY, f64::min)
}
