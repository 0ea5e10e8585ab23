//! Finite elements on grids of unit squares and cubes: elasticity and heat conduction.
//!
//! | symbol | code | meaning | unit |
//! | --- | --- | --- | --- |
//! | K_e | `Element::stiffness` | element matrix for stiffness 1 | force/length |
//! | E_e | `stiffness[e]` | stiffness of element e relative to K_e | 1 |
//! | u | `displacement` | nodal unknowns, `components * node + axis` | length, or temperature |
//! | f | `force` | nodal loads | force, or heat |
//!
//! `K(E) = sum_e E_e K_e`, where every element has the same `K_e`: what topology
//! optimization needs. Elements and nodes are numbered row by row, x fastest; y is the
//! axis of the rows and points down in pictures.

mod direct;
mod element;
mod lattice;
pub mod multigrid;
mod rigid;
mod solver;
mod system;

pub use direct::Direct;
pub use element::{Elastic, Element, PlaneState};
pub use lattice::Lattice;
pub use rigid::{RigidMode, free_modes};
pub use solver::{Choice, LinearSolver, SolveReport};
pub use system::System;

#[cfg(test)]
mod tests;
