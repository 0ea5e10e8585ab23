//! Areas, perimeters, components and Euler numbers.

use proptest::prelude::*;
use solvers::level_set::shapes::Point;
use solvers::level_set::{Measures, Shape, label_components};
use solvers::order::observed_order;
use solvers::{Boundary, Field, Grid};
use std::f64::consts::PI;

#[test]
fn circle_and_sphere_second_order() {
    let r = 0.31;
    for (dim, area, perimeter) in
        [(2, PI * r * r, 2.0 * PI * r), (3, 4.0 / 3.0 * PI * r * r * r, 4.0 * PI * r * r)]
    {
        let ns = [16, 32, 64];
        let errors = ns.map(|n| {
            let grid = Grid::new(&vec![n; dim], 1.0 / n as f64).unwrap();
            let center = Point([0.49, 0.51, if dim == 3 { 0.47 } else { 0.0 }]);
            let phi = Shape::Circle { center, radius: r }.field(grid).unwrap();
            let m = Measures::of(&phi, Boundary::Neumann);
            assert_eq!((m.components, m.holes, m.euler_number), (1, 0, 1));
            let errors = ((m.area / area - 1.0).abs(), (m.perimeter / perimeter - 1.0).abs());
            println!("{dim}D ball, n = {n}: area {:.2e}, perimeter {:.2e}", errors.0, errors.1);
            errors
        });
        let at = |n: usize| errors[ns.iter().position(|&m| m == n).unwrap()];
        let orders = (observed_order(&ns, |n| at(n).0), observed_order(&ns, |n| at(n).1));
        println!("{dim}D ball: orders {orders:.2?}");
        assert!(orders.0 > 1.9 && orders.1 > 1.9, "{orders:?}");
    }
}

#[test]
fn the_border_counts_half_a_cell() {
    // Left half of the domain: from x = -h/2 to the middle.
    let grid = Grid::new(&[10, 20], 0.5).unwrap();
    let phi = Field::from_fn(grid, |[x, _, _]| x - 4.75);
    let m = Measures::of(&phi, Boundary::Neumann);
    assert!((m.area - 25.0).abs() < 1e-12 && (m.perimeter - 5.0).abs() < 1e-12, "{m:?}");
    let line = Field::from_fn(Grid::new(&[20], 0.5).unwrap(), |[x, _, _]| (x - 4.0).abs() - 1.3);
    let m = Measures::of(&line, Boundary::Neumann);
    assert!((m.area - 2.6).abs() < 1e-12 && m.perimeter == 2.0 && m.components == 1, "{m:?}");
}

#[test]
fn topology_with_and_without_periods() {
    let grid = Grid::new(&[40, 40], 1.0).unwrap();
    // A stripe around the period: one component, no disk.
    let stripe = Field::from_fn(grid, |[x, _, _]| (x - 20.0).abs() - 5.0);
    let euler = |b| Measures::of(&stripe, b).euler_number;
    assert_eq!((euler(Boundary::Neumann), euler(Boundary::Periodic)), (1, 0));
    // Four quarter disks at the corners are one disk.
    let corners = Field::from_fn(grid, |[x, y, _]| x.min(40.0 - x).hypot(y.min(40.0 - y)) - 6.0);
    let counts = |b| Measures::of(&corners, b).components;
    assert_eq!((counts(Boundary::Neumann), counts(Boundary::Periodic)), (4, 1));
    let m = Measures::of(&corners, Boundary::Periodic);
    assert!((m.area / (36.0 * PI) - 1.0).abs() < 0.02, "{m:?}");
    // A hollow ball and a ring in space.
    let cube = Grid::new(&[24, 24, 24], 1.0).unwrap();
    let shell = Field::from_fn(cube, |[x, y, z]| {
        ((x - 12.0).hypot(y - 11.0).hypot(z - 11.5) - 7.0).abs() - 2.0
    });
    let m = Measures::of(&shell, Boundary::Neumann);
    assert_eq!((m.components, m.holes, m.euler_number), (1, 1, 2));
    let torus = Shape::Torus { center: Point([11.5, 12.0, 11.0]), major: 7.0, minor: 2.6 };
    let m = Measures::of(&torus.field(cube).unwrap(), Boundary::Neumann);
    assert_eq!((m.components, m.holes, m.euler_number), (1, 0, 0));
}

#[test]
fn components_of_a_minimum_size() {
    let grid = Grid::new(&[20, 20], 1.0).unwrap();
    let mut phi = Field::constant(grid, 1.0);
    for (j, i) in [(2, 2), (2, 3), (3, 2), (3, 3), (3, 4), (10, 10), (11, 11)] {
        phi.as_mut_slice()[grid.index(0, j, i)] = -1.0;
    }
    let m = Measures::of(&phi, Boundary::Neumann);
    // Diagonal neighbours are apart.
    assert_eq!(m.sizes, [5, 1, 1]);
    assert_eq!(m.components_of_at_least(4), (1, 5.0));
    assert_eq!(m.components_of_at_least(6), (0, 0.0));
    let message = label_components(&[true; 3], grid, Boundary::Neumann).unwrap_err().to_string();
    assert_eq!(message, "mask has shape [3], expected [20, 20]");
}

/// Flood fill, the slow way.
fn flood(mask: &[bool], grid: Grid, periodic: bool) -> Vec<u32> {
    let shape = grid.shape();
    let mut labels = vec![0; mask.len()];
    let mut count = 0;
    for start in 0..mask.len() {
        if !mask[start] || labels[start] != 0 {
            continue;
        }
        count += 1;
        let mut stack = vec![start];
        while let Some(n) = stack.pop() {
            if labels[n] != 0 || !mask[n] {
                continue;
            }
            labels[n] = count;
            for axis in 0..3 {
                for step in [-1, 1] {
                    let mut node = grid.node(n).map(|c| c as isize);
                    node[axis] += step;
                    let size = shape[axis] as isize;
                    if periodic {
                        node[axis] = node[axis].rem_euclid(size);
                    } else if !(0..size).contains(&node[axis]) {
                        continue;
                    }
                    let [k, j, i] = node.map(|c| c as usize);
                    stack.push(grid.index(k, j, i));
                }
            }
        }
    }
    labels
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn labels_are_those_of_a_flood_fill(
        mask in prop::collection::vec(prop::bool::weighted(0.55), 5 * 6 * 7), periodic: bool, solid: bool,
    ) {
        let grid = if solid { Grid::new(&[5, 6, 7], 1.0) } else { Grid::new(&[30, 7], 1.0) }.unwrap();
        let boundary = if periodic { Boundary::Periodic } else { Boundary::Neumann };
        let found = label_components(&mask, grid, boundary).unwrap();
        let expected = flood(&mask, grid, periodic);
        prop_assert_eq!(&found.labels, &expected);
        for (m, &size) in found.sizes.iter().enumerate() {
            prop_assert_eq!(size, expected.iter().filter(|&&l| l as usize == m + 1).count());
        }
    }

    #[test]
    fn inside_and_outside_fill_the_domain(
        values in prop::collection::vec(-1.0..1.0_f64, 5 * 6 * 7), periodic: bool, solid: bool,
    ) {
        let grid = if solid { Grid::new(&[5, 6, 7], 0.5) } else { Grid::new(&[30, 7], 0.5) }.unwrap();
        let boundary = if periodic { Boundary::Periodic } else { Boundary::Neumann };
        let phi = Field::from_vec(grid, values).unwrap();
        let mut other = phi.clone();
        other.as_mut_slice().iter_mut().for_each(|v| *v = -*v);
        let (a, b) = (Measures::of(&phi, boundary), Measures::of(&other, boundary));
        let whole = grid.len() as f64 * grid.cell_volume();
        prop_assert!((a.area + b.area - whole).abs() < 1e-10, "{} {} {}", a.area, b.area, whole);
        prop_assert!((a.perimeter - b.perimeter).abs() < 1e-10);
    }
}
