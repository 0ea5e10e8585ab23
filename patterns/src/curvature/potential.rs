//! Phase fields of a given mass from vector potentials: `u = k * (div A + m0)`.

use super::energy::Spatial;
use pulp::{Arch, NullaryFnOnce};
use rayon::prelude::*;
use solvers::blur::{Blur, BlurEdges};
use solvers::{Error, Float, Result};

/// The map from A to u and its transpose, on a periodic box.
///
/// The divergence is of central differences, k a Gaussian of `sigma` voxels. The mean of u is
/// that of m0, whatever A is. Song 2021, section 4.1.
#[derive(Clone, Debug)]
pub struct Potential<T> {
    shape: [usize; 3],
    /// 1 / (2 dx).
    half: T,
    m0: Mass<T>,
    blur: Blur<T>,
}

#[derive(Clone, Debug)]
enum Mass<T> {
    Uniform(T),
    Map(Vec<T>),
}

impl<T: Float> Potential<T> {
    /// For fields of `shape` `[nz, ny, nx]` and voxels `dx` apart; `sigma` in voxels, `m0` in
    /// (-1, 1).
    ///
    /// # Errors
    /// If a number is out of its range or the map has another shape.
    pub fn new(shape: [usize; 3], dx: f64, sigma: f64, m0: &Spatial) -> Result<Self> {
        if !(dx > 0.0 && dx.is_finite()) {
            return Err(Error::out_of_range("dx", dx, "(0, inf)"));
        }
        let check = |m: f64| match m.abs() < 1.0 {
            true => Ok(T::from_f64(m)),
            false => Err(Error::out_of_range("m0", m, "(-1, 1)")),
        };
        let m0 = match m0 {
            Spatial::Uniform(m) => Mass::Uniform(check(*m)?),
            Spatial::Map(values) if values.len() == shape.iter().product() => {
                Mass::Map(values.iter().map(|&m| check(m)).collect::<Result<_>>()?)
            }
            Spatial::Map(values) => {
                return Err(Error::Shape {
                    name: "m0".into(),
                    actual: vec![values.len()],
                    expected: shape.to_vec(),
                });
            }
        };
        let blur = Blur::new(shape, sigma, BlurEdges::Periodic)?;
        Ok(Self { shape, half: T::from_f64(0.5 / dx), m0, blur })
    }

    /// Factor of the differences of k * dF/du in dG/dA: -1 / (2 dx).
    pub(super) fn factor(&self) -> T {
        -self.half
    }

    /// `u = k * (div A + m0)`; components of A along z, y, x. `between` is overwritten.
    ///
    /// # Panics
    /// If a slice has not one number per voxel.
    pub fn phase(&mut self, a: [&[T]; 3], between: &mut [T], u: &mut [T]) {
        self.divergence(a, u);
        self.blur_in_place(u, between);
    }

    /// `div A + m0`; components of A along z, y, x.
    ///
    /// # Panics
    /// If a slice has not one number per voxel.
    pub fn divergence(&self, a: [&[T]; 3], out: &mut [T]) {
        let [nz, ny, nx] = self.shape;
        assert!(a.iter().all(|a| a.len() == nz * ny * nx), "one number per voxel");
        assert!(out.len() == nz * ny * nx, "one number per voxel");
        out.par_chunks_mut(ny * nx).enumerate().for_each(|(k, out)| {
            Arch::new().dispatch(Plane { potential: self, a, k, out });
        });
    }

    /// `u = k * D`. `between` is overwritten.
    ///
    /// # Panics
    /// If a slice has not one number per voxel.
    pub(super) fn blur(&mut self, divergence: &[T], between: &mut [T], u: &mut [T]) {
        self.blur.apply(divergence, between, u);
    }

    /// `k * field` in place of `field`; k is its own transpose, so that this is for gradients with
    /// respect to u too. `between` is overwritten.
    ///
    /// # Panics
    /// If a slice has not one number per voxel.
    pub fn blur_in_place(&mut self, field: &mut [T], between: &mut [T]) {
        self.blur.transpose(field, between);
    }

    /// `dG/dA = -grad(k * dF/du)` from `k * dF/du`.
    ///
    /// # Panics
    /// If a slice has not one number per voxel.
    pub fn gradient(&self, blurred: &[T], out: [&mut [T]; 3]) {
        let factor = self.factor();
        for (axis, out) in out.into_iter().enumerate() {
            assert!(out.len() == blurred.len(), "one number per voxel");
            let n = self.shape[axis];
            let stride: usize = self.shape[axis + 1..].iter().product();
            for (i, out) in out.iter_mut().enumerate() {
                let at = i / stride % n;
                let first = i - at * stride;
                let next = first + (at + 1) % n * stride;
                let last = first + (at + n - 1) % n * stride;
                *out = factor * (blurred[next] - blurred[last]);
            }
        }
    }
}

/// A plane of `div A + m0`.
struct Plane<'a, T> {
    potential: &'a Potential<T>,
    a: [&'a [T]; 3],
    k: usize,
    out: &'a mut [T],
}

impl<T: Float> NullaryFnOnce for Plane<'_, T> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { potential: Potential { shape: [nz, ny, nx], half, m0, .. }, a, k, out } = self;
        let (nz, ny, nx) = (*nz, *ny, *nx);
        let [az, ay, ax] = a;
        for (j, out) in out.chunks_exact_mut(nx).enumerate() {
            let line = |k: usize, j: usize| (k * ny + j) * nx;
            let row = |k: usize, j: usize| line(k, j)..line(k, j) + nx;
            let near = [
                &az[row((k + 1) % nz, j)],
                &az[row((k + nz - 1) % nz, j)],
                &ay[row(k, (j + 1) % ny)],
                &ay[row(k, (j + ny - 1) % ny)],
                &ax[row(k, j)],
            ];
            match m0 {
                Mass::Uniform(m0) => row_of(*half, near, |_| *m0, out),
                Mass::Map(m0) => {
                    let m0 = &m0[row(k, j)];
                    row_of(*half, near, |i| m0[i], out);
                }
            }
        }
    }
}

/// `half ((above - below) + (south - north)) + m0 + half (east - west)`, the row periodic.
#[inline(always)]
fn row_of<T: Float>(half: T, near: [&[T]; 5], m0: impl Fn(usize) -> T, out: &mut [T]) {
    let n = out.len();
    let [above, below, south, north, along] = near.map(|row| &row[..n]);
    let across = |i: usize| half * ((above[i] - below[i]) + (south[i] - north[i])) + m0(i);
    for i in 1..n - 1 {
        out[i] = across(i) + half * (along[i + 1] - along[i - 1]);
    }
    out[0] = across(0) + half * (along[1] - along[n - 1]);
    out[n - 1] = across(n - 1) + half * (along[0] - along[n - 2]);
}
