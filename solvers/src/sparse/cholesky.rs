//! Sparse Cholesky factorization `P A P^T = L L^T`.

use super::SymmetricMatrix;
use crate::{Error, Result};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltError;
use faer::perm::Perm;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::{Conj, MatMut, Par, Side};
use std::sync::Arc;

/// Order of elimination.
#[derive(Clone, Copy, Debug, Default)]
pub enum Ordering<'a> {
    /// Approximate minimum degree: good for irregular meshes.
    #[default]
    Amd,
    /// The i-th unknown eliminated is `order[i]`, e.g. of [`super::nested_dissection`].
    Custom(&'a [usize]),
}

/// Where the factor of a pattern has its entries; cheap to clone and to share.
#[derive(Clone, Debug)]
pub struct Symbolic {
    inner: Arc<SymbolicCholesky<usize>>,
    entries: usize,
}

impl Symbolic {
    /// Analyses the pattern of `matrix`; its values do not matter.
    ///
    /// # Errors
    /// If a custom ordering is no permutation, or the factor's size overflows.
    pub fn new(matrix: &SymmetricMatrix, ordering: Ordering<'_>) -> Result<Self> {
        let order = match ordering {
            Ordering::Amd => None,
            Ordering::Custom(order) => Some(permutation(order, matrix.len())?),
        };
        let ordering = match &order {
            None => SymmetricOrdering::Amd,
            Some(order) => SymmetricOrdering::Custom(order.as_ref()),
        };
        // Dense blocks were faster than single columns at every size measured.
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let inner =
            factorize_symbolic_cholesky(matrix.lower().symbolic(), Side::Lower, ordering, params)
                .map_err(|reason| Error::Invalid(format!("Cholesky analysis failed: {reason:?}")))?;
        Ok(Self { inner: Arc::new(inner), entries: matrix.values().len() })
    }

    /// Number of stored entries of the factor, which are 8 bytes each.
    pub fn factor_entries(&self) -> usize {
        self.inner.len_val()
    }
}

/// A Cholesky factor; solving with it needs only a shared reference.
///
/// One thread: factors of different systems, or solves with one factor, are to be run
/// beside each other. Results are the same for any number of threads; across processors
/// they may differ in the last bits, because the dense kernels use the widest vector
/// instructions that they find.
pub struct Cholesky {
    symbolic: Symbolic,
    values: Vec<f64>,
    memory: MemBuffer,
}

/// Work space of a solve.
pub struct Scratch(MemBuffer);

impl Cholesky {
    /// Factorizes `matrix`, which has the pattern that was analysed.
    ///
    /// # Errors
    /// As [`Cholesky::refactorize`].
    pub fn new(symbolic: Symbolic, matrix: &SymmetricMatrix) -> Result<Self> {
        let values = vec![0.0; symbolic.inner.len_val()];
        let request =
            symbolic.inner.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        let memory = MemBuffer::try_new(request).map_err(|_| Error::TooLarge {
            name: "work space of a Cholesky factorization".into(),
            shape: vec![matrix.len(), matrix.len()],
            needed: format!("{:.3e} bytes", request.unaligned_bytes_required() as f64),
            available: "less".into(),
        })?;
        let mut cholesky = Self { symbolic, values, memory };
        cholesky.refactorize(matrix)?;
        Ok(cholesky)
    }

    /// Factorizes other values of the same pattern, into the memory of the old factor.
    ///
    /// # Errors
    /// If the matrix has another number of entries, or is not positive definite; the
    /// latter names the first row whose pivot is not above 0, and leaves no usable factor.
    pub fn refactorize(&mut self, matrix: &SymmetricMatrix) -> Result<()> {
        let symbolic = &self.symbolic.inner;
        if matrix.len() != symbolic.nrows() || matrix.values().len() != self.symbolic.entries {
            return Err(Error::Shape {
                name: "matrix to factorize (rows, stored entries)".into(),
                actual: vec![matrix.len(), matrix.values().len()],
                expected: vec![symbolic.nrows(), self.symbolic.entries],
            });
        }
        // faer promises nothing for NaN; a bad entry would spread silently.
        if let Some(bad) = matrix.values().iter().position(|v| !v.is_finite()) {
            let (row, value) = (matrix.rows()[bad], matrix.values()[bad]);
            return Err(Error::Invalid(format!("matrix entry in row {row} is {value}")));
        }
        let result = symbolic.factorize_numeric_llt(
            &mut self.values,
            matrix.lower(),
            Side::Lower,
            Default::default(),
            Par::Seq,
            MemStack::new(&mut self.memory),
            Default::default(),
        );
        match result {
            Ok(_) => Ok(()),
            Err(LltError::NonPositivePivot { index }) => {
                let row = symbolic.perm().map_or(index, |order| order.arrays().0[index]);
                Err(Error::Invalid(format!(
                    "the matrix is not positive definite: its pivot in row {row} is not above 0"
                )))
            }
        }
    }

    /// Number of unknowns.
    pub fn len(&self) -> usize {
        self.symbolic.inner.nrows()
    }

    /// Whether there are no unknowns.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of stored entries of the factor, 8 bytes each.
    pub fn entries(&self) -> usize {
        self.values.len()
    }

    /// Work space for [`Cholesky::solve`] with up to `columns` right-hand sides.
    pub fn scratch(&self, columns: usize) -> Scratch {
        let request = self.symbolic.inner.solve_in_place_scratch::<f64>(columns, Par::Seq);
        Scratch(MemBuffer::new(request))
    }

    /// Replaces right-hand sides by solutions of `A x = b`.
    ///
    /// `b` holds one right-hand side after another, each as long as the matrix.
    ///
    /// # Panics
    /// If the length of `b` is no multiple of the matrix's, or `scratch` was made for
    /// fewer columns.
    pub fn solve(&self, b: &mut [f64], scratch: &mut Scratch) {
        let n = self.len();
        assert!(b.len().is_multiple_of(n), "{} numbers for systems of {n} rows", b.len());
        let columns = b.len() / n;
        LltRef::new(&self.symbolic.inner, &self.values).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(b, n, columns),
            Par::Seq,
            MemStack::new(&mut scratch.0),
        );
    }
}

impl std::fmt::Debug for Cholesky {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Cholesky {{ rows: {}, entries: {} }}", self.len(), self.entries())
    }
}

fn permutation(order: &[usize], n: usize) -> Result<Perm<usize>> {
    let mut inverse = vec![usize::MAX; n];
    for (position, &row) in order.iter().enumerate() {
        match inverse.get_mut(row) {
            Some(slot) if *slot == usize::MAX => *slot = position,
            _ => {
                return Err(Error::Invalid(format!(
                    "ordering names row {row} twice or beyond the {n} rows"
                )));
            }
        }
    }
    if order.len() != n {
        return Err(Error::Shape {
            name: "ordering".into(),
            actual: vec![order.len()],
            expected: vec![n],
        });
    }
    Ok(Perm::new_checked(order.into(), inverse.into(), n))
}
