//! Coarse operators `P^T A P`, element by element.
//!
//! The matrix of a coarse element is the sum over its 4 or 8 children c of
//! `P_c^T K_c P_c`. Between the finest level and the next `K_c = E_c Ke`, so that these
//! products are made once and a design only weighs them; where unknowns are fixed or
//! springs act, the few elements concerned are summed in full. Elements keep 8-byte
//! numbers down to the coarsest level: rounding their rigid motions to 4 bytes would give
//! these a stiffness that exceeds that of the void around.

use super::children::{
    MOST, accumulate, add_projected, child_of, children, offsets, unknowns, weights,
};
use super::first::First;
use super::lattice::{Lattice, Layout};
use super::stencil::{Stencil, neighbours};
use rayon::prelude::*;
use std::ops::Range;

/// Matrices of the elements of a level above the finest.
#[derive(Clone, Debug)]
pub(super) enum Elements {
    /// Of the second finest level, computed when asked for.
    First(Box<First>),
    /// Of the others.
    Stored { lattice: Lattice, matrices: Vec<f64> },
}

impl Elements {
    /// Adds rows of the matrix of an element to `out`.
    fn add(&self, element: usize, rows: Range<usize>, out: &mut [f64]) {
        match self {
            Self::First(first) => first.add(element, rows, out),
            Self::Stored { lattice, matrices } => {
                let size = matrices.len() / lattice.element_count();
                let n = size.isqrt();
                let matrix = &matrices[element * size..];
                accumulate(1.0, &matrix[rows.start * n..rows.end * n], out);
            }
        }
    }

    pub(super) fn lattice(&self) -> Lattice {
        match self {
            Self::First(first) => first.coarse(),
            Self::Stored { lattice, .. } => *lattice,
        }
    }

    /// Elements of the next level, matrices still to be [`Elements::gather`]ed.
    pub(super) fn coarser(&self, components: usize) -> Self {
        let lattice = self.lattice().coarser();
        let size = (components * lattice.corners()).pow(2);
        Self::Stored { lattice, matrices: vec![0.0; lattice.element_count() * size] }
    }

    /// Sums the matrices of stored elements over those of the next finer level.
    pub(super) fn gather(&mut self, finer: &Self, components: usize) {
        let Self::Stored { lattice, matrices } = self else { return };
        let (coarse, fine) = (*lattice, finer.lattice());
        let n = components * coarse.corners();
        let all: Vec<_> = children(fine).map(|c| (c, weights(fine, c))).collect();
        matrices.par_chunks_exact_mut(n * n).enumerate().for_each(|(element, matrix)| {
            matrix.fill(0.0);
            let at = coarse.element(element);
            for (child, weights) in &all {
                if let Some(child) = child_of(fine, at, *child) {
                    let mut inner = [0.0; MOST * MOST];
                    finer.add(child, 0..n, &mut inner[..n * n]);
                    add_projected(&inner[..n * n], weights, components, matrix);
                }
            }
        });
    }

    /// Fills a stencil with the sums over elements, and the inverse of its diagonal; an
    /// unknown without stiffness, fixed on all finer levels, gets 0 there.
    pub(super) fn assemble(&self, stencil: &mut Stencil, inverse_diagonal: &mut [f32]) {
        let layout = stencil.layout;
        let (values, row_len) = (Stencil::row_values(&layout), layout.row_len());
        let rows = stencil.values_mut().par_chunks_exact_mut(values).take(layout.rows());
        let rows = rows.zip(inverse_diagonal.par_chunks_exact_mut(row_len)).enumerate();
        let work = || vec![0.0; values];
        rows.for_each_init(work, |sums, (row, (values, inverse))| {
            sums.fill(0.0);
            self.add_row(&layout, row, sums);
            for (value, sum) in values.iter_mut().zip(&*sums) {
                *value = *sum as f32;
            }
            for c in 0..layout.components {
                let diagonal = &sums[c * (layout.components + 1) * layout.stride..];
                for i in 1..=layout.lattice.nodes()[2] {
                    let d = diagonal[i];
                    inverse[c * layout.stride + i] = if d > 0.0 { (1.0 / d) as f32 } else { 0.0 };
                }
            }
        });
    }

    /// Adds what the elements around a row of nodes give to its stencils.
    fn add_row(&self, layout: &Layout, row: usize, sums: &mut [f64]) {
        let lattice = layout.lattice;
        let (corners, components, stride) = (lattice.corners(), layout.components, layout.stride);
        let (k, j) = (row / layout.lines(), row % layout.lines());
        let n = corners * components;
        for a in 0..corners {
            let [dz, dy, dx] = offsets(a);
            let (Some(k), Some(j)) = (k.checked_sub(dz), j.checked_sub(dy)) else { continue };
            let Some(first) = lattice.element_index([k, j, 0]) else { continue };
            let stored = stored_neighbours(lattice.dim(), a);
            for i in 0..lattice.elements()[2] {
                let mut rows = [0.0; 3 * MOST];
                let rows = &mut rows[..components * n];
                self.add(first + i, a * components..(a + 1) * components, rows);
                let place = i + dx + 1;
                for (b, h) in stored.iter().enumerate().filter_map(|(b, h)| Some((b, (*h)?))) {
                    for c in 0..components {
                        for d in 0..components {
                            let entry = (h * components + c) * components + d;
                            sums[entry * stride + place] += rows[c * n + b * components + d];
                        }
                    }
                }
            }
        }
    }

    /// Calls `put(element's unknowns, matrix)` for all elements in order.
    pub(super) fn each_matrix(&self, components: usize, mut put: impl FnMut(&[usize], &[f64])) {
        let lattice = self.lattice();
        let n = components * lattice.corners();
        for element in 0..lattice.element_count() {
            let mut matrix = [0.0; MOST * MOST];
            self.add(element, 0..n, &mut matrix[..n * n]);
            put(&unknowns(lattice, element, components)[..n], &matrix[..n * n]);
        }
    }
}

/// For corner `a`, the place among the stored neighbours of each other corner, if stored.
fn stored_neighbours(dim: usize, a: usize) -> [Option<usize>; 8] {
    let from = offsets(a);
    std::array::from_fn(|b| {
        let to = offsets(b);
        let difference = std::array::from_fn(|axis| to[axis] as isize - from[axis] as isize);
        neighbours(dim).iter().position(|d| b < 1 << dim && *d == difference)
    })
}
