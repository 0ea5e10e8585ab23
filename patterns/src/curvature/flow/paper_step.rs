//! Adam's step on A, of which only the divergence is kept.
//!
//! u depends on A through D = div A + m0 alone, and dG/dA is minus the gradient of b = k * dF/du.
//! Adam's mean of it is then minus the gradient of M, the running mean of b. So D, M and the mean
//! squared gradient, five numbers at a voxel, do for A and its two means, which are nine.

use crate::curvature::energy::Scalar;
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;
use solvers::Aligned;
use solvers::optimize::Adam;
use solvers::slab::planes_per_slab;

/// Numbers that are computed together.
const CHUNK: usize = 16;

/// What Adam keeps from step to step, and the buffers of its step.
#[derive(Clone, Debug)]
pub(super) struct Variables<T> {
    shape: [usize; 3],
    /// -1 / (2 dx).
    factor: T,
    /// D, M, and the mean squared gradient along z, y, x.
    pub(super) fields: [Aligned<T>; 5],
    norms: Vec<f64>,
    works: Vec<Work<T>>,
}

/// Buffers of a slab of planes, each of a plane.
#[derive(Clone, Debug)]
struct Work<T> {
    /// M on the two planes before the slab and the two behind it.
    means: [Aligned<T>; 4],
    /// The mean squared gradient along z on the plane before the slab and the one behind it.
    squares: [Aligned<T>; 2],
    /// Steps along z in turn, then those along y.
    steps: [Aligned<T>; 4],
    /// A row of M, of b and of the steps along x, with what stands beyond its ends.
    rows: [Aligned<T>; 3],
}

impl<T: Scalar> Variables<T> {
    /// At rest at the divergence D.
    pub(super) fn new(shape: [usize; 3], factor: T, divergence: Aligned<T>) -> Self {
        let zeros = || Aligned::new(divergence.len(), T::from_f64(0.0));
        let [mean, z, y, x] = [zeros(), zeros(), zeros(), zeros()];
        let fields = [divergence, mean, z, y, x];
        Self { shape, factor, fields, norms: vec![0.0; shape[0]], works: Vec::new() }
    }

    /// A step, given b; returns the norm of the gradient with respect to A.
    pub(super) fn step(&mut self, adam: Adam<T>, blurred: &[T]) -> f64 {
        let [nz, ny, nx] = self.shape;
        let planes = planes_per_slab(nz, blurred.len());
        self.copy_neighbours(planes);
        let Self { shape, factor, fields, norms, works } = self;
        let (shape, size) = (*shape, planes * ny * nx);
        let kernel = Kernel { adam, factor: *factor };
        let [d, m, z, y, x] = fields.each_mut().map(|field| field.par_chunks_mut(size));
        let parts = d.zip(m).zip(z).zip(y).zip(x);
        let parts = parts.zip(norms.par_chunks_mut(planes)).zip(works);
        parts.enumerate().for_each(|(index, ((((((d, m), z), y), x), norms), work))| {
            let fields = [d, m, z, y, x];
            let first = index * planes;
            let slab = Slab { shape, kernel, blurred, first, fields, norms, work };
            Arch::new().dispatch(slab);
        });
        self.norms.iter().sum::<f64>().sqrt()
    }

    /// Keeps aside for each slab what others are about to change.
    fn copy_neighbours(&mut self, planes: usize) {
        let [nz, ny, nx] = self.shape;
        let (size, slabs) = (ny * nx, nz.div_ceil(planes));
        if self.works.len() != slabs {
            let plane = |_| Aligned::new(size, T::from_f64(0.0));
            let row = |_| Aligned::new(nx + 2, T::from_f64(0.0));
            let work = |_| Work {
                means: [0; 4].map(plane),
                squares: [0; 2].map(plane),
                steps: [0; 4].map(plane),
                rows: [0; 3].map(row),
            };
            self.works = (0..slabs).map(work).collect();
        }
        let [_, mean, square, ..] = &self.fields;
        self.works.par_iter_mut().enumerate().for_each(|(index, work)| {
            let first = index * planes;
            let behind = (first + planes).min(nz);
            // Numbered around the box: before the first planes are its last.
            let plane = |k: usize| k % nz * size..k % nz * size + size;
            let (before, last) = (first + 2 * nz - 2, first + nz - 1);
            for (out, k) in work.means.iter_mut().zip([before, last, behind, behind + 1]) {
                out.copy_from_slice(&mean[plane(k)]);
            }
            for (out, k) in work.squares.iter_mut().zip([last, behind]) {
                out.copy_from_slice(&square[plane(k)]);
            }
        });
    }
}

/// The step on a slab of planes.
struct Slab<'a, T> {
    shape: [usize; 3],
    kernel: Kernel<T>,
    blurred: &'a [T],
    first: usize,
    fields: [&'a mut [T]; 5],
    norms: &'a mut [f64],
    work: &'a mut Work<T>,
}

impl<T: Scalar> NullaryFnOnce for Slab<'_, T> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { shape: [nz, ny, nx], kernel, blurred, first, norms, work, .. } = self;
        let [d, m, vz, vy, vx] = self.fields;
        let Work { means, squares, steps, rows } = work;
        let [steps_z @ .., steps_y] = steps;
        let (size, count) = (ny * nx, norms.len());
        // Planes are numbered from two before the slab, which starts with number 2.
        let source = |k: usize| &blurred[(first + 2 * nz + k - 2) % nz * size..][..size];
        for (mean, k) in means.iter_mut().zip([0, 1, count + 2, count + 3]) {
            kernel.follow(source(k), mean);
        }
        for k in 1..count + 3 {
            if (1..=count).contains(&k) {
                kernel.follow(source(k + 1), &mut m[(k - 1) * size..][..size]);
            }
            let mean = |k: usize| match k {
                0 | 1 => &means[k][..],
                k if k < count + 2 => &m[(k - 2) * size..][..size],
                k => &means[k - count][..],
            };
            let own = (2..count + 2).contains(&k).then(|| (k - 2) * size..(k - 1) * size);
            let near = [mean(k + 1), mean(k - 1), source(k + 1), source(k - 1)];
            let square = match &own {
                Some(own) => &mut vz[own.clone()],
                None => &mut squares[usize::from(k > 1)][..],
            };
            let mut norm = kernel.steps(near, square, &mut steps_z[k % 3]);
            if let Some(own) = own {
                let near = [mean(k), source(k)];
                norm += kernel.along_y(nx, near, &mut vy[own.clone()], steps_y);
                let (squares, d) = (&mut vx[own.clone()], &mut d[own]);
                norms[k - 2] = norm + kernel.along_x(nx, near, (steps_y, rows), squares, d);
            }
            if k > 2 {
                let near = [&steps_z[k % 3][..], &steps_z[(k - 2) % 3]];
                kernel.move_along_z(near, &mut d[(k - 3) * size..][..size]);
            }
        }
    }
}

/// Adam's arithmetic, compiled into each loop.
#[derive(Clone, Copy)]
struct Kernel<T> {
    adam: Adam<T>,
    /// -1 / (2 dx).
    factor: T,
}

impl<T: Scalar> Kernel<T> {
    /// The mean follows.
    #[inline(always)]
    fn follow(&self, values: &[T], mean: &mut [T]) {
        for (mean, &value) in mean.iter_mut().zip(values) {
            *mean = self.adam.mean(*mean, value);
        }
    }

    /// Steps of variables whose mean gradients and gradients are `factor` times the differences
    /// of the first two and of the last two slices; returns the sum of the squared gradients.
    #[inline(always)]
    fn steps(&self, near: [&[T]; 4], squares: &mut [T], out: &mut [T]) -> f64 {
        let zero = T::from_f64(0.0);
        let n = squares.len();
        let [mp, mm, bp, bm] = [&near[0][..n], &near[1][..n], &near[2][..n], &near[3][..n]];
        let (squares, last_squares) = squares.as_chunks_mut::<CHUNK>();
        let (out, last_out) = out[..n].as_chunks_mut::<CHUNK>();
        let mut sums = [zero; CHUNK];
        {
            let near = [mp.as_chunks().0, mm.as_chunks().0, bp.as_chunks().0, bm.as_chunks().0];
            for j in 0..squares.len() {
                let near = [&near[0][j], &near[1][j], &near[2][j], &near[3][j]];
                (squares[j], out[j]) = self.chunk(near, squares[j], &mut sums);
            }
        }
        // The end of a row as a whole vector: single numbers would take as long as the rest.
        let rest = last_squares.len();
        if rest > 0 {
            let (mut near, mut square) = ([[zero; CHUNK]; 4], [zero; CHUNK]);
            for (near, values) in near.iter_mut().zip([mp, mm, bp, bm]) {
                near[..rest].copy_from_slice(&values[n - rest..]);
            }
            square[..rest].copy_from_slice(last_squares);
            let (square, step) =
                self.chunk([&near[0], &near[1], &near[2], &near[3]], square, &mut sums);
            last_squares.copy_from_slice(&square[..rest]);
            last_out.copy_from_slice(&step[..rest]);
        }
        let mut sum = 0.0;
        for square in sums {
            sum += square.to_f64();
        }
        sum
    }

    /// New mean squared gradients, and the steps.
    #[inline(always)]
    fn chunk(
        &self,
        [mp, mm, bp, bm]: [&[T; CHUNK]; 4],
        mut square: [T; CHUNK],
        sums: &mut [T; CHUNK],
    ) -> ([T; CHUNK], [T; CHUNK]) {
        let mut step = [T::from_f64(0.0); CHUNK];
        for i in 0..CHUNK {
            let gradient = self.factor * (bp[i] - bm[i]);
            sums[i] = sums[i] + gradient * gradient;
            square[i] = self.adam.square(square[i], gradient);
            step[i] = self.adam.step(self.factor * (mp[i] - mm[i]), square[i]);
        }
        (square, step)
    }

    /// What the steps along z change of a plane of D, given those above and below.
    #[inline(always)]
    fn move_along_z(&self, [above, below]: [&[T]; 2], d: &mut [T]) {
        let n = d.len();
        let (above, below) = (&above[..n], &below[..n]);
        for i in 0..n {
            d[i] = d[i] + self.factor * (above[i] - below[i]);
        }
    }

    /// Those along y of a plane.
    #[inline(always)]
    fn along_y(&self, nx: usize, near: [&[T]; 2], squares: &mut [T], out: &mut [T]) -> f64 {
        let [m, b] = near;
        let size = squares.len();
        let last = size - nx;
        // Where a stretch of rows starts and ends, and where the next rows and those before do.
        let stretches = [[0, nx, nx, last], [nx, last, 2 * nx, 0], [last, size, 0, last - nx]];
        let mut sum = 0.0;
        for [start, end, next, before] in stretches {
            let n = end - start;
            let near = [&m[next..][..n], &m[before..][..n], &b[next..][..n], &b[before..][..n]];
            sum += self.steps(near, &mut squares[start..end], &mut out[start..end]);
        }
        sum
    }

    /// Those along x, row by row, and what they and the ones along y change of D.
    #[inline(always)]
    fn along_x(
        &self,
        nx: usize,
        near: [&[T]; 2],
        (steps_y, rows): (&[T], &mut [Aligned<T>; 3]),
        squares: &mut [T],
        d: &mut [T],
    ) -> f64 {
        let size = squares.len();
        let [m, b, steps_x] = rows;
        let mut sum = 0.0;
        for first in (0..size).step_by(nx) {
            let own = first..first + nx;
            for (row, field) in [(&mut *m, near[0]), (&mut *b, near[1])] {
                row[1..=nx].copy_from_slice(&field[own.clone()]);
                wrap(row);
            }
            let near = [&m[2..], &m[..nx], &b[2..], &b[..nx]];
            sum += self.steps(near, &mut squares[own.clone()], &mut steps_x[1..=nx]);
            wrap(steps_x);
            let next = if first + nx < size { first + nx } else { 0 };
            let before = if first > 0 { first - nx } else { size - nx };
            let (north, south) = (&steps_y[before..][..nx], &steps_y[next..][..nx]);
            let (west, east) = (&steps_x[..nx], &steps_x[2..][..nx]);
            let d = &mut d[own];
            for i in 0..nx {
                d[i] = d[i] + self.factor * ((south[i] - north[i]) + (east[i] - west[i]));
            }
        }
        sum
    }
}

/// What stands beyond the ends of a row.
#[inline(always)]
fn wrap<T: Copy>(row: &mut [T]) {
    let n = row.len() - 2;
    row[0] = row[n];
    row[n + 1] = row[1];
}
