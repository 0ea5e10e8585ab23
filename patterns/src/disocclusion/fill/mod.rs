//! What is hidden, filled in: by the model that made the pattern, or by copies of its patches.
//!
//! A reaction runs again with the visible pixels held, from the likeliest continuation of the
//! visible texture; a structure is optimized again, whole; without a model, patches of the
//! visible part are copied.

mod contour;
mod frame;
mod patch;
mod rd;
mod reference;
mod topology;

#[cfg(test)]
mod tests;

use super::class::Class;
use super::normalize::Normal;
use crate::{Error, Inputs, Result};
use solvers::level_set::distance::from_mask;
use solvers::{Boundary, Field, Grid};

pub use contour::contour;

/// Samples where a hole is wider than [`WIDE`].
const SAMPLES: usize = 6;

/// Width of a hole (wavelengths) from which its inside is not determined by its rim.
const WIDE: f64 = 2.0;

/// Samples that the expectation by depth counts as, beside those that were run.
const PRIOR: f64 = 2.0;

/// How a picture is filled.
#[derive(Clone, Debug, Default)]
pub struct Fill {
    /// Seed of the random continuations.
    pub seed: u64,
    /// Number of samples, at least 1; absent: 1 where every hole is narrower than two
    /// wavelengths, else 6.
    pub samples: Option<usize>,
    /// Whether ink and paper of the picture are exchanged with respect to the class.
    pub inverted: bool,
    /// How far the picture is turned from the class's frame (radians, from x to y), for
    /// classes without chance.
    pub angle: f64,
    /// Grey levels of the picture (low is dark) where they are a monotone function of the
    /// concentration; absent where only ink and paper are to be trusted.
    pub grey: Option<Field>,
}

/// A filled picture.
#[derive(Clone, Debug)]
pub struct Filled {
    /// Rows and columns.
    pub shape: [usize; 2],
    /// Probability of ink, in [0, 1]; 0 or 1 where visible.
    pub ink: Vec<f64>,
    /// Probability that a pixel of the first sample is right, in [0, 1]; 1 where visible.
    pub confidence: Vec<f64>,
    /// Pictures in ink that all continue the visible part; the first is the likeliest, and
    /// has the statistics of the pattern, which a mean over samples has not.
    pub samples: Vec<Vec<bool>>,
    /// What filled it: `reaction-diffusion`, `topology` or `patch`.
    pub method: &'static str,
    /// Level set of the first sample, negative in the ink (pixels).
    pub contour: Field,
}

impl Filled {
    /// The first sample.
    pub fn picture(&self) -> &[bool] {
        &self.samples[0]
    }
}

/// What a method found, in the picture's frame and polarity.
struct Made {
    /// Negative in the ink, of any scale; one per sample.
    levels: Vec<Vec<f64>>,
    /// Agreement with the truth that is expected at the rim, and over how many pixels of
    /// depth it falls to that of unrelated pictures; infinite where it does not fall.
    at_rim: f64,
    range: f64,
    method: &'static str,
}

/// Fills the hidden pixels of `normal`: with `class` at `point` (shares of its ranges), or by
/// copies of patches if there is none or its model is neither `rd` nor `topopt`.
///
/// # Errors
/// [`Error::Config`] for `samples` if it is 0, for `grey` if it has another size; what a
/// model refuses or meets on its way.
pub fn fill(
    normal: &Normal,
    class: Option<&Class>,
    point: &[f64],
    settings: &Fill,
    inputs: &(dyn Inputs + Sync),
) -> Result<Filled> {
    let [ny, nx] = normal.shape;
    if settings.samples == Some(0) {
        return Err(Error::range("samples", 0.0, "[1, inf)"));
    }
    if let Some(grey) = settings.grey.as_ref().filter(|grey| grey.grid().axes() != [ny, nx]) {
        let reason = format!("its axes are {:?}, the picture's [{ny}, {nx}]", grey.grid().axes());
        return Err(Error::config("grey", reason));
    }
    let depth = depth(normal)?;
    let made = match class.map(|class| (class, class.model.name)) {
        _ if !normal.visible.contains(&false) => Made {
            levels: vec![vec![0.0; ny * nx]],
            at_rim: 1.0,
            range: f64::INFINITY,
            method: "patch",
        },
        Some((class, "rd")) => rd::run(normal, class, point, settings, inputs)?,
        Some((class, "topopt")) => topology::run(normal, class, point, settings, inputs)?,
        _ => patch::copy(normal, settings)?,
    };
    finish(normal, &depth, made)
}

/// Distance of each hidden pixel from what is visible (pixels), negative where visible.
fn depth(normal: &Normal) -> Result<Vec<f64>> {
    let [ny, nx] = normal.shape;
    let hidden: Vec<bool> = normal.visible.iter().map(|seen| !seen).collect();
    if !hidden.contains(&true) {
        return Ok(vec![-1.0; ny * nx]);
    }
    let phi = from_mask(&hidden, Grid::new(&[ny, nx], 1.0)?, Boundary::Neumann)?;
    Ok(phi.as_slice().iter().map(|v| -v).collect())
}

/// Width of the widest hole (pixels).
fn width(normal: &Normal) -> Result<f64> {
    Ok(2.0 * depth(normal)?.into_iter().fold(0.0, f64::max))
}

/// Samples of a pattern of `wavelength` (pixels) if `settings` does not say.
fn samples(normal: &Normal, wavelength: f64, settings: &Fill) -> Result<usize> {
    let several = width(normal)? > WIDE * wavelength;
    Ok(settings.samples.unwrap_or(if several { SAMPLES } else { 1 }))
}

fn finish(normal: &Normal, depth: &[f64], made: Made) -> Result<Filled> {
    let pixels = normal.ink.len();
    let samples: Vec<Vec<bool>> = made
        .levels
        .iter()
        .map(|level| {
            let colour = |n| if normal.visible[n] { normal.ink[n] } else { level[n] < 0.0 };
            (0..pixels).map(colour).collect()
        })
        .collect();
    let picture = &samples[0];
    let dark = picture.iter().filter(|&&ink| ink).count() as f64 / pixels as f64;
    // Unrelated pictures of that much ink agree by chance.
    let chance = dark * dark + (1.0 - dark) * (1.0 - dark);
    let others = samples.len() as f64 - 1.0;
    let confidence: Vec<f64> = (0..pixels)
        .map(|n| {
            if normal.visible[n] {
                return 1.0;
            }
            let fall = libm::exp(-depth[n].max(0.0) / made.range);
            let expected = chance + (made.at_rim - chance).max(0.0) * fall;
            let agree = samples[1..].iter().filter(|s| s[n] == picture[n]).count() as f64;
            (PRIOR * expected + agree) / (PRIOR + others)
        })
        .collect();
    let ink =
        (0..pixels).map(|n| if picture[n] { confidence[n] } else { 1.0 - confidence[n] }).collect();
    let contour = contour(normal, picture, &made.levels[0])?;
    Ok(Filled { shape: normal.shape, ink, confidence, samples, method: made.method, contour })
}
