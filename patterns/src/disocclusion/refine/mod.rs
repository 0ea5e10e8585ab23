//! The parameters of the class that was found, closer than its calibration tells.
//!
//! CMA-ES on the shares of the class's ranges. Classes with a free seed are compared by summary
//! statistics (`statistics.rs`), classes without chance pixel by pixel (`pixels.rs`).

mod pixels;
mod statistics;

use super::{Class, Identifier, Match, Normal};
use crate::{Inputs, Result};
use pixels::Pixels;
use rayon::prelude::*;
use solvers::optimize::Cmaes;
use statistics::Statistics;
use std::collections::BTreeMap;

/// Width of the first generation, share of a range: the calibration's usual error.
const WIDTH: f64 = 0.15;

/// Cost of leaving the ranges by the whole of one: more than any pattern inside costs.
const OUTSIDE: f64 = 100.0;

/// A generation of the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Generation {
    /// Candidates so far that were run, and those that a former one answered.
    pub candidates: [usize; 2],
    /// The least cost so far.
    pub best: f64,
    /// Mean cost of this generation.
    pub mean: f64,
    /// Width of the search, shares of the ranges.
    pub sigma: f64,
}

/// What a search found.
#[derive(Clone, Debug, PartialEq)]
pub struct Refined {
    /// Shares of the ranges.
    pub point: Vec<f64>,
    /// Standard deviation of each.
    pub deviations: Vec<f64>,
    /// How far the picture is turned from the class's frame (radians, from x to y); none for a
    /// texture.
    pub angle: Option<f64>,
    /// Least cost of a candidate without chance, see [`Tried::cost`]; none for a texture, or
    /// before a generation.
    pub cost: Option<f64>,
}

/// A candidate that was run.
#[derive(Clone, Debug, PartialEq)]
pub struct Tried {
    /// Shares of the ranges.
    pub point: Vec<f64>,
    /// Squared distance of the summary statistics over their variance, or masked pixel error (as
    /// it was when a bad candidate was left) and a little for unusual parameters.
    pub cost: f64,
    /// The angle at which it fits best, as [`Refined::angle`].
    pub angle: Option<f64>,
}

/// A search in progress.
pub struct Refiner<'a> {
    identifier: &'a Identifier,
    class: usize,
    start: Refined,
    method: Option<Method<'a>>,
    runs: Runs<'a>,
    history: Vec<Generation>,
}

/// How candidates are compared with the picture.
enum Method<'a> {
    Statistics(Statistics<'a>),
    Pixels(Pixels<'a>),
}

impl<'a> Refiner<'a> {
    /// A search from the answer `found` for the picture `normal`.
    ///
    /// # Errors
    /// Never for an answer of `identifier` on `normal`.
    pub fn new(
        identifier: &'a Identifier,
        normal: &'a Normal,
        found: &Match,
        seed: u64,
    ) -> Result<Self> {
        let class = identifier.class(found);
        let method = match (class.ranges.is_empty(), class.free_seeds) {
            (true, _) => None,
            (_, true) => Statistics::new(identifier, normal, found, seed)?.map(Method::Statistics),
            (_, false) => Some(Method::Pixels(Pixels::new(class, normal, found, seed))),
        };
        let start = Refined {
            point: found.point.clone(),
            deviations: identifier.deviations(found.class),
            angle: found.angle,
            cost: None,
        };
        let runs = Runs { class, known: BTreeMap::new(), tried: Vec::new(), answered: 0 };
        Ok(Self { identifier, class: found.class, start, method, runs, history: Vec::new() })
    }

    /// Runs a generation, candidates side by side; none if there is nothing (more) to search.
    ///
    /// # Errors
    /// What the model meets on its way.
    pub fn step(&mut self, inputs: &(dyn Inputs + Sync)) -> Result<Option<Generation>> {
        let step = match &mut self.method {
            None => None,
            Some(Method::Statistics(method)) => Some(method.step(&mut self.runs, inputs)?),
            Some(Method::Pixels(method)) => method.step(&mut self.runs, inputs)?,
        };
        let Some((costs, sigma)) = step else { return Ok(None) };
        let generation = Generation {
            candidates: [self.runs.tried.len(), self.runs.answered],
            best: self.runs.least(),
            mean: costs.iter().sum::<f64>() / costs.len() as f64,
            sigma,
        };
        self.history.push(generation);
        Ok(Some(generation))
    }

    /// The generations so far.
    pub fn history(&self) -> &[Generation] {
        &self.history
    }

    /// The candidates that were run.
    pub fn tried(&self) -> &[Tried] {
        &self.runs.tried
    }

    /// The best so far: for a class with a free seed the middle of the search, as costs hold
    /// the chance of a run, with the calibration's error; otherwise the candidate of least error,
    /// with the width of the search.
    pub fn finish(&self) -> Refined {
        let start = self.start.clone();
        match (&self.method, self.runs.best()) {
            (Some(Method::Statistics(method)), _) => {
                let deviations = self.identifier.deviations(self.class);
                Refined { point: method.point(), deviations, ..start }
            }
            (Some(Method::Pixels(method)), Some(best)) => Refined {
                point: best.point.clone(),
                deviations: method.deviations().unwrap_or(start.deviations),
                angle: best.angle,
                cost: Some(best.cost),
            },
            _ => start,
        }
    }
}

/// Candidates that were run, each once.
struct Runs<'a> {
    class: &'a Class,
    /// Costs by configuration.
    known: BTreeMap<String, f64>,
    tried: Vec<Tried>,
    answered: usize,
}

/// Cost of a candidate, and the angle at which it fits.
type Cost = (f64, Option<f64>);

impl Runs<'_> {
    /// Costs of `points`, those that are new run side by side.
    fn run(
        &mut self,
        points: &[Vec<f64>],
        cost: &(dyn Fn(&[f64]) -> Result<Cost> + Sync),
    ) -> Result<Vec<f64>> {
        let keys: Vec<String> = points
            .iter()
            .map(|point| Ok(self.class.configure(point)?.to_string()))
            .collect::<Result<_>>()?;
        let mut fresh: Vec<usize> = Vec::new();
        for (n, key) in keys.iter().enumerate() {
            if self.known.contains_key(key) || fresh.iter().any(|&m| keys[m] == *key) {
                self.answered += 1;
            } else {
                fresh.push(n);
            }
        }
        let found: Vec<Cost> =
            fresh.par_iter().with_max_len(1).map(|&n| cost(&points[n])).collect::<Result<_>>()?;
        for (&n, &(cost, angle)) in fresh.iter().zip(&found) {
            self.known.insert(keys[n].clone(), cost);
            self.tried.push(Tried { point: points[n].clone(), cost, angle });
        }
        Ok(keys.iter().map(|key| self.known[key]).collect())
    }

    /// A generation of `search`: the costs of its points, clamped to the ranges.
    fn generation(
        &mut self,
        search: &mut Cmaes,
        cost: &(dyn Fn(&[f64]) -> Result<Cost> + Sync),
    ) -> Result<Vec<f64>> {
        let asked = search.ask();
        let inside: Vec<Vec<f64>> =
            asked.iter().map(|p| p.iter().map(|v| v.clamp(0.0, 1.0)).collect()).collect();
        let costs = self.run(&inside, cost)?;
        let beyond = |n: usize| {
            asked[n].iter().zip(&inside[n]).map(|(a, b)| (a - b).powi(2)).sum::<f64>() * OUTSIDE
        };
        let told: Vec<f64> = (0..costs.len()).map(|n| costs[n] + beyond(n)).collect();
        search.tell(&told)?;
        Ok(costs)
    }

    /// The candidate of least cost so far.
    fn best(&self) -> Option<&Tried> {
        self.tried.iter().min_by(|a, b| a.cost.total_cmp(&b.cost))
    }

    /// Its cost.
    fn least(&self) -> f64 {
        self.best().map_or(f64::INFINITY, |best| best.cost)
    }
}
