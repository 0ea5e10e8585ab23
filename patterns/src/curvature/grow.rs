//! Textures by the dozen: one small shape from its parameters, refused where it does not settle.

use super::config::{Boundary, Config, Size};
use super::energy::{Energy, EnergyConfig, Spatial};
use super::flow::Opened;
use super::{Coefficients, Diagram, Potential, view};
use crate::{Context, Error, Result};
use serde::{Deserialize, Serialize};
use solvers::{Field, Grid, isosurface::Caps, transport::PointCloud};

/// Parts of the evaluations after the opening after which a shape must be viable: the paper looks
/// after 500, 1000 and 5000 of 8000 steps. The fast flow's rate rises in the first quarter of them,
/// and at a third one in five of the refused would still have settled.
const LOOKS: [f64; 2] = [2.0 / 3.0, 1.0];

/// How shapes are grown: by the fast flow after an opening, in a periodic box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Growth {
    /// Voxels `[nz, ny, nx]`, or one number for a cube.
    pub(crate) size: Size,
    /// Width of a voxel.
    pub(crate) spacing: f64,
    /// Width of the phase transition.
    pub(crate) epsilon: f64,
    /// Standard deviation of the blur of the start (voxels).
    pub(crate) blur: f64,
    /// Evaluations of the energy.
    pub(crate) evaluations: u64,
    /// Those of the opening; absent: as for one texture.
    pub(crate) opening: Option<u64>,
    /// Step of the fast flow; absent: as for one texture.
    pub(crate) rate: Option<f64>,
    /// Shapes of a greater normalized discrepancy are refused.
    pub(crate) max_discrepancy: f64,
    /// The phase must rise above this and fall below its negative.
    pub(crate) least_range: f64,
}

impl Default for Growth {
    fn default() -> Self {
        Self {
            size: Size::Cube(64),
            spacing: 0.01,
            epsilon: 0.02,
            blur: 2.0,
            evaluations: 300,
            opening: None,
            rate: None,
            max_discrepancy: 0.75,
            least_range: 0.1,
        }
    }
}

/// What came of the parameters.
#[derive(Clone, Debug)]
pub(crate) enum Grown {
    /// A viable shape.
    Shape(Box<Shape>),
    /// The normalized discrepancy was above its limit.
    Diffuse,
    /// The phase kept to one side of 0, or nearly.
    Empty,
    /// The energy or a curvature was not finite.
    Broken,
}

/// A viable shape.
#[derive(Clone, Debug)]
pub(crate) struct Shape {
    /// Energy, normalized discrepancy, mass, area, genus, components.
    pub(crate) measures: [f64; 6],
    /// The curvature diagram, of mass 1 (1/length).
    pub(crate) diagram: PointCloud<2>,
    /// The phase.
    pub(crate) phase: Field,
}

/// Names of [`Shape::measures`].
pub(crate) const MEASURES: [&str; 6] =
    ["energy", "normalized_discrepancy", "mass_measured", "area", "genus", "components"];

impl Growth {
    /// Refuses values out of range; `key` is that of the table.
    pub(crate) fn check(&self, key: &str) -> Result<()> {
        let inner = |error| match error {
            Error::Config { key: name, reason } => Error::config(&format!("{key}.{name}"), reason),
            other => other,
        };
        self.config().check().map_err(inner)?;
        let unit = |name: &str, value: f64| match value > 0.0 && value <= 1.0 {
            true => Ok(()),
            false => Err(Error::range(&format!("{key}.{name}"), value, "(0, 1]")),
        };
        unit("max_discrepancy", self.max_discrepancy)?;
        unit("least_range", self.least_range)
    }

    /// Refuses boxes of which `together` do not fit into memory.
    pub(crate) fn check_memory(
        &self,
        key: &str,
        together: usize,
        context: &Context<'_>,
    ) -> Result<()> {
        let bytes = self.config().bytes_per_voxel() * together;
        crate::check_memory(key, self.grid()?, bytes, context)
    }

    /// The same as a configuration of one texture.
    fn config(&self) -> Config {
        Config {
            size: self.size.clone(),
            spacing: self.spacing,
            epsilon: self.epsilon,
            blur: self.blur,
            evaluations: self.evaluations,
            opening: self.opening,
            rate: self.rate,
            boundary: Boundary::Periodic,
            ..Config::default()
        }
    }

    /// The box.
    pub(crate) fn grid(&self) -> Result<Grid> {
        Ok(Grid::new(&self.config().shape(), self.spacing)?)
    }

    /// The energy of a box of this kind.
    pub(crate) fn energy(&self, coefficients: Coefficients) -> Result<Energy<f32>> {
        let shape = self.config().shape();
        Ok(Energy::new(EnergyConfig::new(shape, self.spacing, self.epsilon, coefficients))?)
    }

    /// Grows a shape from the noise of `seed`.
    ///
    /// # Errors
    /// If the coefficients are refused; that a shape does not settle is a result.
    pub(crate) fn grow(&self, coefficients: Coefficients, mass: f64, seed: u64) -> Result<Grown> {
        let config = self.config();
        let energy = self.energy(coefficients)?;
        let mass = Spatial::Uniform(mass);
        let potential = Potential::new(config.shape(), self.spacing, self.blur, &mass)?;
        let mut flow = Opened::new(energy, potential, config.opened(), seed)?;
        let mut last = f64::NAN;
        let opening = config.opened().opening;
        for look in LOOKS {
            let left = self.evaluations.saturating_sub(opening);
            let until = opening + (look * left as f64).round() as u64;
            while flow.steps() < until {
                match flow.step() {
                    Ok(info) => last = info.energy,
                    Err(_) => return Ok(Grown::Broken),
                }
            }
            if let Some(why) = self.refused(&flow) {
                return Ok(why);
            }
        }
        self.measure(&flow, last)
    }

    /// Section 4.5: viable are phases of both signs with a small discrepancy.
    fn refused(&self, flow: &Opened<f32>) -> Option<Grown> {
        let extreme = |fold: fn(f32, f32) -> f32| flow.phase().iter().copied().fold(0.0, fold);
        let (low, high) = (f64::from(extreme(f32::min)), f64::from(extreme(f32::max)));
        if low > -self.least_range || high < self.least_range {
            return Some(Grown::Empty);
        }
        let discrepancy = flow.energy().discrepancy(flow.phase());
        (discrepancy >= self.max_discrepancy || discrepancy.is_nan()).then_some(Grown::Diffuse)
    }

    fn measure(&self, flow: &Opened<f32>, energy: f64) -> Result<Grown> {
        let u = flow.phase();
        let grid = self.grid()?;
        let phase = Field::from_vec(grid, u.iter().map(|&u| f64::from(u)).collect())?;
        let mesh = view::surface(phase.clone(), 0.0, Caps::Periodic).mesh;
        let Ok(Some(diagram)) = Diagram::of(flow.energy(), u, &mesh).and_then(|d| d.cloud(0))
        else {
            return Ok(Grown::Broken);
        };
        let discrepancy = flow.energy().discrepancy(u);
        let mass = solvers::field::sum(phase.as_slice(), |u| u) / phase.as_slice().len() as f64;
        let [nz, ny, nx] = grid.shape().map(|n| n as f64 * self.spacing);
        let area = mesh.area();
        let torus = mesh.on_torus([nx, ny, nz]);
        let genus = torus.genus().map_or(f64::NAN, |genus| genus as f64);
        let measures = [energy, discrepancy, mass, area, genus, torus.components() as f64];
        Ok(Grown::Shape(Box::new(Shape { measures, diagram, phase })))
    }
}

#[cfg(test)]
mod tests {
    use super::{Grown, Growth, Size};
    use crate::curvature::{Coefficients, MODEL};
    use crate::{Artifact, Context, NoInputs, Status};

    /// A shape of an atlas is the texture that its parameters grow alone, to the byte.
    #[test]
    fn shapes_grow_as_single_textures_do() {
        let list = [1.0, 2.0, 6.0, -40.0, -40.0, 400.0];
        let alone = |settings: &str| {
            let settings = format!(
                "size = 16\nevaluations = 60\ncoefficients = {list:?}\nmass = -0.4\n{settings}"
            );
            let context = Context { seed: 5, inputs: &NoInputs, memory: 1 << 33 };
            let mut run = (MODEL.start)(&settings.parse().unwrap(), &context).unwrap();
            while run.step().unwrap() == Status::Running {}
            let phase = run.artifacts().into_iter().find_map(|artifact| match artifact {
                Artifact::Image(image) if image.name == "phase" => Some(image.field),
                _ => None,
            });
            phase.unwrap()
        };
        let usual = Growth { size: Size::Cube(16), evaluations: 60, ..Growth::default() };
        let mut all = Vec::new();
        for (growth, settings) in [
            (usual.clone(), ""),
            (Growth { opening: Some(5), ..usual.clone() }, "opening = 5"),
            (Growth { rate: Some(0.25), ..usual }, "rate = 0.25"),
        ] {
            let grown = growth.grow(Coefficients::from(list), -0.4, 5).unwrap();
            let Grown::Shape(shape) = grown else { panic!("{settings}: {grown:?}") };
            let alone = alone(settings);
            assert!(shape.phase.as_slice() == alone.as_slice(), "{settings}");
            assert!(all.iter().all(|other| other != alone.as_slice()), "{settings}");
            all.push(alone.as_slice().to_vec());
        }
    }
}
