//! From a shape to the parameters that grow shapes like it.
//!
//! Song 2021, section 5: the shapes of an atlas whose curvature diagrams are nearest to that of
//! the given shape, then searches (CMA-ES) around the best of them that bring the diagrams together.
//! The mass is that of the given shape; a20 is 1, for the texture knows the polynomial up to a
//! factor. What else of it the texture knows is told by the ranges of all parameters that were
//! tried whose shapes are as near as those of another noise.

mod config;
mod cuts;
mod proof;
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
