//! Recovery of known parameters: textures are grown from other noise than the search's, and what
//! is found is put beside what made them, its distance beside that of the true parameters.
//!
//! `cargo bench --bench recovery -- ATLAS [SIZE] [GENERATIONS] [PRESETS,..] [EVALUATIONS] [SEARCHED]`,
//! ATLAS being the output folder of `patterns curvature atlas`, the evaluations those of the known
//! textures and of the search's; a minute or two a texture.
#![allow(clippy::print_stdout, reason = "a study prints a table")]

use lab::inputs::FileInputs;
use patterns::curvature::{self, atlas, infer};
use patterns::{Artifact, Context, Inputs, Model, Result, Run, Status};
use solvers::{Field, isosurface::Polyline};

const KNOWN: [&str; 4] = ["tubes", "bilayers", "vesicles", "sponges"];
const PARAMETERS: [&str; 6] = ["a11", "a02", "b10", "b01", "c", "mass"];

/// The grown phase under the name `given`; files otherwise.
struct Given {
    phase: Field,
    files: FileInputs,
}

impl Inputs for Given {
    fn field(&self, key: &str, path: &str) -> Result<Field> {
        if path == "given" { Ok(self.phase.clone()) } else { self.files.field(key, path) }
    }

    fn lines(&self, key: &str, path: &str) -> Result<Vec<Polyline>> {
        self.files.lines(key, path)
    }
}

fn main() -> Result<()> {
    let argument = |n: usize| std::env::args().filter(|text| text != "--bench").nth(n);
    let number =
        |n: usize, default: u64| argument(n).and_then(|text| text.parse().ok()).unwrap_or(default);
    let Some(folder) = argument(1) else {
        println!("name the output folder of `patterns {}`", atlas::MODEL.name);
        return Ok(());
    };
    let (size, generations) = (number(2, 48), number(3, 32));
    let wanted = argument(4).unwrap_or_default();
    let (evaluations, searched) = (number(5, 300), number(6, 200));
    let chosen = |name: &str| wanted.is_empty() || wanted.split(',').any(|w| w == name);
    let study = Study { folder, size, generations, evaluations, searched };
    KNOWN.into_iter().filter(|name| chosen(name)).try_for_each(|name| study.recover(name))
}

/// How the known textures and the search's grow.
struct Study {
    folder: String,
    size: u64,
    generations: u64,
    evaluations: u64,
    searched: u64,
}

impl Study {
    /// Grows a texture and looks for what made it.
    fn recover(&self, name: &str) -> Result<()> {
        let Self { folder, size, generations, evaluations, searched } = self;
        let texture = format!("preset = '{name}'\nsize = {size}\nevaluations = {evaluations}");
        let (grown, known) = finish(&curvature::MODEL, &texture, 77, &FileInputs::new(vec![]))?;
        let phase = grown.artifacts().into_iter().find_map(|artifact| match artifact {
            Artifact::Image(image) if image.name == "phase" => Some(image.field),
            _ => None,
        });
        let Some(phase) = phase else { return Ok(()) };
        let given = Given { phase, files: FileInputs::new(vec![".".into()]) };
        let growth = format!("[growth]\nevaluations = {searched}");
        let search =
            format!("shape = 'given'\natlas = '{folder}'\ngenerations = {generations}\n{growth}");
        let (run, _) = finish(&infer::MODEL, &search, 1, &given)?;
        let metric = |name: &str| metric(run.as_ref(), name);
        let list = known.get("coefficients").and_then(toml::Value::as_array);
        let coefficient = |n: usize| {
            let value = list.and_then(|list| list.get(n)).cloned();
            value.and_then(|v| v.as_float()).unwrap_or(f64::NAN)
        };
        let mass = known.get("mass").and_then(toml::Value::as_float).unwrap_or(f64::NAN);
        let truth = [1, 2, 3, 4, 5, 6].map(|n| if n == 6 { mass } else { coefficient(n) });
        println!(
            "{name}: distance {:.2}, of the true parameters {:.2} (nearest of the atlas {:.2}, \
             other noise {:.2}, between noises {:.2})",
            metric("distance"),
            distance_of(truth, *searched, &given).unwrap_or(f64::NAN),
            metric("nearest_distance"),
            metric("distance_other_noise"),
            metric("distance_of_noises")
        );
        for (parameter, truth) in PARAMETERS.into_iter().zip(truth) {
            let [low, high] = ["low", "high"].map(|end| metric(&format!("{parameter}_{end}")));
            let found = metric(parameter);
            // The mass is the given shape's own.
            let range = if low.is_nan() {
                String::new()
            } else {
                let inside = if (low..=high).contains(&truth) { "in" } else { "NOT in" };
                format!("the truth is {inside} [{low:.3}, {high:.3}]")
            };
            println!("  {parameter:4} {truth:9.3} found {found:9.3} {range}");
        }
        Ok(())
    }
}

/// Distance of what the true parameters grow in the search's way, from other noise.
fn distance_of(truth: [f64; 6], searched: u64, given: &Given) -> Result<f64> {
    let mut only = format!(
        "shape = 'given'\ncount = 3\ngenerations = 0\n[growth]\nevaluations = {searched}\n[ranges]\n"
    );
    for (parameter, value) in PARAMETERS.into_iter().zip(truth) {
        only += &format!("{parameter} = [{value:?}, {value:?}]\n");
    }
    let (run, _) = finish(&infer::MODEL, &only, 1, given)?;
    Ok(metric(run.as_ref(), "distance"))
}

fn metric(run: &dyn Run, name: &str) -> f64 {
    run.metrics().iter().find(|m| m.name == name).map_or(f64::NAN, |m| m.value)
}

/// Runs a model to its end; the run and its whole configuration.
fn finish(
    model: &Model,
    config: &str,
    seed: u64,
    inputs: &dyn Inputs,
) -> Result<(Box<dyn Run>, toml::Table)> {
    let context = Context { seed, inputs, memory: 4 << 30 };
    let table: toml::Table = config.parse().unwrap_or_default();
    let mut run = (model.start)(&table, &context)?;
    while run.step()? == Status::Running {}
    let config = run.config();
    Ok((run, config))
}
