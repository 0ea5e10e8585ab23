#![expect(
    clippy::print_stdout,
    reason = "measured figures are printed for the reader of a test run"
)]

use super::*;
use crate::{Grid, random};
use nalgebra_sparse::CscMatrix;

/// `shift + ` the 2D Dirichlet Laplacian with random positive conductances.
fn grid_matrix([ny, nx]: [usize; 2], shift: f64, index: u64) -> SymmetricMatrix {
    let mut stream = random::stream(3, "conductance", index);
    let mut triplets = Vec::new();
    for n in 0..ny * nx {
        triplets.push((n, n, shift));
        let beside = [(n % nx + 1 < nx).then_some(n + 1), (n + nx < ny * nx).then_some(n + nx)];
        for other in beside.into_iter().flatten() {
            let w = 0.1 + random::uniform(&mut stream);
            triplets.extend([(n, n, w), (other, other, w), (other, n, -w), (n, other, -w)]);
        }
    }
    SymmetricMatrix::from_triplets(ny * nx, triplets).unwrap()
}

fn residual(matrix: &SymmetricMatrix, x: &[f64], b: &[f64]) -> f64 {
    let mut product = vec![0.0; x.len()];
    matrix.multiply(x, &mut product);
    product.iter().zip(b).map(|(p, b)| (p - b).abs()).fold(0.0, f64::max)
}

/// Both orderings, several values of one pattern, several right-hand sides at once.
#[test]
fn solutions_satisfy_their_systems() {
    let shape = [23, 31];
    let n = shape[0] * shape[1];
    let order = nested_dissection(&shape, false);
    for ordering in [Ordering::Amd, Ordering::Custom(&order)] {
        let first = grid_matrix(shape, 0.5, 0);
        let symbolic = Symbolic::new(&first, ordering).unwrap();
        let mut factor = Cholesky::new(symbolic, &first).unwrap();
        let mut scratch = factor.scratch(3);
        for index in 1..3 {
            let matrix = grid_matrix(shape, 0.5, index);
            factor.refactorize(&matrix).unwrap();
            let mut stream = random::stream(4, "right-hand side", index);
            let b: Vec<f64> = (0..3 * n).map(|_| random::normal(&mut stream)).collect();
            let mut x = b.clone();
            factor.solve(&mut x, &mut scratch);
            let mut single = b[n..2 * n].to_vec();
            factor.solve(&mut single, &mut scratch);
            for (x, b) in x.chunks(n).chain([&single[..]]).zip(b.chunks(n).chain([&b[n..2 * n]])) {
                // Condition number 10/0.5: a few hundred round-offs at most.
                assert!(residual(&matrix, x, b) < 1e-13);
            }
        }
    }
}

/// In three dimensions and with diagonal neighbours, as for elements. For the five points
/// of a plane Laplacian minimum degree fills less.
#[test]
fn dissection_fills_less_than_minimum_degree_in_three_dimensions() {
    let grid = Grid::new(&[24, 16, 16], 1.0).unwrap();
    let touch = |a: usize, b: usize| {
        let (a, b) = (grid.node(a), grid.node(b));
        (0..3).all(|axis| a[axis].abs_diff(b[axis]) <= 1)
    };
    // A neighbour's index is at most one plane, one row and one node away.
    let triplets = (0..grid.len()).flat_map(|n| {
        let last = (n + 16 * 16 + 16 + 2).min(grid.len());
        (n..last).filter(move |&m| touch(m, n)).map(move |m| (m, n, 1.0))
    });
    let matrix = SymmetricMatrix::from_triplets(grid.len(), triplets).unwrap();
    let order = nested_dissection(grid.axes(), false);
    let entries = |ordering| Symbolic::new(&matrix, ordering).unwrap().factor_entries();
    let (degree, own) = (entries(Ordering::Amd), entries(Ordering::Custom(&order)));
    println!("entries of the factor, 24 x 16 x 16: minimum degree {degree}, dissection {own}");
    assert!(own < degree);
}

#[test]
fn the_row_of_a_bad_pivot_is_named() {
    // Path of three nodes, the middle one with a negative diagonal.
    let triplets = [(0, 0, 2.0), (1, 0, -1.0), (1, 1, -1.0), (2, 1, -1.0), (2, 2, 2.0)];
    let matrix = SymmetricMatrix::from_triplets(3, triplets).unwrap();
    for order in [[0, 2, 1], [1, 0, 2]] {
        let symbolic = Symbolic::new(&matrix, Ordering::Custom(&order)).unwrap();
        let message = Cholesky::new(symbolic, &matrix).unwrap_err().to_string();
        assert!(message.contains("pivot in row 1 is not above 0"), "{message}");
    }
}

#[test]
fn unusable_inputs_are_refused() {
    let good = SymmetricMatrix::from_triplets(2, [(0, 0, 1.0), (1, 1, 1.0)]).unwrap();
    let symbolic = Symbolic::new(&good, Ordering::Amd).unwrap();
    let mut factor = Cholesky::new(symbolic, &good).unwrap();
    let mut nan = good.clone();
    nan.values_mut()[1] = f64::NAN;
    let message = factor.refactorize(&nan).unwrap_err().to_string();
    assert_eq!(message, "matrix entry in row 1 is NaN");
    let more = SymmetricMatrix::from_triplets(2, [(0, 0, 1.0), (1, 0, 0.1), (1, 1, 1.0)]).unwrap();
    assert!(factor.refactorize(&more).unwrap_err().to_string().contains("[2, 3]"));
    assert!(Symbolic::new(&good, Ordering::Custom(&[0, 0])).is_err());
    assert!(Symbolic::new(&good, Ordering::Custom(&[0])).is_err());
    assert!(SymmetricMatrix::from_triplets(2, [(0, 2, 1.0)]).is_err());
    assert!(SymmetricMatrix::from_csc(CscMatrix::zeros(2, 3)).is_err());
}
