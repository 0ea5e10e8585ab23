//! Conjugate gradients with a multigrid preconditioner, for finite elements on lattices.
//!
//! Solves `K u = f`, `K = sum_e E_e Ke + S`, as density-based topology optimization does
//! for every design: one element matrix, a stiffness per element, from void to solid.
//!
//! | symbol | code        | meaning                                                    |
//! |--------|-------------|------------------------------------------------------------|
//! | Ke     | `ke`        | matrix of an element of stiffness 1, `components 2^dim` rows |
//! | E_e    | `stiffness` | stiffness of an element, above 0                           |
//! | S      | `springs`   | extra diagonal                                             |
//! | P      | `Transfer`  | interpolation from a level to the next finer one           |
//! | D      | `inverse_diagonal` | diagonal of a level's matrix (stored as 1 / D)      |
//!
//! Elements are row-major with x fastest, `[ny, nx]` or `[nz, ny, nx]`; nodes likewise, one
//! more along each axis; unknown `components node + component`, components of displacement
//! in the order x, y, z. Corner a of an element is at `x = a & 1`, `y = a >> 1 & 1`,
//! `z = a >> 2 & 1`.
//!
//! The finest level multiplies without a matrix (`element.rs`, `fine.rs`), the others are
//! Galerkin products `P^T A P` kept as stencils (`galerkin.rs`, `stencil.rs`), and the
//! coarsest is factorized. The V-cycle is in 4-byte numbers, the iteration around it in
//! 8-byte ones: Amir, Aage and Lazarov 2014, "On multigrid-CG for efficient topology
//! optimization"; Wu, Dick and Westermann 2016, "A system for high-resolution topology
//! optimization". Deviations: Galerkin operators are summed element by element with
//! supports removed first, and the smoother is a Chebyshev polynomial (`level.rs`).
//!
//! All results are the same bytes for any number of threads. Across processors they may
//! differ in the last bits, because vectors and fused products are used where there are any.

mod bands;
mod check;
mod children;
mod coarsest;
mod constraints;
mod cycle;
mod element;
mod fine;
mod first;
mod galerkin;
mod lattice;
mod level;
mod memory;
mod radius;
mod real;
mod rows;
mod smooth;
mod solve;
mod stencil;
mod transfer;

#[cfg(test)]
mod designs;
#[cfg(test)]
mod tests;

pub use memory::memory;

use crate::{Error, Result};
use bands::Bands;
use check::{check, shape};
use constraints::Constraints;
use cycle::Hierarchy;
use fine::{Fine, Work};
use lattice::{Lattice, Layout};
use std::sync::Arc;

/// A solve is given up when the smallest residual norm has not fallen by this factor ...
const STALL_FACTOR: f64 = 0.1;

/// ... within this many iterations. The slowest designs measured (0/1, with loose islands in
/// the void) took 13 iterations per factor 10; with 0/1 noise the residual even grows.
const STALL_WINDOW: usize = 40;

/// How a [`Multigrid`] preconditions; the default is good for 2D and 3D.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Degree of the smoother's polynomial, 2 to 4. 3 saves a tenth of the iterations, each
    /// of which costs a third more.
    pub degree: usize,
    /// The first level of no more unknowns than this is solved directly; by default as
    /// measured best. More saves iterations, but the direct solve, which is serial, then
    /// dominates.
    pub coarsest_unknowns: Option<usize>,
}

impl Default for Options {
    fn default() -> Self {
        Self { degree: 2, coarsest_unknowns: None }
    }
}

impl Options {
    /// 9000 admits 16 x 8 x 8 elements of three unknowns and 75 x 25 of two: at 64 x 32 x 32
    /// and 300 x 100 a level less needs half as many iterations again. On a plane, where
    /// factors are cheap, a 12th (two levels down) up to 40 000 saves another third at
    /// 600 x 200 and a quarter at 1000 x 1000.
    fn coarsest(&self, lattice: &Lattice, components: usize) -> usize {
        let share = lattice.node_count() * components / 12;
        let plane = share.clamp(9000, 40_000);
        self.coarsest_unknowns.unwrap_or(if lattice.dim() == 2 { plane } else { 9000 })
    }
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The tolerance is reached.
    Converged,
    /// The residual has not fallen by a factor of 10 within 40 iterations, or rounding
    /// prevents any progress: solve directly instead. x is the last iterate.
    Stalled,
    /// The limit of iterations is reached; x is the last iterate.
    LimitReached,
}

/// What a solve did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// Iterations done.
    pub iterations: usize,
    /// `|K x - f| / |f|` over the free unknowns; the true one if converged.
    pub residual: f64,
    /// How it ended.
    pub status: Status,
}

/// A solver of `K u = f` on one lattice, with one set of supports; allocated once.
pub struct Multigrid {
    layout: Layout,
    bands: Bands,
    fixed: Vec<bool>,
    constraints: Arc<Constraints>,
    fine: Fine<f64>,
    hierarchy: Hierarchy,
    /// Whether there is a stiffness.
    ready: bool,
    x: Vec<f64>,
    r: Vec<f64>,
    p: Vec<f64>,
    q: Vec<f64>,
    work: Vec<Work<f64>>,
    /// One each per row.
    sums: Vec<f64>,
    more_sums: Vec<f64>,
}

impl Multigrid {
    /// Allocates all levels; [`Multigrid::update`] must follow.
    ///
    /// `ke` row by row, symmetric, `components * 2^dim` rows; `components` is 1 or the number
    /// of axes. `fixed` (the unknown is 0) and `springs` (extra diagonal, in the unit of
    /// `E Ke`, or empty for none) have one entry per unknown. Threads are those of the rayon
    /// pool it is called in. Bytes: see [`memory()`].
    ///
    /// # Errors
    /// If a length or the number of components does not fit, `ke` is not symmetric with a
    /// positive diagonal, a number is not finite, a spring is negative, the degree is not in
    /// 2 to 4, or memory does not suffice.
    pub fn new(
        lattice: &Lattice,
        components: usize,
        ke: &[f64],
        fixed: &[bool],
        springs: &[f64],
        options: Options,
    ) -> Result<Self> {
        check(lattice, components, ke, fixed, springs, &options)?;
        let layout = Layout::new(*lattice, components);
        let constraints = Arc::new(Constraints::new(&layout, fixed, springs));
        let scale = 1.0 / ke.iter().copied().fold(0.0, f64::max);
        let scaled = |values: &[f64]| values.iter().map(|v| v * scale).collect::<Vec<_>>();
        let hierarchy =
            Hierarchy::new(*lattice, components, &scaled(ke), fixed, &scaled(springs), options)?;
        let bands = Fine::<f64>::bands(&layout);
        let zeros = || vec![0.0; layout.len()];
        Ok(Self {
            layout,
            bands,
            fixed: fixed.to_vec(),
            fine: Fine::new(layout, ke, constraints.clone()),
            constraints,
            hierarchy,
            ready: false,
            x: zeros(),
            r: zeros(),
            p: zeros(),
            q: zeros(),
            work: vec![Work::new(&layout); bands.count],
            sums: vec![0.0; layout.rows()],
            more_sums: vec![0.0; layout.rows()],
        })
    }

    /// Takes over the stiffness of each element, and rebuilds all coarse operators. Costs
    /// as much as 5 (2D) to 10 (3D) iterations.
    ///
    /// # Errors
    /// If the length does not fit, a stiffness is not a number above 0, or the coarsest
    /// matrix is not positive definite: then supports are missing.
    pub fn update(&mut self, stiffness: &[f64]) -> Result<()> {
        self.ready = false;
        let count = self.layout.lattice.element_count();
        if stiffness.len() != count {
            return Err(shape("stiffness", stiffness.len(), count));
        }
        if let Some(e) = stiffness.iter().position(|&e| !(e > 0.0 && e.is_finite())) {
            let name = format!("stiffness of element {e}");
            return Err(Error::out_of_range(&name, stiffness[e], "(0, inf)"));
        }
        self.fine.set_stiffness(stiffness, 1.0, 0.0);
        self.hierarchy.update(stiffness)?;
        self.ready = true;
        Ok(())
    }

    /// `y = K x` for the stiffness of the last update, with the rows and columns of fixed
    /// unknowns taken as 0. Allocates its work space.
    ///
    /// # Errors
    /// If a length does not fit.
    pub fn apply(&self, x: &[f64], y: &mut [f64]) -> Result<()> {
        self.check_length("x of the product", x.len())?;
        self.check_length("y of the product", y.len())?;
        let layout = &self.layout;
        let mut spread = vec![0.0; layout.len()];
        rows::spread(layout, x, &mut spread);
        self.constraints.clear_fixed(layout, &mut spread);
        let per_row = layout.components * layout.lattice.nodes()[2];
        let mut work = self.work.clone();
        let parts = (self.bands.part(y, per_row), bands::Part::one_each(&mut work));
        self.bands.each(parts, |band, (y, work)| {
            let rows = self.bands.range(band);
            let start = rows.start;
            self.fine.product(&spread, rows, &mut work.data[0], |row, product| {
                let y = &mut y.data[(row - start) * per_row..][..per_row];
                for (place, y) in y.iter_mut().enumerate() {
                    let (i, c) = (place / layout.components, place % layout.components);
                    *y = product[c * layout.wide() + 1 + i];
                }
            });
        });
        Ok(())
    }

    /// Number of unknowns.
    pub fn unknowns(&self) -> usize {
        self.layout.unknowns()
    }

    fn check_length(&self, name: &str, len: usize) -> Result<()> {
        if len == self.unknowns() { Ok(()) } else { Err(shape(name, len, self.unknowns())) }
    }
}

impl std::fmt::Debug for Multigrid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (levels, entries) = (self.hierarchy.levels.len(), self.hierarchy.factor_entries());
        write!(f, "Multigrid {{ unknowns: {}, levels: ", self.unknowns())?;
        write!(f, "{}, entries of the coarsest factor: {entries} }}", levels + 1)
    }
}
