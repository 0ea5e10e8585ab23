//! The numerics against exact solutions: convergence, identities, faults.
//! One binary: every test file of its own would be linked, and run, by itself.
#![allow(clippy::print_stdout, reason = "tests print what they measure")]

mod diffusion_operator;
mod diffusion_steppers;
mod distance_isosurface;
mod distance_measures;
mod distance_redistance;
mod distance_shapes;
mod level_set_evolution;
mod level_set_reinitialize;
mod level_set_speeds;
mod level_set_standard;
mod level_set_support;
mod mesh_periodic;
