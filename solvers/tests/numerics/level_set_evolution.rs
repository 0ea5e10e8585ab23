//! The time stepper itself: symmetry, borders, narrow band, options, errors.

use super::level_set_support::{Read, contour, contour_error, distance, radius, scheme, unit};
use proptest::prelude::*;
use solvers::level_set::{
    ConstantSpeed, CurvatureSpeed, FieldAdvection, FieldSpeed, FnAdvection, FnSpeed, LevelSet,
    Order, Scheme, Speed, reinitialize,
};
use solvers::{Boundary, Field, Grid, random};

fn noise(grid: Grid, name: &str) -> Field {
    let mut stream = random::stream(3, name, 0);
    let values = (0..grid.len()).map(|_| 2.0 * random::uniform(&mut stream) - 1.0).collect();
    Field::from_vec(grid, values).unwrap()
}

/// `field` with node (k, j, i) taken from `source(k, j, i)`.
fn permuted(field: &Field, source: impl Fn([usize; 3]) -> [usize; 3]) -> Field {
    let grid = field.grid();
    let values = (0..grid.len()).map(|n| {
        let [k, j, i] = source(grid.node(n));
        field.at(k, j, i)
    });
    Field::from_vec(grid, values.collect()).unwrap()
}

fn after(phi: &Field, scheme: &Scheme, mut speed: impl Speed, steps: usize) -> Field {
    let mut front = LevelSet::new(phi.clone(), scheme.clone()).unwrap();
    for _ in 0..steps {
        front.advance(&mut speed, 0.5).unwrap();
    }
    front.phi().clone()
}

#[test]
fn mirrored_and_turned_fronts_move_by_the_same_bytes() {
    let grid = Grid::new(&[24, 24], 1.0).unwrap();
    let (phi, beta) = (noise(grid, "phi"), noise(grid, "beta"));
    let mirror = |[k, j, i]: [usize; 3]| [k, j, 23 - i];
    let turn = |[k, j, i]: [usize; 3]| [k, i, 23 - j];
    let negative = |field: Field| {
        Field::from_vec(grid, field.as_slice().iter().map(|v| -v).collect()).unwrap()
    };
    for order in [Order::First, Order::Weno5] {
        for boundary in [Boundary::Neumann, Boundary::Periodic, Boundary::Extrapolate] {
            let scheme = Scheme { order, boundary, ..Scheme::default() };
            for source in [mirror as fn([usize; 3]) -> [usize; 3], turn] {
                let image = permuted(&phi, source);
                let normal = after(&phi, &scheme, FieldSpeed(beta.clone()), 5);
                let of_image = after(&image, &scheme, FieldSpeed(permuted(&beta, source)), 5);
                assert_eq!(permuted(&normal, source), of_image, "{order:?} {boundary:?} normal");
                if boundary == Boundary::Extrapolate {
                    // Its corner ghosts continue along x first, which rounds otherwise than y first.
                    continue;
                }
                let bent = after(&phi, &scheme, CurvatureSpeed::new(0.3), 5);
                let of_image = after(&image, &scheme, CurvatureSpeed::new(0.3), 5);
                assert_eq!(permuted(&bent, source), of_image, "{order:?} {boundary:?} curvature");
            }
            let v = [noise(grid, "vx"), noise(grid, "vy")];
            let carried = after(&phi, &scheme, FieldAdvection(v.to_vec()), 5);
            let [vx, vy] = v.map(|v| permuted(&v, mirror));
            let flow = FieldAdvection(vec![negative(vx), vy]);
            let of_image = after(&permuted(&phi, mirror), &scheme, flow, 5);
            assert_eq!(permuted(&carried, mirror), of_image, "{order:?} {boundary:?} flow");
        }
    }
}

#[test]
fn one_source_serves_all_dimensions() {
    // A front that does not depend on y and z moves the same in 1D, 2D and 3D.
    let wave = |[x, _, _]: [f64; 3]| (0.7 * x).sin() + 0.1 * x;
    let speed = || FnSpeed(|[x, _, _]: [f64; 3], t: f64| (0.3 * x).cos() + t);
    for order in [Order::First, Order::Weno5] {
        let run = |shape: &[usize]| {
            let phi = Field::from_fn(Grid::new(shape, 1.0).unwrap(), wave);
            let scheme = Scheme { order, ..Scheme::default() };
            let mut front = LevelSet::new(phi, scheme).unwrap();
            for _ in 0..10 {
                front.step(&mut speed(), 0.2).unwrap();
            }
            front.phi().as_slice()[..40].to_vec()
        };
        let line = run(&[40]);
        assert_eq!(line, run(&[3, 40]));
        assert_eq!(line, run(&[2, 3, 40]));
    }
}

#[test]
fn a_wave_returns_through_a_periodic_border() {
    let error = |n: usize| {
        let grid = Grid::new(&[n], 1.0 / n as f64).unwrap();
        let wave = |x: f64| (std::f64::consts::TAU * x).sin();
        let phi = Field::from_fn(grid, |[x, _, _]| wave(x));
        let scheme = Scheme { boundary: Boundary::Periodic, cfl: 0.3, ..Scheme::default() };
        let mut front = LevelSet::new(phi.clone(), scheme).unwrap();
        while 1.0 - front.time() > 1e-12 {
            front
                .advance(
                    &mut FnAdvection(|_: [f64; 3], _: f64| [1.0, 0.0, 0.0]),
                    1.0 - front.time(),
                )
                .unwrap();
        }
        let pairs = front.phi().as_slice().iter().zip(phi.as_slice());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let order = solvers::order::observed_order(&[20, 40, 80], error);
    println!("advected sine: order {order:.2}, error {:.1e} at n = 80", error(80));
    // Fifth order in space and third in time: between them while space dominates.
    assert!(order > 3.5);
}

#[test]
fn shrinking_disk_vanishes() {
    // R^2 = R0^2 - 2 b t reaches zero at t = 12.5; at the centre the gradient is zero.
    let grid = Grid::new(&[17, 17], 1.0).unwrap();
    let phi = Field::from_fn(grid, |[x, y, _]| (x - 8.0).hypot(y - 8.0) - 5.0);
    let mut front = LevelSet::new(phi, Scheme { cfl: 0.9, ..scheme(Order::First) }).unwrap();
    while front.phi().range().0 < 0.0 {
        front.advance(&mut CurvatureSpeed::new(1.0), 1.0).unwrap();
        assert!(front.time() < 14.0, "{:?}", front.phi().range());
    }
    println!("disk of radius 5 vanished at t = {:.2}, exact 12.5", front.time());
    // The last cell is not resolved: a radius of h less, in time h^2/2, or h more.
    assert!((front.time() - 12.5).abs() < 1.0);
}

/// A circle that grows from 0.25 to 0.4, reinitialized every ten steps.
fn grown(n: usize, band: Option<f64>) -> Field {
    let phi = Field::from_fn(unit(2, n), |p| distance(p, [0.5, 0.5, 0.0]) - 0.25);
    let mut front = LevelSet::new(phi, Scheme { band, ..scheme(Order::Weno5) }).unwrap();
    let mut steps = 0;
    while 0.15 - front.time() > 1e-12 {
        front.advance(&mut ConstantSpeed(1.0), 0.15 - front.time()).unwrap();
        steps += 1;
        if steps % 10 == 0 {
            reinitialize(front.phi_mut(), 20, Boundary::Extrapolate);
        }
    }
    front.phi().clone()
}

#[test]
fn narrow_band_gives_the_contour_of_the_full_grid() {
    for n in [64, 128] {
        let full = grown(n, None);
        let band = grown(n, Some(8.0 / n as f64));
        let exact = |p| distance(p, [0.5, 0.5, 0.0]) - 0.4;
        let [e, f] = [&full, &band].map(|phi| contour_error(phi, Read::Linear, exact));
        let [p, q] = [&full, &band].map(|phi| contour(phi, Read::Linear));
        assert_eq!(p.len(), q.len());
        let gap = p.iter().zip(&q).map(|(p, q)| distance(*p, *q)).fold(0.0, f64::max) * n as f64;
        println!(
            "narrow band, n = {n}: off the full grid by {gap:.1e} h, errors {e:.5} and {f:.5} h"
        );
        // Equally right, and the same to better than the error that both make.
        assert!(gap < e && (e - f).abs() < 0.1 * e);
    }
}

#[test]
fn outside_the_band_nothing_changes() {
    for order in [Order::First, Order::Weno5] {
        let phi = Field::from_fn(unit(3, 20), |p| distance(p, [0.5; 3]) - 0.25);
        let full = Scheme { order, ..Scheme::default() };
        let mut front = LevelSet::new(phi.clone(), Scheme { band: Some(0.3), ..full }).unwrap();
        for _ in 0..3 {
            front.advance(&mut ConstantSpeed(1.0), 0.01).unwrap();
        }
        let rows = phi.as_slice().chunks(21).zip(front.phi().as_slice().chunks(21));
        let mut still = 0;
        for (before, after) in rows.filter(|(row, _)| row.iter().all(|v| v.abs() >= 0.3)) {
            // Within a row, short gaps between nodes of the band evolve too.
            assert_eq!(before, after);
            still += 1;
        }
        assert!(still > 50 && front.phi() != &phi);
        let all = Scheme { order, ..Scheme::default() };
        let wide = Scheme { band: Some(10.0), ..all.clone() };
        let (all, wide) =
            (after(&phi, &all, ConstantSpeed(1.0), 4), after(&phi, &wide, ConstantSpeed(1.0), 4));
        assert_eq!(all, wide, "a band over the whole grid is the whole grid");
    }
}

#[test]
fn floor_and_clip_do_what_they_say() {
    let grid = Grid::new(&[8, 9], 1.0).unwrap();
    let flat = Field::constant(grid, 2.9);
    let scheme = Scheme {
        order: Order::First,
        gradient_floor: Some(1.0),
        clip: Some(3.0),
        ..Scheme::default()
    };
    let mut front = LevelSet::new(flat, scheme).unwrap();
    front.step(&mut ConstantSpeed(1.0), 0.45).unwrap();
    assert!(front.phi().as_slice().iter().all(|&v| v == 2.9 - 0.45), "flat phi sinks");
    for _ in 0..20 {
        front.step(&mut ConstantSpeed(-1.0), 0.45).unwrap();
    }
    assert!(front.phi().as_slice().iter().all(|&v| v == 3.0), "and stops at the clip");
    let plain = Scheme { gradient_floor: None, ..front.scheme().clone() };
    front.set_scheme(plain).unwrap();
    front.step(&mut ConstantSpeed(1.0), 0.45).unwrap();
    assert!(front.phi().as_slice().iter().all(|&v| v == 3.0), "without the floor flat is still");
}

#[test]
fn blow_up_is_named_and_keeps_the_last_state() {
    let grid = Grid::new(&[6, 7], 1.0).unwrap();
    let phi = Field::from_fn(grid, |[x, _, _]| x - 3.0);
    for order in [Order::First, Order::Weno5] {
        let scheme = Scheme { order, ..Scheme::default() };
        let mut front = LevelSet::new(phi.clone(), scheme).unwrap();
        front.set_time(0.4);
        let mut hole =
            FnSpeed(|p: [f64; 3], _: f64| if p == [2.0, 3.0, 0.0] { f64::NAN } else { 1.0 });
        let message = front.step(&mut hole, 0.1).unwrap_err().to_string();
        assert!(
            message.starts_with("phi became NaN at t = 0.4 at node (j, i) = (3, 2)"),
            "{message}"
        );
        assert_eq!(front.phi(), &phi);
        front.step(&mut ConstantSpeed(1.0), 0.1).unwrap();
    }
}

#[test]
fn impossible_requests_are_refused() {
    let phi = || Field::from_fn(Grid::new(&[6, 7], 1.0).unwrap(), |[x, _, _]| x - 3.0);
    let refused = |scheme: Scheme| LevelSet::new(phi(), scheme).unwrap_err().to_string();
    let plain = Scheme::default;
    assert_eq!(refused(Scheme { cfl: 1.5, ..plain() }), "cfl = 1.5 is outside its range (0, 1]");
    let message = refused(Scheme { gradient_floor: Some(-1.0), ..plain() });
    assert_eq!(message, "gradient_floor = -1 is outside its range (0, inf)");
    let message = refused(Scheme { band: Some(f64::NAN), ..plain() });
    assert_eq!(message, "band = NaN is outside its range (0, inf)");
    let message = refused(Scheme { clip: Some(0.0), ..plain() });
    assert_eq!(message, "clip = 0 is outside its range (0, inf)");
    let mut front = LevelSet::new(phi(), plain()).unwrap();
    let message = front.advance(&mut ConstantSpeed(0.0), f64::INFINITY).unwrap_err().to_string();
    assert_eq!(message, "dt_max = inf is outside its range (0, inf)");
    let message = front.step(&mut CurvatureSpeed::new(-1.0), 0.1).unwrap_err().to_string();
    assert_eq!(message, "curvature coefficient = -1 is outside its range [0, inf)");
    assert_eq!(front.advance(&mut ConstantSpeed(0.0), 0.3).unwrap(), 0.3);
    let unknown: Result<Scheme, _> = toml_like("cfi");
    assert!(unknown.unwrap_err().to_string().contains("unknown field `cfi`"));
}

/// A scheme from a map with one key.
fn toml_like(key: &str) -> Result<Scheme, serde::de::value::Error> {
    use serde::{Deserialize, de::value::MapDeserializer};
    Scheme::deserialize(MapDeserializer::new(std::iter::once((key, 0.5))))
}

#[test]
fn steps_obey_their_rules() {
    let phi = || Field::from_fn(Grid::new(&[20, 20], 0.1).unwrap(), |[x, y, _]| x - y);
    let step = |speed: &mut dyn Speed| {
        let scheme = Scheme { cfl: 0.6, ..Scheme::default() };
        LevelSet::new(phi(), scheme).unwrap().advance(speed, 10.0).unwrap()
    };
    let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-14, "{a} {b}");
    close(step(&mut ConstantSpeed(-2.0)), 0.6 * 0.1 / (2.0 * 2.0_f64.sqrt()));
    close(step(&mut FnAdvection(|_: [f64; 3], _: f64| [3.0, -1.0, 99.0])), 0.6 * 0.1 / 4.0);
    close(step(&mut CurvatureSpeed::new(0.5)), 0.6 * 0.01 / (2.0 * 2.0 * 0.5));
}

proptest! {
    // Few cases: each advances two fronts.
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    /// First order is monotone: a front inside another stays inside (Crandall & Lions 1984).
    #[test]
    fn nested_fronts_stay_nested(radius in 2.0..6.0_f64, x in 6.0..10.0_f64, gap in 0.0..2.0_f64, beta in -1.0..1.0_f64) {
        let grid = Grid::new(&[17, 17], 1.0).unwrap();
        let outer = Field::from_fn(grid, |p| distance(p, [x, 8.0, 0.0]) - radius);
        let inner = Field::from_fn(grid, |p| distance(p, [8.0, x, 0.0]).max(distance(p, [x, 8.0, 0.0])) - radius + gap);
        let speed = || FnSpeed(move |[x, y, _]: [f64; 3], _: f64| beta + 0.4 * (x - y).sin());
        let scheme = Scheme { order: Order::First, boundary: Boundary::Neumann, ..Scheme::default() };
        let mut fronts = [outer, inner].map(|phi| LevelSet::new(phi, scheme.clone()).unwrap());
        for _ in 0..10 {
            for front in &mut fronts {
                front.step(&mut speed(), 0.45).unwrap();
            }
        }
        let [outer, inner] = &fronts;
        // Rounding of a sum of ten steps.
        prop_assert!(outer.phi().as_slice().iter().zip(inner.phi().as_slice()).all(|(o, i)| *o <= i + 1e-12));
    }

    /// Motion along normals forth and back through smooth stages returns the circle.
    #[test]
    fn growth_and_retreat_cancel(radius0 in 0.2..0.3_f64, x in 0.45..0.55_f64) {
        let center = [x, 0.5, 0.0];
        let mut front = LevelSet::new(
            Field::from_fn(unit(2, 40), |p| distance(p, center) - radius0),
            scheme(Order::Weno5),
        ).unwrap();
        for beta in [1.0, -1.0] {
            for _ in 0..10 {
                front.step(&mut ConstantSpeed(beta), 0.008).unwrap();
            }
        }
        let (mean, spread) = radius(front.phi(), center);
        // A hundredth of a cell: 20 steps of fifth order in space, third in time.
        prop_assert!((mean - radius0).abs() < 0.01 / 40.0 && spread < 0.01 / 40.0, "{mean} {spread}");
    }
}
