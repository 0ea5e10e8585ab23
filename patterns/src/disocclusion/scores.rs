//! The scores of section 1.4.1 of the paper, and the one that it names.
//!
//! Both pictures hold 1 for ink and 0 for paper; only visible pixels count.

use super::{candidate::Ink, normalize::Normal};

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

fn pairs<'a>(normal: &'a Normal, candidate: &'a Ink) -> impl Iterator<Item = (bool, bool)> + 'a {
    let pixels = normal.ink.iter().zip(&candidate.ink).zip(&normal.visible);
    pixels.filter(|(_, seen)| **seen).map(|((&a, &b), _)| (a, b))
}
