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

/// Points that the tests of several modules look at.
#[cfg(test)]
pub(crate) mod examples {
    use ndarray::Array2;

    pub(crate) fn distances<const D: usize>(points: &[[f64; D]]) -> Array2<f64> {
        Array2::from_shape_fn((points.len(), points.len()), |(i, j)| {
            (0..D).map(|d| (points[i][d] - points[j][d]).powi(2)).sum::<f64>().sqrt()
        })
    }

    /// Three spirals of different density, and scattered points.
    pub(crate) fn spirals() -> Vec<[f64; 2]> {
        let mut points = Vec::new();
        for (c, (x, y, s, n)) in
            [(0.0, 0.0, 1.0, 40), (9.0, 1.0, 0.6, 25), (4.0, 9.0, 2.0, 50)].into_iter().enumerate()
        {
            points.extend((0..n).map(|k| {
                let r = s * ((f64::from(k) + 0.5) / f64::from(n)).sqrt() * 1.8;
                let t = 2.399963229728653 * f64::from(k) + c as f64;
                [x + r * libm::cos(t), y + r * libm::sin(t)]
            }));
        }
        let scattered = |k: i32, ratio: f64| -12.0 + 33.0 * (f64::from(k) * ratio).fract();
        points.extend(
            (0..20).map(|k| [scattered(k, 0.618033988749895), scattered(k, 0.754877666246693)]),
        );
        points
    }
}
