//! The configuration of a run.

use super::Interpretable;
use super::flow::OpenedConfig;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// A complete configuration. Lengths are in the units of `spacing` unless they say voxels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// Voxels `[nz, ny, nx]`, or one number for a cube.
    pub size: Size,
    /// Width of a voxel.
    pub spacing: f64,
    /// Width of the phase transition.
    pub epsilon: f64,
    /// `[a20, a11, a02, b10, b01, c]` of equation (20).
    pub coefficients: Option<[f64; 6]>,
    /// The same as squares, equation (26).
    pub squares: Option<Interpretable>,
    /// Mean of the phase, in (-1, 1): volume fraction `(1 + mass) / 2`.
    pub mass: f64,
    /// Coefficients and mass that vary along an axis.
    pub along: Option<Along>,
    /// A penalty on normals along a direction.
    pub orientation: Option<Orientation>,
    /// What lies beyond the box.
    pub boundary: Boundary,
    /// An array whose voxels above 0.5 the shape must contain.
    pub include: Option<String>,
    /// An array whose voxels above 0.5 the shape must avoid.
    pub exclude: Option<String>,
    /// Where the flow starts.
    pub start: Start,
    /// Method of descent.
    pub flow: Flow,
    /// Evaluations of the energy; the flow may stop before.
    pub evaluations: u64,
    /// Those of the published flow at the beginning of the fast one from noise, below
    /// `evaluations`; absent: a quarter of them, at most 200.
    pub opening: Option<u64>,
    /// Step of the method; absent: the method's own.
    pub rate: Option<f64>,
    /// Standard deviation of the blur (voxels); 0: none.
    pub blur: f64,
    /// Precision of the fields; sums are always in 64 bits.
    pub precision: Precision,
    /// The flow ends when the energy changes by less than this fraction in 50 evaluations.
    pub tolerance: f64,
    /// Level of the surface that is measured and written.
    pub level: f64,
    /// Pictures of a film around the final shape; 0: none.
    pub turntable: usize,
}

/// Voxels along each axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected a number of voxels, or a list of 3 of them")]
pub enum Size {
    /// A cube.
    Cube(usize),
    /// `[nz, ny, nx]`.
    Axes([usize; 3]),
}

/// Coefficients and mass at places along an axis, interpolated linearly and periodically.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Along {
    /// `x`, `y` or `z`.
    pub axis: Axis,
    /// The places, in increasing order.
    pub stops: Vec<Stop>,
}

/// Coefficients and mass at a place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stop {
    /// Place along the axis, 0 to 1.
    pub at: f64,
    /// As [`Config::coefficients`].
    pub coefficients: [f64; 6],
    /// As [`Config::mass`].
    pub mass: f64,
}

/// An axis of the box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    /// The last axis of the arrays.
    X,
    /// The middle axis of the arrays.
    Y,
    /// The first axis of the arrays.
    Z,
}

/// Adds `weight epsilon (direction . grad u)^2`: surfaces turn parallel to the direction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Orientation {
    /// mu.
    pub weight: f64,
    /// theta `[x, y, z]`, of any length above 0.
    pub direction: Option<[f64; 3]>,
    /// theta as three arrays x, y, z in place of one direction.
    pub field: Option<[String; 3]>,
}

/// What lies beyond the box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Boundary {
    /// The box again.
    #[default]
    Periodic,
    /// The outermost voxels again.
    Replicated,
    /// Nothing: only voxels with all their neighbours count.
    Free,
}

/// Where the flow starts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Start {
    /// The divergence of independent uniform numbers, as in the paper.
    #[default]
    Noise,
    /// A ball.
    Sphere {
        /// Radius.
        radius: f64,
    },
    /// Boxes in a row along x, each with a hole along z.
    HoledBoxes {
        /// Number of boxes, and of holes.
        count: usize,
        /// Half a box's width.
        half_width: f64,
        /// Half a hole's width.
        half_hole: f64,
    },
    /// A phase from a file, of the size of the box.
    File {
        /// The array.
        path: String,
    },
}

/// Methods of descent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Flow {
    /// Adam in a spectrally preconditioned variable; the mass is kept.
    #[default]
    Fast,
    /// The paper's: the H^-1 flow through a vector potential, by Adam.
    Paper,
    /// L-BFGS, the mass free.
    L2,
    /// L-BFGS, the mass kept.
    L2Mass,
}

/// Precision of the fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Precision {
    /// 32 bits.
    #[default]
    F32,
    /// 64 bits.
    F64,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            size: Size::Cube(100),
            spacing: 0.01,
            epsilon: 0.02,
            coefficients: None,
            squares: None,
            mass: -0.6,
            along: None,
            orientation: None,
            boundary: Boundary::default(),
            include: None,
            exclude: None,
            start: Start::default(),
            flow: Flow::default(),
            evaluations: 800,
            opening: None,
            rate: None,
            blur: 2.0,
            precision: Precision::default(),
            tolerance: 0.0,
            level: 0.0,
            turntable: 0,
        }
    }
}

impl Config {
    /// Voxels `[nz, ny, nx]`.
    pub(super) fn shape(&self) -> [usize; 3] {
        match self.size {
            Size::Cube(n) => [n; 3],
            Size::Axes(axes) => axes,
        }
    }

    /// Refuses values out of range.
    pub(super) fn check(&self) -> Result<()> {
        let least = self.least_size();
        for n in self.shape() {
            if n < least {
                let wanted = format!(
                    "[{least}, inf): the phase changes over {:.1} voxels",
                    self.epsilon / self.spacing
                );
                return Err(Error::range("size", n as f64, &wanted));
            }
        }
        positive("spacing", self.spacing)?;
        positive("epsilon", self.epsilon)?;
        if self.epsilon < self.spacing {
            let range = format!("[{}, inf): at least a voxel", self.spacing);
            return Err(Error::range("epsilon", self.epsilon, &range));
        }
        if self.coefficients.is_some() && self.squares.is_some() {
            return Err(Error::config(
                "squares",
                "the coefficients are given; give one of the two",
            ));
        }
        self.coefficients.iter().flatten().try_for_each(|&a| finite("coefficients", a))?;
        mass("mass", self.mass)?;
        if let Some(along) = &self.along {
            along.check()?;
        }
        if let Some(orientation) = &self.orientation {
            orientation.check()?;
        }
        self.check_flow()?;
        if !(0.0..=20.0).contains(&self.blur) {
            return Err(Error::range("blur", self.blur, "[0, 20]"));
        }
        if self.start == Start::Noise && self.blur == 0.0 {
            return Err(Error::range("blur", self.blur, "(0, 20] for a start from noise"));
        }
        if !(1..=10_000_000).contains(&self.evaluations) {
            return Err(Error::range("evaluations", self.evaluations as f64, "[1, 10000000]"));
        }
        self.check_opening()?;
        if let Some(rate) = self.rate {
            positive("rate", rate)?;
        }
        if !(0.0..1.0).contains(&self.tolerance) {
            return Err(Error::range("tolerance", self.tolerance, "[0, 1)"));
        }
        if !(self.level > -1.0 && self.level < 1.0) {
            return Err(Error::range("level", self.level, "(-1, 1)"));
        }
        if self.turntable > 1000 {
            return Err(Error::range("turntable", self.turntable as f64, "[0, 1000]"));
        }
        Ok(())
    }

    /// Refuses what a flow cannot do.
    fn check_flow(&self) -> Result<()> {
        let spectral = matches!(self.flow, Flow::Fast | Flow::Paper);
        if spectral && self.boundary != Boundary::Periodic {
            let reason = "`fast` and `paper` need a periodic box; take `--flow l2` or `l2-mass`";
            return Err(Error::config("boundary", reason));
        }
        let given =
            self.include.as_ref().map(|_| "include").or(self.exclude.as_ref().map(|_| "exclude"));
        if let (Flow::L2Mass, Some(key)) = (self.flow, given) {
            let reason = "`l2-mass` cannot keep the mass where voxels are given; take another flow";
            return Err(Error::config(key, reason));
        }
        if self.flow == Flow::Paper && self.start != Start::Noise {
            return Err(Error::config("start", "`paper` starts from noise; take another flow"));
        }
        Ok(())
    }

    fn check_opening(&self) -> Result<()> {
        let Some(opening) = self.opening else { return Ok(()) };
        if self.flow != Flow::Fast || self.start != Start::Noise {
            let reason = "only the fast flow from noise has one";
            return Err(Error::config("opening", reason));
        }
        if opening < self.evaluations {
            return Ok(());
        }
        let range = format!("[0, {}): below `evaluations`", self.evaluations);
        Err(Error::range("opening", opening as f64, &range))
    }

    /// Constants of the fast flow; only noise has an opening.
    pub(super) fn opened(&self) -> OpenedConfig {
        let opening = if self.start == Start::Noise { self.opening } else { Some(0) };
        let mut config = OpenedConfig::new(self.evaluations, opening);
        if let Some(rate) = self.rate {
            config.fast.adam.rate = rate;
        }
        config
    }

    /// Memory of the flow, of the surface and of its pictures.
    pub(super) fn bytes_per_voxel(&self) -> usize {
        let float = if self.precision == Precision::F64 { 8 } else { 4 };
        let opened = self.flow == Flow::Fast && self.start == Start::Noise;
        let (fields, saved) = match self.flow {
            Flow::Fast => (10, 0),
            // A checkpoint beside it: its fields, twice, and a file of one of them.
            Flow::Paper => (8, 8 + 5 + 5 + 1),
            Flow::L2 | Flow::L2Mass => (28, 0),
        };
        let maps = if self.along.is_some() { 7 * (8 + float) } else { 0 };
        // Both flows are there when the opening ends, with their transforms, and no surface.
        let both = if opened { 23 * float + 2 * maps } else { 0 };
        // What is not the flow's grows with the area of the surface, which is not known before:
        // of 256^3 voxels 70 bytes each for tubes, 129 for sponges, the preset of the most area.
        let surface = 132;
        both.max(saved * float + maps).max(fields * float + maps + surface)
    }

    /// A box must hold the transition of a surface and of its neighbour.
    fn least_size(&self) -> usize {
        let width = self.epsilon / self.spacing;
        if width.is_finite() { ((4.0 * width).ceil() as usize).clamp(8, 1 << 20) } else { 8 }
    }
}

impl Along {
    fn check(&self) -> Result<()> {
        if self.stops.len() < 2 {
            return Err(Error::range("along.stops", self.stops.len() as f64, "[2, inf)"));
        }
        let mut last = -1.0;
        for (n, stop) in self.stops.iter().enumerate() {
            let key = |name: &str| format!("along.stops.{n}.{name}");
            if !(stop.at > last && (0.0..=1.0).contains(&stop.at)) {
                let range = format!("[0, 1], above the stop before ({last})");
                return Err(Error::range(&key("at"), stop.at, &range));
            }
            last = stop.at;
            stop.coefficients.iter().try_for_each(|&a| finite(&key("coefficients"), a))?;
            mass(&key("mass"), stop.mass)?;
        }
        Ok(())
    }
}

impl Orientation {
    fn check(&self) -> Result<()> {
        if !(self.weight >= 0.0 && self.weight.is_finite()) {
            return Err(Error::range("orientation.weight", self.weight, "[0, inf)"));
        }
        match (&self.direction, &self.field) {
            (Some(direction), None) => {
                let length = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
                positive("orientation.direction", length)
            }
            (None, Some(_)) => Ok(()),
            _ => Err(Error::config("orientation", "give a `direction` or a `field`")),
        }
    }
}

fn finite(key: &str, value: f64) -> Result<()> {
    if value.is_finite() { Ok(()) } else { Err(Error::range(key, value, "(-inf, inf)")) }
}

/// Refuses numbers that are not positive.
pub(super) fn positive(key: &str, value: f64) -> Result<()> {
    let good = value > 0.0 && value.is_finite();
    if good { Ok(()) } else { Err(Error::range(key, value, "(0, inf)")) }
}

fn mass(key: &str, value: f64) -> Result<()> {
    let good = value > -1.0 && value < 1.0;
    if good { Ok(()) } else { Err(Error::range(key, value, "(-1, 1)")) }
}
