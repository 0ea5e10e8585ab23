//! Growing domains against exact decay, published mode doubling, and the run without growth.

use patterns::{Context, Error, Inputs, MODELS, NoInputs, Run, State, Status, Values};
use solvers::isosurface::Polyline;
use solvers::{Field, Grid};
use std::f64::consts::PI;
use toml::Table;

fn start(config: &str, inputs: &dyn Inputs) -> patterns::Result<Box<dyn Run>> {
    let model = MODELS.iter().find(|model| model.name == "rd").unwrap();
    (model.start)(&config.parse().unwrap(), &Context { seed: 0, inputs, memory: 1 << 32 })
}

fn end(config: &str, inputs: &dyn Inputs) -> Box<dyn Run> {
    let mut run = start(config, inputs).unwrap();
    while run.step().unwrap() == Status::Running {}
    run
}

fn species(run: &dyn Run, name: &str) -> Vec<f64> {
    match &run.save().arrays[name] {
        Values::F64(values) => values.clone(),
        other => panic!("{other:?}"),
    }
}

/// Local maxima above the mean.
fn peaks(u: &[f64]) -> usize {
    let mean = u.iter().sum::<f64>() / u.len() as f64;
    let side = |i: Option<usize>| i.and_then(|i| u.get(i)).copied().unwrap_or(f64::NEG_INFINITY);
    let peak =
        |&i: &usize| u[i] > mean && side(i.checked_sub(1)) <= u[i] && side(Some(i + 1)) < u[i];
    (0..u.len()).filter(peak).count()
}

/// Crampin, Gaffney and Maini 1999: on an exponentially growing row every peak of Schnakenberg's
/// activator splits when the length has doubled.
#[test]
fn peaks_double_when_the_row_doubles() {
    let counts = [3466, 6931, 10397].map(|iterations| {
        let config = format!(
            "preset = 'schnakenberg-growing-row'\nsnapshots = []\niterations = {iterations}"
        );
        let run = end(&config, &NoInputs);
        let scale = run.metrics().into_iter().find(|metric| metric.name == "scale").unwrap().value;
        println!("scale {scale:.3}: {} peaks", peaks(&species(run.as_ref(), "u")));
        peaks(&species(run.as_ref(), "u"))
    });
    assert_eq!(counts, [4, 8, 16]);
}

/// A cosine mode of a row of 32 cells.
struct Wave;

const K: f64 = 3.0 * PI / 32.0;

impl Inputs for Wave {
    fn field(&self, _: &str, _: &str) -> patterns::Result<Field> {
        let grid = Grid::new(&[32], 1.0)?;
        Ok(Field::from_fn(grid, |[x, ..]| 2.0 + (K * (x + 0.5)).cos()))
    }

    fn lines(&self, key: &str, path: &str) -> patterns::Result<Vec<Polyline>> {
        NoInputs.lines(key, path)
    }
}

/// Diffusion alone to time 4 at growth rate 0.3: the mode's factor over the exact
/// `exp(-s D int (L0/L)^2 dt)`, s the Laplacian's symbol, less 1.
fn decay_error(stepper: &str, law: &str, steps: usize) -> f64 {
    let limit = if law == "logistic" { "limit = 3.0" } else { "" };
    let config = format!(
        "kinetics = 'formulas'\nsize = [32]\niterations = {steps}\ndt = {:?}\nstepper = '{stepper}'\n\
         clamp = false\ninitial = {{ c = 'wave' }}\ndiffusion = {{ c = 0.4 }}\ncurve = {{ speed = 'off' }}\n\
         ink = {{ species = 'c', level = 'mean', below = false }}\n[formulas]\nc = '0'\n\
         [growth]\nlaw = '{law}'\nrate = 0.3\ndilution = false\n{limit}",
        4.0 / steps as f64
    );
    let c = species(end(&config, &Wave).as_ref(), "c");
    let wave = |i: usize| (K * (i as f64 + 0.5)).cos();
    let amplitude = (0..32).map(|i| c[i] * wave(i)).sum::<f64>() / 16.0;
    let integral = match law {
        "exponential" => (1.0 - (-2.4_f64).exp()) / 0.6,
        "linear" => (1.0 - 1.0 / 2.2) / 0.3,
        // 1/s = (1 + 2 exp(-r t)) / 3.
        _ => {
            (4.0 + 4.0 * (1.0 - (-1.2_f64).exp()) / 0.3 + 4.0 * (1.0 - (-2.4_f64).exp()) / 0.6)
                / 9.0
        }
    };
    let symbol = 2.0 - 2.0 * K.cos();
    (amplitude / (-symbol * 0.4 * integral).exp() - 1.0).abs()
}

#[test]
fn a_mode_decays_as_the_exact_integral() {
    for law in ["exponential", "linear", "logistic"] {
        for (stepper, order) in [("explicit", 1.0), ("semi-implicit", 2.0)] {
            let [coarse, fine] = [20, 40].map(|steps| decay_error(stepper, law, steps));
            let observed = (coarse / fine).log2();
            println!("{law:12} {stepper:14} order {observed:.3}, error {fine:.1e}");
            assert!((observed - order).abs() < 0.1, "{observed}");
        }
        let exact = decay_error("etdrk4", law, 20);
        println!("{law:12} etdrk4         error {exact:.1e}");
        // Twenty steps of round-off.
        assert!(exact < 1e-13, "{exact:e}");
    }
}

/// With dilution the amount of substance stays: the mean falls as 1/L^dim.
#[test]
fn dilution_keeps_the_amount() {
    for (size, dim) in [("[24]", 1), ("[6, 8]", 2), ("[4, 5, 6]", 3)] {
        for stepper in ["explicit", "semi-implicit", "etdrk4"] {
            let config = format!(
                "kinetics = 'formulas'\nsize = {size}\niterations = 40\ndt = 0.1\nstepper = '{stepper}'\n\
                 initial = {{ c = 2.0 }}\ndiffusion = {{ c = 0.4 }}\ncurve = {{ speed = 'off' }}\n\
                 ink = {{ species = 'c', level = 'mean', below = false }}\n[formulas]\nc = '0'\n\
                 [growth]\nrate = 0.1"
            );
            let mean = species(end(&config, &NoInputs).as_ref(), "c")[0];
            let exact = 2.0 * (-0.4 * f64::from(dim)).exp();
            assert!((mean / exact - 1.0).abs() < 1e-13, "{size} {stepper}: {mean} {exact}");
        }
    }
}

fn saved(config: &str) -> State {
    end(config, &NoInputs).save()
}

/// Rate 0 changes no byte, for every kinetics and stepper.
#[test]
fn no_growth_is_growth_at_rate_zero() {
    let kinetics = patterns::reaction_diffusion::kinetics::KINETICS.iter().map(|k| k.name);
    for kinetics in kinetics {
        for stepper in ["explicit", "semi-implicit", "etdrk4"] {
            let config = format!(
                "kinetics = '{kinetics}'\nsize = [40, 24]\niterations = 25\nstepper = '{stepper}'\n"
            );
            let still = saved(&config);
            for law in ["law = 'exponential'", "law = 'linear'", "law = 'logistic'\nlimit = 2.0"] {
                let grown = saved(&format!("{config}[growth]\nrate = 0.0\n{law}"));
                assert!(grown == still, "{kinetics} {stepper} {law}");
            }
            let grown = saved(&format!("{config}[growth]\nrate = 0.01"));
            assert!(grown != still, "{kinetics} {stepper}");
        }
    }
}

#[test]
fn impossible_growth_is_refused_by_its_key() {
    let refused = |growth: &str| {
        let config: Table = format!("[growth]\n{growth}").parse().unwrap();
        let model = MODELS.iter().find(|model| model.name == "rd").unwrap();
        let context = Context { seed: 0, inputs: &NoInputs, memory: 1 << 32 };
        match (model.start)(&config, &context) {
            Err(Error::Config { key, reason }) => format!("{key}: {reason}"),
            other => panic!("{growth}: {:?}", other.err()),
        }
    };
    assert!(refused("rate = -1.0").starts_with("growth.rate: -1 is outside"));
    assert!(refused("rate = 1.0").contains("times as long"));
    assert!(refused("law = 'linear'").contains("rate"));
    assert!(refused("rate = 0.0\nlaw = 'logistic'").starts_with("growth.limit"));
    assert!(refused("rate = 0.0\nlaw = 'logistic'\nlimit = 1.0").starts_with("growth.limit: 1"));
    assert!(refused("rate = 0.0\nlimit = 2.0").starts_with("growth.limit"));
}
