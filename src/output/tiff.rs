//! Stacks of grey pictures in a TIFF, as microscopes and CT scanners write them.

use super::volume::{self, Volume};
use anyhow::{Context as _, Result, ensure};
use ndarray::ArrayD;
use std::io::{Cursor, Seek, Write};
use tiff::{
    ColorType,
    decoder::{Decoder, DecodingResult, Limits},
    encoder::{TiffEncoder, colortype::Gray64Float},
};

/// Writes one page for each z, of 64-bit floating point numbers.
///
/// # Errors
/// If there are more than three axes or `out` fails.
pub fn write(volume: &Volume, out: &mut (impl Write + Seek)) -> Result<()> {
    let [nx, ny, _] = volume.sizes()?;
    let (width, height) = (u32::try_from(nx)?, u32::try_from(ny)?);
    let values: Vec<f64> = volume.values.iter().copied().collect();
    let mut encoder = TiffEncoder::new(out)?;
    for page in values.chunks_exact(nx * ny) {
        encoder.write_image::<Gray64Float>(width, height, page)?;
    }
    Ok(())
}

/// Number of pages, as far as the file can be followed.
pub fn pages(bytes: &[u8]) -> usize {
    let Ok(mut decoder) = Decoder::new(Cursor::new(bytes)) else { return 0 };
    let mut count = 1;
    while decoder.more_images() && decoder.next_image().is_ok() {
        count += 1;
    }
    count
}

/// Reads grey pages of one size as a volume `[pages, ny, nx]`: whole numbers become grey levels
/// in [0, 1] (0 black), floating point numbers keep their values; at most `limit` bytes of f64.
///
/// # Errors
/// If a page is coloured or of another size, the stack is too large, truncated or corrupt.
pub fn read(bytes: &[u8], limit: u64) -> Result<Volume> {
    let damaged = "a truncated, corrupt or unsupported TIFF";
    let count = pages(bytes);
    let mut limits = Limits::default();
    let most = usize::try_from(limit).unwrap_or(usize::MAX);
    (limits.decoding_buffer_size, limits.intermediate_buffer_size) = (most, most);
    let mut decoder = Decoder::new(Cursor::new(bytes)).context(damaged)?.with_limits(limits);
    let (width, height) = decoder.dimensions().context(damaged)?;
    let sizes = [width as usize, height as usize, count];
    let total = volume::count(&sizes, limit)?;
    let mut values = Vec::new();
    for page in 0..count {
        if page > 0 {
            decoder.next_image().context(damaged)?;
        }
        let size = decoder.dimensions().context(damaged)?;
        ensure!(
            size == (width, height),
            "page {} has {} x {} pixels, the first {width} x {height}",
            page + 1,
            size.0,
            size.1
        );
        let color = decoder.colortype().context(damaged)?;
        ensure!(
            matches!(color, ColorType::Gray(8 | 16 | 32 | 64)),
            "pixels of type {color:?}; wanted is grey"
        );
        let before = values.len();
        match decoder.read_image().context(damaged)? {
            DecodingResult::U8(v) => values.extend(v.iter().map(|&v| f64::from(v) / 255.0)),
            DecodingResult::U16(v) => values.extend(v.iter().map(|&v| f64::from(v) / 65535.0)),
            DecodingResult::U32(v) => {
                values.extend(v.iter().map(|&v| f64::from(v) / f64::from(u32::MAX)));
            }
            DecodingResult::F32(v) => values.extend(v.iter().map(|&v| f64::from(v))),
            DecodingResult::F64(v) => values.extend(v),
            _ => anyhow::bail!("pixels of this type are not supported"),
        }
        ensure!(values.len() - before == sizes[0] * sizes[1], "page {} is incomplete", page + 1);
    }
    ensure!(values.len() == total, "the stack is incomplete");
    let shape = [count, sizes[1], sizes[0]];
    Ok(Volume::new(ArrayD::from_shape_vec(&shape[..], values)?))
}
