//! The globally convergent method of moving asymptotes (GCMMA).
//!
//! | symbol | code         | meaning                                                | unit       |
//! |--------|--------------|--------------------------------------------------------|------------|
//! | x      | `x`          | point of the outer iteration                           | `[x]`      |
//! | x^     | `trial`      | solution of a subproblem                               | `[x]`      |
//! | f~_i   | `model`      | approximations at the trial, f_0 first                 | `[f]`      |
//! | rho_i  | `curvature`  | curvature that the approximations have at least        | `[f]`      |
//! | d(x^)  | `distance`   | what an approximation rises by per unit of rho         | 1          |
//!
//! Steps are those of [`super::Mma`] with a curvature that is raised until all approximations
//! are conservative, `f~_i(x^) >= f_i(x^)`. Then `f_0(x^) <= f~_0(x^) <= f_0(x)` and no
//! feasible point is left. A tightening costs one evaluation of the functions, no gradients.
//!
//! Sources: K. Svanberg, A class of globally convergent optimization methods based on
//! conservative convex separable approximations, SIAM J. Optim. 12 (2002) 555-573; and MMA
//! and GCMMA (2007), section 4.

use super::Bounds;
use super::check::{self, Evaluation};
use super::mma::subproblem::{Model, Subproblem};
use super::mma::{Artificial, Asymptotes, MovingLimits, Solve};
use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// How a [`Gcmma`] steps; the defaults are the published constants.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GcmmaConfig {
    /// Least curvature rho, `[f]`; raa0eps, 1e-6.
    pub least_curvature: f64,
    /// Excess of a function over its approximation that counts as conservative, `[f]`; 1e-7.
    pub slack: f64,
    /// Largest violation of a subproblem's optimality conditions that is left, absolute;
    /// 1e-9, see [`super::MmaConfig::tolerance`].
    pub tolerance: f64,
    /// Trials per outer iteration before [`Verdict::Exhausted`]; 15.
    pub max_trials: usize,
    /// Where the asymptotes and the bounds of a step stand.
    pub limits: MovingLimits,
}

impl Default for GcmmaConfig {
    fn default() -> Self {
        let limits = MovingLimits::default();
        Self { least_curvature: 1e-6, slack: 1e-7, tolerance: 1e-9, max_trials: 15, limits }
    }
}

/// First curvature in mean slopes per box, and bounds of its growth (section 4).
const FIRST: f64 = 0.1;
const OVERSHOOT: f64 = 1.1;
const FASTEST: f64 = 10.0;

/// Part of the function values that is taken for their round-off: without it, trials from an
/// optimum of large functions could never count as conservative.
const ROUND_OFF: f64 = 64.0 * f64::EPSILON;

/// What [`Gcmma::accept`] says of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The trial is the next point: evaluate the gradients there and propose again.
    Accepted,
    /// [`Gcmma::trial`] is another point to evaluate.
    Tighten,
    /// The last of the trials is not conservative either: values or gradients are inexact.
    /// Taking it is usual and gives up that the objective falls; the method can go on.
    Exhausted,
}

/// Optimizes smooth functions under inequality constraints, from every start to a point that
/// fulfils the first-order conditions.
///
/// Memory: about `24 n + 4 m n` numbers.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "Saved")]
pub struct Gcmma {
    config: GcmmaConfig,
    artificial: Artificial,
    bounds: Bounds,
    history: Asymptotes,
    #[serde(skip_serializing_if = "Option::is_none")]
    pending: Option<Pending>,
    #[serde(skip)]
    spare: Pending,
    #[serde(skip)]
    subproblem: Subproblem,
    #[serde(skip)]
    solve: Solve,
}

/// A [`Gcmma`] as read, before it is checked.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    config: GcmmaConfig,
    artificial: Artificial,
    bounds: Bounds,
    history: Asymptotes,
    pending: Option<Pending>,
}

/// An outer iteration whose trial waits for its values.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Pending {
    x: Vec<f64>,
    f0: f64,
    df0: Vec<f64>,
    g: Vec<f64>,
    dg: Vec<f64>,
    curvature: Vec<f64>,
    trial: Vec<f64>,
    model: Vec<f64>,
    distance: f64,
    trials: usize,
}

impl Pending {
    fn values(&self) -> Evaluation<'_> {
        Evaluation { f0: self.f0, df0: &self.df0, g: &self.g, dg: &self.dg }
    }

    fn fill(&mut self, x: &[f64], values: Evaluation<'_>) {
        let copies = [
            (&mut self.x, x),
            (&mut self.df0, values.df0),
            (&mut self.g, values.g),
            (&mut self.dg, values.dg),
        ];
        for (to, from) in copies {
            to.clear();
            to.extend_from_slice(from);
        }
        (self.f0, self.trials) = (values.f0, 0);
    }

    fn check(&self, bounds: &Bounds, m: usize) -> Result<()> {
        bounds.check(&self.x)?;
        self.values().check(bounds.len(), m)?;
        check::length("saved trial", &self.trial, bounds.len())?;
        for (name, values) in [("saved curvature", &self.curvature), ("saved model", &self.model)] {
            check::length(name, values, m + 1)?;
            check::finite(name, values)?;
        }
        check::finite("saved distance", &[self.distance])
    }
}

impl TryFrom<Saved> for Gcmma {
    type Error = Error;

    fn try_from(saved: Saved) -> Result<Self> {
        let Saved { config, artificial, bounds, history, pending } = saved;
        history.check(bounds.len())?;
        if let Some(pending) = &pending {
            pending.check(&bounds, artificial.len())?;
        }
        Ok(Self { history, pending, ..Self::new(bounds, artificial, config)? })
    }
}

impl Gcmma {
    /// An optimizer without history for the variables in `bounds` and as many constraints as
    /// `artificial` has costs.
    ///
    /// # Errors
    /// If a number of the configuration is outside its range or the costs are not valid.
    pub fn new(bounds: Bounds, artificial: Artificial, config: GcmmaConfig) -> Result<Self> {
        artificial.check()?;
        config.limits.check()?;
        let GcmmaConfig { least_curvature: least, slack, tolerance, max_trials, .. } = config;
        check::within("slack", slack, slack >= 0.0 && slack.is_finite(), "[0, inf)")?;
        check::within("least_curvature", least, least > 0.0 && least.is_finite(), "(0, inf)")?;
        check::within("tolerance", tolerance, tolerance > 0.0 && tolerance < 1.0, "(0, 1)")?;
        check::within("max_trials", max_trials as f64, max_trials > 0, "[1, inf)")?;
        Ok(Self {
            history: Asymptotes::new(bounds.len()),
            config,
            artificial,
            bounds,
            pending: None,
            spare: Pending::default(),
            subproblem: Subproblem::default(),
            solve: Solve::default(),
        })
    }

    /// Begins an outer iteration at `x`: the first trial, to be evaluated and handed to
    /// [`Gcmma::accept`].
    ///
    /// Shapes: `x`, `df0` are `[n]`, `g` is `[m]`, `dg` is `[m, n]` row by row. Cost: as
    /// [`super::Mma::step`]. Source: Svanberg 2007, section 4.
    ///
    /// # Errors
    /// If a trial still waits for its values, a length does not fit, a number is not finite
    /// or `x` is outside its box; the state is as before then.
    pub fn propose(
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
        if self.pending.is_some() {
            return Err(Error::Invalid(
                "a trial waits for its values: call accept before the next propose".into(),
            ));
        }
        self.history.advance(x, &self.bounds, &self.config.limits);
        let mut pending = std::mem::take(&mut self.spare);
        pending.fill(x, values);
        pending.curvature = self.first_curvature(df0, dg);
        self.solve_pending(&mut pending);
        Ok(&self.pending.insert(pending).trial)
    }

    /// Judges the trial by the functions there, and makes another if it is not conservative.
    ///
    /// Source: Svanberg 2007, section 4.
    ///
    /// # Errors
    /// If no trial waits, a length does not fit or a number is not finite; the trial waits on
    /// then.
    pub fn accept(&mut self, f0: f64, g: &[f64]) -> Result<Verdict> {
        check::values(f0, g, self.artificial.len())?;
        let Some(mut pending) = self.pending.take() else {
            return Err(Error::Invalid("no trial waits for its values: call propose first".into()));
        };
        let mut conservative = true;
        for (i, &value) in std::iter::once(&f0).chain(g).enumerate() {
            let excess = value - pending.model[i];
            if excess > self.config.slack + ROUND_OFF * value.abs() {
                conservative = false;
                let rho = pending.curvature[i];
                let wanted = OVERSHOOT * (rho + excess / pending.distance);
                pending.curvature[i] = wanted.min(FASTEST * rho);
            }
        }
        if conservative || pending.trials >= self.config.max_trials {
            self.spare = pending;
            return Ok(if conservative { Verdict::Accepted } else { Verdict::Exhausted });
        }
        self.solve_pending(&mut pending);
        self.pending = Some(pending);
        Ok(Verdict::Tighten)
    }

    /// The point that waits for its values, if any.
    pub fn trial(&self) -> Option<&[f64]> {
        self.pending.as_ref().map(|pending| pending.trial.as_slice())
    }

    /// Multipliers, artificial variables and status of the last subproblem; empty before the
    /// first and after reading a saved state.
    pub fn last_solve(&self) -> &Solve {
        &self.solve
    }

    /// Outer iterations begun.
    pub fn steps(&self) -> u64 {
        self.history.steps()
    }

    fn solve_pending(&mut self, pending: &mut Pending) {
        let model = Model {
            x: &pending.x,
            values: pending.values(),
            curvature: &pending.curvature,
            bounds: &self.bounds,
            history: &self.history,
            limits: &self.config.limits,
        };
        self.subproblem.build(&model);
        self.solve = self.subproblem.solve(&self.artificial, self.config.tolerance);
        let (values, distance) = self.subproblem.approximations(&model);
        (pending.model, pending.distance) = (values, distance);
        self.subproblem.write_solution(&self.bounds, &mut pending.trial);
        pending.trials += 1;
    }

    /// A tenth of the mean of slope times box width, per function.
    fn first_curvature(&self, df0: &[f64], dg: &[f64]) -> Vec<f64> {
        let (lower, upper) = (self.bounds.lower(), self.bounds.upper());
        let free = (0..lower.len()).filter(|&j| !self.bounds.is_fixed(j)).count().max(1);
        let first = |slopes: &[f64]| {
            let boxes = lower.iter().zip(upper);
            let sum: f64 = slopes.iter().zip(boxes).map(|(s, (l, u))| s.abs() * (u - l)).sum();
            (FIRST * sum / free as f64).max(self.config.least_curvature)
        };
        std::iter::once(df0).chain(dg.chunks_exact(df0.len())).map(first).collect()
    }
}
