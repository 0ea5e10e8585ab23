/// The result of a solver.
pub type Result<T> = std::result::Result<T, Error>;

/// Anything that can go wrong in a solver.
///
/// Messages name the quantity, the value found and the value wanted. Running
/// out of iterations is not an error: it is a status of the result.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter is outside its documented range.
    #[error("{name} = {value} is outside its range {range}")]
    OutOfRange {
        /// Name as written in the docs, e.g. `"cfl"`.
        name: String,
        /// The value given.
        value: f64,
        /// The range in interval notation, e.g. `"(0, 1]"`.
        range: String,
    },
    /// Two arrays that must agree in shape do not.
    #[error("{name} has shape {actual:?}, expected {expected:?}")]
    Shape {
        /// Name of the array.
        name: String,
        /// Shape given, `[nz, ny, nx]` without absent axes.
        actual: Vec<usize>,
        /// Shape wanted.
        expected: Vec<usize>,
    },
    /// A field stopped being finite.
    #[error("{name} became {value} at t = {t} at node {node}; reduce the time step")]
    NotFinite {
        /// Name of the field.
        name: String,
        /// NaN or an infinity.
        value: f64,
        /// Time at the start of the failing step.
        t: f64,
        /// First bad node, e.g. `(j, i) = (3, 17)`.
        node: String,
    },
    /// An array would not fit in memory.
    #[error("{name} of shape {shape:?} needs {needed} of memory, {available} is available")]
    TooLarge {
        /// Name of the quantity that is too large.
        name: String,
        /// Its shape.
        shape: Vec<usize>,
        /// What it needs, with a unit.
        needed: String,
        /// What there is, with a unit.
        available: String,
    },
    /// Anything else that makes an input unusable; the text says all.
    #[error("{0}")]
    Invalid(String),
}

impl Error {
    /// An [`Error::OutOfRange`].
    pub fn out_of_range(name: &str, value: f64, range: &str) -> Self {
        Self::OutOfRange { name: name.into(), value, range: range.into() }
    }
}
