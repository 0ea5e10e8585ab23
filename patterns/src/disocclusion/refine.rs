//! The parameters of the class that was found, closer than its calibration tells.
//!
//! CMA-ES on the shares of the class's ranges. Classes with a free seed are run and compared by
//! summary statistics: the regression of the parameters on the descriptor, which Fearnhead &
//! Prangle 2012, "Constructing summary statistics for approximate Bayesian computation", show
//! to be the best ones for the parameters' mean. Classes without chance are compared pixel by pixel.

use super::{
    Class, Identifier, Match, Normal, place::Placement, scores::mean_squared_error, simulate,
};
use crate::{Inputs, Result};
use rayon::prelude::*;
use solvers::{optimize::Cmaes, texture::Descriptor, texture::Masked};
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
}

/// A candidate that was run.
#[derive(Clone, Debug, PartialEq)]
pub struct Tried {
    /// Shares of the ranges.
    pub point: Vec<f64>,
    /// Squared distance of the summary statistics over their variance, or masked pixel error.
    pub cost: f64,
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
    start: Vec<f64>,
    seed: u64,
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
            start: found.point.clone(),
            seed,
            known: BTreeMap::new(),
            tried: Vec::new(),
            answered: 0,
            history: Vec::new(),
        })
    }

    /// Runs a generation, candidates side by side; none if there is nothing to search.
    ///
    /// # Errors
    /// What the model meets on its way.
    pub fn step(&mut self, inputs: &(dyn Inputs + Sync)) -> Result<Option<Generation>> {
        let Some(mut search) = self.search.take() else { return Ok(None) };
        let asked = search.ask();
        let inside: Vec<Vec<f64>> =
            asked.iter().map(|p| p.iter().map(|v| v.clamp(0.0, 1.0)).collect()).collect();
        let class = &self.identifier.database().classes[self.class];
        let keys: Vec<String> = inside
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
        let found: Vec<f64> = fresh
            .par_iter()
            .with_max_len(1)
            .map(|&n| self.cost(class, &inside[n], inputs))
            .collect::<Result<_>>()?;
        for (&n, &cost) in fresh.iter().zip(&found) {
            self.known.insert(keys[n].clone(), cost);
            self.tried.push(Tried { point: inside[n].clone(), cost });
        }
        let costs: Vec<f64> = keys.iter().map(|key| self.known[key]).collect();
        let beyond = |n: usize| {
            asked[n].iter().zip(&inside[n]).map(|(a, b)| (a - b).powi(2)).sum::<f64>() * OUTSIDE
        };
        let told: Vec<f64> = (0..costs.len()).map(|n| costs[n] + beyond(n)).collect();
        search.tell(&told)?;
        let best = self.tried.iter().fold(f64::INFINITY, |a, t| a.min(t.cost));
        let generation = Generation {
            candidates: [self.tried.len(), self.answered],
            best,
            mean: costs.iter().sum::<f64>() / costs.len() as f64,
            sigma: search.sigma(),
        };
        self.history.push(generation);
        self.search = Some(search);
        Ok(Some(generation))
    }

    /// Cost of the class at `point`.
    fn cost(&self, class: &Class, point: &[f64], inputs: &dyn Inputs) -> Result<f64> {
        let pattern = simulate(class, point, self.seed, inputs)?;
        let Some((wanted, deviations)) = &self.target else {
            let placed = self.placement.place(&pattern, self.normal.shape);
            return Ok(mean_squared_error(self.normal, &placed));
        };
        let all = vec![true; pattern.ink.len()];
        let masked = Masked::new(pattern.shape, &pattern.ink, &all)?;
        let Some(descriptor) = Descriptor::new(&masked) else { return Ok(OUTSIDE) };
        let summary = self.identifier.summary(self.class, &descriptor, false);
        let terms = summary.iter().zip(wanted).zip(deviations);
        Ok(terms.map(|((a, b), s)| ((a - b) / s).powi(2)).sum())
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
        let Some(search) = &self.search else {
            let deviations = self.identifier.deviations(self.class);
            return Refined { point: self.start.clone(), deviations };
        };
        if let Some((_, deviations)) = &self.target {
            let point = search.mean().iter().map(|v| v.clamp(0.0, 1.0)).collect();
            return Refined { point, deviations: deviations.clone() };
        }
        let best = self.tried.iter().min_by(|a, b| a.cost.total_cmp(&b.cost));
        let point = best.map_or_else(|| self.start.clone(), |b| b.point.clone());
        Refined { point, deviations: search.deviations() }
    }
}
