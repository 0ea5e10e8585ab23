use super::Reaction;
use crate::{Error, Grid, Result};
use rayon::prelude::*;

/// Nodes per call of a reaction: large enough to hide the call, small enough that
/// all species of a chunk stay in the first-level caches.
const CHUNK: usize = 4096;

/// Evaluates the reaction on whole fields, chunks in parallel.
pub(super) fn evaluate(reaction: &dyn Reaction, u: &[Vec<f64>], rates: &mut [Vec<f64>]) {
    let mut chunks: Vec<Vec<&mut [f64]>> = Vec::new();
    for field in rates {
        for (c, piece) in field.chunks_mut(CHUNK).enumerate() {
            if c == chunks.len() {
                chunks.push(Vec::with_capacity(u.len()));
            }
            chunks[c].push(piece);
        }
    }
    chunks.par_iter_mut().enumerate().for_each(|(c, out)| {
        let first = c * CHUNK;
        let length = out.first().map_or(0, |piece| piece.len());
        let u: Vec<&[f64]> = u.iter().map(|field| &field[first..first + length]).collect();
        reaction.rates(first, &u, out);
    });
}

/// Refuses a state or reaction that does not fit the stepper.
pub(super) fn check(
    grid: Grid,
    species: usize,
    reaction: &dyn Reaction,
    u: &[Vec<f64>],
) -> Result<()> {
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
