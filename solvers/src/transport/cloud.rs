//! Weighted points, sorted along a space-filling curve.

use super::kernel::BLOCK;
use crate::{Error, Result};
use std::cmp::Ordering;

/// A cloud of weighted points in `D` dimensions.
///
/// The points are kept along a Morton curve, so that neighbours in memory are
/// neighbours in space: whole blocks can then be left out of a sum at once, and
/// results do not depend on the order in which the points were given.
#[derive(Clone, Debug, PartialEq)]
pub struct PointCloud<const D: usize> {
    /// Coordinates of all points, axis by axis (length).
    pub(super) axes: [Vec<f64>; D],
    weights: Vec<f64>,
    /// Logarithms to the base 2 of the weights.
    pub(super) log_weights: Vec<f64>,
    /// Least and greatest coordinates of each block of points, axis by axis.
    pub(super) blocks: [[Vec<f64>; 2]; D],
}

impl<const D: usize> PointCloud<D> {
    /// `points` (length) with `weights` (mass); points of no weight are dropped.
    ///
    /// # Errors
    /// If the numbers of points and weights differ, none has weight, a coordinate is not
    /// finite, or a weight is negative or not finite.
    pub fn new(points: &[[f64; D]], weights: &[f64]) -> Result<Self> {
        if points.len() != weights.len() {
            return Err(Error::Shape {
                name: "weights".into(),
                actual: vec![weights.len()],
                expected: vec![points.len()],
            });
        }
        if let Some(&bad) = points.iter().flatten().find(|v| !v.is_finite()) {
            return Err(Error::out_of_range("coordinate of a point", bad, "(-inf, inf)"));
        }
        if let Some(&bad) = weights.iter().find(|w| !(**w >= 0.0 && w.is_finite())) {
            return Err(Error::out_of_range("weight of a point", bad, "[0, inf)"));
        }
        let all = points.iter().copied().zip(weights.iter().copied());
        let cloud: Vec<_> = all.filter(|(_, weight)| *weight > 0.0).collect();
        if cloud.is_empty() {
            return Err(Error::Invalid("a cloud has no point of positive weight".into()));
        }
        Ok(Self::sorted(cloud).0)
    }

    /// The cloud along the curve, and the place that each point has got.
    fn sorted(cloud: Vec<([f64; D], f64)>) -> (Self, Vec<u32>) {
        let mut low = [f64::INFINITY; D];
        let mut side = 0.0_f64;
        for (d, low) in low.iter_mut().enumerate() {
            *low = cloud.iter().fold(f64::INFINITY, |m, (x, _)| m.min(x[d]));
            side = cloud.iter().fold(side, |m, (x, _)| m.max(x[d] - *low));
        }
        let key = |(n, (x, w))| (morton(x, low, side), x, w, n);
        let mut keyed: Vec<_> = cloud.into_iter().enumerate().map(key).collect();
        keyed.sort_by(|(k, x, w, _), (l, y, v, _)| {
            let ties = || x.iter().zip(y).map(|(a, b)| a.total_cmp(b));
            let place = || ties().fold(Ordering::Equal, Ordering::then);
            k.cmp(l).then_with(place).then_with(|| w.total_cmp(v))
        });
        let mut places = vec![0; keyed.len()];
        for (place, &(.., n)) in keyed.iter().enumerate() {
            places[n] = place as u32;
        }
        let axes: [Vec<f64>; D] =
            std::array::from_fn(|d| keyed.iter().map(|(_, x, ..)| x[d]).collect());
        let weights: Vec<f64> = keyed.iter().map(|&(_, _, w, _)| w).collect();
        let log_weights = weights.iter().map(|&w| libm::log2(w)).collect();
        let blocks = std::array::from_fn(|d| {
            let extreme = |start: f64, pick: fn(f64, f64) -> f64| {
                axes[d].chunks(BLOCK).map(|x| x.iter().copied().fold(start, pick)).collect()
            };
            [extreme(f64::INFINITY, f64::min), extreme(f64::NEG_INFINITY, f64::max)]
        });
        (Self { axes, weights, log_weights, blocks }, places)
    }

    /// The cloud seen at a resolution: one point for each occupied cell of the lattice of
    /// side `cell` (length), at the centre of mass of its points.
    ///
    /// # Errors
    /// Unless `cell` is positive and finite.
    pub fn binned(&self, cell: f64) -> Result<Self> {
        if !(cell > 0.0 && cell.is_finite()) {
            return Err(Error::out_of_range("cell", cell, "(0, inf)"));
        }
        Ok(self.coarsened(cell).0)
    }

    /// [`PointCloud::binned`], and of each point the one that it went into.
    pub(super) fn coarsened(&self, cell: f64) -> (Self, Vec<u32>) {
        let mut order: Vec<([i64; D], usize)> = (0..self.len())
            .map(|n| (std::array::from_fn(|d| (self.axes[d][n] / cell).floor() as i64), n))
            .collect();
        order.sort_unstable();
        let mean = |group: &[([i64; D], usize)]| {
            let mass: f64 = group.iter().map(|&(_, n)| self.weights[n]).sum();
            let moment = |d: usize| -> f64 {
                group.iter().map(|&(_, n)| self.weights[n] * self.axes[d][n]).sum()
            };
            (std::array::from_fn(|d| moment(d) / mass), mass)
        };
        let groups = || order.chunk_by(|a, b| a.0 == b.0);
        let (coarse, places) = Self::sorted(groups().map(mean).collect());
        let mut parents = vec![0; self.len()];
        for (place, group) in places.iter().zip(groups()) {
            group.iter().for_each(|&(_, n)| parents[n] = *place);
        }
        (coarse, parents)
    }

    /// Number of points of positive weight.
    pub fn len(&self) -> usize {
        self.weights.len()
    }

    /// Whether there is no point; never true.
    pub fn is_empty(&self) -> bool {
        self.weights.is_empty()
    }

    /// The weights (mass), in the order in which the points are kept.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Coordinate `n` of axis `d` (length), in the order in which the points are kept.
    pub fn point(&self, n: usize) -> [f64; D] {
        std::array::from_fn(|d| self.axes[d][n])
    }

    /// Diagonal of the box around both clouds (length).
    pub fn diameter(&self, other: &Self) -> f64 {
        let side = |d: usize| {
            let both = || self.axes[d].iter().chain(&other.axes[d]).copied();
            both().fold(f64::NEG_INFINITY, f64::max) - both().fold(f64::INFINITY, f64::min)
        };
        (0..D).map(|d| side(d) * side(d)).sum::<f64>().sqrt()
    }
}

/// Place of `x` along the Morton curve through the cube of `side` at `low`.
fn morton<const D: usize>(x: [f64; D], low: [f64; D], side: f64) -> u64 {
    let bits = (63 / D).min(20);
    let cells = (1_u64 << bits) as f64;
    let scale = if side > 0.0 { cells / side } else { 0.0 };
    let place: [u64; D] =
        std::array::from_fn(|d| ((x[d] - low[d]) * scale).min(cells - 1.0) as u64);
    (0..bits).rev().fold(0, |key, bit| place.iter().fold(key, |key, p| key << 1 | (p >> bit & 1)))
}
