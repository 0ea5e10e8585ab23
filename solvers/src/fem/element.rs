//! The one element matrix: bilinear squares, trilinear cubes.

use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// What is assumed across the plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PlaneState {
    /// No stress across: a thin plate.
    #[default]
    PlaneStress,
    /// No strain across: a slice of a long body.
    PlaneStrain,
}

/// An isotropic elastic material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elastic {
    /// Young's modulus E (force/length^2), above 0.
    pub youngs_modulus: f64,
    /// Poisson's ratio nu (1), in (-1, 1/2).
    pub poisson_ratio: f64,
    /// Ignored in space.
    pub plane: PlaneState,
}

/// The matrix of one element of edge 1 (and thickness 1) and stiffness 1, and the
/// strains at its middle.
#[derive(Clone, Debug, PartialEq)]
pub struct Element {
    dim: usize,
    components: usize,
    stiffness: Vec<f64>,
    /// Rows: strains `xx, yy, xy` or `xx, yy, zz, yz, xz, xy`; or the gradient.
    strain: Vec<f64>,
    /// Strains to stresses.
    law: Vec<f64>,
}

impl Element {
    /// An elastic element in `dim` 2 or 3: `K_e = int B^T D B`.
    ///
    /// # Errors
    /// If a constant is out of its range.
    pub fn elastic(dim: usize, material: Elastic) -> Result<Self> {
        let Elastic { youngs_modulus: e, poisson_ratio: nu, plane } = material;
        if !(e > 0.0 && e.is_finite()) {
            return Err(Error::out_of_range("youngs_modulus", e, "(0, inf)"));
        }
        if !(nu > -1.0 && nu < 0.5) {
            return Err(Error::out_of_range("poisson_ratio", nu, "(-1, 0.5)"));
        }
        let shear = e / (2.0 * (1.0 + nu));
        let (normal, cross) = match (dim, plane) {
            (2, PlaneState::PlaneStress) => (e / (1.0 - nu * nu), nu * e / (1.0 - nu * nu)),
            _ => {
                let lame = e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
                (lame + 2.0 * shear, lame)
            }
        };
        let rows = if dim == 2 { 3 } else { 6 };
        let mut law = vec![0.0; rows * rows];
        for r in 0..rows {
            for c in 0..dim.min(if r < dim { dim } else { 0 }) {
                law[r * rows + c] = if r == c { normal } else { cross };
            }
            if r >= dim {
                law[r * rows + r] = shear;
            }
        }
        Ok(Self::integrate(dim, dim, law))
    }

    /// A heat-conducting element in `dim` 2 or 3: `K_e = conductivity int grad N . grad N`.
    ///
    /// # Errors
    /// Unless the conductivity is positive.
    pub fn conducting(dim: usize, conductivity: f64) -> Result<Self> {
        if !(conductivity > 0.0 && conductivity.is_finite()) {
            return Err(Error::out_of_range("conductivity", conductivity, "(0, inf)"));
        }
        let mut law = vec![0.0; dim * dim];
        (0..dim).for_each(|n| law[n * dim + n] = conductivity);
        Ok(Self::integrate(dim, 1, law))
    }

    /// The element of `-length^2 lap u + u` in `dim` 2 or 3, with the consistent mass matrix.
    ///
    /// # Errors
    /// Unless the length is positive.
    pub fn screened_poisson(dim: usize, length: f64) -> Result<Self> {
        if !(length > 0.0 && length.is_finite()) {
            return Err(Error::out_of_range("length", length, "(0, inf)"));
        }
        let mut element = Self::conducting(dim, length * length)?;
        let n = element.unknowns();
        for (r, row) in element.stiffness.chunks_exact_mut(n).enumerate() {
            for (c, k) in row.iter_mut().enumerate() {
                // int N_r N_c: 1/3 along an axis where both nodes agree, 1/6 where not.
                let apart = (r ^ c).count_ones() as i32;
                *k += 3.0_f64.powi(-(dim as i32)) * 0.5_f64.powi(apart);
            }
        }
        Ok(element)
    }

    /// Two Gauss points along each axis: exact for these elements.
    fn integrate(dim: usize, components: usize, law: Vec<f64>) -> Self {
        let rows = law.len().isqrt();
        let n = components << dim;
        let half = 0.5 / 3.0_f64.sqrt();
        let mut stiffness = vec![0.0; n * n];
        for point in 0..1 << dim {
            let at =
                std::array::from_fn(|axis| 0.5 + if point >> axis & 1 == 1 { half } else { -half });
            let b = strain_matrix(dim, components, at);
            let mut stress = vec![0.0; rows * n];
            for r in 0..rows {
                for c in 0..n {
                    stress[r * n + c] = (0..rows).map(|k| law[r * rows + k] * b[k * n + c]).sum();
                }
            }
            for r in 0..n {
                for c in 0..n {
                    let product: f64 = (0..rows).map(|k| b[k * n + r] * stress[k * n + c]).sum();
                    stiffness[r * n + c] += product / f64::from(1 << dim);
                }
            }
        }
        let strain = strain_matrix(dim, components, [0.5; 3]);
        Self { dim, components, stiffness, strain, law }
    }

    /// Number of axes.
    pub fn dim(&self) -> usize {
        self.dim
    }

    /// Unknowns per node: `dim` displacements, or 1 temperature.
    pub fn components(&self) -> usize {
        self.components
    }

    /// Unknowns of the element.
    pub fn unknowns(&self) -> usize {
        self.components << self.dim
    }

    /// `K_e`, row by row, symmetric and positive semi-definite.
    pub fn stiffness(&self) -> &[f64] {
        &self.stiffness
    }

    /// `u^T K_e v` of two vectors of nodal values.
    pub fn energy(&self, u: &[f64], v: &[f64]) -> f64 {
        self.stiffness.chunks_exact(u.len()).zip(u).map(|(row, u)| u * dot(row, v)).sum()
    }

    /// Stress at the element's middle for stiffness 1: `xx, yy, xy` in the plane,
    /// `xx, yy, zz, yz, xz, xy` in space; the flux for heat. The rest of `stress` is 0.
    pub fn stress(&self, u: &[f64]) -> [f64; 6] {
        let mut strain = [0.0; 6];
        for (e, row) in strain.iter_mut().zip(self.strain.chunks_exact(u.len())) {
            *e = dot(row, u);
        }
        let rows = self.law.len().isqrt();
        let mut stress = [0.0; 6];
        for (s, row) in stress.iter_mut().zip(self.law.chunks_exact(rows)) {
            *s = dot(row, &strain);
        }
        stress
    }

    /// Adds `(D B)^T weights` to `out`: the adjoint of [`Element::stress`].
    pub fn stress_adjoint(&self, weights: &[f64; 6], out: &mut [f64]) {
        let rows = self.law.len().isqrt();
        for (law, row) in self.law.chunks_exact(rows).zip(self.strain.chunks_exact(out.len())) {
            // D is symmetric: its row is its column.
            let strain = dot(law, weights);
            out.iter_mut().zip(row).for_each(|(o, b)| *o += strain * b);
        }
    }
}

/// Products of the common part of two vectors, summed in order.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// B at a point of the unit element: nodal displacements to engineering strains, or
/// nodal temperatures to the gradient.
fn strain_matrix(dim: usize, components: usize, at: [f64; 3]) -> Vec<f64> {
    let n = components << dim;
    let rows = if components == 1 { dim } else { dim * (dim + 1) / 2 };
    let mut b = vec![0.0; rows * n];
    for node in 0..1 << dim {
        let gradient: [f64; 3] = std::array::from_fn(|along| {
            let factor = |axis: usize| match (axis == along, node >> axis & 1 == 1) {
                (true, far) => {
                    if far {
                        1.0
                    } else {
                        -1.0
                    }
                }
                (false, true) => at[axis],
                (false, false) => 1.0 - at[axis],
            };
            (0..dim).map(factor).product()
        });
        let column = node * components;
        for axis in 0..dim {
            b[axis * n + column + if components == 1 { 0 } else { axis }] = gradient[axis];
        }
        if components == 2 {
            b[2 * n + column] = gradient[1];
            b[2 * n + column + 1] = gradient[0];
        }
        if components == 3 {
            for (row, (p, q)) in [(3, (1, 2)), (4, (0, 2)), (5, (0, 1))] {
                b[row * n + column + p] = gradient[q];
                b[row * n + column + q] = gradient[p];
            }
        }
    }
    b
}
