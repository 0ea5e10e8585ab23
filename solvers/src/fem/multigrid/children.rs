//! Fine elements within a coarse one, and their projected matrices.

use super::lattice::Lattice;

/// Most rows of the matrix of an element.
pub(super) const MOST: usize = 24;

/// Weights `[fine corner][coarse corner]` of one child of an element.
pub(super) type Weights = [[f64; 8]; 8];

/// `[z, y, x]` of a corner or a child.
pub(super) fn offsets(bits: usize) -> [usize; 3] {
    [bits >> 2 & 1, bits >> 1 & 1, bits & 1]
}

/// Children that the elements above a lattice have: fewer where an axis is kept.
pub(super) fn children(fine: Lattice) -> impl Iterator<Item = usize> {
    let ratios = fine.ratios();
    (0..fine.corners()).filter(move |&c| offsets(c).iter().zip(ratios).all(|(&o, r)| o < r))
}

/// A child of the coarse element `at`, unless it is outside.
pub(super) fn child_of(fine: Lattice, at: [usize; 3], child: usize) -> Option<usize> {
    let (ratios, offsets) = (fine.ratios(), offsets(child));
    fine.element_index(std::array::from_fn(|axis| ratios[axis] * at[axis] + offsets[axis]))
}

pub(super) fn weights(fine: Lattice, child: usize) -> Weights {
    let ratios = fine.ratios();
    let mut weights = [[0.0; 8]; 8];
    for (a, row) in weights.iter_mut().enumerate().take(fine.corners()) {
        for (b, weight) in row.iter_mut().enumerate().take(fine.corners()) {
            *weight = (0..3)
                .map(|axis| {
                    let place = (offsets(child)[axis] + offsets(a)[axis]) as f64;
                    let t = place / ratios[axis] as f64;
                    if offsets(b)[axis] == 1 { t } else { 1.0 - t }
                })
                .product();
        }
    }
    weights
}

pub(super) fn unknowns(lattice: Lattice, element: usize, components: usize) -> [usize; MOST] {
    let at = lattice.element(element);
    let [_, ny, nx] = lattice.nodes();
    let mut unknowns = [0; MOST];
    for (local, unknown) in unknowns.iter_mut().enumerate().take(components * lattice.corners()) {
        let [dz, dy, dx] = offsets(local / components);
        let node = ((at[0] + dz) * ny + at[1] + dy) * nx + at[2] + dx;
        *unknown = node * components + local % components;
    }
    unknowns
}

pub(super) fn accumulate(factor: f64, from: &[f64], out: &mut [f64]) {
    for (out, value) in out.iter_mut().zip(from) {
        *out += factor * value;
    }
}

/// `out += P^T K P`, P the same for each component.
pub(super) fn add_projected(matrix: &[f64], weights: &Weights, components: usize, out: &mut [f64]) {
    let n = matrix.len().isqrt();
    let corners = n / components;
    let mut right = [0.0; MOST * MOST];
    for (row, right) in matrix.chunks_exact(n).zip(right.chunks_exact_mut(n)) {
        for a in 0..corners {
            for b in (0..corners).filter(|&b| weights[a][b] != 0.0) {
                for c in 0..components {
                    right[b * components + c] += row[a * components + c] * weights[a][b];
                }
            }
        }
    }
    for a in 0..corners {
        for b in (0..corners).filter(|&b| weights[a][b] != 0.0) {
            let rows = components * n;
            accumulate(weights[a][b], &right[a * rows..][..rows], &mut out[b * rows..][..rows]);
        }
    }
}
