//! Flows that lower the energy, one evaluation at a time.
//!
//! All own their state and hand it out for checkpoints; a step that meets a number that is
//! not finite is an error that names its iteration, after which the state is of no use.

mod descent;
mod fast;
mod opened;
mod paper;
mod paper_step;
mod precondition;

pub use descent::{Descent, DescentConfig};
pub use fast::{Fast, FastConfig, Guard};
pub use opened::{Opened, OpenedConfig, Stage};
pub use paper::{Paper, PaperConfig, start};

use solvers::{Error, Result};

/// What a step saw before it moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepInfo {
    /// Number of the evaluation, from 0.
    pub iteration: u64,
    /// F.
    pub energy: f64,
    /// Euclidean norm of the gradient with respect to the flow's variable.
    pub gradient_norm: f64,
}

impl StepInfo {
    fn check(self) -> Result<Self> {
        if self.energy.is_finite() && self.gradient_norm.is_finite() {
            return Ok(self);
        }
        Err(Error::Invalid(format!(
            "the energy became {} and the gradient's norm {} at iteration {}; reduce the rate",
            self.energy, self.gradient_norm, self.iteration
        )))
    }
}
