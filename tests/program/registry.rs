//! Rules that every model obeys; a new model is tested without touching this file.

use patterns::{Context, Inputs, MODELS, Model, NoInputs, Result, Run, Status};
use solvers::{Field, Grid, isosurface::Polyline};
use toml::Table;

const SEED: Context<'static> = Context { seed: 7, inputs: &Ball, memory: 1 << 32 };

/// A ball in space for models that want a shape; no lines.
struct Ball;

impl Inputs for Ball {
    fn field(&self, _: &str, _: &str) -> Result<Field> {
        let far = |p: [f64; 3]| p.iter().map(|x| (x - 7.5).powi(2)).sum::<f64>().sqrt();
        Ok(Field::from_fn(Grid::new(&[16; 3], 1.0)?, |p| if far(p) < 5.0 { 1.0 } else { 0.0 }))
    }

    fn lines(&self, key: &str, path: &str) -> Result<Vec<Polyline>> {
        NoInputs.lines(key, path)
    }
}

/// What is refused on purpose: a structure without a problem, and the row of Table 1.1 whose
/// load acts on a support.
const REFUSED: &[(&str, &str)] = &[("topopt", "default"), ("topopt", "row-o")];

/// Settings that make the steps of a model in space short.
const SMALL: &[(&str, &str)] = &[
    ("curvature", "size = 16"),
    ("curvature-atlas", "count = 40\ngrowth = { size = 16, evaluations = 20 }"),
    (
        "curvature-infer",
        "shape = 'ball'\ncount = 3\ngenerations = 2\ngrowth = { size = 16, evaluations = 20 }",
    ),
];

/// Every preset and the default of a model, but for what is refused.
fn configs(model: &Model) -> Vec<(String, Table)> {
    let small = SMALL.iter().find(|(name, _)| *name == model.name);
    let small: Table = small.map_or_else(Table::new, |(_, text)| text.parse().unwrap());
    let presets =
        (model.presets)().into_iter().map(|p| (p.name.to_owned(), p.config.parse().unwrap()));
    let all = std::iter::once(("default".to_owned(), Table::new())).chain(presets);
    let all = all.map(|(name, mut config): (String, Table)| {
        config.extend(small.clone());
        (name, config)
    });
    all.filter(|(name, _)| !REFUSED.contains(&(model.name, name))).collect()
}

#[test]
fn what_is_refused_names_its_key() {
    for (model, name) in REFUSED {
        let model = MODELS.iter().find(|m| m.name == *model).unwrap();
        let preset = (model.presets)().into_iter().find(|p| p.name == *name);
        let config = preset.map_or_else(Table::new, |p| p.config.parse().unwrap());
        match (model.start)(&config, &SEED) {
            Err(patterns::Error::Config { key, .. }) => {
                assert!(key.starts_with("problem"), "{key}")
            }
            Err(other) => panic!("{name}: {other}"),
            Ok(_) => panic!("{name} starts"),
        }
    }
}

fn steps(run: &mut dyn Run, n: usize) {
    for _ in 0..n {
        if run.step().unwrap() != Status::Running {
            break;
        }
    }
}

fn bits(run: &dyn Run) -> String {
    format!("{:?}", run.save())
}

#[test]
fn a_run_repeats_itself_for_one_and_three_threads() {
    for model in MODELS {
        for (name, config) in configs(model) {
            let state = |threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| {
                    let mut run = (model.start)(&config, &SEED).unwrap();
                    steps(run.as_mut(), 12);
                    bits(run.as_ref())
                })
            };
            assert!(state(1) == state(3), "{} {name}: threads change the bytes", model.name);
        }
    }
}

#[test]
fn a_restored_run_goes_on_to_the_same_bytes() {
    for model in MODELS {
        for (name, config) in configs(model) {
            let mut whole = (model.start)(&config, &SEED).unwrap();
            steps(whole.as_mut(), 7);
            let (saved, done) = (whole.save(), whole.iterations());
            steps(whole.as_mut(), 6);
            let mut resumed = (model.start)(&whole.config(), &SEED).unwrap();
            resumed.restore(&saved).unwrap();
            assert_eq!(resumed.iterations(), done);
            steps(resumed.as_mut(), 6);
            assert!(bits(whole.as_ref()) == bits(resumed.as_ref()), "{} {name}", model.name);
        }
    }
}

#[test]
fn the_complete_configuration_is_a_fixed_point() {
    for model in MODELS {
        for (name, config) in configs(model) {
            let complete = (model.start)(&config, &SEED).unwrap().config();
            let again = (model.start)(&complete, &SEED).unwrap().config();
            assert_eq!(complete, again, "{} {name}", model.name);
        }
    }
}

#[test]
fn unknown_keys_are_refused_by_name() {
    for model in MODELS {
        let config = "radios = 0.3".parse().unwrap();
        let error = (model.start)(&config, &SEED).err().unwrap().to_string();
        assert!(error.contains("radios"), "{}: {error}", model.name);
    }
}

#[test]
fn metrics_are_finite_and_have_one_name_each() {
    for model in MODELS {
        let (_, config) = configs(model).swap_remove(0);
        let mut run = (model.start)(&config, &SEED).unwrap();
        steps(run.as_mut(), 12);
        let metrics = run.metrics();
        for (n, metric) in metrics.iter().enumerate() {
            assert!(metric.value.is_finite(), "{}: {metric:?}", model.name);
            assert!(metrics[..n].iter().all(|m| m.name != metric.name), "{metric:?} twice");
        }
    }
}
