use serde::{Deserialize, Serialize};

/// What stands beyond the box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Edges {
    /// The box repeats itself.
    #[default]
    Periodic,
    /// `u[-1] = u[0]`: the gradient is that of the energy of the box's own voxels, ghosts
    /// included (the published program's differs from it at the faces).
    Replicate,
    /// No voxel stands there: the density is summed over the voxels that have all their
    /// neighbours, and nothing is asked of u at the faces. A voxel at one of the eight corners
    /// has no part in any difference, its gradient is 0.
    Free,
}

impl Edges {
    /// The voxel of `0..n` that stands for voxel `i`.
    #[inline(always)]
    pub(crate) fn inside(self, i: isize, n: usize) -> usize {
        let n = n as isize;
        let inside = if self == Self::Periodic { i.rem_euclid(n) } else { i.clamp(0, n - 1) };
        inside as usize
    }

    /// Voxels along an axis whose density is part of the energy.
    #[inline(always)]
    pub(crate) fn energy_range(self, n: usize) -> std::ops::Range<isize> {
        let n = n as isize;
        if self == Self::Free { 1..n - 1 } else { 0..n }
    }
}
