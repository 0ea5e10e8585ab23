//! Anisotropic diffusion with non-negative weights: Selling's decomposition.

use crate::{Boundary, Error, Grid, Result};
use serde::{Deserialize, Serialize};

/// A symmetric, positive definite diffusion tensor (length^2/time); components of absent
/// axes are ignored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Tensor {
    /// Along x.
    pub xx: f64,
    /// Along y.
    pub yy: f64,
    /// Along z.
    pub zz: f64,
    /// Between x and y.
    pub xy: f64,
    /// Between x and z.
    pub xz: f64,
    /// Between y and z.
    pub yz: f64,
}

/// A bond of a node with the nodes at plus and minus this offset `[x, y, z]`.
pub(super) type Offset = ([i64; 3], f64);

/// Reductions that Selling's algorithm may take; their number grows like the logarithm
/// of the ratio of the tensor's eigenvalues, and this suffices for ratios beyond 1e12.
const MAX_REDUCTIONS: usize = 200;

impl Tensor {
    /// `along` in the direction `angle` (radians from the x axis towards y), `across`
    /// perpendicular to it, in two dimensions.
    pub fn rotated(along: f64, across: f64, angle: f64) -> Self {
        let (s, c) = angle.sin_cos();
        Self {
            xx: along * c * c + across * s * s,
            yy: along * s * s + across * c * c,
            zz: across,
            xy: (along - across) * s * c,
            ..Self::default()
        }
    }

    fn product(&self, a: [i64; 3], b: [i64; 3]) -> f64 {
        let [ax, ay, az] = a.map(|v| v as f64);
        let [bx, by, bz] = b.map(|v| v as f64);
        self.xx * ax * bx
            + self.yy * ay * by
            + self.zz * az * bz
            + self.xy * (ax * by + ay * bx)
            + self.xz * (ax * bz + az * bx)
            + self.yz * (ay * bz + az * by)
    }

    /// Offsets e and weights rho >= 0 with `D = sum rho e e^T`: at most 1, 3 or 6 of
    /// them in 1, 2 or 3 dimensions. Fehrenbach and Mirebeau 2014, section 2.
    pub(super) fn decompose(&self, dim: usize) -> Result<Vec<Offset>> {
        let minor = self.xx * self.yy - self.xy * self.xy;
        let determinant = self.zz * minor + 2.0 * self.xy * self.xz * self.yz
            - self.xx * self.yz * self.yz
            - self.yy * self.xz * self.xz;
        let minors = [self.xx, minor, determinant];
        if !minors[..dim].iter().all(|&m| m > 0.0 && m.is_finite()) {
            return Err(Error::Invalid(format!(
                "diffusion tensor {self:?} is not positive definite: its leading minors are {:?}",
                &minors[..dim]
            )));
        }
        let offsets = match dim {
            1 => vec![([1, 0, 0], self.xx)],
            2 => self.decompose_2d()?,
            _ => self.decompose_3d()?,
        };
        Ok(offsets.into_iter().filter(|&(_, weight)| weight > 0.0).collect())
    }

    fn decompose_2d(&self) -> Result<Vec<Offset>> {
        const TURNS: [[usize; 3]; 3] = [[0, 1, 2], [1, 2, 0], [2, 0, 1]];
        let mut e = [[1, 0, 0], [0, 1, 0], [-1, -1, 0]];
        let mut p = self.products(&e);
        for _ in 0..MAX_REDUCTIONS {
            let Some([i, j, k]) = TURNS.into_iter().find(|&[i, j, _]| p.of(i, j) > 0.0) else {
                let bond = |[i, j, k]: [usize; 3]| ([-e[k][1], e[k][0], 0], -p.of(i, j));
                return Ok(TURNS.map(bond).to_vec());
            };
            let sharp = p.of(i, j);
            p.set(i, j, -sharp);
            p.set(i, k, p.of(i, k) + 2.0 * sharp);
            p.set(j, k, p.of(j, k) + 2.0 * sharp);
            (e[i], e[k]) = (e[i].map(|v| -v), combine(e[i], e[j], -1));
        }
        Err(self.too_anisotropic())
    }

    fn decompose_3d(&self) -> Result<Vec<Offset>> {
        const PAIRS: [[usize; 4]; 6] =
            [[0, 1, 2, 3], [0, 2, 1, 3], [0, 3, 1, 2], [1, 2, 0, 3], [1, 3, 0, 2], [2, 3, 0, 1]];
        let mut e = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, -1, -1]];
        let mut p = self.products(&e);
        for _ in 0..MAX_REDUCTIONS {
            let Some([i, j, k, l]) = PAIRS.into_iter().find(|&[i, j, ..]| p.of(i, j) > 0.0) else {
                let bond = |[i, j, k, l]: [usize; 4]| (cross(e[k], e[l]), -p.of(i, j));
                return Ok(PAIRS.map(bond).to_vec());
            };
            let (sharp, ik, il) = (p.of(i, j), p.of(i, k), p.of(i, l));
            p.set(i, j, -sharp);
            p.set(i, k, sharp + il);
            p.set(i, l, sharp + ik);
            p.set(j, k, p.of(j, k) + sharp);
            p.set(j, l, p.of(j, l) + sharp);
            p.set(k, l, p.of(k, l) - sharp);
            (e[k], e[l]) = (combine(e[k], e[i], 1), combine(e[l], e[i], 1));
            e[i] = e[i].map(|v| -v);
        }
        Err(self.too_anisotropic())
    }

    /// Products of the vectors of a first superbase.
    fn products<const N: usize>(&self, e: &[[i64; 3]; N]) -> Products<N> {
        Products(e.map(|a| e.map(|b| self.product(a, b))))
    }

    fn too_anisotropic(&self) -> Error {
        Error::Invalid(format!("diffusion tensor {self:?} is too anisotropic for a grid stencil"))
    }
}

/// Products `e_i . D e_j` of a superbase. They follow its reductions, because the vectors
/// grow long where the tensor is narrow: computed from these, small ones would cancel.
struct Products<const N: usize>([[f64; N]; N]);

impl<const N: usize> Products<N> {
    fn of(&self, i: usize, j: usize) -> f64 {
        self.0[i][j]
    }

    fn set(&mut self, i: usize, j: usize, value: f64) {
        (self.0[i][j], self.0[j][i]) = (value, value);
    }
}

/// `a + sign b`.
fn combine(a: [i64; 3], b: [i64; 3], sign: i64) -> [i64; 3] {
    [0, 1, 2].map(|axis| a[axis] + sign * b[axis])
}

fn cross(a: [i64; 3], b: [i64; 3]) -> [i64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Bonds `(node, neighbour, weight)` of the discrete energy
/// `1/2 sum_x sum_e rho_e(x)/2 [(u(x + e h) - u(x))^2 + (u(x) - u(x - e h))^2] / h^2`;
/// bonds that leave a Neumann grid are mirrored back into it. (Left out, they would leave
/// corner nodes without any bond when all offsets are slanted.)
pub(super) fn bonds(
    grid: Grid,
    boundary: Boundary,
    tensors: &[Tensor],
) -> Result<Vec<(usize, usize, f64)>> {
    let mut bonds = Vec::new();
    let mut offsets = Vec::new();
    let half = 0.5 / grid.spacing().powi(2);
    for index in 0..grid.len() {
        if index < tensors.len() {
            offsets = tensors[index].decompose(grid.dim()).map_err(|error| {
                Error::Invalid(format!("at node {}: {error}", grid.name_node(index)))
            })?;
        }
        for &(offset, weight) in &offsets {
            for sign in [1, -1] {
                let other = neighbour(grid, boundary, index, offset.map(|e| sign * e));
                if other != index {
                    bonds.push((index.max(other), index.min(other), half * weight));
                }
            }
        }
    }
    Ok(bonds)
}

fn neighbour(grid: Grid, boundary: Boundary, index: usize, [x, y, z]: [i64; 3]) -> usize {
    let (node, shape, step) = (grid.node(index), grid.shape(), [z, y, x]);
    let at = |axis: usize| boundary.wrap(node[axis] as isize + step[axis] as isize, shape[axis]);
    grid.index(at(0), at(1), at(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// D = sum rho e e^T with rho >= 0, for tensors of any direction and ratios to 1e4.
        #[test]
        fn weights_are_not_negative_and_rebuild_the_tensor(
            q in prop::array::uniform3(prop::array::uniform3(-1.0..1.0_f64)),
            dim in 1_usize..=3,
        ) {
            let dot = |a: usize, b: usize| (0..3).map(|m| q[a][m] * q[b][m]).sum::<f64>();
            let d = Tensor {
                xx: dot(0, 0) + 1e-4, yy: dot(1, 1) + 1e-4, zz: dot(2, 2) + 1e-4,
                xy: dot(0, 1), xz: dot(0, 2), yz: dot(1, 2),
            };
            let offsets = d.decompose(dim).unwrap();
            prop_assert!(offsets.len() <= [1, 3, 6][dim - 1]);
            let sum = |a: usize, b: usize| offsets.iter()
                .map(|(e, w)| w * (e[a] * e[b]) as f64).sum::<f64>();
            let wanted = [(0, 0, d.xx), (1, 1, d.yy), (0, 1, d.xy), (2, 2, d.zz), (0, 2, d.xz), (1, 2, d.yz)];
            for &(a, b, value) in &wanted[..[1, 3, 6][dim - 1]] {
                // A weight is exact but for round-offs of the tensor's size, a few a reduction.
                let size = d.xx + d.yy + d.zz;
                let reach = offsets.iter().map(|(e, _)| (e[a] * e[b]).abs()).sum::<i64>() as f64;
                let bound = 2e-15 * size * (1.0 + reach);
                prop_assert!((sum(a, b) - value).abs() < bound, "{} {value} {bound}", sum(a, b));
            }
            prop_assert!(offsets.iter().all(|&(_, w)| w > 0.0));
        }
    }

    /// Computed from the long vectors of its superbase, the products of this one left 1.3e-11.
    #[test]
    fn a_narrow_tensor_is_rebuilt_to_round_off() {
        let q: [[f64; 3]; 3] = [
            [-0.8242222639152028, -0.7618097414235061, -0.079014534872331],
            [-0.15559562882420835, -0.7563076551015832, -0.11261966000230306],
            [0.878275254469841, 0.8180780979664294, 0.08200929463358768],
        ];
        let dot = |a: usize, b: usize| (0..3).map(|m| q[a][m] * q[b][m]).sum::<f64>();
        let tensor = Tensor {
            xx: dot(0, 0) + 1e-4,
            yy: dot(1, 1) + 1e-4,
            zz: dot(2, 2) + 1e-4,
            xy: dot(0, 1),
            xz: dot(0, 2),
            yz: dot(1, 2),
        };
        let offsets = tensor.decompose(3).unwrap();
        for (axis, value) in [tensor.xx, tensor.yy, tensor.zz].into_iter().enumerate() {
            let sum = offsets.iter().map(|(e, w)| w * (e[axis] * e[axis]) as f64).sum::<f64>();
            assert!((sum - value).abs() < 1e-12, "{sum} {value}");
        }
    }

    #[test]
    fn a_tensor_that_is_not_positive_definite_is_refused() {
        let tensor = Tensor { xx: 1.0, yy: 1.0, xy: 1.5, ..Tensor::default() };
        let message = tensor.decompose(2).unwrap_err().to_string();
        assert!(message.contains("leading minors are [1.0, -1.25]"), "{message}");
    }
}
