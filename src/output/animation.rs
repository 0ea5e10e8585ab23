//! Animations: frames as small indexed images, written as GIF or APNG.

use super::axes;
use anyhow::{Context as _, Result, bail, ensure};
use patterns::{Colors, Image};
use rayon::prelude::*;
use std::{io::Write, path::Path};

mod bytes;
mod film;
mod frame;
mod turntable;

pub use turntable::write_pictures;

use film::Film;
use frame::Frame;

/// Smaller frames are magnified by a whole number, up to this many pixels.
const SIDE: usize = 320;
/// Hundredths of a second for each frame, and for the last before the film begins again.
const DELAY: u16 = 7;
const LAST_DELAY: u16 = 150;
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
        self.film()?.write_gif(out)
    }

    /// Writes an animated PNG that repeats for ever.
    ///
    /// # Errors
    /// If there is no frame or `out` fails.
    pub fn write_apng(&self, out: &mut impl Write) -> Result<()> {
        self.film()?.write_apng(out)
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
        Ok(Film::new(size, film::palette(self.colors), &pictures, [DELAY, LAST_DELAY]))
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
