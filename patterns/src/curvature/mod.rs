//! Curvature textures: surfaces that minimize a polynomial of their principal curvatures.
//!
//! The surface is the zero level of a phase field u, near 1 inside and near -1 outside.
//! Anna Song 2021, "Generation of tubular and membranous shape textures with curvature
//! functionals".

mod coefficients;
pub mod energy;
pub mod flow;
mod mask;
mod potential;

pub use coefficients::{Coefficients, Interpretable};
pub use mask::Mask;
pub use potential::Potential;
