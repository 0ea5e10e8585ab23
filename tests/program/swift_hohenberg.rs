//! Swift and Hohenberg's equation by every stepper: orders, energy, wavelength.

use patterns::{Context, Inputs, MODELS, NoInputs, Run, Status, Values};
use solvers::isosurface::Polyline;
use solvers::{Field, Grid, order::observed_order};
use std::f64::consts::TAU;

const N: usize = 32;
const K0: f64 = TAU / 8.0;
const R: f64 = 0.2;
const G: f64 = 0.6;

/// A smooth start.
struct Waves;

impl Inputs for Waves {
    fn field(&self, _: &str, _: &str) -> patterns::Result<Field> {
        let k = TAU / N as f64;
        let wave =
            |[x, y, _]: [f64; 3]| 0.4 * (4.0 * k * x).cos() + 0.2 * (3.0 * k * y + k * x).sin();
        Ok(Field::from_fn(Grid::new(&[N, N], 1.0)?, wave))
    }

    fn lines(&self, key: &str, path: &str) -> patterns::Result<Vec<Polyline>> {
        NoInputs.lines(key, path)
    }
}

fn start(config: &str) -> Box<dyn Run> {
    let model = MODELS.iter().find(|model| model.name == "rd").unwrap();
    let context = Context { seed: 0, inputs: &Waves, memory: 1 << 32 };
    (model.start)(&config.parse().unwrap(), &context).unwrap()
}

fn u(run: &dyn Run) -> Vec<f64> {
    match &run.save().arrays["u"] {
        Values::F64(values) => values.clone(),
        other => panic!("{other:?}"),
    }
}

fn config(stepper: &str, dt: f64, iterations: usize) -> String {
    format!(
        "kinetics = 'swift-hohenberg'\nsize = {N}\nstepper = '{stepper}'\ndt = {dt:?}\n\
         iterations = {iterations}\nperturbation = []\ninitial = {{ u = 'waves' }}\n\
         parameters = {{ r = {R}, g = {G}, k0 = {K0} }}"
    )
}

/// u at time 4 after `steps` steps.
fn after(stepper: &str, steps: usize) -> Vec<f64> {
    let mut run = start(&config(stepper, 4.0 / steps as f64, steps));
    while run.step().unwrap() == Status::Running {}
    u(run.as_ref())
}

#[test]
fn steppers_have_their_orders() {
    let reference = after("etdrk4", 1024);
    for (stepper, order, steps) in [
        ("etdrk4", 4.0, [32, 64, 128]),
        ("semi-implicit", 2.0, [64, 128, 256]),
        ("explicit", 1.0, [128, 256, 512]),
    ] {
        let error = |n| {
            let values = after(stepper, n);
            values.iter().zip(&reference).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        let observed = observed_order(&steps, error);
        println!(
            "{stepper:14} order {observed:.3}, error {:.1e} with {} steps",
            error(steps[2]),
            steps[2]
        );
        assert!((observed - order).abs() < 0.1 * order, "{stepper}: {observed}");
    }
}

/// `mean(((k0^2 + lap) u)^2 / 2 - r u^2 / 2 - g u^3 / 3 + u^4 / 4)`, nine points.
fn energy(u: &[f64]) -> f64 {
    let at = |j: usize, i: usize| u[j % N * N + i % N];
    let density = |n: usize| {
        let (j, i) = (n / N + N, n % N + N);
        let edges = at(j - 1, i) + at(j + 1, i) + at(j, i - 1) + at(j, i + 1);
        let corners = at(j - 1, i - 1) + at(j - 1, i + 1) + at(j + 1, i - 1) + at(j + 1, i + 1);
        let curved = K0 * K0 * u[n] + (4.0 * edges + corners - 20.0 * u[n]) / 6.0;
        let v = u[n];
        0.5 * (curved * curved - R * v * v) - G * v.powi(3) / 3.0 + 0.25 * v.powi(4)
    };
    (0..N * N).map(density).sum::<f64>() / (N * N) as f64
}

/// The equation is the gradient flow of its energy: no step may raise it.
#[test]
fn the_energy_never_rises() {
    for (stepper, dt) in [("etdrk4", 0.5), ("semi-implicit", 0.25), ("explicit", 0.05)] {
        let mut run = start(&config(stepper, dt, 4000));
        let (first, mut last) = (energy(&u(run.as_ref())), f64::INFINITY);
        loop {
            let status = run.step().unwrap();
            let next = energy(&u(run.as_ref()));
            // Once at rest, only round-off is left.
            assert!(next <= last + 1e-15, "{stepper}: {next} after {last}");
            last = next;
            if status != Status::Running {
                break;
            }
        }
        println!("{stepper:14} energy {first:.6} to {last:.6}");
        assert!(last < 0.0);
    }
}

/// All steppers come to the same rest state from the same start.
#[test]
fn steppers_agree_on_the_pattern() {
    let rest = |stepper: &str, dt: f64| {
        let mut run = start(&config(stepper, dt, (400.0 / dt) as usize));
        while run.step().unwrap() == Status::Running {}
        u(run.as_ref())
    };
    let reference = rest("etdrk4", 0.25);
    for (stepper, dt) in [("semi-implicit", 0.1), ("explicit", 0.05)] {
        let other = rest(stepper, dt);
        let difference =
            other.iter().zip(&reference).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("{stepper:14} differs from etdrk4 by {difference:.1e}");
        assert!(difference < 1e-6, "{stepper}: {difference:e}");
    }
}

/// Linear theory knows the fastest wave, |k| = k0, and its growth, r.
#[test]
fn dispersion_is_predicted() {
    let run = start(&format!("{}\ndispersion = true", config("etdrk4", 0.1, 10)));
    let metrics = run.metrics();
    let value = |name: &str| metrics.iter().find(|metric| metric.name == name).unwrap().value;
    assert!((value("predicted_growth") - R).abs() < 1e-6);
    // Eight cells in the continuum; the nine points' symbol is k0^2 at a wave a little shorter.
    assert!((value("predicted_wavelength") / 8.0 - 1.0).abs() < 0.04);
}
