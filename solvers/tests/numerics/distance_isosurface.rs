//! Contours and meshes: closed, oriented, of the right size and topology.

use proptest::prelude::*;
use solvers::isosurface::{Caps, closed_contours, contour_lines, triangulate};
use solvers::level_set::shapes::Point;
use solvers::level_set::{Measures, Shape};
use solvers::mesh::TriangleMesh;
use solvers::order::observed_order;
use solvers::{Boundary, Field, Grid};
use std::f64::consts::PI;

fn ball(x: f64, radius: f64) -> Shape {
    Shape::Circle { center: Point([x, 0.51, 0.48]), radius }
}

fn mesh(shape: &Shape, n: usize) -> TriangleMesh {
    let grid = Grid::new(&[n, n, n], 1.0 / n as f64).unwrap();
    triangulate(&shape.field(grid).unwrap(), 0.0, Caps::Open).unwrap()
}

#[test]
fn sphere_area_and_volume_second_order() {
    let r = 0.31;
    let ns = [16, 32, 64];
    let errors = ns.map(|n| {
        let m = mesh(&ball(0.47, r), n);
        assert!(m.is_closed() && m.is_manifold());
        let area = (m.area() / (4.0 * PI * r * r) - 1.0).abs();
        let volume = (m.volume() / (4.0 / 3.0 * PI * r * r * r) - 1.0).abs();
        println!("sphere {n}^3: area error {area:.2e}, volume error {volume:.2e}");
        (area, volume)
    });
    let order = |f: fn(&(f64, f64)) -> f64| {
        observed_order(&ns, |n| f(&errors[ns.iter().position(|&m| m == n).unwrap()]))
    };
    let (area, volume) = (order(|e| e.0), order(|e| e.1));
    println!("orders: area {area:.2}, volume {volume:.2}");
    assert!(area > 1.9 && volume > 1.9, "{area} {volume}");
}

/// Gauss-Bonnet: the angles missing at the vertices add up to 2 pi chi.
#[test]
fn topology_of_known_surfaces() {
    let torus = Shape::Torus { center: Point([0.5, 0.5, 0.5]), major: 0.27, minor: 0.1 };
    let pair = Shape::Union { shapes: vec![ball(0.27, 0.17), ball(0.73, 0.17)] };
    for (name, shape, chi) in [("sphere", ball(0.5, 0.3), 2), ("torus", torus, 0), ("two", pair, 4)]
    {
        let m = mesh(&shape, 33);
        assert!(m.is_closed() && m.is_manifold(), "{name}");
        assert_eq!(m.euler_characteristic(), chi, "{name}");
        let missing = 2.0 * PI * m.vertices.len() as f64 - angles(&m);
        println!("{name}: angle defect {:.12} x 2 pi", missing / (2.0 * PI));
        // Round-off of about 10^4 arc cosines near 0, each sqrt(eps) at worst.
        assert!((missing / (2.0 * PI) - chi as f64).abs() < 1e-5, "{name}");
        assert!(m.volume() > 0.0, "{name} is inside out");
    }
}

fn angles(m: &TriangleMesh) -> f64 {
    let corner = |a: u32, b: u32, c: u32| {
        let [a, b, c] = [a, b, c].map(|v| m.vertices[v as usize]);
        let (p, q): ([f64; 3], [f64; 3]) =
            (std::array::from_fn(|d| b[d] - a[d]), std::array::from_fn(|d| c[d] - a[d]));
        let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
        let cross =
            [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
        dot(cross, cross).sqrt().atan2(dot(p, q))
    };
    m.triangles.iter().map(|&[a, b, c]| corner(a, b, c) + corner(b, c, a) + corner(c, a, b)).sum()
}

#[test]
fn normals_point_outward() {
    let m = mesh(&ball(0.5, 0.3), 24);
    for (p, n) in m.vertices.iter().zip(m.vertex_normals()) {
        let radial = [p[0] - 0.5, p[1] - 0.51, p[2] - 0.48];
        let cosine = (0..3).map(|d| radial[d] * n[d]).sum::<f64>() / 0.3;
        // Facets of one cell on a sphere of 7 cells tilt by 1/7 at most: cos > .95.
        assert!(cosine > 0.95, "{cosine}");
    }
    assert_eq!(m.triangle_normals().len(), m.triangles.len());
}

#[test]
fn caps_close_a_cut_ball() {
    let grid = Grid::new(&[20, 20, 20], 0.05).unwrap();
    let phi = Shape::Circle { center: Point([0.0, 0.0, 0.0]), radius: 0.6 }.field(grid).unwrap();
    let open = triangulate(&phi, 0.0, Caps::Open).unwrap();
    assert!(!open.is_closed() && open.is_manifold() && open.euler_characteristic() == 1);
    let closed = triangulate(&phi, 0.0, Caps::Closed).unwrap();
    assert!(closed.is_closed() && closed.is_manifold() && closed.euler_characteristic() == 2);
    assert!(closed.border().is_empty());
    let at_face = |&v: &u32| open.vertices[v as usize].iter().any(|&x| x < 1e-12);
    assert!((0..open.vertices.len() as u32).filter(at_face).eq(open.border()));
    let measured = Measures::of(&phi, Boundary::Neumann).area;
    println!("cut ball: mesh {:.6}, measure {measured:.6}", closed.volume());
    // Caps stand .0005 cell off the faces: .05 * .0005 * area of the caps (~ 1) at most.
    assert!((closed.volume() - measured).abs() < 5e-5);
    let flat = Field::constant(Grid::new(&[4, 4], 1.0).unwrap(), 1.0);
    assert!(
        triangulate(&flat, 0.0, Caps::Open).unwrap_err().to_string().contains("number of axes")
    );
}

#[test]
fn ellipse_lines_second_order() {
    let (a, b) = (0.41_f64, 0.23_f64);
    // Ramanujan's second formula, relative error below 1e-9 at this ratio.
    let m = ((a - b) / (a + b)).powi(2);
    let perimeter = PI * (a + b) * (1.0 + 3.0 * m / (10.0 + (4.0 - 3.0 * m).sqrt()));
    let ns = [32, 64, 128, 256];
    let errors = ns.map(|n| {
        let grid = Grid::new(&[n, n], 1.0 / n as f64).unwrap();
        let shape = Shape::Ellipse { center: Point([0.493, 0.507, 0.0]), radii: vec![a, b] };
        let lines = contour_lines(&shape.field(grid).unwrap(), 0.0);
        assert!(lines.len() == 1 && lines[0].closed);
        let errors = (
            (lines[0].area() / (PI * a * b) - 1.0).abs(),
            (lines[0].length() / perimeter - 1.0).abs(),
        );
        println!("ellipse {n}: area error {:.2e}, perimeter error {:.2e}", errors.0, errors.1);
        errors
    });
    let at = |n: usize| errors[ns.iter().position(|&m| m == n).unwrap()];
    let (area, length) = (observed_order(&ns, |n| at(n).0), observed_order(&ns, |n| at(n).1));
    println!("orders: area {area:.2}, perimeter {length:.2}");
    assert!(area > 1.9 && length > 1.9, "{area} {length}");
}

#[test]
fn saddles_join_by_the_bilinear_interpolant() {
    let grid = Grid::new(&[2, 2], 1.0).unwrap();
    let lines = |inside: f64| {
        let phi = Field::from_vec(grid, vec![-inside, 1.0, 1.0, -inside]).unwrap();
        closed_contours(&phi, 0.0).len()
    };
    // Saddle value (inside^2 - 1) / (-2 inside - 2): below 0 for inside > 1.
    assert_eq!((lines(2.0), lines(0.5)), (1, 2));
}

fn random_field(shape: &[usize], values: Vec<f64>) -> Field {
    Field::from_vec(Grid::new(shape, 1.0).unwrap(), values).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]

    /// White noise meets every case of every cell, zeros included.
    #[test]
    fn noise_makes_manifolds(values in prop::collection::vec((-4..4_i32).prop_map(f64::from), 6 * 5 * 7)) {
        let phi = random_field(&[6, 5, 7], values);
        let open = triangulate(&phi, 0.0, Caps::Open).unwrap();
        prop_assert!(open.is_manifold());
        let closed = triangulate(&phi, 0.0, Caps::Closed).unwrap();
        prop_assert!(closed.is_manifold() && closed.is_closed());
        let measured = Measures::of(&phi, Boundary::Neumann).area;
        // The margin moves vertices by 1e-4, the caps by 5e-4 of a cell, over about 1000 squares.
        prop_assert!((closed.volume() - measured).abs() < 0.6, "{} {}", closed.volume(), measured);
    }

    #[test]
    fn noise_makes_closed_lines(values in prop::collection::vec((-4..4_i32).prop_map(f64::from), 9 * 11)) {
        let phi = random_field(&[9, 11], values);
        let h = 1.0;
        for line in contour_lines(&phi, 0.0).iter().filter(|l| !l.closed) {
            for end in [line.points[0], line.points[line.points.len() - 1]] {
                let on_border = end[0] == 0.0 || end[1] == 0.0 || end[0] == 10.0 * h || end[1] == 8.0 * h;
                prop_assert!(on_border, "{:?}", end);
            }
        }
        let regions = closed_contours(&phi, 0.0);
        prop_assert!(regions.iter().all(|line| line.closed));
        let area: f64 = regions.iter().map(|line| line.area()).sum();
        let measured = Measures::of(&phi, Boundary::Neumann).area;
        prop_assert!((area - measured).abs() < 1e-9, "{} {}", area, measured);
    }
}
