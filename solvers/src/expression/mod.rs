//! Formulas given as text, compiled once and evaluated on slices.
//!
//! [`Expression::parse`] reads a formula of named variables, [`Program::new`] compiles
//! several of them together, so that what they share is computed once, and
//! [`Program::evaluate`] runs the program on 256 nodes at a time, each operation on whole
//! vectors. [`FormulaReaction`] makes a reaction of a system of formulas.
//!
//! ```
//! use solvers::expression::{Expression, Input, Program, Scratch};
//! let names = ["u", "v", "feed", "kill"];
//! let rates = [
//!     Expression::parse("feed*(1 - u) - u*v^2", &names)?,
//!     Expression::parse("u*v^2 - (feed + kill)*v", &names)?,
//! ];
//! let program = Program::new(&rates)?;
//! let (u, v) = ([1.0, 0.5], [0.0, 0.25]);
//! let inputs = [Input::Slice(&u), Input::Slice(&v), Input::Uniform(0.04), Input::Uniform(0.06)];
//! let (mut du, mut dv) = ([0.0; 2], [0.0; 2]);
//! program.evaluate(&inputs, &mut [&mut du, &mut dv], &mut Scratch::default());
//! assert_eq!(du, [0.0, 0.04 * (1.0 - 0.5) - 0.5 * (0.25 * 0.25)]);
//! assert_eq!(rates[0].derivative(1).to_string(), "-(u*(2*v))");
//! # Ok::<(), solvers::Error>(())
//! ```
//!
//! # The language
//! Numbers (`1e-3`, `.5`), names, `pi`, `e`, `tau` (unless a variable has the name),
//! `+ - * / ^`, parentheses, `< <= > >= ==` with the value 1 or 0, and functions:
//!
//! | functions | value |
//! |-----------|-------|
//! | `abs sqrt exp log log10 sin cos tan asin acos atan sinh cosh tanh` | as usual; `log` is natural, angles in radians |
//! | `floor ceil round sign` | `round` takes halves away from 0; `sign(0) = 0` |
//! | `step(x)` | 1 for x >= 0, else 0 |
//! | `min(a, b, ...)  max(a, b, ...)` | NaN if an argument is NaN |
//! | `clamp(x, lo, hi)` | `min(max(x, lo), hi)` |
//! | `where(c, a, b)` | a for c other than 0, else b |
//! | `atan2(y, x)  hypot(x, y)  pow(x, y)` | `pow(x, y) = x^y` |
//! | `hill(x, k, n)` | `x^n/(k^n + x^n)` |
//!
//! `^` groups to the right and binds more strongly than a sign: `-x^2 = -(x^2)`.
//! Comparisons do not chain.
//!
//! # What is computed
//! The operations as written, each rounded once, on every machine and for any length of
//! the slices: the same bytes (except which NaN it is). Numbers are folded when the formula
//! is read. `x^n` for whole `|n| <= 16` is done by multiplications, digit by digit of n in
//! base 2 from the left (`x^3 = (x x) x`, `x^4 = (x x)(x x)`, `x^-2 = 1/(x x)`), `x^0.5` by
//! `sqrt`; whether n is a number, a parameter or a map makes no difference.

mod derivative;
mod display;
mod error;
mod evaluate;
mod graph;
mod lexer;
mod op;
mod parser;
mod program;
mod reaction;

#[cfg(test)]
mod tests;

pub use error::ParseError;
pub use evaluate::{Input, Scratch};
pub use program::Program;
pub use reaction::FormulaReaction;

use graph::{Graph, Id};
use std::fmt;

/// A formula of named variables. Its text (`to_string`) reads back as the same program,
/// if it is not longer or deeper than what [`Expression::parse`] takes.
#[derive(Clone, Debug)]
pub struct Expression {
    names: Vec<String>,
    graph: Graph,
    root: Id,
}

impl Expression {
    /// Reads a formula of the variables `names`, which are numbered in this order.
    ///
    /// Names consist of letters, digits and `_` and begin with no digit.
    ///
    /// # Errors
    /// If the text is no formula, with the place and what was expected there; if it is longer
    /// than 10000 bytes or nested deeper than 200 levels.
    pub fn parse(text: &str, names: &[&str]) -> Result<Self, ParseError> {
        let (graph, root) = parser::parse(text, names)?;
        Ok(Self { names: names.iter().map(|&name| name.into()).collect(), graph, root })
    }

    /// Names of the variables, in order.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The derivative by variable number `variable`, in the same variables.
    ///
    /// Where a function has a step or a corner, the value on one side of it: comparisons,
    /// `floor`, `ceil`, `round` and `sign` have derivative 0, `abs` has 0 at 0, `min` and
    /// `max` at equal arguments that of the second. `x^y` with a `y` that depends on the
    /// variable needs x > 0.
    #[must_use]
    pub fn derivative(&self, variable: usize) -> Self {
        let mut derived = self.clone();
        derived.root = derivative::derivative(&mut derived.graph, self.root, variable);
        derived
    }
}

impl fmt::Display for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        display::write(&self.graph, self.root, &self.names, f)
    }
}
