//! Uniform grids of one, two or three axes.

use crate::{Error, Result};

/// A uniform grid; nodes are cell centres, `spacing` apart along every axis.
///
/// Shapes are `[nz, ny, nx]`; an absent leading axis has size 1, so that one
/// source serves 1D, 2D and 3D.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    shape: [usize; 3],
    dim: usize,
    spacing: f64,
}

impl Grid {
    /// A grid of `shape` (`[nx]`, `[ny, nx]` or `[nz, ny, nx]`) and node distance `spacing` (length).
    ///
    /// # Errors
    /// Unless there are 1 to 3 axes of at least one node each, no more than 2^40
    /// nodes, and a positive finite spacing.
    pub fn new(shape: &[usize], spacing: f64) -> Result<Self> {
        if shape.is_empty() || shape.len() > 3 {
            return Err(Error::out_of_range("number of axes", shape.len() as f64, "[1, 3]"));
        }
        if !(spacing > 0.0 && spacing.is_finite()) {
            return Err(Error::out_of_range("spacing", spacing, "(0, inf)"));
        }
        let mut full = [1; 3];
        full[3 - shape.len()..].copy_from_slice(shape);
        let nodes = full.iter().try_fold(1_usize, |n, &m| n.checked_mul(m));
        match nodes {
            Some(0) => Err(Error::Invalid(format!(
                "shape {shape:?} has an axis of 0 nodes, expected at least 1"
            ))),
            Some(n) if n <= 1 << 40 => Ok(Self { shape: full, dim: shape.len(), spacing }),
            _ => Err(Error::TooLarge {
                name: "grid".into(),
                shape: shape.to_vec(),
                needed: format!(
                    "{:.0} GiB a field",
                    shape.iter().map(|&n| n as f64).product::<f64>() * 8.0 / 1024.0_f64.powi(3)
                ),
                available: "an address space of 2^40 nodes".into(),
            }),
        }
    }

    /// Number of axes, 1 to 3.
    pub fn dim(&self) -> usize {
        self.dim
    }

    /// Shape `[nz, ny, nx]`; absent axes have size 1.
    pub fn shape(&self) -> [usize; 3] {
        self.shape
    }

    /// Shape without the absent axes: `[nx]`, `[ny, nx]` or `[nz, ny, nx]`.
    pub fn axes(&self) -> &[usize] {
        &self.shape[3 - self.dim..]
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.shape.iter().product()
    }

    /// Whether there is no node; never true.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Node distance (length).
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// Distance in memory between neighbours along z, y, x.
    pub fn strides(&self) -> [usize; 3] {
        [self.shape[1] * self.shape[2], self.shape[2], 1]
    }

    /// Flat index of node `(k, j, i)`.
    pub fn index(&self, k: usize, j: usize, i: usize) -> usize {
        (k * self.shape[1] + j) * self.shape[2] + i
    }

    /// `(k, j, i)` of a flat index.
    pub fn node(&self, index: usize) -> [usize; 3] {
        let [_, ny, nx] = self.shape;
        [index / (nx * ny), index / nx % ny, index % nx]
    }

    /// Position `[x, y, z]` (length) of a flat index.
    pub fn position(&self, index: usize) -> [f64; 3] {
        let [k, j, i] = self.node(index);
        [i as f64 * self.spacing, j as f64 * self.spacing, k as f64 * self.spacing]
    }

    /// Position `[x, y, z]` of the middle of the grid.
    pub fn center(&self) -> [f64; 3] {
        let [nz, ny, nx] = self.shape;
        [nx, ny, nz].map(|n| (n - 1) as f64 * 0.5 * self.spacing)
    }

    /// A node as people write it: `i = 3`, `(j, i) = (2, 3)` or `(k, j, i) = (1, 2, 3)`.
    pub fn name_node(&self, index: usize) -> String {
        let [k, j, i] = self.node(index);
        match self.dim {
            1 => format!("i = {i}"),
            2 => format!("(j, i) = ({j}, {i})"),
            _ => format!("(k, j, i) = ({k}, {j}, {i})"),
        }
    }

    /// Volume of a cell, `h^dim`.
    pub fn cell_volume(&self) -> f64 {
        self.spacing.powi(self.dim as i32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn node_and_index_are_inverse() {
        let grid = Grid::new(&[3, 4, 5], 0.5).unwrap();
        for n in 0..grid.len() {
            let [k, j, i] = grid.node(n);
            assert_eq!(grid.index(k, j, i), n);
        }
        assert_eq!(grid.position(grid.index(1, 2, 3)), [1.5, 1.0, 0.5]);
        assert_eq!(Grid::new(&[4, 5], 1.0).unwrap().shape(), [1, 4, 5]);
    }

    #[test]
    fn impossible_shapes_are_refused_with_their_numbers() {
        assert!(Grid::new(&[0, 5], 1.0).unwrap_err().to_string().contains("axis of 0 nodes"));
        let huge = Grid::new(&[1_000_000, 1_000_000, 1_000_000], 1.0).unwrap_err().to_string();
        assert!(huge.contains("8.000e18 bytes"), "{huge}");
        assert!(Grid::new(&[4], -1.0).unwrap_err().to_string().contains("spacing = -1"));
    }
}
