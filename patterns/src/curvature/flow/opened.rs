//! The fast flow after an opening of the published one.

use super::{Fast, FastConfig, Paper, PaperConfig, StepInfo};
use crate::curvature::energy::{Energy, Scalar};
use crate::curvature::{Mask, Potential};
use solvers::Result;
use solvers::spectral::Transforms;

/// Constants of both flows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenedConfig {
    /// Of the opening.
    pub paper: PaperConfig,
    /// Its steps.
    pub opening: u64,
    /// Of what follows.
    pub fast: FastConfig,
}

/// Steps of an opening, and most of a run's: a quarter.
const OPENING: (u64, u64) = (200, 4);

/// Rate of the fast flow after an opening.
const RATE: f64 = 0.5;

/// Steps in which the rate rises to that, and most of those after the opening: a quarter, or half
/// of the rest where the opening is longer than that. Adam's first steps are of one size in all its
/// variables, whatever the gradient; at full rate they undo the opening, and their gradients hold
/// the flow back for as long as Adam remembers them. The more the opening has settled, the more
/// there is to undo: with a quarter the energy of bilayers rose by .3 after 1600 steps.
const WARMUP: (u64, u64, u64) = (100, 4, 2);

/// After an opening and with a rate that rises slowly, the energy hardly rises.
const RISE: f64 = 1.25;

impl OpenedConfig {
    /// Constants for a run of `evaluations`, as many in the opening as given, or the usual.
    pub fn new(evaluations: u64, opening: Option<u64>) -> Self {
        let opening = opening.unwrap_or(OPENING.0.min(evaluations / OPENING.1));
        let left = evaluations.saturating_sub(opening);
        let mut fast = FastConfig { decay: Some(left), ..FastConfig::default() };
        if opening > 0 {
            fast.adam.rate = RATE;
            let (most, usual, long) = WARMUP;
            fast.warmup = most.min(left / if opening > left { long } else { usual });
            fast.rise = RISE;
        }
        Self { paper: PaperConfig::default(), opening, fast }
    }
}

/// A flow of two stages: the first steps choose where there will be a wall, a tube or a hole, and
/// the fast flow, left to choose, chooses otherwise than the published one.
#[derive(Debug)]
pub struct Opened<T: Transforms> {
    config: OpenedConfig,
    mask: Option<Mask<T>>,
    stage: Stage<T>,
}

/// Where an [`Opened`] flow is.
#[derive(Debug)]
pub enum Stage<T: Transforms> {
    /// In its opening.
    Opening(Box<Paper<T>>),
    /// Past it.
    Fast(Box<Fast<T>>),
}

impl<T: Scalar + Transforms> Opened<T> {
    /// The published start, as [`Paper::new`].
    ///
    /// # Errors
    /// As [`Paper::new`] and [`Fast::new`].
    pub fn new(
        energy: Energy<T>,
        potential: Potential<T>,
        config: OpenedConfig,
        seed: u64,
    ) -> Result<Self> {
        config.fast.check(energy.config())?;
        let paper = Paper::new(energy, potential, config.paper, seed)?;
        let stage = Stage::Opening(Box::new(paper));
        let mut flow = Self { config, mask: None, stage };
        flow.hand_over()?;
        Ok(flow)
    }

    /// Gives u at some voxels; the mean of u is then no longer kept.
    #[must_use]
    pub fn with_mask(mut self, mask: Mask<T>) -> Self {
        self.mask = Some(mask.clone());
        self.stage = match self.stage {
            Stage::Opening(paper) => Stage::Opening(Box::new(paper.with_mask(mask))),
            Stage::Fast(fast) => Stage::Fast(Box::new(fast.with_mask(mask))),
        };
        self
    }

    /// Evaluates, then steps.
    ///
    /// # Errors
    /// If the energy or its gradient is not finite.
    pub fn step(&mut self) -> Result<StepInfo> {
        let info = match &mut self.stage {
            Stage::Opening(paper) => paper.step()?,
            Stage::Fast(fast) => {
                let info = fast.step()?;
                StepInfo { iteration: self.config.opening + info.iteration, ..info }
            }
        };
        self.hand_over()?;
        Ok(info)
    }

    fn hand_over(&mut self) -> Result<()> {
        match &self.stage {
            Stage::Opening(paper) if paper.steps() >= self.config.opening => {
                let phase = paper.phase().to_vec();
                self.begin(phase)
            }
            _ => Ok(()),
        }
    }

    /// Begins the fast flow: at the end of the opening, or where a checkpoint says.
    ///
    /// # Errors
    /// As [`Fast::new`].
    ///
    /// # Panics
    /// If `start` has not one number per voxel.
    pub fn begin(&mut self, start: Vec<T>) -> Result<()> {
        let mut fast = Fast::new(self.energy().clone(), self.config.fast, start)?;
        if let Some(mask) = &self.mask {
            fast = fast.with_mask(mask.clone());
        }
        self.stage = Stage::Fast(Box::new(fast));
        Ok(())
    }

    /// The phase field, shape `[nz, ny, nx]`.
    pub fn phase(&self) -> &[T] {
        match &self.stage {
            Stage::Opening(paper) => paper.phase(),
            Stage::Fast(fast) => fast.phase(),
        }
    }

    /// Its energy's constants and measures.
    pub fn energy(&self) -> &Energy<T> {
        match &self.stage {
            Stage::Opening(paper) => paper.energy(),
            Stage::Fast(fast) => fast.energy(),
        }
    }

    /// Evaluations made, of both stages.
    pub fn steps(&self) -> u64 {
        match &self.stage {
            Stage::Opening(paper) => paper.steps(),
            Stage::Fast(fast) => self.config.opening + fast.steps(),
        }
    }

    /// Where it is: all that a checkpoint needs.
    pub fn stage(&self) -> &Stage<T> {
        &self.stage
    }

    /// The same, to restore a checkpoint.
    pub fn stage_mut(&mut self) -> &mut Stage<T> {
        &mut self.stage
    }
}
