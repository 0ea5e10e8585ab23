//! MRC volumes, as electron microscopy programs read and write them.
//!
//! Source: Cheng et al. 2015, "MRC2014: extensions to the MRC format header", J. Struct. Biol.
//! 192:146; words of the 1024-byte header are counted from 1 there, bytes from 0 here.

use super::volume::{self, Element, Volume};
use anyhow::{Context as _, Result, bail, ensure};
use std::io::Write;

const HEADER: usize = 1024;
/// Where `MAP ` stands.
const MARK: usize = 208;

/// Whether these bytes begin an MRC file.
pub fn is_mrc(bytes: &[u8]) -> bool {
    bytes.len() >= HEADER && &bytes[MARK..MARK + 3] == b"MAP"
}

/// Writes a volume as `float`, little endian.
///
/// # Errors
/// If it has more than three axes or `out` fails.
pub fn write(volume: &Volume, out: &mut impl Write) -> Result<()> {
    let sizes = volume.sizes()?;
    let mut head = [0; HEADER];
    let mut put = |at: usize, bytes: [u8; 4]| head[at..at + 4].copy_from_slice(&bytes);
    let values = volume.values.iter().map(|&v| v as f32);
    let count = volume.values.len().max(1) as f64;
    let mean = volume.values.iter().sum::<f64>() / count;
    let variance = volume.values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count;
    for (axis, size) in sizes.into_iter().enumerate() {
        let size = i32::try_from(size)?;
        put(4 * axis, size.to_le_bytes());
        put(28 + 4 * axis, size.to_le_bytes());
        put(40 + 4 * axis, (volume.spacing[axis] as f32 * size as f32).to_le_bytes());
        put(52 + 4 * axis, 90_f32.to_le_bytes());
        // Columns, rows and sections are x, y and z.
        put(64 + 4 * axis, (axis as i32 + 1).to_le_bytes());
        put(196 + 4 * axis, (volume.origin[axis] as f32).to_le_bytes());
    }
    put(12, 2_i32.to_le_bytes());
    put(76, values.clone().fold(f32::INFINITY, f32::min).to_le_bytes());
    put(80, values.clone().fold(f32::NEG_INFINITY, f32::max).to_le_bytes());
    put(84, (mean as f32).to_le_bytes());
    put(88, 1_i32.to_le_bytes());
    put(108, 20141_i32.to_le_bytes());
    put(MARK, *b"MAP ");
    put(212, [0x44, 0x44, 0, 0]);
    put(216, (variance.sqrt() as f32).to_le_bytes());
    out.write_all(&head)?;
    for v in values {
        out.write_all(&v.to_le_bytes())?;
    }
    Ok(())
}

/// Reads a volume of real numbers with x, y, z in this order; at most `limit` bytes of f64.
///
/// # Errors
/// If it is another file, complex, has another order of axes, is too large or truncated.
pub fn read(bytes: &[u8], limit: u64) -> Result<Volume> {
    ensure!(is_mrc(bytes), "no MRC (truncated?)");
    let word = |at: usize| [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
    // The machine stamp; some programs leave it empty.
    let little = match bytes[212] {
        0x11 => false,
        0x44 => true,
        _ => (0..=101).contains(&i32::from_le_bytes(word(12))),
    };
    let int = |at: usize| match little {
        true => i32::from_le_bytes(word(at)),
        false => i32::from_be_bytes(word(at)),
    };
    let float = |at: usize| f64::from(f32::from_bits(int(at).cast_unsigned()));
    let order = [64, 68, 72].map(int);
    ensure!(
        order == [1, 2, 3] || order == [0; 3],
        "columns, rows and sections are the axes {order:?}; wanted is [1, 2, 3]"
    );
    let sizes = [0, 4, 8].map(int);
    ensure!(sizes.iter().all(|&n| n >= 1), "axes of {sizes:?} nodes");
    let sizes = sizes.map(|n| n as usize);
    let count = volume::count(&sizes, limit)?;
    let kind = match int(12) {
        0 => Element::I8,
        1 => Element::I16,
        2 => Element::F32,
        6 => Element::U16,
        other => bail!("mode {other}; wanted is 0, 1, 2 or 6"),
    };
    let extended = usize::try_from(int(92)).context("the length of the extended header")?;
    let data = bytes.get(HEADER + extended..).context("truncated before the data")?;
    let values = kind.decode(volume::head(data, count * kind.bytes())?, little);
    let spacing = [0, 1, 2].map(|axis| {
        let (length, cells) = (float(40 + 4 * axis), int(28 + 4 * axis));
        if length > 0.0 && cells > 0 { length / f64::from(cells) } else { 1.0 }
    });
    Volume::from_values(&sizes, values, spacing, [196, 200, 204].map(float))
}
