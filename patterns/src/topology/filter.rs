//! Averages over neighbours: what keeps a design from depending on the mesh.

use super::{
    build::Problem,
    config::{Config, Filter},
};
use crate::Result;
use rayon::prelude::*;
use solvers::{
    Grid,
    fem::{Choice, Element, Lattice, LinearSolver, System},
};

/// A linear, symmetric map `H` of densities and its row sums `Hs`.
pub(super) enum Smoothing {
    /// The identity.
    None,
    /// The cone `max(0, r - distance)`.
    Cone(Cone),
    /// The screened Poisson equation, whose row sums are 1.
    Helmholtz(Box<Helmholtz>),
}

impl Smoothing {
    pub(super) fn new(config: &Config, problem: &Problem) -> Result<Self> {
        Ok(match config.filter {
            Filter::None => Self::None,
            Filter::Sensitivity | Filter::Density => {
                Self::Cone(Cone::new(problem.grid, config.filter_radius))
            }
            Filter::Helmholtz => {
                Self::Helmholtz(Box::new(Helmholtz::new(problem, config.filter_radius)?))
            }
        })
    }

    /// `out = H x / Hs`: the filtered densities.
    pub(super) fn average(&mut self, x: &[f64], out: &mut [f64]) -> Result<()> {
        match self {
            Self::None => out.copy_from_slice(x),
            Self::Cone(cone) => cone.average(x, out),
            Self::Helmholtz(filter) => filter.apply(x, out)?,
        }
        Ok(())
    }

    /// `out = H (y / Hs)`: the transpose of [`Smoothing::average`].
    pub(super) fn transpose(&mut self, y: &[f64], out: &mut [f64]) -> Result<()> {
        match self {
            Self::None => out.copy_from_slice(y),
            Self::Cone(cone) => cone.transpose(y, out),
            Self::Helmholtz(filter) => filter.apply(y, out)?,
        }
        Ok(())
    }
}

/// Cone-shaped weights on a grid, clipped at the border.
pub(super) struct Cone {
    grid: Grid,
    /// Offset `[x, y, z]` and weight.
    stencil: Vec<([isize; 3], f64)>,
    /// Sum of the weights at each element.
    sums: Vec<f64>,
    work: Vec<f64>,
}

impl Cone {
    fn new(grid: Grid, radius: f64) -> Self {
        let reach = (radius.ceil() as isize) - 1;
        let depth = if grid.dim() == 3 { reach } else { 0 };
        let mut stencil = Vec::new();
        for z in -depth..=depth {
            for y in -reach..=reach {
                for x in -reach..=reach {
                    let weight = radius - ((x * x + y * y + z * z) as f64).sqrt();
                    if weight > 0.0 {
                        stencil.push(([x, y, z], weight));
                    }
                }
            }
        }
        let mut cone = Self { grid, stencil, sums: Vec::new(), work: vec![0.0; grid.len()] };
        let mut sums = vec![0.0; grid.len()];
        cone.sum(&vec![1.0; grid.len()], &mut sums);
        cone.sums = sums;
        cone
    }

    /// `out = H x`, rows in parallel.
    fn sum(&self, x: &[f64], out: &mut [f64]) {
        let [nz, ny, nx] = self.grid.shape();
        out.par_chunks_mut(nx).enumerate().for_each(|(row, out)| {
            out.fill(0.0);
            let (k, j) = ((row / ny) as isize, (row % ny) as isize);
            for &([dx, dy, dz], weight) in &self.stencil {
                let (kk, jj) = (k + dz, j + dy);
                if kk < 0
                    || kk >= nz as isize
                    || jj < 0
                    || jj >= ny as isize
                    || dx.unsigned_abs() >= nx
                {
                    continue;
                }
                let source = &x[(kk as usize * ny + jj as usize) * nx..][..nx];
                let (from, to) = (dx.max(0) as usize, (-dx).max(0) as usize);
                let count = nx - dx.unsigned_abs();
                for (o, s) in out[to..to + count].iter_mut().zip(&source[from..from + count]) {
                    *o += weight * s;
                }
            }
        });
    }

    fn average(&self, x: &[f64], out: &mut [f64]) {
        self.sum(x, out);
        out.iter_mut().zip(&self.sums).for_each(|(o, s)| *o /= s);
    }

    fn transpose(&mut self, y: &[f64], out: &mut [f64]) {
        let mut work = std::mem::take(&mut self.work);
        work.iter_mut().zip(y).zip(&self.sums).for_each(|((w, y), s)| *w = y / s);
        self.sum(&work, out);
        self.work = work;
    }

    /// Sensitivity filter `H (x dc) / (Hs max(0.001, x))`: Sigmund 2001, eq. (5); the
    /// floor of x as in Andreassen et al. 2011.
    pub(super) fn sensitivity(&mut self, x: &[f64], dc: &mut [f64]) {
        let mut work = std::mem::take(&mut self.work);
        work.iter_mut().zip(x).zip(&*dc).for_each(|((w, x), dc)| *w = x * dc);
        self.sum(&work, dc);
        for ((dc, sum), x) in dc.iter_mut().zip(&self.sums).zip(x) {
            *dc /= sum * x.max(1e-3);
        }
        self.work = work;
    }
}

/// `-r^2 lap x~ + x~ = x` with free ends: Lazarov & Sigmund 2011, eqs. (4) and (13).
pub(super) struct Helmholtz {
    system: System,
    solver: LinearSolver,
    nodal: Vec<f64>,
    solution: Vec<f64>,
}

impl Helmholtz {
    /// The filter as wide as a cone of `radius`: `r = radius / (2 sqrt 3)`.
    pub(super) fn new(problem: &Problem, radius: f64) -> Result<Self> {
        let grid = problem.grid;
        let lattice = Lattice::new(grid.axes())?;
        let nodes = lattice.node_count();
        let element = Element::screened_poisson(grid.dim(), radius / (2.0 * 3.0_f64.sqrt()))?;
        let system = System::new(lattice, element, vec![false; nodes], Vec::new())?;
        let mut solver = LinearSolver::new(&system, Choice::Auto, problem.memory)?;
        solver.prepare(&system, &vec![1.0; grid.len()])?;
        Ok(Self { system, solver, nodal: vec![0.0; nodes], solution: vec![0.0; nodes] })
    }

    /// Elements to nodes, solve, nodes to elements: symmetric.
    pub(super) fn apply(&mut self, x: &[f64], out: &mut [f64]) -> Result<()> {
        let lattice = self.system.lattice();
        let (corners, offsets) = (lattice.corners(), lattice.offsets());
        let share = 1.0 / corners as f64;
        self.nodal.fill(0.0);
        for (element, x) in x.iter().enumerate() {
            let first = lattice.first_node(element);
            offsets[..corners].iter().for_each(|offset| self.nodal[first + offset] += share * x);
        }
        self.solver.solve(&self.system, &self.nodal, &mut self.solution, 1e-10)?;
        for (element, out) in out.iter_mut().enumerate() {
            let first = lattice.first_node(element);
            let sum: f64 =
                offsets[..corners].iter().map(|offset| self.solution[first + offset]).sum();
            *out = share * sum;
        }
        Ok(())
    }
}
