//! Fixed points that fill squares, discs and half spheres evenly.

use super::vector::{V, along, frame, scale};

/// Pixels of a square of `CLASSES` have different samples; together they have a fine set.
pub(super) const CLASSES: usize = 16;
/// Samples of a pixel, for the key light and for the sky.
pub(super) const SAMPLES: usize = 8;

/// The class of a pixel: any 4 x 4 neighbours have all classes (bits of x and of x + y).
pub(super) fn class(x: usize, y: usize) -> usize {
    let (a, b) = (x ^ y, y);
    (a & 1) << 3 | (b & 1) << 2 | (a & 2) | (b & 2) >> 1
}

/// Point `n` of the first two dimensions of Sobol's sequence in [0, 1)^2: any `SAMPLES`
/// consecutive ones from a multiple on are stratified, and so are those of all classes.
pub(super) fn sobol(n: usize) -> [f32; 2] {
    let n = n as u32;
    let mut y = 0;
    let (mut bits, mut v) = (n, 1_u32 << 31);
    while bits > 0 {
        if bits & 1 == 1 {
            y ^= v;
        }
        bits >>= 1;
        v ^= v >> 1;
    }
    // 24 bits: no rounding up to 1.
    [n.reverse_bits(), y].map(|v| (v >> 8) as f32 / (1 << 24) as f32)
}

/// The unit disc from the unit square, keeping areas (Shirley and Chiu 1997).
fn disc([u, v]: [f32; 2]) -> [f32; 2] {
    use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    if a == 0.0 && b == 0.0 {
        return [0.0; 2];
    }
    let (r, phi) = if a.abs() > b.abs() {
        (a, FRAC_PI_4 * (b / a))
    } else {
        (b, FRAC_PI_2 - FRAC_PI_4 * (a / b))
    };
    [r * phi.cos(), r * phi.sin()]
}

/// All samples: points of the unit disc.
#[derive(Debug)]
pub(super) struct Samples {
    points: Vec<[f32; 2]>,
    /// Fractions for the reach of rays.
    third: Vec<f32>,
}

impl Samples {
    pub(super) fn new() -> Self {
        let count = CLASSES * SAMPLES;
        let points = (0..count).map(|n| disc(sobol(n))).collect();
        // 37 is odd, so that each n is met once.
        let third = (0..count).map(|n| ((37 * n) % count) as f32 / count as f32).collect();
        Self { points, third }
    }

    /// Directions to a round lamp of angular radius `tan` around the unit vector `key`.
    pub(super) fn lamp(&self, class: usize, key: V, tan: f32) -> impl Iterator<Item = V> + '_ {
        let [a, b] = frame(key);
        self.class(class).map(move |n| {
            let [x, y] = self.points[n];
            along(along(key, tan * x, a), tan * y, b)
        })
    }

    /// Directions of the half sphere around `n`, dense as its cosine, and fractions in [0, 1).
    pub(super) fn sky(&self, class: usize, n: V) -> impl Iterator<Item = (V, f32)> + '_ {
        let [a, b] = frame(n);
        self.class(class).map(move |m| {
            let [x, y] = self.points[m];
            let z = (1.0 - x * x - y * y).max(0.0).sqrt();
            (along(along(scale(n, z), x, a), y, b), self.third[m])
        })
    }

    fn class(&self, class: usize) -> std::ops::Range<usize> {
        let first = class % CLASSES * SAMPLES;
        first..first + SAMPLES
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_square_of_pixels_has_all_classes() {
        for (x0, y0) in [(0, 0), (1, 0), (2, 3), (7, 5)] {
            let mut seen = [0; CLASSES];
            (0..4).for_each(|y| (0..4).for_each(|x| seen[class(x0 + x, y0 + y)] += 1));
            assert_eq!(seen, [1; CLASSES]);
        }
    }

    #[test]
    fn the_samples_of_a_class_and_of_all_integrate() {
        // The mean of the cosine over a cosine-dense half sphere is 2/3.
        let samples = Samples::new();
        let n = [0.6, 0.0, -0.8];
        let cosine = |class| -> f32 {
            samples.sky(class, n).map(|(d, _)| super::super::vector::dot(d, n)).sum::<f32>()
        };
        let each: Vec<f32> = (0..CLASSES).map(|c| cosine(c) / SAMPLES as f32).collect();
        // The cosine's deviation is 0.24: eight independent samples are .083 off, 128 are .02.
        assert!(each.iter().all(|m| (m - 2.0 / 3.0).abs() < 0.12), "{each:?}");
        let mean = each.iter().sum::<f32>() / CLASSES as f32;
        assert!((mean - 2.0 / 3.0).abs() < 0.01, "{mean}");
    }
}
