//! The laboratory: runs models, watches them, writes what they return.
//!
//! A run passes through [`request`] (what to run), [`runner`] (step, observe,
//! checkpoint, stop), [`record`] (animation and log), [`folder`] (the output
//! folder) and [`manifest`] (`run.json`).

pub mod artifact;
pub mod bench;
pub mod checkpoint;
pub mod cli;
pub mod database;
pub mod figure;
pub mod folder;
pub mod input;
pub mod inputs;
pub mod manifest;
pub mod memory;
pub mod output;
pub mod reconstruct;
pub mod record;
pub mod render;
pub mod request;
pub mod runner;
