//! Curvature textures: surfaces that minimize a polynomial of their principal curvatures.
mod coefficients;
pub mod energy;
pub use coefficients::{Coefficients, Interpretable};
