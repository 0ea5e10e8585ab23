//! Elements of the second finest level, from the stiffness of the finest.

use super::children::{
    MOST, accumulate, add_projected, child_of, children, offsets, unknowns, weights,
};
use super::lattice::Lattice;
use rayon::prelude::*;
use std::ops::Range;

/// The second finest level.
#[derive(Clone, Debug)]
pub(super) struct First {
    fine: Lattice,
    coarse: Lattice,
    components: usize,
    /// `P_c^T Ke P_c` for each child.
    children: Vec<Vec<f64>>,
    /// E of the fine elements, scaled.
    stiffness: Vec<f64>,
    ke: Vec<f64>,
    /// Per coarse element its place in `special`, or `u32::MAX`.
    which: Vec<u32>,
    /// Elements with fixed unknowns or springs, and their matrices.
    special: Vec<usize>,
    matrices: Vec<f64>,
}

impl First {
    /// `fixed` and `springs` (or none) per unknown of the fine level; `springs` and `ke` scaled.
    pub(super) fn new(
        fine: Lattice,
        components: usize,
        ke: &[f64],
        fixed: &[bool],
        springs: &[f64],
    ) -> Self {
        let coarse = fine.coarser();
        let n = components * fine.corners();
        let project = |child| {
            let mut matrix = vec![0.0; n * n];
            add_projected(ke, &weights(fine, child), components, &mut matrix);
            matrix
        };
        let is_special = |u: usize| fixed[u] || springs.get(u).is_some_and(|&s| s != 0.0);
        let special: Vec<usize> = (0..coarse.element_count())
            .filter(|&element| {
                let mut inside = children(fine)
                    .filter_map(|child| child_of(fine, coarse.element(element), child));
                inside.any(|child| {
                    unknowns(fine, child, components)[..n].iter().any(|&u| is_special(u))
                })
            })
            .collect();
        let mut which = vec![u32::MAX; coarse.element_count()];
        for (place, &element) in special.iter().enumerate() {
            which[element] = place as u32;
        }
        Self {
            fine,
            coarse,
            components,
            children: children(fine).map(project).collect(),
            stiffness: vec![0.0; fine.element_count()],
            ke: ke.to_vec(),
            which,
            matrices: vec![0.0; special.len() * n * n],
            special,
        }
    }

    /// Takes over the stiffness of each fine element, times `scale`.
    pub(super) fn update(
        &mut self,
        stiffness: &[f64],
        scale: f64,
        fixed: &[bool],
        springs: &[f64],
    ) {
        for (slot, value) in self.stiffness.iter_mut().zip(stiffness) {
            *slot = value * scale;
        }
        let n = self.components * self.fine.corners();
        let mut matrices = std::mem::take(&mut self.matrices);
        let special = matrices.par_chunks_exact_mut(n * n).zip(&self.special);
        special.for_each(|(matrix, &element)| self.sum_special(element, fixed, springs, matrix));
        self.matrices = matrices;
    }

    /// The second finest lattice.
    pub(super) fn coarse(&self) -> Lattice {
        self.coarse
    }

    /// Adds rows of the matrix of an element to `out`.
    pub(super) fn add(&self, element: usize, rows: Range<usize>, out: &mut [f64]) {
        let n = self.components * self.fine.corners();
        let part = rows.start * n..rows.end * n;
        let special = self.which[element];
        if special != u32::MAX {
            return accumulate(1.0, &self.matrices[special as usize * n * n..][part], out);
        }
        let at = self.coarse.element(element);
        for (child, matrix) in children(self.fine).zip(&self.children) {
            if let Some(child) = child_of(self.fine, at, child) {
                accumulate(self.stiffness[child], &matrix[part.clone()], out);
            }
        }
    }

    /// The matrix of an element with fixed unknowns or springs. A spring belongs to the
    /// first child of the lattice that has its node.
    fn sum_special(&self, element: usize, fixed: &[bool], springs: &[f64], out: &mut [f64]) {
        let n = self.components * self.fine.corners();
        let at = self.coarse.element(element);
        out.fill(0.0);
        for bits in children(self.fine) {
            let Some(child) = child_of(self.fine, at, bits) else { continue };
            let unknowns = unknowns(self.fine, child, self.components);
            let mut matrix = [0.0; MOST * MOST];
            accumulate(self.stiffness[child], &self.ke, &mut matrix[..n * n]);
            for (row, &u) in unknowns[..n].iter().enumerate() {
                if fixed[u] {
                    for other in 0..n {
                        matrix[row * n + other] = 0.0;
                        matrix[other * n + row] = 0.0;
                    }
                } else if let Some(&spring) = springs.get(u)
                    && self.owns(child, row / self.components)
                {
                    matrix[row * n + row] += spring;
                }
            }
            let weights = weights(self.fine, bits);
            add_projected(&matrix[..n * n], &weights, self.components, out);
        }
    }

    /// Whether `corner` is the origin of the element or, at an end of the lattice, lies there.
    fn owns(&self, element: usize, corner: usize) -> bool {
        let (at, end) = (self.fine.element(element), self.fine.elements());
        offsets(corner).iter().zip(at).zip(end).all(|((&o, i), n)| o == 0 || i + 1 == n)
    }
}
