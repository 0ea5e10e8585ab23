//! The configuration of an atlas.

use crate::curvature::config::positive;
use crate::curvature::grow::Growth;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use solvers::transport::{CoarseSinkhorn, Sinkhorn};

/// A complete configuration; lengths are in the units of `growth.spacing`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Config {
    /// Shapes of the atlas.
    pub(super) count: usize,
    /// Most draws of parameters, viable or not; absent: 20 for each shape.
    pub(super) draws: Option<usize>,
    /// How each shape is grown.
    pub(super) growth: Growth,
    /// Parameters are drawn uniformly from these.
    pub(super) ranges: Ranges,
    /// How distances are measured.
    pub(super) distance: Distance,
    /// How the map is drawn from the distances.
    pub(super) map: Map,
}

/// Ranges of parameters `[low, high]`; a20 is 1. Song 2021, section 4.5.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Ranges {
    a11: [f64; 2],
    a02: [f64; 2],
    b10: [f64; 2],
    b01: [f64; 2],
    c: [f64; 2],
    mass: [f64; 2],
}

/// Distances between curvature diagrams.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Distance {
    /// Resolution of the transport (1/length).
    pub(crate) blur: f64,
    /// How far mass is carried (1/length).
    pub(crate) reach: f64,
    /// Diagrams are binned in cells of this side (1/length): twice the blur is within 2 %.
    pub(crate) cell: f64,
}

/// UMAP and HDBSCAN.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Map {
    /// Neighbours that make up the surroundings of a shape.
    pub(super) neighbors: usize,
    /// Least distance in the map.
    pub(super) min_dist: f64,
    /// Scale of the map.
    pub(super) spread: f64,
    /// Seed of the map.
    pub(super) seed: u64,
    /// Fewest shapes of a cluster.
    pub(super) cluster: usize,
    /// Neighbours whose farthest sets the density.
    pub(super) samples: usize,
    /// Shapes that are shown.
    pub(super) pictures: usize,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            count: 1000,
            draws: None,
            growth: Growth::default(),
            ranges: Ranges::default(),
            distance: Distance::default(),
            map: Map::default(),
        }
    }
}

impl Default for Ranges {
    fn default() -> Self {
        Self {
            a11: [-4.0, 4.0],
            a02: [1.0 / 15.0, 15.0],
            b10: [-200.0, 200.0],
            b01: [-200.0, 200.0],
            c: [-3000.0, 3000.0],
            mass: [-0.75, -0.15],
        }
    }
}

impl Default for Distance {
    fn default() -> Self {
        Self { blur: 1.0, reach: 20.0, cell: 2.0 }
    }
}

impl Default for Map {
    fn default() -> Self {
        Self {
            neighbors: 25,
            min_dist: 0.05,
            spread: 1.0,
            seed: 1,
            cluster: 10,
            samples: 10,
            pictures: 20,
        }
    }
}

impl Config {
    /// Refuses values out of range.
    pub(super) fn check(&self) -> Result<()> {
        whole("count", self.count, 3, 20_000)?;
        whole("draws", self.most_draws(), self.count, 10_000_000)?;
        self.growth.check("growth")?;
        self.ranges.check("ranges")?;
        self.distance.check("distance")?;
        whole("map.neighbors", self.map.neighbors, 2, 1000)?;
        positive("map.spread", self.map.spread)?;
        if !(0.0..=self.map.spread).contains(&self.map.min_dist) {
            let range = format!("[0, {}]", self.map.spread);
            return Err(Error::range("map.min_dist", self.map.min_dist, &range));
        }
        whole("map.cluster", self.map.cluster, 2, 20_000)?;
        whole("map.samples", self.map.samples, 1, 20_000)?;
        whole("map.pictures", self.map.pictures, 0, 30)
    }

    /// Most draws of parameters.
    pub(super) fn most_draws(&self) -> usize {
        self.draws.unwrap_or(self.count.saturating_mul(20))
    }
}

impl Ranges {
    pub(crate) fn check(&self, key: &str) -> Result<()> {
        let ranges = self.list();
        for (name, [low, high]) in NAMES.iter().zip(ranges) {
            let good = low.is_finite() && high.is_finite() && low <= high;
            if !good {
                let wanted = format!("two finite numbers, the lesser first, found [{low}, {high}]");
                return Err(Error::config(&format!("{key}.{name}"), wanted));
            }
        }
        // a20 is 1; the flow's preconditioner wants a positive sum.
        if ranges[1][0] <= -1.0 {
            return Err(Error::range(&format!("{key}.a02"), ranges[1][0], "(-1, inf)"));
        }
        if !(ranges[5][0] > -1.0 && ranges[5][1] < 1.0) {
            return Err(Error::config(&format!("{key}.mass"), "the mass lies in (-1, 1)"));
        }
        Ok(())
    }

    /// In the order of [`NAMES`].
    pub(crate) fn list(&self) -> [[f64; 2]; 6] {
        [self.a11, self.a02, self.b10, self.b01, self.c, self.mass]
    }
}

/// The parameters that are drawn.
pub(crate) const NAMES: [&str; 6] = ["a11", "a02", "b10", "b01", "c", "mass"];

impl Distance {
    pub(crate) fn check(&self, key: &str) -> Result<()> {
        positive(&format!("{key}.blur"), self.blur)?;
        positive(&format!("{key}.reach"), self.reach)?;
        positive(&format!("{key}.cell"), self.cell)
    }

    /// The transport that compares diagrams of voxels of width `spacing`.
    pub(crate) fn transport(&self, spacing: f64) -> Result<CoarseSinkhorn> {
        // The finest curvature of a grid is far below 4 / spacing.
        let diameter = (4.0 / spacing).max(self.blur);
        let sinkhorn = Sinkhorn {
            blur: self.blur,
            reach: Some(self.reach),
            diameter: Some(diameter),
            ..Sinkhorn::default()
        };
        Ok(CoarseSinkhorn::new(sinkhorn, self.cell)?)
    }
}

/// Refuses numbers outside `[low, high]`.
pub(crate) fn whole(key: &str, value: usize, low: usize, high: usize) -> Result<()> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(Error::range(key, value as f64, &format!("[{low}, {high}]")))
}
