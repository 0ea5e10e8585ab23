//! Motion by mean curvature with central differences, row by row.
#![allow(
    clippy::needless_range_loop,
    reason = "rows side by side share one index; zips would hide the stencil"
)]

use super::{ghost::Row, upwind::max};

/// Square of the gradient below which motion by curvature turns into diffusion (no unit).
///
/// Evans & Spruck 1991: `|grad phi| kappa = lap phi - n . H n` with
/// `n = grad phi / sqrt(|grad phi|^2 + epsilon)`. A minimum of phi, where the
/// gradient is zero, then rises, so that a shrinking disk really vanishes.
const EPSILON: f64 = 1e-12;

/// Adds `b kappa |grad phi|` to `rate` (second order), kappa being the sum of the
/// principal curvatures, with |kappa| at most (dim - 1)/h. Zero in 1D.
///
/// The limit multiplies the steepest one-sided gradient: no curvature finer than
/// the grid is meaningful, and without it a kink would move the front by cells.
#[inline(always)]
pub(super) fn add<const DIM: usize>(row: Row<'_>, b: &[f64], per_h: f64, rate: &mut [f64]) {
    let n = row.len();
    let (center, b, rate) = (&row.along(0, 0)[..n], &b[..n], &mut rate[..n]);
    let before: [&[f64]; DIM] = std::array::from_fn(|axis| &row.along(axis, -1)[..n]);
    let after: [&[f64]; DIM] = std::array::from_fn(|axis| &row.along(axis, 1)[..n]);
    let corners: [[[&[f64]; 4]; DIM]; DIM] = std::array::from_fn(|axis| {
        std::array::from_fn(|other| {
            let corner =
                |p, q| if axis < other { &row.diagonal(axis, p, other, q)[..n] } else { center };
            [corner(1, 1), corner(-1, -1), corner(1, -1), corner(-1, 1)]
        })
    });
    let limit = (DIM as f64 - 1.0) * per_h * per_h;
    for i in 0..n {
        let c = center[i];
        let (mut first, mut second) = ([0.0; DIM], [0.0; DIM]);
        let (mut square, mut laplacian, mut steepest) = (0.0, 0.0, 0.0);
        for axis in 0..DIM {
            let (back, ahead) = (c - before[axis][i], after[axis][i] - c);
            first[axis] = 0.5 * (back + ahead);
            second[axis] = ahead - back;
            square += first[axis] * first[axis];
            laplacian += second[axis];
            steepest += max(back * back, ahead * ahead);
        }
        // n . H n times the squared gradient; mixed parts apart, so that swapping x and
        // y swaps the same bytes.
        let (mut normal, mut mixed) = (0.0, 0.0);
        for axis in 0..DIM {
            normal += first[axis] * first[axis] * second[axis];
            for other in axis + 1..DIM {
                let [pp, mm, pm, mp] = corners[axis][other].map(|corner| corner[i]);
                mixed += 0.5 * (first[axis] * first[other]) * ((pp + mm) - (pm + mp));
            }
        }
        // Differences are not divided by h: squares carry h^2, phi itself h.
        let floor = EPSILON / (per_h * per_h);
        let curvature = per_h * per_h * (laplacian - (normal + mixed) / (square + floor));
        let bound = limit * steepest.sqrt();
        rate[i] += b[i] * max(-bound, -max(-bound, -curvature));
    }
}
