//! The whole program and its models: published results, figures, command line, faults.
//! One binary: every test file of its own would be linked, and run, by itself.
#![allow(clippy::print_stdout, reason = "tests print what they measure")]

mod curvature;
mod curvature_flows;
mod curvature_infer;
mod database;
mod faults;
mod faults_models;
mod figures;
mod formats;
mod formats_images;
mod formats_pictures;
mod formats_volumes;
mod fronts;
mod growth;
mod layers;
mod reaction_diffusion;
mod reconstruct;
mod registry;
mod render;
mod resume;
mod swift_hohenberg;
mod topology;
