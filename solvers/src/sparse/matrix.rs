//! Symmetric sparse matrices by their lower triangle.

use crate::{Error, Result};
use faer::sparse::{SparseColMat, SparseColMatRef, SymbolicSparseColMat};
use nalgebra_sparse::{CooMatrix, CscMatrix};

/// A symmetric matrix, of which the lower triangle is stored, column by column.
#[derive(Clone, Debug)]
pub struct SymmetricMatrix {
    lower: SparseColMat<usize, f64>,
}

impl SymmetricMatrix {
    /// The `n` by `n` matrix with entries `(row, column, value)`; entries of the same
    /// place are added, in the order given. Those above the diagonal are ignored, so the
    /// triplets may be those of the lower triangle or of the whole matrix.
    ///
    /// # Errors
    /// If an index is not below `n`.
    pub fn from_triplets(
        n: usize,
        triplets: impl IntoIterator<Item = (usize, usize, f64)>,
    ) -> Result<Self> {
        let mut coo = CooMatrix::new(n, n);
        for (row, column, value) in triplets {
            if row >= n || column >= n {
                return Err(Error::Invalid(format!(
                    "matrix entry ({row}, {column}) lies outside {n} rows and columns"
                )));
            }
            if row >= column {
                coo.push(row, column, value);
            }
        }
        Self::from_csc(CscMatrix::from(&coo))
    }

    /// Takes over a square matrix in compressed columns with sorted rows; only entries on
    /// and below the diagonal count, and its arrays are moved if there are no others.
    ///
    /// # Errors
    /// If it is not square.
    pub fn from_csc(matrix: CscMatrix<f64>) -> Result<Self> {
        let n = matrix.nrows();
        if matrix.ncols() != n {
            return Err(Error::Shape {
                name: "symmetric matrix".into(),
                actual: vec![n, matrix.ncols()],
                expected: vec![n, n],
            });
        }
        let is_lower = matrix.triplet_iter().all(|(row, column, _)| row >= column);
        let matrix = if is_lower { matrix } else { matrix.lower_triangle() };
        let (offsets, rows, values) = matrix.disassemble();
        let pattern = SymbolicSparseColMat::new_checked(n, n, offsets, None, rows);
        Ok(Self { lower: SparseColMat::new(pattern, values) })
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.lower.nrows()
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Values of the stored entries; entry `e` stands at row `rows()[e]`.
    pub fn values(&self) -> &[f64] {
        self.lower.val()
    }

    /// Values of the stored entries, for writing a matrix of the same pattern.
    pub fn values_mut(&mut self) -> &mut [f64] {
        self.lower.val_mut()
    }

    /// Row of each stored entry.
    pub fn rows(&self) -> &[usize] {
        self.lower.symbolic().row_idx()
    }

    /// Where each column's entries begin, with their number at the end.
    pub fn offsets(&self) -> &[usize] {
        self.lower.symbolic().col_ptr()
    }

    pub(super) fn lower(&self) -> SparseColMatRef<'_, usize, f64> {
        self.lower.as_ref()
    }

    /// `y = A x`, serially.
    ///
    /// # Panics
    /// If a length is not that of the matrix.
    pub fn multiply(&self, x: &[f64], y: &mut [f64]) {
        assert_eq!(x.len(), self.len(), "length of x");
        y.fill(0.0);
        for (column, span) in self.offsets().windows(2).enumerate() {
            for entry in span[0]..span[1] {
                let (row, value) = (self.rows()[entry], self.values()[entry]);
                y[row] += value * x[column];
                if row != column {
                    y[column] += value * x[row];
                }
            }
        }
    }
}
