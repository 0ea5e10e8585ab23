//! Element matrices, loads and designs for tests and timing.

use super::{Lattice, Multigrid, Options, Status};

/// Matrix of a unit element of Young's modulus 1 (plane stress in 2D) and Poisson's ratio
/// `nu`; or, for one component, of conductivity 1. Two Gauss points along each axis.
pub(super) fn element_matrix(dim: usize, components: usize, nu: f64) -> Vec<f64> {
    let corners = 1_usize << dim;
    let n = corners * components;
    let mut ke = vec![0.0; n * n];
    let gauss = [0.5 - 0.5 / 3.0_f64.sqrt(), 0.5 + 0.5 / 3.0_f64.sqrt()];
    for point in 0..corners {
        let at: Vec<f64> = (0..dim).map(|axis| gauss[point >> axis & 1]).collect();
        let factor =
            |a: usize, axis: usize| if a >> axis & 1 == 1 { at[axis] } else { 1.0 - at[axis] };
        let slope = |a: usize, axis: usize| {
            let others: f64 = (0..dim).filter(|&o| o != axis).map(|o| factor(a, o)).product();
            if a >> axis & 1 == 1 { others } else { -others }
        };
        let (mu, lambda) = if dim == 2 {
            (0.5 / (1.0 + nu), nu / (1.0 - nu * nu))
        } else {
            (0.5 / (1.0 + nu), nu / ((1.0 + nu) * (1.0 - 2.0 * nu)))
        };
        for a in 0..corners {
            for b in 0..corners {
                let gradients: f64 = (0..dim).map(|i| slope(a, i) * slope(b, i)).sum();
                for c in 0..components {
                    for d in 0..components {
                        let same = if c == d { gradients } else { 0.0 };
                        let value = if components == 1 {
                            gradients
                        } else {
                            lambda * slope(a, c) * slope(b, d)
                                + mu * (slope(a, d) * slope(b, c) + same)
                        };
                        ke[(a * components + c) * n + b * components + d] += value / corners as f64;
                    }
                }
            }
        }
    }
    ke
}

/// A problem: supports and load.
pub(super) struct Problem {
    /// The elements.
    pub(super) lattice: Lattice,
    /// Unknowns per node.
    pub(super) components: usize,
    /// Matrix of an element.
    pub(super) ke: Vec<f64>,
    /// Supports, per unknown.
    pub(super) fixed: Vec<bool>,
    /// Load, per unknown.
    pub(super) load: Vec<f64>,
}

/// Clamped at x = 0 (half MBB beam in 2D: rollers at x = 0 and the far lower corner), a load
/// in y at the end; for heat, a sink in the middle of x = 0 and heat everywhere.
///
/// # Panics
/// If `elements` make no lattice.
pub(super) fn problem(elements: &[usize], components: usize) -> Problem {
    let lattice = Lattice::new(elements).unwrap();
    let dim = lattice.dim();
    let [nz, ny, nx] = lattice.nodes();
    let n = lattice.node_count() * components;
    let (mut fixed, mut load) = (vec![false; n], vec![0.0; n]);
    let node = |k: usize, j: usize, i: usize| (k * ny + j) * nx + i;
    if components == 1 {
        load.fill(1.0 / n as f64);
        for k in 0..nz {
            for j in ny / 2 - ny / 10..=ny / 2 + ny / 10 {
                fixed[node(k, j, 0)] = true;
            }
        }
    } else if dim == 2 {
        for j in 0..ny {
            fixed[2 * node(0, j, 0)] = true;
        }
        fixed[2 * node(0, ny - 1, nx - 1) + 1] = true;
        load[1] = -1.0;
    } else {
        for k in 0..nz {
            for j in 0..ny {
                for c in 0..3 {
                    fixed[3 * node(k, j, 0) + c] = true;
                }
            }
            load[3 * node(k, ny - 1, nx - 1) + 1] = 1.0 / nz as f64;
        }
    }
    Problem { lattice, components, ke: element_matrix(dim, components, 0.3), fixed, load }
}

/// Stiffness of densities: `1e-9 + rho^3 (1 - 1e-9)`.
pub(super) fn stiffness(densities: &[f64]) -> Vec<f64> {
    densities.iter().map(|rho| 1e-9 + rho.powi(3) * (1.0 - 1e-9)).collect()
}

/// Densities after `steps` of SIMP (penalty 3, sensitivity filter, optimality criteria).
///
/// # Panics
/// If the solver does not converge.
pub(super) fn optimize(problem: &Problem, volume: f64, radius: f64, steps: usize) -> Vec<f64> {
    let lattice = &problem.lattice;
    let count = lattice.element_count();
    let mut rho = vec![volume; count];
    let mut x = vec![0.0; problem.load.len()];
    let mut solver = Multigrid::new(
        lattice,
        problem.components,
        &problem.ke,
        &problem.fixed,
        &[],
        Options::default(),
    )
    .unwrap();
    for _ in 0..steps {
        solver.update(&stiffness(&rho)).unwrap();
        let report = solver.solve(&problem.load, &mut x, 1e-5, 400).unwrap();
        assert!(report.status == Status::Converged, "{report:?}");
        let slope: Vec<f64> =
            (0..count).map(|e| 3.0 * rho[e].powi(2) * energy(problem, e, &x)).collect();
        let weighted: Vec<f64> = slope.iter().zip(&rho).map(|(s, r)| s * r).collect();
        let smooth = filter(lattice, &weighted, radius);
        let gain: Vec<f64> = smooth.iter().zip(&rho).map(|(s, r)| s / r.max(1e-3)).collect();
        rho = criteria(&rho, &gain, volume);
    }
    rho
}

fn energy(problem: &Problem, element: usize, x: &[f64]) -> f64 {
    let lattice = &problem.lattice;
    let [_, ny, nx] = lattice.elements();
    let [k, j, i] = [element / (nx * ny), element / nx % ny, element % nx];
    let n = problem.components << lattice.dim();
    let local: Vec<f64> = (0..n)
        .map(|l| {
            let (a, c) = (l / problem.components, l % problem.components);
            let node = ((k + (a >> 2)) * (ny + 1) + j + (a >> 1 & 1)) * (nx + 1) + i + (a & 1);
            x[node * problem.components + c]
        })
        .collect();
    (0..n).map(|r| (0..n).map(|c| local[r] * problem.ke[r * n + c] * local[c]).sum::<f64>()).sum()
}

/// Cone filter, one axis at a time (a product of hats: enough for a test design).
fn filter(lattice: &Lattice, values: &[f64], radius: f64) -> Vec<f64> {
    let shape = lattice.elements();
    let strides = [shape[1] * shape[2], shape[2], 1];
    let reach = radius as isize;
    let mut now = values.to_vec();
    for axis in 0..3 {
        let pass = |e: usize| {
            let at = (e / strides[axis] % shape[axis]) as isize;
            let (mut sum, mut weights) = (0.0, 0.0);
            for d in -reach..=reach {
                if (0..shape[axis] as isize).contains(&(at + d)) {
                    let weight = radius - d.abs() as f64;
                    weights += weight;
                    sum += weight * now[e.wrapping_add_signed(d * strides[axis] as isize)];
                }
            }
            sum / weights
        };
        now = (0..values.len()).map(pass).collect();
    }
    now
}

fn criteria(rho: &[f64], gain: &[f64], volume: f64) -> Vec<f64> {
    let (mut low, mut high) = (0.0, gain.iter().copied().fold(0.0, f64::max) * 1e3 + 1e-30);
    let step = |lambda: f64| -> Vec<f64> {
        let new = |(r, g): (&f64, &f64)| {
            (r * (g / lambda).sqrt()).clamp(r - 0.2, r + 0.2).clamp(1e-3, 1.0)
        };
        rho.iter().zip(gain).map(new).collect()
    };
    for _ in 0..60 {
        let middle = if low == 0.0 { high * 1e-3 } else { f64::sqrt(low * high) };
        let mean = step(middle).iter().sum::<f64>() / rho.len() as f64;
        if mean > volume { low = middle } else { high = middle }
    }
    step(high)
}
