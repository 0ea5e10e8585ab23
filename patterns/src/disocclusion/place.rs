//! Candidates in the frame of the picture.

use super::{Match, candidate::Ink};

/// How a candidate lies in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Whether ink and paper are exchanged.
    pub inverted: bool,
    /// How far the picture is turned from the candidate's frame (radians); none for a texture,
    /// which repeats itself.
    pub angle: Option<f64>,
    /// Pixels of a texture to a pixel of the picture.
    pub scale: f64,
}

impl Placement {
    /// As an answer tells; textures pixel by pixel.
    pub fn of(found: &Match) -> Self {
        Self { inverted: found.inverted, angle: found.angle, scale: 1.0 }
    }

    /// The candidate as it would be seen, `shape` pixels.
    pub fn place(&self, candidate: &Ink, shape: [usize; 2]) -> Ink {
        let [ny, nx] = shape;
        let [cy, cx] = candidate.shape;
        let ink = match self.angle {
            None => (0..ny * nx)
                .map(|n| {
                    let at =
                        |n: usize, side: usize| ((n as f64 + 0.5) * self.scale) as usize % side;
                    candidate.ink[at(n / nx, cy) * cx + at(n % nx, cx)] != self.inverted
                })
                .collect(),
            Some(angle) => {
                let frame = Frame::new(shape, candidate.shape, angle);
                let at = |n: usize| frame.find(n).is_some_and(|m| candidate.ink[m]);
                (0..ny * nx).map(|n| at(n) != self.inverted).collect()
            }
        };
        Ink { shape, ink }
    }
}

/// From pixels of a picture to those of a candidate that fills its frame, turned about the middle.
pub(super) struct Frame {
    shape: [usize; 2],
    other: [usize; 2],
    sin: f64,
    cos: f64,
}

impl Frame {
    /// The candidate's longer side lies along the picture's after a turn by `angle`.
    pub(super) fn new(shape: [usize; 2], other: [usize; 2], angle: f64) -> Self {
        // A picture on its side is a quarter turn of the candidate's frame.
        let swapped = swapped(shape, other);
        let scale = other[1] as f64 / shape[usize::from(!swapped)] as f64;
        let (sin, cos) = (libm::sin(angle) * scale, libm::cos(angle) * scale);
        Self { shape, other, sin, cos }
    }

    /// Pixels of the candidate to a pixel of the picture.
    pub(super) fn scale(&self) -> f64 {
        self.sin.hypot(self.cos)
    }

    /// The candidate's pixel under the picture's pixel `n`; none outside.
    pub(super) fn find(&self, n: usize) -> Option<usize> {
        let ([ny, nx], [cy, cx]) = (self.shape, self.other);
        let y = (n / nx) as f64 + 0.5 - 0.5 * ny as f64;
        let x = (n % nx) as f64 + 0.5 - 0.5 * nx as f64;
        let u = self.cos * x + self.sin * y + 0.5 * cx as f64;
        let v = self.cos * y - self.sin * x + 0.5 * cy as f64;
        let inside = u >= 0.0 && v >= 0.0 && u < cx as f64 && v < cy as f64;
        inside.then(|| v as usize * cx + u as usize)
    }
}

/// Largest difference of the logarithms of two aspect ratios of the same frame.
const ASPECT: f64 = 0.15;

/// Logarithm of width over height.
fn aspect([ny, nx]: [usize; 2]) -> f64 {
    libm::log(nx as f64 / ny as f64)
}

/// Whether two frames have the same proportions, upright or on their side.
pub(super) fn alike(a: [usize; 2], b: [usize; 2]) -> bool {
    (aspect(a).abs() - aspect(b).abs()).abs() <= ASPECT
}

/// Whether one frame lies on its side.
pub(super) fn swapped(a: [usize; 2], b: [usize; 2]) -> bool {
    (aspect(a) - aspect(b)).abs() > ASPECT
}
