//! Turing patterns with holes and what this program puts into them, as NPY for
//! `benches/peers/disocclusion/run.py`, which measures them and other programs' fillings.
//!
//! cargo bench --bench filling -- FOLDER [SEEDS]
#![allow(
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a study reads the clock and prints its progress"
)]

use patterns::disocclusion::fill::{Fill, fill};
use patterns::disocclusion::{Class, Database, normalize};
use patterns::{Artifact, Context, NoInputs, Status};
use solvers::{Field, Grid};
use std::{error::Error, fs, path::Path, time::Instant};

/// Rows and columns.
const SIDE: usize = 128;

/// Name in the table, class and point (shares of its ranges).
const PATTERNS: [(&str, &str, [f64; 2]); 2] =
    [("spots", "turing-spots", [1.0, 1.0 / 3.0]), ("stripes", "turing-labyrinth", [0.6, 0.6])];

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1).filter(|text| text != "--bench");
    let folder = arguments.next().ok_or("usage: filling FOLDER [SEEDS]")?;
    let seeds: u64 = arguments.next().map_or(Ok(3), |text| text.parse())?;
    fs::create_dir_all(&folder)?;
    let database = Database::built_in()?;
    for (name, class, point) in PATTERNS {
        let class = database.find(class).ok_or("no such class")?;
        for seed in 1..=seeds {
            let (b, ink) = pattern(class, &point, seed)?;
            for (hole, visible) in [("sixteen", sixteen()), ("one", one())] {
                let path = |part: &str| format!("{folder}/{name}-{hole}-{seed}-{part}.npy");
                let numbers =
                    |flags: &[bool]| flags.iter().map(|&f| f64::from(u8::from(f))).collect();
                write(path("ink"), numbers(&ink))?;
                write(path("visible"), numbers(&visible))?;
                write(path("grey"), b.clone())?;
                for kind in ["grey", "binary"] {
                    let start = Instant::now();
                    let values = match kind {
                        "grey" => b.clone(),
                        _ => ink.iter().map(|&ink| f64::from(u8::from(!ink))).collect(),
                    };
                    let picture = Field::from_vec(Grid::new(&[SIDE, SIDE], 1.0)?, values)?;
                    let normal = normalize(&picture, &visible)?;
                    let grey = (kind == "grey").then_some(picture);
                    let settings = Fill { seed, grey, ..Fill::default() };
                    let filled = fill(&normal, Some(class), &point, &settings, &NoInputs)?;
                    let own = start.elapsed().as_secs_f64();
                    for (n, sample) in filled.samples.iter().enumerate() {
                        write(path(&format!("ours_{kind}_{n}")), numbers(sample))?;
                    }
                    write(path(&format!("confidence_{kind}")), filled.confidence)?;
                    let start = Instant::now();
                    if std::env::var("NOPATCH").is_err() {
                        let patch = fill(&normal, None, &[], &settings, &NoInputs)?;
                        write(path(&format!("patch_{kind}")), numbers(patch.picture()))?;
                    }
                    let seconds = start.elapsed().as_secs_f64();
                    println!(
                        "{name}, {hole}, seed {seed}, {kind}: ours {own:.2} s, patch {seconds:.2} s"
                    );
                }
            }
        }
    }
    Ok(())
}

/// Concentration of b in 256 grey levels, and ink.
fn pattern(
    class: &Class,
    point: &[f64],
    seed: u64,
) -> Result<(Vec<f64>, Vec<bool>), Box<dyn Error>> {
    let context = Context { seed, inputs: &NoInputs, memory: 1 << 30 };
    let mut run = (class.model.start)(&class.configure(point)?, &context)?;
    while run.step()? == Status::Running {}
    let b = run.artifacts().into_iter().find_map(|artifact| match artifact {
        Artifact::Image(image) if image.name == "b" => Some(image.field),
        _ => None,
    });
    let b = b.ok_or("no concentration b")?;
    let ((low, high), (mean, _)) = (b.range(), b.mean_std());
    let grey = |&v: &f64| ((v - low) / (high - low) * 255.0).round() / 255.0;
    Ok((b.as_slice().iter().map(grey).collect(), b.as_slice().iter().map(|&v| v < mean).collect()))
}

/// All but sixteen boxes of 16 x 16 pixels.
fn sixteen() -> Vec<bool> {
    let hidden = |x: usize| (8..24).contains(&(x % 32));
    (0..SIDE * SIDE).map(|n| !(hidden(n / SIDE) && hidden(n % SIDE))).collect()
}

/// All but one box of 64 x 64 pixels.
fn one() -> Vec<bool> {
    let hidden = |x: usize| (SIDE / 4..3 * SIDE / 4).contains(&x);
    (0..SIDE * SIDE).map(|n| !(hidden(n / SIDE) && hidden(n % SIDE))).collect()
}

/// A square array, NPY format 1.0.
fn write(path: impl AsRef<Path>, values: Vec<f64>) -> Result<(), Box<dyn Error>> {
    let mut header =
        format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({SIDE}, {SIDE}), }}");
    header += &" ".repeat(117 - header.len());
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.bytes());
    bytes.extend(values.into_iter().flat_map(f64::to_le_bytes));
    Ok(fs::write(path, bytes)?)
}
