#![expect(
    clippy::print_stdout,
    reason = "measured figures are printed for the reader of a test run"
)]

use super::designs::{Problem, element_matrix, optimize, problem, stiffness};
use super::galerkin::Elements;
use super::stencil::neighbours;
use super::*;
use crate::random;
use crate::sparse::{Cholesky, Ordering, Symbolic, SymmetricMatrix, nested_dissection};

/// Odd and even sizes, axes of one element, all dimensions and numbers of components.
const CASES: [(&[usize], usize); 9] = [
    (&[20, 60], 2),
    (&[30, 45], 2),
    (&[33, 81], 2),
    (&[1, 7], 2),
    (&[20, 32], 1),
    (&[13, 6], 1),
    (&[5, 6, 9], 3),
    (&[1, 4, 7], 3),
    (&[6, 5, 4], 1),
];

fn noise(name: &str, n: usize) -> Vec<f64> {
    let mut stream = random::stream(5, name, n as u64);
    (0..n).map(|_| random::normal(&mut stream)).collect()
}

/// Members across the lattice, solid in void of 1e-9: bands along both diagonals and the rim.
fn truss(lattice: &Lattice) -> Vec<f64> {
    let [_, ny, nx] = lattice.elements();
    let height = ny as f64;
    let density = |e: usize| {
        let [k, j, i] = lattice.element(e);
        let (x, y) = ((i as f64 + 0.5) / height, (j as f64 + 0.5) / height);
        let rim =
            !(0.1..=0.9).contains(&y) || i == 0 || i + 1 == nx || (lattice.dim() == 3 && k == 0);
        let bay = x.fract();
        let diagonal = (bay - y).abs() < 0.07 || (bay + y - 1.0).abs() < 0.07;
        if rim || diagonal { 1.0 } else { 1e-3 }
    };
    stiffness(&(0..lattice.element_count()).map(density).collect::<Vec<_>>())
}

fn solver(problem: &Problem, springs: &[f64], options: Options) -> Multigrid {
    let Problem { lattice, components, ke, fixed, .. } = problem;
    Multigrid::new(lattice, *components, ke, fixed, springs, options).unwrap()
}

/// K with fixed rows and columns 0, by the textbook.
fn assemble(problem: &Problem, springs: &[f64], stiffness: &[f64]) -> SymmetricMatrix {
    let Problem { lattice, components, ke, fixed, .. } = problem;
    let n = components * lattice.corners();
    let mut triplets: Vec<_> = (0..fixed.len())
        .map(|u| (u, u, if fixed[u] { 0.0 } else { springs.get(u).copied().unwrap_or(0.0) }))
        .collect();
    for (element, e) in stiffness.iter().enumerate() {
        let unknowns = children::unknowns(*lattice, element, *components);
        for (row, &u) in unknowns[..n].iter().enumerate() {
            for (column, &v) in unknowns[..n].iter().enumerate() {
                if !fixed[u] && !fixed[v] {
                    triplets.push((u, v, e * ke[row * n + column]));
                }
            }
        }
    }
    SymmetricMatrix::from_triplets(fixed.len(), triplets).unwrap()
}

fn springs(n: usize) -> Vec<f64> {
    (0..n).map(|u| if u % 7 == 3 { 0.1 } else { 0.0 }).collect()
}

#[test]
fn products_are_those_of_the_assembled_matrix() {
    for (elements, components) in CASES {
        let mut problem = problem(elements, components);
        let n = problem.load.len();
        let (x, springs) = (noise("x", n), springs(n));
        let e: Vec<f64> =
            noise("E", problem.lattice.element_count()).iter().map(|v| v.abs() + 1e-9).collect();
        for mirrored in [true, false] {
            if !mirrored {
                // An anisotropic element: the mirrors change it.
                let size = problem.ke.len().isqrt();
                let v = noise("ke", size);
                (0..size * size).for_each(|i| problem.ke[i] += 0.1 * v[i / size] * v[i % size]);
            }
            let mut solver = solver(&problem, &springs, Options::default());
            solver.update(&e).unwrap();
            let (mut y, mut expected) = (vec![f64::NAN; n], vec![0.0; n]);
            solver.apply(&x, &mut y).unwrap();
            let free = |u: usize| if problem.fixed[u] { 0.0 } else { x[u] };
            let masked: Vec<f64> = (0..n).map(free).collect();
            assemble(&problem, &springs, &e).multiply(&masked, &mut expected);
            let largest = expected.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
            let error = y.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(error <= 1e-12 * largest, "{elements:?} {components}: {error:e}");
        }
    }
}

/// `M v` for the V-cycle M.
fn precondition(solver: &mut Multigrid, v: &[f64]) -> Vec<f64> {
    let layout = solver.layout;
    let mut wide = vec![0.0; layout.len()];
    rows::spread(&layout, v, &mut wide);
    solver.constraints.clear_fixed(&layout, &mut wide);
    let b = &mut solver.hierarchy.levels[0].b;
    b.iter_mut().zip(&wide).for_each(|(b, v)| *b = *v as f32);
    solver.hierarchy.precondition();
    let z = &solver.hierarchy.levels[0].x;
    wide.iter_mut().zip(z).for_each(|(v, z)| *v = f64::from(*z));
    let mut out = vec![0.0; v.len()];
    rows::collect(&layout, &wide, &mut out);
    out
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Few unknowns on the coarsest level, so that there are several levels.
const DEEP: Options = Options { degree: 2, coarsest_unknowns: Some(60) };

#[test]
fn the_preconditioner_is_symmetric_and_positive_definite() {
    for (elements, components) in CASES {
        for degree in 2..5 {
            let problem = problem(elements, components);
            let n = problem.load.len();
            let mut solver = solver(&problem, &springs(n), Options { degree, ..DEEP });
            // A contrast whose void is well above the rounding of 4-byte numbers.
            let e = truss(&problem.lattice).iter().map(|e| e.max(1e-3)).collect::<Vec<_>>();
            solver.update(&e).unwrap();
            let (x, y) = (noise("x", n), noise("y", n));
            let (mx, my) = (precondition(&mut solver, &x), precondition(&mut solver, &y));
            let (xx, yy) = (dot(&x, &mx), dot(&y, &my));
            assert!(xx > 0.0 && yy > 0.0, "{elements:?}");
            let difference = (dot(&x, &my) - dot(&y, &mx)).abs();
            assert!(difference <= 1e-5 * (xx * yy).sqrt(), "{elements:?}: {difference:e}");
        }
    }
}

/// `(P v)^T A (P v) = v^T A_coarse v` for each two levels, with supports and springs.
#[test]
fn coarse_operators_are_galerkin_products() {
    for (elements, components) in CASES {
        let problem = problem(elements, components);
        let n = problem.load.len();
        let mut solver = solver(&problem, &springs(n), DEEP);
        solver
            .update(
                &noise("E", problem.lattice.element_count())
                    .iter()
                    .map(|v| v * v + 1e-9)
                    .collect::<Vec<_>>(),
            )
            .unwrap();
        let hierarchy = &mut solver.hierarchy;
        for index in 0..hierarchy.levels.len() {
            let (levels, elements) = (&mut hierarchy.levels, &hierarchy.elements);
            let coarse = Layout::new(elements[index].lattice(), components);
            let v: Vec<f64> = noise("v", coarse.unknowns());
            let mut wide = vec![0.0; coarse.len()];
            rows::spread(&coarse, &v, &mut wide);
            let wide: Vec<f32> = wide.iter().map(|&v| v as f32).collect();
            let level = &mut levels[index];
            level.x.fill(0.0);
            level.b.fill(0.0);
            let fixed = &hierarchy.constraints.fixed;
            hierarchy.transfers[index].prolong(&wide, &mut level.x, |row, x| {
                let list = if index == 0 { fixed.row(row) } else { &[] };
                list.iter().for_each(|&place| x[place as usize] = 0.0);
            });
            level.residual();
            let energy: f64 =
                level.x.iter().zip(&level.r).map(|(x, r)| -f64::from(*x) * f64::from(*r)).sum();
            let mut expected = 0.0;
            elements[index].each_matrix(components, |unknowns, matrix| {
                for (row, &u) in unknowns.iter().enumerate() {
                    for (column, &w) in unknowns.iter().enumerate() {
                        expected += v[u] * matrix[row * unknowns.len() + column] * v[w];
                    }
                }
            });
            // Energies are sums of squares: 4-byte rounding of each.
            assert!((energy - expected).abs() <= 2e-6 * expected, "{energy} {expected}");
            if let Some(next) = levels.get_mut(index + 1) {
                stencil_matches(&elements[index], next, &wide, expected);
            }
        }
    }
}

/// The stencils' energy is that of the elements they are summed from.
fn stencil_matches(elements: &Elements, level: &mut level::Level, v: &[f32], energy: f64) {
    assert_eq!(elements.lattice(), level.layout.lattice);
    level.x.copy_from_slice(v);
    level.b.fill(0.0);
    level.residual();
    let found: f64 = v.iter().zip(&level.r).map(|(x, r)| -f64::from(*x) * f64::from(*r)).sum();
    assert!((found - energy).abs() <= 2e-6 * energy, "{found} {energy}");
}

#[test]
fn stored_neighbours_are_half_of_all() {
    for (dim, count) in [(2, 9), (3, 27)] {
        assert_eq!(neighbours(dim).len(), count / 2 + 1);
        let negative = |d: &[isize; 3]| d.map(|d| -d);
        assert!(neighbours(dim)[1..].iter().all(|d| !neighbours(dim).contains(&negative(d))));
    }
}

/// Solution by sparse Cholesky.
fn direct(problem: &Problem, stiffness: &[f64]) -> Vec<f64> {
    let mut matrix = assemble(problem, &[], stiffness);
    for u in (0..problem.fixed.len()).filter(|&u| problem.fixed[u]) {
        let diagonal = matrix.offsets()[u];
        matrix.values_mut()[diagonal] = 1.0;
    }
    let nodes = nested_dissection(&problem.lattice.nodes(), false);
    let c = problem.components;
    let order: Vec<usize> = nodes.into_iter().flat_map(|n| c * n..c * n + c).collect();
    let symbolic = Symbolic::new(&matrix, Ordering::Custom(&order)).unwrap();
    let factor = Cholesky::new(symbolic, &matrix).unwrap();
    let masked = problem.load.iter().zip(&problem.fixed);
    let mut x: Vec<f64> = masked.map(|(b, &fixed)| if fixed { 0.0 } else { *b }).collect();
    factor.solve(&mut x, &mut factor.scratch(1));
    x
}

#[test]
fn energies_agree_with_a_direct_solver() {
    for (elements, components) in CASES {
        let problem = problem(elements, components);
        let mut solver = solver(&problem, &[], DEEP);
        let uniform = vec![1.0; problem.lattice.element_count()];
        for e in [uniform, truss(&problem.lattice)] {
            solver.update(&e).unwrap();
            let mut x = vec![0.0; problem.load.len()];
            // The energy's error is second order in the residual, but the void multiplies it.
            let report = solver.solve(&problem.load, &mut x, 1e-9, 300).unwrap();
            assert_eq!(report.status, Status::Converged, "{elements:?}: {report:?}");
            let energy = dot(&problem.load, &x);
            let expected = dot(&problem.load, &direct(&problem, &e));
            println!("{elements:?} x {components}: {} iterations", report.iterations);
            assert!((energy / expected - 1.0).abs() < 1e-8, "{elements:?}: {energy} {expected}");
        }
    }
}

#[test]
fn iterations_grow_slowly_with_the_size() {
    let count = |scale: usize| {
        let problem = problem(&[32 * scale, 64 * scale], 2);
        let mut solver = solver(&problem, &[], Options::default());
        solver.update(&truss(&problem.lattice)).unwrap();
        let mut x = vec![0.0; problem.load.len()];
        let report = solver.solve(&problem.load, &mut x, 1e-8, 300).unwrap();
        assert_eq!(report.status, Status::Converged);
        report.iterations
    };
    let counts = [1, 2, 4, 8].map(count);
    println!("iterations at 64 x 32, 128 x 64, 256 x 128, 512 x 256: {counts:?}");
    // The smallest has two levels only, which is nearly a direct solver.
    assert!(counts[3] <= 40 && 2 * counts[3] <= 3 * counts[1].max(counts[2]), "{counts:?}");
}

#[test]
fn random_noise_is_reported_as_stalled() {
    let problem = problem(&[100, 100], 2);
    let mut solver = solver(&problem, &[], Options::default());
    let e: Vec<f64> =
        noise("solid", 100 * 100).iter().map(|v| if *v > 0.0 { 1.0 } else { 1e-9 }).collect();
    solver.update(&e).unwrap();
    let mut x = vec![0.0; problem.load.len()];
    let report = solver.solve(&problem.load, &mut x, 1e-8, 1000).unwrap();
    println!("noise: {report:?}");
    assert_eq!(report.status, Status::Stalled);
    assert!(report.iterations <= 2 * STALL_WINDOW);
}

#[test]
fn one_and_several_threads_give_the_same_bytes() {
    for (elements, components) in [(&[96, 160][..], 2), (&[12, 18, 40], 3), (&[150, 150], 1)] {
        let solve = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let problem = problem(elements, components);
                let mut solver =
                    solver(&problem, &[], Options { degree: 2, coarsest_unknowns: Some(500) });
                solver.update(&truss(&problem.lattice)).unwrap();
                let mut x = vec![0.0; problem.load.len()];
                let report = solver.solve(&problem.load, &mut x, 1e-8, 200).unwrap();
                (x.iter().map(|v| v.to_bits()).collect::<Vec<_>>(), report, solver.bands.count)
            })
        };
        let (x, report, bands) = solve(1);
        assert_eq!(bands, 1);
        for threads in [2, 3] {
            let (other, other_report, bands) = solve(threads);
            assert!(bands > 1, "{elements:?} is too small for this test");
            assert!(x == other && report == other_report, "{threads} threads");
        }
    }
}

#[test]
fn a_design_loop_and_a_warm_start() {
    let problem = problem(&[20, 60], 2);
    let rho = optimize(&problem, 0.5, 1.5, 20);
    let mut solver = solver(&problem, &[], DEEP);
    solver.update(&stiffness(&rho)).unwrap();
    let mut x = vec![0.0; problem.load.len()];
    let cold = solver.solve(&problem.load, &mut x, 1e-6, 100).unwrap();
    let warm = solver.solve(&problem.load, &mut x, 1e-8, 100).unwrap();
    assert!(cold.status == Status::Converged && warm.status == Status::Converged);
    let mut y = vec![0.0; x.len()];
    let all = solver.solve(&problem.load, &mut y, 1e-8, 100).unwrap();
    assert!(warm.iterations < all.iterations, "{warm:?} {all:?}");
    // The residual reported is the true one.
    solver.apply(&y, &mut x).unwrap();
    let square = |v: f64| v * v;
    let free = |u: &usize| !problem.fixed[*u];
    let r: f64 = (0..x.len()).filter(free).map(|u| square(x[u] - problem.load[u])).sum();
    let b: f64 = (0..x.len()).filter(free).map(|u| square(problem.load[u])).sum();
    assert!(((r / b).sqrt() / all.residual - 1.0).abs() < 1e-3);
}

#[test]
fn nothing_to_do_is_done_at_once() {
    let problem = problem(&[8, 8], 2);
    let mut solver = solver(&problem, &[], Options::default());
    solver.update(&[1.0; 64]).unwrap();
    let mut x = vec![1.0; problem.load.len()];
    // A load on a support does nothing either.
    let mut load = vec![0.0; x.len()];
    load[0] = 1.0;
    assert!(problem.fixed[0]);
    let report = solver.solve(&load, &mut x, 1e-8, 10).unwrap();
    assert_eq!(report, Report { iterations: 0, residual: 0.0, status: Status::Converged });
    assert!(x.iter().all(|&x| x == 0.0));
}

#[test]
fn unusable_inputs_are_refused() {
    let problem = problem(&[8, 8], 2);
    let Problem { lattice, ke, fixed, load, .. } = &problem;
    let make = |components, ke: &[f64], springs: &[f64]| {
        Multigrid::new(lattice, components, ke, fixed, springs, Options::default())
    };
    let text = |result: Result<Multigrid>| result.unwrap_err().to_string();
    assert!(text(make(3, ke, &[])).contains("components per node = 3"));
    assert!(text(make(2, &ke[1..], &[])).contains("[63]"));
    assert!(text(make(2, ke, &[1.0])).contains("springs has shape [1]"));
    let skew: Vec<f64> = ke.iter().enumerate().map(|(i, v)| v + (i == 1) as u8 as f64).collect();
    assert!(text(make(2, &skew, &[])).contains("symmetric"));
    let mut solver = make(2, ke, &[]).unwrap();
    let mut x = vec![0.0; load.len()];
    assert!(solver.solve(load, &mut x, 1e-8, 10).unwrap_err().to_string().contains("update"));
    let mut e = vec![1.0; 64];
    e[5] = f64::NAN;
    let message = solver.update(&e).unwrap_err().to_string();
    assert!(message.contains("stiffness of element 5 = NaN"), "{message}");
    assert!(solver.update(&e[..9]).is_err());
    solver.update(&[1.0; 64]).unwrap();
    let mut bad = load.clone();
    bad[7] = f64::NAN;
    let message = solver.solve(&bad, &mut x, 1e-8, 10).unwrap_err().to_string();
    assert!(message.contains("right-hand side[7] = NaN"), "{message}");
    assert!(solver.solve(load, &mut x, 0.0, 10).is_err());
    assert!(Lattice::new(&[1 << 20, 1 << 20]).unwrap_err().to_string().contains("2^30"));
    assert!(Lattice::new(&[3]).is_err() && Lattice::new(&[0, 3]).is_err());
}

#[test]
fn memory_is_known_before_it_is_taken() {
    let megabytes = |elements: &[usize], components| {
        memory(&Lattice::new(elements).unwrap(), components, &Options::default()) as f64 / 1e6
    };
    // Resident memory measured: 280, 243 and 47 MB.
    let cases: [(&[usize], usize, f64); 3] =
        [(&[1000, 1000], 2, 280.0), (&[64, 64, 128], 3, 243.0), (&[200, 600], 2, 47.0)];
    for (elements, components, measured) in cases {
        let estimate = megabytes(elements, components);
        assert!((estimate / measured - 1.0).abs() < 0.15, "{elements:?}: {estimate} MB");
    }
}

/// Loads of any size and stiffness in any unit: 4-byte numbers never see them.
#[test]
fn units_do_not_matter() {
    let problem = problem(&[20, 60], 2);
    let mut solver = solver(&problem, &[], DEEP);
    let e = truss(&problem.lattice);
    let mut count = |unit: f64, force: f64| {
        solver.update(&e.iter().map(|e| e * unit).collect::<Vec<_>>()).unwrap();
        let load: Vec<f64> = problem.load.iter().map(|f| f * force).collect();
        let mut x = vec![0.0; load.len()];
        let report = solver.solve(&load, &mut x, 1e-8, 100).unwrap();
        assert_eq!(report.status, Status::Converged);
        report.iterations
    };
    let iterations = count(1.0, 1.0);
    assert!(count(2.1e11, 1e5).abs_diff(iterations) <= 1);
    assert!(count(1e-60, 1e60).abs_diff(iterations) <= 1);
}

#[test]
fn element_matrices_keep_rigid_motions_free() {
    for (dim, components) in [(2, 1), (2, 2), (3, 1), (3, 3)] {
        let ke = element_matrix(dim, components, 0.3);
        let n = ke.len().isqrt();
        for c in 0..components {
            let move_row =
                |row: usize| -> f64 { ke[row * n..][..n].iter().skip(c).step_by(components).sum() };
            assert!((0..n).all(|row| move_row(row).abs() < 1e-15));
        }
    }
}
