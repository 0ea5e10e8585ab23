#![expect(
    clippy::print_stdout,
    reason = "measured figures are printed for the reader of a test run"
)]

use super::*;
use crate::NoInputs;

fn context() -> Context<'static> {
    Context { seed: 0, inputs: &NoInputs, memory: 1 << 33 }
}

/// A problem of the database with other settings.
fn table(name: &str, settings: &str) -> toml::Table {
    let preset = database::presets().into_iter().find(|preset| preset.name == name).unwrap();
    let mut table: toml::Table = preset.config.parse().unwrap();
    table.extend(settings.parse::<toml::Table>().unwrap());
    table
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

/// Octave's figures with the originals (Sigmund 2001; Andreassen et al. 2011), to all
/// printed digits, with the same number of iterations.
#[test]
fn the_originals_digit_by_digit() {
    let expected = [
        ("row-a", "", "203.3061", 94),
        ("mbb", "", "203.1925", 94),
        ("mbb", "filter = 'density'", "218.8032", 127),
        ("cantilever", "", "57.3492", 71),
        ("row-c", "", "47.4605", 33),
        ("row-c", "rules = '88'\ninterpolation = 'modified'", "47.4410", 33),
        ("row-l", "volume = 0.4\nfilter_radius = 1.2", "61.2880", 76),
        ("row-h", "", "22.2650", 17),
        ("row-l", "", "50.4218", 29),
        ("row-d", "", "9.5551", 19),
        ("row-f", "", "23.6862", 26),
        ("row-p", "", "6.3028", 20),
        ("row-l", "one_case = true", "17.0364", 53),
        ("row-h", "one_case = true\nrules = '88'\ninterpolation = 'modified'", "5.0960", 37),
    ];
    for (name, settings, value, iterations) in expected {
        assert_eq!(printed(name, settings), (value.to_owned(), iterations), "{name} {settings}");
    }
}
