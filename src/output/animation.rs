//! Animations: frames as small indexed images, written as GIF or APNG.

use super::{
    axes, canvas,
    colormap::{Colormap, NOT_A_NUMBER},
    slice::{self, Slice},
};
use anyhow::{Context as _, Result, bail, ensure};
use patterns::{Colors, Image};
use rayon::prelude::*;
use std::{borrow::Cow, io::Write, path::Path};

mod bytes;

/// Larger frames are shrunk to this many cells.
const LARGEST: usize = 512;
/// Smaller frames are magnified by a whole number, up to this many pixels.
const SIDE: usize = 320;
/// Hundredths of a second for each frame, and for the last before the film begins again.
const DELAY: u16 = 7;
const LAST_DELAY: u16 = 150;
/// Level of a cell that is not a number; the others are 0 to 254.
const NAN_LEVEL: u8 = 255;
/// Steps of `phi` for one cell: clipped at 3.2 cells.
const PHI_STEPS: f64 = 40.0;
/// Colours of the palette in false colours, each in `MIXES` mixtures with the line's colour.
const SHADES: usize = 84;
const MIXES: usize = 3;
/// Palette entries of the line, of cells that are not numbers, and of unchanged pixels.
const LINE: u8 = (SHADES * MIXES) as u8;
const NAN_COLOR: u8 = LINE + 1;
const UNCHANGED: u8 = 255;
/// Greys of ink: palette entries 0 (black) to `GREYS` (white).
const GREYS: u8 = 253;

/// A film that is recorded frame by frame.
///
/// When there are more than `limit` frames every other one is dropped, and from then on
/// only every second, fourth, ... is kept; the newest is always the last of the film. The
/// frames that remain depend on the number of those seen only, so that a run that was
/// interrupted and resumed ([`Self::to_bytes`]) makes the same film.
#[derive(Clone, Debug, PartialEq)]
pub struct Animation {
    limit: usize,
    stride: u64,
    seen: u64,
    colors: Colors,
    range: Option<[f64; 2]>,
    frames: Vec<Frame>,
    /// The newest frame, unless it is the last of `frames`.
    newest: Option<Frame>,
}

/// A frame, at most [`LARGEST`] cells a side.
#[derive(Clone, Debug, PartialEq)]
struct Frame {
    nx: usize,
    ny: usize,
    /// Values of levels 0 and 254.
    range: [f64; 2],
    levels: Vec<u8>,
    /// `phi` in cells times [`PHI_STEPS`].
    phi: Option<Vec<i8>>,
}

impl Animation {
    /// An empty film of at most `limit` frames, at least 2.
    pub fn new(limit: usize) -> Self {
        Self {
            limit: limit.max(2),
            stride: 1,
            seen: 0,
            colors: Colors::Sequential,
            range: None,
            frames: Vec::new(),
            newest: None,
        }
    }

    /// Number of frames of the film.
    pub fn len(&self) -> usize {
        self.frames.len() + usize::from(self.newest.is_some())
    }

    /// Whether there is no frame yet.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Adds a frame; of a solid its middle slice across z. The first frame sets shape,
    /// colours and range for all.
    ///
    /// # Errors
    /// If the shape differs from that of the first frame.
    pub fn push(&mut self, image: &Image) -> Result<()> {
        let frame = Frame::new(image);
        match self.frames.first() {
            None => {
                self.colors = image.colors;
                self.range = image.range.filter(|&r| axes::is_range(r, false));
            }
            Some(first) => ensure!(
                (first.nx, first.ny) == (frame.nx, frame.ny),
                "a frame of {} x {} cells follows frames of {} x {}",
                frame.nx,
                frame.ny,
                first.nx,
                first.ny
            ),
        }
        self.newest = None;
        if self.seen.is_multiple_of(self.stride) {
            self.frames.push(frame);
        } else {
            self.newest = Some(frame);
        }
        self.seen += 1;
        if self.frames.len() > self.limit {
            self.thin();
        }
        Ok(())
    }

    /// Drops every other frame.
    fn thin(&mut self) {
        // The newest stays at the end of the film.
        if self.frames.len().is_multiple_of(2) {
            self.newest = self.frames.last().cloned();
        }
        let mut n = 0;
        self.frames.retain(|_| {
            n += 1;
            n % 2 == 1
        });
        self.stride *= 2;
    }

    /// Writes the film as GIF or APNG, by the extension of `path` (`.gif`, `.png`, `.apng`).
    ///
    /// # Errors
    /// If the extension is another, or as [`Self::write_gif`].
    pub fn write(&self, path: &Path, out: &mut impl Write) -> Result<()> {
        match path.extension().and_then(|e| e.to_str()) {
            Some("gif") => self.write_gif(out),
            Some("png" | "apng") => self.write_apng(out),
            other => {
                bail!("`.{}` is no animation; wanted is .gif, .apng or .png", other.unwrap_or(""))
            }
        }
    }

    /// Writes a GIF that repeats for ever.
    ///
    /// # Errors
    /// If there is no frame or `out` fails.
    pub fn write_gif(&self, out: &mut impl Write) -> Result<()> {
        let film = self.film()?;
        let [width, height] = film.size;
        let mut encoder =
            gif::Encoder::new(out, width as u16, height as u16, film.palette.as_flattened())?;
        encoder.set_repeat(gif::Repeat::Infinite)?;
        let compressed: Vec<gif::Frame<'_>> = film.patches.par_iter().map(Patch::to_gif).collect();
        for frame in &compressed {
            encoder.write_lzw_pre_encoded_frame(frame)?;
        }
        Ok(encoder.into_inner()?.flush()?)
    }

    /// Writes an animated PNG that repeats for ever.
    ///
    /// # Errors
    /// If there is no frame or `out` fails.
    pub fn write_apng(&self, out: &mut impl Write) -> Result<()> {
        let film = self.film()?;
        let [width, height] = film.size.map(|n| n as u32);
        let mut encoder = png::Encoder::new(out, width, height);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_palette(film.palette.as_flattened());
        encoder.set_trns([vec![255; 255], vec![0]].concat());
        encoder.set_compression(png::Compression::Balanced);
        encoder.set_filter(png::Filter::NoFilter);
        encoder.set_animated(film.patches.len() as u32, 0)?;
        let mut writer = encoder.write_header()?;
        for patch in &film.patches {
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

    /// The frames as patches over one another.
    fn film(&self) -> Result<Film> {
        let frames: Vec<&Frame> = self.frames.iter().chain(&self.newest).collect();
        let first = frames.first().context("the animation has no frame")?;
        let times = (SIDE / first.nx.max(first.ny)).max(1);
        let range = self.color_range(&frames);
        let draw = |frame: &&Frame| frame.draw(times, range, self.colors);
        let pictures: Vec<Vec<u8>> = frames.par_iter().map(draw).collect();
        let size = [first.nx * times, first.ny * times];
        let mut patches = vec![Patch {
            left: 0,
            top: 0,
            width: size[0],
            height: size[1],
            delay: DELAY,
            pixels: pictures[0].clone(),
        }];
        for pair in pictures.windows(2) {
            match (Patch::between(&pair[0], &pair[1], size[0]), patches.last_mut()) {
                (None, Some(last)) => last.delay = last.delay.saturating_add(DELAY),
                (patch, _) => patches.extend(patch),
            }
        }
        if let Some(last) = patches.last_mut() {
            last.delay = last.delay.saturating_add(LAST_DELAY - DELAY);
        }
        Ok(Film { size, palette: palette(self.colors), patches })
    }

    /// Values at the ends of the colormap, for all frames.
    fn color_range(&self, frames: &[&Frame]) -> [f64; 2] {
        if let Some(range) = self.range {
            return range;
        }
        let [low, high] = axes::data_range(frames.iter().flat_map(|f| f.range), false);
        if self.colors == Colors::Diverging {
            let end = low.abs().max(high.abs());
            return [-end, end];
        }
        [low, high]
    }
}

impl Frame {
    fn new(image: &Image) -> Self {
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
    fn draw(&self, times: usize, range: [f64; 2], colors: Colors) -> Vec<u8> {
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

/// The 256 colours of a film.
fn palette(colors: Colors) -> [[u8; 3]; 256] {
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
struct Film {
    size: [usize; 2],
    palette: [[u8; 3]; 256],
    patches: Vec<Patch>,
}

/// A rectangle that changes, with unchanged pixels transparent.
struct Patch {
    left: usize,
    top: usize,
    width: usize,
    height: usize,
    /// Hundredths of a second.
    delay: u16,
    pixels: Vec<u8>,
}

impl Patch {
    /// What turns the picture `old` into `new`; `None` if they are equal.
    fn between(old: &[u8], new: &[u8], nx: usize) -> Option<Self> {
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
        Some(Self { left, top, width, height, delay: DELAY, pixels })
    }

    fn to_gif(&self) -> gif::Frame<'_> {
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
