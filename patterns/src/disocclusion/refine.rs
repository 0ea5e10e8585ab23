//! The parameters of the class that was found, closer than its calibration tells.
//!
//! CMA-ES on the shares of the class's ranges. Classes with a free seed are run and compared by
//! summary statistics: the regression of the parameters on the descriptor, which Fearnhead &
//! Prangle 2012, "Constructing summary statistics for approximate Bayesian computation", show
//! to be the best ones for the parameters' mean. Classes without chance are compared pixel by pixel,
//! from the best of points all over the ranges: what is hidden may hold what a parameter moves,
//! and features tell nothing of it then.

use super::{
    Identifier, Match, Normal, Values, candidate::watch, place::Placement,
    scores::mean_squared_error, simulate,
};
use crate::{Inputs, Result};
use rayon::prelude::*;
use solvers::{optimize::Cmaes, texture::Descriptor, texture::Masked};
use std::{collections::BTreeMap, f64::consts::FRAC_PI_2};

/// Width of the first generation, share of a range: the calibration's usual error.
const WIDTH: f64 = 0.15;

/// Points all over the ranges that a search without chance looks at, and those of them that are
/// run to their end, beside the entry's own configuration.
const SPREAD: (u64, usize) = (24, 6);

/// Candidates of a generation without chance.
const POINTS: usize = 10;

/// Least deviation of a whole number, in its steps.
const WHOLE: f64 = 0.4;

/// Width (shares of a range) at which a search without chance ends.
const SETTLED: f64 = 0.012;

/// Cost at which a search without chance ends: the published problem, or next to it.
const SAME: f64 = 2e-4;

/// Pixel error that is added at a distance of one range from the entry's own configuration: of
/// problems that show the same where it is visible, the published one is the likeliest. At most a
/// few elements' pixels.
const UNUSUAL: f64 = 0.004;

/// Angles around the best one so far that each candidate without chance is compared at: their
/// step (degrees) and number to each side. The first one was measured on a worse candidate.
const TURN: (f64, i32) = (0.5, 3);

/// Largest angle (degrees) to an upright picture, or one on its side, for which that is tried.
const UPRIGHT: f64 = 5.0;

/// By how much a run's pixel error falls after a third and after two thirds of it, at most: a
/// candidate that is worse than the best by more is left there.
const FALLS: [f64; 2] = [0.06, 0.03];

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
    normal: &'a Normal,
    placement: Placement,
    /// Summary statistics of the picture and their deviations, for a class with a free seed.
    target: Option<(Vec<f64>, Vec<f64>)>,
    search: Option<Cmaes>,
    /// Whether a search without chance has looked all over the ranges.
    spread: bool,
    start: Vec<f64>,
    /// The entry's own configuration.
    usual: Vec<f64>,
    seed: u64,
    /// Costs by configuration.
    known: BTreeMap<String, f64>,
    tried: Vec<Tried>,
    answered: usize,
    history: Vec<Generation>,
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
        let descriptor = Descriptor::new(&normal.masked()?);
        let target = match (class.free_seeds, descriptor) {
            (true, Some(d)) => {
                let summary = identifier.summary(found.class, &d, found.inverted);
                let deviations = identifier.deviations(found.class);
                Some((summary, deviations))
            }
            _ => None,
        };
        let search = match class.ranges.is_empty() || (class.free_seeds && target.is_none()) {
            true => None,
            false => Some(Cmaes::new(&found.point, WIDTH, seed)?),
        };
        Ok(Self {
            identifier,
            class: found.class,
            normal,
            placement: Placement::of(found),
            target,
            search,
            spread: false,
            start: found.point.clone(),
            usual: class.usual(),
            seed,
            known: BTreeMap::new(),
            tried: Vec::new(),
            answered: 0,
            history: Vec::new(),
        })
    }

    /// Runs a generation, candidates side by side; none if there is nothing (more) to search.
    ///
    /// # Errors
    /// What the model meets on its way.
    pub fn step(&mut self, inputs: &(dyn Inputs + Sync)) -> Result<Option<Generation>> {
        let fixed = self.target.is_none();
        if self.search.is_some() && fixed && !self.spread {
            self.spread = true;
            return self.look_around(inputs).map(Some);
        }
        let Some(mut search) = self.search.take() else { return Ok(None) };
        let settled = search.deviations().iter().all(|d| *d < SETTLED);
        if fixed && (settled || self.best() < SAME) {
            self.search = Some(search);
            return Ok(None);
        }
        let asked = search.ask();
        let inside: Vec<Vec<f64>> =
            asked.iter().map(|p| p.iter().map(|v| v.clamp(0.0, 1.0)).collect()).collect();
        let before = self.best();
        let costs = self.run(&inside, inputs)?;
        let beyond = |n: usize| {
            asked[n].iter().zip(&inside[n]).map(|(a, b)| (a - b).powi(2)).sum::<f64>() * OUTSIDE
        };
        let told: Vec<f64> = (0..costs.len()).map(|n| costs[n] + beyond(n)).collect();
        search.tell(&told)?;
        let mut sigma = search.sigma();
        if fixed && self.best() >= before {
            // The next whole numbers, which a search may be too narrow for.
            let best = self.first();
            let near = self.neighbours(&best);
            self.run(&near, inputs)?;
            if self.best() < before {
                sigma = 0.5 * WIDTH;
                search = self.search_from(&self.first(), sigma)?;
            }
        }
        self.search = Some(search);
        Ok(Some(self.report(&costs, sigma)))
    }

    /// The points one whole number away.
    fn neighbours(&self, point: &[f64]) -> Vec<Vec<f64>> {
        let steps = self.whole_steps();
        let axes = steps.iter().enumerate().filter_map(|(n, s)| s.map(|s| (n, s)));
        let moved = axes.flat_map(|(n, step)| {
            [-step, step].map(|by| {
                let mut near = point.to_vec();
                near[n] += by;
                near
            })
        });
        moved.filter(|p| p.iter().all(|v| (0.0..=1.0).contains(v))).collect()
    }

    /// Shares of the ranges of whole numbers that one of them takes.
    fn whole_steps(&self) -> Vec<Option<f64>> {
        let class = &self.identifier.database().classes[self.class];
        let step = |values: &Values| match values {
            Values::Between { low, high, integer: true, .. } => Some(1.0 / (high - low)),
            _ => None,
        };
        class.ranges.iter().map(|range| step(&range.values)).collect()
    }

    /// A search without chance.
    fn search_from(&self, point: &[f64], width: f64) -> Result<Cmaes> {
        let least: Vec<f64> =
            self.whole_steps().iter().map(|step| WHOLE * step.unwrap_or(0.0)).collect();
        let seed = self.seed + self.history.len() as u64;
        Ok(Cmaes::new(point, width, seed)?.with_points(POINTS).with_least_deviations(&least)?)
    }

    /// The first generation without chance: points all over the ranges, each for a third of its
    /// run, the best of them to their end; the search starts from the best.
    fn look_around(&mut self, inputs: &(dyn Inputs + Sync)) -> Result<Generation> {
        let class = &self.identifier.database().classes[self.class];
        let mut points: Vec<Vec<f64>> = (0..SPREAD.0).map(|n| class.point(self.seed, n)).collect();
        points.push(self.start.clone());
        let glances: Vec<f64> = points
            .par_iter()
            .with_max_len(1)
            .map(|point| Ok(self.cost(point, f64::NEG_INFINITY, inputs)?.0))
            .collect::<Result<_>>()?;
        let mut order: Vec<usize> = (0..points.len()).collect();
        order.sort_by(|&a, &b| glances[a].total_cmp(&glances[b]));
        let best = order[..SPREAD.1].iter().map(|&n| points[n].clone());
        let best: Vec<Vec<f64>> = best.chain([self.usual.clone()]).collect();
        let costs = self.run(&best, inputs)?;
        self.search = Some(self.search_from(&self.first(), WIDTH)?);
        Ok(self.report(&costs, WIDTH))
    }

    /// Costs of candidates, each run once.
    fn run(&mut self, points: &[Vec<f64>], inputs: &(dyn Inputs + Sync)) -> Result<Vec<f64>> {
        let class = &self.identifier.database().classes[self.class];
        let keys: Vec<String> = points
            .iter()
            .map(|point| Ok(class.configure(point)?.to_string()))
            .collect::<Result<_>>()?;
        let mut fresh: Vec<usize> = Vec::new();
        for (n, key) in keys.iter().enumerate() {
            if self.known.contains_key(key) || fresh.iter().any(|&m| keys[m] == *key) {
                self.answered += 1;
            } else {
                fresh.push(n);
            }
        }
        let limit = self.best();
        let found: Vec<(f64, Option<f64>)> = fresh
            .par_iter()
            .with_max_len(1)
            .map(|&n| self.cost(&points[n], limit, inputs))
            .collect::<Result<_>>()?;
        for (&n, &(cost, angle)) in fresh.iter().zip(&found) {
            self.known.insert(keys[n].clone(), cost);
            self.tried.push(Tried { point: points[n].clone(), cost, angle });
        }
        if let Some(best) = self.tried.iter().min_by(|a, b| a.cost.total_cmp(&b.cost)) {
            self.placement.angle = best.angle;
        }
        Ok(keys.iter().map(|key| self.known[key]).collect())
    }

    /// The least cost so far.
    fn best(&self) -> f64 {
        self.tried.iter().fold(f64::INFINITY, |a, t| a.min(t.cost))
    }

    /// The point of least cost so far, else the start.
    fn first(&self) -> Vec<f64> {
        let best = self.tried.iter().min_by(|a, b| a.cost.total_cmp(&b.cost));
        best.map_or_else(|| self.start.clone(), |b| b.point.clone())
    }

    /// The angles at which a candidate without chance is compared.
    fn angles(&self) -> Vec<f64> {
        let now = self.placement.angle.unwrap_or(0.0);
        // Without the sign of a rounded -0.
        let upright = (now / FRAC_PI_2).round() * FRAC_PI_2 + 0.0;
        let straight = ((now - upright).abs() <= UPRIGHT.to_radians()).then_some(upright);
        let around = (-TURN.1..=TURN.1).map(|n| now + (f64::from(n) * TURN.0).to_radians());
        straight.into_iter().chain(around).collect()
    }

    fn report(&mut self, costs: &[f64], sigma: f64) -> Generation {
        let generation = Generation {
            candidates: [self.tried.len(), self.answered],
            best: self.best(),
            mean: costs.iter().sum::<f64>() / costs.len() as f64,
            sigma,
        };
        self.history.push(generation);
        generation
    }

    /// Cost of the class at `point`, and the angle at which it fits; where it will be worse than
    /// `limit` the cost at which the run was left.
    fn cost(&self, point: &[f64], limit: f64, inputs: &dyn Inputs) -> Result<(f64, Option<f64>)> {
        let class = &self.identifier.database().classes[self.class];
        let Some((wanted, deviations)) = &self.target else {
            let unusual: f64 =
                point.iter().zip(&self.usual).map(|(v, usual)| (v - usual).powi(2)).sum();
            let mut falls = FALLS.iter();
            let angles = self.angles();
            let (mut error, mut angle) = (f64::INFINITY, self.placement.angle);
            let looks = FALLS.len() as u64 + 1;
            watch(class, point, self.seed, looks, inputs, &mut |_, pattern| {
                error = f64::INFINITY;
                for &turned in &angles {
                    let placement = Placement { angle: Some(turned), ..self.placement };
                    let placed = placement.place(&pattern, self.normal.shape);
                    let here = mean_squared_error(self.normal, &placed) + UNUSUAL * unusual;
                    if here < error {
                        (error, angle) = (here, Some(turned));
                    }
                }
                falls.next().is_none_or(|fall| error - fall <= limit)
            })?;
            return Ok((error, angle));
        };
        let pattern = simulate(class, point, self.seed, inputs)?;
        let all = vec![true; pattern.ink.len()];
        let masked = Masked::new(pattern.shape, &pattern.ink, &all)?;
        let Some(descriptor) = Descriptor::new(&masked) else { return Ok((OUTSIDE, None)) };
        let summary = self.identifier.summary(self.class, &descriptor, false);
        let terms = summary.iter().zip(wanted).zip(deviations);
        Ok((terms.map(|((a, b), s)| ((a - b) / s).powi(2)).sum(), None))
    }

    /// The generations so far.
    pub fn history(&self) -> &[Generation] {
        &self.history
    }

    /// The candidates that were run.
    pub fn tried(&self) -> &[Tried] {
        &self.tried
    }

    /// The best so far: for a class with a free seed the middle of the search, as costs hold
    /// the chance of a run, with the calibration's error; otherwise the candidate of least error,
    /// with the width of the search.
    pub fn finish(&self) -> Refined {
        let angle = self.placement.angle;
        let Some(search) = &self.search else {
            let deviations = self.identifier.deviations(self.class);
            return Refined { point: self.start.clone(), deviations, angle, cost: None };
        };
        if let Some((_, deviations)) = &self.target {
            let point = search.mean().iter().map(|v| v.clamp(0.0, 1.0)).collect();
            return Refined { point, deviations: deviations.clone(), angle, cost: None };
        }
        let cost = (!self.tried.is_empty()).then(|| self.best());
        Refined { point: self.first(), deviations: search.deviations(), angle, cost }
    }
}
