//! NIfTI-1 volumes (`.nii`, `.nii.gz`), as medical imaging programs read and write them.
//!
//! Source: `nifti1.h` (R. Cox et al., 2003, public domain); offsets of the header's 348 bytes
//! are those of that file.

use super::volume::{self, Element, Volume};
use anyhow::{Context as _, Result, bail, ensure};
use flate2::{Compression, write::GzEncoder};
use std::io::Write;

/// Size of the header, and where our data begin.
const HEADER: usize = 348;
const DATA: usize = 352;
/// The offset of the mark that tells a file of one part.
const MARK: usize = 344;

/// Whether these bytes begin a NIfTI-1 file, of either byte order.
pub fn is_nifti(bytes: &[u8]) -> bool {
    bytes.get(MARK..MARK + 4).is_some_and(|m| m == b"n+1\0" || m == b"ni1\0")
}

/// Writes a volume as `float64`, little endian, with its spacing and origin as scanner
/// coordinates; lengths have no unit.
///
/// # Errors
/// If it has more than three axes or one longer than 32767, or `out` fails.
pub fn write(volume: &Volume, out: &mut impl Write) -> Result<()> {
    let sizes = volume.sizes()?;
    let mut head = [0; DATA];
    let mut put = |at: usize, bytes: &[u8]| head[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &(HEADER as i32).to_le_bytes());
    let axes = [3, sizes[0], sizes[1], sizes[2], 1, 1, 1, 1];
    for (n, size) in axes.into_iter().enumerate() {
        let size = i16::try_from(size)
            .map_err(|_| anyhow::anyhow!("{size} nodes on an axis; NIfTI-1 has at most 32767"))?;
        put(40 + 2 * n, &size.to_le_bytes());
    }
    put(70, &64_i16.to_le_bytes());
    put(72, &64_i16.to_le_bytes());
    let steps = [1.0, volume.spacing[0], volume.spacing[1], volume.spacing[2]];
    steps.iter().enumerate().for_each(|(n, &v)| put(76 + 4 * n, &(v as f32).to_le_bytes()));
    put(108, &(DATA as f32).to_le_bytes());
    put(112, &1_f32.to_le_bytes());
    // Scanner coordinates by rows (sform).
    put(254, &1_i16.to_le_bytes());
    for axis in 0..3 {
        put(268 + 4 * axis, &(volume.origin[axis] as f32).to_le_bytes());
        put(280 + 16 * axis + 4 * axis, &(volume.spacing[axis] as f32).to_le_bytes());
        put(280 + 16 * axis + 12, &(volume.origin[axis] as f32).to_le_bytes());
    }
    put(MARK, b"n+1\0");
    out.write_all(&head)?;
    for v in &volume.values {
        out.write_all(&v.to_le_bytes())?;
    }
    Ok(())
}

/// As [`write()`], compressed with gzip.
///
/// # Errors
/// As [`write()`].
pub fn write_gz(volume: &Volume, out: &mut impl Write) -> Result<()> {
    let mut encoder = GzEncoder::new(out, Compression::fast());
    write(volume, &mut encoder)?;
    encoder.finish()?;
    Ok(())
}

/// Reads one to three axes of real numbers in the file itself, scaled as the header tells; at
/// most `limit` bytes of f64. Axes that are turned keep their spacing.
///
/// # Errors
/// If it is another file, has more axes, complex or coloured elements, is too large or
/// truncated.
pub fn read(bytes: &[u8], limit: u64) -> Result<Volume> {
    ensure!(bytes.len() >= HEADER && is_nifti(bytes), "no NIfTI-1 (truncated?)");
    ensure!(&bytes[MARK..MARK + 4] == b"n+1\0", "the data are in another file; wanted is one file");
    let little = i32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) == HEADER as i32;
    let short = |at: usize| Element::I16.decode(&bytes[at..at + 2], little)[0] as i64;
    let float = |at: usize| Element::F32.decode(&bytes[at..at + 4], little)[0];
    let axes = short(40);
    ensure!((1..=7).contains(&axes), "{axes} axes; wanted are 1 to 3");
    let sizes: Vec<i64> = (1..=axes as usize).map(|n| short(40 + 2 * n)).collect();
    ensure!(sizes.iter().all(|&n| n >= 1), "axes of {sizes:?} nodes");
    ensure!(sizes.iter().skip(3).all(|&n| n == 1), "axes of {sizes:?} nodes; wanted are 1 to 3");
    let sizes: Vec<usize> = sizes.iter().map(|&n| n as usize).collect();
    let count = volume::count(&sizes, limit)?;
    let kind = match short(70) {
        2 => Element::U8,
        4 => Element::I16,
        8 => Element::I32,
        16 => Element::F32,
        64 => Element::F64,
        256 => Element::I8,
        512 => Element::U16,
        768 => Element::U32,
        1024 => Element::I64,
        1280 => Element::U64,
        other => bail!("elements of code {other}; wanted are real numbers"),
    };
    let start = float(108);
    ensure!(start >= HEADER as f64 && start < 1e9, "the data begin at byte {start}");
    let data = bytes.get(start as usize..).context("truncated before the data")?;
    let mut values = kind.decode(volume::head(data, count * kind.bytes())?, little);
    let (slope, offset) = (float(112), float(116));
    if slope != 0.0 && slope.is_finite() && offset.is_finite() && (slope, offset) != (1.0, 0.0) {
        values.iter_mut().for_each(|v| *v = *v * slope + offset);
    }
    // 0 where nobody set a spacing.
    let spacing = [80, 84, 88].map(|at| match float(at).abs() {
        0.0 => 1.0,
        v => v,
    });
    let origin = match (short(254) > 0, short(252) > 0) {
        (true, _) => [292, 308, 324].map(float),
        (_, true) => [268, 272, 276].map(float),
        _ => [0.0; 3],
    };
    Volume::from_values(&sizes, values, spacing, origin)
}
