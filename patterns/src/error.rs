/// The result of a model.
pub type Result<T> = std::result::Result<T, Error>;

/// Anything that can go wrong in a model.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The configuration does not fit the model: an unknown key, a wrong type, a value out of range.
    #[error("`{key}`: {reason}")]
    Config {
        /// Key in the configuration, dotted: `kinetics.feed`.
        key: String,
        /// What was found and what is wanted.
        reason: String,
    },
    /// The structure can move without strain, and a load drives it.
    #[error("`{key}`: {reason}")]
    Mechanism {
        /// Key in the configuration that could hold it.
        key: String,
        /// What moves, and what would stop it.
        reason: String,
        /// The motion.
        picture: Box<crate::Artifact>,
    },
    /// An input file could not be used.
    #[error("`{key}`: {reason}")]
    Input {
        /// Key in the configuration that names the file.
        key: String,
        /// What is wrong with the file, with its name.
        reason: String,
    },
    /// A checkpoint does not belong to this configuration.
    #[error("checkpoint: {0}")]
    Checkpoint(String),
    /// A solver failed.
    #[error(transparent)]
    Solver(#[from] solvers::Error),
}

impl Error {
    /// An [`Error::Config`].
    pub fn config(key: &str, reason: impl Into<String>) -> Self {
        Self::Config { key: key.into(), reason: reason.into() }
    }

    /// An [`Error::Config`] for a number outside `range` (interval notation).
    pub fn range(key: &str, value: f64, range: &str) -> Self {
        Self::config(key, format!("{value} is outside its range {range}"))
    }
}
