//! Reinitialization and velocity extension, against exact distances and angles.

use super::level_set_support::{Read, area, contour_error, distance, unit};
use solvers::level_set::{extend_speed, reinitialize};
use solvers::{Boundary, Field, Grid, order::observed_order};

const SIZES: [usize; 4] = [32, 64, 128, 256];

/// Signed distance to the ellipse of half-axes 4 and 2 around (5, 5): the nearest of
/// many points, then Newton's method for the foot of the perpendicular.
fn ellipse([x, y, _]: [f64; 3]) -> f64 {
    let (a, b, x, y) = (4.0, 2.0, x - 5.0, y - 5.0);
    let to = |t: f64| (a * t.cos() - x).hypot(b * t.sin() - y);
    let angles = (0..200).map(|k| f64::from(k) * std::f64::consts::TAU / 200.0);
    let mut t = angles.min_by(|&s, &t| to(s).total_cmp(&to(t))).unwrap();
    for _ in 0..20 {
        let (px, py, dx, dy) = (a * t.cos() - x, b * t.sin() - y, -a * t.sin(), b * t.cos());
        t -= (px * dx + py * dy) / (dx * dx + dy * dy - px * a * t.cos() - py * b * t.sin());
    }
    to(t).copysign((x / a).powi(2) + (y / b).powi(2) - 1.0)
}

/// The distorted ellipse of Russo & Smereka 2000, eq. (21): slopes from 0.05 to 40.
fn distorted(n: usize) -> Field {
    let grid = Grid::new(&[n + 1, n + 1], 10.0 / n as f64).unwrap();
    Field::from_fn(grid, |[x, y, _]| {
        let (x, y) = (x - 5.0, y - 5.0);
        let stretch = 0.1 + (x - 3.5).powi(2) + (y - 2.0).powi(2);
        stretch * (((x / 4.0).powi(2) + (y / 2.0).powi(2)).sqrt() - 1.0)
    })
}

/// Greatest |phi - distance| (node distances) where |distance| < 1.5 h.
fn near_error(phi: &Field) -> f64 {
    let (grid, h) = (phi.grid(), phi.grid().spacing());
    let errors = phi.as_slice().iter().enumerate().filter_map(|(n, v)| {
        let d = ellipse(grid.position(n));
        (d.abs() < 1.5 * h).then_some((v - d).abs() / h)
    });
    errors.fold(0.0, f64::max)
}

#[test]
fn distorted_ellipse_becomes_a_distance() {
    // References at n = 32 .. 256: near error .38 .. .05 h, contour moves .057 .. .015 h.
    let mut near = [0.0; 4];
    for (slot, n) in near.iter_mut().zip(SIZES) {
        let mut phi = distorted(n);
        reinitialize(&mut phi, 20, Boundary::Extrapolate);
        let moved = contour_error(&phi, Read::Linear, ellipse);
        let moved_eno = contour_error(&phi, Read::Eno, ellipse);
        *slot = near_error(&phi);
        reinitialize(&mut phi, 100, Boundary::Extrapolate);
        let later = contour_error(&phi, Read::Linear, ellipse);
        println!(
            "Russo-Smereka ellipse, n = {n}: near error {slot:.4} h, contour off by {moved:.4} h \
             read linearly ({moved_eno:.4} h with ENO), {later:.4} h after six times as many steps"
        );
        assert!(*slot < 0.05 && moved < 0.015);
        // The linear read-out is blind below its own error, h / 16 of the greatest curvature.
        assert!(later < moved + 1e-3, "the contour drifts");
    }
    let order = observed_order(&SIZES, |n| near[n.ilog2() as usize - 5] / n as f64);
    println!("Russo-Smereka ellipse: near error of order {order:.2}");
    assert!(order > 2.0);
}

#[test]
fn reinitialized_front_keeps_its_area() {
    let start = distorted(64);
    let mut phi = start.clone();
    reinitialize(&mut phi, 60, Boundary::Neumann);
    let exact = 8.0 * std::f64::consts::PI;
    let h = phi.grid().spacing();
    println!("area {:.5}, exact {exact:.5}", area(&phi));
    // Inscribed polygon: the chords lose 2 pi h^2 / 12 and half as much again.
    assert!((area(&phi) - exact).abs() < 0.8 * h * h);
}

#[test]
fn a_distance_is_a_fixed_point_in_1d_and_3d() {
    let line = Field::from_fn(Grid::new(&[40], 0.1).unwrap(), |[x, _, _]| 1.23 - x);
    let mut phi = line.clone();
    reinitialize(&mut phi, 50, Boundary::Extrapolate);
    let gap = |a: &Field, b: &Field| {
        a.as_slice().iter().zip(b.as_slice()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    // Rounding only.
    assert!(gap(&phi, &line) < 1e-13);
    let center = [0.5; 3];
    let sphere = Field::from_fn(unit(3, 24), |p| distance(p, center) - 0.31);
    let mut phi = sphere.clone();
    phi.as_mut_slice().iter_mut().for_each(|v| *v *= 3.0 + *v);
    reinitialize(&mut phi, 40, Boundary::Extrapolate);
    let near = |phi: &Field| {
        let pairs = phi.as_slice().iter().zip(sphere.as_slice());
        pairs.filter(|(_, d)| d.abs() < 0.0625).map(|(a, d)| (a - d).abs()).fold(0.0, f64::max)
    };
    println!("sphere, n = 24: error within 1.5 h {:.4} h", near(&phi) * 24.0);
    assert!(near(&phi) < 0.05 / 24.0, "the reference's best in 2D");
}

#[test]
fn nodes_on_the_front_stay_there() {
    let grid = Grid::new(&[9, 9], 1.0).unwrap();
    let mut phi = Field::from_fn(grid, |[x, _, _]| 5.0 * (x - 4.0));
    reinitialize(&mut phi, 30, Boundary::Neumann);
    for j in 0..9 {
        // Exact within ten contractions by 1/2 per node of depth; the border lies 4 nodes off.
        assert_eq!(phi.at(0, j, 4), 0.0);
        assert!((phi.at(0, j, 6) - 2.0).abs() < 1e-3, "{}", phi.at(0, j, 6));
    }
}

/// A value that depends on the angle around the center only.
fn by_angle([x, y, z]: [f64; 3], center: [f64; 3]) -> f64 {
    let angle = (y - center[1]).atan2(x - center[0]);
    let latitude = (z - center[2]).atan2((x - center[0]).hypot(y - center[1]));
    // Smooth at the poles too.
    (3.0 * angle).sin() * latitude.cos().powi(3) + 0.3 * angle.cos() * latitude.cos()
}

/// Greatest error of the extension within `band` of the front of a circle or sphere.
fn extension_error(dim: usize, n: usize, band: f64) -> f64 {
    let center = [0.52, 0.49, if dim == 3 { 0.51 } else { 0.0 }];
    let phi = Field::from_fn(unit(dim, n), |p| distance(p, center) - 0.3);
    // Right on the front only: the factor r / 0.3 off it must not leak into the extension.
    let mut speed = Field::from_fn(phi.grid(), |p| by_angle(p, center) * distance(p, center) / 0.3);
    extend_speed(&phi, &mut speed, Boundary::Neumann).unwrap();
    let grid = phi.grid();
    let errors = (0..grid.len())
        .filter(|&m| phi.as_slice()[m].abs() < band)
        .map(|m| (speed.as_slice()[m] - by_angle(grid.position(m), center)).abs());
    errors.fold(0.0, f64::max)
}

#[test]
fn extension_is_constant_along_normals() {
    let near = observed_order(&SIZES, |n| extension_error(2, n, 1.5 / n as f64));
    let band = observed_order(&SIZES[1..], |n| extension_error(2, n, 0.1));
    println!("extension: order {near:.2} next to the front, {band:.2} within 0.1");
    println!("extension: error within 0.1 {:.1e} at n = 256", extension_error(2, 256, 0.1));
    assert!(near > 1.8, "second order within the scatter of the crossings");
    assert!(band > 1.8);
    let space = observed_order(&[24, 48], |n| extension_error(3, n, 0.1));
    println!("extension in 3D: order {space:.2} within 0.1");
    assert!(space > 1.3);
}

#[test]
fn extension_crosses_a_periodic_border() {
    // The front x = 0.05 is nearer to the nodes at the right border through the left one.
    let grid = Grid::new(&[4, 10], 0.1).unwrap();
    let wrap = |x: f64| (x - 0.05 + 0.5).rem_euclid(1.0) - 0.5;
    let phi = Field::from_fn(grid, |[x, _, _]| wrap(x));
    let mut speed = Field::from_fn(grid, |[_, y, _]| 7.0 + y);
    extend_speed(&phi, &mut speed, Boundary::Periodic).unwrap();
    for j in 0..4 {
        assert!((speed.at(0, j, 9) - (7.0 + 0.1 * j as f64)).abs() < 1e-12);
    }
    let other = Field::constant(Grid::new(&[4, 9], 0.1).unwrap(), 0.0);
    let message = extend_speed(&other, &mut speed, Boundary::Periodic).unwrap_err().to_string();
    assert_eq!(message, "speed has shape [4, 10], expected [4, 9]");
}
