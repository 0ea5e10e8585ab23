use super::Reaction;
use crate::{Error, Grid, Result};
use rayon::prelude::*;

/// Nodes per call of a reaction: large enough to hide the call, small enough that
/// all species of a chunk stay in the first-level caches.
const CHUNK: usize = 4096;

/// Most species of a [`Reaction`] in a stepper: the list of their pieces stands on the stack of a call.
pub const MOST_SPECIES: usize = 32;

/// Evaluates the reaction on whole fields, fixed chunks in parallel, without allocating.
pub(super) fn evaluate(reaction: &dyn Reaction, u: &[Vec<f64>], rates: &mut [Vec<f64>]) {
    let mut inputs: [&[f64]; MOST_SPECIES] = [&[]; MOST_SPECIES];
    let mut outputs: [&mut [f64]; MOST_SPECIES] = std::array::from_fn(|_| &mut [][..]);
    for (input, field) in inputs.iter_mut().zip(u) {
        *input = field;
    }
    for (output, field) in outputs.iter_mut().zip(rates) {
        *output = field;
    }
    halve(reaction, u.len(), 0, inputs, outputs);
}

/// Evaluates at the nodes from `first` on: a chunk at once, more in two halves in parallel.
fn halve(
    reaction: &dyn Reaction,
    species: usize,
    first: usize,
    u: [&[f64]; MOST_SPECIES],
    mut rates: [&mut [f64]; MOST_SPECIES],
) {
    let chunks = u[0].len().div_ceil(CHUNK);
    if chunks < 2 {
        return reaction.rates(first, &u[..species], &mut rates[..species]);
    }
    let middle = chunks / 2 * CHUNK;
    let mut high: [&mut [f64]; MOST_SPECIES] = std::array::from_fn(|_| &mut [][..]);
    for (low, high) in rates[..species].iter_mut().zip(&mut high) {
        (*low, *high) = std::mem::take(low).split_at_mut(middle);
    }
    let part = |low: bool| {
        u.map(|u| match u.len() {
            0 => u,
            _ if low => &u[..middle],
            _ => &u[middle..],
        })
    };
    rayon::join(
        || halve(reaction, species, first, part(true), rates),
        || halve(reaction, species, first + middle, part(false), high),
    );
}

/// Refuses a state or reaction that does not fit the stepper.
pub(super) fn check(
    grid: Grid,
    species: usize,
    reaction: &dyn Reaction,
    u: &[Vec<f64>],
) -> Result<()> {
    if species > MOST_SPECIES {
        let range = format!("[1, {MOST_SPECIES}]");
        return Err(Error::out_of_range("number of species", species as f64, &range));
    }
    for (name, count) in [("species of the reaction", reaction.species()), ("species", u.len())] {
        if count != species {
            return Err(Error::Shape {
                name: name.into(),
                actual: vec![count],
                expected: vec![species],
            });
        }
    }
    match u.iter().position(|field| field.len() != grid.len()) {
        None => Ok(()),
        Some(s) => Err(Error::Shape {
            name: format!("concentration of species {s}"),
            actual: vec![u[s].len()],
            expected: grid.axes().to_vec(),
        }),
    }
}

/// Refuses a time step that is not positive and finite.
pub(super) fn check_dt(dt: f64) -> Result<()> {
    if dt > 0.0 && dt.is_finite() {
        return Ok(());
    }
    Err(Error::out_of_range("dt", dt, "(0, inf)"))
}

/// `out = f(out, inputs)`, number by number.
pub(super) fn combine<const N: usize>(
    out: &mut [f64],
    inputs: [&[f64]; N],
    f: impl Fn(f64, [f64; N]) -> f64 + Sync,
) {
    out.par_chunks_mut(CHUNK).enumerate().for_each(|(c, out)| {
        let inputs = inputs.map(|values| &values[c * CHUNK..][..out.len()]);
        for (i, out) in out.iter_mut().enumerate() {
            *out = f(*out, inputs.map(|values| values[i]));
        }
    });
}
