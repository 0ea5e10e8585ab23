//! Signed distance of a 1024 x 1024 circle: milliseconds on one and two threads, errors in cells.
//!
//! `cargo bench --bench redistance`; `benches/peers/level_set` runs it beside scikit-fmm.
#![allow(
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a benchmark reads the clock and prints"
)]

use solvers::level_set::{Redistance, RedistanceOptions};
use solvers::{Field, Grid};
use std::time::Instant;

fn main() {
    let n = 1024;
    let grid = Grid::new(&[n, n], 1.0).expect("a valid grid");
    let radius = 0.3 * n as f64;
    let center = 0.5 * n as f64 - 0.3;
    let exact = |[x, y, _]: [f64; 3]| (x - center).hypot(y - 0.9 - center) - radius;
    let square = |p: [f64; 3]| (exact(p) + radius).powi(2) - radius * radius;
    let uneven = |p: [f64; 3]| exact(p) * (1.1 + (p[0] / 9.0).sin()) * (1.0 + 0.01 * p[1]);
    let inputs: [(&str, Field); 3] = [
        ("distance", Field::from_fn(grid, exact)),
        ("x^2+y^2-r^2", Field::from_fn(grid, square)),
        ("uneven", Field::from_fn(grid, uneven)),
    ];
    println!("engine\tinput\tthreads\twall_ms\tcpu_ms\tnear_max\tnear_mean\tfar_max");
    for (name, phi) in &inputs {
        for (band, label) in [(None, "full"), (Some(6.0), "band")] {
            for threads in [1, 2] {
                let [wall, cpu] = best(phi, band, threads);
                let mut out = phi.clone();
                let options = RedistanceOptions { band, ..Default::default() };
                Redistance::new(grid, options)
                    .and_then(|mut r| r.apply(&mut out))
                    .expect("finite input");
                let [near, mean, far] = errors(&out, &exact, band);
                println!(
                    "patterns-{label}\t{name}\t{threads}\t{wall:.2}\t{cpu:.2}\t{near:.5}\t{mean:.6}\t{far:.4}"
                );
            }
        }
    }
    small();
}

/// Milliseconds that this process has spent on processors, where the system tells.
fn cpu() -> f64 {
    1e3 * lab::bench::processor_seconds()
}

/// Milliseconds a call: wall time of the best one, and mean processor time of enough calls
/// that hundredths of a second do not show.
fn best(phi: &Field, band: Option<f64>, threads: usize) -> [f64; 2] {
    const ENOUGH: f64 = 1000.0;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    pool.install(|| {
        let options = RedistanceOptions { band, ..Default::default() };
        let mut work = Redistance::new(phi.grid(), options).expect("valid options");
        let mut out = phi.clone();
        let (mut wall, mut total, mut calls) = (f64::INFINITY, 0.0, 0.0);
        let (start, busy) = (Instant::now(), cpu());
        while start.elapsed().as_secs_f64() * 1e3 < ENOUGH {
            out.copy_from(phi);
            let start = Instant::now();
            work.apply(&mut out).expect("finite input");
            let time = start.elapsed().as_secs_f64() * 1e3;
            wall = wall.min(time);
            total += time;
            calls += 1.0;
        }
        // The share of the processor time that is not the copies'.
        let share = total / (start.elapsed().as_secs_f64() * 1e3);
        [wall, (cpu() - busy) / calls * share]
    })
}

/// Largest and mean error where `|d| < 1.5`, largest error anywhere (within the band).
fn errors(phi: &Field, exact: &impl Fn([f64; 3]) -> f64, band: Option<f64>) -> [f64; 3] {
    let band = band.unwrap_or(f64::INFINITY);
    let (mut near, mut sum, mut count, mut far) = (0.0_f64, 0.0, 0.0, 0.0_f64);
    for (n, &value) in phi.as_slice().iter().enumerate() {
        let d = exact(phi.grid().position(n));
        let error = (value - d.clamp(-band, band)).abs();
        far = far.max(error);
        if d.abs() < 1.5 {
            near = near.max(error);
            sum += error;
            count += 1.0;
        }
    }
    [near, sum / count, far]
}

/// 80 x 80, one circle and a field of spots as a reaction-diffusion run makes them.
fn small() {
    let grid = Grid::new(&[80, 80], 1.0).expect("a valid grid");
    let circle = Field::from_fn(grid, |[x, y, _]| (x - 40.0).hypot(y - 39.0) - 25.0);
    let spots = Field::from_fn(grid, |[x, y, _]| {
        0.45 - (std::f64::consts::TAU * x / 8.9).cos() * (std::f64::consts::TAU * y / 8.9).cos()
    });
    for (name, phi) in [("80x80 circle", circle), ("80x80 spots", spots)] {
        for band in [None, Some(3.0)] {
            let [wall, cpu] = best(&phi, band, 1);
            println!(
                "patterns-{}\t{name}\t1\t{wall:.3}\t{cpu:.3}",
                if band.is_some() { "band" } else { "full" }
            );
        }
    }
}
