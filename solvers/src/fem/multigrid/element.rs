//! Forces of a row of elements, one lane of a vector per element.
//!
//! | symbol | code           | meaning                                                   |
//! |--------|----------------|-----------------------------------------------------------|
//! | Ke     | `ke`           | matrix of an element of stiffness 1                       |
//! | H      | `walsh`        | sums and differences of corner values along each axis     |
//! | B      | `coefficients` | `H Ke H^T / 4^dim`, so that `Ke = H^T B H`                |
//!
//! A matrix that the element's mirrors leave unchanged has blocks in B: the function of
//! component c with odd axes w only meets those of equal `w xor c`'s axis. In three
//! dimensions that is 72 products and 144 sums for the 576 products of Ke; and rigid
//! translations give differences, and so forces, of exactly 0 in any precision.

use super::lattice::{Layout, SLACK};
use super::real::Real;
use pulp::{Simd, WithSimd};

/// Entries of B outside the blocks, relative to the largest, that count as rounding.
const ROUNDING: f64 = 1e-12;

/// The matrix of an element, ready to be applied to rows of elements.
#[derive(Clone, Debug)]
pub(super) struct Element<T> {
    /// Blocks `[odd axes][row][column]` of B, or Ke row by row.
    coefficients: Vec<T>,
    mirrored: bool,
    apply: fn(Row<'_, T>),
}

/// One row of elements.
pub(super) struct Row<'a, T> {
    pub element: &'a Element<T>,
    pub layout: &'a Layout,
    /// Node values, at the start of the rows at y = 0, 1 and, in 3D, z = 0, 1 behind them.
    pub nodes: [&'a [T]; 4],
    /// Stiffness of the elements; 0 beyond the end of the row.
    pub stiffness: &'a [T],
    /// Forces `[row of nodes][component][from the element right, left of it]`, each
    /// [`Layout::wide`] long and at the places of the nodes they act on.
    pub forces: &'a mut [T],
}

impl<T: Real> Element<T> {
    /// `ke` is symmetric, `components * 2^dim` rows, corners in binary order.
    pub(super) fn new(ke: &[f64], dim: usize, components: usize) -> Self {
        let blocks = mirror_blocks(ke, dim, components);
        let mirrored = blocks.is_some();
        let numbers = blocks.unwrap_or_else(|| ke.to_vec());
        let apply = match (dim, components) {
            (2, 1) => apply::<T, 1, 4>,
            (2, _) => apply::<T, 2, 4>,
            (_, 1) => apply::<T, 1, 8>,
            _ => apply::<T, 3, 8>,
        };
        Self { coefficients: numbers.into_iter().map(T::from_f64).collect(), mirrored, apply }
    }
}

impl<T: Real> Row<'_, T> {
    /// Writes the forces.
    pub(super) fn apply(self) {
        (self.element.apply)(self);
    }
}

/// Length of [`Row::forces`].
pub(super) fn force_len(layout: &Layout) -> usize {
    layout.lattice.corners() * layout.components * layout.wide()
}

/// Which function of component `c` is in the block `odd`.
#[inline(always)]
fn member<const C: usize>(odd: usize, c: usize) -> usize {
    if C == 1 { odd } else { odd ^ (1 << c) }
}

fn mirror_blocks(ke: &[f64], dim: usize, components: usize) -> Option<Vec<f64>> {
    let (corners, n) = (1 << dim, components << dim);
    // H[w][a]: -1 for each axis odd in w along which corner a is at 0.
    let walsh =
        |w: usize, a: usize| if (w & !a).count_ones().is_multiple_of(2) { 1.0 } else { -1.0 };
    let entry = |(c, w): (usize, usize), (d, v): (usize, usize)| {
        let terms = (0..corners * corners).map(|ab| {
            let (a, b) = (ab / corners, ab % corners);
            walsh(w, a) * ke[(a * components + c) * n + b * components + d] * walsh(v, b)
        });
        terms.sum::<f64>() / (corners * corners) as f64
    };
    let block = |c: usize, w: usize| if components == 1 { w } else { w ^ (1 << c) };
    let all = || (0..components).flat_map(|c| (0..corners).map(move |w| (c, w)));
    let largest = all().map(|i| entry(i, i).abs()).fold(0.0, f64::max);
    let is_zero = |i: (usize, usize), j: (usize, usize)| {
        block(i.0, i.1) == block(j.0, j.1) || entry(i, j).abs() <= ROUNDING * largest
    };
    if !all().all(|i| all().all(|j| is_zero(i, j))) {
        return None;
    }
    let mut blocks = Vec::with_capacity(corners * components * components);
    for odd in 0..corners {
        for c in 0..components {
            // `block` is its own inverse: it also tells which function is in a block.
            blocks.extend((0..components).map(|d| entry((c, block(c, odd)), (d, block(d, odd)))));
        }
    }
    Some(blocks)
}

fn apply<T: Real, const C: usize, const K: usize>(row: Row<'_, T>) {
    pulp::Arch::new().dispatch(Kernel::<T, C, K>(row));
}

struct Kernel<'a, T, const C: usize, const K: usize>(Row<'a, T>);

impl<T: Real, const C: usize, const K: usize> WithSimd for Kernel<'_, T, C, K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        if self.0.element.mirrored { self.run::<S, true>(simd) } else { self.run::<S, false>(simd) }
    }
}

impl<T: Real, const C: usize, const K: usize> Kernel<'_, T, C, K> {
    #[inline(always)]
    #[expect(clippy::needless_range_loop, reason = "one index serves several arrays")]
    fn run<S: Simd, const MIRRORED: bool>(self, simd: S) {
        let Row { element, layout, nodes, stiffness, forces } = self.0;
        let (stride, wide) = (layout.stride, layout.wide());
        let last = layout.lattice.elements()[2];
        let nodes = nodes.map(|row| &row[..(C - 1) * stride + last + SLACK + 1]);
        for first in (1..=last).step_by(T::lanes::<S>()) {
            let mut values = [[T::splat(simd, T::default()); K]; C];
            for c in 0..C {
                for a in 0..K {
                    values[c][a] = T::load(simd, &nodes[a >> 1][c * stride + first + (a & 1)..]);
                }
            }
            let stiffness = T::load(simd, &stiffness[first..]);
            let result = if MIRRORED {
                in_blocks::<T, S, C, K>(simd, &element.coefficients, stiffness, values)
            } else {
                in_full::<T, S, C, K>(simd, &element.coefficients, stiffness, &values)
            };
            for c in 0..C {
                for a in 0..K {
                    let side = ((a >> 1) * C + c) * 2 + (a & 1);
                    T::store(simd, &mut forces[side * wide + first + (a & 1)..], result[c][a]);
                }
            }
        }
    }
}

/// `E H^T B H u` for a vector of elements.
#[inline(always)]
#[expect(clippy::needless_range_loop, reason = "one index serves several arrays")]
fn in_blocks<T: Real, S: Simd, const C: usize, const K: usize>(
    simd: S,
    blocks: &[T],
    stiffness: T::Vector<S>,
    mut values: [[T::Vector<S>; K]; C],
) -> [[T::Vector<S>; K]; C] {
    for value in &mut values {
        for axis in [1, 2, 4] {
            for a in (0..K).filter(|a| a & axis == 0 && axis < K) {
                let (low, high) = (value[a], value[a | axis]);
                value[a] = T::plus(simd, low, high);
                value[a | axis] = T::minus(simd, high, low);
            }
        }
    }
    let blocks = &blocks[..K * C * C];
    for odd in 0..K {
        let old: [_; C] = std::array::from_fn(|c| values[c][member::<C>(odd, c)]);
        for c in 0..C {
            let factor = |d: usize| T::splat(simd, blocks[(odd * C + c) * C + d]);
            let mut sum = T::times(simd, factor(0), old[0]);
            for d in 1..C {
                sum = T::times_plus(simd, factor(d), old[d], sum);
            }
            values[c][member::<C>(odd, c)] = T::times(simd, stiffness, sum);
        }
    }
    for value in &mut values {
        for axis in [1, 2, 4] {
            for a in (0..K).filter(|a| a & axis == 0 && axis < K) {
                let (even, odd) = (value[a], value[a | axis]);
                value[a] = T::minus(simd, even, odd);
                value[a | axis] = T::plus(simd, even, odd);
            }
        }
    }
    values
}

/// `E Ke u` for a vector of elements.
#[inline(always)]
fn in_full<T: Real, S: Simd, const C: usize, const K: usize>(
    simd: S,
    ke: &[T],
    stiffness: T::Vector<S>,
    values: &[[T::Vector<S>; K]; C],
) -> [[T::Vector<S>; K]; C] {
    let mut result = [[T::splat(simd, T::default()); K]; C];
    for (row, entries) in ke.chunks_exact(K * C).enumerate() {
        let mut sum = T::splat(simd, T::default());
        for (column, &entry) in entries.iter().enumerate() {
            let value = values[column % C][column / C];
            sum = T::times_plus(simd, T::splat(simd, entry), value, sum);
        }
        result[row % C][row / C] = T::times(simd, stiffness, sum);
    }
    result
}
