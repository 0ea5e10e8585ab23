//! The border of the ink of a filled picture, by the level-set engine.

use super::super::normalize::Normal;
use crate::Result;
use solvers::level_set::{LevelSet, Order, Redistance, RedistanceOptions, Scheme, Speed, Terms};
use solvers::texture::normalized_convolution;
use solvers::{Boundary, Field, Grid};

/// Steps of the curve, their length (pixels) and the number between two redistancings: the
/// border starts within a pixel of where it rests.
const STEPS: (usize, f64, usize) = (40, 0.45, 5);

/// Bound on |phi| (pixels) while it moves.
const CLIP: f64 = 3.0;

/// Smoothing of pictures of which only ink and paper are known (pixels).
const SMOOTH: f64 = 0.7;

/// Greatest change of side: the speed is a smooth sign of the target over this part of its
/// standard deviation.
const WIDTH: f64 = 0.25;

struct Towards<'a> {
    target: &'a [f64],
    width: f64,
}

impl Speed for Towards<'_> {
    fn add(&mut self, _: &Field, _: f64, terms: &mut Terms) -> solvers::Result<()> {
        let beta = terms.normal().as_mut_slice();
        for (beta, &v) in beta.iter_mut().zip(self.target) {
            *beta -= v / (v * v + self.width * self.width).sqrt();
        }
        Ok(())
    }
}

/// phi, negative in the ink (pixels): the curve that Algorithm 1's speed brings to rest on the
/// border of `picture`. `level` (negative in the ink, any scale) says where the border passes
/// between hidden pixels; where visible only colours are known.
///
/// # Errors
/// What the engine refuses.
pub fn contour(normal: &Normal, picture: &[bool], level: &[f64]) -> Result<Field> {
    let [ny, nx] = normal.shape;
    let grid = Grid::new(&[ny, nx], 1.0)?;
    let colours: Vec<f64> = picture.iter().map(|&ink| if ink { -1.0 } else { 1.0 }).collect();
    let mut target = normalized_convolution(normal.shape, &colours, &vec![1.0; ny * nx], SMOOTH).0;
    let scale = deviation(level.iter().zip(&normal.visible).filter(|(_, s)| !**s).map(|v| *v.0));
    for n in (0..ny * nx).filter(|&n| !normal.visible[n] && scale > 0.0) {
        target[n] = level[n] / scale;
    }
    // A pixel keeps its colour, whatever smoothing says.
    for (value, colour) in target.iter_mut().zip(&colours) {
        *value = colour * (colour * *value).max(0.05);
    }
    let boundary = Boundary::Neumann;
    let mut phi = Field::from_vec(grid, colours)?;
    if !picture.contains(&true) || !picture.contains(&false) {
        return Ok(phi);
    }
    let width = WIDTH * deviation(target.iter().copied());
    let mut redistance = Redistance::new(grid, RedistanceOptions { boundary, band: Some(CLIP) })?;
    redistance.apply(&mut phi)?;
    let scheme = Scheme { order: Order::First, boundary, clip: Some(CLIP), ..Scheme::default() };
    let mut front = LevelSet::new(phi, scheme)?;
    let mut speed = Towards { target: &target, width };
    let (steps, dt, every) = STEPS;
    for n in 1..=steps {
        front.step(&mut speed, dt)?;
        if n.is_multiple_of(every) {
            redistance.apply(front.phi_mut())?;
        }
    }
    let mut phi = front.phi().clone();
    Redistance::new(grid, RedistanceOptions { boundary, band: None })?.apply(&mut phi)?;
    Ok(phi)
}

fn deviation(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let (sum, squares, count) =
        values.fold((0.0, 0.0, 0.0_f64), |(a, b, n), v| (a + v, b + v * v, n + 1.0));
    let mean = sum / count.max(1.0);
    (squares / count.max(1.0) - mean * mean).max(0.0).sqrt()
}
