//! A system of reactions given by formulas.

use super::{Expression, Input, Program, Scratch};
use crate::diffusion::Reaction;
use crate::diffusion::explicit::Parameter;
use crate::{Error, Result};
use nalgebra::DMatrix;
use std::sync::Mutex;

/// Most species and parameters together: their list stands on the stack of a call.
const MAX_VARIABLES: usize = 64;

/// The rates `f_s(u, p)` of species by formulas in the names of species and parameters.
///
/// ```
/// use solvers::diffusion::{Reaction, explicit::Parameter};
/// use solvers::expression::FormulaReaction;
/// let species = [("u", "feed*(1 - u) - u*v^2"), ("v", "u*v^2 - (feed + kill)*v")];
/// let parameters = [("feed", Parameter::Uniform(0.04)), ("kill", Parameter::Uniform(0.06))];
/// let reaction = FormulaReaction::new(&species, &parameters)?;
/// let (mut du, mut dv) = ([0.0; 1], [0.0; 1]);
/// reaction.rates(0, &[&[1.0], &[0.5]], &mut [&mut du, &mut dv]);
/// assert_eq!(du, [-0.25]);
/// # Ok::<(), solvers::Error>(())
/// ```
#[derive(Debug)]
pub struct FormulaReaction {
    names: Vec<String>,
    parameters: Vec<Parameter>,
    rates: Vec<Expression>,
    program: Program,
    /// As many as there were calls at the same time.
    scratch: Mutex<Vec<Scratch>>,
}

impl FormulaReaction {
    /// From pairs of a species and the formula of its rate, and of a parameter and its value.
    /// Maps have one value for each node that [`Reaction::rates`] will be asked for.
    ///
    /// # Errors
    /// If a formula cannot be read (the message names its species); if a name is not made of
    /// letters, digits and `_`, or is given twice; for no species, or more than 64 names.
    pub fn new(species: &[(&str, &str)], parameters: &[(&str, Parameter)]) -> Result<Self> {
        let names: Vec<&str> =
            species.iter().map(|s| s.0).chain(parameters.iter().map(|p| p.0)).collect();
        check_names(&names, species.len())?;
        let mut rates = Vec::new();
        for (name, text) in species {
            let rate = Expression::parse(text, &names).map_err(|error| {
                Error::Invalid(format!("in the formula of species `{name}`: {error}"))
            })?;
            rates.push(rate);
        }
        let program = Program::new(&rates)?;
        Ok(Self {
            names: names.into_iter().map(String::from).collect(),
            parameters: parameters.iter().map(|(_, value)| value.clone()).collect(),
            rates,
            program,
            scratch: Mutex::default(),
        })
    }

    /// Names of the species, in order.
    pub fn species_names(&self) -> &[String] {
        &self.names[..self.rates.len()]
    }

    /// The formulas of the rates; their variables are the species and then the parameters.
    pub fn formulas(&self) -> &[Expression] {
        &self.rates
    }

    /// Gives a parameter another value.
    ///
    /// # Errors
    /// If there is none of this name.
    pub fn set_parameter(&mut self, name: &str, value: Parameter) -> Result<()> {
        let names = &self.names[self.rates.len()..];
        let Some(index) = names.iter().position(|known| known == name) else {
            let known = names.join(", ");
            return Err(Error::Invalid(format!("unknown parameter `{name}`; known: {known}")));
        };
        self.parameters[index] = value;
        Ok(())
    }

    /// The Jacobian `d f_s / d u_r` (row s, column r) of the concentrations `u` at `node`,
    /// from the formulas' derivatives.
    ///
    /// # Errors
    /// If `u` has another length than there are species.
    pub fn jacobian(&self, node: usize, u: &[f64]) -> Result<DMatrix<f64>> {
        let n = self.rates.len();
        if u.len() != n {
            return Err(Error::Shape {
                name: "concentrations".into(),
                actual: vec![u.len()],
                expected: vec![n],
            });
        }
        let entries: Vec<Expression> =
            self.rates.iter().flat_map(|rate| (0..n).map(|r| rate.derivative(r))).collect();
        let parameters = self.parameters.iter().map(|parameter| parameter.at(node));
        let inputs: Vec<Input<'_>> =
            u.iter().copied().chain(parameters).map(Input::Uniform).collect();
        let mut values = vec![0.0; n * n];
        let mut outputs: Vec<&mut [f64]> = values.chunks_mut(1).collect();
        Program::new(&entries)?.evaluate(&inputs, &mut outputs, &mut Scratch::default());
        Ok(DMatrix::from_row_slice(n, n, &values))
    }

    /// A work space that no other call uses; it is a new one if all are in use.
    fn borrow(&self) -> Scratch {
        self.scratch.lock().ok().and_then(|mut pool| pool.pop()).unwrap_or_default()
    }
}

impl Reaction for FormulaReaction {
    fn species(&self) -> usize {
        self.rates.len()
    }

    fn rates(&self, first: usize, u: &[&[f64]], rates: &mut [&mut [f64]]) {
        let n = u.first().map_or(0, |values| values.len());
        let mut inputs = [Input::Uniform(0.0); MAX_VARIABLES];
        let inputs = &mut inputs[..self.names.len()];
        let (species, parameters) = inputs.split_at_mut(self.rates.len());
        for (input, values) in species.iter_mut().zip(u) {
            *input = Input::Slice(values);
        }
        for (input, parameter) in parameters.iter_mut().zip(&self.parameters) {
            *input = match parameter {
                Parameter::Uniform(value) => Input::Uniform(*value),
                Parameter::Map(field) => Input::Slice(&field.as_slice()[first..first + n]),
            };
        }
        let mut scratch = self.borrow();
        self.program.evaluate(inputs, rates, &mut scratch);
        if let Ok(mut pool) = self.scratch.lock() {
            pool.push(scratch);
        }
    }
}

fn check_names(names: &[&str], species: usize) -> Result<()> {
    if species == 0 || names.len() > MAX_VARIABLES {
        let found = names.len();
        return Err(Error::Invalid(format!(
            "a system of formulas has 1 to {MAX_VARIABLES} species and parameters, found {species} \
             species of {found} names"
        )));
    }
    for (k, name) in names.iter().enumerate() {
        let begins = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
        if !begins || !name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
            return Err(Error::Invalid(format!(
                "the name `{name}` is not made of letters, digits and `_`, beginning with no digit"
            )));
        }
        if names[..k].contains(name) {
            return Err(Error::Invalid(format!("the name `{name}` is given twice")));
        }
    }
    Ok(())
}
