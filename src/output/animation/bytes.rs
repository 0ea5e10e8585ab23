//! Animations as bytes, for checkpoints.

use super::{Animation, frame::Frame};
use anyhow::{Context as _, Result, bail, ensure};
use patterns::Colors;

const MAGIC: &[u8] = b"PATTERNS-FILM-1\n";

impl Animation {
    /// All that is needed to go on recording ([`Self::from_bytes`]): little endian, about
    /// one byte a cell and frame, two with a contour.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = MAGIC.to_vec();
        let colors = match self.colors {
            Colors::Diverging => 1,
            Colors::Ink => 2,
            _ => 0,
        };
        let counts = [self.limit as u64, self.stride, self.seen, colors];
        counts.iter().for_each(|n| out.extend(n.to_le_bytes()));
        // NaN for an absent range: no range has NaN ends.
        let range = self.range.unwrap_or([f64::NAN; 2]);
        range.iter().for_each(|v| out.extend(v.to_le_bytes()));
        let first = self.frames.first();
        let [nx, ny] = first.map_or([0, 0], |f| [f.nx as u64, f.ny as u64]);
        let counts = [nx, ny, self.frames.len() as u64, u64::from(self.newest.is_some())];
        counts.iter().for_each(|n| out.extend(n.to_le_bytes()));
        for frame in self.frames.iter().chain(&self.newest) {
            frame.range.iter().for_each(|v| out.extend(v.to_le_bytes()));
            out.extend(&frame.levels);
            out.push(u8::from(frame.phi.is_some()));
            out.extend(frame.phi.iter().flatten().map(|v| v.cast_unsigned()));
        }
        out
    }

    /// Takes up a recording that [`Self::to_bytes`] saved.
    ///
    /// # Errors
    /// If the bytes are of something else or truncated.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let mut rest = bytes.strip_prefix(MAGIC).context("no saved animation")?;
        let rest = &mut rest;
        let [limit, stride, seen, colors] = [word(rest)?, word(rest)?, word(rest)?, word(rest)?];
        let range = [word(rest)?, word(rest)?].map(f64::from_bits);
        let [nx, ny, count, newest] = [word(rest)?, word(rest)?, word(rest)?, word(rest)?];
        let cells =
            nx.checked_mul(ny).filter(|&n| n <= 1 << 24).context("the frames are too large")?;
        let colors = match colors {
            0 => Colors::Sequential,
            1 => Colors::Diverging,
            2 => Colors::Ink,
            other => bail!("colours {other} are not known"),
        };
        ensure!(stride > 0, "the animation keeps no frame");
        let mut read = |_| -> Result<Frame> {
            let range = [word(rest)?, word(rest)?].map(f64::from_bits);
            let levels = take(rest, cells as usize)?.to_vec();
            let phi = match take(rest, 1)? {
                [0] => None,
                _ => Some(take(rest, cells as usize)?.iter().map(|v| v.cast_signed()).collect()),
            };
            Ok(Frame { nx: nx as usize, ny: ny as usize, range, levels, phi })
        };
        let frames = (0..count).map(&mut read).collect::<Result<Vec<_>>>()?;
        let newest = (newest == 1).then(|| read(0)).transpose()?;
        ensure!(rest.is_empty(), "{} bytes follow the animation", rest.len());
        let range = (!range[0].is_nan()).then_some(range);
        Ok(Self { limit: limit as usize, stride, seen, colors, range, frames, newest })
    }
}

fn take<'a>(rest: &mut &'a [u8], count: usize) -> Result<&'a [u8]> {
    let (head, tail) = rest.split_at_checked(count).context("the animation is truncated")?;
    *rest = tail;
    Ok(head)
}

fn word(rest: &mut &[u8]) -> Result<u64> {
    Ok(u64::from_le_bytes(take(rest, 8)?.try_into()?))
}
