//! Pictures as they come: hidden in part, noisy, blurred, inverted, rotated; seeded.

use super::candidate::Ink;
use crate::{Error, Result};
use solvers::random::{Stream, stream, uniform};
use solvers::texture::normalized_convolution;
use solvers::{Field, Grid};

/// What happens to a picture besides being hidden in part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Harm {
    /// One box hides the share.
    Box,
    /// Boxes of an eighth of the picture's side hide it.
    SmallBoxes,
    /// One box, filled with random dots.
    Dots,
    /// One box, and 10 % of the pixels black or white.
    Speckle,
    /// One box, and a Gaussian blur of 1.2 pixels.
    Blur,
    /// One box, ink and paper exchanged.
    Invert,
    /// One box, rotated by any angle about the middle; what comes from outside is hidden.
    Rotate,
}

/// All of them.
pub const HARMS: [Harm; 7] = [
    Harm::Box,
    Harm::SmallBoxes,
    Harm::Dots,
    Harm::Speckle,
    Harm::Blur,
    Harm::Invert,
    Harm::Rotate,
];

/// A harmed picture.
#[derive(Clone, Debug)]
pub struct Harmed {
    /// Grey levels: 0 is ink, 1 is paper.
    pub picture: Field,
    /// What is visible.
    pub visible: Vec<bool>,
    /// The truth in the harmed picture's frame (not inverted), for pixels that show the source.
    pub truth: Vec<bool>,
}

/// Hides `share` of a picture in [0, 1) and does `harm` to it.
///
/// # Errors
/// [`Error::Config`] if the share is outside its range.
pub fn harm(source: &Ink, harm: Harm, share: f64, seed: u64) -> Result<Harmed> {
    if !(0.0..1.0).contains(&share) {
        return Err(Error::range("share", share, "[0, 1)"));
    }
    let [ny, nx] = source.shape;
    let grid = Grid::new(&[ny, nx], 1.0)?;
    let mut random = stream(seed, "harm", harm as u64);
    let mut visible = match harm {
        Harm::SmallBoxes => small_boxes(source.shape, share, &mut random),
        _ => one_box(source.shape, share, &mut random),
    };
    let mut truth = source.ink.clone();
    if harm == Harm::Rotate {
        let angle = std::f64::consts::PI * uniform(&mut random);
        let (turned, inside) = rotate(source, angle);
        visible.iter_mut().zip(&inside).for_each(|(v, i)| *v &= i);
        truth = turned;
    }
    let mut values: Vec<f64> = truth.iter().map(|&ink| if ink { 0.0 } else { 1.0 }).collect();
    match harm {
        Harm::Blur => {
            values = normalized_convolution(source.shape, &values, &vec![1.0; values.len()], 1.2).0;
        }
        Harm::Speckle => {
            for value in &mut values {
                if uniform(&mut random) < 0.1 {
                    *value = f64::from(u8::from(uniform(&mut random) < 0.5));
                }
            }
        }
        Harm::Invert => values.iter_mut().for_each(|v| *v = 1.0 - *v),
        _ => {}
    }
    for (value, _) in values.iter_mut().zip(&visible).filter(|(_, seen)| !**seen) {
        *value = match harm {
            Harm::Dots => f64::from(u8::from(uniform(&mut random) < 0.5)),
            _ => 0.5,
        };
    }
    Ok(Harmed { picture: Field::from_vec(grid, values)?, visible, truth })
}

/// All but a box of the picture's proportions, anywhere inside.
fn one_box([ny, nx]: [usize; 2], share: f64, random: &mut Stream) -> Vec<bool> {
    let side = share.sqrt();
    let (h, w) = ((side * ny as f64).round() as usize, (side * nx as f64).round() as usize);
    let top = (uniform(random) * (ny - h + 1) as f64) as usize;
    let left = (uniform(random) * (nx - w + 1) as f64) as usize;
    let hidden =
        |n: usize| (top..top + h).contains(&(n / nx)) && (left..left + w).contains(&(n % nx));
    (0..ny * nx).map(|n| !hidden(n)).collect()
}

/// All but boxes of an eighth of the shorter side, dropped until the share is hidden.
fn small_boxes([ny, nx]: [usize; 2], share: f64, random: &mut Stream) -> Vec<bool> {
    let side = (ny.min(nx) / 8).max(1);
    let mut visible = vec![true; ny * nx];
    let wanted = (share * visible.len() as f64) as usize;
    let mut hidden = 0;
    while hidden < wanted {
        let top = (uniform(random) * (ny - side + 1) as f64) as usize;
        let left = (uniform(random) * (nx - side + 1) as f64) as usize;
        for j in top..top + side {
            for seen in &mut visible[j * nx + left..][..side] {
                hidden += usize::from(*seen);
                *seen = false;
            }
        }
    }
    visible
}

/// The picture turned about its middle, and which pixels come from inside it.
fn rotate(source: &Ink, angle: f64) -> (Vec<bool>, Vec<bool>) {
    let [ny, nx] = source.shape;
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    let (cy, cx) = (0.5 * (ny - 1) as f64, 0.5 * (nx - 1) as f64);
    let (mut turned, mut inside) = (vec![false; ny * nx], vec![false; ny * nx]);
    for n in 0..ny * nx {
        let (y, x) = ((n / nx) as f64 - cy, (n % nx) as f64 - cx);
        let (v, u) = (cy + cos * y - sin * x, cx + sin * y + cos * x);
        if v < 0.0 || u < 0.0 || v > (ny - 1) as f64 || u > (nx - 1) as f64 {
            continue;
        }
        let (j, i) = ((v as usize).min(ny - 2), (u as usize).min(nx - 2));
        let (t, s) = (v - j as f64, u - i as f64);
        let at = |j: usize, i: usize| f64::from(u8::from(source.ink[j * nx + i]));
        let row = |j: usize| (1.0 - s) * at(j, i) + s * at(j, i + 1);
        turned[n] = (1.0 - t) * row(j) + t * row(j + 1) > 0.5;
        inside[n] = true;
    }
    (turned, inside)
}
