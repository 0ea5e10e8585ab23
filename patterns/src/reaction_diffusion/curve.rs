//! The curve of Algorithm 1: a level set that follows the border of the ink.
//!
//! | symbol | code    | meaning                                       | unit          |
//! |--------|---------|-----------------------------------------------|---------------|
//! | phi    | `phi`   | level set, negative in the ink                | cells         |
//! | beta   | `beta`  | speed of the curve, positive where ink grows  | cells/step    |
//! | c      | `c`     | concentration whose border is followed        | concentration |
//! | m, s   | `level`, `width` | its level at the border, .25 of its standard deviation | concentration |
//!
//! The paper's speed, the Laplacian of b (1.16), agrees with `m - b` up to a factor
//! only while the pattern is linear; afterwards it tracks inflection contours, and a
//! level set cannot nucleate. [`CurveSpeed::Recipe`] therefore departs from the paper:
//! `beta = d / sqrt(d^2 + s^2)` with `d = m - c`, |grad phi| raised to at least 1 and
//! |phi| kept to at most 3, redistanced now and then. Steps without the floor and a last
//! redistancing end a run.

use super::config::{self, CurveSpeed};
use crate::{Result, State};
use solvers::level_set::{LevelSet, Order, Redistance, RedistanceOptions, Scheme, Speed, Terms};
use solvers::{Boundary, Field};

/// Bound on |phi| (cells): a node that changes sides must cross it between two redistancings.
const CLIP: f64 = 3.0;

/// Share of the standard deviation over which the speed changes its sign.
const WIDTH: f64 = 0.25;

/// Steps between two redistancings while the curve settles between the nodes.
const FINISH_EVERY: u64 = 5;

/// What the curve follows in one step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Border<'a> {
    /// The concentration.
    pub(super) c: &'a Field,
    /// Its level at the border; `None`: its mean.
    pub(super) level: Option<f64>,
    /// Whether ink is where the concentration is low.
    pub(super) below: bool,
}

impl Border<'_> {
    /// Level of the border, and standard deviation of the concentration.
    pub(super) fn level_std(&self) -> (f64, f64) {
        let (mean, std) = self.c.mean_std();
        (self.level.unwrap_or(mean), std)
    }

    /// Whether a concentration is ink.
    pub(super) fn is_ink(&self, c: f64, level: f64) -> bool {
        (c < level) == self.below
    }
}

/// The level set and its work space.
pub(super) struct Curve {
    front: LevelSet,
    redistance: Redistance,
    speed: CurveSpeed,
    dt: f64,
    every: u64,
    steps: u64,
    /// Signs at the last call of [`Curve::changed_signs`].
    inside: Vec<bool>,
}

/// beta, on loan to the engine for one step.
struct Beta<'a> {
    border: Border<'a>,
    speed: CurveSpeed,
    boundary: Boundary,
}

impl Speed for Beta<'_> {
    fn add(&mut self, _: &Field, _: f64, terms: &mut Terms) -> solvers::Result<()> {
        let (level, std) = self.border.level_std();
        let beta = terms.normal().as_mut_slice();
        let side = if self.border.below { 1.0 } else { -1.0 };
        match self.speed {
            CurveSpeed::Literal => add_laplacian(self.border.c, self.boundary, side, beta),
            CurveSpeed::Recipe | CurveSpeed::Off => {
                // Adding the least positive number leaves 0 for a flat concentration, not NaN.
                let width = (WIDTH * std).powi(2) + f64::MIN_POSITIVE;
                for (beta, c) in beta.iter_mut().zip(self.border.c.as_slice()) {
                    let d = side * (level - c);
                    *beta += d / (d * d + width).sqrt();
                }
            }
        }
        Ok(())
    }
}

/// Adds `factor` times the nine-point Laplacian, which the reaction uses too.
fn add_laplacian(c: &Field, boundary: Boundary, factor: f64, beta: &mut [f64]) {
    let [nz, ny, nx] = c.grid().shape();
    let row = |k: usize, j: isize| {
        let j = boundary.wrap(j, ny);
        &c.as_slice()[(k * ny + j) * nx..][..nx]
    };
    for k in 0..nz {
        for j in 0..ny {
            let [north, center, south] = [-1, 0, 1].map(|d| row(k, j as isize + d));
            for i in 0..nx {
                let [west, east] = [-1, 1].map(|d| boundary.wrap(i as isize + d, nx));
                let sides = north[i] + south[i] + center[west] + center[east];
                let corners = north[west] + north[east] + south[west] + south[east];
                let laplacian = (4.0 * sides + corners - 20.0 * center[i]) / 6.0;
                beta[(k * ny + j) * nx + i] += factor * laplacian;
            }
        }
    }
}

impl Curve {
    /// Starts from the curve `phi = 0`.
    pub(super) fn new(mut phi: Field, boundary: Boundary, config: &config::Curve) -> Result<Self> {
        let band = (config.speed == CurveSpeed::Recipe).then_some(CLIP);
        let grid = phi.grid();
        let mut redistance = Redistance::new(grid, RedistanceOptions { boundary, band })?;
        redistance.apply(&mut phi)?;
        let inside = phi.as_slice().iter().map(|&v| v < 0.0).collect();
        let floor = (config.speed == CurveSpeed::Recipe).then_some(1.0);
        let front = LevelSet::new(phi, scheme(boundary, floor, band))?;
        let (dt, every) = (config.dt, config.redistance_every);
        Ok(Self { front, redistance, speed: config.speed, dt, every, steps: 0, inside })
    }

    /// One step towards the border, and a redistancing when it is due.
    pub(super) fn step(&mut self, border: Border<'_>) -> Result<()> {
        self.move_front(border)?;
        self.steps += 1;
        if self.steps.is_multiple_of(self.every) {
            self.redistance.apply(self.front.phi_mut())?;
        }
        Ok(())
    }

    fn move_front(&mut self, border: Border<'_>) -> Result<()> {
        let boundary = self.front.scheme().boundary;
        let mut beta = Beta { border, speed: self.speed, boundary };
        match self.speed {
            // |beta| < 1: this step is stable as it is.
            CurveSpeed::Recipe => self.front.step(&mut beta, self.dt)?,
            _ => {
                self.front.advance(&mut beta, self.dt)?;
            }
        }
        Ok(())
    }

    /// `steps` steps towards a resting border without the floor on the gradient, redistanced
    /// every few so that phi stays straight across the curve, whose place between the
    /// nodes then settles where beta = 0; at the end a redistancing over the whole grid.
    pub(super) fn finish(&mut self, border: Border<'_>, steps: u64) -> Result<()> {
        let boundary = self.front.scheme().boundary;
        self.front.set_scheme(scheme(boundary, None, self.front.scheme().clip))?;
        for n in 1..=steps {
            self.move_front(border)?;
            if n.is_multiple_of(FINISH_EVERY) {
                self.redistance.apply(self.front.phi_mut())?;
            }
        }
        let grid = self.front.phi().grid();
        let options = RedistanceOptions { boundary, band: None };
        Redistance::new(grid, options)?.apply(self.front.phi_mut())?;
        Ok(())
    }

    /// The level set, negative in the ink.
    pub(super) fn phi(&self) -> &Field {
        self.front.phi()
    }

    /// Share of the nodes that changed sides since the last call.
    pub(super) fn changed_signs(&mut self) -> f64 {
        let phi = self.front.phi().as_slice();
        let mut changed = 0;
        for (inside, &v) in self.inside.iter_mut().zip(phi) {
            changed += usize::from(std::mem::replace(inside, v < 0.0) != (v < 0.0));
        }
        changed as f64 / phi.len() as f64
    }

    /// Adds the curve to a checkpoint.
    pub(super) fn save(&self, state: &mut State) {
        state.put_f64("curve.phi", self.front.phi().as_slice());
        state.put_f64("curve.time", &[self.front.time()]);
        state.put_u64("curve.steps", &[self.steps]);
        state.put_u8("curve.inside", &self.inside.iter().map(|&v| u8::from(v)).collect::<Vec<_>>());
    }

    /// Takes the curve from a checkpoint.
    pub(super) fn restore(&mut self, state: &State) -> Result<()> {
        let mut time = [0.0];
        state.get_f64("curve.time", &mut time)?;
        state.get_f64("curve.phi", self.front.phi_mut().as_mut_slice())?;
        self.front.set_time(time[0]);
        self.steps = state.all_u64("curve.steps")?.first().copied().unwrap_or(0);
        self.inside = state.all_u8("curve.inside")?.iter().map(|&v| v != 0).collect();
        Ok(())
    }
}

fn scheme(boundary: Boundary, gradient_floor: Option<f64>, clip: Option<f64>) -> Scheme {
    Scheme { order: Order::First, boundary, gradient_floor, clip, ..Scheme::default() }
}
