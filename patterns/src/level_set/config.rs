//! Configuration of the `level-set` model.

use super::shape::ShapeConfig;
use crate::{Context, Error, Result};
use serde::{Deserialize, Serialize};
use solvers::{
    Boundary, Field, Grid,
    level_set::{self, Order, Scheme, Speed},
};

/// Parameters of a run; lengths in cells.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Nodes `[ny, nx]` or `[nz, ny, nx]`; taken from the image if there is one.
    pub size: Vec<usize>,
    /// The front at the start: a shape by its name, which fills 60 % of the grid, or in full.
    pub shape: ShapeConfig,
    /// A grey picture or array whose region below `level` is inside, instead of a shape.
    pub image: Option<String>,
    /// Grey level of the front in the picture.
    pub level: f64,
    /// A file of closed lines instead of a shape: points x,y in cells from the picture's upper
    /// left corner, as `contour.csv`.
    pub contour: Option<String>,
    /// Shapes that are added to the front, then cut to, then taken away.
    pub union: Vec<ShapeConfig>,
    /// Shapes that the front is cut to.
    pub intersect: Vec<ShapeConfig>,
    /// Shapes that are taken away from the front.
    pub subtract: Vec<ShapeConfig>,
    /// The speeds that are added up.
    pub speed: Vec<SpeedConfig>,
    /// Time at the end.
    pub time: f64,
    /// Slices of the time; each is a frame, an observation, a possible checkpoint.
    pub iterations: u64,
    /// Differences: `first` or `weno5`.
    pub order: Order,
    /// `neumann`, `periodic` or `extrapolate`.
    pub boundary: Boundary,
    /// Fraction of the largest stable time step, in (0, 1].
    pub cfl: f64,
    /// Slices between two redistancings, 0 for none.
    pub redistance_every: u64,
    /// Least |grad phi| in the speed term; the front can then nucleate.
    pub gradient_floor: Option<f64>,
    /// Bound on |phi|.
    pub clip: Option<f64>,
    /// Half-width of the narrow band that moves, at least 6.
    pub band: Option<f64>,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            size: vec![200, 200],
            shape: ShapeConfig::Name("star".into()),
            image: None,
            level: 0.5,
            contour: None,
            union: Vec::new(),
            intersect: Vec::new(),
            subtract: Vec::new(),
            speed: vec![SpeedConfig::Curvature { coefficient: 1.0 }],
            time: 500.0,
            iterations: 200,
            order: Order::Weno5,
            boundary: Boundary::Neumann,
            cfl: 0.5,
            redistance_every: 10,
            gradient_floor: None,
            clip: None,
            band: None,
        }
    }
}

/// A built-in speed.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum SpeedConfig {
    /// The same normal speed everywhere (cells/time, positive outwards).
    Constant {
        /// Speed.
        value: f64,
    },
    /// Motion by curvature: normal speed `-b kappa`.
    Curvature {
        /// b (cells^2/time).
        coefficient: f64,
    },
    /// Normal speed from a picture or array.
    Image {
        /// The file.
        path: String,
        /// Speed at grey level 0, or what is added to an array.
        low: f64,
        /// Speed at grey level 1.
        high: f64,
    },
    /// Carried along by a constant velocity.
    Translation {
        /// `[vx, vy]` or `[vx, vy, vz]` (cells/time).
        velocity: Vec<f64>,
    },
    /// Carried along by a rotation about the middle of the grid, in the x-y plane.
    Rotation {
        /// Angular speed (radians/time), positive from x to y.
        rate: f64,
    },
    /// The single vortex of Rider and Kothe on the unit square stretched over the
    /// grid, reversed at half of `period`: stream function
    /// `sin^2(pi x) sin^2(pi y) cos(pi t / period) / pi`.
    Vortex {
        /// Time after which the exact front is back at its start.
        period: f64,
    },
}

impl Config {
    /// The scheme of the engine.
    pub(super) fn scheme(&self) -> Scheme {
        Scheme {
            order: self.order,
            boundary: self.boundary,
            cfl: self.cfl,
            gradient_floor: self.gradient_floor,
            clip: self.clip,
            band: self.band,
        }
    }

    /// Whether shapes are combined with the front.
    pub(super) fn combines(&self) -> bool {
        [&self.union, &self.intersect, &self.subtract].into_iter().any(|shapes| !shapes.is_empty())
    }

    /// Refuses values out of range.
    pub(super) fn check(&self) -> Result<()> {
        if !(2..=3).contains(&self.size.len()) {
            return Err(Error::range("size", self.size.len() as f64, "2 or 3 axes"));
        }
        if let Some(&n) = self.size.iter().find(|&&n| n < 4) {
            return Err(Error::range("size", n as f64, "[4, inf)"));
        }
        if !(self.time > 0.0 && self.time.is_finite()) {
            return Err(Error::range("time", self.time, "(0, inf)"));
        }
        if !(1..=10_000_000).contains(&self.iterations) {
            return Err(Error::range("iterations", self.iterations as f64, "[1, 10000000]"));
        }
        if self.image.is_some() && self.contour.is_some() {
            return Err(Error::config("contour", "the front is a picture's already; give one"));
        }
        if self.speed.is_empty() {
            return Err(Error::config("speed", "there is none; give at least one"));
        }
        if let Some(band) = self.band.filter(|&band| !(band >= 6.0 && band.is_finite())) {
            return Err(Error::range("band", band, "[6, inf)"));
        }
        if !self.level.is_finite() {
            return Err(Error::range("level", self.level, "(-inf, inf)"));
        }
        self.scheme().check().map_err(|error| match error {
            solvers::Error::OutOfRange { name, value, range } => Error::range(&name, value, &range),
            other => other.into(),
        })
    }

    /// The speeds, as the engine takes them.
    pub(super) fn speeds(&self, grid: Grid, context: &Context<'_>) -> Result<Vec<Box<dyn Speed>>> {
        let build = |(n, speed): (usize, &SpeedConfig)| speed.build(n, grid, context);
        self.speed.iter().enumerate().map(build).collect()
    }
}

impl SpeedConfig {
    fn build(&self, n: usize, grid: Grid, context: &Context<'_>) -> Result<Box<dyn Speed>> {
        let key = |name: &str| format!("speed.{n}.{name}");
        let finite = |name: &str, value: f64| {
            if value.is_finite() {
                Ok(value)
            } else {
                Err(Error::range(&key(name), value, "(-inf, inf)"))
            }
        };
        let [cx, cy, _] = grid.center();
        Ok(match self {
            Self::Constant { value } => {
                Box::new(level_set::ConstantSpeed(finite("value", *value)?))
            }
            Self::Curvature { coefficient } => {
                if !(*coefficient > 0.0 && coefficient.is_finite()) {
                    return Err(Error::range(&key("coefficient"), *coefficient, "(0, inf)"));
                }
                Box::new(level_set::CurvatureSpeed::new(*coefficient))
            }
            Self::Image { path, low, high } => {
                let (low, high) = (finite("low", *low)?, finite("high", *high)?);
                let mut field = context.inputs.field(&key("path"), path)?;
                field
                    .check_shape(path, grid)
                    .map_err(|error| Error::config(&key("path"), error.to_string()))?;
                field.as_mut_slice().iter_mut().for_each(|v| *v = low + (high - low) * *v);
                Box::new(level_set::FieldSpeed(field))
            }
            Self::Translation { velocity } => {
                if velocity.len() != grid.dim() || velocity.iter().any(|v| !v.is_finite()) {
                    let reason = format!("{velocity:?} should be {} finite numbers", grid.dim());
                    return Err(Error::config(&key("velocity"), reason));
                }
                let v = [0, 1, 2].map(|axis| velocity.get(axis).copied().unwrap_or(0.0));
                Box::new(level_set::FnAdvection(move |_, _| v))
            }
            Self::Rotation { rate } => {
                let rate = finite("rate", *rate)?;
                Box::new(level_set::FnAdvection(move |[x, y, _]: [f64; 3], _| {
                    [-rate * (y - cy), rate * (x - cx), 0.0]
                }))
            }
            Self::Vortex { period } => {
                if !(*period > 0.0 && period.is_finite()) {
                    return Err(Error::range(&key("period"), *period, "(0, inf)"));
                }
                Box::new(level_set::FnAdvection(vortex(grid, *period)))
            }
        })
    }
}

/// Velocity of the single vortex, scaled from the unit square to the grid.
fn vortex(grid: Grid, period: f64) -> impl Fn([f64; 3], f64) -> [f64; 3] + Sync + Send {
    use std::f64::consts::PI;
    let [_, ny, nx] = grid.shape().map(|n| n as f64 * grid.spacing());
    move |[x, y, _], t| {
        let (x, y) = ((x + 0.5) / nx * PI, (y + 0.5) / ny * PI);
        let back = (PI * t / period).cos();
        let u = -x.sin().powi(2) * (2.0 * y).sin() * back;
        let v = y.sin().powi(2) * (2.0 * x).sin() * back;
        [u * nx, v * ny, 0.0]
    }
}

/// phi of the front at the start: negative where the picture is darker than `level`.
pub(super) fn below(mut image: Field, level: f64) -> Field {
    image.as_mut_slice().iter_mut().for_each(|v| *v -= level);
    image
}
