//! The transpose of the differences: from derivatives of the density to that of the energy.

use super::local::{Constants, FIELDS};
use super::rows::{CHUNK, PAD};
use solvers::Float;

/// Derivatives of the density in three consecutive rows of a plane, [`FIELDS`] padded rows each.
pub(super) type Slots<'a, T> = [&'a [T]; 3];

/// What of these a voxel's differences reach: field, row, shift along x.
const TERMS: [(usize, usize, isize); 21] = [
    (0, 1, 0),
    (1, 0, 0),
    (1, 1, 0),
    (1, 2, 0),
    (2, 1, -1),
    (2, 1, 0),
    (2, 1, 1),
    (5, 0, -1),
    (5, 0, 1),
    (5, 2, -1),
    (5, 2, 1),
    (4, 1, -1),
    (4, 1, 1),
    (3, 0, 0),
    (3, 2, 0),
    (6, 1, 0),
    (7, 0, 0),
    (7, 2, 0),
    (8, 1, -1),
    (8, 1, 1),
    (9, 1, 0),
];

/// Contributions to the gradient in the row's own plane, the plane above and the one below,
/// from the [`TERMS`].
#[inline(always)]
fn combine<T: Float>(v: &[T; TERMS.len()], k: &Constants<T>) -> [T; 3] {
    let [zz, yn, yy, ys, xw, xx, xe, nw, ne, sw, se, zw, ze, zn, zs, gz, gn, gs, gw, ge, well] = *v;
    let second = ((yn + ys) - (yy + yy)) + ((xw + xe) - (xx + xx));
    let mixed = (se - sw) - (ne - nw);
    let first = (gs - gn) + (ge - gw);
    let even = zz * k.to_second;
    let odd = gz * k.to_first - ((ze - zw) + (zs - zn)) * k.to_mixed;
    let own =
        ((second * k.to_second - (even + even)) + mixed * k.to_mixed) + (well - first * k.to_first);
    [own, even + odd, even - odd]
}

/// The row's contributions at its `count` chunks, as padded rows.
#[inline(always)]
pub(super) fn assemble<T: Float>(
    slots: &Slots<'_, T>,
    k: &Constants<T>,
    count: usize,
    out: [&mut [T]; 3],
) {
    let zero = T::from_f64(0.0);
    let stride = slots[0].len() / FIELDS;
    let mut chunks: [&[[T; CHUNK]]; TERMS.len()] = [&[]; TERMS.len()];
    for t in 0..TERMS.len() {
        let (field, row, shift) = TERMS[t];
        let first = (field * stride + PAD).wrapping_add_signed(shift);
        chunks[t] = &slots[row][first..].as_chunks().0[..count];
    }
    let [own, above, below] = out;
    let own = &mut own[PAD..].as_chunks_mut().0[..count];
    let above = &mut above[PAD..].as_chunks_mut().0[..count];
    let below = &mut below[PAD..].as_chunks_mut().0[..count];
    let none = [zero; CHUNK];
    for j in 0..count {
        let mut near = [&none; TERMS.len()];
        for t in 0..TERMS.len() {
            near[t] = &chunks[t][j];
        }
        let mut sums = [[zero; CHUNK]; 3];
        for i in 0..CHUNK {
            let mut v = [zero; TERMS.len()];
            for t in 0..TERMS.len() {
                v[t] = near[t][i];
            }
            let [own, above, below] = combine(&v, k);
            sums[0][i] = own;
            sums[1][i] = above;
            sums[2][i] = below;
        }
        own[j] = sums[0];
        above[j] = sums[1];
        below[j] = sums[2];
    }
}

/// The contributions at one place of the padded row: what falls on a ghost voxel.
pub(super) fn assemble_at<T: Float>(
    slots: &Slots<'_, T>,
    k: &Constants<T>,
    place: usize,
) -> [T; 3] {
    let stride = slots[0].len() / FIELDS;
    let v = TERMS
        .map(|(field, row, shift)| slots[row][(field * stride + place).wrapping_add_signed(shift)]);
    combine(&v, k)
}
