//! The coarsest level, solved directly.

use super::galerkin::Elements;
use super::lattice::Layout;
use crate::Result;
use crate::sparse::{Cholesky, Ordering, Scratch, Symbolic, SymmetricMatrix, nested_dissection};

/// `A x = b` by a sparse Cholesky factor, in 8-byte numbers.
pub(super) struct Coarsest {
    pub layout: Layout,
    pub b: Vec<f32>,
    pub x: Vec<f32>,
    matrix: SymmetricMatrix,
    /// Where the entries of the elements' matrices are added, `u32::MAX` above the diagonal.
    places: Vec<u32>,
    factor: Cholesky,
    scratch: Scratch,
    values: Vec<f64>,
}

impl Coarsest {
    /// Analyses the pattern; the values are those of [`Coarsest::update`].
    pub(super) fn new(layout: Layout, elements: &Elements) -> Result<Self> {
        let n = layout.unknowns();
        let mut triplets: Vec<_> = (0..n).map(|u| (u, u, 1.0)).collect();
        elements.each_matrix(layout.components, |unknowns, _| {
            for &row in unknowns {
                let below = unknowns.iter().filter(|&&column| column < row);
                triplets.extend(below.map(|&column| (row, column, 0.0)));
            }
        });
        let matrix = SymmetricMatrix::from_triplets(n, triplets)?;
        let mut places = Vec::new();
        elements.each_matrix(layout.components, |unknowns, _| {
            for &row in unknowns {
                places.extend(unknowns.iter().map(|&column| place(&matrix, row, column)));
            }
        });
        let nodes = nested_dissection(&layout.lattice.nodes(), false);
        let components = layout.components;
        let expand = |node: usize| node * components..(node + 1) * components;
        let order: Vec<usize> = nodes.into_iter().flat_map(expand).collect();
        let symbolic = Symbolic::new(&matrix, Ordering::Custom(&order))?;
        let factor = Cholesky::new(symbolic, &matrix)?;
        let scratch = factor.scratch(1);
        let zeros = || vec![0.0; layout.len()];
        Ok(Self {
            layout,
            b: zeros(),
            x: zeros(),
            matrix,
            places,
            factor,
            scratch,
            values: vec![0.0; n],
        })
    }

    /// Sums and factorizes the matrix of new elements.
    pub(super) fn update(&mut self, elements: &Elements) -> Result<()> {
        let values = self.matrix.values_mut();
        values.fill(0.0);
        let mut places = self.places.iter();
        elements.each_matrix(self.layout.components, |_, matrix| {
            for (value, &place) in matrix.iter().zip(&mut places) {
                if place != u32::MAX {
                    values[place as usize] += value;
                }
            }
        });
        self.fill_fixed();
        self.factor.refactorize(&self.matrix)
    }

    /// Unknowns without stiffness, fixed on all finer levels, get a diagonal of 1.
    fn fill_fixed(&mut self) {
        for column in 0..self.matrix.len() {
            let diagonal = self.matrix.offsets()[column];
            let value = &mut self.matrix.values_mut()[diagonal];
            if *value == 0.0 {
                *value = 1.0;
            }
        }
    }

    /// Writes x for the present b.
    pub(super) fn solve(&mut self) {
        let Self { layout, b, x, values, factor, scratch, .. } = self;
        let (components, row_len) = (layout.components, layout.row_len());
        let rows = || (0..layout.rows()).flat_map(|row| (0..components).map(move |c| (row, c)));
        let nodes = layout.lattice.nodes()[2];
        for (row, c) in rows() {
            let to = values[row * nodes * components + c..].iter_mut().step_by(components);
            for (to, from) in to.zip(&b[row * row_len..][layout.span(c)]) {
                *to = f64::from(*from);
            }
        }
        factor.solve(values, scratch);
        for (row, c) in rows() {
            let from = values[row * nodes * components + c..].iter().step_by(components);
            for (to, from) in x[row * row_len..][layout.span(c)].iter_mut().zip(from) {
                *to = *from as f32;
            }
        }
    }

    /// Stored entries of the factor, 8 bytes each.
    pub(super) fn entries(&self) -> usize {
        self.factor.entries()
    }
}

/// Where entry `(row, column)` is stored.
fn place(matrix: &SymmetricMatrix, row: usize, column: usize) -> u32 {
    if column > row {
        return u32::MAX;
    }
    let span = matrix.offsets()[column]..matrix.offsets()[column + 1];
    // Rows are sorted, and the entry is in the pattern made of the same elements.
    let before = matrix.rows()[span.clone()].partition_point(|&other| other < row);
    (span.start + before) as u32
}
