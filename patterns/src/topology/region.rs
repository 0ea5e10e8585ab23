//! Where a load, a support or a region of fixed material lies.

use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use solvers::fem::Lattice;

/// A side of the box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// First column.
    Left,
    /// Last column.
    Right,
    /// First row.
    Top,
    /// Last row.
    Bottom,
    /// First plane.
    Front,
    /// Last plane.
    Back,
}

/// Nodes of the mesh: exactly one key is given.
#[derive(Clone, Debug, Default)]
pub(super) struct Place<'a> {
    /// Key of the configuration, for messages.
    pub(super) key: String,
    /// Column and row (and plane), from 1; row 1 is at the top.
    pub(super) node: Option<&'a Vec<usize>>,
    /// First and last node of a line, rectangle or box of nodes, from 1.
    pub(super) nodes: Option<&'a [Vec<usize>; 2]>,
    /// All nodes of a side.
    pub(super) edge: Option<Side>,
    /// Nodes in a box of space, `[[x, y], [x, y]]` in elements from the upper left corner.
    pub(super) area: Option<&'a [Vec<f64>; 2]>,
}

/// A box of nodes: first and last column, row and plane, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct NodeBox {
    low: [usize; 3],
    high: [usize; 3],
}

impl Place<'_> {
    /// The nodes, checked against the mesh.
    pub(super) fn find(&self, lattice: Lattice) -> Result<NodeBox> {
        let given =
            [self.node.is_some(), self.nodes.is_some(), self.edge.is_some(), self.area.is_some()];
        if given.iter().filter(|&&g| g).count() != 1 {
            let reason = "give exactly one of `node`, `nodes`, `edge` and `box`";
            return Err(Error::config(&self.key, reason));
        }
        let [nz, ny, nx] = lattice.nodes();
        let last = [nx - 1, ny - 1, nz - 1];
        if let Some(node) = self.node {
            let at = self.node_at("node", node, lattice)?;
            return Ok(NodeBox { low: at, high: at });
        }
        if let Some([a, b]) = self.nodes {
            let (a, b) = (self.node_at("nodes", a, lattice)?, self.node_at("nodes", b, lattice)?);
            let low = std::array::from_fn(|n| a[n].min(b[n]));
            return Ok(NodeBox { low, high: std::array::from_fn(|n| a[n].max(b[n])) });
        }
        if let Some(side) = self.edge {
            let (mut low, mut high) = ([0; 3], last);
            let (axis, far) = match side {
                Side::Left => (0, false),
                Side::Right => (0, true),
                Side::Top => (1, false),
                Side::Bottom => (1, true),
                Side::Front => (2, false),
                Side::Back => (2, true),
            };
            if axis >= lattice.dim() {
                let key = format!("{}.edge", self.key);
                return Err(Error::config(&key, "a plane problem has no front and no back"));
            }
            if far {
                low[axis] = last[axis]
            } else {
                high[axis] = 0
            }
            return Ok(NodeBox { low, high });
        }
        self.nodes_in_area(lattice, last)
    }

    /// A node by its numbers from 1.
    fn node_at(&self, name: &str, node: &[usize], lattice: Lattice) -> Result<[usize; 3]> {
        let key = format!("{}.{name}", self.key);
        let [nz, ny, nx] = lattice.nodes();
        if node.len() != lattice.dim() {
            let reason = format!("{node:?} should have {} numbers", lattice.dim());
            return Err(Error::config(&key, reason));
        }
        let counts = [nx, ny, nz];
        if node.iter().zip(counts).any(|(&n, count)| n == 0 || n > count) {
            let reason = format!(
                "node {node:?} lies outside the mesh, whose nodes are 1 to {:?}",
                &counts[..lattice.dim()]
            );
            return Err(Error::config(&key, reason));
        }
        Ok([node[0] - 1, node[1] - 1, node.get(2).map_or(0, |n| n - 1)])
    }

    fn nodes_in_area(&self, lattice: Lattice, last: [usize; 3]) -> Result<NodeBox> {
        let key = format!("{}.box", self.key);
        let (mut low, mut high) = ([0; 3], [0; 3]);
        let [a, b] = self.area.ok_or_else(|| Error::config(&key, "missing"))?;
        for axis in 0..lattice.dim() {
            let (Some(&p), Some(&q)) = (a.get(axis), b.get(axis)) else {
                let reason = format!("its corners should have {} numbers", lattice.dim());
                return Err(Error::config(&key, reason));
            };
            let (p, q) = (p.min(q).ceil().max(0.0), p.max(q).floor().min(last[axis] as f64));
            if p.is_nan() || q.is_nan() || p > q {
                let reason = format!("no node lies in {a:?} to {b:?}");
                return Err(Error::config(&key, reason));
            }
            (low[axis], high[axis]) = (p as usize, q as usize);
        }
        Ok(NodeBox { low, high })
    }
}

impl NodeBox {
    /// Each node with its share of a load that is spread evenly over the box: half
    /// shares at the ends of a line, so that a uniform traction is met.
    pub(super) fn shares(self, lattice: Lattice) -> Vec<(usize, f64)> {
        let mut shares = Vec::new();
        for k in self.low[2]..=self.high[2] {
            for j in self.low[1]..=self.high[1] {
                for i in self.low[0]..=self.high[0] {
                    let at = [i, j, k];
                    let share = (0..3).map(|axis| {
                        let (low, high) = (self.low[axis], self.high[axis]);
                        if low == high {
                            return 1.0;
                        }
                        let end = at[axis] == low || at[axis] == high;
                        (if end { 0.5 } else { 1.0 }) / (high - low) as f64
                    });
                    shares.push((lattice.node(at), share.product()));
                }
            }
        }
        shares
    }

    /// The nodes.
    pub(super) fn nodes(self, lattice: Lattice) -> impl Iterator<Item = usize> {
        self.shares(lattice).into_iter().map(|(node, _)| node)
    }
}
