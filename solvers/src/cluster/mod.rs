//! Clusters of points that are known by their mutual distances: HDBSCAN.
//!
//! Source: Campello, Moulavi and Sander 2013, "Density-based clustering based on
//! hierarchical density estimates"; the conventions are those of McInnes, Healy and
//! Astels 2017 (the `hdbscan` Python package), which count neighbours without the point itself.

mod condensed;
mod spanning_tree;
#[cfg(test)]
mod tests;

use crate::distances::check_distances;
use crate::{Error, Result};
use condensed::CondensedTree;
use ndarray::ArrayView2;

/// Hierarchical density-based clustering; clusters are those of greatest excess of mass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hdbscan {
    /// Fewest points of a cluster, at least 2.
    pub min_cluster_size: usize,
    /// Neighbours whose farthest sets the density at a point, at least 1; no more than
    /// there are are used.
    pub min_samples: usize,
}

impl Default for Hdbscan {
    /// 10 and 10, the settings of the curvature atlas.
    fn default() -> Self {
        Self { min_cluster_size: 10, min_samples: 10 }
    }
}

/// What [`Hdbscan::labels`] finds.
#[derive(Clone, Debug, PartialEq)]
pub struct Clusters {
    /// Cluster of each point, numbered by their first points; `None` is noise.
    pub labels: Vec<Option<usize>>,
    /// How firmly each point belongs to its cluster, in [0, 1]; 0 for noise.
    pub strengths: Vec<f64>,
    /// Number of clusters.
    pub count: usize,
}

impl Hdbscan {
    /// Clusters of `n` points from `distances`, shape `[n, n]`, symmetric, zero on the
    /// diagonal. The whole set is never one cluster. Cost O(n^2) time, O(n) memory beside the input.
    ///
    /// # Errors
    /// If a setting is outside its range, or the distances are no square of finite,
    /// symmetric, non-negative numbers.
    pub fn labels(&self, distances: ArrayView2<'_, f64>) -> Result<Clusters> {
        if self.min_cluster_size < 2 {
            let value = self.min_cluster_size as f64;
            return Err(Error::out_of_range("min_cluster_size", value, "[2, inf)"));
        }
        if self.min_samples < 1 {
            return Err(Error::out_of_range("min_samples", 0.0, "[1, inf)"));
        }
        let n = check_distances(distances)?;
        let edges = spanning_tree::mutual_reachability_tree(distances, self.min_samples.min(n - 1));
        Ok(CondensedTree::new(n, &edges, self.min_cluster_size).clusters())
    }
}
