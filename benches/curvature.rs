//! Curvature flows at 100^3 in single precision: milliseconds of an energy with its gradient, a
//! blur, a step of the published flow and one of the fast flow, on one and two threads by turns,
//! and how much faster two are. Two loops that need no such flow tell what the machine itself
//! gives: one of arithmetic only, one that streams through memory.
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
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use solvers::blur::{Blur, BlurEdges, Stored};
use std::hint::black_box;
use std::time::Instant;

/// Numbers of a task of the machine's own loops.
const TASK: usize = 16_384;

fn main() {
    let mut sizes = vec![100];
    sizes.extend(std::env::args().filter_map(|text| text.parse::<usize>().ok()));
    println!("part\tsize\twall_ms_1\tcpu_ms_1\twall_ms_2\tcpu_ms_2\tfaster");
    let pools =
        [1, 2].map(|n| ThreadPoolBuilder::new().num_threads(n).build().expect("some threads"));
    for n in sizes {
        flows(n, &pools);
        machine(n, &pools);
    }
}

fn flows(n: usize, pools: &[ThreadPool; 2]) {
    let shape = [n; 3];
    let tubes = Coefficients::from([1.0, 2.0, 6.0, -40.0, -40.0, 400.0]);
    let config = EnergyConfig::new(shape, 0.01, 0.02, tubes);
    let mut energy = Energy::<f32>::new(config).expect("a valid energy");
    let map = Potential::new(shape, 0.01, 2.0, &Spatial::Uniform(-0.6)).expect("a valid mass");
    let mut paper = Paper::new(energy.clone(), map, PaperConfig::default(), 1).expect("a start");
    let start = paper.phase().to_vec();
    report("paper step", n, pools, || {
        paper.step().expect("finite energies");
    });
    drop(paper);
    let mut fast =
        Fast::new(energy.clone(), FastConfig::default(), start.clone()).expect("a start");
    report("fast step", n, pools, || {
        fast.step().expect("finite energies");
    });
    drop(fast);
    let mut out = start.clone();
    report("energy and gradient", n, pools, || {
        energy.value_and_gradient(&start, &mut out);
    });
    let mut blur = Blur::<f32>::new(shape, 2.0, BlurEdges::Periodic).expect("a valid sigma");
    let mut between = start.clone();
    report("blur", n, pools, || blur.apply(&Stored(&start), &mut between, &mut out));
}

/// What two threads gain where nothing but the machine is in the way.
fn machine(n: usize, pools: &[ThreadPool; 2]) {
    let [mut a, b, c] = [0.0, 1.0, 2.0].map(|value: f32| vec![value; n * n * n]);
    report("arithmetic", n, pools, || {
        a.par_chunks_mut(TASK).for_each(|task| {
            for lanes in task.as_chunks_mut::<64>().0 {
                let mut x = *lanes;
                for _ in 0..200 {
                    x.iter_mut().for_each(|x| *x = *x * 0.999 + 0.001);
                }
                *lanes = x;
            }
        });
    });
    report("streams", n, pools, || {
        let inputs = b.par_chunks(TASK).zip(c.par_chunks(TASK));
        a.par_chunks_mut(TASK).zip(inputs).for_each(|(a, (b, c))| {
            a.iter_mut().zip(b.iter().zip(c)).for_each(|(a, (b, c))| *a = 0.5 * (b + c));
        });
    });
    black_box(a);
}

/// Median wall times of several calls in each pool by turns, mean processor times, and the
/// ratio of the walls.
fn report(part: &str, n: usize, pools: &[ThreadPool; 2], mut call: impl FnMut() + Send) {
    let calls = (100_000_000 / (n * n * n)).max(3);
    let (mut walls, mut busy) = ([Vec::new(), Vec::new()], [0.0; 2]);
    call();
    for _ in 0..calls {
        for (pool, (walls, busy)) in pools.iter().zip(walls.iter_mut().zip(&mut busy)) {
            let (before, start) = (lab::bench::processor_seconds(), Instant::now());
            pool.install(&mut call);
            walls.push(start.elapsed().as_secs_f64() * 1e3);
            *busy += (lab::bench::processor_seconds() - before) * 1e3 / calls as f64;
        }
    }
    let [one, two] = walls.map(|mut walls| {
        walls.sort_by(f64::total_cmp);
        walls[calls / 2]
    });
    let [cpu_one, cpu_two] = busy;
    println!("{part}\t{n}\t{one:.2}\t{cpu_one:.2}\t{two:.2}\t{cpu_two:.2}\t{:.2}", one / two);
}
