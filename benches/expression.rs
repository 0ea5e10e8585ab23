//! Nodes per second of reactions given by formulas, beside the same rates written in Rust.
//!
//! `cargo bench --bench expression`; one thread, best of several repetitions.
#![allow(clippy::print_stdout, reason = "a benchmark prints")]

use solvers::diffusion::{Reaction, explicit::Parameter};
use solvers::expression::FormulaReaction;
use std::hint::black_box;
use std::time::Instant;

/// Many short runs: some of them are not disturbed by other work of the machine.
const REPETITIONS: usize = 300;

/// Nodes per call, as the time steppers ask for them.
const CALL: usize = 4096;

/// A rate of `[u, v]` at parameters `[feed, kill]`.
struct Handwritten;

const PARAMETERS: [f64; 2] = [0.04, 0.06];

impl Reaction for Handwritten {
    fn species(&self) -> usize {
        2
    }

    fn rates(&self, _: usize, u: &[&[f64]], rates: &mut [&mut [f64]]) {
        let [feed, kill] = black_box(PARAMETERS);
        let [du, dv] = rates else { return };
        pulp::Arch::new().dispatch(
            #[inline(always)]
            || {
                for (((du, dv), &u), &v) in du.iter_mut().zip(dv.iter_mut()).zip(u[0]).zip(u[1]) {
                    let reaction = u * v * v;
                    *du = feed * (1.0 - u) - reaction;
                    *dv = reaction - (feed + kill) * v;
                }
            },
        );
    }
}

/// Million nodes per second on `n` nodes; `passes` over them per repetition.
fn rate(reaction: &dyn Reaction, n: usize) -> f64 {
    let u: Vec<f64> = (0..n).map(|i| 0.5 + 0.4 * (0.01 * i as f64).sin()).collect();
    let v: Vec<f64> = u.iter().map(|u| 0.6 * (1.0 - u)).collect();
    let (mut du, mut dv) = (vec![0.0; n], vec![0.0; n]);
    let passes = (1_usize << 15).div_ceil(n);
    let run = |_| {
        let start = Instant::now();
        for _ in 0..passes {
            for first in (0..n).step_by(CALL) {
                let nodes = first..(first + CALL).min(n);
                let inputs = [&u[nodes.clone()], &v[nodes.clone()]];
                reaction.rates(first, &inputs, &mut [&mut du[nodes.clone()], &mut dv[nodes]]);
            }
            black_box((&mut du, &mut dv));
        }
        start.elapsed().as_secs_f64()
    };
    let seconds = (0..REPETITIONS).map(run).fold(f64::INFINITY, f64::min);
    (n * passes) as f64 / seconds / 1e6
}

fn formulas(species: &[(&str, &str)], names: [&str; 2]) -> FormulaReaction {
    let parameters = [0, 1].map(|k| (names[k], Parameter::Uniform(PARAMETERS[k])));
    FormulaReaction::new(species, &parameters).expect("formulas")
}

fn main() {
    let gray_scott = [("u", "feed*(1 - u) - u*v^2"), ("v", "u*v^2 - (feed + kill)*v")];
    let compiled = formulas(&gray_scott, ["feed", "kill"]);
    println!("Gray-Scott's two rates, million nodes per second on one thread");
    println!("{:>9} {:>9} {:>9} {:>6}", "nodes", "Rust", "formula", "ratio");
    for n in [CALL, 1 << 16, 1 << 20] {
        let (by_hand, by_formula) = (rate(&Handwritten, n), rate(&compiled, n));
        println!("{n:9} {by_hand:9.0} {by_formula:9.0} {:6.2}", by_hand / by_formula);
    }
    let cases = [
        ("hill, exponent 2 as a parameter", "a*hill(v, 0.3, n*50) - u", "a*u - v"),
        ("hill, exponent 2.5", "a*hill(v, 0.3, 2.5) - u", "a*u - v"),
        ("exp, tanh", "a*exp(-u) - n*u", "tanh(u - v) - a*v"),
        ("where, min, max", "where(u > v, a, n)*u", "clamp(u, 0.2, 0.8) - max(v, n)"),
    ];
    for (name, u, v) in cases {
        let reaction = formulas(&[("u", u), ("v", v)], ["n", "a"]);
        println!("{name}: {:.0}", rate(&reaction, CALL));
    }
}
