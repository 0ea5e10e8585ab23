//! The scores of section 1.4.1 of the paper, and the one that it names.
//!
//! Both pictures hold 1 for ink and 0 for paper; only visible pixels count.

use super::{
    candidate::{Ink, watch},
    class::Class,
    normalize::Normal,
    pixels::phi_coefficient,
    place::Placement,
};
use crate::{Inputs, Result};

/// The paper's "MSE" as it is defined there: the sum of the products of the pixels. It grows
/// with agreement; the paper takes the least.
pub fn sum_of_products(normal: &Normal, candidate: &Ink) -> f64 {
    pairs(normal, candidate).filter(|&(a, b)| a && b).count() as f64
}

/// Mean squared error over the visible pixels; 0 if none is visible.
pub fn mean_squared_error(normal: &Normal, candidate: &Ink) -> f64 {
    let count = pairs(normal, candidate).count().max(1) as f64;
    pairs(normal, candidate).filter(|(a, b)| a != b).count() as f64 / count
}

/// The paper's score as what it is: Pearson's correlation over the visible pixels, in [-1, 1];
/// 0 if either picture has one colour.
pub fn correlation(normal: &Normal, candidate: &Ink) -> f64 {
    let mut table = [[0.0; 2]; 2];
    pairs(normal, candidate).for_each(|(a, b)| table[usize::from(a)][usize::from(b)] += 1.0);
    phi_coefficient(table)
}

/// The three scores of a run at an iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// Iteration of the run.
    pub iteration: u64,
    /// As [`sum_of_products`].
    pub sum_of_products: f64,
    /// As [`correlation`].
    pub correlation: f64,
    /// As [`mean_squared_error`].
    pub mean_squared_error: f64,
}

impl Score {
    /// Of a candidate of the picture's shape, after `iteration` iterations of its run.
    pub fn new(normal: &Normal, placed: &Ink, iteration: u64) -> Self {
        Self {
            iteration,
            sum_of_products: sum_of_products(normal, placed),
            correlation: correlation(normal, placed),
            mean_squared_error: mean_squared_error(normal, placed),
        }
    }
}

/// Runs `class` at `point` and scores it about `count` times on its way, as figures 1.7(c) and
/// 1.8(c) of the paper do; the last score is of the end.
///
/// # Errors
/// What the model refuses or meets on its way.
pub fn by_iteration(
    normal: &Normal,
    placement: Placement,
    (class, point, seed): (&Class, &[f64], u64),
    count: u64,
    inputs: &dyn Inputs,
) -> Result<Vec<Score>> {
    let mut scores = Vec::new();
    watch(class, point, seed, count, inputs, &mut |iteration, pattern| {
        let placed = placement.place(&pattern, normal.shape);
        scores.push(Score::new(normal, &placed, iteration));
        true
    })?;
    Ok(scores)
}

fn pairs<'a>(normal: &'a Normal, candidate: &'a Ink) -> impl Iterator<Item = (bool, bool)> + 'a {
    let pixels = normal.ink.iter().zip(&candidate.ink).zip(&normal.visible);
    pixels.filter(|(_, seen)| **seen).map(|((&a, &b), _)| (a, b))
}
