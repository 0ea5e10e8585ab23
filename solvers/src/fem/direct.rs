//! Sparse Cholesky: the pattern analysed once, the values factorized often.

use super::System;
use crate::sparse::{Cholesky, Ordering, Scratch, Symbolic, SymmetricMatrix, nested_dissection};
use crate::{Error, Result};
use nalgebra_sparse::CscMatrix;

/// Marks an unknown that is not solved for.
const FIXED: u32 = u32::MAX;

/// Estimate of the bytes of a factorization by nested dissection with its analysis and
/// work space.
///
/// Entries of factors fit `3.3 n log2 n` on planes and `17 n^(4/3)` in space (measured at
/// 700 to 20 000 unknowns; George 1973 has the exponents).
pub(super) fn factor_bytes(unknowns: usize, dim: usize) -> usize {
    let n = unknowns as f64;
    let entries = if dim == 2 { 3.3 * n * n.log2().max(1.0) } else { 17.0 * n.powf(4.0 / 3.0) };
    // As much again for the analysis and the work space.
    entries as usize * 16
}

/// Direct solver of a [`System`]: nested dissection of the nodes, supernodal Cholesky.
///
/// Cost for n nodes: memory O(n log n) in the plane and O(n^(4/3)) in space,
/// factorization O(n^(3/2)) and O(n^2).
pub struct Direct {
    /// Number of each unknown among those solved for.
    number: Vec<u32>,
    /// Entry of the matrix of each entry of each element matrix's lower triangle.
    target: Vec<u32>,
    /// Entry of the matrix of each free unknown's diagonal.
    diagonal: Vec<u32>,
    matrix: SymmetricMatrix,
    symbolic: Symbolic,
    factor: Option<(Cholesky, Scratch)>,
    work: Vec<f64>,
}

impl Direct {
    /// Analyses the pattern.
    ///
    /// # Errors
    /// If nothing is free, or the matrix has more entries than 4-byte numbers can count.
    pub fn new(system: &System) -> Result<Self> {
        let mut number = vec![FIXED; system.unknowns()];
        let free = system.fixed().iter().enumerate().filter(|(_, fixed)| !**fixed);
        let mut count = 0_u32;
        for (unknown, _) in free {
            number[unknown] = count;
            count += 1;
        }
        if count == 0 {
            return Err(Error::Invalid("every unknown is fixed: there is nothing to solve".into()));
        }
        let matrix = pattern(system, &number, count as usize)?;
        let order = elimination(system, &number);
        let symbolic = Symbolic::new(&matrix, Ordering::Custom(&order))?;
        let (target, diagonal) = targets(system, &number, &matrix);
        let work = vec![0.0; count as usize];
        Ok(Self { number, target, diagonal, matrix, symbolic, factor: None, work })
    }

    /// Stored entries of the factor, 8 bytes each.
    pub fn factor_entries(&self) -> usize {
        self.symbolic.factor_entries()
    }

    /// Assembles and factorizes `K(stiffness)`.
    ///
    /// # Errors
    /// If the matrix is not positive definite or not finite.
    pub fn factorize(&mut self, system: &System, stiffness: &[f64]) -> Result<()> {
        let values = self.matrix.values_mut();
        values.fill(0.0);
        let n = system.element().unknowns();
        let entries = n * (n + 1) / 2;
        let lower: Vec<f64> = (0..n)
            .flat_map(|r| system.element().stiffness()[r * n..].iter().take(r + 1).copied())
            .collect();
        for (&scale, targets) in stiffness.iter().zip(self.target.chunks_exact(entries)) {
            for (&k, &target) in lower.iter().zip(targets) {
                if target != FIXED {
                    values[target as usize] += scale * k;
                }
            }
        }
        let free = self.number.iter().zip(system.springs()).filter(|(n, _)| **n != FIXED);
        for (&number, &spring) in free {
            values[self.diagonal[number as usize] as usize] += spring;
        }
        match &mut self.factor {
            Some((factor, _)) => factor.refactorize(&self.matrix),
            None => {
                let factor = Cholesky::new(self.symbolic.clone(), &self.matrix)?;
                let scratch = factor.scratch(1);
                self.factor = Some((factor, scratch));
                Ok(())
            }
        }
    }

    /// `u = K^-1 f` at the free unknowns and 0 at the fixed ones.
    ///
    /// # Errors
    /// If nothing was factorized yet.
    pub fn solve(&mut self, force: &[f64], u: &mut [f64]) -> Result<()> {
        let Some((factor, scratch)) = &mut self.factor else {
            return Err(Error::Invalid("solve before the first factorization".into()));
        };
        for (&number, &f) in self.number.iter().zip(force) {
            if number != FIXED {
                self.work[number as usize] = f;
            }
        }
        factor.solve(&mut self.work, scratch);
        for (&number, u) in self.number.iter().zip(u) {
            *u = if number == FIXED { 0.0 } else { self.work[number as usize] };
        }
        Ok(())
    }
}

/// The matrix's pattern: unknowns of nodes that share an element.
fn pattern(system: &System, number: &[u32], count: usize) -> Result<SymmetricMatrix> {
    let (lattice, components) = (system.lattice(), system.element().components());
    let nodes = lattice.nodes();
    let reach = |at: usize, n: usize| at.saturating_sub(1)..=(at + 1).min(n - 1);
    let (mut offsets, mut rows) = (vec![0], Vec::new());
    for (unknown, _) in number.iter().enumerate().filter(|(_, n)| **n != FIXED) {
        let [i, j, k] = lattice.position(unknown / components);
        for kk in reach(k, nodes[0]) {
            for jj in reach(j, nodes[1]) {
                for ii in reach(i, nodes[2]) {
                    let first = lattice.node([ii, jj, kk]) * components;
                    let others = first.max(unknown)..(first + components).max(unknown);
                    rows.extend(
                        others.map(|o| number[o]).filter(|&n| n != FIXED).map(|n| n as usize),
                    );
                }
            }
        }
        offsets.push(rows.len());
    }
    if rows.len() >= FIXED as usize {
        return Err(Error::TooLarge {
            name: "stiffness matrix".into(),
            shape: vec![count, count],
            needed: format!("{} entries", rows.len()),
            available: format!("room for {FIXED}"),
        });
    }
    let values = vec![0.0; rows.len()];
    let matrix = CscMatrix::try_from_csc_data(count, count, offsets, rows, values)
        .map_err(|error| Error::Invalid(format!("pattern of the stiffness matrix: {error}")))?;
    SymmetricMatrix::from_csc(matrix)
}

/// Order of elimination of the free unknowns.
fn elimination(system: &System, number: &[u32]) -> Vec<usize> {
    let components = system.element().components();
    nested_dissection(&system.lattice().nodes(), false)
        .into_iter()
        .flat_map(|node| node * components..(node + 1) * components)
        .map(|unknown| number[unknown])
        .filter(|&n| n != FIXED)
        .map(|n| n as usize)
        .collect()
}

/// Where the entries of the element matrices and of the diagonal go.
fn targets(system: &System, number: &[u32], matrix: &SymmetricMatrix) -> (Vec<u32>, Vec<u32>) {
    let (lattice, components) = (system.lattice(), system.element().components());
    let (offsets, rows) = (matrix.offsets(), matrix.rows());
    let find = |row: u32, column: u32| {
        let span = offsets[column as usize]..offsets[column as usize + 1];
        let place = rows[span.clone()].binary_search(&(row as usize));
        place.map_or(FIXED, |p| (span.start + p) as u32)
    };
    let n = system.element().unknowns();
    let corners = lattice.offsets();
    let mut target = Vec::with_capacity(lattice.element_count() * n * (n + 1) / 2);
    for element in 0..lattice.element_count() {
        let first = lattice.first_node(element);
        let unknown =
            |r: usize| number[(first + corners[r / components]) * components + r % components];
        for r in 0..n {
            for c in 0..=r {
                let (a, b) = (unknown(r), unknown(c));
                let inside = a != FIXED && b != FIXED;
                target.push(if inside { find(a.max(b), a.min(b)) } else { FIXED });
            }
        }
    }
    let diagonal = (0..matrix.len() as u32).map(|n| find(n, n)).collect();
    (target, diagonal)
}
