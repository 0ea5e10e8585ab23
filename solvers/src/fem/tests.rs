use super::*;
use std::f64::consts::PI;

fn elastic(dim: usize) -> Element {
    let material =
        Elastic { youngs_modulus: 1.0, poisson_ratio: 0.3, plane: PlaneState::PlaneStress };
    Element::elastic(dim, material).unwrap()
}

fn lattice(elements: &[usize]) -> Lattice {
    Lattice::new(elements).unwrap()
}

/// Entries of the 99-line program's element matrix (Sigmund 2001), E = 1, nu = 0.3.
#[test]
fn the_square_is_that_of_the_99_lines() {
    let nu = 0.3;
    let k = [0.5 - nu / 6.0, 0.125 + nu / 8.0, -0.25 - nu / 12.0, -0.125 + 3.0 * nu / 8.0];
    let scale = 1.0 / (1.0 - nu * nu);
    let element = elastic(2);
    let found = element.stiffness();
    // Node 0 with itself, its x with its y, with the next node along x.
    for (at, expected) in [(0, k[0]), (1, k[1]), (2, k[2])] {
        assert!((found[at] - expected * scale).abs() < 1e-15, "{at}: {}", found[at]);
    }
    assert!((found[3].abs() - k[3].abs() * scale).abs() < 1e-15);
}

/// Rigid motions cost nothing; uniform strain has the energy of the material's law.
#[test]
fn elements_know_rigid_motions_and_uniform_strain() {
    for dim in [2, 3] {
        let element = elastic(dim);
        let system =
            System::new(lattice(&vec![1; dim]), element.clone(), vec![false; dim << dim], vec![])
                .unwrap();
        let modes = free_modes(&system);
        assert_eq!(modes.len(), dim * (dim + 1) / 2);
        for mode in modes {
            let u: Vec<f64> = (0..element.unknowns()).map(|n| mode.at(&system, n)).collect();
            assert!(element.energy(&u, &u).abs() < 1e-14);
        }
        // u = x: strain xx = 1.
        let u: Vec<f64> = (0..element.unknowns())
            .map(|n| if n % dim == 0 { ((n / dim) & 1) as f64 } else { 0.0 })
            .collect();
        let stress = element.stress(&u);
        assert!((element.energy(&u, &u) - stress[0]).abs() < 1e-14);
        let mut adjoint = vec![0.0; u.len()];
        element.stress_adjoint(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], &mut adjoint);
        let weighted: f64 =
            stress.iter().zip([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]).map(|(s, w)| s * w).sum();
        let through: f64 = adjoint.iter().zip(&u).map(|(a, u)| a * u).sum();
        assert!((weighted - through).abs() < 1e-14);
    }
}

/// Patch test: linear displacements on the border give linear displacements inside,
/// to rounding, whatever the uniform stiffness.
#[test]
fn patch_test() {
    for elements in [vec![5, 7], vec![3, 4, 5]] {
        let (lattice, dim) = (lattice(&elements), elements.len());
        let [nz, ny, nx] = lattice.nodes();
        let exact = |unknown: usize| {
            let [x, y, z] = lattice.position(unknown / dim).map(|n| n as f64);
            let axis = (unknown % dim) as f64;
            0.3 * x + (0.1 + 0.2 * axis) * y - 0.15 * z * (1.0 + axis)
        };
        let unknowns = lattice.node_count() * dim;
        let fixed = (0..unknowns)
            .map(|unknown| {
                let [i, j, k] = lattice.position(unknown / dim);
                i == 0
                    || j == 0
                    || i + 1 == nx
                    || j + 1 == ny
                    || dim == 3 && (k == 0 || k + 1 == nz)
            })
            .collect::<Vec<_>>();
        let system = System::new(lattice, elastic(dim), fixed.clone(), vec![]).unwrap();
        let stiffness = vec![0.7; lattice.element_count()];
        let border: Vec<f64> =
            (0..unknowns).map(|n| if fixed[n] { exact(n) } else { 0.0 }).collect();
        let mut force = vec![0.0; unknowns];
        system.multiply(&stiffness, &border, &mut force);
        force.iter_mut().for_each(|f| *f = -*f);
        let mut direct = Direct::new(&system).unwrap();
        direct.factorize(&system, &stiffness).unwrap();
        let mut u = vec![0.0; unknowns];
        direct.solve(&force, &mut u).unwrap();
        for n in 0..unknowns {
            assert!((u[n] + border[n] - exact(n)).abs() < 1e-10, "unknown {n}");
        }
    }
}

/// A slender cantilever's tip: the error against Timoshenko's beam falls with h^2.
#[test]
fn cantilever_converges_to_beam_theory() {
    let tip = |refine: usize| {
        let (height, length) = (2 * refine, 40 * refine);
        let lattice = lattice(&[height, length]);
        let unknowns = 2 * lattice.node_count();
        let fixed = (0..unknowns).map(|n| lattice.position(n / 2)[0] == 0).collect();
        // nu = 0: no clamped-end effect across the height.
        let material =
            Elastic { youngs_modulus: 1.0, poisson_ratio: 0.0, plane: PlaneState::PlaneStress };
        let system =
            System::new(lattice, Element::elastic(2, material).unwrap(), fixed, vec![]).unwrap();
        let mut force = vec![0.0; unknowns];
        for j in 0..height {
            // Parabolic shear over the end, lumped consistently by Simpson's rule.
            let shear =
                |y: f64| 6.0 * (y / height as f64) * (1.0 - y / height as f64) / height as f64;
            let (a, m, b) = (shear(j as f64), shear(j as f64 + 0.5), shear(j as f64 + 1.0));
            force[2 * lattice.node([length, j, 0]) + 1] += (a + 2.0 * m) / 6.0;
            force[2 * lattice.node([length, j + 1, 0]) + 1] += (2.0 * m + b) / 6.0;
        }
        let mut direct = Direct::new(&system).unwrap();
        direct.factorize(&system, &vec![1.0; lattice.element_count()]).unwrap();
        let mut u = vec![0.0; unknowns];
        direct.solve(&force, &mut u).unwrap();
        u[2 * lattice.node([length, height / 2, 0]) + 1]
    };
    // P L^3 / (3 E I) + P L / (k G A), k = 5/6, the same for every refinement.
    let (length, height): (f64, f64) = (40.0, 2.0);
    let inertia = height.powi(3) / 12.0;
    let exact = length.powi(3) / (3.0 * inertia) + length / (5.0 / 6.0 * 0.5 * height);
    let errors = [1, 2, 4].map(|refine| 1.0 - tip(refine) / exact);
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((1.8..2.2).contains(&order), "errors {errors:?}");
    }
}

/// Heat: the solution is exact for a cosine in the discrete sense of second order.
#[test]
fn conduction_converges() {
    let error = |n: usize| {
        let lattice = lattice(&[n, n]);
        let fixed = (0..lattice.node_count())
            .map(|node| {
                let [i, j, _] = lattice.position(node);
                i == 0 || i == n || j == 0 || j == n
            })
            .collect();
        let system =
            System::new(lattice, Element::conducting(2, 1.0).unwrap(), fixed, vec![]).unwrap();
        let exact = |node: usize| {
            let [x, y, _] = lattice.position(node).map(|m| m as f64 / n as f64);
            (PI * x).sin() * (PI * y).sin()
        };
        let h = 1.0 / n as f64;
        let force: Vec<f64> =
            (0..lattice.node_count()).map(|m| 2.0 * PI * PI * exact(m) * h * h).collect();
        let mut direct = Direct::new(&system).unwrap();
        direct.factorize(&system, &vec![1.0; n * n]).unwrap();
        let mut u = vec![0.0; force.len()];
        direct.solve(&force, &mut u).unwrap();
        u.iter().enumerate().map(|(m, u)| (u - exact(m)).abs()).fold(0.0, f64::max)
    };
    let order = (error(8) / error(16)).log2();
    assert!((1.8..2.2).contains(&order), "order {order}");
}

/// Table 1.1, row f as printed: x at the lower left corner, y at the lower right one.
#[test]
fn a_mechanism_has_its_pivot() {
    let lattice = lattice(&[20, 60]);
    let mut fixed = vec![false; 2 * lattice.node_count()];
    fixed[2 * lattice.node([0, 20, 0])] = true;
    fixed[2 * lattice.node([60, 20, 0]) + 1] = true;
    let system = System::new(lattice, elastic(2), fixed.clone(), vec![]).unwrap();
    let modes = free_modes(&system);
    assert_eq!(modes.len(), 1);
    let pivot = modes[0].pivot().unwrap();
    assert!((pivot[0] - 60.0).abs() < 1e-9 && (pivot[1] - 20.0).abs() < 1e-9, "{pivot:?}");
    fixed[2 * lattice.node([0, 20, 0]) + 1] = true;
    let system = System::new(lattice, elastic(2), fixed, vec![]).unwrap();
    assert!(free_modes(&system).is_empty());
}

/// The assembled matrix and the product without one agree.
#[test]
fn direct_solves_the_product() {
    for (elements, element) in [
        (vec![4, 5], elastic(2)),
        (vec![2, 3, 4], elastic(3)),
        (vec![4, 5], Element::conducting(2, 2.0).unwrap()),
    ] {
        let lattice = lattice(&elements);
        let components = element.components();
        let unknowns = lattice.node_count() * components;
        let fixed = (0..unknowns).map(|n| lattice.position(n / components)[0] == 0).collect();
        let springs = (0..unknowns).map(|n| (n % 7) as f64 * 0.1).collect();
        let system = System::new(lattice, element, fixed, springs).unwrap();
        let stiffness: Vec<f64> =
            (0..lattice.element_count()).map(|e| 0.1 + (e % 5) as f64).collect();
        let force: Vec<f64> = (0..unknowns).map(|n| ((n * 37 % 11) as f64 - 5.0) / 5.0).collect();
        let mut direct = Direct::new(&system).unwrap();
        direct.factorize(&system, &stiffness).unwrap();
        let (mut u, mut product) = (vec![0.0; unknowns], vec![0.0; unknowns]);
        direct.solve(&force, &mut u).unwrap();
        system.multiply(&stiffness, &u, &mut product);
        for n in (0..unknowns).filter(|&n| !system.fixed()[n]) {
            assert!((product[n] - force[n]).abs() < 1e-10, "unknown {n}");
        }
    }
}
