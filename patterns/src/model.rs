use crate::{Artifact, Error, Image, Metric, Result, State};
use solvers::{Field, isosurface::Polyline, mesh::TriangleMesh};

/// A model as the registry sees it.
pub struct Model {
    /// Name on the command line, `kebab-case`.
    pub name: &'static str,
    /// One sentence for `patterns list`.
    pub about: &'static str,
    /// Source: authors, year, equation or DOI.
    pub paper: &'static str,
    /// Named starting points.
    pub presets: fn() -> Vec<Preset>,
    /// Checks a configuration, fills in its defaults and reads its inputs, then
    /// sets up step 0. Every bad value is found here, before any work.
    pub start: fn(config: &toml::Table, context: &Context<'_>) -> Result<Box<dyn Run>>,
}

/// A named configuration of a model.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    /// Name on the command line.
    pub name: &'static str,
    /// One sentence.
    pub about: &'static str,
    /// The configuration, as TOML.
    pub config: &'static str,
}

/// What a run may know of the world.
pub struct Context<'a> {
    /// Seed of all random streams.
    pub seed: u64,
    /// Reads an image or array that the configuration names; the caller owns the disk.
    pub inputs: &'a dyn Inputs,
    /// Bytes of memory that a run may take; larger requests are refused at the start.
    pub memory: u64,
}

/// Reads the files that a configuration names.
pub trait Inputs {
    /// The values of `path` as a field of node distance 1: an image's grey levels in
    /// [0, 1], or an array as it is. `key` is the configuration's key, for messages.
    ///
    /// # Errors
    /// [`Error::Input`] with the file's name and what is wrong with it.
    fn field(&self, key: &str, path: &str) -> Result<Field>;

    /// The triangles of `path`, or `None` if its name is not that of a mesh.
    ///
    /// # Errors
    /// [`Error::Input`] with the file's name and what is wrong with it.
    fn mesh(&self, key: &str, path: &str) -> Result<Option<TriangleMesh>> {
        let _ = (key, path);
        Ok(None)
    }

    /// The closed lines of `path`, each of at least 3 finite points `[x, y]`.
    ///
    /// # Errors
    /// [`Error::Input`] with the file's name, the line and what is wrong with it.
    fn lines(&self, key: &str, path: &str) -> Result<Vec<Polyline>>;
}

/// No files at all, for tests and for models without inputs.
pub struct NoInputs;

impl Inputs for NoInputs {
    fn field(&self, key: &str, path: &str) -> Result<Field> {
        Err(Error::Input { key: key.into(), reason: format!("`{path}` cannot be read here") })
    }

    fn lines(&self, key: &str, path: &str) -> Result<Vec<Polyline>> {
        Err(Error::Input { key: key.into(), reason: format!("`{path}` cannot be read here") })
    }
}

/// Observations that are made of a whole run, about.
const OBSERVATIONS: u64 = 400;

/// Steps between two observations of a run of about `iterations` steps: whoever runs it calls
/// [`Run::observe`] at the multiples, and at the end.
pub fn observation_interval(iterations: u64) -> u64 {
    iterations.div_ceil(OBSERVATIONS).max(1)
}

/// A run in progress. The caller owns the loop, the clock and the disk.
pub trait Run {
    /// Does one unit of work (a time step, an iteration, a generation).
    ///
    /// # Errors
    /// Whatever stops the run for good; not reaching a tolerance is a status.
    fn step(&mut self) -> Result<Status>;

    /// Steps done since the start.
    fn iterations(&self) -> u64;

    /// The most steps that there can be.
    fn max_iterations(&self) -> u64;

    /// About how many steps there will be, for the spacing of frames and log lines.
    fn expected_iterations(&self) -> u64 {
        self.max_iterations()
    }

    /// The configuration, complete: starting from it repeats this run.
    fn config(&self) -> toml::Table;

    /// Named scalars of the current state, for `run.json`; may cost more than a step.
    fn metrics(&self) -> Vec<Metric>;

    /// Cheap scalars of the current state for the log and the convergence plot,
    /// the same names at every step.
    fn observe(&self) -> Vec<Metric> {
        Vec::new()
    }

    /// What can be drawn or saved in the current state.
    fn artifacts(&self) -> Vec<Artifact>;

    /// The picture of the current state for the animation, if there is one to make.
    fn frame(&self) -> Option<Image>;

    /// Notes for the person who runs it, e.g. which solver was chosen.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }

    /// All that is needed to go on from here to the same bytes.
    fn save(&self) -> State;

    /// Goes on from a saved state; `self` was started from the same configuration and seed.
    ///
    /// # Errors
    /// [`Error::Checkpoint`] if something is missing or has another shape.
    fn restore(&mut self, state: &State) -> Result<()>;
}

/// What a step says about the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// More steps to go.
    Running,
    /// The planned steps are done, or the stopping criterion is met.
    Done,
    /// The budget of steps is spent before the criterion is met.
    NotConverged,
}
