//! Dense fields on uniform grids.

use crate::{Error, Grid, Result};
use ndarray::{Array3, ArrayD, ArrayView3};
use rayon::prelude::*;

/// A scalar field on the nodes of a [`Grid`], always row-major and contiguous.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    grid: Grid,
    values: Array3<f64>,
}

impl Field {
    /// `value` at every node.
    pub fn constant(grid: Grid, value: f64) -> Self {
        Self { grid, values: Array3::from_elem(grid.shape(), value) }
    }

    /// Samples `f([x, y, z])` at every node, rows in parallel.
    ///
    /// ```
    /// use solvers::{Field, Grid};
    /// let field = Field::from_fn(Grid::new(&[2, 3], 0.5)?, |[x, y, _]| 10.0 * y + x);
    /// assert_eq!(field.at(0, 1, 2), 6.0); // x = 1.0, y = 0.5
    /// # Ok::<(), solvers::Error>(())
    /// ```
    pub fn from_fn(grid: Grid, f: impl Fn([f64; 3]) -> f64 + Sync) -> Self {
        let mut field = Self::constant(grid, 0.0);
        let nx = grid.shape()[2];
        field.as_mut_slice().par_chunks_mut(nx).enumerate().for_each(|(row, values)| {
            for (i, value) in values.iter_mut().enumerate() {
                *value = f(grid.position(row * nx + i));
            }
        });
        field
    }

    /// Wraps row-major `values`.
    ///
    /// # Errors
    /// If their number is not that of the grid's nodes.
    pub fn from_vec(grid: Grid, values: Vec<f64>) -> Result<Self> {
        let count = values.len();
        let values = Array3::from_shape_vec(grid.shape(), values).map_err(|_| Error::Shape {
            name: "values".into(),
            actual: vec![count],
            expected: grid.axes().to_vec(),
        })?;
        Ok(Self { grid, values })
    }

    /// Takes an array of 1 to 3 axes as a field of node distance `spacing`.
    ///
    /// # Errors
    /// As [`Grid::new`].
    pub fn from_array(values: ArrayD<f64>, spacing: f64) -> Result<Self> {
        let grid = Grid::new(values.shape(), spacing)?;
        Self::from_vec(grid, values.iter().copied().collect())
    }

    /// The grid it lives on.
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// Value at node `(k, j, i)`; `k` is 0 in 2D.
    ///
    /// # Panics
    /// If the node lies outside the grid.
    pub fn at(&self, k: usize, j: usize, i: usize) -> f64 {
        self.values[[k, j, i]]
    }

    /// The values as an array of shape `[nz, ny, nx]`.
    pub fn view(&self) -> ArrayView3<'_, f64> {
        self.values.view()
    }

    /// All values, row-major.
    pub fn as_slice(&self) -> &[f64] {
        self.values.as_slice().unwrap_or_default()
    }

    /// All values, row-major, for writing.
    pub fn as_mut_slice(&mut self) -> &mut [f64] {
        self.values.as_slice_mut().unwrap_or_default()
    }

    /// Copies the values of `other`.
    ///
    /// # Panics
    /// If the shapes differ.
    pub fn copy_from(&mut self, other: &Self) {
        self.as_mut_slice().copy_from_slice(other.as_slice());
    }

    /// Least and greatest value, `(inf, -inf)` if every value is NaN.
    pub fn range(&self) -> (f64, f64) {
        let least_greatest = |values: &[f64]| {
            values
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)))
        };
        least_greatest(self.as_slice())
    }

    /// Mean and standard deviation; the same bytes for any number of threads.
    pub fn mean_std(&self) -> (f64, f64) {
        let n = self.as_slice().len() as f64;
        let mean = sum(self.as_slice(), |v| v) / n;
        (mean, (sum(self.as_slice(), |v| (v - mean) * (v - mean)) / n).sqrt())
    }

    /// Refuses NaN and infinities.
    ///
    /// # Errors
    /// [`Error::NotFinite`] with the first bad node.
    pub fn check_finite(&self, name: &str, t: f64) -> Result<()> {
        match self.as_slice().iter().position(|v| !v.is_finite()) {
            None => Ok(()),
            Some(n) => Err(Error::NotFinite {
                name: name.into(),
                value: self.as_slice()[n],
                t,
                node: self.grid.name_node(n),
            }),
        }
    }

    /// Refuses another shape than `grid`'s.
    ///
    /// # Errors
    /// [`Error::Shape`].
    pub fn check_shape(&self, name: &str, grid: Grid) -> Result<()> {
        if self.grid.axes() == grid.axes() {
            return Ok(());
        }
        Err(Error::Shape {
            name: name.into(),
            actual: self.grid.axes().to_vec(),
            expected: grid.axes().to_vec(),
        })
    }
}

/// Sum of `f(v)` in fixed chunks of 4096 and, within a chunk, 8 lanes: the same
/// bytes for 1 and N threads, whatever the width of the machine's vectors.
pub fn sum(values: &[f64], f: impl Fn(f64) -> f64 + Sync) -> f64 {
    let chunk_sum = |chunk: &[f64]| {
        let mut lanes = [0.0; 8];
        let mut groups = chunk.chunks_exact(8);
        for group in groups.by_ref() {
            for (lane, &v) in lanes.iter_mut().zip(group) {
                *lane += f(v);
            }
        }
        lanes.iter().sum::<f64>() + groups.remainder().iter().map(|&v| f(v)).sum::<f64>()
    };
    if values.len() <= 1 << 16 {
        return values.chunks(4096).map(chunk_sum).sum();
    }
    let partial: Vec<f64> = values.par_chunks(4096).map(chunk_sum).collect();
    partial.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_deviation_of_a_ramp() {
        let field = Field::from_fn(Grid::new(&[101], 1.0).unwrap(), |[x, _, _]| x);
        let (mean, std) = field.mean_std();
        assert!((mean - 50.0).abs() < 1e-12);
        assert!((std - (101.0_f64.powi(2) - 1.0).sqrt() / 12.0_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn first_bad_node_is_named() {
        let mut field = Field::constant(Grid::new(&[4, 5], 1.0).unwrap(), 0.0);
        field.as_mut_slice()[13] = f64::NAN;
        let message = field.check_finite("phi", 0.4).unwrap_err().to_string();
        assert!(
            message.starts_with("phi became NaN at t = 0.4 at node (j, i) = (2, 3)"),
            "{message}"
        );
    }
}
