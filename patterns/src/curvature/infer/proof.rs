//! What the parameters that were found grow, from several noises.

use super::search::{self, Search, Target};
use crate::Result;
use crate::curvature::grow::Shape;
use rayon::prelude::*;
use solvers::transport::PreparedCloud;

/// Noises that the parameters are grown from, the search's own first.
const NOISES: u64 = 3;

/// What was found, and how far it is to be trusted.
pub(super) struct Found {
    pub(super) parameters: [f64; 6],
    /// Grown from the search's noise.
    pub(super) shape: Box<Shape>,
    /// Its distance from the given shape.
    pub(super) distance: f64,
    /// Mean distance from the given shape if it grows from other noises.
    pub(super) again: f64,
    /// Mean distance between the shapes of two noises.
    pub(super) floor: f64,
    /// Least and greatest parameters of all candidates that are farther from the given shape by
    /// no more than that: diagrams do not tell them from the ones that were found.
    pub(super) ranges: [[f64; 2]; 5],
    /// Their number.
    pub(super) near: usize,
}

impl Found {
    /// Of the search's best; none if it grows nothing, or from its own noise only.
    ///
    /// # Errors
    /// If coefficients are refused.
    pub(super) fn new(search: &Search, target: Target<'_>) -> Result<Option<Self>> {
        let Some(parameters) = search.best().map(|best| best.parameters) else { return Ok(None) };
        let grow =
            |noise: u64| search::grow(target.config, parameters, target.seed.wrapping_add(noise));
        let shapes: Result<Vec<_>> = (0..NOISES).into_par_iter().map(grow).collect();
        let mut shapes = shapes?.into_iter();
        let Some(Some(shape)) = shapes.next() else { return Ok(None) };
        let others: Vec<Box<Shape>> = shapes.flatten().collect();
        let away = |shape: &Shape, from: &PreparedCloud<2>| {
            search::distance(Some(shape), Target { wanted: from, ..target })
        };
        let (mut again, mut pairs) = (Vec::new(), Vec::new());
        for (n, other) in others.iter().enumerate() {
            again.push(away(other, target.wanted)?);
            let own = target.transport.prepare(&other.diagram)?;
            for before in std::iter::once(&shape).chain(&others[..n]) {
                pairs.push(away(before, &own)?);
            }
        }
        if again.is_empty() {
            return Ok(None);
        }
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let (distance, floor) = (away(&shape, target.wanted)?, mean(&pairs));
        let within = distance + floor;
        let (ranges, near) = (search.ranges(within), search.within(within).count());
        Ok(Some(Self { parameters, shape, distance, again: mean(&again), floor, ranges, near }))
    }

    /// What there is to be said of it.
    pub(super) fn notes(&self, search: &Search) -> Vec<String> {
        let (near, all) = (self.near, search.candidates.len());
        let mut notes =
            vec![format!("the ranges of the parameters are those of {near} of {all} candidates")];
        if self.distance > self.floor {
            notes.push(format!(
                "the shape that was found is {:.2} from the given one, two noises {:.2} from each \
                 other: more generations may come nearer",
                self.distance, self.floor
            ));
        }
        notes
    }
}

/// Why nothing was found.
pub(super) fn refused(search: &Search) -> String {
    match search.best() {
        Some(best) => format!(
            "the nearest candidate, {:.2} away, does not grow from another noise: {:?}",
            best.distance, best.parameters
        ),
        None => "no candidate of the search grew a shape".into(),
    }
}
