//! Pattern models built on [`solvers`]; one folder per model.
//!
//! To add a model: write `<name>/mod.rs` with a `pub static MODEL`, then add
//! the two lines marked below.

mod artifact;
mod config;
mod contour;
mod error;
mod model;
mod state;

// 1. declare
pub mod curvature;
pub mod disocclusion;
pub mod level_set;
pub mod reaction_diffusion;
pub mod topology;

pub(crate) use config::{check_memory, from_table, overlay, to_table};

pub use artifact::{
    Artifact, Axis, Colors, Image, Map, MapPoint, Mark, Metric, Plot, Series, Stroke, Surface,
    SurfaceValues,
};
pub use error::{Error, Result};
pub use model::{Context, Inputs, Model, NoInputs, Preset, Run, Status, observation_interval};
pub use state::{State, Values};

/// Every model, in the order shown by `patterns list`.
pub static MODELS: &[&Model] = &[
    // 2. register
    &reaction_diffusion::MODEL,
    &level_set::MODEL,
    &topology::MODEL,
    &curvature::MODEL,
    &curvature::atlas::MODEL,
    &curvature::infer::MODEL,
];
