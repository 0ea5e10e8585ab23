//! The search for parameters whose shapes have the wanted diagram.

use super::config::Config;
use crate::Result;
use crate::curvature::atlas::coefficients;
use crate::curvature::grow::{Grown, Shape};
use rayon::prelude::*;
use solvers::optimize::Cmaes;
use solvers::transport::{CoarseSinkhorn, PreparedCloud};

/// Distance of parameters that grow no viable shape, as part of the transport's reach: farther
/// than any shape.
const REFUSED: f64 = 2.0;

/// Generations whose better half tells how far the parameters are known.
const LAST: usize = 3;

/// CMA-ES over a11, a02, b10, b01, c, each as a part of its range; the ranges are kept by
/// reflection at their ends.
pub(super) struct Search {
    cmaes: Cmaes,
    /// Values of all generations so far, and the points they belong to.
    pub(super) told: Vec<Vec<f64>>,
    points: Vec<Vec<Vec<f64>>>,
}

impl Search {
    /// Around `start`.
    ///
    /// # Errors
    /// None for a checked configuration.
    pub(super) fn new(config: &Config, start: [f64; 6], seed: u64) -> Result<Self> {
        let ranges = config.ranges.list();
        let part = |k: usize| {
            let [low, high] = ranges[k];
            // An atlas may have been drawn from wider ranges.
            if high > low { ((start[k] - low) / (high - low)).clamp(0.0, 1.0) } else { 0.5 }
        };
        let start: Vec<f64> = (0..5).map(part).collect();
        let cmaes = Cmaes::new(&start, config.width, seed)?;
        Ok(Self { cmaes, told: Vec::new(), points: Vec::new() })
    }

    /// The parameters of a point.
    pub(super) fn parameters(config: &Config, point: &[f64], mass: f64) -> [f64; 6] {
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

    /// Grows and compares a generation; all candidates start from the same noise, so that
    /// they differ by their parameters alone.
    ///
    /// # Errors
    /// If coefficients are refused.
    pub(super) fn generation(
        &mut self,
        config: &Config,
        wanted: &PreparedCloud<2>,
        transport: &CoarseSinkhorn,
        mass: f64,
        seed: u64,
    ) -> Result<()> {
        let points = self.cmaes.ask();
        let evaluate = |point: &Vec<f64>| {
            let shape = grow(config, Self::parameters(config, point, mass), seed)?;
            distance(shape.as_deref(), wanted, transport, config)
        };
        let values: Result<Vec<f64>> = points.par_iter().map(evaluate).collect();
        self.tell(points, values?)
    }

    fn tell(&mut self, points: Vec<Vec<f64>>, values: Vec<f64>) -> Result<()> {
        self.cmaes.tell(&values)?;
        self.told.push(values);
        self.points.push(points);
        Ok(())
    }

    /// Goes through a generation again whose values are known.
    ///
    /// # Errors
    /// If their number is another.
    pub(super) fn repeat(&mut self, values: Vec<f64>) -> Result<()> {
        let points = self.cmaes.ask();
        self.tell(points, values)
    }

    /// Points of a generation.
    pub(super) fn population(&self) -> usize {
        self.told.first().map_or(0, Vec::len)
    }

    /// The best point so far and its distance.
    pub(super) fn best(&self) -> Option<(&[f64], f64)> {
        self.cmaes.best()
    }

    /// How far the parameters are known: standard deviation of the better halves of the last
    /// generations.
    pub(super) fn spread(&self, config: &Config, mass: f64) -> [f64; 5] {
        let from = self.told.len().saturating_sub(LAST);
        let mut kept: Vec<[f64; 6]> = Vec::new();
        for (points, values) in self.points[from..].iter().zip(&self.told[from..]) {
            let mut order: Vec<usize> = (0..values.len()).collect();
            order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
            let half = order.iter().take(values.len() / 2);
            kept.extend(half.map(|&n| Self::parameters(config, &points[n], mass)));
        }
        std::array::from_fn(|k| {
            let n = kept.len().max(1) as f64;
            let mean = kept.iter().map(|p| p[k]).sum::<f64>() / n;
            let square = kept.iter().map(|p| (p[k] - mean).powi(2)).sum::<f64>();
            (square / (n - 1.0).max(1.0)).sqrt()
        })
    }
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
pub(super) fn distance(
    shape: Option<&Shape>,
    wanted: &PreparedCloud<2>,
    transport: &CoarseSinkhorn,
    config: &Config,
) -> Result<f64> {
    let Some(shape) = shape else { return Ok(REFUSED * config.distance.reach) };
    let own = transport.prepare(&shape.diagram)?;
    Ok(transport.divergence(wanted, &own).abs().sqrt())
}
