//! Candidates compared pixel by pixel, from the best of points all over the ranges: what is
//! hidden may hold what a parameter moves, and the ranking tells nothing of it then.

use super::super::candidate::watch;
use super::super::place::Placement;
use super::super::{Class, Match, Normal, Values, scores::mean_squared_error};
use super::{Cost, Runs, WIDTH};
use crate::{Inputs, Result};
use rayon::prelude::*;
use solvers::optimize::Cmaes;
use std::f64::consts::FRAC_PI_2;

/// Points all over the ranges that are looked at, and those of them that are run to their end,
/// beside the entry's own configuration.
const SPREAD: (u64, usize) = (24, 6);

/// Candidates of a generation.
const POINTS: usize = 10;

/// Least deviation of a whole number, in its steps.
const WHOLE: f64 = 0.4;

/// Width (shares of a range) at which the search ends.
const SETTLED: f64 = 0.012;

/// Cost at which the search ends: the published problem, or next to it.
const SAME: f64 = 2e-4;

/// Pixel error that is added at a distance of one range from the entry's own configuration: of
/// problems that show the same where it is visible, the published one is the likeliest. At most a
/// few elements' pixels.
const UNUSUAL: f64 = 0.004;

/// Angles around the best one so far at which each candidate is compared: their step (degrees)
/// and number to each side. The first one was measured on a worse candidate.
const TURN: (f64, i32) = (0.5, 3);

/// Largest angle (degrees) to an upright picture, or one on its side, for which that is tried.
const UPRIGHT: f64 = 5.0;

/// By how much a run's pixel error falls after a third and after two thirds of it, at most: a
/// candidate that is worse than the best by more is left there.
const FALLS: [f64; 2] = [0.06, 0.03];

/// A search for a class without chance.
pub(super) struct Pixels<'a> {
    class: &'a Class,
    normal: &'a Normal,
    placement: Placement,
    start: Vec<f64>,
    /// The entry's own configuration.
    usual: Vec<f64>,
    seed: u64,
    generation: u64,
    /// None before points all over the ranges were looked at.
    search: Option<Cmaes>,
}

impl<'a> Pixels<'a> {
    pub(super) fn new(class: &'a Class, normal: &'a Normal, found: &Match, seed: u64) -> Self {
        Self {
            class,
            normal,
            placement: Placement::of(found),
            start: found.point.clone(),
            usual: class.usual(),
            seed,
            generation: 0,
            search: None,
        }
    }

    /// Width of the search along each coordinate, once it has begun.
    pub(super) fn deviations(&self) -> Option<Vec<f64>> {
        self.search.as_ref().map(Cmaes::deviations)
    }

    /// A generation: its costs and the width of the search; none if it has ended.
    pub(super) fn step(
        &mut self,
        runs: &mut Runs<'_>,
        inputs: &(dyn Inputs + Sync),
    ) -> Result<Option<(Vec<f64>, f64)>> {
        let before = runs.least();
        let (costs, mut search) = match self.search.take() {
            None => self.look_around(runs, inputs)?,
            Some(search) if self.ended(&search, before) => {
                self.search = Some(search);
                return Ok(None);
            }
            Some(mut search) => {
                let cost = |point: &[f64]| self.cost(point, before, inputs);
                let costs = runs.generation(&mut search, &cost)?;
                (costs, search)
            }
        };
        if runs.least() >= before {
            // The next whole numbers, which a search may be too narrow for.
            let near = runs.best().map(|best| self.neighbours(&best.point)).unwrap_or_default();
            runs.run(&near, &|point| self.cost(point, before, inputs))?;
            if let Some(best) = runs.best().filter(|best| best.cost < before) {
                search = self.search_from(&best.point, 0.5 * WIDTH)?;
            }
        }
        self.generation += 1;
        self.placement.angle = runs.best().and_then(|best| best.angle);
        let sigma = search.sigma();
        self.search = Some(search);
        Ok(Some((costs, sigma)))
    }

    fn ended(&self, search: &Cmaes, least: f64) -> bool {
        let settled = search.deviations().iter().all(|d| *d < SETTLED);
        settled || least < SAME
    }

    /// The first generation: points all over the ranges, each for a third of its run, the best of
    /// them and the entry's own to their end; a search from the best.
    fn look_around(
        &self,
        runs: &mut Runs<'_>,
        inputs: &(dyn Inputs + Sync),
    ) -> Result<(Vec<f64>, Cmaes)> {
        let mut points: Vec<Vec<f64>> =
            (0..SPREAD.0).map(|n| self.class.point(self.seed, n)).collect();
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
        let costs = runs.run(&best, &|point| self.cost(point, f64::INFINITY, inputs))?;
        let first = runs.best().map_or(&self.start, |best| &best.point);
        Ok((costs, self.search_from(first, WIDTH)?))
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
        let step = |values: &Values| match values {
            Values::Between { low, high, integer: true, .. } => Some(1.0 / (high - low)),
            _ => None,
        };
        self.class.ranges.iter().map(|range| step(&range.values)).collect()
    }

    fn search_from(&self, point: &[f64], width: f64) -> Result<Cmaes> {
        let least: Vec<f64> =
            self.whole_steps().iter().map(|step| WHOLE * step.unwrap_or(0.0)).collect();
        let seed = self.seed.wrapping_add(self.generation);
        Ok(Cmaes::new(point, width, seed)?.with_points(POINTS).with_least_deviations(&least)?)
    }

    /// The angles at which a candidate is compared.
    fn angles(&self) -> Vec<f64> {
        let now = self.placement.angle.unwrap_or(0.0);
        // Without the sign of a rounded -0.
        let upright = (now / FRAC_PI_2).round() * FRAC_PI_2 + 0.0;
        let straight = ((now - upright).abs() <= UPRIGHT.to_radians()).then_some(upright);
        let around = (-TURN.1..=TURN.1).map(|n| now + (f64::from(n) * TURN.0).to_radians());
        straight.into_iter().chain(around).collect()
    }

    /// Cost of the class at `point`, and the angle at which it fits; where it will be worse than
    /// `limit` the cost at which the run was left.
    fn cost(&self, point: &[f64], limit: f64, inputs: &dyn Inputs) -> Result<Cost> {
        let distance: f64 = point.iter().zip(&self.usual).map(|(v, u)| (v - u).powi(2)).sum();
        let (angles, unusual) = (self.angles(), UNUSUAL * distance);
        let mut falls = FALLS.iter();
        let mut best = (f64::INFINITY, self.placement.angle);
        let looks = FALLS.len() as u64 + 1;
        watch(self.class, point, self.seed, looks, inputs, &mut |_, pattern| {
            best.0 = f64::INFINITY;
            for &turned in &angles {
                let placement = Placement { angle: Some(turned), ..self.placement };
                let placed = placement.place(&pattern, self.normal.shape);
                let here = mean_squared_error(self.normal, &placed) + unusual;
                if here < best.0 {
                    best = (here, Some(turned));
                }
            }
            falls.next().is_none_or(|fall| best.0 - fall <= limit)
        })?;
        Ok(best)
    }
}
