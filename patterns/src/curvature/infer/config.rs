//! The configuration of an inference.

use crate::curvature::atlas::{Distance, Ranges, whole};
use crate::curvature::config::Size;
use crate::curvature::grow::Growth;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// A complete configuration; lengths are in the units of `growth.spacing`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Config {
    /// The shape: a volume of three axes, or a closed mesh.
    pub(super) shape: String,
    /// Width of the volume's voxels; of a mesh, of the voxels that it is read with. Absent:
    /// `growth.spacing`.
    pub(super) spacing: Option<f64>,
    /// Level of the volume's surface; absent: 0 if the values have both signs, else half way
    /// between least and greatest.
    pub(super) level: Option<f64>,
    /// Voxels of this value are inside, all others outside.
    pub(super) label: Option<f64>,
    /// On which side of the level the shape is.
    pub(super) inside: Inside,
    /// Standard deviation of the blur of a volume of two values (voxels).
    pub(super) smooth: f64,
    /// Output folder of an atlas; absent: one is drawn first.
    pub(super) atlas: Option<String>,
    /// Shapes of the atlas that is drawn where none is given.
    pub(super) count: usize,
    /// Nearest shapes of the atlas that are told, and grown with the given shape's mass.
    pub(super) nearest: usize,
    /// Number of the best of these at which the search begins.
    pub(super) starts: usize,
    /// Generations of the search.
    pub(super) generations: u64,
    /// First width of the search, as part of the ranges.
    pub(super) width: f64,
    /// How shapes are grown.
    pub(super) growth: Growth,
    /// Where parameters are looked for; the mass is the shape's own.
    pub(super) ranges: Ranges,
    /// How distances are measured.
    pub(super) distance: Distance,
}

/// A side of a level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Inside {
    /// Values above the level.
    #[default]
    Above,
    /// Values below the level.
    Below,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            shape: String::new(),
            spacing: None,
            level: None,
            label: None,
            inside: Inside::default(),
            smooth: 1.5,
            atlas: None,
            count: 64,
            nearest: 8,
            starts: 3,
            generations: 32,
            width: 0.12,
            growth: Growth { size: Size::Cube(48), evaluations: 200, ..Growth::default() },
            ranges: Ranges::default(),
            distance: Distance::default(),
        }
    }
}

impl Config {
    /// Refuses values out of range.
    pub(super) fn check(&self) -> Result<()> {
        if self.shape.is_empty() {
            return Err(Error::config("shape", "name the file of a volume or a mesh"));
        }
        let good = self.spacing.is_none_or(|h| h > 0.0 && h.is_finite());
        if !good {
            let value = self.spacing.unwrap_or(f64::NAN);
            return Err(Error::range("spacing", value, "(0, inf)"));
        }
        for (key, value) in [("level", self.level), ("label", self.label)] {
            if let Some(value) = value.filter(|v| !v.is_finite()) {
                return Err(Error::range(key, value, "(-inf, inf)"));
            }
        }
        if self.level.is_some() && self.label.is_some() {
            return Err(Error::config("label", "the level is given; give one of the two"));
        }
        if !(0.0..=20.0).contains(&self.smooth) {
            return Err(Error::range("smooth", self.smooth, "[0, 20]"));
        }
        whole("count", self.count, 3, 20_000)?;
        whole("nearest", self.nearest, 1, 100)?;
        whole("starts", self.starts, 1, self.nearest)?;
        whole("generations", self.generations as usize, 0, 10_000)?;
        if !(self.width > 0.0 && self.width <= 1.0) {
            return Err(Error::range("width", self.width, "(0, 1]"));
        }
        self.growth.check("growth")?;
        self.ranges.check("ranges")?;
        self.distance.check("distance")
    }

    /// Width of the given shape's voxels.
    pub(super) fn spacing(&self) -> f64 {
        self.spacing.unwrap_or(self.growth.spacing)
    }
}
