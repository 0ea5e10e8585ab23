//! The laboratory: runs models, watches them, writes what they return.

pub mod input;
pub mod output;
