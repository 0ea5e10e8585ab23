//! From a picture of any contrast to ink and paper.

use crate::{Error, Result};
use solvers::texture::Masked;
use solvers::{Field, Grid};

/// Share of single pixels of the other colour above which a picture counts as speckled:
/// models leave next to none, 10 % of salt and pepper leaves 3 %.
const SPECKLED: f64 = 0.005;

/// Rounds of threshold and light; the light's change is below a grey level after four.
const ROUNDS: usize = 6;

/// A picture in ink and paper, and what was done to get it.
#[derive(Clone, Debug)]
pub struct Normal {
    /// Rows and columns.
    pub shape: [usize; 2],
    /// Whether a pixel is dark; of hidden pixels false.
    pub ink: Vec<bool>,
    /// Whether a pixel is visible.
    pub visible: Vec<bool>,
    /// Grey level between ink and paper where the light is even.
    pub threshold: f64,
    /// Whether single pixels were taken for noise and given their neighbours' colour.
    pub despeckled: bool,
}

impl Normal {
    /// For the estimators of [`solvers::texture`].
    ///
    /// # Errors
    /// Never for a picture made by [`normalize`].
    pub fn masked(&self) -> Result<Masked<'_>> {
        Ok(Masked::new(self.shape, &self.ink, &self.visible)?)
    }
}

/// Splits the visible part of `picture` (low is dark) into ink and paper: Otsu's threshold
/// after a light of second degree in x and y, found together with it, is taken off; then,
/// where there is speckle, the majority of each pixel and its eight neighbours.
///
/// # Errors
/// [`Error::Config`] for `mask` if it has another size or hides everything; for `picture` if
/// it is not plane or its visible part has one value.
pub fn normalize(picture: &Field, visible: &[bool]) -> Result<Normal> {
    let grid = picture.grid();
    let [_, ny, nx] = grid.shape();
    if grid.dim() != 2 {
        let reason = format!("has {} axes, 2 are wanted", grid.dim());
        return Err(Error::config("picture", reason));
    }
    if visible.len() != grid.len() {
        let reason = format!("{} pixels, the picture has {}", visible.len(), grid.len());
        return Err(Error::config("mask", reason));
    }
    if !visible.contains(&true) {
        return Err(Error::config("mask", "hides the whole picture"));
    }
    let seen = || picture.as_slice().iter().zip(visible).filter(|(_, seen)| **seen);
    let (low, high) = seen().fold((f64::MAX, f64::MIN), |(a, b), (&v, _)| (a.min(v), b.max(v)));
    if high <= low {
        return Err(Error::config("picture", "its visible part has one value only"));
    }
    let (ink, threshold, _) = split(picture, visible);
    Ok(calm(Normal {
        shape: [ny, nx],
        ink,
        visible: visible.to_vec(),
        threshold,
        despeckled: false,
    }))
}

/// Means of squares of `factor` pixels; a square is visible if all of its pixels are.
///
/// # Errors
/// If no square fits into the picture.
pub fn reduced(picture: &Field, visible: &[bool], factor: usize) -> Result<(Field, Vec<bool>)> {
    if factor == 1 {
        return Ok((picture.clone(), visible.to_vec()));
    }
    let [_, ny, nx] = picture.grid().shape();
    let (my, mx) = (ny / factor, nx / factor);
    let (mut values, mut seen) = (vec![0.0; my * mx], vec![true; my * mx]);
    let area = (factor * factor) as f64;
    for j in 0..my * factor {
        for i in 0..mx * factor {
            let (m, n) = (j / factor * mx + i / factor, j * nx + i);
            values[m] += picture.as_slice()[n] / area;
            seen[m] &= visible[n];
        }
    }
    Ok((Field::from_vec(Grid::new(&[my, mx], 1.0)?, values)?, seen))
}

/// Takes speckle off, where there is much.
fn calm(mut normal: Normal) -> Normal {
    if speckle(&normal) > SPECKLED {
        normal.ink = majority(&normal);
        normal.despeckled = true;
    }
    normal
}

/// The same picture split at the mean of its grey levels, where it has such: the level at which
/// most models draw their ink. Otsu's threshold is another one where peaks are narrow.
pub fn at_mean(picture: &Field, normal: &Normal) -> Option<Normal> {
    let levels = grey_levels(picture, normal)?;
    let seen = || levels.as_slice().iter().zip(&normal.visible).filter(|(_, seen)| **seen);
    let threshold = seen().map(|(v, _)| v).sum::<f64>() / seen().count() as f64;
    let pixels = levels.as_slice().iter().zip(&normal.visible);
    let ink = pixels.map(|(&v, &seen)| seen && v < threshold).collect();
    Some(calm(Normal { ink, threshold, ..normal.clone() }))
}

/// Share of visible pixels in the middle half of the range above which a picture has more grey
/// levels than those of ink and paper.
const GREY: f64 = 0.2;

/// The grey levels of the visible part with an even light, 0 where hidden; none for a picture in
/// ink and paper only, or a speckled one.
///
/// Here the light is the polynomial through the levels themselves: residuals to the means of ink
/// and paper, which [`normalize`] uses, hold a part of the pattern where levels are continuous.
pub fn grey_levels(picture: &Field, normal: &Normal) -> Option<Field> {
    if normal.despeckled || picture.as_slice().len() != normal.ink.len() {
        return None;
    }
    let (_, _, level) = split(picture, &normal.visible);
    let (low, high) = level.iter().fold((f64::MAX, f64::MIN), |(a, b), &v| (a.min(v), b.max(v)));
    let quarter = 0.25 * (high - low);
    let middle = level.iter().filter(|&&v| v > low + quarter && v < high - quarter).count();
    if (middle as f64) < GREY * level.len() as f64 {
        return None;
    }
    let seen: Vec<usize> = (0..normal.ink.len()).filter(|&n| normal.visible[n]).collect();
    let mean = seen.iter().map(|&n| picture.as_slice()[n]).sum::<f64>() / seen.len() as f64;
    let residual: Vec<f64> = seen.iter().map(|&n| picture.as_slice()[n] - mean).collect();
    let light = light(&seen, normal.shape, &residual);
    let mut values = vec![0.0; normal.ink.len()];
    for ((&n, r), l) in seen.iter().zip(&residual).zip(&light) {
        values[n] = mean + r - l;
    }
    Field::from_vec(picture.grid(), values).ok()
}

/// Whether each visible pixel is darker than the threshold, that, and the visible pixels' levels
/// with an even light.
pub(super) fn split(picture: &Field, visible: &[bool]) -> (Vec<bool>, f64, Vec<f64>) {
    let [_, ny, nx] = picture.grid().shape();
    let seen: Vec<usize> = (0..visible.len()).filter(|&n| visible[n]).collect();
    let values: Vec<f64> = seen.iter().map(|&n| picture.as_slice()[n]).collect();
    let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(a, b), &v| (a.min(v), b.max(v)));
    let mut level = values.clone();
    let mut threshold = otsu(&level);
    if values.iter().any(|&v| v > low && v < high) {
        for _ in 0..ROUNDS {
            let residual = residuals(&level, &values, threshold);
            let light = light(&seen, [ny, nx], &residual);
            level.iter_mut().zip(&values).zip(&light).for_each(|((l, v), s)| *l = v - s);
            threshold = otsu(&level);
        }
    }
    let mut ink = vec![false; visible.len()];
    seen.iter().zip(&level).for_each(|(&n, &v)| ink[n] = v < threshold);
    (ink, threshold, level)
}

/// Otsu's threshold (1979): the greatest variance between the two classes, over 256 bins.
fn otsu(values: &[f64]) -> f64 {
    let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(a, b), &v| (a.min(v), b.max(v)));
    let width = (high - low) / 256.0;
    let mut bins = [0.0; 256];
    for v in values {
        bins[(((v - low) / width) as usize).min(255)] += 1.0;
    }
    let total = values.len() as f64;
    let mean = bins.iter().enumerate().map(|(n, b)| n as f64 * b).sum::<f64>() / total;
    let (mut weight, mut sum) = (0.0, 0.0);
    let mut between = [0.0; 256];
    for n in 0..256 {
        weight += bins[n] / total;
        sum += n as f64 * bins[n] / total;
        let rest = weight * (1.0 - weight);
        between[n] = if rest > 0.0 { (mean * weight - sum).powi(2) / rest } else { 0.0 };
    }
    // Between two peaks without values the variance is flat: the middle of the plateau.
    let best = between.iter().fold(0.0_f64, |a, &b| a.max(b));
    let plateau: Vec<usize> = (0..256).filter(|&n| between[n] >= best * (1.0 - 1e-9)).collect();
    let middle = plateau.iter().sum::<usize>() as f64 / plateau.len() as f64;
    low + (middle + 1.0) * width
}

/// What the values differ by from the mean of their side of the threshold.
fn residuals(level: &[f64], values: &[f64], threshold: f64) -> Vec<f64> {
    let mut sums = [(0.0, 0.0); 2];
    for &v in level {
        let side = &mut sums[usize::from(v < threshold)];
        *side = (side.0 + v, side.1 + 1.0);
    }
    let means = sums.map(|(sum, count)| sum / f64::max(count, 1.0));
    level.iter().zip(values).map(|(l, v)| v - means[usize::from(*l < threshold)]).collect()
}

/// Least-squares polynomial of second degree through `residual` at the pixels `seen`.
fn light(seen: &[usize], [ny, nx]: [usize; 2], residual: &[f64]) -> Vec<f64> {
    let terms = |n: usize| {
        let (x, y) = ((n % nx) as f64 / nx as f64 - 0.5, (n / nx) as f64 / ny as f64 - 0.5);
        nalgebra::SVector::<f64, 6>::from([1.0, x, y, x * x, x * y, y * y])
    };
    let mut normal = nalgebra::SMatrix::<f64, 6, 6>::identity() * 1e-9;
    let mut right = nalgebra::SVector::<f64, 6>::zeros();
    for (&n, &r) in seen.iter().zip(residual) {
        let t = terms(n);
        normal += t * t.transpose();
        right += t * r;
    }
    let Some(fit) = normal.cholesky().map(|c| c.solve(&right)) else {
        return vec![0.0; seen.len()];
    };
    seen.iter().map(|&n| terms(n).dot(&fit)).collect()
}

/// Visible neighbours of a pixel of the same colour, and all of them.
fn alike(normal: &Normal, n: usize) -> (usize, usize) {
    let [ny, nx] = normal.shape;
    let (j, i) = (n / nx, n % nx);
    let (mut same, mut all) = (0, 0);
    for y in j.saturating_sub(1)..(j + 2).min(ny) {
        for x in i.saturating_sub(1)..(i + 2).min(nx) {
            let m = y * nx + x;
            if m != n && normal.visible[m] {
                all += 1;
                same += usize::from(normal.ink[m] == normal.ink[n]);
            }
        }
    }
    (same, all)
}

/// Share of the visible pixels that none of their eight neighbours resembles.
fn speckle(normal: &Normal) -> f64 {
    let seen = (0..normal.ink.len()).filter(|&n| normal.visible[n]);
    let (mut single, mut count) = (0, 0);
    for n in seen {
        let (same, all) = alike(normal, n);
        count += 1;
        single += usize::from(same == 0 && all == 8);
    }
    f64::from(single as u32) / f64::from(count.max(1) as u32)
}

/// The colour of most of a pixel and its visible neighbours; its own in a draw.
fn majority(normal: &Normal) -> Vec<bool> {
    let colour = |n: usize| {
        let (same, all) = alike(normal, n);
        normal.visible[n] && (normal.ink[n] == (2 * (same + 1) > all))
    };
    (0..normal.ink.len()).map(colour).collect()
}
