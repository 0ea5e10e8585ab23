//! Curvature diagrams: how much of a surface has which principal curvatures.

use super::energy::{Edges, Energy, Scalar};
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
        let boundary = match config.edges {
            Edges::Periodic => Boundary::Periodic,
            Edges::Replicate | Edges::Free => Boundary::Neumann,
        };
        Ok(Self(mesh.sample([&first, &second], boundary, least)?))
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

#[cfg(test)]
mod tests {
    use super::Diagram;
    use crate::curvature::Coefficients;
    use crate::curvature::energy::{Energy, EnergyConfig};
    use crate::curvature::view;
    use solvers::{Field, Grid, isosurface::Caps};

    /// A ball that the box's faces cut has the curvatures of the same ball in the middle.
    #[test]
    fn a_periodic_box_has_no_faces() {
        let (n, h, epsilon) = (24_usize, 0.01, 0.02);
        let around = |moved: usize| {
            let far = |i: usize| (((i + n - moved) % n) as f64 - 12.0) * h;
            let phase = |i: usize| {
                let [x, y, z] = [i % n, i / n % n, i / n / n].map(far);
                libm::tanh((0.06 - libm::hypot(libm::hypot(x, y), z)) / (1.5 * epsilon))
            };
            let u: Vec<f64> = (0..n * n * n).map(phase).collect();
            let ball = Coefficients::from([1.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
            let energy = Energy::new(EnergyConfig::new([n; 3], h, epsilon, ball)).unwrap();
            let grid = Grid::new(&[n; 3], h).unwrap();
            let field = Field::from_vec(grid, u.clone()).unwrap();
            let mesh = view::surface(field, 0.0, Caps::Periodic).mesh;
            let mut of = Diagram::of::<f64>(&energy, &u, &mesh).unwrap();
            of.0.values.sort_by(|a, b| a[0].total_cmp(&b[0]));
            of
        };
        let [middle, cut] = [0, 11].map(around);
        assert_eq!(middle.0.values.len(), cut.0.values.len());
        assert!((middle.area() / cut.area() - 1.0).abs() < 1e-9);
        for (a, b) in middle.0.values.iter().zip(&cut.0.values) {
            assert!((a[0] - b[0]).abs() < 1e-9, "{a:?} {b:?}");
        }
    }
}
