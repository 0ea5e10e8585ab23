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
        let mut e = [[1, 0, 0], [0, 1, 0], [-1, -1, 0]];
        for _ in 0..MAX_REDUCTIONS {
            let sharp = [(0, 1, 2), (1, 2, 0), (2, 0, 1)]
                .into_iter()
                .find(|&(i, j, _)| self.product(e[i], e[j]) > 0.0);
            let Some((i, j, k)) = sharp else {
                return Ok([(0, 1, 2), (1, 2, 0), (2, 0, 1)]
                    .map(|(i, j, k)| ([-e[k][1], e[k][0], 0], -self.product(e[i], e[j])))
                    .to_vec());
            };
            (e[i], e[k]) = (e[i].map(|v| -v), combine(e[i], e[j], -1));
        }
        Err(self.too_anisotropic())
    }

    fn decompose_3d(&self) -> Result<Vec<Offset>> {
        const PAIRS: [[usize; 4]; 6] =
            [[0, 1, 2, 3], [0, 2, 1, 3], [0, 3, 1, 2], [1, 2, 0, 3], [1, 3, 0, 2], [2, 3, 0, 1]];
        let mut e = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, -1, -1]];
        for _ in 0..MAX_REDUCTIONS {
            let sharp = PAIRS.into_iter().find(|&[i, j, ..]| self.product(e[i], e[j]) > 0.0);
            let Some([i, _, k, l]) = sharp else {
                return Ok(PAIRS
                    .map(|[i, j, k, l]| (cross(e[k], e[l]), -self.product(e[i], e[j])))
                    .to_vec());
            };
            (e[k], e[l]) = (combine(e[k], e[i], 1), combine(e[l], e[i], 1));
            e[i] = e[i].map(|v| -v);
        }
        Err(self.too_anisotropic())
    }

    fn too_anisotropic(&self) -> Error {
        Error::Invalid(format!("diffusion tensor {self:?} is too anisotropic for a grid stencil"))
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
                // Offsets are up to 1e2 long, so products cancel to 1e4 round-offs.
                prop_assert!((sum(a, b) - value).abs() < 1e-11, "{} {value}", sum(a, b));
            }
            prop_assert!(offsets.iter().all(|&(_, w)| w > 0.0));
        }
    }

    #[test]
    fn a_tensor_that_is_not_positive_definite_is_refused() {
        let tensor = Tensor { xx: 1.0, yy: 1.0, xy: 1.5, ..Tensor::default() };
        let message = tensor.decompose(2).unwrap_err().to_string();
        assert!(message.contains("leading minors are [1.0, -1.25]"), "{message}");
    }
}
