//! From a shape to the parameters that grow shapes like it.
//!
//! Song 2021, section 5: the shapes of an atlas whose curvature diagrams are nearest to that of
//! the given shape, then a search (CMA-ES) that brings the diagrams together. The mass is that of
//! the given shape; a20 is 1, for the texture knows the polynomial up to a factor.

mod config;
mod cuts;
mod query;
mod run;
mod search;
mod view;

use crate::Model;

/// Registry entry.
pub static MODEL: Model = Model {
    name: "curvature-infer",
    about: "The parameters of a given curvature texture",
    paper: "Song 2021, section 5, doi:10.1007/s10851-021-01049-9",
    presets: Vec::new,
    start: run::begin,
};
