//! The product of a coarse level, by the stencils of its nodes.

use super::lattice::{Layout, SLACK};
use pulp::{Simd, WithSimd};

/// A symmetric matrix that couples nodes with all that share an element with them.
///
/// Only the couplings with a node itself and with those after it are stored (14 of 27 in
/// three dimensions): the product is limited by memory, and the others are the transposes
/// of stored ones of rows nearby.
#[derive(Clone, Debug)]
pub(super) struct Stencil {
    pub layout: Layout,
    /// Per row `[neighbour][component][component of the neighbour][place]`.
    values: Vec<f32>,
    row: fn(&Stencil, usize, &[f32], &mut [f32]),
}

/// Stored neighbours, `(dz, dy, dx)`: the node itself and those after it.
pub(super) fn neighbours(dim: usize) -> &'static [[isize; 3]] {
    const ALL: [[isize; 3]; 14] = [
        [0, 0, 0],
        [0, 0, 1],
        [0, 1, -1],
        [0, 1, 0],
        [0, 1, 1],
        [1, -1, -1],
        [1, -1, 0],
        [1, -1, 1],
        [1, 0, -1],
        [1, 0, 0],
        [1, 0, 1],
        [1, 1, -1],
        [1, 1, 0],
        [1, 1, 1],
    ];
    if dim == 2 { &ALL[..5] } else { &ALL }
}

impl Stencil {
    pub(super) fn new(layout: Layout) -> Self {
        let row = match layout.components {
            1 => row::<1>,
            2 => row::<2>,
            _ => row::<3>,
        };
        Self { layout, values: vec![0.0; Self::values(&layout)], row }
    }

    /// Numbers stored for a level.
    pub(super) fn values(layout: &Layout) -> usize {
        layout.rows() * Self::row_values(layout) + SLACK
    }

    /// Numbers stored for a row of nodes.
    pub(super) fn row_values(layout: &Layout) -> usize {
        neighbours(layout.lattice.dim()).len() * layout.components * layout.row_len()
    }

    /// All rows, one after another.
    pub(super) fn values_mut(&mut self) -> &mut [f32] {
        &mut self.values
    }

    /// Writes one row of the product, components [`Layout::wide`] apart.
    pub(super) fn product(&self, row: usize, x: &[f32], product: &mut [f32]) {
        (self.row)(self, row, x, product);
    }
}

fn row<const C: usize>(stencil: &Stencil, row: usize, x: &[f32], product: &mut [f32]) {
    pulp::Arch::new().dispatch(Kernel::<C> { stencil, row, x, product });
}

/// One neighbour of all nodes of a row: where its couplings and values are, counted from
/// the node's place.
#[derive(Clone, Copy, Default)]
struct Term {
    values: usize,
    x: usize,
}

struct Kernel<'a, const C: usize> {
    stencil: &'a Stencil,
    row: usize,
    x: &'a [f32],
    product: &'a mut [f32],
}

impl<const C: usize> WithSimd for Kernel<'_, C> {
    type Output = ();

    #[inline(always)]
    #[expect(clippy::needless_range_loop, reason = "one index serves several arrays")]
    fn with_simd<S: Simd>(self, simd: S) {
        let layout = &self.stencil.layout;
        let (stride, wide) = (layout.stride, layout.wide());
        let (mut after, mut before) = ([Term::default(); 14], [Term::default(); 14]);
        let after = self.terms(1, &mut after);
        let before = self.terms(-1, &mut before);
        let values = &self.stencil.values[..];
        let load = |from: &[f32], at: usize| S::as_simd_f32s(&from[at..at + S::F32_LANES]).0[0];
        for first in (1..=layout.lattice.nodes()[2]).step_by(S::F32_LANES) {
            let mut sums = [[simd.splat_f32s(0.0); C]; 2];
            for term in after {
                let near: [_; C] =
                    std::array::from_fn(|d| load(self.x, term.x + first + d * stride));
                for c in 0..C {
                    for d in 0..C {
                        let value = load(values, term.values + first + (c * C + d) * stride);
                        sums[0][c] = simd.mul_add_e_f32s(value, near[d], sums[0][c]);
                    }
                }
            }
            for term in before {
                let near: [_; C] =
                    std::array::from_fn(|d| load(self.x, term.x + first + d * stride));
                for d in 0..C {
                    for c in 0..C {
                        let value = load(values, term.values + first + (d * C + c) * stride);
                        sums[1][c] = simd.mul_add_e_f32s(value, near[d], sums[1][c]);
                    }
                }
            }
            for c in 0..C {
                let to = &mut self.product[c * wide + first..][..S::F32_LANES];
                S::as_mut_simd_f32s(to).0[0] = simd.add_f32s(sums[0][c], sums[1][c]);
            }
        }
    }
}

impl<const C: usize> Kernel<'_, C> {
    /// The neighbours after the row's nodes (`sign` 1), or those before them (-1).
    fn terms<'t>(&self, sign: isize, terms: &'t mut [Term; 14]) -> &'t [Term] {
        let layout = &self.stencil.layout;
        let [planes, lines, _] = layout.lattice.nodes().map(|n| n as isize);
        let (k, j) = (self.row as isize / lines, self.row as isize % lines);
        let (row_values, block) = (Stencil::row_values(layout), C * layout.row_len());
        let mut count = 0;
        for (h, &[dz, dy, dx]) in neighbours(layout.lattice.dim()).iter().enumerate() {
            let (kk, jj) = (k + sign * dz, j + sign * dy);
            let outside = kk < 0 || kk >= planes || jj < 0 || jj >= lines;
            if outside || (sign < 0 && h == 0) {
                continue;
            }
            let near = (kk * lines + jj) as usize;
            // A coupling is stored with the earlier of its two nodes.
            let (owner, shift) = if sign > 0 { (self.row, 0) } else { (near, -dx) };
            terms[count] = Term {
                values: (owner * row_values + h * block).wrapping_add_signed(shift),
                x: (near * layout.row_len()).wrapping_add_signed(sign * dx),
            };
            count += 1;
        }
        &terms[..count]
    }
}
