//! Curvature textures: surfaces that minimize a polynomial of their principal curvatures.
//!
//! The surface is the zero level of a phase field u, near 1 inside and near -1 outside.
//! Anna Song 2021, "Generation of tubular and membranous shape textures with curvature
//! functionals".

mod coefficients;
mod config;
mod descent;
mod diagram;
pub mod energy;
pub mod flow;
mod mask;
mod potential;
mod presets;
mod run;
mod start;
#[cfg(test)]
mod tests;
mod view;
mod written;

pub use coefficients::{Coefficients, Interpretable};
pub use config::Config;
pub use diagram::Diagram;
pub use mask::Mask;
pub use potential::Potential;

use crate::Model;

/// Registry entry.
pub static MODEL: Model = Model {
    name: "curvature",
    about: "Tubes, membranes and sponges in space from an energy of curvatures",
    paper: "Song 2021, doi:10.1007/s10851-021-01049-9",
    presets: presets::presets,
    start: run::begin,
};
