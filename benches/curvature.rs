//! Curvature flows at 100^3 in single precision: milliseconds of an energy with its gradient, a
//! blur, a step of the published flow and one of the fast flow, on one and two threads in turns,
//! and how much faster two are: of the median times, and of the least, which others on the machine
//! disturb least. Two loops that need no such flow tell what the machine itself gives: one of
//! arithmetic only, one that streams through memory.
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
use solvers::blur::{Blur, BlurEdges};
use std::hint::black_box;
use std::time::Instant;

/// Numbers of a task of the machine's own loops.
const TASK: usize = 16_384;

/// Numbers of an array that no cache holds: 64 MiB.
const STREAM: usize = 1024 * TASK;

fn main() {
    let mut sizes = vec![100];
    sizes.extend(std::env::args().filter_map(|text| text.parse::<usize>().ok()));
    println!(
        "part\tsize\twall_ms_1\tcpu_ms_1\twall_ms_2\tcpu_ms_2\tfaster\tleast_ms_1\tleast_ms_2\tleast_faster"
    );
    let pools =
        [1, 2].map(|n| ThreadPoolBuilder::new().num_threads(n).build().expect("some threads"));
    for n in sizes {
        flows(n, &pools);
    }
    machine(&pools);
}

fn flows(n: usize, pools: &[ThreadPool; 2]) {
    let shape = [n; 3];
    let tubes = Coefficients::from([1.0, 2.0, 6.0, -40.0, -40.0, 400.0]);
    let config = EnergyConfig::new(shape, 0.01, 0.02, tubes);
    let energy = Energy::<f32>::new(config).expect("a valid energy");
    let map = Potential::new(shape, 0.01, 2.0, &Spatial::Uniform(-0.6)).expect("a valid mass");
    let paper =
        || Paper::new(energy.clone(), map.clone(), PaperConfig::default(), 1).expect("a start");
    let start = paper().phase().to_vec();
    let calls = [paper(), paper()].map(|mut paper| {
        move || {
            paper.step().expect("finite energies");
        }
    });
    report("paper step", n, pools, calls);
    let fast = || Fast::new(energy.clone(), FastConfig::default(), start.clone()).expect("a start");
    let calls = [fast(), fast()].map(|mut fast| {
        move || {
            fast.step().expect("finite energies");
        }
    });
    report("fast step", n, pools, calls);
    let calls = [energy.clone(), energy.clone()].map(|mut energy| {
        let (u, mut out) = (start.clone(), start.clone());
        move || {
            energy.value_and_gradient(&u, &mut out);
        }
    });
    report("energy and gradient", n, pools, calls);
    let calls = [(); 2].map(|()| {
        let mut blur = Blur::<f32>::new(shape, 2.0, BlurEdges::Periodic).expect("a valid sigma");
        let (u, mut between, mut out) = (start.clone(), start.clone(), start.clone());
        move || blur.apply(&u, &mut between, &mut out)
    });
    report("blur", n, pools, calls);
}

/// What two threads gain where nothing but the machine is in the way.
fn machine(pools: &[ThreadPool; 2]) {
    let calls = [(); 2].map(|()| {
        let mut a = vec![0.0_f32; 64 * TASK];
        move || {
            black_box(&mut a).par_chunks_mut(TASK).for_each(|task| {
                for lanes in task.as_chunks_mut::<64>().0 {
                    let mut x = *lanes;
                    for _ in 0..200 {
                        x.iter_mut().for_each(|x| *x = *x * 0.999 + 0.001);
                    }
                    *lanes = x;
                }
            });
        }
    });
    report("arithmetic", 100, pools, calls);
    let calls = [(); 2].map(|()| {
        let [mut a, b, c] = [0.0_f32, 1.0, 2.0].map(|value| vec![value; STREAM]);
        move || {
            let inputs = b.par_chunks(TASK).zip(c.par_chunks(TASK));
            black_box(&mut a).par_chunks_mut(TASK).zip(inputs).for_each(|(a, (b, c))| {
                a.iter_mut().zip(b.iter().zip(c)).for_each(|(a, (b, c))| *a = 0.5 * (b + c));
            });
        }
    });
    report("streams", 256, pools, calls);
}

/// Calls of a turn: the first finds the caches full of the other's state.
const TURN: usize = 10;

/// Median and least wall times of several calls in each pool, in turns of [`TURN`], each with a
/// state of its own, mean processor times, and the ratios of the walls.
fn report<F: FnMut() + Send>(part: &str, n: usize, pools: &[ThreadPool; 2], mut calls: [F; 2]) {
    let turns = (10_000_000 / (n * n * n)).max(3);
    let count = turns * TURN;
    let (mut walls, mut busy) = ([Vec::new(), Vec::new()], [0.0; 2]);
    for (pool, call) in pools.iter().zip(&mut calls) {
        pool.install(call);
    }
    for m in (0..2 * turns).map(|turn| turn % 2) {
        let before = lab::bench::processor_seconds();
        for _ in 0..TURN {
            let start = Instant::now();
            pools[m].install(&mut calls[m]);
            walls[m].push(start.elapsed().as_secs_f64() * 1e3);
        }
        busy[m] += (lab::bench::processor_seconds() - before) * 1e3 / count as f64;
    }
    let [[least_one, one], [least_two, two]] = walls.map(|mut walls| {
        walls.sort_by(f64::total_cmp);
        [walls[0], walls[count / 2]]
    });
    let ([cpu_one, cpu_two], [faster, least]) = (busy, [one / two, least_one / least_two]);
    println!(
        "{part}\t{n}\t{one:.2}\t{cpu_one:.2}\t{two:.2}\t{cpu_two:.2}\t{faster:.2}\t\
         {least_one:.2}\t{least_two:.2}\t{least:.2}"
    );
}
