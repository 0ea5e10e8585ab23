//! Reaction formulas: one file per kinetics, one registry.

pub mod brusselator;
pub mod fitzhugh_nagumo;
pub mod gierer_meinhardt;
pub mod gray_scott;
pub mod meinhardt;
pub mod schnakenberg;
pub mod swift_hohenberg;
pub mod turing;

use super::stepper::{self, Setup, Stepper};
use crate::{Preset, Result};
use solvers::diffusion::Reaction;
use solvers::diffusion::explicit::{Cell, CellReaction, Parameter};
use solvers::spectral::LinearPart;

/// Every kinetics, in the order shown to people.
pub static KINETICS: &[&Kinetics] = &[
    &turing::KINETICS,
    &gray_scott::KINETICS,
    &schnakenberg::KINETICS,
    &fitzhugh_nagumo::KINETICS,
    &gierer_meinhardt::KINETICS,
    &brusselator::KINETICS,
    &swift_hohenberg::KINETICS,
    &meinhardt::KINETICS,
];

/// Makes a reaction at given parameters.
pub type MakeReaction = fn(&[Parameter]) -> Result<Box<dyn Reaction + Send>>;

/// Makes the linear part of each species; `None` if a map makes it vary in place.
pub type MakeLinear = fn(&[Parameter]) -> Option<Vec<LinearPart>>;

/// A reaction as the registry sees it.
pub struct Kinetics {
    /// Name in configurations, `kebab-case`.
    pub name: &'static str,
    /// The equations, without diffusion.
    pub equations: &'static str,
    /// Source: authors, year.
    pub source: &'static str,
    /// Names of the species.
    pub species: &'static [&'static str],
    /// Names of the parameters and the ranges that they may have.
    pub parameters: &'static [Range],
    /// What its runs start from, as TOML, before a preset and the user's own keys.
    pub defaults: &'static str,
    /// Configurations that make a known pattern; the first is that of the kinetics' name alone.
    pub presets: &'static [Preset],
    /// The explicit stepper at concentrations 0.
    pub explicit: fn(&Setup) -> Result<Box<dyn Stepper>>,
    /// The linear part of each species for other steppers, if it is not diffusion.
    pub linear: Option<MakeLinear>,
    /// The reaction for other steppers.
    pub reaction: MakeReaction,
}

/// The presets of all kinetics, in the order shown to people.
pub fn presets() -> Vec<Preset> {
    KINETICS.iter().flat_map(|kinetics| kinetics.presets).copied().collect()
}

/// A parameter and its closed range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Name in configurations.
    pub name: &'static str,
    /// Least value.
    pub low: f64,
    /// Greatest value, possibly infinite.
    pub high: f64,
}

/// A parameter that may be any number in `[low, high]`.
const fn range(name: &'static str, low: f64, high: f64) -> Range {
    Range { name, low, high }
}

/// The explicit stepper of a [`Cell`].
fn explicit<C: Cell<S, P>, const S: usize, const P: usize>(
    setup: &Setup,
) -> Result<Box<dyn Stepper>> {
    stepper::explicit_cell::<C, S, P>(setup)
}

/// The explicit stepper of a [`Cell`] in double precision only: single precision is
/// compiled for the models that are run at large sizes, to keep the build short.
fn explicit_double<C: Cell<S, P>, const S: usize, const P: usize>(
    setup: &Setup,
) -> Result<Box<dyn Stepper>> {
    stepper::explicit_double::<C, S, P>(setup)
}

/// The [`Reaction`] of a [`Cell`].
fn reaction<C: Cell<S, P>, const S: usize, const P: usize>(
    parameters: &[Parameter],
) -> Result<Box<dyn Reaction + Send>> {
    Ok(Box::new(CellReaction::<C, S, P>::new(stepper::array(parameters)?)))
}

/// The kinetics of that name.
pub fn find(name: &str) -> Option<&'static Kinetics> {
    KINETICS.iter().copied().find(|k| k.name == name)
}
