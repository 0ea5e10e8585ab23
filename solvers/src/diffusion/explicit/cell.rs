//! Kernels made of a per-cell rate formula, parameters and a stencil.

use super::stencil::{CHUNK, Chunks, sum};
use super::{Kernel, Real, Rows, Stencil};
use crate::diffusion::Reaction;
use crate::{Error, Field, Grid, Result};
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
    /// One value per node, or one row of equal values; rows filled up to whole chunks.
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
        let nx = grid.shape()[2];
        let width = nx.next_multiple_of(CHUNK);
        match parameter {
            Parameter::Uniform(value) => {
                self.maps[index] = vec![T::from_f64(*value); width];
                self.mapped[index] = false;
            }
            Parameter::Map(field) => {
                field.check_shape("parameter map", grid)?;
                self.maps[index].clear();
                for row in field.as_slice().chunks_exact(nx) {
                    self.maps[index].extend(row.iter().map(|&v| T::from_f64(v)));
                    self.maps[index].extend(std::iter::repeat_n(T::from_f64(0.0), width - nx));
                }
                self.mapped[index] = true;
            }
        }
        Ok(())
    }

    /// A row of all species: `max(u + dt f(u, p) + weight sum, 0)`.
    ///
    /// All slices are cut to one length before the loop, which then has no bounds
    /// checks, and a chunk is written only when it is complete, so that nothing read
    /// for it can be what was written. Plain loops fill the arrays of slices: the
    /// library's `map` and `from_fn` are not always compiled into their caller, and
    /// then not for its vector unit. Parameters are always read from rows, and the
    /// clamp is a number: each variant would be compiled for every kinetics,
    /// precision and instruction set.
    #[inline(always)]
    fn run<const POINTS: u8>(&self, first: usize, rows: &Rows<'_, T>, out: &mut [T]) {
        let zero = T::from_f64(0.0);
        let (dt, weight, floor) = (self.dt, self.weight, self.floor);
        let count = rows.cells.div_ceil(CHUNK);
        let first = first / rows.cells * count;
        let mut maps: [&[[T; CHUNK]]; P] = [&[]; P];
        for (p, map) in maps.iter_mut().enumerate() {
            let first = if self.mapped[p] { first } else { 0 };
            *map = &self.maps[p].as_chunks().0[first..][..count];
        }
        let mut near = [[Chunks::default(); 5]; S];
        for (s, near) in near.iter_mut().enumerate() {
            *near = Chunks::around(rows, s, count);
        }
        for j in 0..count {
            let mut sums = [[zero; CHUNK]; S];
            for s in 0..S {
                sums[s] = sum::<T, POINTS>(&near[s], j);
            }
            let mut next = [[zero; CHUNK]; S];
            for i in 0..CHUNK {
                let (mut u, mut p) = ([zero; S], [zero; P]);
                for s in 0..S {
                    u[s] = near[s][0].here[j][i];
                }
                for k in 0..P {
                    p[k] = maps[k][j][i];
                }
                let rates = C::rates(u, p);
                for s in 0..S {
                    let value = (u[s] + dt * rates[s]) + weight[s] * sums[s][i];
                    next[s][i] = if value < floor { zero } else { value };
                }
            }
            for s in 0..S {
                out[s * rows.stride + 1 + j * CHUNK..][..CHUNK].copy_from_slice(&next[s]);
            }
        }
    }
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
