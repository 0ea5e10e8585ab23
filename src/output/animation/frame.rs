//! Frames of animations: small while recorded, palette indices when drawn.

use super::film::{GREYS, LINE, MIXES, NAN_COLOR, SHADES};
use crate::output::{
    axes, canvas,
    slice::{self, Slice},
};
use patterns::{Colors, Image};

/// Larger frames are shrunk to this many cells.
const LARGEST: usize = 512;
/// Level of a cell that is not a number; the others are 0 to 254.
const NAN_LEVEL: u8 = 255;
/// Steps of `phi` for one cell: clipped at 3.2 cells.
const PHI_STEPS: f64 = 40.0;
/// A frame, at most [`LARGEST`] cells a side.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Frame {
    pub(super) nx: usize,
    pub(super) ny: usize,
    /// Values of levels 0 and 254.
    pub(super) range: [f64; 2],
    pub(super) levels: Vec<u8>,
    /// `phi` in cells times [`PHI_STEPS`].
    pub(super) phi: Option<Vec<i8>>,
}

impl Frame {
    /// The middle slice of an image, small enough.
    pub(super) fn new(image: &Image) -> Self {
        let reduced = |field| {
            let mut slice = slice::middle(field).remove(0);
            let shrink = slice.nx.max(slice.ny).div_ceil(LARGEST);
            slice = slice.shrink(shrink);
            if image.field.grid().dim() == 1 {
                // A line as a band.
                let rows = (slice.nx / 8).max(1);
                slice = Slice { ny: rows, values: slice.values.repeat(rows), ..slice };
            }
            slice
        };
        let slice = reduced(&image.field);
        let [low, high] = axes::data_range(slice.values.iter().copied(), false);
        let level = |v: &f64| match v.is_nan() {
            true => NAN_LEVEL,
            false => ((v - low) / (high - low) * 254.0).round().clamp(0.0, 254.0) as u8,
        };
        let levels = slice.values.iter().map(level).collect();
        let phi = image.contour.as_ref().map(|phi| {
            let slice = reduced(phi);
            let step = |v: &f64| (v / slice.spacing * PHI_STEPS).clamp(-127.0, 127.0).round() as i8;
            slice.values.iter().map(step).collect()
        });
        Self { nx: slice.nx, ny: slice.ny, range: [low, high], levels, phi }
    }

    /// Palette indices of the picture, `times` pixels a cell.
    pub(super) fn draw(&self, times: usize, range: [f64; 2], colors: Colors) -> Vec<u8> {
        let [low, high] = self.range;
        let value = |&level: &u8| match level {
            NAN_LEVEL => f64::NAN,
            level => low + f64::from(level) / 254.0 * (high - low),
        };
        let t = |v: f64| (v - range[0]) / (range[1] - range[0]);
        let slice = |values: Vec<f64>| Slice {
            nx: self.nx,
            ny: self.ny,
            values,
            spacing: 1.0,
            unit: "cells",
            axes: ["x", "y"],
            rows: None,
            at: String::new(),
        };
        let phi = self.phi.as_ref();
        let phi = phi.map(|phi| slice(phi.iter().map(|&v| f64::from(v)).collect()));
        if colors == Colors::Ink {
            let shades: Vec<f64> = match phi {
                Some(phi) => phi.magnify(times).outside(),
                None => {
                    let values = self.levels.iter().map(|level| t(value(level))).collect();
                    slice(values).magnify(times).values
                }
            };
            let top = f64::from(GREYS);
            return shades.iter().map(|v| (v * top).round().clamp(0.0, top) as u8).collect();
        }
        let shades: Vec<u8> = (0..=255)
            .map(|level: u8| match value(&level) {
                v if v.is_nan() => NAN_COLOR,
                v => {
                    let last = (SHADES - 1) as f64;
                    (t(v) * last).round().clamp(0.0, last) as u8 * MIXES as u8
                }
            })
            .collect();
        let mut picture = Vec::with_capacity(self.levels.len() * times * times);
        for row in self.levels.chunks_exact(self.nx) {
            let start = picture.len();
            let cells = row.iter().map(|&level| shades[usize::from(level)]);
            picture.extend(cells.flat_map(|shade| std::iter::repeat_n(shade, times)));
            let end = picture.len();
            (1..times).for_each(|_| picture.extend_from_within(start..end));
        }
        if let Some(phi) = phi {
            draw_line(&mut picture, &phi, times);
        }
        picture
    }
}

/// Mixes the zero line of `phi` into a picture.
fn draw_line(picture: &mut [u8], phi: &Slice, times: usize) {
    let pixel = |p: [f64; 2]| p.map(|v| (v + 0.5) * times as f64);
    let segments: Vec<_> = phi.zero_segments().into_iter().map(|s| s.map(pixel)).collect();
    let coverage = canvas::coverage([phi.nx * times, phi.ny * times], &segments, 1.8);
    for (shade, &covered) in picture.iter_mut().zip(&coverage) {
        if covered == 0.0 {
            continue;
        }
        let mix = (covered * MIXES as f32).round() as u8;
        *shade = match mix {
            0 => *shade,
            mix if *shade < LINE && mix < MIXES as u8 => *shade + mix,
            _ => LINE,
        };
    }
}
