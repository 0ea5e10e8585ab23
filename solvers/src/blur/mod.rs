//! Gaussian blur of fields of three axes, by short sums along each.
//!
//! The first pass blurs each plane along x and y, the second along z.

mod axis;

#[cfg(test)]
mod tests;

use crate::slab::planes_per_slab;
use crate::{Aligned, Error, Float, Result};
use axis::{Axis, GROUP};
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;

/// Numbers that are computed together.
const CHUNK: usize = 16;

/// Numbers of a plane that are blurred along z before the next ones: with two slabs' planes
/// around them they stay in the first-level cache.
const STRETCH: usize = 16 * CHUNK;

/// What stands beyond the box that is blurred.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlurEdges {
    /// The box repeats itself.
    Periodic,
    /// The outer voxels repeat, `3 sigma` times; the box so extended is periodic, which farther
    /// out takes 0.3 % of the weight to the other side (as Song's program has it).
    Replicate,
}

/// Separable Gaussian blur of standard deviation `sigma` voxels.
///
/// Along each axis the weights are `exp(-j^2 / 2 sigma^2)` up to half the axis, over their
/// sum, cut where the rest is below the rounding of `T`. On a periodic box the blur is its
/// own transpose. The same bytes result for any number of threads.
#[derive(Clone, Debug)]
pub struct Blur<T> {
    shape: [usize; 3],
    /// Along z, y, x.
    axes: [Axis<T>; 3],
    work: Vec<Work<T>>,
}

#[derive(Clone, Debug)]
struct Work<T> {
    /// A row with what stands beyond its ends, and up to a whole chunk.
    line: Aligned<T>,
    /// The plane blurred along x, with what stands beyond its first and last rows; rows of whole
    /// chunks, the rest of which means nothing.
    turned: Aligned<T>,
    /// The same blurred along y.
    blurred: Aligned<T>,
}

impl<T: Float> Blur<T> {
    /// A blur for fields of `shape` `[nz, ny, nx]`.
    ///
    /// # Errors
    /// Unless sigma is positive and finite, and no axis is empty.
    pub fn new(shape: [usize; 3], sigma: f64, edges: BlurEdges) -> Result<Self> {
        if !(sigma > 0.0 && sigma.is_finite()) {
            return Err(Error::out_of_range("sigma", sigma, "(0, inf)"));
        }
        if shape.contains(&0) {
            return Err(Error::Invalid(format!("shape {shape:?} has an axis of 0 voxels")));
        }
        Ok(Self { shape, axes: shape.map(|n| Axis::new(n, sigma, edges)), work: Vec::new() })
    }

    /// The blurred `field` into `out`; `between` is overwritten.
    ///
    /// # Panics
    /// If a slice has not one number per voxel.
    pub fn apply(&mut self, field: &[T], between: &mut [T], out: &mut [T]) {
        self.inner::<false>(field, between);
        self.outer::<false>(between, out);
    }

    /// Applies the transpose of [`Blur::apply`] to `field`; `between` is overwritten.
    ///
    /// # Panics
    /// As [`Blur::apply`].
    pub fn transpose(&mut self, field: &mut [T], between: &mut [T]) {
        self.inner::<true>(field, between);
        self.outer::<true>(between, field);
    }

    fn slab(&self) -> usize {
        planes_per_slab(self.shape[0], self.shape.iter().product())
    }

    fn inner<const TRANSPOSED: bool>(&mut self, field: &[T], between: &mut [T]) {
        let [nz, ny, nx] = self.shape;
        assert_eq!(field.len(), nz * ny * nx, "one number per voxel");
        assert_eq!(between.len(), field.len(), "one number per voxel");
        let slab = self.slab();
        let zero = T::from_f64(0.0);
        let wide = nx.next_multiple_of(CHUNK);
        let line = wide + 2 * self.axes[2].radius();
        let rows = ny + 2 * self.axes[1].radius();
        self.work.resize_with(nz.div_ceil(slab), || Work {
            line: Aligned::new(line, zero),
            turned: Aligned::new(rows * wide, zero),
            blurred: Aligned::new(ny * wide, zero),
        });
        let axes = &self.axes;
        let parts = between.par_chunks_mut(slab * ny * nx).zip(field.par_chunks(slab * ny * nx));
        parts.zip(self.work.par_iter_mut()).for_each(|((out, field), work)| {
            let Work { line, turned, blurred } = work;
            for (out, source) in out.chunks_exact_mut(ny * nx).zip(field.chunks_exact(ny * nx)) {
                let transposed = TRANSPOSED;
                T::blur_plane(Inner { axes, nx, transposed, source, line, turned, blurred, out });
            }
        });
    }

    fn outer<const TRANSPOSED: bool>(&self, source: &[T], out: &mut [T]) {
        let [nz, ny, nx] = self.shape;
        assert_eq!(out.len(), nz * ny * nx, "one number per voxel");
        let (slab, plane, axis) = (self.slab(), ny * nx, &self.axes[0]);
        out.par_chunks_mut(slab * plane).enumerate().for_each(|(index, out)| {
            let (first, transposed) = (index * slab, TRANSPOSED);
            T::blur_planes(Outer { axis, plane, transposed, source, first, out });
        });
    }
}

/// The sums, compiled for each type once, in this crate, and for each vector unit.
pub trait Sums: Sized {
    #[doc(hidden)]
    fn blur_plane(plane: Inner<'_, Self>);
    #[doc(hidden)]
    fn blur_planes(planes: Outer<'_, Self>);
}

macro_rules! sums {
    ($($type:ty),*) => {$(
        impl Sums for $type {
            fn blur_plane(plane: Inner<'_, Self>) {
                Arch::new().dispatch(plane);
            }

            fn blur_planes(planes: Outer<'_, Self>) {
                Arch::new().dispatch(planes);
            }
        }
    )*};
}

sums!(f32, f64);

/// A plane, blurred along x and y.
#[derive(Debug)]
pub struct Inner<'a, T> {
    axes: &'a [Axis<T>; 3],
    nx: usize,
    transposed: bool,
    source: &'a [T],
    line: &'a mut [T],
    turned: &'a mut [T],
    blurred: &'a mut [T],
    out: &'a mut [T],
}

impl<T: Float> NullaryFnOnce for Inner<'_, T> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { axes: [_, along_y, along_x], nx, transposed, .. } = self;
        let Self { source, line, turned, blurred, out, .. } = self;
        let (wide, above) = (nx.next_multiple_of(CHUNK), along_y.radius());
        let inside = &mut turned[above * wide..];
        for (row, out) in source.chunks_exact(nx).zip(inside.chunks_exact_mut(wide)) {
            along_x.extend(row, line);
            let steps = Steps { source: &*line, rows: &along_x.steps, stride: 1, offset: 0 };
            steps.sum(&along_x.taps, out);
            if transposed {
                for (i, terms) in &along_x.ends {
                    out[*i] = terms.iter().fold(T::from_f64(0.0), |s, &(o, w)| s + w * row[o]);
                }
            }
        }
        along_y.extend_rows(turned, wide);
        // Rows end to end: short ones take as long to set out as to add.
        for (start, out) in (0..).step_by(STRETCH).zip(blurred.chunks_mut(STRETCH)) {
            let steps =
                Steps { source: &*turned, rows: &along_y.steps, stride: wide, offset: start };
            steps.sum(&along_y.taps, out);
        }
        for (row, out) in blurred.chunks_exact(wide).zip(out.chunks_exact_mut(nx)) {
            out.copy_from_slice(&row[..nx]);
        }
        if transposed {
            for (j, terms) in &along_y.ends {
                let row = |o: usize| &turned[(above + o) * wide..][..nx];
                weighted(terms, row, &mut out[j * nx..][..nx]);
            }
        }
    }
}

/// Planes of a slab, blurred along z.
#[derive(Debug)]
pub struct Outer<'a, T> {
    axis: &'a Axis<T>,
    plane: usize,
    transposed: bool,
    source: &'a [T],
    first: usize,
    out: &'a mut [T],
}

impl<T: Float> NullaryFnOnce for Outer<'_, T> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { axis, plane, transposed, source, first, out } = self;
        for start in (0..plane).step_by(STRETCH) {
            let len = STRETCH.min(plane - start);
            for (k, out) in (first..).zip(out.chunks_exact_mut(plane)) {
                let steps = Steps { source, rows: axis.rows(k), stride: plane, offset: start };
                steps.sum(&axis.taps, &mut out[start..][..len]);
            }
        }
        if transposed {
            let planes = out.len() / plane;
            for (k, terms) in &axis.ends {
                if (first..first + planes).contains(k) {
                    let row = |o: usize| &source[o * plane..][..plane];
                    weighted(terms, row, &mut out[(k - first) * plane..][..plane]);
                }
            }
        }
    }
}

/// `out = sum_o weight_o row(o)`.
fn weighted<'a, T: Float>(terms: &[(usize, T)], row: impl Fn(usize) -> &'a [T], out: &mut [T]) {
    out.fill(T::from_f64(0.0));
    for &(o, weight) in terms {
        for (out, &value) in out.iter_mut().zip(row(o)) {
            *out = *out + weight * value;
        }
    }
}

/// Rows at the steps of a filter: that at step `d` starts at
/// `source[rows[d + radius] * stride + offset]`.
#[derive(Clone, Copy)]
struct Steps<'a, T> {
    source: &'a [T],
    rows: &'a [usize],
    stride: usize,
    offset: usize,
}

impl<'a, T: Float> Steps<'a, T> {
    /// The row of number `d + radius`, of `n` numbers.
    #[inline(always)]
    fn row(&self, index: usize, n: usize) -> &'a [T] {
        &self.source[self.rows[index] * self.stride + self.offset..][..n]
    }

    /// `out = taps[0] row(0) + sum_d taps[d] (row(-d) + row(d))`.
    ///
    /// Only plain loops: the library's `map` and chained iterators over arrays are not always
    /// compiled into their caller, and then not for its vector unit.
    #[inline(always)]
    fn sum(&self, taps: &[T], out: &mut [T]) {
        let (n, radius) = (out.len(), taps.len() - 1);
        let center = self.row(radius, n);
        if radius == 0 {
            for i in 0..n {
                out[i] = taps[0] * center[i];
            }
        }
        for first in (0..radius).step_by(GROUP) {
            let mut pairs = [[center; GROUP]; 2];
            let mut weights = [taps[0]; GROUP];
            for d in 0..GROUP {
                let step = first + d + 1;
                pairs[0][d] = self.row(radius - step, n);
                pairs[1][d] = self.row(radius + step, n);
                weights[d] = taps[step];
            }
            if first == 0 {
                add::<T, true>(taps[0], center, &weights, &pairs, out);
            } else {
                add::<T, false>(taps[0], center, &weights, &pairs, out);
            }
        }
    }
}

/// Adds [`GROUP`] pairs to `out`, which `START` sets to the central term before.
#[inline(always)]
fn add<T: Float, const START: bool>(
    tap: T,
    center: &[T],
    taps: &[T; GROUP],
    pairs: &[[&[T]; GROUP]; 2],
    out: &mut [T],
) {
    let n = out.len();
    let (out, tail) = out.as_chunks_mut::<CHUNK>();
    let count = out.len();
    let center = &center[..n];
    let centers = &center.as_chunks::<CHUNK>().0[..count];
    let [below, above] = pairs;
    let mut low = [centers; GROUP];
    let mut high = [centers; GROUP];
    for d in 0..GROUP {
        low[d] = &below[d].as_chunks::<CHUNK>().0[..count];
        high[d] = &above[d].as_chunks::<CHUNK>().0[..count];
    }
    for j in 0..count {
        let (a, b, c, d) = (&low[0][j], &low[1][j], &low[2][j], &low[3][j]);
        let (e, f, g, h) = (&high[0][j], &high[1][j], &high[2][j], &high[3][j]);
        let mut sums = if START { centers[j] } else { out[j] };
        for i in 0..CHUNK {
            let first = if START { tap * sums[i] } else { sums[i] };
            sums[i] = first
                + ((taps[0] * (a[i] + e[i]) + taps[1] * (b[i] + f[i]))
                    + (taps[2] * (c[i] + g[i]) + taps[3] * (d[i] + h[i])));
        }
        out[j] = sums;
    }
    for (i, out) in (count * CHUNK..n).zip(tail) {
        let first = if START { tap * center[i] } else { *out };
        *out = first
            + ((taps[0] * (below[0][i] + above[0][i]) + taps[1] * (below[1][i] + above[1][i]))
                + (taps[2] * (below[2][i] + above[2][i]) + taps[3] * (below[3][i] + above[3][i])));
    }
}
