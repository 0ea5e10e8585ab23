//! The search for parameters whose shapes have the wanted diagram.

#[cfg(test)]
mod tests;

use super::config::Config;
use crate::curvature::atlas::coefficients;
use crate::curvature::grow::{Grown, Shape};
use crate::{Error, Result};
use rayon::prelude::*;
use solvers::optimize::Cmaes;
use solvers::random::{stream, uniform};
use solvers::transport::{CoarseSinkhorn, PreparedCloud};

/// Distance of parameters that grow no viable shape, as part of the transport's reach: farther
/// than any shape.
const REFUSED: f64 = 2.0;

/// The candidates around which the search looks at last: as near as this times the least distance,
/// and at least as many as this.
const NEAR: (f64, usize) = (2.0, 16);

/// Shapes that are grown together: starts, candidates of a generation, or draws of an atlas.
pub(super) const TOGETHER: usize = 8;

/// What candidates are compared with.
#[derive(Clone, Copy)]
pub(super) struct Target<'a> {
    pub(super) config: &'a Config,
    pub(super) wanted: &'a PreparedCloud<2>,
    pub(super) transport: &'a CoarseSinkhorn,
    /// Of the noise that all candidates start from, so that they differ by their parameters alone.
    pub(super) seed: u64,
}

/// A shape that grew: its parameters and its distance from the given one.
#[derive(Clone, Copy)]
pub(super) struct Candidate {
    /// 0 for the shapes of the atlas.
    pub(super) generation: usize,
    pub(super) parameters: [f64; 6],
    pub(super) distance: f64,
}

/// First the nearest shapes of the atlas, with the mass of the given one; then CMA-ES around the
/// best of them, by turns, over a11, a02, b10, b01, c, each as a part of its range, which is kept
/// by reflection at its ends; after half of the generations around the best start only. The last
/// quarter looks around: how far do parameters reach that grow shapes as near?
pub(super) struct Search {
    starts: Vec<[f64; 6]>,
    mass: f64,
    lanes: Vec<Lane>,
    /// Values of the starts, then of each generation.
    pub(super) told: Vec<Vec<f64>>,
    pub(super) candidates: Vec<Candidate>,
}

/// Where a generation comes from.
enum Turn {
    Lane(usize),
    Around,
}

/// The search around one start.
struct Lane {
    cmaes: Cmaes,
    /// Distance of the start.
    start: f64,
}

impl Lane {
    fn best(&self) -> f64 {
        self.cmaes.best().map_or(self.start, |(_, value)| value.min(self.start))
    }
}

impl Search {
    /// Of the neighbourhoods of `nearest`, as far as they are in the ranges.
    pub(super) fn new(config: &Config, nearest: &[[f64; 6]], mass: f64) -> Self {
        let starts = nearest.iter().map(|shape| {
            let point: Vec<f64> = part(config, shape);
            parameters(config, &point, mass)
        });
        let starts = starts.collect();
        Self { starts, mass, lanes: Vec::new(), told: Vec::new(), candidates: Vec::new() }
    }

    /// Generations so far, without the starts.
    pub(super) fn generations(&self) -> usize {
        self.told.len().saturating_sub(1)
    }

    /// Grows and compares the starts, or a generation.
    ///
    /// # Errors
    /// If coefficients are refused.
    pub(super) fn advance(&mut self, target: Target<'_>) -> Result<()> {
        let points = self.ask(target.config, target.seed);
        let evaluate = |&parameters: &[f64; 6]| {
            let shape = grow(target.config, parameters, target.seed)?;
            distance(shape.as_deref(), target)
        };
        let mut values = Vec::with_capacity(points.len());
        for points in points.chunks(TOGETHER) {
            let some: Result<Vec<f64>> = points.par_iter().map(evaluate).collect();
            values.extend(some?);
        }
        self.tell(target.config, target.seed, &points, values)
    }

    /// Goes through a generation again whose values are known.
    ///
    /// # Errors
    /// If their number is another.
    pub(super) fn repeat(&mut self, config: &Config, seed: u64, values: Vec<f64>) -> Result<()> {
        let points = self.ask(config, seed);
        self.tell(config, seed, &points, values)
    }

    fn ask(&mut self, config: &Config, seed: u64) -> Vec<[f64; 6]> {
        if self.told.is_empty() {
            return self.starts.clone();
        }
        let points = match self.turn(config) {
            Turn::Lane(lane) => self.lanes[lane].cmaes.ask(),
            Turn::Around => self.around(config, seed),
        };
        points.iter().map(|point| parameters(config, point, self.mass)).collect()
    }

    /// Points as far from a near candidate as two others are from each other, which goes on along
    /// what the diagrams do not tell: the proposals of ter Braak 2006, "A Markov chain Monte Carlo
    /// version of the genetic algorithm differential evolution", with a factor of 1.
    fn around(&self, config: &Config, seed: u64) -> Vec<Vec<f64>> {
        let mut near: Vec<&Candidate> = self.candidates.iter().collect();
        near.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        let least = near.first().map_or(0.0, |best| best.distance);
        let count = near.partition_point(|c| c.distance <= NEAR.0 * least).max(NEAR.1);
        near.truncate(count);
        let near: Vec<Vec<f64>> = near.iter().map(|c| part(config, &c.parameters)).collect();
        let mut random = stream(seed, "curvature inference", self.told.len() as u64);
        let mut below = |n: usize| (uniform(&mut random) * n as f64) as usize;
        (0..TOGETHER)
            .map(|_| {
                let from = below(near.len());
                // Two others of a turned list: neither the first nor each other.
                let other = |step: usize| &near[(from + step) % near.len()];
                let one = 1 + below(near.len() - 1);
                let two = 1 + (one + below(near.len() - 2)) % (near.len() - 1);
                let pairs = other(one).iter().zip(other(two));
                near[from].iter().zip(pairs).map(|(x, (a, b))| x + (a - b)).collect()
            })
            .collect()
    }

    fn tell(
        &mut self,
        config: &Config,
        seed: u64,
        points: &[[f64; 6]],
        values: Vec<f64>,
    ) -> Result<()> {
        if points.len() != values.len() {
            let (is, wanted) = (values.len(), points.len());
            return Err(Error::Checkpoint(format!("a generation has {is} values, not {wanted}")));
        }
        if self.told.is_empty() {
            self.open_lanes(config, seed, &values)?;
        } else if let Turn::Lane(lane) = self.turn(config) {
            self.lanes[lane].cmaes.tell(&values)?;
        }
        let generation = self.told.len();
        let new = points.iter().zip(&values);
        let new = new.filter(|(_, distance)| **distance < REFUSED * config.distance.reach);
        self.candidates.extend(new.map(|(&parameters, &distance)| Candidate {
            generation,
            parameters,
            distance,
        }));
        self.told.push(values);
        Ok(())
    }

    /// Lanes around the best starts.
    fn open_lanes(&mut self, config: &Config, seed: u64, values: &[f64]) -> Result<()> {
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
        // Each has its turn.
        let count = config.starts.min(config.generations.div_ceil(2).max(1) as usize);
        for (number, &n) in order.iter().take(count).enumerate() {
            let start = part(config, &self.starts[n]);
            let cmaes = Cmaes::new(&start, config.width, seed.wrapping_add(number as u64))?;
            self.lanes.push(Lane { cmaes, start: values[n] });
        }
        Ok(())
    }

    /// Where the next generation comes from.
    fn turn(&self, config: &Config) -> Turn {
        let (n, all) = (self.generations(), config.generations as usize);
        if 2 * n < all {
            return Turn::Lane(n % self.lanes.len());
        }
        if 4 * n >= 3 * all && self.candidates.len() > 2 {
            return Turn::Around;
        }
        let best = |a: &usize, b: &usize| self.lanes[*a].best().total_cmp(&self.lanes[*b].best());
        Turn::Lane((0..self.lanes.len()).min_by(best).unwrap_or(0))
    }

    /// Least distance of each generation, NaN where nothing grew.
    pub(super) fn least(&self) -> Vec<f64> {
        let mut least = vec![f64::NAN; self.told.len()];
        for candidate in &self.candidates {
            let least = &mut least[candidate.generation];
            *least = least.min(candidate.distance);
        }
        least
    }

    /// The nearest candidate so far.
    pub(super) fn best(&self) -> Option<&Candidate> {
        self.candidates.iter().min_by(|a, b| a.distance.total_cmp(&b.distance))
    }

    /// Candidates within a distance of the given shape.
    pub(super) fn within(&self, distance: f64) -> impl Iterator<Item = &Candidate> {
        self.candidates.iter().filter(move |c| c.distance <= distance)
    }

    /// Their least and greatest parameters.
    pub(super) fn ranges(&self, distance: f64) -> [[f64; 2]; 5] {
        std::array::from_fn(|k| {
            let near = self.within(distance);
            near.map(|c| c.parameters[k])
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
                    [low.min(v), high.max(v)]
                })
        })
    }
}

/// The parameters of a point.
fn parameters(config: &Config, point: &[f64], mass: f64) -> [f64; 6] {
    let ranges = config.ranges.list();
    std::array::from_fn(|k| match point.get(k) {
        Some(&part) => {
            let [low, high] = ranges[k];
            // Reflected into [0, 1] as often as it takes.
            let t = part.rem_euclid(2.0);
            low + if t > 1.0 { 2.0 - t } else { t } * (high - low)
        }
        None => mass,
    })
}

/// The point of some parameters; the nearest in the ranges, for an atlas may have been drawn from
/// wider ones.
fn part(config: &Config, parameters: &[f64; 6]) -> Vec<f64> {
    let part = |(&value, [low, high]): (&f64, [f64; 2])| match high > low {
        true => ((value - low) / (high - low)).clamp(0.0, 1.0),
        false => 0.5,
    };
    parameters.iter().zip(config.ranges.list()).take(5).map(part).collect()
}

/// The shape of some parameters, if it is viable.
///
/// # Errors
/// If coefficients are refused.
pub(super) fn grow(config: &Config, parameters: [f64; 6], seed: u64) -> Result<Option<Box<Shape>>> {
    let (polynomial, mass) = coefficients(parameters);
    Ok(match config.growth.grow(polynomial, mass, seed)? {
        Grown::Shape(shape) => Some(shape),
        Grown::Diffuse | Grown::Empty | Grown::Broken => None,
    })
}

/// Distance of a shape's diagram from the wanted one (1/length).
///
/// # Errors
/// None for diagrams of finite curvatures.
pub(super) fn distance(shape: Option<&Shape>, target: Target<'_>) -> Result<f64> {
    let Some(shape) = shape else { return Ok(REFUSED * target.config.distance.reach) };
    let own = target.transport.prepare(&shape.diagram)?;
    Ok(target.transport.divergence(target.wanted, &own).abs().sqrt())
}
