//! Time stepping of `du_s/dt = f_s(u, x) + div(D_s grad u_s)` for species `s = 0, 1, ...`.

mod etdrk4;
mod euler;
mod growth;
mod operator;
mod operator_tensor;
mod rates;
mod semi_implicit;

pub use etdrk4::{Etdrk4, Etdrk4Config};
pub use euler::Euler;
pub use growth::{Growth, GrowthLaw};
pub use operator::{Diffusivity, FaceMean, Operator};
pub use operator_tensor::Tensor;
pub use rates::MOST_SPECIES;
pub use semi_implicit::{ImexScheme, SemiImplicit, SemiImplicitConfig};
pub mod explicit;

/// The reaction part `f(u, x)` of a reaction-diffusion system of at most [`MOST_SPECIES`] species, in 64-bit floats.
pub trait Reaction: Sync {
    /// Number of species.
    fn species(&self) -> usize;

    /// Writes `f_s` at the nodes `first..first + n` into `rates[s]`; `u[s]` holds
    /// the concentrations there. All slices have length `n`.
    fn rates(&self, first: usize, u: &[&[f64]], rates: &mut [&mut [f64]]);
}
