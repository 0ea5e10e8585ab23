//! The configuration of a run: defaults, presets, and what the user says, in that order.

use super::kinetics;
use super::stepper::Precision;
use crate::{Error, Preset, Result};
use serde::{Deserialize, Serialize};
use solvers::Boundary;
use solvers::diffusion::GrowthLaw;
use solvers::diffusion::explicit::Stencil;
use std::collections::BTreeMap;

/// What every run starts from.
const COMMON: &str = r#"
size = [80, 80]
iterations = 8000
dt = 1.0
boundary = "neumann"
precision = "f64"
stepper = "explicit"
clamp = true
snapshots = []
stop_when_settled = false
dispersion = false
perturbation = []
parameters = {}
diffusion = {}
initial = {}

[curve]
speed = "recipe"
start = "circle"
dt = 0.45
redistance_every = 20
finish = 200
"#;

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

/// Growth of the domain, the same in all directions and places: cells grow, their number stays.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Growth {
    /// How the length L depends on time.
    #[serde(default)]
    pub law: Law,
    /// Growth rate of L / L(0) at time 0 (1/time).
    pub rate: f64,
    /// L / L(0) at which logistic growth ends, above 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit: Option<f64>,
    /// Whether growth dilutes the concentrations.
    #[serde(default = "yes")]
    pub dilution: bool,
}

/// How the length of a growing domain depends on time, at growth rate r.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Law {
    /// `exp(r t)`.
    #[default]
    Exponential,
    /// `1 + r t`.
    Linear,
    /// `m / (1 + (m - 1) exp(-r t))`, m the limit.
    Logistic,
}

fn yes() -> bool {
    true
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

/// Lays `over` on `base`: tables key by key, anything else as a whole.
fn lay(base: &mut toml::Table, over: &toml::Table) {
    for (key, value) in over {
        match (base.get_mut(key), value) {
            (Some(toml::Value::Table(base)), toml::Value::Table(over)) => lay(base, over),
            _ => {
                base.insert(key.clone(), value.clone());
            }
        }
    }
}

fn parse(text: &str) -> Result<toml::Table> {
    text.parse().map_err(|e: toml::de::Error| Error::config("preset", e.to_string()))
}

/// The configuration that `user` asks for: [`COMMON`], then the defaults of a kinetics,
/// then a preset, then `user`'s own keys. The preset is the one under the key `preset`,
/// else the first of the kinetics, else the first of all.
pub(super) fn resolve(user: &toml::Table) -> Result<Config> {
    let mut user = user.clone();
    let text = |key: &str, value: &toml::Value| {
        value.as_str().map(str::to_owned).ok_or_else(|| {
            Error::config(key, format!("expected a name, found {}", value.type_str()))
        })
    };
    let preset = user.remove("preset").map(|v| text("preset", &v)).transpose()?;
    let named = user.get("kinetics").map(|v| text("kinetics", v)).transpose()?;
    let mut table = parse(COMMON)?;
    if let Some((kinetics, preset)) = beginning(preset.as_deref(), named.as_deref())? {
        lay(&mut table, &parse(kinetics.defaults)?);
        lay(&mut table, &parse(preset.config)?);
    }
    // A table of the preset that the user replaces by something else is replaced whole.
    lay(&mut table, &user);
    let config: Config = crate::from_table(&table)?;
    config.check()?;
    Ok(config)
}

/// The kinetics and the preset that a configuration begins with; none for formulas.
fn beginning(
    preset: Option<&str>,
    named: Option<&str>,
) -> Result<Option<(&'static kinetics::Kinetics, &'static Preset)>> {
    let all = || kinetics::KINETICS.iter().flat_map(|k| k.presets.iter().map(move |p| (*k, p)));
    let Some(name) = preset else {
        return match named {
            Some(FORMULAS) => Ok(None),
            Some(name) => {
                let kinetics = lookup(name)?;
                Ok(kinetics.presets.first().map(|preset| (kinetics, preset)))
            }
            None => Ok(all().next()),
        };
    };
    let Some((kinetics, preset)) = all().find(|(_, preset)| preset.name == name) else {
        let known: Vec<_> = all().map(|(_, preset)| preset.name).collect();
        return Err(Error::config("preset", format!("no `{name}`; known: {}", known.join(", "))));
    };
    if let Some(named) = named.filter(|&named| named != kinetics.name) {
        let reason = format!("`{named}` does not go with preset `{name}` of `{}`", kinetics.name);
        return Err(Error::config("kinetics", reason));
    }
    Ok(Some((kinetics, preset)))
}

/// The kinetics of that name, or an error that lists the known ones.
pub(super) fn lookup(name: &str) -> Result<&'static kinetics::Kinetics> {
    kinetics::find(name).ok_or_else(|| {
        let known: Vec<_> = kinetics::KINETICS.iter().map(|k| k.name).collect();
        let reason = format!("no `{name}`; known: {}, formulas", known.join(", "));
        Error::config("kinetics", reason)
    })
}

/// More than any grid has cells for: a pattern of one wave has none left there.
const GREATEST_SCALE: f64 = 1000.0;

impl Growth {
    /// As the solvers want it.
    fn law(&self) -> Result<solvers::diffusion::Growth> {
        let law = match (self.law, self.limit) {
            (Law::Exponential, None) => GrowthLaw::Exponential,
            (Law::Linear, None) => GrowthLaw::Linear,
            (Law::Logistic, Some(limit)) => GrowthLaw::Logistic { limit },
            (Law::Logistic, None) => {
                return Err(Error::config("growth.limit", "logistic growth needs one, above 1"));
            }
            (_, Some(_)) => {
                let reason = "only logistic growth ends at one";
                return Err(Error::config("growth.limit", reason));
            }
        };
        solvers::diffusion::Growth::new(law, self.rate).map_err(|error| match error {
            solvers::Error::OutOfRange { name, value, range } => {
                Error::range(&format!("growth.{name}"), value, &range)
            }
            other => other.into(),
        })
    }
}

impl Config {
    /// The growth of the domain, if it grows.
    pub(super) fn growth(&self) -> Result<Option<solvers::diffusion::Growth>> {
        let Some(growth) = &self.growth else { return Ok(None) };
        let law = growth.law()?;
        let end = law.scale(self.dt * self.iterations as f64);
        if end > GREATEST_SCALE || end.is_nan() {
            let reason = format!(
                "{} makes the domain {end:.3e} times as long by the end, at most {GREATEST_SCALE}",
                growth.rate
            );
            return Err(Error::config("growth.rate", reason));
        }
        if self.dispersion {
            let reason = "linear theory is for a domain of one size; leave out growth";
            return Err(Error::config("dispersion", reason));
        }
        Ok(Some(law))
    }

    /// The axes of the grid.
    pub(super) fn axes(&self) -> Vec<usize> {
        match &self.size {
            Size::Square(n) => vec![*n, *n],
            Size::Axes(axes) => axes.clone(),
        }
    }

    fn check(&self) -> Result<()> {
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
