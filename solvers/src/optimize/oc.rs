//! The optimality-criteria update of density topology optimization.
//!
//! | symbol | code                  | meaning                                         | unit        |
//! |--------|-----------------------|-------------------------------------------------|-------------|
//! | x_e    | `x`                   | densities                                       | 1           |
//! | dc     | `dc`                  | derivative of the objective, `<= 0`             | `[c]`       |
//! | dv     | `dv`                  | derivative of the volume, `> 0`                 | `[v]`       |
//! | lambda | `multiplier`          | Lagrange multiplier of the volume               | `[c]/[v]`   |
//! | m      | `move_limit`          | farthest change of a density                    | 1           |
//! | eta    | `damping`             | exponent                                        | 1           |
//!
//! `x_e (-dc/dv/lambda)^eta`, held within the move limit and the box, where lambda is found
//! by bisection so that the volume is met. Rounding, stopping and the order of operations are
//! those of the published programs, so their printed compliances and iteration counts can be
//! met digit by digit.
//!
//! Sources: O. Sigmund, A 99 line topology optimization code written in Matlab, Struct.
//! Multidisc. Optim. 21 (2001) 120-127; E. Andreassen et al., Efficient topology optimization
//! in MATLAB using 88 lines of code, Struct. Multidisc. Optim. 43 (2011) 1-16; for mechanisms
//! M. P. Bendsoe and O. Sigmund, Topology Optimization (2003), appendix.

mod work;

use super::{Bounds, check};
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use work::{Work, bisect};

/// When the bisection of `[l1, l2]` ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BisectionEnd {
    /// At `l2 - l1` up to this.
    Absolute(f64),
    /// At `(l2 - l1)/(l1 + l2)` up to this, or when l2 has come down to `least`.
    Relative {
        /// Relative width.
        width: f64,
        /// A multiplier that counts as 0, for objectives without slope.
        least: f64,
    },
}

impl BisectionEnd {
    /// Written as the loops' conditions, so that 0/0 ends them too.
    fn goes_on(self, l1: f64, l2: f64) -> bool {
        match self {
            Self::Absolute(width) => l2 - l1 > width,
            Self::Relative { width, least } => (l2 - l1) / (l1 + l2) > width && l2 > least,
        }
    }
}

/// How an [`OptimalityCriteria`] updates; [`OcConfig::top88`] by default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OcConfig {
    /// Farthest change of a density, above 0.
    pub move_limit: f64,
    /// Exponent eta in `(0, 1]`; 1/2 is taken as a square root.
    pub damping: f64,
    /// Least value of `-dc/dv/lambda`, for objectives that may rise with a density; without
    /// it a positive `dc` is an error.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub floor: Option<f64>,
    /// Multiplier from which the bisection starts downwards.
    pub greatest_multiplier: f64,
    /// When the bisection ends.
    pub end: BisectionEnd,
}

impl Default for OcConfig {
    fn default() -> Self {
        Self::top88()
    }
}

impl OcConfig {
    /// Rules of the 99-line code, for bounds [0.001, 1].
    pub fn top99() -> Self {
        let end = BisectionEnd::Absolute(1e-4);
        Self { move_limit: 0.2, damping: 0.5, floor: None, greatest_multiplier: 1e5, end }
    }

    /// Rules of the 88-line code, for bounds [0, 1].
    pub fn top88() -> Self {
        // Without slope anywhere the published loop never ends.
        let end = BisectionEnd::Relative { width: 1e-3, least: f64::MIN_POSITIVE };
        Self { move_limit: 0.2, damping: 0.5, floor: None, greatest_multiplier: 1e9, end }
    }

    /// Rules of the 99-line code for compliant mechanisms, for bounds [0.001, 1].
    pub fn mechanism() -> Self {
        let end = BisectionEnd::Relative { width: 1e-4, least: 1e-40 };
        let floor = Some(1e-10);
        Self { move_limit: 0.1, damping: 0.3, floor, greatest_multiplier: 1e5, end }
    }

    fn check(&self) -> Result<()> {
        let (limit, top) = (self.move_limit, self.greatest_multiplier);
        let positive = |v: f64| v > 0.0 && v.is_finite();
        check::within("move_limit", limit, positive(limit), "(0, inf)")?;
        let eta = self.damping;
        check::within("damping", eta, eta > 0.0 && eta <= 1.0, "(0, 1]")?;
        check::within("greatest_multiplier", top, positive(top), "(0, inf)")?;
        let floor = self.floor.unwrap_or(0.0);
        check::within("floor", floor, floor >= 0.0 && floor.is_finite(), "[0, inf)")?;
        let (BisectionEnd::Absolute(width) | BisectionEnd::Relative { width, .. }) = self.end;
        check::within("width of the bisection", width, positive(width), "(0, inf)")
    }

    fn power(&self, v: f64) -> f64 {
        if self.damping == 0.5 { v.sqrt() } else { libm::pow(v, self.damping) }
    }
}

/// Updates densities towards the optimum of one objective under one volume.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "Saved")]
pub struct OptimalityCriteria {
    config: OcConfig,
    bounds: Bounds,
    #[serde(skip)]
    work: Work,
    #[serde(skip)]
    next: Vec<f64>,
    #[serde(skip)]
    multiplier: f64,
    #[serde(skip)]
    bisections: usize,
}

/// An [`OptimalityCriteria`] as read, before it is checked.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    config: OcConfig,
    bounds: Bounds,
}

impl TryFrom<Saved> for OptimalityCriteria {
    type Error = Error;

    fn try_from(Saved { config, bounds }: Saved) -> Result<Self> {
        Self::new(bounds, config)
    }
}

impl OptimalityCriteria {
    /// An optimizer of the densities in `bounds`; fix passive elements there.
    ///
    /// # Errors
    /// If a number of the configuration is outside its range or a bound is below 0.
    pub fn new(bounds: Bounds, config: OcConfig) -> Result<Self> {
        config.check()?;
        for (j, &lower) in bounds.lower().iter().enumerate() {
            check::within(&format!("lower bound[{j}]"), lower, lower >= 0.0, "[0, inf)")?;
        }
        let (work, next) = (Work::default(), Vec::new());
        Ok(Self { config, bounds, work, next, multiplier: 0.0, bisections: 0 })
    }

    /// The next densities, from the gradients at `x`.
    ///
    /// `volume` is called with every trial and returns its excess over the target, of which
    /// only the sign counts: physical densities (filtered, projected, passive) are its matter.
    /// All slices are `[n]`; without `dv` the volume's derivative is 1. Passive elements take
    /// their fixed value whatever their gradients are. The volume is met as closely as the
    /// rules' bisection ends: some digits, or not at all within one move limit.
    ///
    /// Cost: 30 to 50 bisections of O(n) and one call of `volume` each.
    ///
    /// # Errors
    /// If a length does not fit, a number or a volume is not finite, a density is outside its
    /// box, a `dv` is not above 0, or a `dc` is above 0 and the configuration has no floor.
    pub fn update(
        &mut self,
        x: &[f64],
        dc: &[f64],
        dv: Option<&[f64]>,
        mut volume: impl FnMut(&[f64]) -> f64,
    ) -> Result<&[f64]> {
        self.prepare(x, dc, dv)?;
        let Self { config, work, next, .. } = self;
        next.resize(x.len(), 0.0);
        let found = bisect(config, |multiplier| {
            work.write(config, x, multiplier, next);
            volume(next)
        })?;
        (self.multiplier, self.bisections) = found;
        Ok(&self.next)
    }

    /// As [`OptimalityCriteria::update`], for a volume that is the plain sum of the densities
    /// less `target`; the same bytes, several times faster.
    ///
    /// Most trials are not written but summed without roots, in parallel. Where the sum is so
    /// near to `target` that rounding might decide, `volume` is called as in `update`; it
    /// must be a sum in some order, less the same `target`.
    ///
    /// # Errors
    /// As [`OptimalityCriteria::update`], and if `target` is not finite.
    pub fn update_sum(
        &mut self,
        x: &[f64],
        dc: &[f64],
        dv: Option<&[f64]>,
        target: f64,
        mut volume: impl FnMut(&[f64]) -> f64,
    ) -> Result<&[f64]> {
        check::within("target", target, target.is_finite(), "(-inf, inf)")?;
        self.prepare(x, dc, dv)?;
        let Self { config, work, next, .. } = self;
        work.scale(config, x);
        next.resize(x.len(), 0.0);
        let found = bisect(config, |multiplier| {
            let [sum, doubt] = work.sum(config, multiplier);
            if (sum - target).abs() > doubt {
                return sum - target;
            }
            work.write(config, x, multiplier, next);
            volume(next)
        })?;
        work.write(config, x, found.0, next);
        (self.multiplier, self.bisections) = found;
        Ok(&self.next)
    }

    /// Lagrange multiplier of the last update, `[c]/[v]`; 0 before the first.
    pub fn multiplier(&self) -> f64 {
        self.multiplier
    }

    /// Bisections of the last update.
    pub fn bisections(&self) -> usize {
        self.bisections
    }

    fn prepare(&mut self, x: &[f64], dc: &[f64], dv: Option<&[f64]>) -> Result<()> {
        self.bounds.check(x)?;
        check::length("dc", dc, x.len())?;
        check::finite("dc", dc)?;
        if let Some(dv) = dv {
            check::length("dv", dv, x.len())?;
            check::finite("dv", dv)?;
        }
        self.work.prepare(&self.config, &self.bounds, x, dc, dv)
    }
}
