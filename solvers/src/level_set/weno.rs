//! Fifth-order WENO differences for Hamilton-Jacobi equations, row by row.
//!
//! The three candidates and their ideal weights 1/10, 6/10, 3/10 are those of Jiang &
//! Peng 2000, SIAM J. Sci. Comput. 21:2126, eqs (2.7) to (2.11). The weights have the form
//! of WENO-Z (Borges, Carmona, Costa & Don 2008, J. Comput. Phys. 227:3191),
//! `d_k (1 + (tau / beta_k)^p)` divided by their sum, whose tau is small only where the
//! five differences are smooth together. They keep corners of a front sharper than
//! Jiang & Peng's `d_k / beta_k^2`: after one turn of Zalesak's disk the contour is off
//! by half as much.
#![allow(
    clippy::needless_range_loop,
    reason = "rows side by side share one index; zips would hide the stencil"
)]

use super::{ghost::Row, upwind::max};

/// Upwind slope from five neighbouring differences, the most upwind one first.
///
/// tau is the modulus of their fourth difference; its square is the smoothest
/// indicator of WENO-Z-eta (Fan, Shen, Tian & Yang 2014, J. Comput. Phys. 269:329).
/// beta_k, of the same unit, is the greater of a candidate's first and second derivative
/// where the Euclidean norm is usual. That and p = 3, or 3/2 between squares, are our
/// choice: no p in either norm leaves the contour of Zalesak's disk on 200 cells nearer
/// to the exact one (p = 4 between moduli as near), and they need no square root. The
/// relative 1e-3 is the square root of the one of Osher & Fedkiw 2003, eq. (3.38).
///
/// The weights are multiplied through by all cubes, which leaves one division; 1e-30
/// keeps the products, of degree nine, from underflowing where phi is flat. `greatest`
/// is the greatest modulus of the last four, which both slopes at a node share; so are
/// the second differences, written such that reversing the order gives the same bits.
#[inline(always)]
fn slope([v1, v2, v3, v4, v5]: [f64; 5], greatest: f64) -> f64 {
    let cube = |v: f64| v * v * v;
    let epsilon = 1e-3 * max(v1.abs(), greatest) + 1e-30;
    let (left, middle, right) = (v1 + v3 - 2.0 * v2, v2 + v4 - 2.0 * v3, v3 + v5 - 2.0 * v4);
    let b1 = cube(epsilon + size(left, 0.5 * left + (v3 - v2)));
    let b2 = cube(epsilon + size(middle, 0.5 * (v4 - v2)));
    let b3 = cube(epsilon + size(right, 0.5 * right - (v4 - v3)));
    // Third differences: how far the outer candidates lie from the middle one.
    let (off1, off3) = (left - middle, middle - right);
    let tau = cube((off1 - off3).abs());
    let a1 = (b1 + tau) * (b2 * b3);
    let a2 = 6.0 * ((b2 + tau) * (b1 * b3));
    let a3 = 3.0 * ((b3 + tau) * (b1 * b2));
    let central = (1.0 / 6.0) * (5.0 * v3 - v2 + 2.0 * v4);
    central + (2.0 * a1 * off1 + a3 * off3) / (6.0 * (a1 + a2 + a3))
}

/// The greater of two moduli.
#[inline(always)]
fn size(a: f64, b: f64) -> f64 {
    max(a.abs(), b.abs())
}

/// The greatest modulus of the differences that every upwind slope at a node uses.
#[inline(always)]
fn greatest([_, d1, d2, d3, d4, _]: [f64; 6]) -> f64 {
    max(size(d1, d2), size(d3, d4))
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
            let d @ [d0, d1, d2, d3, d4, d5] = differences(&line, i);
            let greatest = greatest(d);
            let sign = 1.0_f64.copysign(beta[i]);
            let back = sign * slope([d0, d1, d2, d3, d4], greatest);
            let ahead = -sign * slope([d5, d4, d3, d2, d1], greatest);
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
        rate[i] -= v[i] * per_h * slope(upwind, greatest(d));
    }
}

#[cfg(test)]
mod tests {
    fn slope(v: [f64; 5]) -> f64 {
        super::slope(v, v[1..].iter().fold(0.0, |m, v| v.abs().max(m)))
    }

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
    fn slope_is_of_fifth_order_also_where_the_second_derivative_vanishes() {
        // phi = sin x; the weights of Jiang & Peng may fall to a lower order at x = 0.
        for (at, exact) in [(0.0, 1.0), (1.0, 1.0_f64.cos())] {
            let error = |h: f64| {
                let phi = |k: f64| (at + k * h).sin();
                let d = |k: f64| phi(k) - phi(k - 1.0);
                (slope([d(-2.0), d(-1.0), d(0.0), d(1.0), d(2.0)]) / h - exact).abs()
            };
            let order = (error(0.1) / error(0.05)).log2();
            assert!((order - 5.0).abs() < 0.3 || order > 5.0, "order {order} at {at}");
        }
    }

    #[test]
    fn flat_is_flat() {
        assert_eq!(slope([0.0; 5]), 0.0);
        // Neither underflow nor 0/0, only rounding.
        assert!((slope([1e-30; 5]) / 1e-30 - 1.0).abs() < 1e-14);
    }
}
