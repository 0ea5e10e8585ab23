//! Matrices of mutual distances.

use crate::{Error, Result};
use ndarray::ArrayView2;

/// Number of points of a distance matrix.
///
/// # Errors
/// Unless it is square, not empty, and its entries are finite, non-negative, symmetric
/// and zero on the diagonal.
pub(crate) fn check_distances(distances: ArrayView2<'_, f64>) -> Result<usize> {
    let n = distances.nrows();
    if n == 0 || distances.ncols() != n {
        return Err(Error::Shape {
            name: "distances".into(),
            actual: distances.shape().to_vec(),
            expected: vec![n.max(1); 2],
        });
    }
    for ((i, j), &d) in distances.indexed_iter() {
        if !(d >= 0.0 && d.is_finite()) {
            let name = format!("distance between points {i} and {j}");
            return Err(Error::out_of_range(&name, d, "[0, inf)"));
        }
        if d != distances[[j, i]] || (i == j && d != 0.0) {
            return Err(Error::Invalid(format!(
                "distance between points {i} and {j} is {d} one way and {} the other; \
                 distances must be symmetric, and 0 from a point to itself",
                distances[[j, i]]
            )));
        }
    }
    Ok(n)
}
