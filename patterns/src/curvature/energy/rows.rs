//! Rows of fields in memory, with room for neighbours on either side.

use solvers::Float;

/// Voxels that are computed together: one vector of 4-byte numbers or two of 8 in the widest
/// unit.
pub(super) const CHUNK: usize = 16;

/// Numbers before the first voxel of a row: its ghosts, and then it starts a vector.
pub(super) const PAD: usize = CHUNK;

/// Length of a padded row of `nx` voxels: ghosts, whole chunks, ghosts.
pub(super) fn stride(nx: usize) -> usize {
    PAD + nx.next_multiple_of(CHUNK) + CHUNK
}

/// The chunks of a padded row that start `shift` voxels after the first.
#[inline(always)]
pub(super) fn chunks<T>(row: &[T], shift: isize, count: usize) -> &[[T; CHUNK]] {
    &row[PAD.wrapping_add_signed(shift)..].as_chunks().0[..count]
}

/// A padded row and its two neighbours along x.
#[derive(Clone, Copy)]
pub(super) struct Along<'a, T> {
    pub(super) west: &'a [[T; CHUNK]],
    pub(super) here: &'a [[T; CHUNK]],
    pub(super) east: &'a [[T; CHUNK]],
}

impl<'a, T: Float> Along<'a, T> {
    #[inline(always)]
    pub(super) fn new(row: &'a [T], count: usize) -> Self {
        Self {
            west: chunks(row, -1, count),
            here: chunks(row, 0, count),
            east: chunks(row, 1, count),
        }
    }
}

/// The rows around a row of a field that the 19 points of all second differences stand in.
#[derive(Clone, Copy)]
pub(super) struct Near<'a, T> {
    /// Row j - 1, j, j + 1 of plane k.
    pub(super) plane: [Along<'a, T>; 3],
    /// Row j of planes k - 1 and k + 1.
    pub(super) below: Along<'a, T>,
    pub(super) above: Along<'a, T>,
    /// Rows j - 1, j + 1 of plane k - 1, then of plane k + 1.
    pub(super) corners: [&'a [[T; CHUNK]]; 4],
}
