//! Motions that the supports leave free.

use super::System;
use nalgebra::DMatrix;

/// Eigenvalues of the supports' stiffness against rigid motions below this fraction of
/// the greatest count as 0: the motions are scaled to displacements of order 1.
const FREE: f64 = 1e-10;

/// A motion of the whole body without strain: `u(x) = translation + rotation x (x - center)`.
///
/// For heat, `translation[0]` is a uniform change of temperature.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidMode {
    /// Displacement of `center` (length).
    pub translation: [f64; 3],
    /// Rotation vector (radians); in the plane only z counts.
    pub rotation: [f64; 3],
    /// The middle of the mesh (length).
    pub center: [f64; 3],
}

impl RigidMode {
    /// Displacement at a point (length).
    pub fn displacement(&self, point: [f64; 3]) -> [f64; 3] {
        let d: [f64; 3] = std::array::from_fn(|axis| point[axis] - self.center[axis]);
        let [wx, wy, wz] = self.rotation;
        let turn = [wy * d[2] - wz * d[1], wz * d[0] - wx * d[2], wx * d[1] - wy * d[0]];
        std::array::from_fn(|axis| self.translation[axis] + turn[axis])
    }

    /// Its value at an unknown of `system`.
    pub fn at(&self, system: &System, unknown: usize) -> f64 {
        let components = system.element().components();
        if components == 1 {
            return self.translation[0];
        }
        let point = system.lattice().position(unknown / components).map(|n| n as f64);
        self.displacement(point)[unknown % components]
    }

    /// Its work with nodal forces: `sum_i f_i u_i`.
    pub fn work(&self, system: &System, force: &[f64]) -> f64 {
        let loaded = force.iter().enumerate().filter(|(_, f)| **f != 0.0);
        loaded.map(|(unknown, f)| f * self.at(system, unknown)).sum()
    }

    /// Where the plane stands still: the centre of the rotation (x, y), if it turns.
    pub fn pivot(&self) -> Option<[f64; 2]> {
        let turn = self.rotation[2];
        let [tx, ty, _] = self.translation;
        // 0 = t + w x (p - c): p = c + (-ty, tx) / w.
        (turn.abs() > 1e-9).then(|| [self.center[0] - ty / turn, self.center[1] + tx / turn])
    }
}

/// Orthogonal rigid motions that neither a support nor a spring of `system` resists:
/// empty if the structure is held. Linear time.
///
/// Void elements count as material: what hangs on nothing but void is not found.
pub fn free_modes(system: &System) -> Vec<RigidMode> {
    let basis = basis(system);
    let n = basis.len();
    let mut held = DMatrix::<f64>::zeros(n, n);
    for unknown in 0..system.unknowns() {
        let spring = system.springs().get(unknown).copied().unwrap_or(0.0);
        if system.fixed()[unknown] || spring > 0.0 {
            let row: Vec<f64> = basis.iter().map(|mode| mode.at(system, unknown)).collect();
            for (r, a) in row.iter().enumerate() {
                row.iter().enumerate().for_each(|(c, b)| held[(r, c)] += a * b);
            }
        }
    }
    let eigen = held.symmetric_eigen();
    let greatest = eigen.eigenvalues.iter().copied().fold(0.0, f64::max);
    let free = (0..n).filter(|&m| eigen.eigenvalues[m] <= FREE * greatest.max(1.0));
    free.map(|m| {
        let mut mode = RigidMode { translation: [0.0; 3], rotation: [0.0; 3], ..basis[0] };
        for (part, &weight) in basis.iter().zip(eigen.eigenvectors.column(m).iter()) {
            for axis in 0..3 {
                mode.translation[axis] += weight * part.translation[axis];
                mode.rotation[axis] += weight * part.rotation[axis];
            }
        }
        mode
    })
    .collect()
}

/// All rigid motions, with displacements of at most about 1.
fn basis(system: &System) -> Vec<RigidMode> {
    let lattice = system.lattice();
    let [nz, ny, nx] = lattice.nodes();
    let center = [nx, ny, nz].map(|n| (n - 1) as f64 / 2.0);
    let still = RigidMode { translation: [0.0; 3], rotation: [0.0; 3], center };
    let along = |axis: usize| {
        let mut mode = still;
        mode.translation[axis] = 1.0;
        mode
    };
    let radius = center.into_iter().fold(1.0, f64::max);
    let about = |axis: usize| {
        let mut mode = still;
        mode.rotation[axis] = 1.0 / radius;
        mode
    };
    match system.element().components() {
        1 => vec![along(0)],
        2 => vec![along(0), along(1), about(2)],
        _ => (0..3).map(along).chain((0..3).map(about)).collect(),
    }
}
