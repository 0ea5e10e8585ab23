//! Operators that are diagonal in the Fourier basis of a periodic box, in either width.

use crate::slab::planes_per_slab;
use crate::{Error, Float, Result, diffusion::explicit::Real};
use rayon::prelude::*;
use rustfft::{Fft, FftNum, FftPlanner, num_complex::Complex};
use std::{mem::take, sync::Arc};

/// Columns along z that are transformed together: they fill whole cache lines of the source.
const COLUMNS: usize = 16;

/// Planes that are gathered from the columns together.
const PLANES: usize = 4;

/// Multiplies the Fourier coefficients of a real field by a real, even symbol.
///
/// Two rows share a complex transform along x; planes are transformed along y where they are,
/// and turned for the transform along z. Cost of a real transform and its inverse, memory of
/// two fields and the symbol's half of one. The same bytes result for any number of threads;
/// across processors they may differ, as the transform uses the widest vectors it finds.
#[derive(Clone)]
pub struct Multiplier<T: FftNum> {
    shape: [usize; 3],
    /// Forward and inverse along z, y, x.
    plans: [[Arc<dyn Fft<T>>; 2]; 3],
    /// The symbol over the number of voxels, as `columns` are stored.
    symbol: Vec<T>,
    /// Coefficients along x and y: planes of kx, of ky.
    planes: Vec<Complex<T>>,
    /// The same by columns: of kx, of ky, of kz.
    columns: Vec<Complex<T>>,
    /// Buffers of the tasks, made once.
    buffers: Vec<Buffers<T>>,
}

impl<T: FftNum> std::fmt::Debug for Multiplier<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Multiplier {{ shape: {:?} }}", self.shape)
    }
}

/// Floats whose transforms are compiled in this crate: generic code that made its own plans
/// would be compiled with the whole library of transforms, wherever it is used.
pub trait Transforms: FftNum {
    /// The forward and the inverse transform of `n` numbers, without factors.
    fn plans(n: usize) -> [Arc<dyn Fft<Self>>; 2];
}

macro_rules! transforms {
    ($($type:ty),*) => {$(
        impl Transforms for $type {
            fn plans(n: usize) -> [Arc<dyn Fft<Self>>; 2] {
                let mut planner = FftPlanner::new();
                [planner.plan_fft_forward(n), planner.plan_fft_inverse(n)]
            }
        }
    )*};
}

transforms!(f32, f64);

/// Buffers of one task.
#[derive(Clone)]
struct Buffers<T> {
    line: Vec<Complex<T>>,
    half: Vec<Complex<T>>,
    turned: Vec<Complex<T>>,
    scratch: Vec<Complex<T>>,
}

impl<T: Float + Transforms> Multiplier<T> {
    /// For fields of `shape` `[nz, ny, nx]`; `symbol([kz, ky, kx])` with the wave numbers in
    /// radians per voxel, in [0, pi] along x and [0, 2 pi) along z and y, where it must be
    /// even about pi.
    ///
    /// # Errors
    /// If an axis is empty or the symbol is not finite.
    pub fn new(shape: [usize; 3], symbol: impl Fn([f64; 3]) -> f64 + Sync) -> Result<Self> {
        let [nz, ny, nx] = shape;
        let voxels = nz * ny * nx;
        if voxels == 0 {
            return Err(Error::Invalid(format!("shape {shape:?} has an axis of 0 voxels")));
        }
        let plans = shape.map(T::plans);
        let half = nx / 2 + 1;
        let angle = |m: usize, n: usize| std::f64::consts::TAU * m as f64 / n as f64;
        let at = |i: usize| {
            let k = [angle(i % nz, nz), angle(i / nz % ny, ny), angle(i / (nz * ny), nx)];
            <T as Real>::from_f64(symbol(k) / voxels as f64)
        };
        let symbol: Vec<T> = (0..half * ny * nz).into_par_iter().map(at).collect();
        if let Some(bad) = symbol.iter().find(|v| !Real::to_f64(**v).is_finite()) {
            return Err(Error::out_of_range("symbol", Real::to_f64(*bad), "(-inf, inf)"));
        }
        let zeros = vec![Complex::new(T::zero(), T::zero()); half * ny * nz];
        let (planes, columns, buffers) = (zeros.clone(), zeros, Vec::new());
        Ok(Self { shape, plans, symbol, planes, columns, buffers })
    }

    fn buffers(&self) -> Buffers<T> {
        let [_, ny, nx] = self.shape;
        let half = nx / 2 + 1;
        let scratch = self.plans.iter().flatten().map(|p| p.get_inplace_scratch_len()).max();
        let zeros = |n: usize| vec![Complex::new(T::zero(), T::zero()); n];
        Buffers {
            line: zeros(nx),
            half: zeros(half * ny),
            turned: zeros(PLANES * half * ny),
            scratch: zeros(scratch.unwrap_or(0)),
        }
    }

    /// The operator applied to `field`, into `out`.
    ///
    /// # Panics
    /// If a slice has not one number per voxel.
    pub fn apply(&mut self, field: &[T], out: &mut [T]) {
        let [nz, ny, nx] = self.shape;
        assert!(field.len() == nz * ny * nx && out.len() == field.len(), "one number per voxel");
        let (mut planes, mut columns) = (take(&mut self.planes), take(&mut self.columns));
        let mut buffers = take(&mut self.buffers);
        let (plane, size) = (ny * nx, (nx / 2 + 1) * ny);
        // Whole groups of planes to a task, and at least as many tasks as are needed for columns.
        let slab = planes_per_slab(nz, field.len()).next_multiple_of(PLANES);
        let tasks = nz.div_ceil(slab);
        let block = size.div_ceil(tasks).next_multiple_of(COLUMNS);
        buffers.resize_with(tasks, || self.buffers());
        let (this, pool) = (&*self, &mut buffers);
        let forward = planes.par_chunks_mut(slab * size).zip(field.par_chunks(slab * plane));
        forward.zip(pool.par_iter_mut()).for_each(|((planes, field), b)| {
            for (out, field) in planes.chunks_exact_mut(size).zip(field.chunks_exact(plane)) {
                this.plane(field, out, b);
            }
        });
        let along = columns.par_chunks_mut(block * nz).zip(this.symbol.par_chunks(block * nz));
        along.zip(pool.par_iter_mut()).enumerate().for_each(|(task, ((columns, symbol), b))| {
            let groups = columns.chunks_mut(COLUMNS * nz).zip(symbol.chunks(COLUMNS * nz));
            for (group, (columns, symbol)) in groups.enumerate() {
                this.column(&planes[task * block + group * COLUMNS..], columns, symbol, b);
            }
        });
        let back = out.par_chunks_mut(slab * plane).zip(pool.par_iter_mut());
        back.enumerate().for_each(|(task, (out, b))| {
            for (group, out) in out.chunks_mut(PLANES * plane).enumerate() {
                this.back(&columns[task * slab + group * PLANES..], out, b);
            }
        });
        (self.planes, self.columns, self.buffers) = (planes, columns, buffers);
    }

    /// Transforms a plane along x and y.
    fn plane(&self, field: &[T], plane: &mut [Complex<T>], b: &mut Buffers<T>) {
        let [_, ny, nx] = self.shape;
        let half = nx / 2 + 1;
        for (pair, out) in field.chunks(2 * nx).zip(b.half.chunks_mut(2 * half)) {
            let (x, y) = pair.split_at(nx);
            for (i, (line, &x)) in b.line.iter_mut().zip(x).enumerate() {
                *line = Complex::new(x, y.get(i).copied().unwrap_or(T::zero()));
            }
            self.plans[2][0].process_with_scratch(&mut b.line, &mut b.scratch);
            let two = T::one() + T::one();
            let (first, second) = out.split_at_mut(half);
            for (m, first) in first.iter_mut().enumerate() {
                let (p, q) = (b.line[m], b.line[(nx - m) % nx].conj());
                *first = (p + q) / two;
                if let Some(second) = second.get_mut(m) {
                    let d = (p - q) / two;
                    *second = Complex::new(d.im, -d.re);
                }
            }
        }
        turn(&b.half, half, plane);
        debug_assert_eq!(plane.len(), half * ny);
        self.plans[1][0].process_with_scratch(plane, &mut b.scratch);
    }

    /// Gathers columns, multiplies by the symbol in the basis of z, and goes back along z.
    fn column(
        &self,
        planes: &[Complex<T>],
        columns: &mut [Complex<T>],
        symbol: &[T],
        b: &mut Buffers<T>,
    ) {
        let [nz, ny, nx] = self.shape;
        let size = (nx / 2 + 1) * ny;
        let width = columns.len() / nz;
        for k in 0..nz {
            let source = &planes[k * size..][..width];
            for (column, &value) in columns.chunks_exact_mut(nz).zip(source) {
                column[k] = value;
            }
        }
        self.plans[0][0].process_with_scratch(columns, &mut b.scratch);
        for (value, &factor) in columns.iter_mut().zip(symbol) {
            *value = value.scale(factor);
        }
        self.plans[0][1].process_with_scratch(columns, &mut b.scratch);
    }

    /// Planes from the columns, which start at the first plane.
    fn back(&self, columns: &[Complex<T>], out: &mut [T], b: &mut Buffers<T>) {
        let [nz, ny, nx] = self.shape;
        let half = nx / 2 + 1;
        let size = half * ny;
        let count = out.len() / (ny * nx);
        for (c, column) in columns.chunks(nz).enumerate().take(size) {
            for (k, &value) in column[..count].iter().enumerate() {
                b.turned[k * size + c] = value;
            }
        }
        for (plane, out) in b.turned.chunks_exact_mut(size).zip(out.chunks_exact_mut(ny * nx)) {
            self.plans[1][1].process_with_scratch(plane, &mut b.scratch);
            turn(plane, ny, &mut b.half);
            for (pair, out) in b.half.chunks(2 * half).zip(out.chunks_mut(2 * nx)) {
                let (first, second) = pair.split_at(half);
                let zero = Complex::new(T::zero(), T::zero());
                for (m, &p) in first.iter().enumerate() {
                    let q = second.get(m).copied().unwrap_or(zero);
                    if m > 0 {
                        b.line[nx - m] = Complex::new(p.re + q.im, q.re - p.im);
                    }
                    b.line[m] = Complex::new(p.re - q.im, p.im + q.re);
                }
                self.plans[2][1].process_with_scratch(&mut b.line, &mut b.scratch);
                let (x, y) = out.split_at_mut(nx);
                for (x, value) in x.iter_mut().zip(&b.line) {
                    *x = value.re;
                }
                for (y, value) in y.iter_mut().zip(&b.line) {
                    *y = value.im;
                }
            }
        }
    }
}

/// Turns rows of `width` into columns.
fn turn<T: Copy>(source: &[T], width: usize, out: &mut [T]) {
    /// Rows whose parts of a column are written together.
    const ROWS: usize = 8;
    let height = source.len() / width;
    for (block, rows) in source.chunks(ROWS * width).enumerate() {
        let count = rows.len() / width;
        for (c, column) in out.chunks_exact_mut(height).enumerate().take(width) {
            for (r, value) in column[block * ROWS..][..count].iter_mut().enumerate() {
                *value = rows[r * width + c];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Multiplier;
    use crate::random::{stream, uniform};

    /// The symbol of a shift's even part and of the compact Laplacian, on odd and even axes.
    #[test]
    fn laplacian_of_noise() {
        for shape in [[4, 6, 8], [5, 7, 9], [6, 5, 10], [9, 8, 7], [1, 4, 5]] {
            let [nz, ny, nx] = shape;
            let mut stream = stream(3, "multiplier", 0);
            let n = nz * ny * nx;
            let u: Vec<f64> = (0..n).map(|_| uniform(&mut stream) - 0.5).collect();
            let symbol = |k: [f64; 3]| k.iter().map(|k| 2.0 * k.cos() - 2.0).sum::<f64>();
            let mut laplacian = Multiplier::<f64>::new(shape, symbol).unwrap();
            let mut out = vec![0.0; n];
            laplacian.apply(&u, &mut out);
            let mut single = Multiplier::<f32>::new(shape, symbol).unwrap();
            let mut out32 = vec![0.0_f32; n];
            single.apply(&u.iter().map(|&v| v as f32).collect::<Vec<_>>(), &mut out32);
            for i in 0..n {
                let (z, y, x) = (i / (ny * nx), i / nx % ny, i % nx);
                let at = |z: usize, y: usize, x: usize| u[(z % nz * ny + y % ny) * nx + x % nx];
                let sum = at(z + 1, y, x)
                    + at(z + nz - 1, y, x)
                    + at(z, y + 1, x)
                    + at(z, y + ny - 1, x)
                    + at(z, y, x + 1)
                    + at(z, y, x + nx - 1);
                assert!((out[i] - (sum - 6.0 * u[i])).abs() < 1e-14, "{shape:?} {i}");
                assert!((f64::from(out32[i]) - out[i]).abs() < 3e-6, "{shape:?} {i}");
            }
        }
    }
}
