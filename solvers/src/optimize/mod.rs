//! Optimizers for many design variables in boxes, which ask and are told.
//!
//! The method owns its state and the caller owns the loop: it evaluates its functions and
//! their gradients, hands them in, and gets the next point back. Nothing is evaluated here.
//!
//! | method                 | problem                                       | inner loop            |
//! |------------------------|-----------------------------------------------|-----------------------|
//! | [`Mma`]                | smooth f0, m constraints `g_i(x) <= 0`        | none                  |
//! | [`Gcmma`]              | the same, falling at every accepted point     | until a trial is good |
//! | [`OptimalityCriteria`] | monotone f0, one volume                       | bisection             |
//!
//! [`Adam`] and [`Lbfgs`] are for many free variables and one smooth function: the first is
//! applied variable by variable, the second calls the function for its line search.
//!
//! All are deterministic: the same input gives the same bytes for any number of threads.
//! Their states implement serde's traits, and a state that was written and read back goes on
//! to the same bytes if the format keeps every bit of a number. A variable whose bounds are
//! equal is fixed: it takes that value whatever is handed in.

mod adam;
mod bounds;
mod check;
mod cmaes;
mod gcmma;
mod lbfgs;
mod mma;
mod oc;

pub use adam::{Adam, AdamConfig};
pub use bounds::Bounds;
pub use cmaes::Cmaes;
pub use gcmma::{Gcmma, GcmmaConfig, Verdict};
pub use lbfgs::{Lbfgs, LbfgsConfig, LbfgsStep};
pub use mma::{Artificial, Mma, MmaConfig, MovingLimits, Solve};
pub use oc::{BisectionEnd, OcConfig, OptimalityCriteria};

#[cfg(test)]
mod tests;
