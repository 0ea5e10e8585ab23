//! Classes without chance in them, compared pixel by pixel.

use super::{
    candidate::{Ink, frame, simulate},
    class::Class,
    normalize::Normal,
    place::{self, Frame},
};
use crate::{Inputs, Result};
use rayon::prelude::*;
use std::{
    f64::consts::{FRAC_PI_2, PI},
    sync::OnceLock,
};

/// Points of a class that are run to rank it.
const POINTS: u64 = 6;

/// Correlation with a class's first point below which its others are not run: points of one
/// class agree far better with each other.
const UNLIKE: f64 = 0.25;

/// Seed of the points; evaluations use others.
const SEED: u64 = 1;

/// Most pixels that are looked at while the angle is sought.
const COARSE: usize = 900;

/// Step of that search (degrees), and then of its refinement.
const STEPS: (usize, f64) = (6, 0.5);

/// Patterns of classes without chance, each run once, when it is first compared.
#[derive(Default)]
pub(super) struct Candidates {
    /// By class and point.
    inks: Vec<Vec<OnceLock<Ink>>>,
}

impl Candidates {
    /// Room for `classes` classes.
    pub(super) fn new(classes: usize) -> Self {
        let room = || (0..POINTS).map(|_| OnceLock::new()).collect();
        Self { inks: (0..classes).map(|_| room()).collect() }
    }

    fn get(&self, class: usize, entry: &Class, index: u64, inputs: &dyn Inputs) -> Result<&Ink> {
        let slot = &self.inks[class][index as usize];
        if let Some(ink) = slot.get() {
            return Ok(ink);
        }
        let ink = simulate(entry, &entry.point(SEED, index), 0, inputs)?;
        Ok(slot.get_or_init(|| ink))
    }
}

/// Half of the usual distance between two points of a class that are run to rank it.
pub(super) fn deviations(class: &Class) -> Vec<f64> {
    let dim = class.ranges.len();
    vec![0.5 * libm::pow(POINTS as f64, -1.0 / dim as f64); dim]
}

/// How well a class agrees with a picture.
#[derive(Clone, Debug)]
pub struct Agreement {
    /// Index of the class.
    pub class: usize,
    /// Correlation of ink over the visible pixels, in [0, 1].
    pub correlation: f64,
    /// How far the picture is turned from the class's frame (radians, from x to y).
    pub angle: f64,
    /// Whether ink and paper are exchanged.
    pub inverted: bool,
    /// Shares of the class's ranges.
    pub point: Vec<f64>,
}

/// The best agreement of each class whose frame has the picture's proportions (upright or on
/// its side), the greatest first: each is run at a few points of its ranges.
///
/// # Errors
/// What a model refuses or meets on its way.
pub(super) fn rank(
    normal: &Normal,
    classes: &[(usize, &Class)],
    candidates: &Candidates,
    inputs: &(dyn Inputs + Sync),
) -> Result<Vec<Agreement>> {
    let found: Vec<Option<Agreement>> = classes
        .par_iter()
        .map(|&(class, entry)| {
            let frame = frame(entry, &entry.point(SEED, 0), inputs)?;
            if frame.is_some_and(|frame| !place::alike(normal.shape, frame)) {
                return Ok(None);
            }
            let at = |index: u64| -> Result<Option<Agreement>> {
                let fit = agree(normal, candidates.get(class, entry, index, inputs)?);
                let agreement = fit.map(|(correlation, angle, inverted)| {
                    let point = entry.point(SEED, index);
                    Agreement { class, correlation, angle, inverted, point }
                });
                Ok(agreement)
            };
            let Some(mut best) = at(0)? else { return Ok(None) };
            if best.correlation >= UNLIKE {
                let others: Vec<Option<Agreement>> =
                    (1..POINTS).into_par_iter().map(at).collect::<Result<_>>()?;
                for other in others.into_iter().flatten() {
                    if other.correlation > best.correlation {
                        best = other;
                    }
                }
            }
            Ok(Some(best))
        })
        .collect::<Result<_>>()?;
    let mut found: Vec<Agreement> = found.into_iter().flatten().collect();
    found.sort_by(|a, b| b.correlation.total_cmp(&a.correlation));
    Ok(found)
}

/// Greatest correlation over all angles, the angle, and whether its sign is negative; none if
/// the frames have other proportions.
pub fn agree(normal: &Normal, candidate: &Ink) -> Option<(f64, f64, bool)> {
    if !place::alike(normal.shape, candidate.shape) {
        return None;
    }
    // A picture on its side is a quarter turn of the class's frame.
    let base = if place::swapped(normal.shape, candidate.shape) { FRAC_PI_2 } else { 0.0 };
    let stride = (normal.ink.len() / COARSE).max(1);
    let score = |angle: f64, stride: usize| correlate(normal, candidate, angle, stride);
    let angles = (0..360).step_by(STEPS.0).map(|d| base + d as f64 * PI / 180.0);
    let better = |a: (f64, f64), b: (f64, f64)| if b.0.abs() > a.0.abs() { b } else { a };
    let mut best = angles.map(|t| (score(t, stride), t)).fold((0.0, base), better);
    // Upright and on its side are the likeliest: they are looked at closely in any case.
    best = better((score(best.1, 1), best.1), (score(base, 1), base));
    let around = best.1;
    for n in -12..=12_i32 {
        let angle = around + f64::from(n) * STEPS.1 * PI / 180.0;
        best = better(best, (score(angle, 1), angle));
    }
    Some((best.0.abs(), best.1, best.0 < 0.0))
}

/// Correlation of the inks of every `stride`th visible pixel, the candidate turned by `angle`
/// about the middle; 0 if fewer than half of them lie in its frame.
fn correlate(normal: &Normal, candidate: &Ink, angle: f64, stride: usize) -> f64 {
    let frame = Frame::new(normal.shape, candidate.shape, angle);
    let mut table = [[0.0_f64; 2]; 2];
    let (mut seen, mut inside) = (0, 0);
    for n in (0..normal.ink.len()).step_by(stride).filter(|&n| normal.visible[n]) {
        seen += 1;
        if let Some(m) = frame.find(n) {
            inside += 1;
            table[usize::from(normal.ink[n])][usize::from(candidate.ink[m])] += 1.0;
        }
    }
    if 2 * inside < seen {
        return 0.0;
    }
    phi_coefficient(table)
}

/// Pearson's correlation of two pictures in ink from the table of their pixels' colours; 0 if
/// one of them has one colour.
pub(super) fn phi_coefficient([[a, b], [c, d]]: [[f64; 2]; 2]) -> f64 {
    let spread = ((a + b) * (c + d) * (a + c) * (b + d)).sqrt();
    if spread > 0.0 { (a * d - b * c) / spread } else { 0.0 }
}
