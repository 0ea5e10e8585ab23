//! `run.json`: what was run and what came out, without time or host.

use anyhow::Result;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use toml::Table;

/// How a run stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RunStatus {
    /// Not finished; there is a checkpoint.
    Running,
    /// Stopped by Ctrl-C or a termination signal; there is a checkpoint.
    Interrupted,
    /// Finished as planned.
    Done,
    /// Out of iterations before its criterion was met.
    NotConverged,
    /// Stopped by an error; there is a checkpoint of an earlier step.
    Failed,
}

/// The content of `run.json`.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Name of the model.
    pub command: String,
    /// Version of this program.
    pub version: String,
    /// The complete configuration; `patterns run run.json` repeats the run.
    pub config: Table,
    /// Seed of all random streams.
    pub seed: u64,
    /// How the run stands.
    pub status: RunStatus,
    /// Steps done.
    pub iterations: u64,
    /// Named results; units stand in the documentation of each model.
    pub metrics: BTreeMap<String, f64>,
    /// Files of the output folder, in order of name.
    pub files: Vec<String>,
    /// What a reconstruction found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub answer: Option<serde_json::Value>,
}

impl Manifest {
    /// The text of `run.json`.
    ///
    /// # Errors
    /// Never for finite metrics.
    pub fn to_json(&self) -> Result<String> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// Reads `run.json`.
    ///
    /// # Errors
    /// If a key is missing, unknown or of the wrong type, with line and column.
    pub fn parse(text: &str) -> Result<Self> {
        Ok(serde_json::from_str(text)?)
    }
}
