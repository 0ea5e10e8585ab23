//! How the nodes of a mesh lie in memory.

pub(super) use crate::fem::Lattice;
use std::ops::Range;

/// Most lanes of a vector unit (16 numbers of 4 bytes), and one more for neighbours: how
/// far a whole vector that begins in a row may reach beyond it.
pub(super) const SLACK: usize = 17;

/// Where node values lie: row after row and, within a row, component after component;
/// node i at place i + 1, so that its neighbours -1 and +1 are always there, and 0
/// beyond the ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    pub lattice: Lattice,
    pub components: usize,
    /// Places of one component of a row.
    pub stride: usize,
}

impl Layout {
    pub(super) fn new(lattice: Lattice, components: usize) -> Self {
        // Two ghosts, and rows that start at multiples of 32 bytes.
        let stride = (lattice.nodes()[2] + 2).next_multiple_of(8);
        Self { lattice, components, stride }
    }

    /// Node rows of a plane.
    pub(super) fn lines(&self) -> usize {
        self.lattice.nodes()[1]
    }

    /// Node rows of the lattice.
    pub(super) fn rows(&self) -> usize {
        self.lattice.nodes()[0] * self.lines()
    }

    /// Places of a row of all components.
    pub(super) fn row_len(&self) -> usize {
        self.components * self.stride
    }

    /// Places of a vector.
    pub(super) fn len(&self) -> usize {
        self.rows() * self.row_len() + SLACK
    }

    /// The nodes of one component of a row, within the row.
    pub(super) fn span(&self, component: usize) -> Range<usize> {
        let first = component * self.stride + 1;
        first..first + self.lattice.nodes()[2]
    }

    /// Places of one component of a work row, into which whole vectors are stored.
    pub(super) fn wide(&self) -> usize {
        self.stride + SLACK
    }

    /// Place of an unknown, as `(row, place in the row)`.
    pub(super) fn place(&self, unknown: usize) -> (usize, usize) {
        let (node, component) = (unknown / self.components, unknown % self.components);
        let nx = self.lattice.nodes()[2];
        (node / nx, component * self.stride + 1 + node % nx)
    }

    /// Number of unknowns.
    pub(super) fn unknowns(&self) -> usize {
        self.lattice.node_count() * self.components
    }
}
