//! Von Mises stresses and their p-norm.

use super::build::Problem;
use rayon::prelude::*;

/// Elements of a task: large enough to hide its cost.
const CHUNK: usize = 1024;

/// Densities below this count as this in the relaxed stress, whose slope is infinite at 0.
const LEAST: f64 = 1e-4;

/// Von Mises stress from `xx, yy, xy` (plane stress) or `xx, yy, zz, yz, xz, xy`, and its
/// derivatives by them.
pub(super) fn von_mises(dim: usize, s: &[f64; 6]) -> (f64, [f64; 6]) {
    if dim == 2 {
        let square = s[0] * s[0] - s[0] * s[1] + s[1] * s[1] + 3.0 * s[2] * s[2];
        let value = square.sqrt();
        let inverse = if value > 0.0 { 1.0 / value } else { 0.0 };
        let slope = [s[0] - 0.5 * s[1], s[1] - 0.5 * s[0], 3.0 * s[2], 0.0, 0.0, 0.0];
        return (value, slope.map(|d| d * inverse));
    }
    let (xy, yz, zx) = (s[0] - s[1], s[1] - s[2], s[2] - s[0]);
    let shear = s[3] * s[3] + s[4] * s[4] + s[5] * s[5];
    let value = (0.5 * (xy * xy + yz * yz + zx * zx) + 3.0 * shear).sqrt();
    let inverse = if value > 0.0 { 1.0 / value } else { 0.0 };
    let slope =
        [0.5 * (xy - zx), 0.5 * (yz - xy), 0.5 * (zx - yz), 3.0 * s[3], 3.0 * s[4], 3.0 * s[5]];
    (value, slope.map(|d| d * inverse))
}

/// Von Mises stresses of solid material at the elements' middles, and what the norm needs.
pub(super) struct Norm {
    /// Stress and its derivatives by the components.
    stresses: Vec<(f64, [f64; 6])>,
    exponent: f64,
    /// `(sum_e (sqrt(rho_e) s_e)^P)^(1/P)`: the relaxed stress of Bruggi 2008 with exponent 1/2.
    pub(super) value: f64,
}

impl Norm {
    /// The p-norm of displacements `u` and densities `rho`.
    pub(super) fn new(problem: &Problem, exponent: f64, u: &[f64], rho: &[f64]) -> Self {
        let (system, element) = (&problem.system, problem.system.element());
        let (n, dim) = (element.unknowns(), element.dim());
        let stress_of = |e: usize| {
            let mut local = [0.0; 24];
            system.gather(e, u, &mut local[..n]);
            von_mises(dim, &element.stress(&local[..n]))
        };
        let stresses: Vec<(f64, [f64; 6])> =
            (0..rho.len()).into_par_iter().with_min_len(CHUNK).map(stress_of).collect();
        let relaxed = |e: usize| relax(rho[e]) * stresses[e].0;
        // Scaled by the greatest: powers of large stresses would overflow.
        let greatest = (0..rho.len()).map(relaxed).fold(f64::MIN_POSITIVE, f64::max);
        let power = |e: usize| libm::pow(relaxed(e) / greatest, exponent);
        let powers: Vec<f64> =
            (0..rho.len()).into_par_iter().with_min_len(CHUNK).map(power).collect();
        let value = greatest * libm::pow(powers.iter().sum(), 1.0 / exponent);
        Self { stresses, exponent, value }
    }

    /// Adds the derivatives by the displacements to `right` and, times `weight`, those by the
    /// densities at fixed displacements to `gradient`.
    pub(super) fn add_derivatives(
        &self,
        problem: &Problem,
        rho: &[f64],
        weight: f64,
        right: &mut [f64],
        gradient: &mut [f64],
    ) {
        let (system, element) = (&problem.system, problem.system.element());
        let (n, components) = (element.unknowns(), element.components());
        let lattice = system.lattice();
        let mut local = [0.0; 24];
        for (e, (stress, slope)) in self.stresses.iter().enumerate() {
            let root = relax(rho[e]);
            let outer = libm::pow(root * stress / self.value, self.exponent - 1.0);
            if rho[e] > LEAST {
                gradient[e] += weight * outer * stress * 0.5 / root;
            }
            local[..n].fill(0.0);
            element.stress_adjoint(&slope.map(|d| d * outer * root), &mut local[..n]);
            let first = lattice.first_node(e);
            for (m, value) in local[..n].iter().enumerate() {
                let node = first + lattice.offsets()[m / components];
                right[node * components + m % components] += value;
            }
        }
    }
}

/// Relaxation of the stress at a density.
fn relax(rho: f64) -> f64 {
    rho.max(LEAST).sqrt()
}
