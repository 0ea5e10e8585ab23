//! The one costly operation: sums of exponentials over a cloud, in log space.

use super::PointCloud;
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

/// Points that are summed or left out together.
pub(super) const BLOCK: usize = 64;

/// Lanes of a sum: the widest vector of `f32`.
const LANES: usize = 16;

/// Rows given to a thread at a time.
const ROWS: usize = 32;

/// Fewest terms worth a second thread.
const SERIAL: usize = 1 << 18;

/// Powers of 2 below the largest term at which terms are left out: less than 1e-8
/// in all for 10^4 terms, a tenth of what the exponentials themselves are off.
const NEGLIGIBLE: f64 = 40.0;

/// How far (powers of 2) a term may exceed the number that is taken off all exponents;
/// such a distance costs the single-precision exponents 2^-22.
const SLACK: f64 = 4.0;

/// A cloud prepared for one sum: `h_j = log2(b_j) + g_j / (eps ln 2)`, and lengths in
/// units of `sqrt(2 eps ln 2)`, so that the terms are `2^(h_j - |x_i - y_j|^2)`.
#[derive(Debug, Default)]
pub(super) struct Source {
    h: Vec<[f64; BLOCK]>,
    axes: Vec<Vec<[f64; BLOCK]>>,
    /// Least and greatest coordinates of the blocks.
    boxes: Vec<[Vec<f64>; 2]>,
    /// Greatest `h` of the blocks.
    tops: Vec<f64>,
}

impl Source {
    fn prepare<const D: usize>(&mut self, cloud: &PointCloud<D>, potential: &[f64], eps: f64) {
        let blocks = cloud.len().div_ceil(BLOCK);
        let (unit, scale) = (1.0 / length_unit(eps), 1.0 / (eps * std::f64::consts::LN_2));
        self.h.clear();
        self.h.resize(blocks, [f64::NEG_INFINITY; BLOCK]);
        let h = self.h.as_flattened_mut().iter_mut();
        match potential {
            [] => h.zip(&cloud.log_weights).for_each(|(h, &w)| *h = w),
            _ => h
                .zip(cloud.log_weights.iter().zip(potential))
                .for_each(|(h, (&w, &g))| *h = w + g * scale),
        }
        self.tops.clear();
        let top = |h: &[f64; BLOCK]| h.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        self.tops.extend(self.h.iter().map(top));
        self.axes.resize(D, Vec::new());
        self.boxes.resize(D, [Vec::new(), Vec::new()]);
        for (axis, cloud) in self.axes.iter_mut().zip(&cloud.axes) {
            axis.clear();
            axis.resize(blocks, [0.0; BLOCK]);
            axis.as_flattened_mut().iter_mut().zip(cloud).for_each(|(y, &x)| *y = x * unit);
        }
        for (target, ends) in self.boxes.iter_mut().flatten().zip(cloud.blocks.iter().flatten()) {
            target.clear();
            target.extend(ends.iter().map(|x| x * unit));
        }
    }
}

/// `sqrt(2 eps ln 2)`.
fn length_unit(eps: f64) -> f64 {
    (2.0 * eps * std::f64::consts::LN_2).sqrt()
}

/// Soft minima `-factor eps log sum_j b_j exp((g_j - C(x_i, y_j)) / eps)` at all points
/// `x_i` of `rows`; an empty `potential` is zero.
pub(super) fn softmin<const D: usize>(
    source: &mut Source,
    rows: &PointCloud<D>,
    columns: &PointCloud<D>,
    potential: &[f64],
    eps: f64,
    factor: f64,
    out: &mut Vec<f64>,
) {
    source.prepare(columns, potential, eps);
    out.resize(rows.len(), 0.0);
    let (source, arch) = (&*source, Arch::new());
    let scale = -factor * eps * std::f64::consts::LN_2;
    let unit = 1.0 / length_unit(eps);
    let run = |(index, out): (usize, &mut [f64])| {
        arch.dispatch(Rows { source, cloud: rows, first: index * ROWS, unit, scale, out });
    };
    if rows.len() * columns.len() < SERIAL {
        out.chunks_mut(ROWS).enumerate().for_each(run);
    } else {
        out.par_chunks_mut(ROWS).enumerate().for_each(run);
    }
}

/// Soft minima of neighbouring rows.
struct Rows<'a, const D: usize> {
    source: &'a Source,
    cloud: &'a PointCloud<D>,
    first: usize,
    unit: f64,
    scale: f64,
    out: &'a mut [f64],
}

impl<const D: usize> NullaryFnOnce for Rows<'_, D> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { source, cloud, first, unit, scale, out } = self;
        let mut bounds = vec![0.0; source.tops.len()];
        for (i, out) in out.iter_mut().enumerate() {
            let mut x = [0.0; D];
            for (x, axis) in x.iter_mut().zip(&cloud.axes) {
                *x = axis[first + i] * unit;
            }
            *out = scale * log_sum(source, x, &mut bounds);
        }
    }
}

/// `log2 sum_j 2^(h_j - |x - y_j|^2)`.
#[inline(always)]
fn log_sum<const D: usize>(source: &Source, x: [f64; D], bounds: &mut [f64]) -> f64 {
    bounds.copy_from_slice(&source.tops);
    for (x, [low, high]) in x.iter().zip(&source.boxes) {
        for (bound, (low, high)) in bounds.iter_mut().zip(low.iter().zip(high)) {
            // Distance to the block's box along this axis.
            let away = greater(greater(low - x, x - high), 0.0);
            *bound -= away * away;
        }
    }
    let (mut best, mut highest) = (0, f64::NEG_INFINITY);
    for (b, &bound) in bounds.iter().enumerate() {
        if bound > highest {
            (best, highest) = (b, bound);
        }
    }
    let mut terms = [0.0; BLOCK];
    let mut top = greatest(source, best, x, &mut terms);
    if highest > top + SLACK {
        for (b, &bound) in bounds.iter().enumerate() {
            if bound > top + SLACK {
                top = greater(top, greatest(source, b, x, &mut terms));
            }
        }
    }
    let mut sums = [0.0_f64; LANES];
    for (b, &bound) in bounds.iter().enumerate() {
        if bound < top - NEGLIGIBLE {
            continue;
        }
        exponents(source, b, x, &mut terms);
        let mut block = [0.0_f32; LANES];
        for lanes in terms.as_chunks::<LANES>().0 {
            for (sum, term) in block.iter_mut().zip(lanes) {
                *sum += exp2((term - top) as f32);
            }
        }
        for (sum, block) in sums.iter_mut().zip(block) {
            *sum += f64::from(block);
        }
    }
    top + libm::log2(sums.iter().sum::<f64>())
}

/// The exponents `h_j - |x - y_j|^2` of a block.
#[inline(always)]
fn exponents<const D: usize>(source: &Source, block: usize, x: [f64; D], out: &mut [f64; BLOCK]) {
    *out = source.h[block];
    for (x, axis) in x.iter().zip(&source.axes) {
        for (out, y) in out.iter_mut().zip(&axis[block]) {
            let away = x - y;
            *out -= away * away;
        }
    }
}

/// The greatest exponent of a block.
#[inline(always)]
fn greatest<const D: usize>(
    source: &Source,
    block: usize,
    x: [f64; D],
    terms: &mut [f64; BLOCK],
) -> f64 {
    exponents(source, block, x, terms);
    let mut lanes = [f64::NEG_INFINITY; LANES];
    for chunk in terms.as_chunks::<LANES>().0 {
        for (lane, &term) in lanes.iter_mut().zip(chunk) {
            *lane = greater(*lane, term);
        }
    }
    lanes.into_iter().fold(f64::NEG_INFINITY, greater)
}

/// The greater of two numbers that are not NaN: one instruction, which `f64::max` is not.
#[inline(always)]
fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// `2^t` to 2e-7 for `t` in [-126, 127], about 1e-38 below.
#[inline(always)]
fn exp2(t: f32) -> f32 {
    /// Added to a number, leaves its nearest integer in the last bits.
    const ROUND: f32 = 12_582_912.0; // 1.5 * 2^23
    /// Taylor coefficients `(ln 2)^k / k!`; the next one contributes 1e-7 at t = 1/2.
    const TAYLOR: [f32; 7] = [
        1.0,
        std::f32::consts::LN_2,
        0.240_226_5,
        0.055_504_11,
        0.009_618_129,
        0.001_333_355_8,
        0.000_154_035_3,
    ];
    let t = if t > -126.0 { t } else { -126.0 };
    let rounded = t + ROUND;
    let r = t - (rounded - ROUND);
    let mut p = TAYLOR[6];
    let mut k = 6;
    while k > 0 {
        k -= 1;
        p = p * r + TAYLOR[k];
    }
    f32::from_bits(p.to_bits().wrapping_add(rounded.to_bits() << 23))
}

#[cfg(test)]
mod tests {
    #[test]
    fn powers_of_two() {
        for n in 0..=130_000 {
            let t = 4.0 - n as f32 * 1e-3;
            let exact = libm::exp2(f64::from(t));
            assert!((f64::from(super::exp2(t)) / exact - 1.0).abs() < 2.5e-7, "{t}");
        }
        assert!(super::exp2(f32::NEG_INFINITY) < 2e-38);
    }
}
