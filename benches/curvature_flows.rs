//! The fast flow beside the published one: energies, evaluations, seconds, and whether both
//! grow the same texture, over several seeds.
//!
//! `cargo bench --bench curvature_flows -- [SIZE] [SEEDS] [PRESETS,..] [EVALUATIONS,..] [OPENING]`,
//! the last two of the fast flow, its opening being 200 where evaluations are given; at the
//! published size of 100 a seed takes a minute and a half.
#![allow(
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a study reads the clock and prints a table"
)]

use patterns::Result;
use patterns::curvature::energy::{Energy, EnergyConfig, Spatial};
use patterns::curvature::flow::{Opened, OpenedConfig, Paper, PaperConfig};
use patterns::curvature::{Coefficients, Diagram, Potential};
use solvers::{
    Field, Grid,
    isosurface::{self, Caps},
};
use std::time::Instant;

/// Name, coefficients, mass, evaluations of the fast flow, of them of its opening.
type Case = (&'static str, [f64; 6], f64, u64, u64);

const CASES: [Case; 4] = [
    ("tubes", [1.0, 2.0, 6.0, -40.0, -40.0, 400.0], -0.6, 800, 200),
    ("bilayers", [1.0, 1.0, 1.0, 0.0, 0.0, 0.0], -0.4, 1920, 1700),
    ("layers", [2.0, 2.0, 2.0, 0.0, 0.0, 0.0], -0.3, 1780, 1500),
    ("sponges", [1.0, 2.8, 2.0, -10.0, -10.0, 25.0], -0.25, 1000, 200),
];

/// Steps of the published flow.
const STEPS: u64 = 4000;

/// What a flow came to.
struct End {
    energy: f64,
    discrepancy: f64,
    seconds: f64,
    diagram: Diagram,
}

fn main() -> Result<()> {
    let argument = |n: usize| std::env::args().filter(|text| text != "--bench").nth(n);
    let number = |n: usize, default: usize| {
        argument(n).and_then(|text| text.parse().ok()).unwrap_or(default)
    };
    let (size, seeds) = (number(1, 100), number(2, 5));
    let wanted = argument(3).unwrap_or_default();
    let chosen = |name: &str| wanted.is_empty() || wanted.split(',').any(|w| w == name);
    for (name, coefficients, mass, evaluations, opening) in
        CASES.into_iter().filter(|c| chosen(c.0))
    {
        let asked = argument(4).map(|list| list.split(',').flat_map(str::parse).collect());
        let lengths: Vec<u64> = asked.unwrap_or_else(|| vec![evaluations]);
        let opening = if argument(4).is_some() { 200 } else { opening };
        let opening = number(5, opening as usize) as u64;
        if let Some(short) = lengths.iter().find(|length| **length <= opening) {
            println!("{short} evaluations end before the opening of {opening}");
            return Ok(());
        }
        println!(
            "{name}: seed, published F ND s, evaluations, fast F ND s, when below the published F"
        );
        let mut published = Vec::new();
        let mut fast: Vec<Vec<End>> = lengths.iter().map(|_| Vec::new()).collect();
        for seed in 1..=seeds as u64 {
            let problem = Problem { size, coefficients, mass, opening, seed };
            let one = problem.published()?;
            for (&length, fast) in lengths.iter().zip(&mut fast) {
                let (two, reached) = problem.fast(length, one.energy)?;
                let reached = reached.map_or("never".into(), |(n, s)| format!("{n} in {s:.1} s"));
                println!(
                    "  {seed}  {:9.1} {:.3} {:6.1}  {length} {:9.1} {:.3} {:6.1}  {reached}",
                    one.energy,
                    one.discrepancy,
                    one.seconds,
                    two.energy,
                    two.discrepancy,
                    two.seconds
                );
                fast.push(two);
            }
            published.push(one);
        }
        let among = distances(&published, &published)?;
        println!("  diagrams: published among themselves {}", summary(&among));
        for (length, fast) in lengths.iter().zip(&fast) {
            let between = distances(fast, &published)?;
            let (more, error) = excess(&between, &among, seeds);
            println!(
                "            {length} evaluations from published {}; more by {more:.2} +- {error:.2}",
                summary(&between)
            );
        }
    }
    Ok(())
}

struct Problem {
    size: usize,
    coefficients: [f64; 6],
    mass: f64,
    opening: u64,
    seed: u64,
}

impl Problem {
    fn energy(&self) -> Result<Energy<f32>> {
        let coefficients = Coefficients::from(self.coefficients);
        Ok(Energy::new(EnergyConfig::new([self.size; 3], 0.01, 0.02, coefficients))?)
    }

    fn potential(&self) -> Result<Potential<f32>> {
        Ok(Potential::new([self.size; 3], 0.01, 2.0, &Spatial::Uniform(self.mass))?)
    }

    fn published(&self) -> Result<End> {
        let (energy, potential) = (self.energy()?, self.potential()?);
        let mut flow = Paper::new(energy, potential, PaperConfig::default(), self.seed)?;
        let clock = Instant::now();
        let mut energy = f64::NAN;
        for _ in 0..=STEPS {
            energy = flow.step()?.energy;
        }
        end(flow.energy(), flow.phase(), energy, clock.elapsed().as_secs_f64())
    }

    /// The fast flow from the same start, and when it was first below `target`.
    fn fast(&self, evaluations: u64, target: f64) -> Result<(End, Option<(u64, f64)>)> {
        let config = OpenedConfig::new(evaluations, Some(self.opening));
        let mut flow = Opened::new(self.energy()?, self.potential()?, config, self.seed)?;
        let (clock, mut reached, mut energy) = (Instant::now(), None, f64::NAN);
        for n in 1..=evaluations {
            energy = flow.step()?.energy;
            if reached.is_none() && energy <= target {
                reached = Some((n, clock.elapsed().as_secs_f64()));
            }
        }
        let seconds = clock.elapsed().as_secs_f64();
        Ok((end(flow.energy(), flow.phase(), energy, seconds)?, reached))
    }
}

fn end(energy: &Energy<f32>, u: &[f32], value: f64, seconds: f64) -> Result<End> {
    let grid = Grid::new(&energy.config().shape, energy.config().dx)?;
    let phi = Field::from_vec(grid, u.iter().map(|&u| -f64::from(u)).collect())?;
    let mesh = isosurface::surface(&phi, 0.0, Caps::Periodic)?.mesh;
    let diagram = Diagram::of(energy, u, &mesh)?;
    Ok(End { energy: value, discrepancy: energy.discrepancy(u), seconds, diagram })
}

/// Two seeds and the distance of their diagrams.
type Pair = (usize, usize, f64);

/// Of all pairs of different seeds.
fn distances(a: &[End], b: &[End]) -> Result<Vec<Pair>> {
    let mut distances = Vec::new();
    for (i, one) in a.iter().enumerate() {
        for (j, two) in b.iter().enumerate().filter(|(j, _)| *j != i) {
            let distance = one.diagram.distance(&two.diagram, (i * b.len() + j) as u64)?;
            distances.push((i, j, distance));
        }
    }
    Ok(distances)
}

/// Mean distance, without the pairs of one seed where one is given.
fn mean(distances: &[Pair], without: Option<usize>) -> f64 {
    let kept = distances.iter().filter(|(i, j, _)| without.is_none_or(|k| k != *i && k != *j));
    let (count, sum) = kept.fold((0.0, 0.0), |(n, sum), (_, _, d)| (n + 1.0, sum + d));
    sum / count
}

/// By how much the mean of `a` is above that of `b`, and the standard error of that by the
/// jackknife over the seeds (Efron and Stein 1981): what another few seeds could have told.
fn excess(a: &[Pair], b: &[Pair], seeds: usize) -> (f64, f64) {
    let without = |k: Option<usize>| mean(a, k) - mean(b, k);
    let parts: Vec<f64> = (0..seeds).map(|k| without(Some(k))).collect();
    let (n, middle) = (seeds as f64, parts.iter().sum::<f64>() / seeds as f64);
    let squares: f64 = parts.iter().map(|part| (part - middle).powi(2)).sum();
    (without(None), ((n - 1.0) / n * squares).sqrt())
}

fn summary(distances: &[Pair]) -> String {
    let most = distances.iter().map(|d| d.2).fold(0.0, f64::max);
    let least = distances.iter().map(|d| d.2).fold(f64::INFINITY, f64::min);
    format!("mean {:.2}, from {least:.2} to {most:.2} 1/length", mean(distances, None))
}
