//! What moves a front. A new speed field is one type that implements [`Speed`].

use crate::{Field, Grid, Result};

/// A speed field: the only thing that a new one implements.
///
/// Called once per time step for the whole grid, so `dyn Speed` costs nothing.
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
#[derive(Clone, Debug)]
pub struct Terms {
    grid: Grid,
    normal: Option<Field>,
    velocity: Option<[Field; 3]>,
    curvature: Option<Field>,
}

impl Terms {
    /// Nothing moves.
    pub fn new(grid: Grid) -> Self {
        Self { grid, normal: None, velocity: None, curvature: None }
    }

    /// The grid of all parts.
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// Normal speed beta (length/time, positive outwards), to be added to.
    pub fn normal(&mut self) -> &mut Field {
        self.normal.get_or_insert_with(|| Field::constant(self.grid, 0.0))
    }

    /// Velocity `[vx, vy, vz]` (length/time), to be added to; absent axes are ignored.
    pub fn velocity(&mut self) -> &mut [Field; 3] {
        self.velocity.get_or_insert_with(|| [0; 3].map(|_| Field::constant(self.grid, 0.0)))
    }

    /// Coefficient b >= 0 (length^2/time) of motion by curvature, to be added to.
    pub fn curvature(&mut self) -> &mut Field {
        self.curvature.get_or_insert_with(|| Field::constant(self.grid, 0.0))
    }
}
