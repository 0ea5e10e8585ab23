//! Maps of points that are known by their mutual distances: classical scaling and UMAP.

mod curve;
mod fuzzy;
mod layout;
mod scaling;
#[cfg(test)]
mod tests;

pub use scaling::classical_scaling;

use crate::distances::check_distances;
use crate::{Error, Result};
use ndarray::ArrayView2;

/// Uniform manifold approximation and projection onto the plane.
///
/// Source: McInnes, Healy and Melville 2018, arXiv:1802.03426; constants and details are
/// those of the Python package umap-learn with `metric="precomputed"`, but for the start,
/// which is classical scaling of all distances (as good as spectral coordinates: Kobak and
/// Linderman 2021) and keeps its proportions, and the random numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Umap {
    /// Neighbours that make up the surroundings of a point, itself among them, at least 2;
    /// no more than there are points are used.
    pub neighbors: usize,
    /// Distance in the map below which points are not drawn together, in `[0, spread]`.
    pub min_dist: f64,
    /// Scale of the map, positive.
    pub spread: f64,
    /// Passes over the edges of the graph.
    pub epochs: usize,
    /// Seed of the negative samples.
    pub seed: u64,
}

impl Default for Umap {
    /// 25 neighbours, minimal distance 0.05, spread 1, 500 epochs: the curvature atlas.
    fn default() -> Self {
        Self { neighbors: 25, min_dist: 0.05, spread: 1.0, epochs: 500, seed: 0 }
    }
}

impl Umap {
    /// Positions in the plane of `n` points from `distances`, shape `[n, n]`, symmetric,
    /// zero on the diagonal. One thread; the same bytes for the same seed. Cost O(n^2) and
    /// about 50 ns for each of `6 epochs` times a half to all edges of the graph.
    ///
    /// # Errors
    /// If a setting is outside its range, or the distances are no square of finite,
    /// symmetric, non-negative numbers.
    pub fn embed(&self, distances: ArrayView2<'_, f64>) -> Result<Vec<[f64; 2]>> {
        if self.neighbors < 2 {
            return Err(Error::out_of_range("neighbors", self.neighbors as f64, "[2, inf)"));
        }
        if !(self.spread > 0.0 && self.spread.is_finite()) {
            return Err(Error::out_of_range("spread", self.spread, "(0, inf)"));
        }
        if !(0.0..=self.spread).contains(&self.min_dist) {
            return Err(Error::out_of_range("min_dist", self.min_dist, "[0, spread]"));
        }
        check_distances(distances)?;
        let edges = fuzzy::fuzzy_graph(distances, self.neighbors);
        let start = classical_scaling(distances)?;
        Ok(layout::optimize(start, &edges, curve::fit(self.spread, self.min_dist), *self))
    }
}
