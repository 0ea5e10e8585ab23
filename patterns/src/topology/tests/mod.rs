#![expect(
    clippy::print_stdout,
    reason = "measured figures are printed for the reader of a test run"
)]

mod digits;
mod fronts;
mod gradients;
mod problems;
mod runs;

use super::{design::Design, simp::Evaluator, update::Functions, *};
use crate::NoInputs;

fn context() -> Context<'static> {
    Context { seed: 0, inputs: &NoInputs, memory: 1 << 33 }
}

/// A problem of the database with other settings.
fn table(name: &str, settings: &str) -> toml::Table {
    let mut table: toml::Table = settings.parse().unwrap();
    table.insert("table".into(), toml::Value::String(name.into()));
    database::expand(&table).unwrap()
}

/// Runs to the end.
fn run(table: &toml::Table) -> Box<dyn Run> {
    let mut run = start(table, &context()).unwrap();
    while run.step().unwrap() == Status::Running {}
    run
}

fn metric(run: &dyn Run, name: &str) -> f64 {
    run.metrics().into_iter().find(|metric| metric.name == name).unwrap().value
}

/// The printed compliance and the number of iterations.
fn printed(name: &str, settings: &str) -> (String, u64) {
    let run = run(&table(name, settings));
    let value = run.observe()[0].value;
    println!("{name} {settings:?}: {value:.4} after {} iterations", run.iterations());
    (format!("{value:.4}"), run.iterations())
}

fn refusal(name: &str, settings: &str) -> String {
    match start(&table(name, settings), &context()) {
        Ok(_) => panic!("{name} {settings} was not refused"),
        Err(error) => error.to_string(),
    }
}
