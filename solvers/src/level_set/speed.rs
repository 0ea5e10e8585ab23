//! What moves a front. A new speed field is one type that implements [`Speed`].

use crate::{Field, Grid, Result};

/// A speed field: the only thing that a new one implements.
///
/// Called once per stage of a time step for the whole grid, so `dyn Speed` costs
/// nothing.
///
/// ```
/// use solvers::level_set::{LevelSet, Scheme, Speed, Terms};
/// use solvers::{Field, Grid, Result};
///
/// /// beta = x: the front moves faster on the right.
/// struct Ramp;
///
/// impl Speed for Ramp {
///     fn add(&mut self, phi: &Field, _t: f64, terms: &mut Terms) -> Result<()> {
///         let grid = phi.grid();
///         for (n, beta) in terms.normal().as_mut_slice().iter_mut().enumerate() {
///             *beta += grid.position(n)[0];
///         }
///         Ok(())
///     }
/// }
///
/// let disk = Field::from_fn(Grid::new(&[32, 32], 1.0)?, |[x, y, _]| (x - 16.0).hypot(y - 16.0) - 8.0);
/// let mut front = LevelSet::new(disk, Scheme::default())?;
/// front.advance(&mut Ramp, 0.1)?;
/// # Ok::<(), solvers::Error>(())
/// ```
pub trait Speed {
    /// Adds this field's part, at time `t` and front `phi`, to `terms`.
    ///
    /// # Errors
    /// Whatever makes the speed unknown at this state, e.g. a failed solve.
    fn add(&mut self, phi: &Field, t: f64, terms: &mut Terms) -> Result<()>;
}

/// What moves a front during one step:
/// `dphi/dt = -beta |grad phi| - v . grad phi + b kappa |grad phi|`.
///
/// The three parts are kept apart because each has its own stable difference
/// scheme: upwind by the sign of beta, upwind by v, and central for kappa.
/// A part that no speed touches costs nothing.
#[derive(Clone, Debug)]
pub struct Terms {
    grid: Grid,
    normal: Part<1>,
    velocity: Part<3>,
    curvature: Part<1>,
}

/// Fields that keep their memory between steps.
#[derive(Clone, Debug)]
struct Part<const N: usize> {
    fields: Option<[Field; N]>,
    used: bool,
}

impl<const N: usize> Part<N> {
    const UNUSED: Self = Self { fields: None, used: false };

    /// The fields, zero at the first call after a clearing.
    fn get(&mut self, grid: Grid) -> &mut [Field; N] {
        let stale = !std::mem::replace(&mut self.used, true);
        let new = self.fields.is_none();
        let fields = self.fields.get_or_insert_with(|| [0; N].map(|_| Field::constant(grid, 0.0)));
        if stale && !new {
            fields.iter_mut().for_each(|field| field.as_mut_slice().fill(0.0));
        }
        fields
    }

    fn slices(&self) -> Option<[&[f64]; N]> {
        let fields = self.fields.as_ref().filter(|_| self.used)?;
        Some(fields.each_ref().map(Field::as_slice))
    }
}

impl Terms {
    /// Nothing moves.
    pub fn new(grid: Grid) -> Self {
        Self { grid, normal: Part::UNUSED, velocity: Part::UNUSED, curvature: Part::UNUSED }
    }

    /// The grid of all parts.
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// Normal speed beta (length/time, positive outwards), to be added to.
    pub fn normal(&mut self) -> &mut Field {
        let [field] = self.normal.get(self.grid);
        field
    }

    /// Velocity `[vx, vy, vz]` (length/time), to be added to; absent axes are ignored.
    pub fn velocity(&mut self) -> &mut [Field; 3] {
        self.velocity.get(self.grid)
    }

    /// Coefficient b >= 0 (length^2/time) of motion by curvature, to be added to.
    pub fn curvature(&mut self) -> &mut Field {
        let [field] = self.curvature.get(self.grid);
        field
    }

    /// Nothing moves again; the memory is kept.
    pub(super) fn clear(&mut self) {
        self.normal.used = false;
        self.velocity.used = false;
        self.curvature.used = false;
    }

    /// The parts that some speed has touched since the last clearing.
    pub(super) fn parts(&self) -> Parts<'_> {
        Parts {
            normal: self.normal.slices().map(|[beta]| beta),
            velocity: self.velocity.slices(),
            curvature: self.curvature.slices().map(|[b]| b),
        }
    }
}

/// The touched parts of [`Terms`], for reading.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parts<'a> {
    /// Normal speed beta.
    pub(super) normal: Option<&'a [f64]>,
    /// Velocity, x first.
    pub(super) velocity: Option<[&'a [f64]; 3]>,
    /// Curvature coefficient b.
    pub(super) curvature: Option<&'a [f64]>,
}
