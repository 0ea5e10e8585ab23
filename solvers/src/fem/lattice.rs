//! The mesh: a box of equal squares or cubes.

use crate::{Error, Grid, Result};

/// A box of `nx` by `ny` (by `nz`) square or cubic elements of edge 1.
///
/// Nodes and elements are row-major with x fastest. An element's nodes are in binary
/// order: node `a` lies at `x = a & 1`, `y = a >> 1 & 1`, `z = a >> 2 & 1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lattice {
    /// `[nz, ny, nx]`; `nz` is 1 in the plane.
    elements: [usize; 3],
    dim: usize,
}

impl Lattice {
    /// The mesh whose elements are the nodes of `grid`.
    ///
    /// # Errors
    /// Unless the grid has 2 or 3 axes.
    pub fn new(grid: Grid) -> Result<Self> {
        if grid.dim() < 2 {
            return Err(Error::out_of_range("axes of a mesh", grid.dim() as f64, "[2, 3]"));
        }
        Ok(Self { elements: grid.shape(), dim: grid.dim() })
    }

    /// Number of axes, 2 or 3.
    pub fn dim(&self) -> usize {
        self.dim
    }

    /// Elements `[nz, ny, nx]`; `nz` is 1 in the plane.
    pub fn elements(&self) -> [usize; 3] {
        self.elements
    }

    /// Nodes `[nz, ny, nx]`; one plane of them in the plane.
    pub fn nodes(&self) -> [usize; 3] {
        let [nz, ny, nx] = self.elements;
        [if self.dim == 3 { nz + 1 } else { 1 }, ny + 1, nx + 1]
    }

    /// Number of elements.
    pub fn element_count(&self) -> usize {
        self.elements.iter().product()
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.nodes().iter().product()
    }

    /// Nodes of an element: 4 in the plane, 8 in space.
    pub fn corners(&self) -> usize {
        1 << self.dim
    }

    /// Flat index of the node at column `i`, row `j`, plane `k`.
    pub fn node(&self, [i, j, k]: [usize; 3]) -> usize {
        let [_, ny, nx] = self.nodes();
        (k * ny + j) * nx + i
    }

    /// Column, row and plane of a node: its position in edges, x first.
    pub fn position(&self, node: usize) -> [usize; 3] {
        let [_, ny, nx] = self.nodes();
        [node % nx, node / nx % ny, node / (nx * ny)]
    }

    /// Column, row and plane of an element, x first.
    pub fn element_position(&self, element: usize) -> [usize; 3] {
        let [_, ny, nx] = self.elements;
        [element % nx, element / nx % ny, element / (nx * ny)]
    }

    /// The first node of an element, from which [`Lattice::offsets`] count.
    pub fn first_node(&self, element: usize) -> usize {
        self.node(self.element_position(element))
    }

    /// Distance in node numbers from an element's first node to each of its nodes; the
    /// first [`Lattice::corners`] of them count.
    pub fn offsets(&self) -> [usize; 8] {
        std::array::from_fn(|a| {
            self.node([a & 1, a >> 1 & 1, if self.dim == 3 { a >> 2 } else { 0 }])
        })
    }
}
