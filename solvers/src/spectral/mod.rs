//! Fourier and cosine series of fields, and what is measured in them.
//!
//! | symbol | code         | meaning                                     | unit     |
//! |--------|--------------|---------------------------------------------|----------|
//! | k      | `wavenumber` | wave number, wavelength = 2 pi / k          | 1/length |
//! | s(k)   | `symbol`     | eigenvalue of minus the Laplacian, >= 0     | 1/length^2 |
//! | P(k)   | `power`      | mean square amplitude of one mode           | field^2  |

mod angular;
mod lines;
mod multiplier;
mod radial;
mod symbol;
mod transform;

pub use angular::AngularSpectrum;
pub use multiplier::{Multiplier, Transforms};
pub use radial::{RadialSpectrum, Window};
pub use symbol::{LaplacianSymbol, LinearPart};
pub use transform::Transform;

#[cfg(test)]
mod tests;
