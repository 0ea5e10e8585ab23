//! An atlas: many textures of random parameters, laid out by how alike their curvatures are.
//!
//! Song 2021, section 4.5 and figure 10. Parameters are drawn by (seed, number), shapes that do
//! not settle are refused, distances are Sinkhorn divergences of the curvature diagrams, the
//! map is UMAP and its labels HDBSCAN.

mod config;
mod draws;
mod run;
mod view;

pub(super) use config::{Distance, NAMES, Ranges, whole};
pub(super) use draws::{Draws, cloud, coefficients};

use crate::Model;

/// Registry entry.
pub static MODEL: Model = Model {
    name: "curvature-atlas",
    about: "A map of many curvature textures of random parameters",
    paper: "Song 2021, section 4.5, doi:10.1007/s10851-021-01049-9",
    presets: Vec::new,
    start: run::begin,
};
