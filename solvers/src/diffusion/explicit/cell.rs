//! Kernels made of a per-cell rate formula, parameters and a stencil.

use super::{Kernel, Real, Rows};
use crate::diffusion::Reaction;
use crate::{Error, Field, Grid, Result};
use serde::{Deserialize, Serialize};
use std::marker::PhantomData;

/// Cells that are computed together. A constant, so that the compiler turns the
/// loop over them into whole vectors and finds all its bounds; 80 columns are five.
const WIDTH: usize = 16;

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
}

/// Forward Euler of a [`Cell`]: `u += dt (f(u, p) + D lap u)`, then `max(u, 0)` if asked.
#[derive(Clone, Debug)]
pub struct CellKernel<T, C, const S: usize, const P: usize> {
    stencil: Stencil,
    volumetric: bool,
    clamp: bool,
    dt: T,
    /// Coefficient of the stencil's integer-weighted sum.
    weight: [T; S],
    uniform: [T; P],
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
            clamp,
            dt: T::from_f64(dt),
            weight: [T::from_f64(0.0); S],
            uniform: [T::from_f64(0.0); P],
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
        let unit = if self.stencil == Stencil::NinePoint { 6.0 } else { 1.0 };
        let scale = self.dt.to_f64() / (unit * grid.spacing().powi(2));
        self.weight = diffusion.map(|d| T::from_f64(d * scale));
    }

    /// Changes parameter `index`.
    ///
    /// # Errors
    /// If a map has another shape than `grid`.
    pub fn set_parameter(&mut self, grid: Grid, index: usize, parameter: &Parameter) -> Result<()> {
        match parameter {
            Parameter::Uniform(value) => {
                self.uniform[index] = T::from_f64(*value);
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

    /// A row in pieces of `WIDTH` cells, the last of them overlapping; shorter rows cell by cell.
    #[inline(always)]
    fn run<const POINTS: u8, const MAPPED: bool>(
        &self,
        first: usize,
        rows: &Rows<'_, T>,
        out: &mut [T],
    ) {
        let nx = rows.stride - 2;
        let mut start = 0;
        while start < nx {
            if nx >= WIDTH {
                let at = start.min(nx - WIDTH);
                // The ghost cells on both sides make the window.
                self.piece::<POINTS, MAPPED, WIDTH, { WIDTH + 2 }>(first, at, rows, out);
                start = at + WIDTH;
            } else {
                self.piece::<POINTS, MAPPED, 1, 3>(first, start, rows, out);
                start += 1;
            }
        }
    }

    /// Cells `at..at + W` of a row; `V = W + 2`.
    #[inline(always)]
    fn piece<const POINTS: u8, const MAPPED: bool, const W: usize, const V: usize>(
        &self,
        first: usize,
        at: usize,
        rows: &Rows<'_, T>,
        out: &mut [T],
    ) {
        let zero = T::from_f64(0.0);
        let window = |row: &'_ [T], s: usize| -> [T; V] {
            let mut values = [zero; V];
            values.copy_from_slice(&row[s * rows.stride + at..][..V]);
            values
        };
        let center: [[T; V]; S] = std::array::from_fn(|s| window(rows.center, s));
        let parameters: [[T; W]; P] = std::array::from_fn(|p| {
            let mut values = [self.uniform[p]; W];
            if MAPPED {
                let origin = if self.mapped[p] { first + at } else { at };
                values.copy_from_slice(&self.maps[p][origin..][..W]);
            }
            values
        });
        let mut next = [[zero; W]; S];
        for i in 0..W {
            let u = std::array::from_fn(|s| center[s][i + 1]);
            let rates = C::rates(u, std::array::from_fn(|p| parameters[p][i]));
            for s in 0..S {
                next[s][i] = u[s] + self.dt * rates[s];
            }
        }
        for s in 0..S {
            let [north, south] = [rows.north, rows.south].map(|row| window(row, s));
            let c = &center[s];
            let sum: [T; W] = if POINTS == 9 {
                std::array::from_fn(|i| nine_point(&north, c, &south, i))
            } else if POINTS == 7 {
                let [front, back] = [rows.front, rows.back].map(|row| window(row, s));
                std::array::from_fn(|i| seven_point([&north, c, &south, &front, &back], i))
            } else {
                std::array::from_fn(|i| five_point(&north, c, &south, i))
            };
            for i in 0..W {
                next[s][i] = next[s][i] + self.weight[s] * sum[i];
            }
            if self.clamp {
                next[s] = next[s].map(T::clamp_negative);
            }
            out[s * rows.stride + 1 + at..][..W].copy_from_slice(&next[s]);
        }
    }
}

// The sums below have the symmetries of the square to the last bit: opposite
// neighbours are added first, so that mirrored states have mirrored successors.

#[inline(always)]
fn five_point<T: Real, const V: usize>(n: &[T; V], c: &[T; V], s: &[T; V], i: usize) -> T {
    (c[i] + c[i + 2]) + (n[i + 1] + s[i + 1]) - T::from_f64(4.0) * c[i + 1]
}

#[inline(always)]
fn nine_point<T: Real, const V: usize>(n: &[T; V], c: &[T; V], s: &[T; V], i: usize) -> T {
    let edges = (c[i] + c[i + 2]) + (n[i + 1] + s[i + 1]);
    let corners = (n[i] + s[i + 2]) + (n[i + 2] + s[i]);
    (T::from_f64(4.0) * edges + corners) - T::from_f64(20.0) * c[i + 1]
}

#[inline(always)]
fn seven_point<T: Real, const V: usize>([n, c, s, f, b]: [&[T; V]; 5], i: usize) -> T {
    let edges = ((c[i] + c[i + 2]) + (n[i + 1] + s[i + 1])) + (f[i + 1] + b[i + 1]);
    edges - T::from_f64(6.0) * c[i + 1]
}

impl<T: Real, C: Cell<S, P>, const S: usize, const P: usize> Kernel<T> for CellKernel<T, C, S, P> {
    fn species(&self) -> usize {
        S
    }

    #[inline(always)]
    fn row(&self, _: usize, first: usize, rows: &Rows<'_, T>, out: &mut [T], _: &mut [T]) {
        let mapped = self.mapped.contains(&true);
        match (self.volumetric, self.stencil, mapped) {
            (true, _, _) => self.run::<7, true>(first, rows, out),
            (_, Stencil::NinePoint, false) => self.run::<9, false>(first, rows, out),
            (_, Stencil::NinePoint, true) => self.run::<9, true>(first, rows, out),
            (_, Stencil::Axes, false) => self.run::<5, false>(first, rows, out),
            (_, Stencil::Axes, true) => self.run::<5, true>(first, rows, out),
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
