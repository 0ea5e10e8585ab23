//! Kernels made of a per-cell rate formula, parameters and a stencil.

use super::{Kernel, Real, Rows};
use crate::diffusion::Reaction;
use crate::{Error, Field, Grid, Result};
use serde::{Deserialize, Serialize};
use std::marker::PhantomData;

/// The reaction of one cell: `S` species, `P` parameters.
pub trait Cell<const S: usize, const P: usize>: Send + Sync + 'static {
    /// Rates `f_s(u)` at parameters `p`. Mark it `#[inline(always)]`.
    fn rates<T: Real>(u: [T; S], p: [T; P]) -> [T; S];
}

/// A parameter: one number, or a value at each node.
#[derive(Clone, Debug, PartialEq)]
pub enum Parameter {
    /// The same everywhere.
    Uniform(f64),
    /// A value at each node.
    Map(Field),
}

impl Parameter {
    /// Value at a node.
    pub fn at(&self, node: usize) -> f64 {
        match self {
            Self::Uniform(value) => *value,
            Self::Map(field) => field.as_slice()[node],
        }
    }
}

/// Differences that stand for the Laplacian (spacing h).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stencil {
    /// 2D (and 1D): `(4 (W + E + N + S) + corners - 20 C) / (6 h^2)`; isotropic to
    /// fourth order, largest symbol 16/3 h^-2.
    NinePoint,
    /// Second differences along each axis: 3, 5 or 7 points, largest symbol `4 dim h^-2`.
    Axes,
}

impl Stencil {
    /// Largest value of the symbol of `-laplacian` on `grid` (1/length^2).
    pub fn max_symbol(self, grid: Grid) -> f64 {
        let unit = match self {
            // On one axis the nine points are the three of `Axes`; on two the symbol
            // is largest at the checkerboard, (4 * 4 - 4 + 20) / 6.
            Self::NinePoint if grid.shape()[1] > 1 => 16.0 / 3.0,
            _ => 4.0 * grid.shape().iter().filter(|&&n| n > 1).count() as f64,
        };
        unit / grid.spacing().powi(2)
    }

    /// What the sum of [`Stencil::sum_row`] is to be multiplied with for a Laplacian (1/length^2).
    pub fn scale(self, grid: Grid) -> f64 {
        let unit = if self == Self::NinePoint { 6.0 } else { 1.0 };
        1.0 / (unit * grid.spacing().powi(2))
    }

    /// Integer-weighted sum of the stencil over a row of one species, one value per cell.
    #[inline(always)]
    pub fn sum_row<T: Real>(
        self,
        volumetric: bool,
        species: usize,
        rows: &Rows<'_, T>,
        out: &mut [T],
    ) {
        let cells = rows.cells;
        let all = [rows.north, rows.center, rows.south, rows.front, rows.back];
        let [n, c, s, f, b] = all.map(|row| &row[species * rows.stride..][..cells + 2]);
        let out = &mut out[..cells];
        match (volumetric, self) {
            (true, _) => (0..cells).for_each(|i| out[i] = seven_point([n, c, s, f, b], i)),
            (_, Self::NinePoint) => (0..cells).for_each(|i| out[i] = nine_point(n, c, s, i)),
            (_, Self::Axes) => (0..cells).for_each(|i| out[i] = five_point(n, c, s, i)),
        }
    }
}

/// Forward Euler of a [`Cell`]: `u += dt (f(u, p) + D lap u)`, then `max(u, 0)` if asked.
///
/// The clamp also takes numbers too small for full precision to 0: arithmetic on
/// them is ten times slower, and a species that dies out passes through them.
#[derive(Clone, Debug)]
pub struct CellKernel<T, C, const S: usize, const P: usize> {
    stencil: Stencil,
    volumetric: bool,
    /// What is less becomes 0.
    floor: T,
    dt: T,
    /// Coefficient of the stencil's integer-weighted sum.
    weight: [T; S],
    /// One value per node, or one row of equal values.
    maps: [Vec<T>; P],
    mapped: [bool; P],
    cell: PhantomData<fn() -> C>,
}

impl<T: Real, C: Cell<S, P>, const S: usize, const P: usize> CellKernel<T, C, S, P> {
    /// `diffusion` in length^2/time, `dt` in time; `clamp` keeps concentrations from
    /// becoming negative.
    ///
    /// # Errors
    /// If a map has another shape than `grid`, or the nine-point stencil is asked for in 3D.
    pub fn new(
        grid: Grid,
        stencil: Stencil,
        dt: f64,
        diffusion: [f64; S],
        parameters: &[Parameter; P],
        clamp: bool,
    ) -> Result<Self> {
        let volumetric = grid.shape()[0] > 1;
        if volumetric && stencil == Stencil::NinePoint {
            return Err(Error::Invalid("the nine-point stencil has no 3D form, use axes".into()));
        }
        let mut kernel = Self {
            stencil,
            volumetric,
            floor: if clamp { T::SMALLEST } else { T::from_f64(f64::NEG_INFINITY) },
            dt: T::from_f64(dt),
            weight: [T::from_f64(0.0); S],
            maps: std::array::from_fn(|_| Vec::new()),
            mapped: [false; P],
            cell: PhantomData,
        };
        kernel.set_diffusion(grid, diffusion);
        for (index, parameter) in parameters.iter().enumerate() {
            kernel.set_parameter(grid, index, parameter)?;
        }
        Ok(kernel)
    }

    /// Changes the diffusion coefficients (length^2/time).
    pub fn set_diffusion(&mut self, grid: Grid, diffusion: [f64; S]) {
        let scale = self.dt.to_f64() * self.stencil.scale(grid);
        self.weight = diffusion.map(|d| T::from_f64(d * scale));
    }

    /// Changes parameter `index`.
    ///
    /// # Errors
    /// If a map has another shape than `grid`.
    pub fn set_parameter(&mut self, grid: Grid, index: usize, parameter: &Parameter) -> Result<()> {
        match parameter {
            Parameter::Uniform(value) => {
                self.maps[index] = vec![T::from_f64(*value); grid.shape()[2]];
                self.mapped[index] = false;
            }
            Parameter::Map(field) => {
                field.check_shape("parameter map", grid)?;
                self.maps[index] = field.as_slice().iter().map(|&v| T::from_f64(v)).collect();
                self.mapped[index] = true;
            }
        }
        Ok(())
    }

    /// A row of all species: `max(u + dt f(u, p) + weight sum, 0)`.
    ///
    /// One plain loop over slices of known length, the neighbours of cell i at i,
    /// i + 1 and i + 2: it becomes vectors of the widest unit without bounds checks.
    /// Parameters are always read from rows, and the clamp is a number: each variant
    /// would be compiled for every kinetics, precision and instruction set.
    #[inline(always)]
    fn run<const POINTS: u8>(&self, first: usize, rows: &Rows<'_, T>, out: &mut [T]) {
        let (n, zero) = (rows.cells, T::from_f64(0.0));
        let [north, center, south, front, back] = [
            species::<T, S>(rows.north, rows),
            species::<T, S>(rows.center, rows),
            species::<T, S>(rows.south, rows),
            species::<T, S>(rows.front, rows),
            species::<T, S>(rows.back, rows),
        ];
        let mut maps = [&rows.center[..n]; P];
        #[allow(clippy::needless_range_loop, reason = "one index serves several arrays")]
        for p in 0..P {
            maps[p] = &self.maps[p][if self.mapped[p] { first } else { 0 }..][..n];
        }
        let mut rest = out;
        let next: [&mut [T]; S] = std::array::from_fn(|_| {
            let row;
            (row, rest) = std::mem::take(&mut rest).split_at_mut(rows.stride);
            &mut row[1..][..n]
        });
        for i in 0..n {
            let (mut u, mut p) = ([zero; S], [zero; P]);
            for s in 0..S {
                u[s] = center[s][i + 1];
            }
            for k in 0..P {
                p[k] = maps[k][i];
            }
            let rates = C::rates(u, p);
            for s in 0..S {
                let (n, c, b) = (north[s], center[s], south[s]);
                let sum = match POINTS {
                    9 => nine_point(n, c, b, i),
                    5 => five_point(n, c, b, i),
                    _ => seven_point([n, c, b, front[s], back[s]], i),
                };
                let value = (u[s] + self.dt * rates[s]) + self.weight[s] * sum;
                next[s][i] = if value < self.floor { zero } else { value };
            }
        }
    }
}

/// A row's species, each with its ghost cells.
#[inline(always)]
fn species<'a, T: Real, const S: usize>(row: &'a [T], rows: &Rows<'_, T>) -> [&'a [T]; S] {
    let mut all = [row; S];
    for (s, one) in all.iter_mut().enumerate() {
        *one = &row[s * rows.stride..][..rows.cells + 2];
    }
    all
}

// The sums below have the symmetries of the square to the last bit: opposite
// neighbours are added first, so that mirrored states have mirrored successors.

#[inline(always)]
fn five_point<T: Real>(n: &[T], c: &[T], s: &[T], i: usize) -> T {
    (c[i] + c[i + 2]) + (n[i + 1] + s[i + 1]) - T::from_f64(4.0) * c[i + 1]
}

#[inline(always)]
fn nine_point<T: Real>(n: &[T], c: &[T], s: &[T], i: usize) -> T {
    let edges = (c[i] + c[i + 2]) + (n[i + 1] + s[i + 1]);
    let corners = (n[i] + s[i + 2]) + (n[i + 2] + s[i]);
    (T::from_f64(4.0) * edges + corners) - T::from_f64(20.0) * c[i + 1]
}

#[inline(always)]
fn seven_point<T: Real>([n, c, s, f, b]: [&[T]; 5], i: usize) -> T {
    let edges = ((c[i] + c[i + 2]) + (n[i + 1] + s[i + 1])) + (f[i + 1] + b[i + 1]);
    edges - T::from_f64(6.0) * c[i + 1]
}

impl<T: Real, C: Cell<S, P>, const S: usize, const P: usize> Kernel<T> for CellKernel<T, C, S, P> {
    fn species(&self) -> usize {
        S
    }

    #[inline(always)]
    fn row(&self, _: usize, first: usize, rows: &Rows<'_, T>, out: &mut [T], _: &mut [T]) {
        match (self.volumetric, self.stencil) {
            (true, _) => self.run::<7>(first, rows, out),
            (_, Stencil::NinePoint) => self.run::<9>(first, rows, out),
            (_, Stencil::Axes) => self.run::<5>(first, rows, out),
        }
    }
}

/// A [`Cell`] as a [`Reaction`], for the other time steppers.
#[derive(Clone, Debug)]
pub struct CellReaction<C, const S: usize, const P: usize> {
    parameters: [Parameter; P],
    cell: PhantomData<fn() -> C>,
}

impl<C: Cell<S, P>, const S: usize, const P: usize> CellReaction<C, S, P> {
    /// The reaction at `parameters`, whose maps have the shape of the grid it is used on.
    pub fn new(parameters: [Parameter; P]) -> Self {
        Self { parameters, cell: PhantomData }
    }
}

impl<C: Cell<S, P>, const S: usize, const P: usize> Reaction for CellReaction<C, S, P> {
    fn species(&self) -> usize {
        S
    }

    fn rates(&self, first: usize, u: &[&[f64]], rates: &mut [&mut [f64]]) {
        for i in 0..u[0].len() {
            let p = std::array::from_fn(|p| self.parameters[p].at(first + i));
            let f = C::rates(std::array::from_fn(|s| u[s][i]), p);
            for s in 0..S {
                rates[s][i] = f[s];
            }
        }
    }
}
