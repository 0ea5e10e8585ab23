//! Time stepping of a front.

use super::{
    Order, Scheme, Speed, Terms,
    band::Band,
    ghost::Padded,
    speed::Parts,
    stage::{self, Stage},
};
use crate::{Error, Field, Result};

/// A front `phi = 0` and its time; `phi < 0` inside.
///
/// ```
/// use solvers::level_set::{ConstantSpeed, LevelSet, Scheme};
/// use solvers::{Field, Grid};
///
/// let grid = Grid::new(&[64, 64], 1.0)?;
/// let disk = Field::from_fn(grid, |[x, y, _]| (x - 32.0).hypot(y - 32.0) - 10.0);
/// let mut front = LevelSet::new(disk, Scheme::default())?;
/// while front.time() < 5.0 {
///     front.advance(&mut ConstantSpeed(1.0), 5.0 - front.time())?;
/// }
/// // The radius has grown from 10 to 15.
/// assert!(front.phi().at(0, 32, 32 + 14) < 0.0 && front.phi().at(0, 32, 32 + 16) > 0.0);
/// # Ok::<(), solvers::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct LevelSet {
    phi: Field,
    t: f64,
    scheme: Scheme,
    terms: Terms,
    padded: Padded,
    /// The next state; outside a band equal to `phi`.
    next: Field,
    band: Option<Band>,
    /// Whether the band must be laid anew.
    stale: bool,
}

impl LevelSet {
    /// Starts at t = 0 from `phi` (length), best a signed distance.
    ///
    /// # Errors
    /// If the scheme is out of range ([`Scheme::check`]) or phi is not finite.
    pub fn new(phi: Field, scheme: Scheme) -> Result<Self> {
        scheme.check()?;
        phi.check_finite("phi", 0.0)?;
        let padded = Padded::new(phi.grid(), scheme.ghosts(), scheme.boundary);
        let (terms, next) = (Terms::new(phi.grid()), phi.clone());
        Ok(Self { phi, t: 0.0, scheme, terms, padded, next, band: None, stale: true })
    }

    /// The level-set function (length).
    pub fn phi(&self) -> &Field {
        &self.phi
    }

    /// The level-set function for writing, e.g. for redistancing. A narrow band
    /// is laid anew before the next step.
    pub fn phi_mut(&mut self) -> &mut Field {
        self.stale = true;
        &mut self.phi
    }

    /// Time since the start.
    pub fn time(&self) -> f64 {
        self.t
    }

    /// Sets the time, as when a stored front is taken up again.
    pub fn set_time(&mut self, t: f64) {
        self.t = t;
    }

    /// How the front is advanced.
    pub fn scheme(&self) -> &Scheme {
        &self.scheme
    }

    /// Advances by another scheme from now on, e.g. without the gradient floor.
    ///
    /// # Errors
    /// As [`Scheme::check`]; the old scheme then stays.
    pub fn set_scheme(&mut self, scheme: Scheme) -> Result<()> {
        scheme.check()?;
        self.padded = Padded::new(self.phi.grid(), scheme.ghosts(), scheme.boundary);
        self.scheme = scheme;
        self.stale = true;
        Ok(())
    }

    /// Advances by the largest stable step, at most `dt_max`, and returns it:
    /// `dt = cfl / max(S / h + 2 dim b / h^2)` with
    /// `S = sqrt(dim) |beta| + |vx| + |vy| + |vz|`.
    ///
    /// # Errors
    /// As [`Self::step`]; `dt_max` must be positive and finite.
    pub fn advance(&mut self, speed: &mut dyn Speed, dt_max: f64) -> Result<f64> {
        check_positive("dt_max", dt_max)?;
        self.prepare(speed)?;
        let rate = stage::fastest(self.phi.grid(), self.terms.parts(), self.band.as_ref());
        let dt = dt_max.min(self.scheme.cfl / rate);
        self.take(speed, dt)?;
        Ok(dt)
    }

    /// Advances by one step of exactly `dt`, stable or not.
    ///
    /// # Errors
    /// [`Error::NotFinite`] where and when phi blows up (phi is then still the one
    /// before the step), [`Error::OutOfRange`] if `dt` is not positive and finite or
    /// a curvature coefficient is negative, and any error of `speed`.
    pub fn step(&mut self, speed: &mut dyn Speed, dt: f64) -> Result<()> {
        check_positive("dt", dt)?;
        self.prepare(speed)?;
        self.take(speed, dt)
    }

    /// Lays the band if need be and asks for the speed at the start of the step.
    fn prepare(&mut self, speed: &mut dyn Speed) -> Result<()> {
        if std::mem::take(&mut self.stale) {
            self.band = self.scheme.band.map(|width| Band::lay(&self.phi, width));
            if self.band.is_some() {
                self.padded.load(self.phi.as_slice());
                self.next.copy_from(&self.phi);
            }
        }
        self.terms.clear();
        speed.add(&self.phi, self.t, &mut self.terms)?;
        check_curvature(self.terms.parts())
    }

    /// One step whose first speed is known. Shu & Osher 1988, eq. (2.18).
    fn take(&mut self, speed: &mut dyn Speed, dt: f64) -> Result<()> {
        self.stage([0.0, 1.0], dt, true)?;
        if self.scheme.order == Order::Weno5 {
            for (weights, t) in [([0.75, 0.25], dt), ([1.0 / 3.0, 2.0 / 3.0], 0.5 * dt)] {
                self.terms.clear();
                speed.add(&self.next, self.t + t, &mut self.terms)?;
                check_curvature(self.terms.parts())?;
                self.stage(weights, dt, false)?;
            }
        }
        std::mem::swap(&mut self.phi, &mut self.next);
        self.t += dt;
        Ok(())
    }

    /// `next = weights[0] phi + weights[1] (u + dt rate(u))`, where u is phi in the
    /// first stage and the previous `next` in the others.
    fn stage(&mut self, weights: [f64; 2], dt: f64, first: bool) -> Result<()> {
        let source = if first { &self.phi } else { &self.next };
        match &self.band {
            None => self.padded.load(source.as_slice()),
            Some(band) => self.padded.load_intervals(source.as_slice(), band.rows()),
        }
        let stage = Stage {
            grid: self.phi.grid(),
            scheme: &self.scheme,
            padded: &self.padded,
            parts: self.terms.parts(),
            band: self.band.as_ref(),
            start: self.phi.as_slice(),
            weights,
            dt,
        };
        if stage.run(self.next.as_mut_slice()) {
            return Ok(());
        }
        self.next.check_finite("phi", self.t)
    }
}

fn check_positive(name: &str, value: f64) -> Result<()> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(Error::out_of_range(name, value, "(0, inf)"))
}

/// Backward motion by curvature has no solution: every wrinkle would grow without bound.
fn check_curvature(parts: Parts<'_>) -> Result<()> {
    let negative = parts.curvature.and_then(|b| b.iter().find(|&&b| b < 0.0));
    negative.map_or(Ok(()), |&b| Err(Error::out_of_range("curvature coefficient", b, "[0, inf)")))
}
