//! Films of coloured pictures.

use super::film::{Film, UNCHANGED};
use crate::{output::colormap::Rgb, render::Picture};
use anyhow::{Context as _, Result, bail, ensure};
use rayon::prelude::*;
use std::{io::Write, path::Path};

/// Hundredths of a second for each picture.
const DELAY: u16 = 5;
/// Bits of a channel that the palette tells apart.
const BITS: usize = 6;
/// Colours of a palette; the last is [`UNCHANGED`].
const COLORS: usize = UNCHANGED as usize;

/// Writes pictures of one size as a GIF or APNG that repeats for ever, by the extension of
/// `path` (`.gif`, `.png`, `.apng`), in 255 colours chosen by median cut (Heckbert 1982).
///
/// # Errors
/// If the extension is another, there is no picture, sizes differ, or `out` fails.
pub fn write_pictures(pictures: &[Picture], path: &Path, out: &mut impl Write) -> Result<()> {
    let size = pictures.first().context("the animation has no frame")?.size;
    ensure!(pictures.iter().all(|p| p.size == size), "the frames have several sizes");
    let (palette, numbers) = palette(pictures);
    let indexed = |p: &Picture| p.pixels.iter().map(|&c| numbers[bin(c)]).collect();
    let frames: Vec<Vec<u8>> = pictures.par_iter().map(indexed).collect();
    let film = Film::new(size, palette, &frames, [DELAY; 2]);
    match path.extension().and_then(|e| e.to_str()) {
        Some("gif") => film.write_gif(out),
        Some("png" | "apng") => film.write_apng(out),
        other => bail!("`.{}` is no animation; wanted is .gif, .apng or .png", other.unwrap_or("")),
    }
}

/// Number of a colour when each channel keeps its upper bits.
fn bin(color: Rgb) -> usize {
    color.iter().fold(0, |n, &c| n << BITS | usize::from(c >> (8 - BITS)))
}

/// Colours with their counts.
struct Bins {
    /// Number, count, and sums of the channels.
    bins: Vec<(usize, u64, [u64; 3])>,
}

impl Bins {
    /// The channel that spreads most, and how much it matters.
    fn spread(&self) -> (usize, f64) {
        let count: u64 = self.bins.iter().map(|b| b.1).sum();
        let channel = |n: usize, c: usize| n >> (BITS * (2 - c)) & ((1 << BITS) - 1);
        let side = |c: usize| {
            let all = || self.bins.iter().map(|b| channel(b.0, c));
            all().max().unwrap_or(0) - all().min().unwrap_or(0)
        };
        let widest = (0..3).max_by_key(|&c| (side(c), c)).unwrap_or(0);
        // The square root: small regions of other colours count as well.
        (widest, side(widest) as f64 * (count as f64).sqrt())
    }

    /// Two halves of about equal count.
    fn split(mut self) -> [Self; 2] {
        let (c, _) = self.spread();
        self.bins.sort_by_key(|b| (b.0 >> (BITS * (2 - c)) & ((1 << BITS) - 1), b.0));
        let total: u64 = self.bins.iter().map(|b| b.1).sum();
        let mut sum = 0;
        let before = |b: &(usize, u64, [u64; 3])| {
            sum += b.1;
            2 * sum <= total
        };
        let half = self.bins.iter().copied().take_while(before).count();
        let rest = self.bins.split_off(half.clamp(1, self.bins.len() - 1));
        [self, Self { bins: rest }]
    }

    fn mean(&self) -> Rgb {
        let count: u64 = self.bins.iter().map(|b| b.1).sum();
        [0, 1, 2].map(|c| {
            let sum: u64 = self.bins.iter().map(|b| b.2[c]).sum();
            ((sum + count / 2) / count.max(1)) as u8
        })
    }
}

/// A palette for all pictures, and its entry for each [`bin`].
fn palette(pictures: &[Picture]) -> ([Rgb; 256], Vec<u8>) {
    let mut counts = vec![(0, [0; 3]); 1 << (3 * BITS)];
    for &color in pictures.iter().flat_map(|p| &p.pixels) {
        let (count, sums) = &mut counts[bin(color)];
        *count += 1;
        (0..3).for_each(|c| sums[c] += u64::from(color[c]));
    }
    let used = counts.iter().enumerate().filter(|(_, (count, _))| *count > 0);
    let mut boxes = vec![Bins { bins: used.map(|(n, &(count, sums))| (n, count, sums)).collect() }];
    while boxes.len() < COLORS {
        let splittable = boxes.iter().enumerate().filter(|(_, b)| b.bins.len() > 1);
        let next = splittable.max_by(|(_, a), (_, b)| a.spread().1.total_cmp(&b.spread().1));
        let Some(n) = next.map(|(n, _)| n) else { break };
        let parts = boxes.swap_remove(n).split();
        boxes.extend(parts);
    }
    let mut palette = [[255; 3]; 256];
    let mut numbers = vec![0; counts.len()];
    for (n, part) in boxes.iter().enumerate() {
        palette[n] = part.mean();
        part.bins.iter().for_each(|b| numbers[b.0] = n as u8);
    }
    (palette, numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_colours_stay_and_many_stay_close() {
        let few: Vec<Rgb> = (0..64).map(|n| [n as u8 * 3, 200, 255 - n as u8 * 2]).collect();
        let smooth: Vec<Rgb> =
            (0..4096).map(|n| [200 + (n % 50) as u8, 180 + (n / 64) as u8 / 2, 150]).collect();
        for (colors, most) in [(few, 3), (smooth, 3)] {
            let picture = Picture { size: [colors.len(), 1], pixels: colors.clone() };
            let (palette, numbers) = palette(&[picture]);
            for color in colors {
                let near = palette[usize::from(numbers[bin(color)])];
                let off = (0..3).map(|c| color[c].abs_diff(near[c])).max().unwrap();
                assert!(off <= most, "{color:?} {near:?}");
            }
        }
    }
}
