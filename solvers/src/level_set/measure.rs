//! Area, perimeter and topology of the inside `phi < 0`.

mod components;
mod content;

pub use components::{Components, label_components};

use crate::{Boundary, Field};

/// Measures of the region `phi < 0`.
///
/// Sizes are those of the linear reconstruction (marching squares, marching
/// tetrahedra), second order in h, over the whole domain: half a cell around
/// the outermost nodes, or one period. Topology is that of the nodes, joined
/// through faces (4 neighbours in the plane, 6 in space).
#[derive(Clone, Debug, PartialEq)]
pub struct Measures {
    /// Length, area or volume of the inside (length^dim).
    pub area: f64,
    /// Number of end points, perimeter or surface area (length^(dim - 1)), without the domain's border.
    pub perimeter: f64,
    /// Number of components.
    pub components: usize,
    /// Enclosed regions of the outside: holes in the plane, cavities in space.
    ///
    /// In a periodic plane `components - euler_number`, which counts ways around the period too.
    pub holes: usize,
    /// Euler number: components - holes in the plane, components - tunnels + cavities in space.
    pub euler_number: i64,
    /// Nodes in each component, in the order of their first nodes.
    pub sizes: Vec<usize>,
}

impl Measures {
    /// Measures `phi < 0`. Linear time.
    ///
    /// ```
    /// use solvers::{Boundary, Field, Grid, level_set::Measures};
    /// let grid = Grid::new(&[64, 64], 1.0)?;
    /// let phi = Field::from_fn(grid, |[x, y, _]| ((x - 31.0).hypot(y - 31.0) - 16.0).abs() - 4.0);
    /// let ring = Measures::of(&phi, Boundary::Neumann);
    /// assert_eq!((ring.components, ring.holes, ring.euler_number), (1, 1, 0));
    /// # Ok::<(), solvers::Error>(())
    /// ```
    pub fn of(phi: &Field, boundary: Boundary) -> Self {
        let grid = phi.grid();
        let inside: Vec<bool> = phi.as_slice().iter().map(|&v| v < 0.0).collect();
        let labels = components::label(&inside, grid, boundary, false);
        let euler_number = components::euler_number(&inside, grid, boundary);
        let (area, perimeter) = content::content(phi, boundary);
        let count = labels.sizes.len();
        let holes = match grid.dim() {
            1 => 0,
            2 => usize::try_from(count as i64 - euler_number).unwrap_or(0),
            _ => components::cavities(&inside, grid, boundary),
        };
        Self { area, perimeter, components: count, holes, euler_number, sizes: labels.sizes }
    }

    /// Number and mean size (nodes) of the components of at least `least` nodes; mean 0 if there are none.
    pub fn components_of_at_least(&self, least: usize) -> (usize, f64) {
        let large = self.sizes.iter().filter(|&&size| size >= least);
        let (count, sum) = large.fold((0, 0), |(count, sum), size| (count + 1, sum + size));
        (count, if count > 0 { sum as f64 / count as f64 } else { 0.0 })
    }
}
