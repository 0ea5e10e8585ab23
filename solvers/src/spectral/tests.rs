#![expect(
    clippy::print_stdout,
    reason = "measured figures are printed for the reader of a test run"
)]

use super::*;
use crate::{Boundary, Field, Grid, random};
use std::f64::consts::{PI, TAU};

fn noise(grid: Grid) -> Vec<f64> {
    let mut stream = random::stream(1, "noise", 0);
    (0..grid.len()).map(|_| random::normal(&mut stream)).collect()
}

const SHAPES: [&[usize]; 7] = [&[1], &[7], &[64], &[6, 9], &[33, 40], &[5, 4, 7], &[16, 18, 20]];

/// Every coefficient by its defining sum, to round-off of sums of up to 1320 terms.
#[test]
fn coefficients_are_the_defining_sums() {
    for shape in &SHAPES[..5] {
        let grid = Grid::new(shape, 0.5).unwrap();
        let u = noise(grid);
        for boundary in [Boundary::Periodic, Boundary::Neumann] {
            let mut transform = Transform::new(grid, boundary).unwrap();
            let mut modes = vec![0.0; grid.len()];
            transform.forward(&u, &mut modes);
            let basis = |m: usize, j: usize, n: usize| match boundary {
                Boundary::Periodic => {
                    let angle = -TAU * (m.div_ceil(2) * j) as f64 / n as f64;
                    if m % 2 == 1 || m == 0 { angle.cos() } else { angle.sin() }
                }
                _ => (PI * (m * (2 * j + 1)) as f64 / (2 * n) as f64).cos(),
            };
            let [_, ny, nx] = grid.shape();
            for (index, &mode) in modes.iter().enumerate() {
                let [mx, my, _] = transform.mode(index);
                assert_eq!(transform.index([mx, my, 0]), index);
                let sum: f64 = (0..grid.len())
                    .map(|n| {
                        let [_, j, i] = grid.node(n);
                        u[n] * basis(mx, i, nx) * basis(my, j, ny)
                    })
                    .sum();
                assert!((sum - mode).abs() < 1e-11, "{shape:?} {boundary:?} {index}: {sum} {mode}");
            }
        }
    }
}

#[test]
fn inverse_undoes_forward_and_power_sums_to_the_mean_square() {
    for shape in SHAPES {
        let grid = Grid::new(shape, 0.5).unwrap();
        let u = noise(grid);
        for boundary in [Boundary::Periodic, Boundary::Neumann] {
            let mut transform = Transform::new(grid, boundary).unwrap();
            let (mut modes, mut back) = (vec![0.0; grid.len()], vec![0.0; grid.len()]);
            transform.forward(&u, &mut modes);
            let weight = transform.weights();
            let power: f64 =
                modes.iter().enumerate().map(|(m, c)| c * c * weight(transform.mode(m))).sum();
            let square = u.iter().map(|u| u * u).sum::<f64>() / grid.len() as f64;
            assert!((power / square - 1.0).abs() < 1e-13, "{shape:?} {boundary:?}");
            drop(weight);
            transform.inverse(&mut modes, &mut back);
            let error = back.iter().zip(&u).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(error < 1e-14, "{shape:?} {boundary:?}: {error:e}");
        }
    }
}

/// A product of basis functions is multiplied by the Laplacian's symbol, in three dimensions.
#[test]
fn stencils_are_diagonal() {
    let grid = Grid::new(&[6, 8, 5], 0.5).unwrap();
    let u = noise(grid);
    for boundary in [Boundary::Periodic, Boundary::Neumann] {
        let mut transform = Transform::new(grid, boundary).unwrap();
        for (laplacian, diagonal) in
            [(LaplacianSymbol::Axes, 0.0), (LaplacianSymbol::Isotropic, 1.0)]
        {
            let (mut modes, mut found) = (vec![0.0; grid.len()], vec![0.0; grid.len()]);
            transform.forward(&u, &mut modes);
            let symbol = transform.map_modes(|k| -laplacian.at(k, 0.5));
            modes.iter_mut().zip(&symbol).for_each(|(m, s)| *m *= s);
            transform.inverse(&mut modes, &mut found);
            for (index, &found) in found.iter().enumerate() {
                let mut sum = 0.0;
                for offset in 0..27_isize {
                    let step = [offset / 9 - 1, offset / 3 % 3 - 1, offset % 3 - 1];
                    let weight = match step.iter().filter(|&&s| s != 0).count() {
                        1 => 1.0 - diagonal * 2.0 / 3.0,
                        2 => diagonal / 6.0,
                        _ => 0.0,
                    };
                    let (node, shape) = (grid.node(index), grid.shape());
                    let [k, j, i] =
                        [0, 1, 2].map(|a| boundary.wrap(node[a] as isize + step[a], shape[a]));
                    sum += weight * (u[grid.index(k, j, i)] - u[index]) / 0.25;
                }
                assert!((sum - found).abs() < 1e-12, "{boundary:?} {laplacian:?}: {sum} {found}");
            }
        }
    }
}

fn relative_error(field: &Field, boundary: Boundary, window: Window<'_>, wavelength: f64) -> f64 {
    let spectrum = RadialSpectrum::new(field, boundary, window).unwrap();
    (spectrum.peak_wavelength().unwrap() / wavelength - 1.0).abs()
}

/// Plane waves of any length and direction, cut out by a Hann window, within 0.5 %.
#[test]
fn plane_waves_are_measured() {
    let grid = Grid::new(&[128, 128], 0.5).unwrap();
    let mut worst: f64 = 0.0;
    for wavelength in [3.1, 4.443, 5.77, 8.0] {
        for angle in [0.0, 0.3, 0.8, 1.9] {
            let (s, c) = f64::sin_cos(angle);
            let wave = |[x, y, _]: [f64; 3]| 4.0 + (TAU * (c * x + s * y) / wavelength + 0.4).sin();
            let field = Field::from_fn(grid, wave);
            worst = worst.max(relative_error(&field, Boundary::Periodic, Window::Hann, wavelength));
        }
    }
    println!("plane waves: largest relative error of the wavelength {worst:.5}");
    assert!(worst < 0.005);
    // A wave that fits the series is met exactly.
    let field = Field::from_fn(grid, |[x, y, _]| (TAU * (3.0 * x - 5.0 * y) / 64.0).cos());
    let wavelength = 64.0 / 34.0_f64.sqrt();
    assert!(relative_error(&field, Boundary::Periodic, Window::None, wavelength) < 1e-12);
}

/// Gaussian spots on a hexagonal lattice of row distance d: wavelength d.
#[test]
fn hexagonal_spots_are_measured() {
    let grid = Grid::new(&[256, 256], 1.0).unwrap();
    for (distance, angle) in [(8.886, 0.0), (8.886, 0.4), (13.3, 0.1)] {
        let waves = [0.0, 1.0, 2.0].map(|m| {
            let (s, c) = f64::sin_cos(angle + m * PI / 3.0);
            [TAU / distance * c, TAU / distance * s]
        });
        let field = Field::from_fn(grid, |[x, y, _]| {
            let sum: f64 = waves.iter().map(|k| (k[0] * x + k[1] * y).cos()).sum();
            (2.0 * sum).exp()
        });
        for (boundary, window) in
            [(Boundary::Periodic, Window::Hann), (Boundary::Neumann, Window::None)]
        {
            let error = relative_error(&field, boundary, window, distance);
            println!("hexagons {distance} turned by {angle}, {boundary:?}: {error:.5}");
            assert!(error < 0.005, "{distance} {angle} {boundary:?}: {error}");
        }
    }
}

/// Filtered noise of known spectral density: the ring average peaks where the density
/// does; the ring sum would peak 2 % off, at k0 + width^2/k0.
#[test]
fn ring_averages_peak_where_the_density_does() {
    let grid = Grid::new(&[256, 256], 1.0).unwrap();
    let (k0, width, samples) = (0.7, 0.12, 8);
    for boundary in [Boundary::Periodic, Boundary::Neumann] {
        let mut transform = Transform::new(grid, boundary).unwrap();
        let filter = transform
            .map_modes(|[x, y, _]| (-(x.hypot(y) - k0).powi(2) / (4.0 * width * width)).exp());
        let mut errors = Vec::new();
        for sample in 0..samples {
            let mut stream = random::stream(2, "filtered", sample);
            let mut modes: Vec<f64> =
                filter.iter().map(|f| f * random::normal(&mut stream)).collect();
            let mut u = vec![0.0; grid.len()];
            transform.inverse(&mut modes, &mut u);
            let field = Field::from_vec(grid, u).unwrap();
            let spectrum = RadialSpectrum::new(&field, boundary, Window::None).unwrap();
            errors.push(spectrum.peak_wavenumber().unwrap() / k0 - 1.0);
        }
        let mean = errors.iter().sum::<f64>() / samples as f64;
        let worst = errors.iter().fold(0.0, |m: f64, e| m.max(e.abs()));
        println!("noise around {k0}, {boundary:?}: mean error {mean:+.5}, largest {worst:.5}");
        // One sample scatters by 0.55 %: three standard errors of the mean and of one.
        assert!(mean.abs() < 3.0 * 0.0055 / 8.0_f64.sqrt() && worst < 3.0 * 0.0055, "{errors:?}");
    }
}

#[test]
fn direction_of_stripes() {
    let grid = Grid::new(&[96, 128], 1.0).unwrap();
    for (mx, my) in [(9.0, 7.0), (9.0, -7.0), (0.0, 8.0), (12.0, 0.0)] {
        let field =
            Field::from_fn(grid, |[x, y, _]| (TAU * (mx * x / 128.0 + my * y / 96.0) + 1.0).cos());
        let spectrum = AngularSpectrum::new(&field, Window::None, [0.1, 2.0], 36).unwrap();
        let angle = (my / 96.0_f64).atan2(mx / 128.0).rem_euclid(PI);
        let turn = (spectrum.direction - angle).abs();
        assert!(turn.min(PI - turn) < 1e-9, "{mx} {my}: {} {angle}", spectrum.direction);
        assert!((spectrum.order - 1.0).abs() < 1e-12);
        // All of the mean square, 1/2, is in the band.
        assert!((spectrum.power.iter().sum::<f64>() - 0.5).abs() < 1e-12, "{mx} {my}");
    }
}

#[test]
fn the_same_bytes_for_any_number_of_threads() {
    let grid = Grid::new(&[70, 90], 1.0).unwrap();
    let u = noise(grid);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut transform = Transform::new(grid, Boundary::Neumann).unwrap();
            let mut modes = vec![0.0; grid.len()];
            transform.forward(&u, &mut modes);
            modes.iter().map(|m| m.to_bits()).collect::<Vec<_>>()
        })
    };
    assert_eq!(run(1), run(3));
}
