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

/// Runs `class` at `point` (shares of its ranges) to its end and returns its picture in ink.
///
/// # Errors
/// What the model refuses or meets on its way; a model without a plane picture in ink.
pub fn simulate(class: &Class, point: &[f64], seed: u64, inputs: &dyn Inputs) -> Result<Ink> {
    let config = class.configure(point)?;
    let context = Context { seed, inputs, memory: 1 << 30 };
    let mut run = (class.model.start)(&config, &context)?;
    while run.step()? == Status::Running {}
    let ink = run.artifacts().into_iter().find_map(|artifact| match artifact {
        Artifact::Image(image) | Artifact::Drawing { image, .. } => black_and_white(&image),
        _ => None,
    });
    let reason = || format!("`{}` shows no plane picture in ink", class.model.name);
    ink.ok_or_else(|| Error::config("model", reason()))
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
