//! The field's standard tests of front propagation, against exact solutions.

mod level_set_support;
use level_set_support::*;
use solvers::level_set::{
    ConstantSpeed, CurvatureSpeed, FnAdvection, LevelSet, Order, Scheme, reinitialize,
};
use solvers::{Boundary, Field, Grid, order::observed_order};
use std::f64::consts::PI;

const SIZES: [usize; 4] = [32, 64, 128, 256];

#[test]
fn probe() {
    for order in [Order::First, Order::Weno5] {
        for read in [Read::Linear, Read::Cubic] {
            for n in SIZES {
                let c = [0.5, 0.5, 0.0];
                let phi = Field::from_fn(unit(2, n), |p| distance(p, c) - 0.2);
                let phi = run(phi, scheme(order), &mut ConstantSpeed(1.0), 0.15);
                let e = contour_error(&phi, read, |p| distance(p, c) - 0.35);
                let (p1, p2) = ([0.3, 0.5, 0.0], [0.7, 0.5, 0.0]);
                let two = |p, r: f64| f64::min(distance(p, p1), distance(p, p2)) - r;
                let phi = Field::from_fn(unit(2, n), |p| two(p, 0.12));
                let phi = run(phi, scheme(order), &mut ConstantSpeed(1.0), 0.12);
                let m = contour_error(&phi, read, |p| two(p, 0.24));
                let sq = |[x, y, _]: [f64; 3], a: f64| (x - 0.5).abs().max((y - 0.5).abs()) - a;
                let phi = Field::from_fn(unit(2, n), |p| sq(p, 0.2));
                let phi = run(phi, scheme(order), &mut ConstantSpeed(1.0), 0.15);
                let rounded = |[x, y, _]: [f64; 3]| {
                    let (dx, dy) = ((x - 0.5).abs() - 0.2, (y - 0.5).abs() - 0.2);
                    dx.max(0.0).hypot(dy.max(0.0)) + dx.max(dy).min(0.0) - 0.15
                };
                let s = contour_error(&phi, read, rounded);
                let start = |[x, y, _]: [f64; 3]| {
                    let (dx, dy) = ((x - 0.5).abs() - 0.2, (y - 0.5).abs() - 0.2);
                    dx.max(0.0).hypot(dy.max(0.0)) + dx.max(dy).min(0.0)
                };
                let phi = Field::from_fn(unit(2, n), start);
                let phi = run(phi, scheme(order), &mut ConstantSpeed(1.0), 0.15);
                let s2 = contour_error(&phi, read, rounded);
                println!(
                    "{order:?} {read:?} n={n} circle {e:.5} merge {m:.5} square max-norm {s:.4} distance {s2:.4}"
                );
            }
        }
    }
}

#[test]
fn probe2() {
    for n in [32, 64, 128] {
        let c = [0.5, 0.5, 0.0];
        let phi = Field::from_fn(unit(2, n), |p| distance(p, c) - 0.35);
        let a0 = area(&phi);
        for order in [Order::First, Order::Weno5] {
            for cfl in [0.8] {
                let sc = Scheme { cfl, ..scheme(order) };
                let t = 0.02;
                let end = run(phi.clone(), sc, &mut CurvatureSpeed::new(1.0), t);
                let rate = (area(&end) - a0) / t / (-2.0 * PI);
                let (r, s) = radius(&end, c);
                println!(
                    "{order:?} n={n} rate {rate:.6} radius-err/h {:.2e} {s:.2e}",
                    (r - (0.35_f64.powi(2) - 2.0 * t).sqrt()) * n as f64
                );
            }
        }
    }
    for n in [100, 200] {
        let grid = Grid::new(&[n + 1, n + 1], 100.0 / n as f64).unwrap();
        let phi = Field::from_fn(grid, zalesak);
        let a0 = area(&phi);
        for order in [Order::First, Order::Weno5] {
            let mut rot = FnAdvection(|[x, y, _]: [f64; 3], _: f64| {
                [PI / 314.0 * (50.0 - y), PI / 314.0 * (x - 50.0), 0.0]
            });
            let t0 = std::time::Instant::now();
            let end = run(phi.clone(), scheme(order), &mut rot, 628.0);
            println!(
                "zalesak {n} {order:?} a0 {a0:.4} loss % {:.4}  {:?}",
                100.0 * (a0 - area(&end)) / a0,
                t0.elapsed()
            );
        }
    }
}
