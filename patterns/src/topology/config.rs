//! Configuration of the `topopt` model.

use super::problem::ProblemConfig;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// Parameters of a run; lengths in elements.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Domain, material, loads, supports.
    pub problem: ProblemConfig,
    /// Take the problem as its source prints it: without what an interpretation added,
    /// and with all loads at once.
    pub as_printed: bool,
    /// Apply the loads of all cases at once.
    pub one_case: bool,
    /// What is done.
    pub method: Method,
    /// Material allowed, as a fraction of the whole box, in (0, 1).
    pub volume: f64,
    /// What is made small.
    pub objective: Objective,
    /// How the load cases are joined.
    pub cases: Cases,
    /// Stiffness as a function of density.
    pub interpolation: Interpolation,
    /// Exponent p of the interpolation (q of RAMP), in [0, 20].
    pub penalization: f64,
    /// Exponent at the start, in [0, penalization]; absent for `penalization` throughout.
    pub penalization_start: Option<f64>,
    /// What a rise adds to the exponent, in (0, 20].
    pub penalization_step: f64,
    /// Iterations until the exponent rises; it rises earlier when the design comes to rest.
    pub penalization_every: u64,
    /// Stiffness of void relative to solid (modified SIMP and RAMP), in (0, 0.1].
    pub void_stiffness: f64,
    /// Rules of the 99 or of the 88 lines for density limits and bisection.
    pub rules: Rules,
    /// What smooths the design.
    pub filter: Filter,
    /// Radius of the filter (elements), at least 1.
    pub filter_radius: f64,
    /// Steps towards black and white after a filter; absent for none.
    pub projection: Option<Projection>,
    /// What updates the design.
    pub optimizer: Optimizer,
    /// Largest change of a density in an iteration, in (0, 1].
    pub move_limit: f64,
    /// Exponent of the optimality criteria, in (0, 1].
    pub damping: f64,
    /// Largest change of a density (of phi, in elements) at which the run ends.
    pub tolerance: f64,
    /// Most iterations.
    pub iterations: u64,
    /// Solver of the linear systems.
    pub solver: Solver,
    /// Relative residual asked of an iterative solver, in [1e-12, 0.01]; absent for one that
    /// follows the change of the design.
    pub solver_tolerance: Option<f64>,
    /// Exponent of the p-norm of the stresses, in [2, 64].
    pub stress_exponent: f64,
    /// What the level-set method does beside.
    pub level_set: LevelSetConfig,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            problem: ProblemConfig::default(),
            as_printed: false,
            one_case: false,
            method: Method::Simp,
            volume: 0.5,
            objective: Objective::Compliance,
            cases: Cases::Sum,
            interpolation: Interpolation::Modified,
            penalization: 3.0,
            penalization_start: None,
            penalization_step: 0.5,
            penalization_every: 20,
            void_stiffness: 1e-9,
            rules: Rules::Lines88,
            filter: Filter::Sensitivity,
            filter_radius: 1.5,
            projection: None,
            optimizer: Optimizer::Oc,
            move_limit: 0.2,
            damping: 0.5,
            tolerance: 0.01,
            iterations: 1000,
            solver: Solver::Auto,
            solver_tolerance: None,
            stress_exponent: 8.0,
            level_set: LevelSetConfig::default(),
        }
    }
}

/// The two methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// A density per element.
    Simp,
    /// A front that moves.
    LevelSet,
}

/// What is made small under the volume constraint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Objective {
    /// Work of the loads; for heat, the mean temperature weighted by the sources.
    Compliance,
    /// The output displacement: negative is along the wanted direction.
    Displacement,
    /// p-norm of the relaxed von Mises stresses.
    Stress,
}

/// How the load cases are joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cases {
    /// The weighted sum.
    Sum,
    /// The greatest.
    Worst,
}

/// Stiffness E of an element of density x.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Interpolation {
    /// `E = x^p`, x at least 0.001: Sigmund 2001.
    Simp,
    /// `E = E_void + x^p (1 - E_void)`: Andreassen et al. 2011, eq. (1).
    Modified,
    /// `E = E_void + x / (1 + q (1 - x)) (1 - E_void)`: Stolpe & Svanberg 2001.
    Ramp,
}

/// Density limits and the bisection of the volume's multiplier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Rules {
    /// x in [0.001, 1], multiplier in [0, 1e5] to 1e-4: Sigmund 2001.
    #[serde(rename = "99")]
    Lines99,
    /// x in [0, 1], multiplier in [0, 1e9] to a relative 1e-3: Andreassen et al. 2011.
    #[serde(rename = "88")]
    Lines88,
}

/// What smooths the design.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Filter {
    /// Nothing: checkerboards and dependence on the mesh.
    None,
    /// Averages of x dC/dx in place of dC/dx: Sigmund 2001, eq. (5).
    Sensitivity,
    /// Averages of the densities: Bruns & Tortorelli 2001.
    Density,
    /// A screened Poisson equation: Lazarov & Sigmund 2011.
    Helmholtz,
}

/// Smooth Heaviside step of the filtered densities (Wang, Lazarov & Sigmund 2011, eq. 4).
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Projection {
    /// Sharpness at the start, in (0, 1024].
    pub beta: f64,
    /// Sharpness at the end.
    pub beta_max: f64,
    /// Iterations until the sharpness is doubled.
    pub every: u64,
    /// Density of the step, in (0, 1).
    pub eta: f64,
    /// Choose the step's density anew so that the volume before and after agree.
    pub preserve_volume: bool,
    /// Robust design: worst of the steps at `eta - delta`, `eta`, `eta + delta`; 0 for `eta` alone.
    pub delta: f64,
}

impl Default for Projection {
    fn default() -> Self {
        Self { beta: 1.0, beta_max: 32.0, every: 50, eta: 0.5, preserve_volume: false, delta: 0.0 }
    }
}

/// What updates the design.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Optimizer {
    /// Optimality criteria.
    Oc,
    /// Method of moving asymptotes.
    Mma,
    /// Its globally convergent version.
    Gcmma,
}

/// Solver of the linear systems.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Solver {
    /// By size.
    Auto,
    /// Sparse Cholesky.
    Direct,
    /// Conjugate gradients with a multigrid preconditioner.
    Multigrid,
}

/// What the level-set method does beside moving the front.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LevelSetConfig {
    /// Holes across and down at the start, `[0, 0]` for a full box.
    pub holes: [usize; 2],
    /// Iterations between two nucleations of holes, 0 for none.
    pub nucleate_every: u64,
    /// Part of the solid that a nucleation turns to void, in [0, 0.2].
    pub nucleate_fraction: f64,
    /// Iterations between two redistancings.
    pub redistance_every: u64,
    /// Length over which the speed is smoothed (elements), in [0, 20].
    pub smoothing: f64,
    /// Stiffness of void relative to solid while the front moves, in (0, 0.1].
    pub ersatz: f64,
    /// Largest way of the front in an iteration (elements), in (0, 2].
    pub step: f64,
    /// Most volume that an iteration takes away, as a fraction of the box, in (0, 1].
    pub volume_step: f64,
}

impl Default for LevelSetConfig {
    fn default() -> Self {
        Self {
            holes: [0, 0],
            nucleate_every: 5,
            nucleate_fraction: 0.03,
            redistance_every: 5,
            smoothing: 1.0,
            ersatz: 1e-3,
            step: 1.0,
            volume_step: 0.01,
        }
    }
}

impl Config {
    /// Refuses values out of range.
    pub(super) fn check(&self) -> Result<()> {
        let within = |key: &str, value: f64, ok: bool, range: &str| {
            if ok && value.is_finite() { Ok(()) } else { Err(Error::range(key, value, range)) }
        };
        let half_open = |key: &str, v: f64, high: f64| {
            within(key, v, v > 0.0 && v <= high, &format!("(0, {high}]"))
        };
        within("volume", self.volume, self.volume > 0.0 && self.volume < 1.0, "(0, 1)")?;
        let p = self.penalization;
        within("penalization", p, (0.0..=20.0).contains(&p), "[0, 20]")?;
        if let Some(start) = self.penalization_start {
            let ok = (0.0..=p).contains(&start);
            within("penalization_start", start, ok, "[0, penalization]")?;
        }
        half_open("penalization_step", self.penalization_step, 20.0)?;
        if self.penalization_every == 0 {
            return Err(Error::range("penalization_every", 0.0, "[1, inf)"));
        }
        if let Some(tolerance) = self.solver_tolerance {
            let ok = (1e-12..=0.01).contains(&tolerance);
            within("solver_tolerance", tolerance, ok, "[1e-12, 0.01]")?;
        }
        half_open("void_stiffness", self.void_stiffness, 0.1)?;
        let r = self.filter_radius;
        within("filter_radius", r, (1.0..=1000.0).contains(&r), "[1, 1000]")?;
        half_open("move_limit", self.move_limit, 1.0)?;
        half_open("damping", self.damping, 1.0)?;
        half_open("tolerance", self.tolerance, 1.0)?;
        let most = self.iterations as f64;
        within("iterations", most, (1.0..=1e7).contains(&most), "[1, 10000000]")?;
        let e = self.stress_exponent;
        within("stress_exponent", e, (2.0..=64.0).contains(&e), "[2, 64]")?;
        if let Some(projection) = &self.projection {
            half_open("projection.beta", projection.beta, 1024.0)?;
            let most = projection.beta_max;
            let ok = most >= projection.beta && most <= 1024.0;
            within("projection.beta_max", most, ok, "[beta, 1024]")?;
            let (eta, delta) = (projection.eta, projection.delta);
            within("projection.eta", eta, eta > 0.0 && eta < 1.0, "(0, 1)")?;
            let ok = delta >= 0.0 && delta < eta.min(1.0 - eta);
            within("projection.delta", delta, ok, "[0, min(eta, 1 - eta))")?;
            if projection.every == 0 {
                return Err(Error::range("projection.every", 0.0, "[1, inf)"));
            }
            if matches!(self.filter, Filter::None | Filter::Sensitivity) {
                let reason = "a projection needs the filter `density` or `helmholtz`";
                return Err(Error::config("projection", reason));
            }
        }
        let level = &self.level_set;
        let f = level.nucleate_fraction;
        within("level_set.nucleate_fraction", f, (0.0..=0.2).contains(&f), "[0, 0.2]")?;
        let s = level.smoothing;
        within("level_set.smoothing", s, (0.0..=20.0).contains(&s), "[0, 20]")?;
        half_open("level_set.ersatz", level.ersatz, 0.1)?;
        half_open("level_set.step", level.step, 2.0)?;
        half_open("level_set.volume_step", level.volume_step, 1.0)?;
        Ok(())
    }
}
