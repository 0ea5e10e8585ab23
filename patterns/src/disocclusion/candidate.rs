//! Patterns that a class makes, run through the registry.

use super::class::Class;
use crate::{Artifact, Colors, Context, Error, Image, Inputs, Result, Status};

/// A picture in ink and paper.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ink {
    /// Rows and columns.
    pub shape: [usize; 2],
    /// Whether a pixel is ink, row by row from the top.
    pub ink: Vec<bool>,
}

impl Ink {
    /// The same with `times` x `times` pixels for each.
    #[must_use]
    pub fn magnify(&self, times: usize) -> Self {
        let [ny, nx] = self.shape;
        let width = nx * times;
        let at = |n: usize| self.ink[n / width / times * nx + n % width / times];
        let ink = (0..ny * times * width).map(at).collect();
        Self { shape: [ny * times, width], ink }
    }
}

/// Runs `class` at `point` (shares of its ranges) to its end and returns its picture in ink.
///
/// # Errors
/// What the model refuses or meets on its way; a model without a plane picture in ink.
pub fn simulate(class: &Class, point: &[f64], seed: u64, inputs: &dyn Inputs) -> Result<Ink> {
    let mut end = None;
    watch(class, point, seed, 0, inputs, &mut |_, ink| {
        end = Some(ink);
        true
    })?;
    let reason = || format!("`{}` shows no plane picture in ink", class.model.name);
    end.ok_or_else(|| Error::config("model", reason()))
}

/// Rows and columns of the pictures of `class` at `point`, which is started but not run; none if
/// it shows none at its start.
///
/// # Errors
/// What the model refuses.
pub(super) fn frame(
    class: &Class,
    point: &[f64],
    inputs: &dyn Inputs,
) -> Result<Option<[usize; 2]>> {
    let context = Context { seed: 0, inputs, memory: 1 << 30 };
    let run = (class.model.start)(&class.configure(point)?, &context)?;
    Ok(run.artifacts().iter().find_map(ink_of).map(|ink| ink.shape))
}

/// Runs `class` to its end, or until `look` says no, and shows it the pictures in ink, with the
/// iteration: about `count` on the way and the last.
///
/// # Errors
/// What the model refuses or meets on its way.
pub(super) fn watch(
    class: &Class,
    point: &[f64],
    seed: u64,
    count: u64,
    inputs: &dyn Inputs,
    look: &mut dyn FnMut(u64, Ink) -> bool,
) -> Result<()> {
    let config = class.configure(point)?;
    let context = Context { seed, inputs, memory: 1 << 30 };
    let mut run = (class.model.start)(&config, &context)?;
    let every = run.expected_iterations().checked_div(count).map_or(u64::MAX, |n| n.max(1));
    let mut next = every;
    loop {
        let ended = run.step()? != Status::Running;
        if ended || run.iterations() >= next {
            next = (run.iterations() / every + 1).saturating_mul(every);
            if let Some(ink) = run.artifacts().iter().find_map(ink_of)
                && !look(run.iterations(), ink)
            {
                return Ok(());
            }
        }
        if ended {
            return Ok(());
        }
    }
}

/// The picture in ink of an artifact that is one.
pub(super) fn ink_of(artifact: &Artifact) -> Option<Ink> {
    match artifact {
        Artifact::Image(image) | Artifact::Drawing { image, .. } => black_and_white(image),
        _ => None,
    }
}

/// Ink of an image in ink: the inside of its contour, else the darker half of its range.
fn black_and_white(image: &Image) -> Option<Ink> {
    let grid = image.field.grid();
    if image.colors != Colors::Ink || grid.dim() != 2 {
        return None;
    }
    let [_, ny, nx] = grid.shape();
    let ink = match (&image.contour, image.range) {
        (Some(phi), _) => phi.as_slice().iter().map(|&v| v < 0.0).collect(),
        (None, range) => {
            let (low, high) = range.map_or_else(|| image.field.range(), |[low, high]| (low, high));
            image.field.as_slice().iter().map(|&v| v < 0.5 * (low + high)).collect()
        }
    };
    Some(Ink { shape: [ny, nx], ink })
}
