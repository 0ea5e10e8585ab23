//! The configuration of a run.

use super::growth::Growth;
use super::stepper::Precision;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use solvers::Boundary;
use solvers::diffusion::explicit::Stencil;
use std::collections::BTreeMap;

/// The kinetics whose rates the configuration writes out.
pub(super) const FORMULAS: &str = "formulas";

/// A complete configuration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Name of the kinetics, or `formulas`.
    pub kinetics: String,
    /// Cells along each axis: `[nx]`, `[ny, nx]`, `[nz, ny, nx]`, or one number for a square.
    pub size: Size,
    /// Time steps.
    pub iterations: u64,
    /// Time step.
    pub dt: f64,
    /// Neumann or periodic.
    pub boundary: Boundary,
    /// Precision of the concentrations.
    pub precision: Precision,
    /// Differences of the Laplacian; default nine-point, in 3D axes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stencil: Option<Stencil>,
    /// Method of time stepping.
    pub stepper: Method,
    /// Keeps concentrations from becoming negative.
    pub clamp: bool,
    /// Parameters of the kinetics: a number, or a map.
    pub parameters: BTreeMap<String, Source>,
    /// Diffusion of each species (cells^2/time).
    pub diffusion: BTreeMap<String, Diffusion>,
    /// Initial concentration of each species: a number, or a map.
    pub initial: BTreeMap<String, Source>,
    /// Changes to the parameters and initial concentrations, in order.
    pub perturbation: Vec<Perturbation>,
    /// Growth of the domain; absent: its size is fixed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub growth: Option<Growth>,
    /// Rates of each species as text, for kinetics `formulas`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub formulas: BTreeMap<String, String>,
    /// What counts as ink.
    pub ink: Ink,
    /// The curve that follows the pattern.
    pub curve: Curve,
    /// Iterations whose concentrations are kept.
    pub snapshots: Vec<u64>,
    /// Stops when under 0.2 % of the signs change in 100 iterations.
    pub stop_when_settled: bool,
    /// Adds growth rate against wavenumber and the predicted wavelength to the results.
    pub dispersion: bool,
}

/// Cells along each axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected a number of cells, or a list of 1 to 3 of them")]
pub enum Size {
    /// A square.
    Square(usize),
    /// Each axis.
    Axes(Vec<usize>),
}

/// Method of time stepping.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Forward Euler, several steps per pass through memory.
    Explicit,
    /// Diffusion implicit, in two stages of second order (ARS(2,2,2)).
    SemiImplicit,
    /// Diffusion exact, the reaction of fourth order (ETDRK4).
    Etdrk4,
}

/// Diffusion of a species.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "expected a number, a file name, { map = FILE, range = [LOW, HIGH] }, or \
                 { along = D, across = D, angle = DEGREES or a map }"
)]
pub enum Diffusion {
    /// The same coefficient everywhere or a map of it.
    Isotropic(Source),
    /// Two coefficients, along and across a direction.
    Anisotropic(Anisotropic),
}

/// Diffusion along and across a direction, which may be a map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Anisotropic {
    /// Coefficient along the direction (cells^2/time).
    pub along: f64,
    /// Coefficient across it (cells^2/time).
    pub across: f64,
    /// The direction (degrees from x towards y).
    pub angle: Source,
}

/// A number, or a value at each node from a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "expected a number, a file name, or { map = FILE, range = [LOW, HIGH] }"
)]
pub enum Source {
    /// The same everywhere.
    Number(f64),
    /// Values of a file.
    File(String),
    /// Values of a file, 0 mapped to the first and 1 to the second number.
    Scaled(Scaled),
}

/// A file whose values 0 and 1 stand for two others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scaled {
    /// File name.
    pub map: String,
    /// What 0 and 1 stand for.
    pub range: [f64; 2],
}

/// A change to a parameter or an initial concentration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Perturbation {
    /// Name of the parameter or species.
    pub target: String,
    /// What happens to it.
    pub kind: Change,
    /// How much.
    pub amplitude: f64,
    /// Where.
    pub region: Region,
    /// Width of the line, block, edge or squares (cells).
    #[serde(default = "one")]
    pub width: usize,
    /// Number of squares.
    #[serde(default = "one")]
    pub count: usize,
}

fn one() -> usize {
    1
}

/// What a perturbation does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Change {
    /// Adds a number that is uniform in [-amplitude, amplitude), another at each node.
    Noise,
    /// Adds the amplitude.
    Add,
    /// Sets the amplitude.
    Set,
}

/// Where a perturbation is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Region {
    /// Every node.
    All,
    /// Nodes whose every index is even.
    Even,
    /// The middle column, `width` cells wide.
    CenterLine,
    /// A block of side `width` in the middle.
    Block,
    /// The first `width` columns.
    Edge,
    /// `count` blocks of side `width` at random places.
    Squares,
}

/// Ink: the nodes on one side of a concentration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ink {
    /// The species.
    pub species: String,
    /// Concentration at the border of ink, or `mean`.
    pub level: Level,
    /// Whether ink is where the concentration is low.
    pub below: bool,
}

/// A concentration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected a number or \"mean\"")]
pub enum Level {
    /// Of that value.
    Value(f64),
    /// The mean over all nodes.
    Mean(Mean),
}

/// The word `mean`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mean {
    /// The mean over all nodes.
    Mean,
}

/// The curve of Algorithm 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Curve {
    /// Its speed.
    pub speed: CurveSpeed,
    /// `circle`, `border`, `seeds`, or an image whose dark half is inside.
    pub start: String,
    /// Closed lines to start from instead: a file of points x,y in cells from the picture's
    /// upper left corner, as `contour.csv`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contour: Option<String>,
    /// Time step of the curve per reaction step.
    pub dt: f64,
    /// Reaction steps between two redistancings.
    pub redistance_every: u64,
    /// Steps without the gradient's floor at the end.
    pub finish: u64,
}

/// Speed of the curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CurveSpeed {
    /// A smooth sign of the concentration's difference from its level; gradient at least 1.
    Recipe,
    /// The paper's: the Laplacian of the concentration (equation 1.16).
    Literal,
    /// No curve.
    Off,
}

impl Config {
    /// The axes of the grid.
    pub(super) fn axes(&self) -> Vec<usize> {
        match &self.size {
            Size::Square(n) => vec![*n, *n],
            Size::Axes(axes) => axes.clone(),
        }
    }

    /// Refuses values out of range.
    pub(super) fn check(&self) -> Result<()> {
        let positive = |key: &str, value: f64| {
            let good = value > 0.0 && value.is_finite();
            if good { Ok(()) } else { Err(Error::range(key, value, "(0, inf)")) }
        };
        positive("dt", self.dt)?;
        positive("curve.dt", self.curve.dt)?;
        if self.curve.dt > 1.0 {
            return Err(Error::range("curve.dt", self.curve.dt, "(0, 1]"));
        }
        if self.iterations == 0 || self.iterations > 1 << 40 {
            return Err(Error::range("iterations", self.iterations as f64, "[1, 2^40]"));
        }
        if self.curve.redistance_every == 0 {
            return Err(Error::range("curve.redistance_every", 0.0, "[1, inf)"));
        }
        if self.boundary == Boundary::Extrapolate {
            return Err(Error::config(
                "boundary",
                "expected neumann or periodic, found extrapolate",
            ));
        }
        if let Some(&late) = self.snapshots.iter().find(|&&n| n > self.iterations) {
            let range = format!("[0, iterations = {}]", self.iterations);
            return Err(Error::range("snapshots", late as f64, &range));
        }
        for (index, change) in self.perturbation.iter().enumerate() {
            let key = |name: &str| format!("perturbation[{index}].{name}");
            if !change.amplitude.is_finite() {
                return Err(Error::range(&key("amplitude"), change.amplitude, "(-inf, inf)"));
            }
            if change.width == 0 {
                return Err(Error::range(&key("width"), 0.0, "[1, inf)"));
            }
        }
        Ok(())
    }
}
