//! From a configuration to fields and a stepper at step 0.

use super::config::{self, Anisotropic, Config, Diffusion, Method, Source};
use super::general::{General, Linear};
use super::kinetics::Kinetics;
use super::perturb::perturb;
use super::resolve;
use super::stepper::{Precision, Setup, Stepper};
use crate::{Context, Error, Result};
use solvers::diffusion::explicit::{Parameter, Stencil};
use solvers::diffusion::{Diffusivity, FaceMean, MOST_SPECIES, Reaction, Tensor};
use solvers::expression::FormulaReaction;
use solvers::{Field, Grid};
use std::collections::BTreeMap;

/// Concentrations, curve, spectra and pictures besides the species, 8 bytes each.
const OTHER_FIELDS: usize = 14;

/// Who reacts with whom: a kinetics of the registry, or formulas.
pub(super) struct Chemistry {
    pub(super) species: Vec<String>,
    pub(super) parameters: Vec<(String, [f64; 2])>,
    /// `None`: the rates are the formulas of the configuration.
    kinetics: Option<&'static Kinetics>,
    formulas: Vec<String>,
}

impl Chemistry {
    fn new(config: &Config) -> Result<Self> {
        if config.kinetics != config::FORMULAS {
            let kinetics = resolve::lookup(&config.kinetics)?;
            let range = |r: &super::kinetics::Range| (r.name.to_owned(), [r.low, r.high]);
            return Ok(Self {
                species: kinetics.species.iter().map(|&name| name.to_owned()).collect(),
                parameters: kinetics.parameters.iter().map(range).collect(),
                kinetics: Some(kinetics),
                formulas: Vec::new(),
            });
        }
        if config.formulas.is_empty() {
            return Err(Error::config("formulas", "there is none; give one for each species"));
        }
        if config.formulas.len() > MOST_SPECIES {
            let count = config.formulas.len();
            return Err(Error::config(
                "formulas",
                format!("{count} species, at most {MOST_SPECIES}"),
            ));
        }
        let any = [f64::NEG_INFINITY, f64::INFINITY];
        Ok(Self {
            species: config.formulas.keys().cloned().collect(),
            parameters: config.parameters.keys().map(|name| (name.clone(), any)).collect(),
            kinetics: None,
            formulas: config.formulas.values().cloned().collect(),
        })
    }

    pub(super) fn parameter_names(&self) -> Vec<&str> {
        self.parameters.iter().map(|(name, _)| name.as_str()).collect()
    }

    pub(super) fn species_names(&self) -> Vec<&str> {
        self.species.iter().map(String::as_str).collect()
    }

    /// The reaction in 64-bit floats.
    fn reaction(&self, parameters: &[Parameter]) -> Result<Box<dyn Reaction + Send>> {
        if let Some(kinetics) = self.kinetics {
            return (kinetics.reaction)(parameters);
        }
        let species: Vec<(&str, &str)> = self
            .species
            .iter()
            .zip(&self.formulas)
            .map(|(s, f)| (s.as_str(), f.as_str()))
            .collect();
        let named: Vec<(&str, Parameter)> =
            self.parameter_names().into_iter().zip(parameters.iter().cloned()).collect();
        let reaction = FormulaReaction::new(&species, &named)
            .map_err(|error| Error::config("formulas", error.to_string()))?;
        Ok(Box::new(reaction))
    }
}

/// Everything that step 0 needs.
pub(super) struct Start {
    pub(super) setup: Setup,
    pub(super) chemistry: Chemistry,
    pub(super) diffusivity: Vec<Diffusivity>,
    pub(super) initial: Vec<Field>,
}

impl Start {
    /// Checks every name and number, reads the maps, draws the perturbations.
    pub(super) fn new(config: &Config, context: &Context<'_>) -> Result<Self> {
        let chemistry = Chemistry::new(config)?;
        let grid = Grid::new(&config.axes(), 1.0)
            .map_err(|error| Error::config("size", error.to_string()))?;
        let bytes = 2 * chemistry.species.len() * config.precision.bytes() + 8 * OTHER_FIELDS;
        crate::check_memory("size", grid, bytes, context)?;
        let stencil = config.stencil(grid)?;
        known("parameters", &config.parameters, &chemistry.parameter_names())?;
        known("initial", &config.initial, &chemistry.species_names())?;
        known("diffusion", &config.diffusion, &chemistry.species_names())?;
        if let Some(species) = config.diffusion.keys().next()
            && chemistry.kinetics.is_some_and(|kinetics| kinetics.linear.is_some())
        {
            let reason = format!("{} has an operator of its own and no diffusion", config.kinetics);
            return Err(Error::config(&format!("diffusion.{species}"), reason));
        }
        let mut parameters = parameters(config, &chemistry, grid, context)?;
        let mut initial = initial(config, &chemistry, grid, context)?;
        perturb(config, &chemistry, context.seed, grid, &mut parameters, &mut initial)?;
        let diffusivity = chemistry
            .species
            .iter()
            .map(|species| diffusivity(config, species, grid, context))
            .collect::<Result<Vec<_>>>()?;
        let constant = |d: &Diffusivity| match d {
            Diffusivity::Constant(d) => *d,
            _ => f64::NAN,
        };
        let setup = Setup {
            grid,
            boundary: config.boundary,
            stencil,
            precision: config.precision,
            dt: config.dt,
            diffusion: diffusivity.iter().map(constant).collect(),
            parameters,
            clamp: config.clamp,
        };
        Ok(Self { setup, chemistry, diffusivity, initial })
    }

    /// The reaction at the mean of every parameter, for linear theory.
    pub(super) fn mean_reaction(&self) -> Result<Box<dyn Reaction + Send>> {
        let mean = |parameter: &Parameter| match parameter {
            Parameter::Uniform(value) => Parameter::Uniform(*value),
            Parameter::Map(field) => Parameter::Uniform(field.mean_std().0),
        };
        let means: Vec<_> = self.setup.parameters.iter().map(mean).collect();
        self.chemistry.reaction(&means)
    }

    /// What is linear in each species: the kinetics' own operator, or diffusion; `None` for
    /// an operator that varies in place.
    pub(super) fn linear(&self) -> Option<Linear> {
        match self.chemistry.kinetics.and_then(|kinetics| kinetics.linear) {
            Some(make) => make(&self.setup.parameters).map(Linear::Parts),
            None => Some(Linear::Diffusion(self.diffusivity.clone())),
        }
    }

    /// The stepper at the initial concentrations, and what it says of itself.
    pub(super) fn stepper(&self, method: Method) -> Result<(Box<dyn Stepper>, Option<String>)> {
        let uniform = self.setup.diffusion.iter().all(|d| d.is_finite());
        let (mut stepper, note) = match self.chemistry.kinetics {
            Some(kinetics) if method == Method::Explicit && uniform => {
                ((kinetics.explicit)(&self.setup)?, None)
            }
            _ => self.general(method)?,
        };
        for (species, field) in self.initial.iter().enumerate() {
            stepper.set(species, field);
        }
        Ok((stepper, note))
    }

    /// The stepper for maps and directions of diffusion, formulas, and the implicit methods.
    fn general(&self, method: Method) -> Result<(Box<dyn Stepper>, Option<String>)> {
        if self.setup.precision == Precision::F32 {
            let reason = "f32 is for explicit steps of a built-in kinetics with constant diffusion";
            return Err(Error::config("precision", reason));
        }
        let reaction = self.chemistry.reaction(&self.setup.parameters)?;
        let linear = self.linear().ok_or_else(|| {
            let reason = "the operator of this kinetics varies in place; use explicit";
            Error::config("stepper", reason)
        })?;
        let general = General::new(&self.setup, method, &linear, reaction)?;
        let note = general.describe();
        Ok((Box::new(general), Some(note)))
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
    chemistry: &Chemistry,
    grid: Grid,
    context: &Context<'_>,
) -> Result<Vec<Parameter>> {
    let parameter = |(name, [least, greatest]): &(String, [f64; 2])| {
        let key = format!("parameters.{name}");
        let given = config
            .parameters
            .get(name)
            .ok_or_else(|| Error::config(&key, "is missing: give a number or a file"))?;
        let value = source(&key, given, grid, context)?;
        let worst = match &value {
            Parameter::Uniform(value) => *value,
            Parameter::Map(field) => {
                let (low, high) = field.range();
                if low < *least { low } else { high }
            }
        };
        if worst < *least || worst > *greatest {
            return Err(Error::range(&key, worst, &format!("[{least}, {greatest}]")));
        }
        Ok(value)
    };
    chemistry.parameters.iter().map(parameter).collect()
}

fn initial(
    config: &Config,
    chemistry: &Chemistry,
    grid: Grid,
    context: &Context<'_>,
) -> Result<Vec<Field>> {
    let field = |species: &String| {
        let key = format!("initial.{species}");
        let given = config.initial.get(species);
        Ok(match given.map(|given| source(&key, given, grid, context)).transpose()? {
            None => Field::constant(grid, 0.0),
            Some(Parameter::Uniform(value)) => Field::constant(grid, value),
            Some(Parameter::Map(field)) => field,
        })
    };
    chemistry.species.iter().map(field).collect()
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
