//! From a configuration to fields and a stepper at step 0.

use super::config::{self, Anisotropic, Change, Config, Diffusion, Method, Region, Source};
use super::general::General;
use super::kinetics::Kinetics;
use super::stepper::{Precision, Setup, Stepper};
use crate::{Context, Error, Result};
use solvers::diffusion::explicit::{Parameter, Stencil};
use solvers::diffusion::{Diffusivity, FaceMean, Reaction, Tensor};
use solvers::random::{stream, uniform};
use solvers::{Field, Grid};
use std::collections::BTreeMap;

/// Concentrations, curve, spectra and pictures besides the species, 8 bytes each.
const OTHER_FIELDS: usize = 14;

/// Everything that step 0 needs.
pub(super) struct Start {
    pub(super) setup: Setup,
    pub(super) kinetics: &'static Kinetics,
    pub(super) diffusivity: Vec<Diffusivity>,
    pub(super) initial: Vec<Field>,
}

impl Start {
    /// Checks every name and number, reads the maps, draws the perturbations.
    pub(super) fn new(config: &Config, context: &Context<'_>) -> Result<Self> {
        let kinetics = config::lookup(&config.kinetics)?;
        let grid = Grid::new(&config.axes(), 1.0)
            .map_err(|error| Error::config("size", error.to_string()))?;
        let bytes = 2 * kinetics.species.len() * config.precision.bytes() + 8 * OTHER_FIELDS;
        crate::check_memory("size", grid, bytes, context)?;
        let stencil = config.stencil(grid)?;
        known("parameters", &config.parameters, &parameter_names(kinetics))?;
        known("initial", &config.initial, kinetics.species)?;
        known("diffusion", &config.diffusion, kinetics.species)?;
        let mut parameters = parameters(config, kinetics, grid, context)?;
        let mut initial = initial(config, kinetics, grid, context)?;
        perturb(config, kinetics, context.seed, grid, &mut parameters, &mut initial)?;
        let diffusivity = kinetics
            .species
            .iter()
            .map(|species| diffusivity(config, species, grid, context))
            .collect::<Result<Vec<_>>>()?;
        let constant = |d: &Diffusivity| match d {
            Diffusivity::Constant(d) => Some(*d),
            _ => None,
        };
        let diffusion: Option<Vec<f64>> = diffusivity.iter().map(constant).collect();
        if diffusion.is_none() && config.stepper == Method::Explicit {
            let reason = "maps and directions of diffusion need stepper = \"semi-implicit\"";
            return Err(Error::config("stepper", reason));
        }
        let setup = Setup {
            grid,
            boundary: config.boundary,
            stencil,
            precision: config.precision,
            dt: config.dt,
            diffusion: diffusion.unwrap_or_default(),
            parameters,
            clamp: config.clamp,
        };
        Ok(Self { setup, kinetics, diffusivity, initial })
    }

    /// The reaction in 64-bit floats, for the implicit steppers.
    fn reaction(&self) -> Result<Option<Box<dyn Reaction + Send>>> {
        self.kinetics.reaction.map(|make| make(&self.setup.parameters)).transpose()
    }

    /// The reaction at the mean of every parameter, for linear theory.
    pub(super) fn mean_reaction(&self) -> Result<Option<Box<dyn Reaction + Send>>> {
        let mean = |parameter: &Parameter| match parameter {
            Parameter::Uniform(value) => Parameter::Uniform(*value),
            Parameter::Map(field) => Parameter::Uniform(field.mean_std().0),
        };
        let means: Vec<_> = self.setup.parameters.iter().map(mean).collect();
        self.kinetics.reaction.map(|make| make(&means)).transpose()
    }

    /// The stepper at the initial concentrations, and what it says of itself.
    pub(super) fn stepper(&self, method: Method) -> Result<(Box<dyn Stepper>, Option<String>)> {
        let (mut stepper, note) = if method == Method::Explicit {
            ((self.kinetics.explicit)(&self.setup)?, None)
        } else {
            if self.setup.precision == Precision::F32 {
                return Err(Error::config("precision", "f32 needs stepper = \"explicit\""));
            }
            let reaction = self.reaction()?.ok_or_else(|| {
                let reason = format!("kinetics `{}` needs \"explicit\"", self.kinetics.name);
                Error::config("stepper", reason)
            })?;
            let general = General::new(&self.setup, method, &self.diffusivity, reaction)?;
            let note = general.describe();
            (Box::new(general) as Box<dyn Stepper>, Some(note))
        };
        for (species, field) in self.initial.iter().enumerate() {
            stepper.set(species, field);
        }
        Ok((stepper, note))
    }
}

impl Config {
    /// The stencil that was asked for, else nine points, else (3D) those on the axes.
    fn stencil(&self, grid: Grid) -> Result<Stencil> {
        match self.stencil {
            Some(Stencil::NinePoint) if grid.dim() == 3 => {
                Err(Error::config("stencil", "nine-point is for 1D and 2D, 3D has axes"))
            }
            Some(stencil) => Ok(stencil),
            None if grid.dim() == 3 => Ok(Stencil::Axes),
            None => Ok(Stencil::NinePoint),
        }
    }
}

fn parameter_names(kinetics: &Kinetics) -> Vec<&'static str> {
    kinetics.parameters.iter().map(|range| range.name).collect()
}

/// Refuses names that the kinetics does not have.
fn known<V>(table: &str, given: &BTreeMap<String, V>, names: &[&str]) -> Result<()> {
    match given.keys().find(|name| !names.contains(&name.as_str())) {
        None => Ok(()),
        Some(name) => {
            let reason = format!("no `{name}` here; known: {}", names.join(", "));
            Err(Error::config(&format!("{table}.{name}"), reason))
        }
    }
}

/// A number as it is, a file as a field of the grid's shape.
fn source(key: &str, source: &Source, grid: Grid, context: &Context<'_>) -> Result<Parameter> {
    let (path, range) = match source {
        Source::Number(value) if value.is_finite() => return Ok(Parameter::Uniform(*value)),
        Source::Number(value) => return Err(Error::range(key, *value, "(-inf, inf)")),
        Source::File(path) => (path, [0.0, 1.0]),
        Source::Scaled(scaled) => (&scaled.map, scaled.range),
    };
    let mut field = context.inputs.field(key, path)?;
    field
        .check_shape(&format!("`{path}`"), grid)
        .map_err(|error| Error::config(key, error.to_string()))?;
    let [low, high] = range;
    field.as_mut_slice().iter_mut().for_each(|v| *v = low + (high - low) * *v);
    Ok(Parameter::Map(field))
}

fn parameters(
    config: &Config,
    kinetics: &Kinetics,
    grid: Grid,
    context: &Context<'_>,
) -> Result<Vec<Parameter>> {
    let parameter = |range: &super::kinetics::Range| {
        let key = format!("parameters.{}", range.name);
        let given = config
            .parameters
            .get(range.name)
            .ok_or_else(|| Error::config(&key, "is missing: give a number or a file"))?;
        let value = source(&key, given, grid, context)?;
        let worst = match &value {
            Parameter::Uniform(value) => *value,
            Parameter::Map(field) => {
                let (low, high) = field.range();
                if low < range.low { low } else { high }
            }
        };
        if worst < range.low || worst > range.high {
            return Err(Error::range(&key, worst, &format!("[{}, {}]", range.low, range.high)));
        }
        Ok(value)
    };
    kinetics.parameters.iter().map(parameter).collect()
}

fn initial(
    config: &Config,
    kinetics: &Kinetics,
    grid: Grid,
    context: &Context<'_>,
) -> Result<Vec<Field>> {
    let field = |species: &&str| {
        let key = format!("initial.{species}");
        let given = config.initial.get(*species);
        Ok(match given.map(|given| source(&key, given, grid, context)).transpose()? {
            None => Field::constant(grid, 0.0),
            Some(Parameter::Uniform(value)) => Field::constant(grid, value),
            Some(Parameter::Map(field)) => field,
        })
    };
    kinetics.species.iter().map(field).collect()
}

fn diffusivity(
    config: &Config,
    species: &str,
    grid: Grid,
    context: &Context<'_>,
) -> Result<Diffusivity> {
    let key = format!("diffusion.{species}");
    let at_least_0 = |key: &str, value: f64| {
        if value >= 0.0 { Ok(value) } else { Err(Error::range(key, value, "[0, inf)")) }
    };
    Ok(match config.diffusion.get(species) {
        None => Diffusivity::Constant(0.0),
        Some(Diffusion::Isotropic(given)) => match source(&key, given, grid, context)? {
            Parameter::Uniform(value) => Diffusivity::Constant(at_least_0(&key, value)?),
            Parameter::Map(values) => {
                at_least_0(&key, values.range().0)?;
                Diffusivity::Map { values, mean: FaceMean::Harmonic }
            }
        },
        Some(Diffusion::Anisotropic(Anisotropic { along, across, angle })) => {
            at_least_0(&format!("{key}.along"), *along)?;
            at_least_0(&format!("{key}.across"), *across)?;
            let tensor = |degrees: f64| Tensor::rotated(*along, *across, degrees.to_radians());
            match source(&format!("{key}.angle"), angle, grid, context)? {
                Parameter::Uniform(degrees) => Diffusivity::Tensor(vec![tensor(degrees)]),
                Parameter::Map(degrees) => {
                    Diffusivity::Tensor(degrees.as_slice().iter().map(|&d| tensor(d)).collect())
                }
            }
        }
    })
}

/// Applies the perturbations, in order; noise has a random stream of its own per entry.
fn perturb(
    config: &Config,
    kinetics: &Kinetics,
    seed: u64,
    grid: Grid,
    parameters: &mut [Parameter],
    initial: &mut [Field],
) -> Result<()> {
    for (index, change) in config.perturbation.iter().enumerate() {
        let target = change.target.as_str();
        let parameter = kinetics.parameters.iter().position(|range| range.name == target);
        let species = kinetics.species.iter().position(|&name| name == target);
        let field = match (parameter, species) {
            (Some(p), _) => {
                if let Parameter::Uniform(value) = parameters[p] {
                    parameters[p] = Parameter::Map(Field::constant(grid, value));
                }
                match &mut parameters[p] {
                    Parameter::Map(field) => field,
                    Parameter::Uniform(_) => continue,
                }
            }
            (None, Some(s)) => &mut initial[s],
            (None, None) => {
                let names = [&parameter_names(kinetics)[..], kinetics.species].concat();
                let reason = format!("no `{target}` here; known: {}", names.join(", "));
                return Err(Error::config(&format!("perturbation.{index}.target"), reason));
            }
        };
        let nodes = region(change, seed, grid);
        let mut noise = stream(seed, "perturbation", index as u64);
        for (value, _) in field.as_mut_slice().iter_mut().zip(&nodes).filter(|(_, inside)| **inside)
        {
            match change.kind {
                Change::Noise => *value += change.amplitude * (2.0 * uniform(&mut noise) - 1.0),
                Change::Add => *value += change.amplitude,
                Change::Set => *value = change.amplitude,
            }
        }
    }
    Ok(())
}

/// Which nodes a perturbation touches. Squares stand at the same places for every
/// perturbation of the same width and count.
fn region(change: &config::Perturbation, seed: u64, grid: Grid) -> Vec<bool> {
    let shape = grid.shape();
    let middle = |m: usize, n: usize| {
        let first = n.saturating_sub(change.width) / 2;
        n == 1 || (first..first + change.width).contains(&m)
    };
    let at = |inside: &dyn Fn([usize; 3]) -> bool| {
        (0..grid.len()).map(|n| inside(grid.node(n))).collect()
    };
    match change.region {
        Region::All => vec![true; grid.len()],
        Region::Even => at(&|node| node.iter().all(|m| m.is_multiple_of(2))),
        Region::CenterLine => at(&|[_, _, i]| middle(i, shape[2])),
        Region::Block => at(&|node| (0..3).all(|axis| middle(node[axis], shape[axis]))),
        Region::Edge => at(&|[_, _, i]| i < change.width),
        Region::Squares => {
            let mut places = stream(seed, "squares", 0);
            let mut inside = vec![false; grid.len()];
            for _ in 0..change.count {
                let corner = shape.map(|n| (uniform(&mut places) * n as f64) as usize);
                for n in 0..change.width.pow(grid.dim() as u32) {
                    let w = change.width;
                    let offset = [n / w / w, n / w % w, n % w];
                    let node = [0, 1, 2].map(|axis| (corner[axis] + offset[axis]) % shape[axis]);
                    inside[grid.index(node[0], node[1], node[2])] = true;
                }
            }
            inside
        }
    }
}
