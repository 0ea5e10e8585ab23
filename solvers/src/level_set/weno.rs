//! Fifth-order WENO differences for Hamilton-Jacobi equations, row by row.
//!
//! Jiang & Peng 2000, SIAM J. Sci. Comput. 21:2126, eqs (2.7) to (2.11); the
//! weights' epsilon scales with the slopes as in Osher & Fedkiw 2003, eq. (3.38).
#![allow(
    clippy::needless_range_loop,
    reason = "rows side by side share one index; zips would hide the stencil"
)]

use super::{ghost::Row, upwind::max};

/// Upwind slope from five neighbouring differences, the most upwind one first.
///
/// The weights are multiplied through by all smoothness terms, which leaves one
/// division; 1e-40 keeps their products from underflowing where phi is flat.
#[inline(always)]
fn slope([v1, v2, v3, v4, v5]: [f64; 5]) -> f64 {
    let square = |v: f64| v * v;
    let greatest = max(max(max(v1 * v1, v2 * v2), max(v3 * v3, v4 * v4)), v5 * v5);
    let epsilon = 1e-6 * greatest + 1e-40;
    let (left, middle, right) = (v1 - 2.0 * v2 + v3, v2 - 2.0 * v3 + v4, v3 - 2.0 * v4 + v5);
    let smooth = |second: f64, first: f64| {
        square(epsilon + 13.0 / 12.0 * square(second) + 0.25 * square(first))
    };
    let s1 = smooth(left, v1 - 4.0 * v2 + 3.0 * v3);
    let s2 = smooth(middle, v2 - v4);
    let s3 = smooth(right, 3.0 * v3 - 4.0 * v4 + v5);
    let (a1, a2, a3) = (s2 * s3, 6.0 * (s1 * s3), 3.0 * (s1 * s2));
    let q1 = 2.0 * v1 - 7.0 * v2 + 11.0 * v3;
    let q2 = 5.0 * v3 - v2 + 2.0 * v4;
    let q3 = 2.0 * v3 + 5.0 * v4 - v5;
    (a1 * q1 + a2 * q2 + a3 * q3) / (6.0 * (a1 + a2 + a3))
}

/// The six differences, not yet divided by h, between nodes -3 to 3 along an axis.
#[inline(always)]
fn differences(line: &[&[f64]; 7], i: usize) -> [f64; 6] {
    std::array::from_fn(|k| line[k + 1][i] - line[k][i])
}

#[inline(always)]
fn lines<'a>(row: Row<'a>, axis: usize) -> [&'a [f64]; 7] {
    std::array::from_fn(|k| &row.along(axis, k as isize - 3)[..row.len()])
}

/// `rate = -beta max(|grad phi|, floor)` with Godunov's |grad phi|, see
/// [`upwind::normal`](super::upwind::normal).
#[inline(always)]
pub(super) fn normal(
    row: Row<'_>,
    dim: usize,
    beta: &[f64],
    (per_h, floor): (f64, f64),
    rate: &mut [f64],
) {
    let n = row.len();
    let (beta, rate) = (&beta[..n], &mut rate[..n]);
    rate.fill(0.0);
    for axis in 0..dim {
        let line = lines(row, axis);
        for i in 0..n {
            let [d0, d1, d2, d3, d4, d5] = differences(&line, i);
            let sign = 1.0_f64.copysign(beta[i]);
            let back = sign * slope([d0, d1, d2, d3, d4]);
            let ahead = -sign * slope([d5, d4, d3, d2, d1]);
            let steepest = max(max(back, ahead), 0.0);
            rate[i] += steepest * steepest;
        }
    }
    for i in 0..n {
        rate[i] = -beta[i] * max(rate[i].sqrt() * per_h, floor);
    }
}

/// `rate -= v D phi` along one axis, D taken on the side that v comes from.
#[inline(always)]
pub(super) fn velocity(row: Row<'_>, axis: usize, v: &[f64], per_h: f64, rate: &mut [f64]) {
    let n = row.len();
    let (v, rate) = (&v[..n], &mut rate[..n]);
    let line = lines(row, axis);
    for i in 0..n {
        let d = differences(&line, i);
        let upwind = std::array::from_fn(|k| if v[i] > 0.0 { d[k] } else { d[5 - k] });
        rate[i] -= v[i] * per_h * slope(upwind);
    }
}

#[cfg(test)]
mod tests {
    use super::slope;

    #[test]
    fn slope_of_a_parabola_is_exact_for_any_weights() {
        // All three candidates agree.
        let phi = |x: f64| 3.0 * x * x - x;
        let d = |k: f64| phi(k) - phi(k - 1.0);
        assert!((slope([d(-1.0), d(0.0), d(1.0), d(2.0), d(3.0)]) - 5.0).abs() < 1e-14);
    }

    #[test]
    fn slope_next_to_a_kink_ignores_the_far_side() {
        // |phi'| = 1 on the upwind side, 100 beyond a kink: within the weights' epsilon of 1.
        assert!((slope([1.0, 1.0, 1.0, 100.0, 100.0]) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn flat_is_flat() {
        assert_eq!(slope([0.0; 5]), 0.0);
        // Neither underflow nor 0/0, only rounding.
        assert!((slope([1e-30; 5]) / 1e-30 - 1.0).abs() < 1e-14);
    }
}
