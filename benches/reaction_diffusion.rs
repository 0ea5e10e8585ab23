//! Cell updates per second of the explicit step, beside the machine's copy bandwidth.
//!
//! `cargo bench --bench reaction_diffusion [-- SIZE]`; best of several repetitions.
#![allow(clippy::print_stdout, reason = "a benchmark prints")]

use patterns::reaction_diffusion::kinetics::{gray_scott::GrayScott, turing::Turing};
use rayon::ThreadPoolBuilder;
use solvers::diffusion::explicit::{Cell, CellKernel, Explicit, Parameter, Real, Stencil};
use solvers::{Boundary, Field, Grid};
use std::hint::black_box;
use std::time::Instant;

const REPETITIONS: usize = 7;

/// Least seconds of several runs of `work`.
fn best(mut work: impl FnMut()) -> f64 {
    let run = |_| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    };
    (0..REPETITIONS).map(run).fold(f64::INFINITY, f64::min)
}

/// Bytes read and written per second by a copy of 256 MB.
fn copy_bandwidth(threads: usize) -> f64 {
    let count = 32 << 20;
    let source = vec![1.0_f64; count];
    let mut target = vec![0.0_f64; count];
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let part = count.div_ceil(threads);
    let seconds = best(|| {
        pool.scope(|scope| {
            for (target, source) in target.chunks_mut(part).zip(source.chunks(part)) {
                scope.spawn(|_| target.copy_from_slice(black_box(source)));
            }
        });
        black_box(&target);
    });
    16.0 * count as f64 / seconds
}

/// Million cell updates per second of one model.
fn rate<T: Real, C: Cell<2, 2>>(
    n: usize,
    threads: usize,
    depth: usize,
    parameters: &[Parameter; 2],
    diffusion: [f64; 2],
    start: [f64; 2],
) -> f64 {
    let grid = Grid::new(&[n, n], 1.0).expect("grid");
    let kernel =
        CellKernel::<T, C, 2, 2>::new(grid, Stencil::NinePoint, 1.0, diffusion, parameters, true);
    let kernel = kernel.expect("kernel");
    let mut state = Explicit::new(grid, Boundary::Periodic, kernel).expect("state");
    if depth > 0 {
        state = state.with_depth(depth);
    }
    for (s, value) in start.into_iter().enumerate() {
        let wave = |i: usize| T::from_f64(value * (1.0 + 0.01 * (i as f64 * 0.7).sin()));
        state.set(s, &(0..grid.len()).map(wave).collect::<Vec<_>>());
    }
    let steps = (1 << 25_u64) / grid.len() as u64 + 8;
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let seconds = best(|| pool.install(|| state.advance(steps)));
    (steps as usize * grid.len()) as f64 / seconds / 1e6
}

fn row<T: Real, C: Cell<2, 2>>(
    name: &str,
    n: usize,
    parameters: &[Parameter; 2],
    diffusion: [f64; 2],
    start: [f64; 2],
) {
    let run = |threads, depth| rate::<T, C>(n, threads, depth, parameters, diffusion, start);
    let [plain, one, two] = [run(1, 1), run(1, 0), run(2, 0)];
    let precision = if size_of::<T>() == 4 { "f32" } else { "f64" };
    println!("{name:<22} {precision:>4} {plain:>10.0} {one:>10.0} {two:>10.0} {:>8.2}", two / one);
}

fn main() {
    // Cargo passes `--bench`.
    let n = std::env::args().skip(1).find_map(|a| a.parse().ok()).unwrap_or(1024);
    println!("{n} x {n}, nine-point stencil, million cell updates per second");
    println!(
        "{:<22} {:>4} {:>10} {:>10} {:>10} {:>8}",
        "", "", "plain", "1 thread", "2 threads", "ratio"
    );
    let uniform = |a: f64, b: f64| [a, b].map(Parameter::Uniform);
    let grid = Grid::new(&[n, n], 1.0).expect("grid");
    let xi = Field::from_fn(grid, |[x, y, _]| 12.0 + 0.4 * (1.3 * x + 2.1 * y).sin());
    let turing = [Parameter::Uniform(0.03125), Parameter::Map(xi)];
    row::<f32, Turing>("turing, xi per cell", n, &turing, [0.25, 0.0625], [4.0, 4.0]);
    row::<f64, Turing>("turing, xi per cell", n, &turing, [0.25, 0.0625], [4.0, 4.0]);
    let kappa = uniform(0.058, 0.063);
    row::<f32, GrayScott>("gray-scott", n, &kappa, [0.2097152, 0.1048576], [0.5, 0.25]);
    row::<f64, GrayScott>("gray-scott", n, &kappa, [0.2097152, 0.1048576], [0.5, 0.25]);
    println!("copy of 256 MB, read + written, and the cell updates that it would carry:");
    for threads in [1, 2] {
        let bandwidth = copy_bandwidth(threads);
        // Two species, each read and written once per step.
        let [f32_cells, f64_cells] = [4.0, 8.0].map(|bytes| bandwidth / (4.0 * bytes) / 1e6);
        println!(
            "{threads} thread(s): {:.1} GB/s = {f32_cells:.0} (f32), {f64_cells:.0} (f64) Mcell/s",
            bandwidth / 1e9
        );
    }
}
