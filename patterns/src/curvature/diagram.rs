//! Curvature diagrams: how much of a surface has which principal curvatures.

use super::energy::{Energy, Scalar};
use crate::Result;
use solvers::{
    Boundary, Field, Grid,
    mesh::{SurfaceSamples, TriangleMesh},
    transport::{PointCloud, Sinkhorn},
};

/// Triangles smaller than this part of a voxel's face are left out.
const SLIVER: f64 = 1e-4;

/// Most triangles that stand for a surface when diagrams are compared.
pub(super) const CELLS: usize = 10_000;

/// Pairs (kappa1, kappa2) of a surface (1/length), weighted by area. Song 2021, eq. (25).
#[derive(Clone, Debug, PartialEq)]
pub struct Diagram(pub SurfaceSamples<2>);

impl Diagram {
    /// The diffuse curvatures of the phase `u` on the mesh of one of its levels.
    ///
    /// # Errors
    /// If the mesh does not belong to `u`.
    pub fn of<T: Scalar>(energy: &Energy<T>, u: &[T], mesh: &TriangleMesh) -> Result<Self> {
        let config = energy.config();
        let grid = Grid::new(&config.shape, config.dx)?;
        let zero = T::from_f64(0.0);
        let (mut first, mut second) = (vec![zero; u.len()], vec![zero; u.len()]);
        energy.curvatures(u, &mut first, &mut second);
        let field =
            |values: Vec<T>| Field::from_vec(grid, values.into_iter().map(T::to_f64).collect());
        let (first, second) = (field(first)?, field(second)?);
        let least = SLIVER * config.dx * config.dx;
        Ok(Self(mesh.sample([&first, &second], Boundary::Neumann, least)?))
    }

    /// Area of the surface (length^2).
    pub fn area(&self) -> f64 {
        self.0.weights.iter().sum()
    }

    /// The diagram of 10000 triangles at most, as a cloud of mass 1; `None` for no surface.
    ///
    /// # Errors
    /// If a curvature is not finite.
    pub fn cloud(&self, seed: u64) -> Result<Option<PointCloud<2>>> {
        let part = self.0.subsample(CELLS, seed);
        if part.values.is_empty() {
            return Ok(None);
        }
        Ok(Some(PointCloud::new(&part.values, &part.weights)?))
    }

    /// Sinkhorn distance (1/length) with the paper's settings: blur 1, reach 20.
    ///
    /// # Errors
    /// As [`Diagram::cloud`].
    pub fn distance(&self, other: &Self, seed: u64) -> Result<f64> {
        match (self.cloud(seed)?, other.cloud(seed)?) {
            (Some(a), Some(b)) => Ok(Sinkhorn::default().distance(&a, &b)?),
            (None, None) => Ok(0.0),
            _ => Ok(f64::INFINITY),
        }
    }
}
