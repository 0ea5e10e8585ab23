//! Reaction-diffusion and the curve that follows its pattern (Algorithm 1).

pub mod kinetics;
pub mod stepper;
