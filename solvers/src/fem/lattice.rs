//! The mesh: a box of equal squares or cubes.

use crate::{Error, Result};

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
    /// A mesh of `elements` along its axes, `[ny, nx]` or `[nz, ny, nx]`.
    ///
    /// # Errors
    /// Unless there are 2 or 3 axes of at least one element each and at most 2^30 elements.
    pub fn new(elements: &[usize]) -> Result<Self> {
        let dim = elements.len();
        if !(2..=3).contains(&dim) {
            return Err(Error::out_of_range("axes of a mesh", dim as f64, "[2, 3]"));
        }
        let count: f64 = elements.iter().map(|&n| n as f64).product();
        if count < 1.0 {
            return Err(Error::Invalid(format!(
                "mesh {elements:?} has an axis of 0 elements, expected at least 1"
            )));
        }
        if count > f64::from(1 << 30) {
            return Err(Error::TooLarge {
                name: "mesh".into(),
                shape: elements.to_vec(),
                needed: format!("{count:.3e} elements"),
                available: "room for 2^30 elements".into(),
            });
        }
        let mut full = [1; 3];
        full[3 - dim..].copy_from_slice(elements);
        Ok(Self { elements: full, dim })
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

    /// How many elements a coarse element spans along z, y, x: an axis of one element
    /// is kept, since stretching it further would only skew its shape functions.
    pub(super) fn ratios(&self) -> [usize; 3] {
        self.elements.map(|n| if n > 1 { 2 } else { 1 })
    }

    /// The mesh of elements twice the size; the last of an odd number is half outside.
    pub(super) fn coarser(&self) -> Self {
        Self { elements: self.elements.map(|n| n.div_ceil(2)), dim: self.dim }
    }

    /// `[k, j, i]` of an element.
    pub(super) fn element(&self, index: usize) -> [usize; 3] {
        let [_, ny, nx] = self.elements;
        [index / (nx * ny), index / nx % ny, index % nx]
    }

    /// Flat index of an element, if it is inside.
    pub(super) fn element_index(&self, [k, j, i]: [usize; 3]) -> Option<usize> {
        let [nz, ny, nx] = self.elements;
        (k < nz && j < ny && i < nx).then_some((k * ny + j) * nx + i)
    }
}
