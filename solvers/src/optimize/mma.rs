//! The method of moving asymptotes (MMA).
//!
//! | symbol   | code                    | meaning                                         | unit        |
//! |----------|-------------------------|-------------------------------------------------|-------------|
//! | x_j      | `x`                     | design variables, n of them                     | any, `[x]`  |
//! | f_0      | `f0`, `df0`             | objective and its gradient                      | `[f0]`      |
//! | f_i      | `g`, `dg`               | constraints `f_i <= 0`, m of them               | `[g]`       |
//! | l_j, u_j | `low`, `upp`            | asymptotes                                      | `[x]`       |
//! | alpha_j, beta_j | `alpha`, `beta`  | bounds of a subproblem                          | `[x]`       |
//! | p_ij, q_ij | `p`, `q`              | coefficients of `1/(u - x)` and `1/(x - l)`     | `[g] [x]`   |
//! | lambda_i | `multipliers`           | Lagrange multipliers                            | `[f0]/[g]`  |
//! | y_i, z   | `y`, `z`                | artificial variables                            | `[g]`, 1    |
//! | a_0, a_i, c_i, d_i | [`Artificial`] | what the artificial variables cost             |             |
//!
//! The problem is: minimize `f_0(x) + a_0 z + sum_i (c_i y_i + d_i y_i^2 / 2)` subject to
//! `f_i(x) - a_i z - y_i <= 0`, `x` in its box, `y >= 0`, `z >= 0`. In each step f_0 and f_i
//! are replaced by convex separable functions with the same value and gradient, whose poles
//! follow the history of each variable.
//!
//! Sources: K. Svanberg, The method of moving asymptotes, Int. J. Numer. Methods Eng. 24
//! (1987) 359-373; K. Svanberg, MMA and GCMMA - two methods for nonlinear optimization
//! (2007), whose equation numbers are cited.

mod artificial;
mod asymptotes;
mod block;
mod expansion;
mod point;
pub(super) mod subproblem;

pub use artificial::Artificial;
pub use asymptotes::MovingLimits;
pub use subproblem::Solve;

pub(super) use asymptotes::Asymptotes;

use super::Bounds;
use super::check::{self, Evaluation};
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use subproblem::{Model, Subproblem};

/// How an [`Mma`] steps; the defaults are the published constants.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MmaConfig {
    /// Curvature that every approximation has at least, `[f]` per box width; raa0, 1e-5.
    pub regularization: f64,
    /// Largest violation of a subproblem's optimality conditions that is left, absolute; 1e-9.
    ///
    /// The published 1e-7 is left per variable, n times that in the objective.
    pub tolerance: f64,
    /// Where the asymptotes and the bounds of a step stand.
    pub limits: MovingLimits,
}

impl Default for MmaConfig {
    fn default() -> Self {
        Self { regularization: 1e-5, tolerance: 1e-9, limits: MovingLimits::default() }
    }
}

/// Optimizes smooth functions under inequality constraints, one subproblem per evaluation.
///
/// There is no line search: objective and constraints may rise on the way, and a step may
/// oscillate by a hundredth of the box around an optimum inside it; [`super::Gcmma`] is the
/// remedy. Functions are best scaled to magnitudes of 1 to 100, as tolerances and the
/// costs `c` are absolute.
///
/// Memory: about `22 n + 3 m n` numbers.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "Saved")]
pub struct Mma {
    config: MmaConfig,
    artificial: Artificial,
    bounds: Bounds,
    history: Asymptotes,
    #[serde(skip)]
    subproblem: Subproblem,
    #[serde(skip)]
    next: Vec<f64>,
    #[serde(skip)]
    solve: Solve,
}

/// An [`Mma`] as read, before it is checked.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    config: MmaConfig,
    artificial: Artificial,
    bounds: Bounds,
    history: Asymptotes,
}

impl TryFrom<Saved> for Mma {
    type Error = Error;

    fn try_from(saved: Saved) -> Result<Self> {
        let Saved { config, artificial, bounds, history } = saved;
        history.check(bounds.len())?;
        Ok(Self { history, ..Self::new(bounds, artificial, config)? })
    }
}

impl Mma {
    /// An optimizer without history for the variables in `bounds` and as many constraints as
    /// `artificial` has costs.
    ///
    /// # Errors
    /// If a number of the configuration is outside its range or the costs are not valid.
    pub fn new(bounds: Bounds, artificial: Artificial, config: MmaConfig) -> Result<Self> {
        artificial.check()?;
        config.limits.check()?;
        let MmaConfig { regularization, tolerance, .. } = config;
        check::within("regularization", regularization, regularization > 0.0, "(0, inf)")?;
        check::within("tolerance", tolerance, tolerance > 0.0 && tolerance < 1.0, "(0, 1)")?;
        let history = Asymptotes::new(bounds.len());
        Ok(Self {
            config,
            artificial,
            bounds,
            history,
            subproblem: Subproblem::default(),
            next: Vec::new(),
            solve: Solve::default(),
        })
    }

    /// The next point, from the functions at `x`.
    ///
    /// `x` is any point in the box, as a rule the last one returned. Shapes: `x`, `df0` are
    /// `[n]`, `g` is `[m]`, `dg` is `[m, n]` row by row. The result lies in the box and within
    /// the move limit of `x`. A subproblem not solved to its tolerance is a status of
    /// [`Mma::last_solve`].
    ///
    /// Cost: 15 to 40 Newton steps of `O(n m^2 + m^3)`. Nothing of size n is allocated after
    /// the first call. Source: Svanberg 2007, sections 3 and 5.
    ///
    /// # Errors
    /// If a length does not fit, a number is not finite or `x` is outside its box; the state
    /// is as before then.
    pub fn step(
        &mut self,
        x: &[f64],
        f0: f64,
        df0: &[f64],
        g: &[f64],
        dg: &[f64],
    ) -> Result<&[f64]> {
        let values = Evaluation { f0, df0, g, dg };
        self.bounds.check(x)?;
        values.check(self.bounds.len(), self.artificial.len())?;
        self.history.advance(x, &self.bounds, &self.config.limits);
        let curvature = vec![self.config.regularization; 1 + g.len()];
        let model = Model {
            x,
            values,
            curvature: &curvature,
            bounds: &self.bounds,
            history: &self.history,
            limits: &self.config.limits,
        };
        self.subproblem.build(&model);
        self.solve = self.subproblem.solve(&self.artificial, self.config.tolerance);
        self.subproblem.write_solution(&self.bounds, &mut self.next);
        Ok(&self.next)
    }

    /// Multipliers, artificial variables and status of the last step; empty before the first
    /// and after reading a saved state.
    pub fn last_solve(&self) -> &Solve {
        &self.solve
    }

    /// Steps done since the history began.
    pub fn steps(&self) -> u64 {
        self.history.steps()
    }

    /// Forgets the history, e.g. after a change of the functions that steps have nothing to do
    /// with.
    pub fn restart(&mut self) {
        self.history = Asymptotes::new(self.bounds.len());
    }
}
