//! Occluders of a picture that comes without a mask: flat regions, random dots, noise.

use super::normalize::{normalize, split};
use crate::{Error, Result};
use solvers::{Boundary, Field, Grid, level_set::label_components, texture::depth};
use std::ops::RangeInclusive;

/// What hides a part of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Occluder {
    /// Regions of one grey level.
    Flat,
    /// Regions of random dots.
    Dots,
    /// Single pixels all over the picture.
    Noise,
}

/// What was found to be hidden.
#[derive(Clone, Debug)]
pub struct Detection {
    /// Whether a pixel is visible.
    pub visible: Vec<bool>,
    /// What hides the rest, and how many pixels of it.
    pub found: Vec<(Occluder, usize)>,
}

/// Greatest difference between neighbours in a flat region, relative to the range of values.
const FLAT: f64 = 1.0 / 256.0;

/// Least part of the picture that counts as a region, and its least number of pixels.
const LEAST: (f64, usize) = (0.002, 16);

/// Least part of a flat region's neighbours on either side of its level: ink of a pattern has
/// lighter neighbours only, paper darker ones only.
const SIDES: f64 = 0.1;

/// A region of ink or paper this many times as thick as the other colour anywhere is an occluder
/// if it also fills its box to the second number.
const THICK: (f64, f64) = (2.5, 0.95);

/// Half of the width of the window in which changes of colour are counted.
const WINDOW: usize = 4;

/// Part of neighbours that differ in colour: 1/2 in random dots; patterns have 2 changes to a
/// wavelength across, and resolved wavelengths are at least 8 pixels. The limit is half way
/// between dots and the calm quarter of the picture, which noise all over raises, but at least this.
const RESTLESS: f64 = 0.3;

/// Least part of the picture that counts as a region of dots: noise all over clusters by chance.
const DOTTED: f64 = 0.01;

/// A region of dots that fills this part of its box is taken for the box.
const BOX: f64 = 0.8;

/// Finds what hides parts of `picture`; nothing found is a mask without hidden pixels.
///
/// Flat regions are those of one grey level with lighter and darker pixels around, or boxes of
/// ink or paper much thicker than the rest; dots are where neighbours differ as often as by
/// chance; noise are single pixels unlike their neighbours, where there are many.
///
/// # Errors
/// [`Error::Config`] for `picture` if it is not plane or has one value.
pub fn detect(picture: &Field) -> Result<Detection> {
    let grid = picture.grid();
    if grid.dim() != 2 {
        let reason = format!("has {} axes, 2 are wanted", grid.dim());
        return Err(Error::config("picture", reason));
    }
    let everything = vec![true; grid.len()];
    // Also refuses what cannot be split.
    let whole = normalize(picture, &everything)?;
    let mut found = Vec::new();
    let mut visible = everything;
    for (kind, hidden) in
        [(Occluder::Flat, flat(picture, &visible)?), (Occluder::Dots, dots(picture, grid)?)]
    {
        let mut count = 0;
        for (seen, &hides) in visible.iter_mut().zip(&hidden) {
            count += usize::from(*seen && hides);
            *seen &= !hides;
        }
        if count > 0 {
            found.push((kind, count));
        }
    }
    if found.is_empty() && whole.despeckled {
        let (raw, ..) = split(picture, &visible);
        visible = raw.iter().zip(&whole.ink).map(|(a, b)| a == b).collect();
        found.push((Occluder::Noise, visible.iter().filter(|seen| !**seen).count()));
    }
    Ok(Detection { visible, found })
}

/// Least number of pixels of a region.
fn least(grid: Grid) -> usize {
    ((LEAST.0 * grid.len() as f64) as usize).max(LEAST.1)
}

/// Pixels of flat occluders.
fn flat(picture: &Field, all: &[bool]) -> Result<Vec<bool>> {
    let grid = picture.grid();
    let [_, ny, nx] = grid.shape();
    let values = picture.as_slice();
    let (low, high) = picture.range();
    let step = FLAT * (high - low);
    let near = |n: usize, m: usize| (values[n] - values[m]).abs() <= step;
    let calm = |n: usize| {
        let (j, i) = (n / nx, n % nx);
        (i == 0 || near(n, n - 1))
            && (i + 1 == nx || near(n, n + 1))
            && (j == 0 || near(n, n - nx))
            && (j + 1 == ny || near(n, n + nx))
    };
    let quiet: Vec<bool> = (0..values.len()).map(calm).collect();
    let parts = label_components(&quiet, grid, Boundary::Neumann)?;
    let mut regions = Vec::new();
    for (label, _) in (1..).zip(&parts.sizes).filter(|(_, size)| **size >= least(grid)) {
        let inside: Vec<bool> = parts.labels.iter().map(|&l| l == label).collect();
        let Some(first) = inside.iter().position(|&b| b) else { continue };
        // Its outermost pixels have neighbours of other levels and were not calm; corners of a
        // box touch such pixels only.
        let level = values[first];
        let alike = |n: usize| (values[n] - level).abs() <= step;
        let grown = grow(&grow(&inside, [ny, nx], alike), [ny, nx], alike);
        let rim = grow(&grown, [ny, nx], |n| !grown[n]);
        let own: Vec<usize> = (0..values.len()).filter(|&n| grown[n]).collect();
        let around = (0..values.len()).filter(|&n| rim[n] && !grown[n]);
        let (mut darker, mut lighter) = (0.0, 0.0);
        for n in around {
            darker += f64::from(u8::from(values[n] < level - step));
            lighter += f64::from(u8::from(values[n] > level + step));
        }
        regions.push((level, [darker, lighter], own));
    }
    let mut hidden = vec![false; values.len()];
    for (level, _, own) in &regions {
        // Occluders of one level are judged together: a small one may touch one colour only.
        let mut sides = [0.0; 2];
        for (_, counts, _) in regions.iter().filter(|r| (r.0 - level).abs() <= step) {
            sides.iter_mut().zip(counts).for_each(|(s, c)| *s += c);
        }
        if sides.iter().all(|&s| s > SIDES * (sides[0] + sides[1])) {
            own.iter().for_each(|&n| hidden[n] = true);
        }
    }
    if !hidden.contains(&true) {
        let (ink, ..) = split(picture, all);
        for colour in [true, false] {
            let own: Vec<bool> = ink.iter().map(|&i| i == colour).collect();
            if let Some(found) = block(&own, [ny, nx]) {
                hidden.iter_mut().zip(&found).for_each(|(h, f)| *h |= f);
            }
        }
    }
    Ok(hidden)
}

/// `inside` and those of its neighbours that `wanted` accepts.
fn grow(inside: &[bool], [ny, nx]: [usize; 2], wanted: impl Fn(usize) -> bool) -> Vec<bool> {
    let mut grown = inside.to_vec();
    for n in (0..inside.len()).filter(|&n| !inside[n] && wanted(n)) {
        let (j, i) = (n / nx, n % nx);
        grown[n] = (i > 0 && inside[n - 1])
            || (i + 1 < nx && inside[n + 1])
            || (j > 0 && inside[n - nx])
            || (j + 1 < ny && inside[n + nx]);
    }
    grown
}

/// A box of one colour, much thicker than the other colour is anywhere.
fn block(own: &[bool], shape: [usize; 2]) -> Option<Vec<bool>> {
    let [_, nx] = shape;
    let other: Vec<bool> = own.iter().map(|&b| !b).collect();
    let inner = depth(shape, own);
    let most = |list: &[f64]| list.iter().fold(0.0_f64, |a, &b| a.max(b));
    let (thick, usual) = (most(&inner), most(&depth(shape, &other)));
    if !(thick.is_finite() && usual > 0.0 && thick >= THICK.0 * usual) {
        return None;
    }
    // Opening by a square: ends that reach out of the box are cut off.
    let reach = (0.6 * thick) as usize;
    let core: Vec<bool> = inner.iter().map(|&d| d > reach as f64).collect();
    let [top, bottom, left, right] = bounds(&core, nx)?;
    let [ny, _] = shape;
    let (mut top, mut left) = (top.saturating_sub(reach), left.saturating_sub(reach));
    let (mut bottom, mut right) = ((bottom + reach).min(ny - 1), (right + reach).min(nx - 1));
    let share = |rows: RangeInclusive<usize>, columns: RangeInclusive<usize>| {
        let all = rows.flat_map(|j| columns.clone().map(move |i| j * nx + i));
        let (own, count) = all.fold((0, 0), |(a, b), n| (a + u32::from(own[n]), b + 1));
        f64::from(own) / f64::from(count)
    };
    if share(top..=bottom, left..=right) < THICK.1 {
        return None;
    }
    // Where the pattern touches the box in its colour the core reaches out of it.
    while top < bottom && share(top..=top, left..=right) < THICK.1 {
        top += 1;
    }
    while top < bottom && share(bottom..=bottom, left..=right) < THICK.1 {
        bottom -= 1;
    }
    while left < right && share(top..=bottom, left..=left) < THICK.1 {
        left += 1;
    }
    while left < right && share(top..=bottom, right..=right) < THICK.1 {
        right -= 1;
    }
    let filled = (top..=bottom).flat_map(|j| (left..=right).map(move |i| j * nx + i));
    let mut hidden = vec![false; own.len()];
    filled.for_each(|n| hidden[n] = true);
    Some(hidden)
}

/// First and last row, first and last column of a region.
fn bounds(region: &[bool], nx: usize) -> Option<[usize; 4]> {
    let mut found: Option<[usize; 4]> = None;
    for n in (0..region.len()).filter(|&n| region[n]) {
        let (j, i) = (n / nx, n % nx);
        let [top, bottom, left, right] = found.unwrap_or([j, j, i, i]);
        found = Some([top.min(j), bottom.max(j), left.min(i), right.max(i)]);
    }
    found
}

/// Pixels of regions of random dots.
fn dots(picture: &Field, grid: Grid) -> Result<Vec<bool>> {
    let [_, ny, nx] = grid.shape();
    let (ink, ..) = split(picture, &vec![true; grid.len()]);
    let changes: Vec<f64> = (0..ink.len()).map(|n| unlike(&ink, [ny, nx], n)).collect();
    let mean = window_mean(&changes, [ny, nx]);
    let mut order = mean.clone();
    order.sort_by(f64::total_cmp);
    let limit = (0.5 * (order[order.len() / 4] + 0.5)).max(RESTLESS);
    let restless: Vec<bool> = mean.iter().map(|&m| m > limit).collect();
    let parts = label_components(&restless, grid, Boundary::Neumann)?;
    let mut hidden = vec![false; ink.len()];
    let least = least(grid).max((DOTTED * grid.len() as f64) as usize);
    for (label, &size) in (1..).zip(&parts.sizes).filter(|(_, size)| **size >= least) {
        let region: Vec<bool> = parts.labels.iter().map(|&l| l == label).collect();
        let Some([top, bottom, left, right]) = bounds(&region, nx) else { continue };
        let area = (bottom - top + 1) * (right - left + 1);
        let whole = size as f64 >= BOX * area as f64;
        for (n, hides) in hidden.iter_mut().enumerate() {
            let (j, i) = (n / nx, n % nx);
            let inside = (top..=bottom).contains(&j) && (left..=right).contains(&i);
            *hides |= if whole { inside } else { region[n] };
        }
    }
    Ok(hidden)
}

/// Part of the four neighbours of another colour.
fn unlike(ink: &[bool], [ny, nx]: [usize; 2], n: usize) -> f64 {
    let (j, i) = (n / nx, n % nx);
    let around = [
        (i > 0).then(|| n - 1),
        (i + 1 < nx).then(|| n + 1),
        (j > 0).then(|| n - nx),
        (j + 1 < ny).then(|| n + nx),
    ];
    let all = around.iter().flatten();
    let count = all.clone().count();
    all.filter(|&&m| ink[m] != ink[n]).count() as f64 / count.max(1) as f64
}

/// Mean over a window around each pixel, cut off at the picture's border.
fn window_mean(values: &[f64], [ny, nx]: [usize; 2]) -> Vec<f64> {
    let mut sums = vec![0.0; (ny + 1) * (nx + 1)];
    for j in 0..ny {
        for i in 0..nx {
            let at = (j + 1) * (nx + 1) + i + 1;
            sums[at] = values[j * nx + i] + sums[at - 1] + sums[at - nx - 1] - sums[at - nx - 2];
        }
    }
    let mean = |n: usize| {
        let (j, i) = (n / nx, n % nx);
        let (top, bottom) = (j.saturating_sub(WINDOW), (j + WINDOW + 1).min(ny));
        let (left, right) = (i.saturating_sub(WINDOW), (i + WINDOW + 1).min(nx));
        let corner = |j: usize, i: usize| sums[j * (nx + 1) + i];
        let sum =
            corner(bottom, right) + corner(top, left) - corner(top, right) - corner(bottom, left);
        sum / ((bottom - top) * (right - left)) as f64
    };
    (0..ny * nx).map(mean).collect()
}
