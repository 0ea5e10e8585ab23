//! Memory of a solver, before it is made.

use super::Options;
use super::cycle::lattices;
use super::element::force_len;
use super::lattice::{Lattice, Layout};
use super::stencil::Stencil;
use crate::fem::direct::factor_bytes;

/// Estimate of the bytes that a [`super::Multigrid`] will take, within a sixth from 30 MB on
/// (lattices of fewer than 100 000 unknowns may take 5 MB more).
///
/// Dominated by four vectors in 8-byte numbers and six in 4-byte ones; in 3D the second
/// level's stencils add half as much again. Cost O(levels).
pub fn memory(lattice: &Lattice, components: usize, options: &Options) -> usize {
    let all = lattices(*lattice, components, options);
    let layouts: Vec<_> = all.iter().map(|&l| Layout::new(l, components)).collect();
    let finest = &layouts[0];
    let work = force_len(finest) * 2 + finest.lines() * finest.row_len();
    let mut bytes = finest.len() * 4 * 8 + finest.unknowns();
    // E three times: for either product and for the coarse elements.
    bytes += lattice.element_count() * (8 + 8 + 4);
    bytes += work * (8 + 4) * rayon::current_num_threads();
    for (index, layout) in layouts.iter().enumerate() {
        let is_last = index + 1 == layouts.len();
        bytes += layout.len() * 4 * if is_last { 2 } else { 6 };
        let matrix = (components * lattice.corners()).pow(2);
        if index > 0 && !is_last {
            bytes += Stencil::values(layout) * 4;
        }
        if index > 1 {
            bytes += layout.lattice.element_count() * matrix * 8;
        }
        if is_last {
            // Places of entries, and the matrix itself by values and rows.
            bytes += layout.lattice.element_count() * matrix * 4;
            bytes += Stencil::values(layout) * 16 + factor_bytes(layout.unknowns(), lattice.dim());
        }
    }
    bytes
}
