//! The operator `A u = div(D grad u)` on a grid.

use super::operator_tensor::{Tensor, bonds};
use crate::sparse::SymmetricMatrix;
use crate::{Boundary, Error, Field, Grid, Result};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Diffusion coefficient of a species (length^2/time).
#[derive(Clone, Debug, PartialEq)]
pub enum Diffusivity {
    /// The same everywhere, at least 0.
    Constant(f64),
    /// One value >= 0 per node.
    Map {
        /// The values.
        values: Field,
        /// Value on the face between two cells.
        mean: FaceMean,
    },
    /// A tensor for all nodes, or one per node.
    Tensor(Vec<Tensor>),
}

/// Diffusion coefficient on the face between two cells.
///
/// Both are of second order where D is smooth. Across a jump only the harmonic mean is
/// right: the flux through two half cells in series is `2 ab/(a + b)` times the difference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FaceMean {
    /// `2 ab/(a + b)`, 0 next to a cell with D = 0.
    #[default]
    Harmonic,
    /// `(a + b)/2`.
    Arithmetic,
}

/// `A u = div(D grad u)`, as bonds between nodes: `(A u)_i = sum_j w_ij (u_j - u_i)` with
/// `w_ij = w_ji >= 0`. So A is symmetric, its rows sum to 0, what leaves a node
/// arrives at another, and forward Euler with `dt <= 1 /` [`Operator::max_rate`] makes
/// no new extrema.
///
/// Scalar D: face fluxes of second order. Tensors: the six or twelve neighbours of
/// Fehrenbach and Mirebeau 2014 ("Sparse non-negative stencils for anisotropic
/// diffusion"), which reach about sqrt(ratio of the eigenvalues) nodes far; of second
/// order inside and on periodic grids. At a Neumann border bonds that leave the grid
/// are mirrored, which changes a layer of one stencil's width: first order there,
/// unless the tensor's axes are the grid's.
#[derive(Clone, Debug)]
pub struct Operator {
    grid: Grid,
    boundary: Boundary,
    weights: Weights,
}

#[derive(Clone, Debug)]
enum Weights {
    /// Along z, y, x: weight of the face between a node and the next one, the last node's
    /// next being the first; 0 there on a Neumann grid. Empty for absent axes.
    Faces([Vec<f64>; 3]),
    /// Neighbours of node i stand at `offsets[i]..offsets[i + 1]`.
    Sparse { offsets: Vec<usize>, neighbours: Vec<usize>, weights: Vec<f64> },
}

impl Operator {
    /// Sets up the operator on `grid`.
    ///
    /// # Errors
    /// If D is negative, not finite or of another shape, a tensor is not positive
    /// definite, or the boundary is extrapolated.
    pub fn new(grid: Grid, boundary: Boundary, diffusivity: &Diffusivity) -> Result<Self> {
        if boundary == Boundary::Extrapolate {
            return Err(Error::Invalid(
                "diffusion needs a periodic or Neumann boundary, not extrapolation".into(),
            ));
        }
        let weights = match diffusivity {
            Diffusivity::Constant(d) => {
                check_diffusivity(*d)?;
                faces(grid, boundary, |_, _| *d)
            }
            Diffusivity::Map { values, mean } => {
                values.check_shape("diffusivity", grid)?;
                let d = values.as_slice();
                d.iter().try_for_each(|&d| check_diffusivity(d))?;
                faces(grid, boundary, |a, b| mean.of(d[a], d[b]))
            }
            Diffusivity::Tensor(tensors) => {
                if tensors.len() != 1 && tensors.len() != grid.len() {
                    return Err(Error::Shape {
                        name: "diffusion tensors".into(),
                        actual: vec![tensors.len()],
                        expected: grid.axes().to_vec(),
                    });
                }
                sparse_weights(grid, bonds(grid, boundary, tensors)?)?
            }
        };
        Ok(Self { grid, boundary, weights })
    }

    /// Writes `A u` into `out`, rows in parallel.
    ///
    /// # Panics
    /// If a length is not the grid's.
    pub fn apply(&self, u: &[f64], out: &mut [f64]) {
        assert_eq!((u.len(), out.len()), (self.grid.len(), self.grid.len()), "length of a field");
        let nx = self.grid.shape()[2];
        let rows = (4096 / nx).max(1);
        let arch = pulp::Arch::new();
        out.par_chunks_mut(nx * rows).enumerate().for_each(|(chunk, out)| match &self.weights {
            Weights::Faces(faces) => {
                for (row, out) in out.chunks_mut(nx).enumerate() {
                    let row = Row::new(self.grid, faces, u, chunk * rows + row);
                    arch.dispatch(|| row.apply(out));
                }
            }
            Weights::Sparse { offsets, neighbours, weights } => {
                for (n, out) in out.iter_mut().enumerate() {
                    let index = chunk * rows * nx + n;
                    let span = offsets[index]..offsets[index + 1];
                    *out = (neighbours[span.clone()].iter().zip(&weights[span]))
                        .map(|(&other, w)| w * (u[other] - u[index]))
                        .sum();
                }
            }
        });
    }

    /// Bound on the largest |eigenvalue| of A (1/time), twice the greatest sum of a
    /// node's weights (Gershgorin): forward Euler is stable for `dt <= 2 / max_rate`.
    pub fn max_rate(&self) -> f64 {
        let mut sums = vec![0.0; self.grid.len()];
        for (i, j, weight) in self.bonds() {
            sums[i] += weight;
            sums[j] += weight;
        }
        2.0 * sums.into_iter().fold(0.0, f64::max)
    }

    /// The matrix `identity I + scale A`.
    ///
    /// # Errors
    /// Never for a valid operator; as [`SymmetricMatrix::from_triplets`].
    pub fn matrix(&self, identity: f64, scale: f64) -> Result<SymmetricMatrix> {
        let diagonal = (0..self.grid.len()).map(|i| (i, i, identity));
        let bonds = self.bonds().into_iter().flat_map(|(i, j, weight)| {
            let w = scale * weight;
            [(i.max(j), i.min(j), w), (i, i, -w), (j, j, -w)]
        });
        SymmetricMatrix::from_triplets(self.grid.len(), diagonal.chain(bonds))
    }

    /// The grid.
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// What stands beyond the border.
    pub fn boundary(&self) -> Boundary {
        self.boundary
    }

    /// Pairs of different nodes with their weight; a pair may occur twice.
    fn bonds(&self) -> Vec<(usize, usize, f64)> {
        let mut bonds = Vec::new();
        match &self.weights {
            Weights::Faces(faces) => {
                for (axis, faces) in faces.iter().enumerate() {
                    for (i, &weight) in faces.iter().enumerate() {
                        let j = next(self.grid, axis, i);
                        if weight != 0.0 && i != j {
                            bonds.push((i, j, weight));
                        }
                    }
                }
            }
            Weights::Sparse { offsets, neighbours, weights } => {
                for (i, span) in offsets.windows(2).enumerate() {
                    let row = neighbours[span[0]..span[1]].iter().zip(&weights[span[0]..span[1]]);
                    bonds.extend(row.filter(|&(&j, _)| j < i).map(|(&j, &w)| (i, j, w)));
                }
            }
        }
        bonds
    }
}

impl FaceMean {
    fn of(self, a: f64, b: f64) -> f64 {
        match self {
            Self::Harmonic if a == 0.0 || b == 0.0 => 0.0,
            Self::Harmonic => 2.0 / (1.0 / a + 1.0 / b),
            Self::Arithmetic => 0.5 * (a + b),
        }
    }
}

fn check_diffusivity(d: f64) -> Result<()> {
    if d >= 0.0 && d.is_finite() {
        return Ok(());
    }
    Err(Error::out_of_range("diffusivity", d, "[0, inf)"))
}

/// The node after `index` along an axis (0 is z), the first one after the last.
fn next(grid: Grid, axis: usize, index: usize) -> usize {
    let (n, stride) = (grid.shape()[axis], grid.strides()[axis]);
    if grid.node(index)[axis] + 1 == n { index + stride - n * stride } else { index + stride }
}

fn faces(grid: Grid, boundary: Boundary, d: impl Fn(usize, usize) -> f64 + Sync) -> Weights {
    let unit = grid.spacing().powi(-2);
    let along = |axis: usize| {
        let n = grid.shape()[axis];
        if n == 1 {
            return Vec::new();
        }
        let weight = |index: usize| {
            let border = boundary == Boundary::Neumann && grid.node(index)[axis] + 1 == n;
            if border { 0.0 } else { unit * d(index, next(grid, axis, index)) }
        };
        (0..grid.len()).into_par_iter().map(weight).collect()
    };
    Weights::Faces([along(0), along(1), along(2)])
}

/// Sums the weights of equal pairs and lists each node's neighbours.
fn sparse_weights(grid: Grid, bonds: Vec<(usize, usize, f64)>) -> Result<Weights> {
    let lower = SymmetricMatrix::from_triplets(grid.len(), bonds)?;
    let mut offsets = vec![0; grid.len() + 1];
    let entries = || {
        (lower.offsets().windows(2).enumerate())
            .flat_map(|(j, span)| (span[0]..span[1]).map(move |entry| (entry, j)))
    };
    for (entry, j) in entries() {
        offsets[lower.rows()[entry] + 1] += 1;
        offsets[j + 1] += 1;
    }
    for i in 0..grid.len() {
        offsets[i + 1] += offsets[i];
    }
    let mut end = offsets.clone();
    let mut neighbours = vec![0; offsets[grid.len()]];
    let mut weights = vec![0.0; offsets[grid.len()]];
    for (entry, j) in entries() {
        let (i, weight) = (lower.rows()[entry], lower.values()[entry]);
        for (node, other) in [(i, j), (j, i)] {
            (neighbours[end[node]], weights[end[node]]) = (other, weight);
            end[node] += 1;
        }
    }
    Ok(Weights::Sparse { offsets, neighbours, weights })
}

/// A row of nodes with the rows beside it and the weights of its faces.
struct Row<'a> {
    u: &'a [f64],
    x: &'a [f64],
    /// Along z and y: weights and values behind, weights and values ahead.
    beside: [Option<[&'a [f64]; 4]>; 2],
}

impl<'a> Row<'a> {
    /// The neighbours wrap around; on a Neumann grid the weight there is 0.
    fn new(grid: Grid, faces: &'a [Vec<f64>; 3], u: &'a [f64], row: usize) -> Self {
        let [nz, ny, nx] = grid.shape();
        let (k, j) = (row / ny, row % ny);
        let span = |k: usize, j: usize| (k * ny + j) * nx..(k * ny + j + 1) * nx;
        let beside = |axis: usize, behind: (usize, usize), ahead: (usize, usize)| {
            let (behind, here, ahead) =
                (span(behind.0, behind.1), span(k, j), span(ahead.0, ahead.1));
            let w = &faces[axis];
            (!w.is_empty()).then(|| [&w[behind.clone()], &u[behind], &w[here], &u[ahead]])
        };
        let z = beside(0, ((k + nz - 1) % nz, j), ((k + 1) % nz, j));
        let y = beside(1, (k, (j + ny - 1) % ny), (k, (j + 1) % ny));
        let x = if faces[2].is_empty() { &[][..] } else { &faces[2][span(k, j)] };
        Self { u: &u[span(k, j)], x, beside: [z, y] }
    }

    #[inline(always)]
    fn apply(&self, out: &mut [f64]) {
        let (u, n) = (self.u, out.len());
        if self.x.is_empty() {
            out.fill(0.0);
        } else {
            let x = &self.x[..n];
            out[0] = x[0] * (u[1] - u[0]) - x[n - 1] * (u[0] - u[n - 1]);
            out[n - 1] = x[n - 1] * (u[0] - u[n - 1]) - x[n - 2] * (u[n - 1] - u[n - 2]);
            let middle = out[1..n - 1].iter_mut().zip(u.windows(3)).zip(x.windows(2));
            for ((out, u), x) in middle {
                *out = x[1] * (u[2] - u[1]) - x[0] * (u[1] - u[0]);
            }
        }
        for &[w_behind, behind, w_ahead, ahead] in self.beside.iter().flatten() {
            let sides = w_behind.iter().zip(behind).zip(w_ahead.iter().zip(ahead));
            for ((out, &u), ((w0, u0), (w1, u1))) in out.iter_mut().zip(u).zip(sides) {
                *out += w1 * (u1 - u) - w0 * (u - u0);
            }
        }
    }
}
