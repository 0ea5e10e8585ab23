//! The taps of a Gaussian along one axis, and what they read beyond its ends.

use super::BlurEdges;
use crate::Float;

/// A symmetric filter along an axis of `n` voxels.
#[derive(Clone, Debug)]
pub(super) struct Axis<T> {
    edges: BlurEdges,
    /// Weights of the voxel itself and of those 1, 2, ... away; filled up with zeros so that
    /// the number of pairs is a multiple of [`GROUP`].
    pub(super) taps: Vec<T>,
    /// Voxel that stands at `i - radius`, for `i` from 0.
    source: Vec<usize>,
    /// Voxels whose sum in the transpose is not the symmetric one, with all their terms.
    pub(super) ends: Vec<(usize, Vec<(usize, T)>)>,
    radius: usize,
    /// 0 to twice the radius.
    pub(super) steps: Vec<usize>,
}

/// Pairs of taps that are added together.
pub(super) const GROUP: usize = 4;

impl<T: Float> Axis<T> {
    pub(super) fn new(n: usize, sigma: f64, edges: BlurEdges) -> Self {
        let pad = match edges {
            BlurEdges::Periodic => 0,
            BlurEdges::Replicate => (3.0 * sigma) as usize,
        };
        let length = n + 2 * pad;
        let weights = weights(length, sigma, T::EPSILON);
        let radius = (weights.len() - 1).next_multiple_of(GROUP);
        let inside = |p: isize| {
            let wrapped = (p + pad as isize).rem_euclid(length as isize) - pad as isize;
            wrapped.clamp(0, n as isize - 1) as usize
        };
        let source: Vec<usize> =
            (0..n + 2 * radius).map(|p| inside(p as isize - radius as isize)).collect();
        let steps = (0..=2 * radius).collect();
        let (taps, ends) = (Vec::new(), Vec::new());
        let mut axis = Self { edges, taps, source, ends, radius, steps };
        if edges == BlurEdges::Replicate {
            axis.ends = axis.transposed_ends(n, &weights);
        }
        let zeros = radius + 1 - weights.len();
        let zeros = std::iter::repeat_n(T::from_f64(0.0), zeros);
        axis.taps = weights.iter().map(|&w| T::from_f64(w)).chain(zeros).collect();
        axis
    }

    /// The farthest tap.
    pub(super) fn radius(&self) -> usize {
        self.radius
    }

    /// The voxels that stand at `i - radius` to `i + radius`.
    #[inline(always)]
    pub(super) fn rows(&self, i: usize) -> &[usize] {
        &self.source[i..=i + 2 * self.radius]
    }

    /// A line with what stands beyond its ends: `radius` more on either side.
    #[inline(always)]
    pub(super) fn extend(&self, line: &[T], out: &mut [T]) {
        let (n, r) = (line.len(), self.radius);
        out[r..r + n].copy_from_slice(line);
        if self.edges == BlurEdges::Periodic && r <= n {
            // Two copies take a fourth of the time of single numbers.
            out[..r].copy_from_slice(&line[n - r..]);
            out[r + n..n + 2 * r].copy_from_slice(&line[..r]);
        } else {
            for p in (0..r).chain(r + n..n + 2 * r) {
                out[p] = line[self.source[p]];
            }
        }
    }

    /// Fills the rows of `width` that stand before the first and behind the last: `radius` on
    /// either side.
    #[inline(always)]
    pub(super) fn extend_rows(&self, rows: &mut [T], width: usize) {
        let r = self.radius;
        let n = self.source.len() - 2 * r;
        for p in (0..r).chain(r + n..n + 2 * r) {
            let first = (r + self.source[p]) * width;
            rows.copy_within(first..first + width, p * width);
        }
    }

    /// Terms of the transposed sums within reach of the ends.
    fn transposed_ends(&self, n: usize, weights: &[f64]) -> Vec<(usize, Vec<(usize, T)>)> {
        let reach = weights.len() - 1;
        let ends: Vec<usize> =
            (0..n).filter(|&i| i < self.radius || i + self.radius >= n).collect();
        let terms = |i: usize| {
            let weight = |o: usize| {
                let steps = -(reach as isize)..=reach as isize;
                let at = |step: isize| self.rows(o)[self.radius.wrapping_add_signed(step)];
                let hits = steps.filter(|&step| at(step) == i);
                hits.map(|step| weights[step.unsigned_abs()]).sum::<f64>()
            };
            let all = (0..n).map(|o| (o, weight(o)));
            all.filter(|t| t.1 != 0.0).map(|(o, w)| (o, T::from_f64(w))).collect()
        };
        ends.into_iter().map(|i| (i, terms(i))).collect()
    }
}

/// Weights of a Gaussian on a ring of `n`: `exp(-j^2 / 2 sigma^2)` for j from -n/2 to
/// (n-1)/2, over their sum, from j = 0 to where all that follow are below a quarter of
/// `epsilon` together. The weight opposite on an even ring counts once, so half on each side.
fn weights(n: usize, sigma: f64, epsilon: f64) -> Vec<f64> {
    let tap = |j: usize| libm::exp(-((j * j) as f64) / (2.0 * sigma * sigma));
    let half = |j: usize| if 2 * j == n { 0.5 } else { 1.0 };
    let mut all: Vec<f64> = (0..=n / 2).map(|j| tap(j) * half(j)).collect();
    let total = all[0] + 2.0 * all[1..].iter().rev().sum::<f64>();
    let mut tail = 0.0;
    while all.len() > 1 && tail + 2.0 * all[all.len() - 1] < 0.25 * epsilon * total {
        tail += 2.0 * all[all.len() - 1];
        all.pop();
    }
    all.iter().map(|w| w / total).collect()
}
