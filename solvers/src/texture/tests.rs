use super::*;
use crate::random::{stream, uniform};

/// A picture of `n` x `n` pixels.
fn picture(n: usize, f: impl Fn(f64, f64) -> bool) -> Vec<bool> {
    (0..n * n).map(|m| f((m % n) as f64 + 0.5, (m / n) as f64 + 0.5)).collect()
}

fn stripes(n: usize, wavelength: f64, angle: f64) -> Vec<bool> {
    picture(n, |x, y| ((x * angle.cos() + y * angle.sin()) / wavelength).rem_euclid(1.0) < 0.4)
}

/// Disks of radius 4 on a square lattice of 16 pixels.
fn disks(n: usize) -> Vec<bool> {
    picture(n, |x, y| (x % 16.0 - 8.0).hypot(y % 16.0 - 8.0) < 4.0)
}

fn boxed(n: usize) -> Vec<bool> {
    (0..n * n).map(|m| !((30..80).contains(&(m % n)) && (40..90).contains(&(m / n)))).collect()
}

#[test]
fn the_wavelength_and_direction_of_stripes_are_found_behind_a_hole() {
    for angle in [0.0, 0.5, 1.2] {
        let ink = stripes(128, 11.0, angle);
        let visible = boxed(128);
        let d = Descriptor::new(&Masked::new([128, 128], &ink, &visible).unwrap()).unwrap();
        assert!((d.wavelength - 11.0).abs() < 0.05 * 11.0, "{}", d.wavelength);
        let along = (angle + std::f64::consts::FRAC_PI_2).rem_euclid(std::f64::consts::PI);
        let off = (d.direction - along).abs();
        assert!(off.min(std::f64::consts::PI - off) < 0.05, "{} {along}", d.direction);
    }
}

#[test]
fn correlation_is_that_of_the_definition() {
    let mut random = stream(3, "texture", 0);
    let (ny, nx) = (19, 23);
    let ink: Vec<bool> = (0..ny * nx).map(|_| uniform(&mut random) < 0.4).collect();
    let visible: Vec<bool> = (0..ny * nx).map(|_| uniform(&mut random) < 0.8).collect();
    let m = Masked::new([ny, nx], &ink, &visible).unwrap();
    let f = m.fraction().unwrap();
    let c = Correlation::new(&m, 4).unwrap();
    // The ring of distance 1 holds the four lags of length 1 and the four diagonal ones.
    let (mut sum, mut count) = (0.0, 0.0);
    for j in 0..ny as i32 {
        for i in 0..nx as i32 {
            for (dj, di) in [(0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, 1), (-1, -1)] {
                let (v, u) = (j + dj, i + di);
                if v < 0 || u < 0 || v >= ny as i32 || u >= nx as i32 {
                    continue;
                }
                let (a, b) = ((j * nx as i32 + i) as usize, (v * nx as i32 + u) as usize);
                if visible[a] && visible[b] {
                    let value = |n: usize| f64::from(u8::from(ink[n])) - f;
                    sum += value(a) * value(b);
                    count += 1.0;
                }
            }
        }
    }
    let expected = sum / count / (f * (1.0 - f));
    assert!((c.radial[1] - expected).abs() < 1e-9, "{} {expected}", c.radial[1]);
    assert!((c.radial[0] - 1.0).abs() < 1e-12);
}

#[test]
fn disks_have_their_area_perimeter_euler_number_and_curvature() {
    let ink = disks(128);
    for visible in [vec![true; 128 * 128], boxed(128)] {
        let m = Masked::new([128, 128], &ink, &visible).unwrap();
        let sets = LevelSets::new(&m, 1.0);
        let d = sets.densities(0.5);
        // One disk per 256 pixels; a Gaussian of width 1 moves a border of radius 4 by 1/8.
        // A hole that cuts the lattice leaves another part of it: 12 %.
        assert!((d.euler * 256.0 - 1.0).abs() < 0.12, "{}", d.euler * 256.0);
        let pi = std::f64::consts::PI;
        assert!((d.perimeter * 256.0 / (8.0 * pi) - 1.0).abs() < 0.12, "{}", d.perimeter * 256.0);
        assert!((d.area * 256.0 / (16.0 * pi) - 1.0).abs() < 0.12, "{}", d.area * 256.0);
        let bend = sets.curvature(0.5, &[0.5])[0];
        assert!((bend - 0.25).abs() < 0.04, "{bend}");
    }
}

#[test]
fn lineal_path_of_stripes_is_exact() {
    // Vertical stripes, 4 of 10 columns: rows hold segments of length 2 in 3 of 10 places,
    // columns in 4 of 10.
    let ink = picture(100, |x, _| x % 10.0 < 4.0);
    let visible = vec![true; 10_000];
    let m = Masked::new([100, 100], &ink, &visible).unwrap();
    let found = lineal_path(&m, &[2.0], false)[0];
    let expected = (100.0 * 30.0 + 40.0 * 99.0) / (2.0 * 100.0 * 99.0);
    assert!((found - expected).abs() < 1e-12, "{found} {expected}");
}

#[test]
fn what_is_hidden_changes_no_bit() {
    let visible = boxed(128);
    let ink = disks(128);
    let mut other = ink.clone();
    let mut random = stream(1, "hidden", 0);
    for (pixel, _) in other.iter_mut().zip(&visible).filter(|(_, seen)| !**seen) {
        *pixel = uniform(&mut random) < 0.5;
    }
    assert_ne!(ink, other);
    let of = |ink: &[bool]| Descriptor::new(&Masked::new([128, 128], ink, &visible).unwrap());
    let bits = |d: Option<Descriptor>| -> Vec<u64> {
        d.unwrap().values.iter().map(|v| v.to_bits()).collect()
    };
    assert_eq!(bits(of(&ink)), bits(of(&other)));
}

#[test]
fn inverting_the_descriptor_is_inverting_the_picture() {
    let mut random = stream(5, "invert", 0);
    let smooth: Vec<f64> = (0..96 * 96).map(|_| uniform(&mut random)).collect();
    let smooth = normalized_convolution([96, 96], &smooth, &vec![1.0; 96 * 96], 2.5).0;
    let ink: Vec<bool> = smooth.iter().map(|&v| v < 0.48).collect();
    let paper: Vec<bool> = ink.iter().map(|&i| !i).collect();
    let visible = vec![true; 96 * 96];
    let of =
        |ink: &[bool]| Descriptor::new(&Masked::new([96, 96], ink, &visible).unwrap()).unwrap();
    let (a, b) = (of(&ink).values, of(&paper).values);
    for (n, (x, y)) in invert(&a).iter().zip(&b).enumerate() {
        // Curvature quantiles fall between squares of different weight.
        let tolerance = if (64..69).contains(&n) { 0.02 } else { 1e-9 };
        assert!((x - y).abs() < tolerance, "statistic {n}: {x} {y}");
    }
}

#[test]
fn a_picture_of_one_colour_has_no_descriptor() {
    let (ink, visible) = (vec![true; 4096], vec![true; 4096]);
    assert!(Descriptor::new(&Masked::new([64, 64], &ink, &visible).unwrap()).is_none());
    assert!(Masked::new([64, 63], &ink, &visible).is_err());
}

#[test]
fn depth_is_the_distance_to_the_nearest_pixel_outside() {
    let mut random = stream(5, "depth", 0);
    let (ny, nx) = (17, 23);
    let inside: Vec<bool> = (0..ny * nx).map(|_| uniform(&mut random) < 0.9).collect();
    let found = depth([ny, nx], &inside);
    for (n, found) in found.iter().enumerate() {
        let nearest = (0..ny * nx)
            .filter(|&m| !inside[m])
            .map(|m| ((n / nx) as f64 - (m / nx) as f64).hypot((n % nx) as f64 - (m % nx) as f64));
        assert_eq!(*found, nearest.fold(f64::INFINITY, f64::min), "pixel {n}");
    }
    assert!(depth([2, 3], &[true; 6]).iter().all(|d| *d == f64::INFINITY));
}
