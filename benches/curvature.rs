//! Curvature flows at 100^3 in single precision: milliseconds of an energy with its gradient, a
//! blur, a step of the published flow and one of the fast flow, on one and two threads.
//!
//! `cargo bench --bench curvature -- 256` adds a size.
#![allow(
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a benchmark reads the clock and prints"
)]

use patterns::curvature::energy::{Energy, EnergyConfig, Spatial};
use patterns::curvature::flow::{Fast, FastConfig, Paper, PaperConfig};
use patterns::curvature::{Coefficients, Potential};
use solvers::blur::{Blur, BlurEdges, Stored};
use std::time::Instant;

fn main() {
    let mut sizes = vec![100];
    sizes.extend(std::env::args().filter_map(|text| text.parse::<usize>().ok()));
    println!("part\tsize\tthreads\twall_ms\tcpu_ms");
    for n in sizes {
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.expect("threads").install(|| parts(n, threads));
        }
    }
}

fn parts(n: usize, threads: usize) {
    let shape = [n; 3];
    let tubes = Coefficients::from([1.0, 2.0, 6.0, -40.0, -40.0, 400.0]);
    let config = EnergyConfig::new(shape, 0.01, 0.02, tubes);
    let mut energy = Energy::<f32>::new(config).expect("a valid energy");
    let map = Potential::new(shape, 0.01, 2.0, &Spatial::Uniform(-0.6)).expect("a valid mass");
    let mut paper = Paper::new(energy.clone(), map, PaperConfig::default(), 1).expect("a start");
    let start = paper.phase().to_vec();
    report("paper step", n, threads, || {
        paper.step().expect("finite energies");
    });
    drop(paper);
    let mut fast =
        Fast::new(energy.clone(), FastConfig::default(), start.clone()).expect("a start");
    report("fast step", n, threads, || {
        fast.step().expect("finite energies");
    });
    drop(fast);
    let mut out = start.clone();
    report("energy and gradient", n, threads, || {
        energy.value_and_gradient(&start, &mut out);
    });
    let mut blur = Blur::<f32>::new(shape, 2.0, BlurEdges::Periodic).expect("a valid sigma");
    let mut between = start.clone();
    report("blur", n, threads, || blur.apply(&Stored(&start), &mut between, &mut out));
}

/// Wall time of the best of several calls, and mean processor time.
fn report(part: &str, n: usize, threads: usize, mut call: impl FnMut()) {
    let calls = (60_000_000 / (n * n * n)).max(3);
    call();
    let (mut wall, busy) = (f64::INFINITY, lab::bench::processor_seconds());
    for _ in 0..calls {
        let start = Instant::now();
        call();
        wall = wall.min(start.elapsed().as_secs_f64() * 1e3);
    }
    let cpu = (lab::bench::processor_seconds() - busy) * 1e3 / calls as f64;
    println!("{part}\t{n}\t{threads}\t{wall:.2}\t{cpu:.2}");
}
