//! Numerical methods that know no pattern.
//!
//! Fields live on uniform grids of one, two or three axes and are row-major
//! with shape `[nz, ny, nx]` (absent axes have size 1); node `(k, j, i)` sits at
//! `x = i h, y = j h, z = k h`. Inside a front `phi < 0`, everywhere.

mod aligned;
pub mod blur;
pub mod boundary;
pub mod cluster;
pub mod diffusion;
mod distances;
pub mod embed;
mod error;
pub mod expression;
pub mod fem;
pub mod field;
pub mod float;
pub mod grid;
pub mod histogram;
pub mod isosurface;
pub mod level_set;
pub mod mesh;
pub mod optimize;
pub mod order;
pub mod random;
pub mod slab;
pub mod sparse;
pub mod spectral;
pub mod stability;
pub mod texture;
pub mod transport;

pub use aligned::Aligned;
pub use boundary::Boundary;
pub use error::{Error, Result};
pub use field::Field;
pub use float::Float;
pub use grid::Grid;
