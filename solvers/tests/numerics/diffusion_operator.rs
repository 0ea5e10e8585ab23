//! Diffusion operators: symmetry, conservation, order, exact moments.

use proptest::prelude::*;
use solvers::diffusion::{Diffusivity, FaceMean, Operator, Tensor};
use solvers::order::observed_order;
use solvers::sparse::{Cholesky, Ordering, Symbolic, nested_dissection};
use solvers::{Boundary, Field, Grid, random};
use std::f64::consts::{PI, TAU};

fn noise(grid: Grid, name: &str) -> Vec<f64> {
    let mut stream = random::stream(5, name, 0);
    (0..grid.len()).map(|_| random::normal(&mut stream)).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn scalar_map(grid: Grid, mean: FaceMean) -> Diffusivity {
    let values = noise(grid, "D").iter().map(|v| v * v).collect();
    Diffusivity::Map { values: Field::from_vec(grid, values).unwrap(), mean }
}

/// `L L^T` of a random lower triangle with 0.2 added to the diagonal.
fn tensor_map(grid: Grid) -> Diffusivity {
    let q = ["a", "b", "c"].map(|name| noise(grid, name));
    let at = |n: usize| {
        let [a, b, c] = [q[0][n], q[1][n], q[2][n]];
        Tensor {
            xx: a * a + 0.2,
            yy: 0.25 * c * c + b * b + 0.2,
            zz: b * b + c * c + 0.2,
            xy: 0.5 * a * c,
            xz: a * b,
            yz: 0.5 * b * c,
        }
    };
    Diffusivity::Tensor((0..grid.len()).map(at).collect())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(60) })]
    /// The matrix and the kernel are the same operator; it is symmetric, negative
    /// semidefinite and conservative, and makes no new extrema, on any small grid.
    #[test]
    fn symmetric_conservative_monotone_and_equal_to_the_matrix(
        shape in prop::collection::vec(1_usize..9, 1..=3),
        periodic: bool,
        kind in 0..4,
    ) {
        let grid = Grid::new(&shape, 0.5).unwrap();
        let boundary = if periodic { Boundary::Periodic } else { Boundary::Neumann };
        let diffusivity = match kind {
            0 => Diffusivity::Constant(1.7),
            1 => scalar_map(grid, FaceMean::Harmonic),
            2 => scalar_map(grid, FaceMean::Arithmetic),
            _ => tensor_map(grid),
        };
        let operator = Operator::new(grid, boundary, &diffusivity).unwrap();
        let (u, v) = (noise(grid, "u"), noise(grid, "v"));
        let (mut au, mut av, mut product) = (u.clone(), u.clone(), u.clone());
        operator.apply(&u, &mut au);
        operator.apply(&v, &mut av);
        // Ten round-offs per node of the largest term.
        let unit = 1e-15 * (1.0 + operator.max_rate()) * grid.len() as f64 * 10.0;
        prop_assert!(au.iter().sum::<f64>().abs() < unit);
        prop_assert!((dot(&v, &au) - dot(&u, &av)).abs() < unit);
        prop_assert!(dot(&u, &au) < unit);
        operator.matrix(0.0, 1.0).unwrap().multiply(&u, &mut product);
        prop_assert!(au.iter().zip(&product).all(|(a, b)| (a - b).abs() < unit));
        let dt = 1.0 / operator.max_rate().max(1.0);
        let moved: Vec<f64> = u.iter().zip(&au).map(|(u, a)| u + dt * a).collect();
        let range = |u: &[f64]| u.iter().fold((9.0, -9.0), |r: (f64, f64), &v| (r.0.min(v), r.1.max(v)));
        let (before, after) = (range(&u), range(&moved));
        prop_assert!(after.0 >= before.0 - 1e-14 && after.1 <= before.1 + 1e-14);
        // Differences of a constant vanish exactly.
        operator.apply(&vec![3.7; grid.len()], &mut au);
        prop_assert!(au.iter().all(|&v| v == 0.0));
    }
}

/// Largest error of A u against div(D grad u) for u = prod cos(m x), D = 2 + u/2.
fn truncation(n: usize, boundary: Boundary, mean: FaceMean, dim: usize) -> f64 {
    let h = TAU / n as f64;
    let grid = Grid::new(&vec![n; dim], h).unwrap();
    // Half the wave number has zero slope at both ends of a Neumann grid.
    let m = if boundary == Boundary::Periodic { 1.0 } else { 0.5 };
    let at = |p: [f64; 3]| p.map(|x| m * (x + 0.5 * h));
    let u = |p: [f64; 3]| at(p)[..dim].iter().map(|x| x.cos()).product::<f64>();
    let exact = |p: [f64; 3]| {
        let (x, value) = (at(p), u(p));
        let squares: f64 = x[..dim].iter().map(|x| (m * x.tan() * value).powi(2)).sum();
        -(2.0 + 0.5 * value) * dim as f64 * m * m * value + 0.5 * squares
    };
    let values = Field::from_fn(grid, |p| 2.0 + 0.5 * u(p));
    let operator = Operator::new(grid, boundary, &Diffusivity::Map { values, mean }).unwrap();
    let mut found = vec![0.0; grid.len()];
    operator.apply(Field::from_fn(grid, u).as_slice(), &mut found);
    let exact = Field::from_fn(grid, exact);
    found.iter().zip(exact.as_slice()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn varying_scalar_diffusion_is_of_second_order() {
    for boundary in [Boundary::Periodic, Boundary::Neumann] {
        for mean in [FaceMean::Harmonic, FaceMean::Arithmetic] {
            for (dim, n) in [(1, [32, 64, 128]), (2, [32, 64, 128]), (3, [16, 24, 32])] {
                let order = observed_order(&n, |n| truncation(n, boundary, mean, dim));
                println!("scalar map, {boundary:?} {mean:?} {dim}D: order {order:.3}");
                assert!((order - 2.0).abs() < 0.15, "{order}");
            }
        }
    }
}

/// Steady flux through two media: only the harmonic mean gives it exactly.
#[test]
fn harmonic_mean_is_exact_across_a_jump() {
    let grid = Grid::new(&[20], 1.0).unwrap();
    let d = |x: f64| if x < 9.5 { 1.0 } else { 50.0 };
    let values = Field::from_fn(grid, |[x, ..]| d(x));
    // A flux of 1 everywhere, with the kink on the face at 9.5.
    let u = Field::from_fn(grid, |[x, ..]| (x - 9.5) / d(x));
    let mut flow = vec![0.0; 20];
    let mut largest = |mean| {
        let map = Diffusivity::Map { values: values.clone(), mean };
        Operator::new(grid, Boundary::Neumann, &map).unwrap().apply(u.as_slice(), &mut flow);
        flow[1..19].iter().fold(0.0, |m: f64, f| m.max(f.abs()))
    };
    assert!(largest(FaceMean::Harmonic) < 1e-13);
    assert!(largest(FaceMean::Arithmetic) > 1.0);
}

/// The covariance of a blob grows at exactly 2 D, for tensors in any direction.
#[test]
fn second_moments_of_a_blob_grow_at_twice_the_tensor() {
    let turned = Tensor::rotated(3.0, 0.1, 0.35);
    let solid = Tensor { xx: 2.0, yy: 1.5, zz: 1.0, xy: -0.9, xz: 0.7, yz: 0.4 };
    for (t, shape) in [(turned, vec![40, 44]), (solid, vec![32, 30, 34])] {
        let (grid, dim) = (Grid::new(&shape, 0.5).unwrap(), shape.len());
        let center = grid.center();
        let blob = Field::from_fn(grid, |p| {
            (-1.5 * (0..3).map(|a| (p[a] - center[a]).powi(2)).sum::<f64>()).exp()
        });
        let diffusivity = Diffusivity::Tensor(vec![t]);
        let operator = Operator::new(grid, Boundary::Neumann, &diffusivity).unwrap();
        let mut rate = vec![0.0; grid.len()];
        operator.apply(blob.as_slice(), &mut rate);
        let mass: f64 = blob.as_slice().iter().sum();
        let moment = |a: usize, b: usize| {
            let arm = |n: usize, axis: usize| grid.position(n)[axis] - center[axis];
            (0..grid.len()).map(|n| arm(n, a) * arm(n, b) * rate[n]).sum::<f64>() / mass
        };
        let wanted =
            [(0, 0, t.xx), (1, 1, t.yy), (0, 1, t.xy), (2, 2, t.zz), (0, 2, t.xz), (1, 2, t.yz)];
        for &(a, b, d) in if dim == 2 { &wanted[..3] } else { &wanted[..] } {
            // At the border the blob is exp(-79) of its peak; the sums round.
            let found = moment(a, b);
            assert!((found - 2.0 * d).abs() < 1e-10, "{dim}D {a}{b}: {found} for {}", 2.0 * d);
        }
    }
}

/// Largest error of the solution of `u - div(D grad u) = f`.
fn solution_error(
    n: usize,
    boundary: Boundary,
    tensor: &dyn Fn(f64, f64) -> Tensor,
    gradient: &dyn Fn(f64, f64) -> [f64; 2],
    exact: &dyn Fn(f64, f64) -> f64,
) -> f64 {
    let h = TAU / n as f64;
    let grid = Grid::new(&[n, n], h).unwrap();
    let flux = |x: f64, y: f64| {
        let (t, [ux, uy]) = (tensor(x, y), gradient(x, y));
        [t.xx * ux + t.xy * uy, t.xy * ux + t.yy * uy]
    };
    // Differences of fourth order over 1e-3: an error of 1e-12.
    let divergence = |x: f64, y: f64| {
        let side = |s: f64| flux(x + 1e-3 * s, y)[0] + flux(x, y + 1e-3 * s)[1];
        (8.0 * (side(1.0) - side(-1.0)) - (side(2.0) - side(-2.0))) / 12e-3
    };
    let points: Vec<[f64; 2]> = (0..grid.len())
        .map(|i| grid.position(i))
        .map(|p| [p[0] + 0.5 * h, p[1] + 0.5 * h])
        .collect();
    let tensors = Diffusivity::Tensor(points.iter().map(|&[x, y]| tensor(x, y)).collect());
    let matrix = Operator::new(grid, boundary, &tensors).unwrap().matrix(1.0, -1.0).unwrap();
    let order = nested_dissection(&[n, n], boundary == Boundary::Periodic);
    let symbolic = Symbolic::new(&matrix, Ordering::Custom(&order)).unwrap();
    let factor = Cholesky::new(symbolic, &matrix).unwrap();
    let mut u: Vec<f64> = points.iter().map(|&[x, y]| exact(x, y) - divergence(x, y)).collect();
    factor.solve(&mut u, &mut factor.scratch(1));
    points.iter().zip(&u).map(|(&[x, y], u)| (u - exact(x, y)).abs()).fold(0.0, f64::max)
}

/// The tensor turns from place to place, so its stencil changes too.
#[test]
fn varying_tensors_give_solutions_of_second_order() {
    let error = |n| {
        solution_error(
            n,
            Boundary::Periodic,
            &|x, y| Tensor::rotated(2.0, 0.2, 0.8 * x.sin() * y.cos()),
            &|x, y| [(x + y).cos() - x.sin(), (x + y).cos()],
            &|x, y| (x + y).sin() + x.cos(),
        )
    };
    let order = observed_order(&[64, 128, 256], error);
    println!("varying tensor, periodic: order {order:.3}");
    assert!(order > 1.8, "{order}");
}

/// Zero flux at a border where the tensor is slanted and so is the gradient:
/// `u = cos(y/2) + sin(x) g(y)` with `D_xx g = -D_xy d/dy cos(y/2)`. Mirroring the bonds
/// that leave the grid changes a layer of one stencil's width, an error of first order.
#[test]
fn slanted_tensors_at_a_neumann_border_are_of_first_order() {
    let tensor = Tensor::rotated(2.0, 0.5, 0.5);
    let fade = |y: f64| 0.5 * (1.0 - y.cos());
    let c = 0.5 * tensor.xy / tensor.xx;
    let error = |n| {
        solution_error(
            n,
            Boundary::Neumann,
            &|_, y| Tensor { xy: tensor.xy * fade(y), ..tensor },
            &|x, y| {
                let (s, half) = ((0.5 * y).sin(), 0.5 * (0.5 * y).cos());
                let slope = 0.5 * y.sin() * s + fade(y) * half;
                [x.cos() * c * fade(y) * s, -0.5 * s + x.sin() * c * slope]
            },
            &|x, y| (0.5 * y).cos() + x.sin() * c * fade(y) * (0.5 * y).sin(),
        )
    };
    let order = observed_order(&[32, 64, 128], error);
    println!("slanted tensor, Neumann: order {order:.3}, error {:.1e} at 128 cells", error(128));
    assert!(order > 0.9, "{order}");
}

#[test]
fn bad_diffusivities_are_named() {
    let grid = Grid::new(&[4, 5], 1.0).unwrap();
    let new = |d: &Diffusivity| Operator::new(grid, Boundary::Neumann, d).unwrap_err().to_string();
    assert!(new(&Diffusivity::Constant(-1.0)).contains("diffusivity = -1 is outside"));
    let mut tensors = vec![Tensor::rotated(1.0, 0.5, PI / 3.0); 20];
    tensors[7].xx = -1.0;
    let message = new(&Diffusivity::Tensor(tensors));
    assert!(message.starts_with("at node (j, i) = (1, 2): diffusion tensor"), "{message}");
    assert!(new(&Diffusivity::Tensor(vec![])).contains("has shape [0], expected [4, 5]"));
}
