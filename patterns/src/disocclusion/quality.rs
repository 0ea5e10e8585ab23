//! How good what was put into a hole is, when the truth is known.

use crate::{Error, Metric, Result};
use solvers::{
    Boundary, Grid,
    level_set::label_components,
    texture::{depth, normalized_convolution},
};

/// Borders between ranges of depth (pixels).
const DEPTHS: [f64; 4] = [2.0, 4.0, 8.0, 16.0];

/// Width of the Gaussian of SSIM (pixels).
const SIGMA: f64 = 1.5;

/// Constants of SSIM for values in [0, 1].
const SMALL: [f64; 2] = [0.01 * 0.01, 0.03 * 0.03];

/// What hidden pixels were taken for, against the truth.
#[derive(Clone, Debug, PartialEq)]
pub struct Quality {
    /// Intersection over union of the ink in the hole; 1 if neither has ink.
    pub ink_iou: f64,
    /// Part of the hole's pixels that are right.
    pub accuracy: f64,
    /// Mean structural similarity over the hole's pixels.
    pub ssim: f64,
    /// Least and greatest depth (pixels; the last has no end), number of pixels, part that is right.
    pub by_depth: Vec<([f64; 2], usize, f64)>,
    /// Components of ink in the hole, as found and in truth.
    pub components: [usize; 2],
    /// Their mean area (pixels), as found and in truth.
    pub mean_area: [f64; 2],
}

impl Quality {
    /// Of `found` against `truth`, `shape` pixels each, where `visible` is false.
    ///
    /// SSIM is that of Wang et al. 2004, with its Gaussian window of 1.5 pixels and its constants.
    ///
    /// # Errors
    /// [`Error::Config`] for `truth` if it has another size; for `mask` if it hides nothing.
    pub fn new(
        shape: [usize; 2],
        found: &[bool],
        truth: &[bool],
        visible: &[bool],
    ) -> Result<Self> {
        if truth.len() != found.len() {
            let reason = format!("{} pixels, the picture has {}", truth.len(), found.len());
            return Err(Error::config("truth", reason));
        }
        let hole: Vec<bool> = visible.iter().map(|seen| !seen).collect();
        let hidden: Vec<usize> = (0..hole.len()).filter(|&n| hole[n]).collect();
        if hidden.is_empty() {
            return Err(Error::config("mask", "hides nothing"));
        }
        let share = |list: &[usize], good: &dyn Fn(usize) -> bool| {
            list.iter().filter(|&&n| good(n)).count() as f64 / list.len().max(1) as f64
        };
        let both = share(&hidden, &|n| found[n] && truth[n]);
        let either = share(&hidden, &|n| found[n] || truth[n]);
        let right = |n: usize| found[n] == truth[n];
        let deep = depth(shape, &hole);
        let ends = [&[0.0], &DEPTHS[..], &[f64::INFINITY]].concat();
        let by_depth = ends.windows(2).filter_map(|w| {
            let inside = |n: &usize| deep[*n] > w[0] && deep[*n] <= w[1];
            let ring: Vec<usize> = hidden.iter().copied().filter(inside).collect();
            (!ring.is_empty()).then(|| ([w[0], w[1]], ring.len(), share(&ring, &right)))
        });
        let map = ssim(shape, found, truth);
        let parts = [found, truth].map(|ink| components(shape, ink, &hole));
        let [a, b] = parts;
        let ([count_a, area_a], [count_b, area_b]) = (a?, b?);
        Ok(Self {
            ink_iou: if either > 0.0 { both / either } else { 1.0 },
            accuracy: share(&hidden, &right),
            ssim: hidden.iter().map(|&n| map[n]).sum::<f64>() / hidden.len() as f64,
            by_depth: by_depth.collect(),
            components: [count_a as usize, count_b as usize],
            mean_area: [area_a, area_b],
        })
    }

    /// As metrics of a run.
    pub fn metrics(&self) -> Vec<Metric> {
        let mut metrics = vec![
            Metric::new("ink_iou", self.ink_iou, "1"),
            Metric::new("accuracy", self.accuracy, "1"),
            Metric::new("ssim", self.ssim, "1"),
            Metric::new("hole_components", self.components[0] as f64, "1"),
            Metric::new("hole_components_true", self.components[1] as f64, "1"),
            Metric::new("hole_mean_area", self.mean_area[0], "pixels^2"),
            Metric::new("hole_mean_area_true", self.mean_area[1], "pixels^2"),
        ];
        metrics.extend(self.by_depth.iter().map(|([low, high], _, right)| {
            let end = if high.is_finite() { format!("_to_{high:02}") } else { "_on".into() };
            Metric::new(&format!("accuracy_depth_{low:02}{end}"), *right, "1")
        }));
        metrics
    }
}

/// Number and mean area of the components of `ink` in `hole`.
fn components(shape: [usize; 2], ink: &[bool], hole: &[bool]) -> Result<[f64; 2]> {
    let inside: Vec<bool> = ink.iter().zip(hole).map(|(a, b)| *a && *b).collect();
    let parts = label_components(&inside, Grid::new(&shape, 1.0)?, Boundary::Neumann)?;
    let count = parts.sizes.len() as f64;
    Ok([count, parts.sizes.iter().sum::<usize>() as f64 / count.max(1.0)])
}

/// Structural similarity around every pixel.
fn ssim(shape: [usize; 2], a: &[bool], b: &[bool]) -> Vec<f64> {
    let number =
        |ink: &[bool]| -> Vec<f64> { ink.iter().map(|&i| f64::from(u8::from(i))).collect() };
    let (x, y) = (number(a), number(b));
    let product: Vec<f64> = x.iter().zip(&y).map(|(x, y)| x * y).collect();
    let all = vec![1.0; x.len()];
    let mean = |v: &[f64]| normalized_convolution(shape, v, &all, SIGMA).0;
    // Of values 0 and 1 the squares are the values.
    let (mx, my, mxy) = (mean(&x), mean(&y), mean(&product));
    (0..x.len())
        .map(|n| {
            let (p, q) = (mx[n], my[n]);
            let (vx, vy, c) = (p - p * p, q - q * q, mxy[n] - p * q);
            (2.0 * p * q + SMALL[0]) * (2.0 * c + SMALL[1])
                / ((p * p + q * q + SMALL[0]) * (vx + vy + SMALL[1]))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hole_is_measured_against_counts_by_hand() {
        let shape = [12, 12];
        let visible: Vec<bool> = (0..144).map(|n| n % 12 < 4).collect();
        // Two bars in the hole, and what was found: one of them, and a pixel too much.
        let truth: Vec<bool> = (0..144).map(|n| matches!(n % 12, 6 | 9)).collect();
        let found: Vec<bool> = (0..144).map(|n| n % 12 == 6 || n == 11).collect();
        let quality = Quality::new(shape, &found, &truth, &visible).unwrap();
        assert_eq!(quality.ink_iou, 12.0 / 25.0);
        assert_eq!(quality.accuracy, 1.0 - 13.0 / 96.0);
        assert_eq!(quality.components, [2, 2]);
        assert_eq!(quality.mean_area, [6.5, 12.0]);
        let rings: Vec<(usize, f64)> = quality.by_depth.iter().map(|d| (d.1, d.2)).collect();
        assert_eq!(rings, [(24, 1.0), (24, 1.0), (48, 35.0 / 48.0)]);
        let same = Quality::new(shape, &truth, &truth, &visible).unwrap();
        assert!((same.ssim - 1.0).abs() < 1e-12 && same.ink_iou == 1.0);
        let turned: Vec<bool> = truth.iter().map(|t| !t).collect();
        assert!(Quality::new(shape, &turned, &truth, &visible).unwrap().ssim < 0.0);
        let nothing = Quality::new(shape, &found, &truth, &[true; 144]).unwrap_err();
        assert!(nothing.to_string().contains("hides nothing"));
    }
}
