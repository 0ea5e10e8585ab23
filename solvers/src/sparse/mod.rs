//! Sparse symmetric systems: analyse once, factorize often, solve often.

mod cholesky;
mod matrix;
mod ordering;

pub use cholesky::{Cholesky, Ordering, Scratch, Symbolic};
pub use matrix::SymmetricMatrix;
pub use ordering::nested_dissection;

#[cfg(test)]
mod tests;
