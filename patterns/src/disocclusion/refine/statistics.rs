//! Candidates compared by summary statistics: the regression of the parameters on the descriptor,
//! which Fearnhead & Prangle 2012, "Constructing summary statistics for approximate Bayesian
//! computation", show to be the best ones for the parameters' mean.

use super::super::{Identifier, Match, Normal, simulate};
use super::{Cost, OUTSIDE, Runs, WIDTH};
use crate::{Inputs, Result};
use solvers::optimize::Cmaes;
use solvers::texture::{Descriptor, Masked};

/// A search for a class with a free seed.
pub(super) struct Statistics<'a> {
    identifier: &'a Identifier,
    class: usize,
    /// Summary statistics of the picture.
    wanted: Vec<f64>,
    deviations: Vec<f64>,
    seed: u64,
    search: Cmaes,
}

impl<'a> Statistics<'a> {
    /// None if the picture has no statistics.
    pub(super) fn new(
        identifier: &'a Identifier,
        normal: &Normal,
        found: &Match,
        seed: u64,
    ) -> Result<Option<Self>> {
        let Some(descriptor) = Descriptor::new(&normal.masked()?) else { return Ok(None) };
        Ok(Some(Self {
            identifier,
            class: found.class,
            wanted: identifier.summary(found.class, &descriptor, found.inverted),
            deviations: identifier.deviations(found.class),
            seed,
            search: Cmaes::new(&found.point, WIDTH, seed)?,
        }))
    }

    /// A generation: its costs and the width of the search.
    pub(super) fn step(
        &mut self,
        runs: &mut Runs<'_>,
        inputs: &(dyn Inputs + Sync),
    ) -> Result<(Vec<f64>, f64)> {
        let (identifier, class) =
            (self.identifier, &self.identifier.database().classes[self.class]);
        let (wanted, deviations) = (&self.wanted, &self.deviations);
        let cost = |point: &[f64]| -> Result<Cost> {
            let pattern = simulate(class, point, self.seed, inputs)?;
            let all = vec![true; pattern.ink.len()];
            let masked = Masked::new(pattern.shape, &pattern.ink, &all)?;
            let Some(descriptor) = Descriptor::new(&masked) else { return Ok((OUTSIDE, None)) };
            let summary = identifier.summary(self.class, &descriptor, false);
            let terms = summary.iter().zip(wanted).zip(deviations);
            Ok((terms.map(|((a, b), s)| ((a - b) / s).powi(2)).sum(), None))
        };
        let costs = runs.generation(&mut self.search, &cost)?;
        Ok((costs, self.search.sigma()))
    }

    /// The middle of the search.
    pub(super) fn point(&self) -> Vec<f64> {
        self.search.mean().iter().map(|v| v.clamp(0.0, 1.0)).collect()
    }
}
