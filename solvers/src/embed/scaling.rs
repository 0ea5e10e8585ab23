//! Classical scaling (principal coordinates).

use crate::Result;
use crate::distances::check_distances;
use crate::random::{normal, stream};
use nalgebra::{DMatrix, SymmetricEigen};
use ndarray::ArrayView2;
use rayon::prelude::*;

/// Vectors iterated at once: those beyond the two wanted speed up convergence.
const BLOCK: usize = 8;

/// Iterations; the error falls as `(lambda_9 / lambda_2)^k`.
const ITERATIONS: usize = 60;

/// Positions in the plane whose distances are nearest to `distances` (shape `[n, n]`) in
/// the sense of Torgerson 1952: the two leading eigenvectors of `-J D^2 J / 2`, by
/// subspace iteration. Right to rounding for points of a plane; centred at the origin.
///
/// # Errors
/// If the distances are no square of finite, symmetric, non-negative numbers.
pub fn classical_scaling(distances: ArrayView2<'_, f64>) -> Result<Vec<[f64; 2]>> {
    let n = check_distances(distances)?;
    let block = BLOCK.min(n);
    let mut random = stream(0, "classical scaling", 0);
    let mut basis = DMatrix::from_fn(n, block, |_, _| normal(&mut random));
    for _ in 0..ITERATIONS {
        basis = multiply(distances, &basis).qr().q();
    }
    let image = multiply(distances, &basis);
    let small = basis.tr_mul(&image);
    let eigen = SymmetricEigen::new((&small + small.transpose()) * 0.5);
    let mut order: Vec<usize> = (0..block).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let mut positions = vec![[0.0; 2]; n];
    for (axis, &k) in order.iter().take(2).enumerate() {
        let vector = &basis * eigen.eigenvectors.column(k);
        // The sign of an eigenvector is arbitrary: its largest entry points up.
        let sign = vector[vector.icamax()].signum();
        let length = sign * eigen.eigenvalues[k].max(0.0).sqrt();
        positions.iter_mut().zip(&vector).for_each(|(p, v)| p[axis] = length * v);
    }
    Ok(positions)
}

/// `-J D^2 J V / 2` with the centring `J = 1 - 1 1^T / n`.
fn multiply(distances: ArrayView2<'_, f64>, vectors: &DMatrix<f64>) -> DMatrix<f64> {
    let (n, columns) = vectors.shape();
    let mut centred = vectors.clone();
    center(&mut centred);
    // Row by row in memory, so that a row of distances is read once.
    let rows = centred.transpose();
    let mut product = DMatrix::zeros(columns, n);
    product.as_mut_slice().par_chunks_mut(columns).enumerate().for_each(|(i, out)| {
        for (d, row) in distances.row(i).iter().zip(rows.as_slice().chunks_exact(columns)) {
            let factor = -0.5 * d * d;
            out.iter_mut().zip(row).for_each(|(out, v)| *out += factor * v);
        }
    });
    let mut product = product.transpose();
    center(&mut product);
    product
}

fn center(vectors: &mut DMatrix<f64>) {
    for mut column in vectors.column_iter_mut() {
        let mean = column.mean();
        column.add_scalar_mut(-mean);
    }
}
