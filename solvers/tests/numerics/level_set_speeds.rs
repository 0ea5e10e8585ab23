//! What every speed must do, run for each of them.

use solvers::level_set::{
    ConstantSpeed, CurvatureSpeed, FieldAdvection, FieldSpeed, FnAdvection, FnSpeed, LevelSet,
    Order, Scheme, Speed, Terms,
};
use solvers::{Field, Grid};

/// Large enough for parallel loops.
fn disk() -> Field {
    let grid = Grid::new(&[260, 270], 0.01).unwrap();
    Field::from_fn(grid, |[x, y, _]| (x - 1.3).hypot(y - 1.2) - 0.7)
}

fn wave(scale: f64) -> Field {
    Field::from_fn(disk().grid(), |[x, y, _]| scale * (3.0 * x).sin() * (2.0 * y).cos())
}

/// All parts of the terms, one after the other.
fn values(terms: &mut Terms) -> Vec<f64> {
    let mut all = terms.normal().as_slice().to_vec();
    all.extend(terms.velocity().iter().flat_map(|v| v.as_slice().to_vec()));
    all.extend(terms.curvature().as_slice());
    all
}

fn adds_and_is_finite(speed: &mut dyn Speed) {
    let phi = disk();
    let (mut once, mut twice) = (Terms::new(phi.grid()), Terms::new(phi.grid()));
    speed.add(&phi, 0.3, &mut once).unwrap();
    speed.add(&phi, 0.3, &mut twice).unwrap();
    speed.add(&phi, 0.3, &mut twice).unwrap();
    let (once, twice) = (values(&mut once), values(&mut twice));
    assert!(once.iter().any(|v| *v != 0.0) && once.iter().all(|v| v.is_finite()));
    // Doubling is exact.
    assert!(once.iter().zip(&twice).all(|(a, b)| 2.0 * a == *b), "the speed overwrites");
}

fn moves_a_front_by_the_same_bytes_on_any_threads(make: fn() -> Box<dyn Speed>, order: Order) {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let scheme = Scheme { order, ..Scheme::default() };
            let mut front = LevelSet::new(disk(), scheme).unwrap();
            let mut speed = make();
            let steps: Vec<u64> =
                (0..4).map(|_| front.advance(speed.as_mut(), 0.1).unwrap().to_bits()).collect();
            let phi: Vec<u64> = front.phi().as_slice().iter().map(|v| v.to_bits()).collect();
            (steps, phi)
        })
    };
    let (one, four) = (run(1), run(4));
    assert!(one == four, "1 and 4 threads differ");
    assert!(one.1.iter().zip(disk().as_slice()).any(|(a, b)| *a != b.to_bits()), "nothing moved");
}

/// Runs the suite for a speed: `speed_tests!(name, expression of a boxed speed)`.
macro_rules! speed_tests {
    ($name:ident, $speed:expr) => {
        mod $name {
            use super::*;

            fn make() -> Box<dyn Speed> {
                Box::new($speed)
            }

            #[test]
            fn adds() {
                adds_and_is_finite(make().as_mut());
            }

            #[test]
            fn same_bytes() {
                for order in [Order::First, Order::Weno5] {
                    moves_a_front_by_the_same_bytes_on_any_threads(make, order);
                }
            }
        }
    };
}

speed_tests!(constant, ConstantSpeed(-0.8));
speed_tests!(curvature, CurvatureSpeed { coefficient: 0.1, constant: 0.5 });
speed_tests!(field, FieldSpeed(wave(1.0)));
speed_tests!(closure, FnSpeed(|[x, y, _]: [f64; 3], t: f64| x - y * t));
speed_tests!(field_advection, FieldAdvection(vec![wave(1.0), wave(-0.5)]));
speed_tests!(closure_advection, FnAdvection(|[x, y, _]: [f64; 3], t: f64| [-y, x, t]));
speed_tests!(sum, {
    let parts: Vec<Box<dyn Speed>> = vec![
        Box::new(ConstantSpeed(0.3)),
        Box::new(CurvatureSpeed::new(0.05)),
        Box::new(FnAdvection(|[x, y, _]: [f64; 3], _: f64| [y, -x, 0.0])),
    ];
    parts
});

#[test]
fn sums_add_up() {
    let phi = disk();
    let mut sum: Vec<Box<dyn Speed>> = vec![
        Box::new(FieldSpeed(wave(1.0))),
        Box::new(CurvatureSpeed { coefficient: 2.0, constant: 0.25 }),
    ];
    let mut terms = Terms::new(phi.grid());
    sum.add(&phi, 0.0, &mut terms).unwrap();
    assert_eq!(terms.normal().at(0, 3, 4), wave(1.0).at(0, 3, 4) + 0.25);
    assert_eq!(terms.curvature().at(0, 3, 4), 2.0);
}

#[test]
fn wrong_shapes_are_named() {
    let (phi, mut terms) = (disk(), Terms::new(disk().grid()));
    let small = Field::constant(Grid::new(&[4, 5], 0.01).unwrap(), 0.0);
    let message = FieldSpeed(small).add(&phi, 0.0, &mut terms).unwrap_err().to_string();
    assert_eq!(message, "speed has shape [4, 5], expected [260, 270]");
    let message = FieldAdvection(vec![wave(1.0)]).add(&phi, 0.0, &mut terms).unwrap_err();
    assert_eq!(
        message.to_string(),
        "number of velocity components = 1 is outside its range [2, 2]"
    );
}
