//! Palettes, and films as patches over one another.

use crate::output::colormap::{Colormap, NOT_A_NUMBER};
use anyhow::Result;
use patterns::Colors;
use rayon::prelude::*;
use std::{borrow::Cow, io::Write};

/// Colours of the palette in false colours, each in `MIXES` mixtures with the line's colour.
pub(super) const SHADES: usize = 84;
pub(super) const MIXES: usize = 3;
/// Palette entries of the line, of cells that are not numbers, and of unchanged pixels.
pub(super) const LINE: u8 = (SHADES * MIXES) as u8;
pub(super) const NAN_COLOR: u8 = LINE + 1;
pub(super) const UNCHANGED: u8 = 255;
/// Greys of ink: palette entries 0 (black) to `GREYS` (white).
pub(super) const GREYS: u8 = 253;

/// The 256 colours of a film.
pub(super) fn palette(colors: Colors) -> [[u8; 3]; 256] {
    let mut palette = [[255; 3]; 256];
    if colors == Colors::Ink {
        for (n, color) in palette.iter_mut().enumerate() {
            *color = [(n * 255 / usize::from(GREYS)).min(255) as u8; 3];
        }
        return palette;
    }
    let map = Colormap::of(colors);
    // Black on the light middle of a diverging map, white on the others.
    let line = if colors == Colors::Diverging { [0; 3] } else { [255; 3] };
    for shade in 0..SHADES {
        let color = map.color(shade as f64 / (SHADES - 1) as f64);
        for mix in 0..MIXES {
            palette[shade * MIXES + mix] = std::array::from_fn(|c| {
                let (from, to) = (usize::from(color[c]), usize::from(line[c]));
                ((from * (MIXES - mix) + to * mix) / MIXES) as u8
            });
        }
    }
    palette[usize::from(LINE)] = line;
    palette[usize::from(NAN_COLOR)] = NOT_A_NUMBER;
    palette
}

/// What the encoders need.
pub(super) struct Film {
    pub(super) size: [usize; 2],
    pub(super) palette: [[u8; 3]; 256],
    pub(super) patches: Vec<Patch>,
}

impl Film {
    /// A film of pictures of `size` that are palette indices, shown for a time each and the
    /// last for another (hundredths of a second).
    pub(super) fn new(
        size: [usize; 2],
        palette: [[u8; 3]; 256],
        pictures: &[Vec<u8>],
        [delay, last_delay]: [u16; 2],
    ) -> Self {
        let mut patches = vec![Patch {
            left: 0,
            top: 0,
            width: size[0],
            height: size[1],
            delay,
            pixels: pictures[0].clone(),
        }];
        for pair in pictures.windows(2) {
            match (Patch::between(&pair[0], &pair[1], size[0], delay), patches.last_mut()) {
                (None, Some(last)) => last.delay = last.delay.saturating_add(delay),
                (patch, _) => patches.extend(patch),
            }
        }
        if let Some(last) = patches.last_mut() {
            last.delay = last.delay.saturating_add(last_delay - delay);
        }
        Self { size, palette, patches }
    }

    /// As a GIF that repeats for ever.
    pub(super) fn write_gif(&self, out: &mut impl Write) -> Result<()> {
        let [width, height] = self.size;
        let mut encoder =
            gif::Encoder::new(out, width as u16, height as u16, self.palette.as_flattened())?;
        encoder.set_repeat(gif::Repeat::Infinite)?;
        let compressed: Vec<gif::Frame<'_>> = self.patches.par_iter().map(Patch::to_gif).collect();
        for frame in &compressed {
            encoder.write_lzw_pre_encoded_frame(frame)?;
        }
        Ok(encoder.into_inner()?.flush()?)
    }

    /// As an animated PNG that repeats for ever.
    pub(super) fn write_apng(&self, out: &mut impl Write) -> Result<()> {
        let [width, height] = self.size.map(|n| n as u32);
        let mut encoder = png::Encoder::new(out, width, height);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_palette(self.palette.as_flattened());
        encoder.set_trns([vec![255; 255], vec![0]].concat());
        encoder.set_compression(png::Compression::Balanced);
        encoder.set_filter(png::Filter::NoFilter);
        encoder.set_animated(self.patches.len() as u32, 0)?;
        let mut writer = encoder.write_header()?;
        for patch in &self.patches {
            // The first covers everything.
            writer.reset_frame_position()?;
            writer.set_frame_dimension(patch.width as u32, patch.height as u32)?;
            writer.set_frame_position(patch.left as u32, patch.top as u32)?;
            writer.set_blend_op(png::BlendOp::Over)?;
            writer.set_frame_delay(patch.delay, 100)?;
            writer.write_image_data(&patch.pixels)?;
        }
        Ok(writer.finish()?)
    }
}

/// A rectangle that changes, with unchanged pixels transparent.
pub(super) struct Patch {
    pub(super) left: usize,
    pub(super) top: usize,
    pub(super) width: usize,
    pub(super) height: usize,
    /// Hundredths of a second.
    pub(super) delay: u16,
    pub(super) pixels: Vec<u8>,
}

impl Patch {
    /// What turns the picture `old` into `new`; `None` if they are equal.
    pub(super) fn between(old: &[u8], new: &[u8], nx: usize, delay: u16) -> Option<Self> {
        let [mut left, mut top, mut right, mut bottom] = [usize::MAX, usize::MAX, 0, 0];
        for (y, (a, b)) in old.chunks_exact(nx).zip(new.chunks_exact(nx)).enumerate() {
            if a == b {
                continue;
            }
            let differs = |x: &usize| a[*x] != b[*x];
            left = left.min((0..nx).find(differs).unwrap_or(nx));
            right = right.max((0..nx).rfind(differs).map_or(0, |x| x + 1));
            (top, bottom) = (top.min(y), y + 1);
        }
        if bottom == 0 {
            return None;
        }
        let mut pixels = Vec::with_capacity((right - left) * (bottom - top));
        for y in top..bottom {
            let row = y * nx + left..y * nx + right;
            let pairs = old[row.clone()].iter().zip(&new[row]);
            pixels.extend(pairs.map(|(a, b)| if a == b { UNCHANGED } else { *b }));
        }
        let (width, height) = (right - left, bottom - top);
        Some(Self { left, top, width, height, delay, pixels })
    }

    /// Compressed.
    pub(super) fn to_gif(&self) -> gif::Frame<'_> {
        let mut frame = gif::Frame {
            delay: self.delay,
            dispose: gif::DisposalMethod::Keep,
            transparent: Some(UNCHANGED),
            left: self.left as u16,
            top: self.top as u16,
            width: self.width as u16,
            height: self.height as u16,
            buffer: Cow::Borrowed(&self.pixels),
            ..gif::Frame::default()
        };
        frame.make_lzw_pre_encoded();
        frame
    }
}
