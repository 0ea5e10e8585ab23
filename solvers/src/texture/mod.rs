//! Statistics of pictures in ink and paper of which only a part is seen.
//!
//! Every estimator counts pairs, squares or segments of pixels that are all visible and
//! divides by how many there are, so that hidden pixels never enter and, on average, do
//! not shift a value. Lengths are in units of the pattern's wavelength.
//!
//! | symbol | code         | meaning                                        | unit   |
//! |--------|--------------|------------------------------------------------|--------|
//! | f      | `fraction`   | ink among the visible pixels                   | 1      |
//! | c(r)   | `Correlation`| autocovariance over the variance f (1 - f)     | 1      |
//! | lambda | `wavelength` | 2 pi over the peak of the spectrum of c        | pixels |

mod chords;
mod correlation;
mod depth;
mod descriptor;
mod kriging;
mod level_sets;
mod smooth;

pub use chords::lineal_path;
pub use correlation::Correlation;
pub use depth::depth;
pub use descriptor::{Descriptor, NAMES, invert};
pub use kriging::Kriging;
pub use level_sets::{Densities, LevelSets};
pub use smooth::normalized_convolution;

use crate::{Error, Result};

/// A picture in ink and paper with hidden parts.
#[derive(Clone, Copy, Debug)]
pub struct Masked<'a> {
    /// Rows and columns.
    pub shape: [usize; 2],
    /// Whether a pixel is ink; of hidden pixels it is never read.
    pub ink: &'a [bool],
    /// Whether a pixel is visible.
    pub visible: &'a [bool],
}

impl<'a> Masked<'a> {
    /// Checks the lengths.
    ///
    /// # Errors
    /// If a slice has not one entry per pixel.
    pub fn new(shape: [usize; 2], ink: &'a [bool], visible: &'a [bool]) -> Result<Self> {
        for (name, slice) in [("ink", ink), ("visible", visible)] {
            if slice.len() != shape[0] * shape[1] {
                return Err(Error::Shape {
                    name: name.into(),
                    actual: vec![slice.len()],
                    expected: shape.to_vec(),
                });
            }
        }
        Ok(Self { shape, ink, visible })
    }

    /// 1 for ink, 0 for paper and for what is hidden.
    pub(crate) fn values(&self) -> Vec<f64> {
        let pairs = self.ink.iter().zip(self.visible);
        pairs.map(|(&ink, &seen)| f64::from(u8::from(ink && seen))).collect()
    }

    /// 1 for visible, 0 for hidden.
    pub(crate) fn weights(&self) -> Vec<f64> {
        self.visible.iter().map(|&seen| f64::from(u8::from(seen))).collect()
    }

    /// Ink among the visible pixels; none if nothing is visible.
    pub fn fraction(&self) -> Option<f64> {
        let seen = self.visible.iter().filter(|&&seen| seen).count();
        let ink = self.ink.iter().zip(self.visible).filter(|&(&ink, &seen)| ink && seen).count();
        (seen > 0).then(|| ink as f64 / seen as f64)
    }
}

#[cfg(test)]
mod tests;
