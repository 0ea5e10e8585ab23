//! Files as fields: images and arrays, recognised by their content.

use crate::output::{csv, npy, vti};
use anyhow::{Context as _, Result, bail, ensure};
use image::{DynamicImage, ImageDecoder as _, ImageFormat, ImageReader};
use ndarray::{ArrayD, Dimension as _, IxDyn};
use solvers::isosurface::Polyline;
use std::{fs, io::Cursor, path::Path};

/// Greatest size of an input as f64 values, bytes: 2 GiB, an image of 16384 x 16384.
pub const LIMIT: u64 = 1 << 31;

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Image(ImageFormat),
    Npy,
    Npz,
    Vti,
    Csv,
}

/// Reads an image or array as values, all finite, shape `[ny, nx]` for images (row 0 at the top).
///
/// Images (PNG, JPEG, BMP, PNM, TIFF; any depth) become grey levels in [0, 1]: 0 is black.
/// Colours become 0.2126 R + 0.7152 G + 0.0722 B (the Rec. 709 weights) of the numbers as
/// stored, without undoing their gamma, so that grey files keep their numbers; transparency
/// shows white paper. TIFFs of floating point numbers keep them. Arrays (NPY, NPZ with one
/// array, VTI with one array, CSV) are taken as they are.
///
/// # Errors
/// With the file's name, what was found and what is wanted: no such file, a folder, an
/// unknown, truncated or corrupt content, more than [`LIMIT`], no values, NaN.
pub fn load_field(path: &Path) -> Result<ArrayD<f64>> {
    load_within(path, LIMIT)
}

/// [`load_field`] of at most `limit` bytes of f64.
///
/// # Errors
/// As [`load_field`].
pub fn load_within(path: &Path, limit: u64) -> Result<ArrayD<f64>> {
    let values = load_array(path, limit)?;
    check_finite(&values).with_context(|| format!("`{}`", path.display()))?;
    Ok(values)
}

/// As [`load_within`], with NaN and infinities allowed.
///
/// # Errors
/// As [`load_field`].
pub fn load_array(path: &Path, limit: u64) -> Result<ArrayD<f64>> {
    let read = || {
        let about = fs::metadata(path)?;
        ensure!(!about.is_dir(), "a folder; wanted is an image or an array");
        // Text needs more bytes a number than f64.
        let most = limit.saturating_mul(4);
        ensure!(about.len() <= most, "{} bytes, more than the limit of {most}", about.len());
        decode(&fs::read(path)?, path, limit)
    };
    read().with_context(|| format!("cannot read `{}`", path.display()))
}

/// Reads closed lines from a CSV (see [`csv::read_lines`]), and the file's bytes.
///
/// # Errors
/// With the file's name and the line: no such file, a folder, no text, more than
/// [`LIMIT`] bytes, or as [`csv::read_lines`].
pub fn load_lines(path: &Path) -> Result<(Vec<Polyline>, Vec<u8>)> {
    let read = || -> Result<_> {
        let about = fs::metadata(path)?;
        ensure!(!about.is_dir(), "a folder; wanted is a CSV of points");
        ensure!(about.len() <= LIMIT, "{} bytes, more than the limit of {LIMIT}", about.len());
        let bytes = fs::read(path)?;
        let text = std::str::from_utf8(&bytes).context("no text; wanted is a CSV of points")?;
        Ok((csv::read_lines(text)?, bytes))
    };
    read().with_context(|| format!("cannot read `{}`", path.display()))
}

/// Refuses another shape than `wanted`.
///
/// # Errors
/// With both shapes.
pub fn check_shape(values: &ArrayD<f64>, wanted: &[usize]) -> Result<()> {
    ensure!(
        values.shape() == wanted,
        "shape {:?}; wanted is {wanted:?} (rows first)",
        values.shape()
    );
    Ok(())
}

/// Refuses NaN and infinities.
///
/// # Errors
/// With the first bad index.
pub fn check_finite(values: &ArrayD<f64>) -> Result<()> {
    match values.indexed_iter().find(|(_, v)| !v.is_finite()) {
        None => Ok(()),
        Some((at, v)) => bail!("{v} at index {:?}; every value must be finite", at.slice()),
    }
}

/// Values of a file's content; `path` serves messages only.
fn decode(bytes: &[u8], path: &Path, limit: u64) -> Result<ArrayD<f64>> {
    ensure!(!bytes.is_empty(), "the file is empty");
    let values = match sniff(bytes, path)? {
        Format::Image(format) => decode_image(bytes, format, limit)?,
        Format::Npy => npy::read(bytes, limit)?,
        Format::Npz => npy::read_npz(bytes, None, limit)?,
        Format::Vti => only_array(vti::read(bytes, limit)?)?,
        Format::Csv => csv::read_grid(std::str::from_utf8(bytes)?)?.into_dyn(),
    };
    ensure!(!values.is_empty(), "shape {:?} holds no value", values.shape());
    Ok(values)
}

fn only_array(mut arrays: Vec<vti::Array>) -> Result<ArrayD<f64>> {
    if arrays.len() > 1 {
        let names: Vec<&str> = arrays.iter().map(|a| a.name.as_str()).collect();
        bail!("{} arrays ({}), one is wanted", arrays.len(), names.join(", "));
    }
    arrays.pop().map(|a| a.values).context("no array")
}

/// The format that the first bytes tell, whatever the file is called.
fn sniff(bytes: &[u8], path: &Path) -> Result<Format> {
    let starts = |magic: &[u8]| bytes.starts_with(magic);
    let second = bytes.get(2).copied().unwrap_or(b' ');
    let found = if starts(npy::MAGIC) {
        Format::Npy
    } else if starts(b"PK\x03\x04") || starts(b"PK\x05\x06") {
        Format::Npz
    } else if starts(b"\x89PNG\r\n\x1a\n") {
        Format::Image(ImageFormat::Png)
    } else if starts(b"\xff\xd8\xff") {
        Format::Image(ImageFormat::Jpeg)
    } else if starts(b"BM") {
        Format::Image(ImageFormat::Bmp)
    } else if starts(b"II*\0") || starts(b"MM\0*") {
        Format::Image(ImageFormat::Tiff)
    } else if bytes[0] == b'P'
        && matches!(bytes.get(1), Some(b'1'..=b'7'))
        && second.is_ascii_whitespace()
    {
        Format::Image(ImageFormat::Pnm)
    } else if starts(b"<?xml") || starts(b"<VTKFile") {
        Format::Vti
    } else {
        Format::Csv
    };
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase();
    let text = || std::str::from_utf8(bytes).is_ok_and(|t| !t.contains('\0'));
    if found == Format::Csv && (!text() || known(&extension)) {
        let head: String = bytes[..bytes.len().min(8)].escape_ascii().to_string();
        let claim = if known(&extension) {
            format!("no {} file", extension.to_uppercase())
        } else {
            "unknown content".into()
        };
        bail!(
            "{claim}: it begins with `{head}`; wanted is PNG, JPEG, BMP, PNM, TIFF, NPY, NPZ, VTI or CSV"
        );
    }
    Ok(found)
}

/// Whether a name of this extension promises something else than text.
fn known(extension: &str) -> bool {
    const KNOWN: [&str; 13] = [
        "png", "jpg", "jpeg", "bmp", "pnm", "pbm", "pgm", "ppm", "tif", "tiff", "npy", "npz", "vti",
    ];
    KNOWN.contains(&extension)
}

fn decode_image(bytes: &[u8], format: ImageFormat, limit: u64) -> Result<ArrayD<f64>> {
    let mut limits = image::Limits::default();
    // 16 bits of four channels take as much as a f64; as much again for scratch.
    limits.max_alloc = Some(limit.saturating_mul(2));
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.limits(limits);
    let name = format!("{format:?}").to_uppercase();
    let damaged = || format!("a truncated, corrupt or unsupported {name}");
    let decoder = reader.into_decoder().with_context(damaged)?;
    let (nx, ny) = decoder.dimensions();
    let needed = (u64::from(nx) * u64::from(ny)).saturating_mul(8);
    ensure!(
        needed <= limit,
        "an image of {nx} x {ny} pixels needs {needed} bytes, more than the limit of {limit}"
    );
    let image = DynamicImage::from_decoder(decoder).with_context(damaged)?;
    let values = match &image {
        DynamicImage::ImageLuma8(p) => grey(p.as_raw(), 1),
        DynamicImage::ImageLumaA8(p) => grey(p.as_raw(), 2),
        DynamicImage::ImageRgb8(p) => grey(p.as_raw(), 3),
        DynamicImage::ImageRgba8(p) => grey(p.as_raw(), 4),
        DynamicImage::ImageLuma16(p) => grey(p.as_raw(), 1),
        DynamicImage::ImageLumaA16(p) => grey(p.as_raw(), 2),
        DynamicImage::ImageRgb16(p) => grey(p.as_raw(), 3),
        DynamicImage::ImageRgba16(p) => grey(p.as_raw(), 4),
        DynamicImage::ImageRgb32F(p) => grey(p.as_raw(), 3),
        DynamicImage::ImageRgba32F(p) => grey(p.as_raw(), 4),
        other => bail!("pixels of type {:?} are not supported", other.color()),
    };
    Ok(ArrayD::from_shape_vec(IxDyn(&[ny as usize, nx as usize]), values)?)
}

/// A channel's number in [0, 1] (floating point: as it is).
trait Channel: Copy {
    fn unit(self) -> f64;
}

impl Channel for u8 {
    fn unit(self) -> f64 {
        f64::from(self) / 255.0
    }
}

impl Channel for u16 {
    fn unit(self) -> f64 {
        f64::from(self) / 65535.0
    }
}

impl Channel for f32 {
    fn unit(self) -> f64 {
        f64::from(self)
    }
}

/// Grey levels of pixels of 1 (grey), 2 (with alpha), 3 (RGB) or 4 channels.
fn grey<C: Channel>(pixels: &[C], channels: usize) -> Vec<f64> {
    let level = |p: &[C]| {
        let [r, g, b] = [p[0], p[p.len() / 3], p[2 * (p.len() / 3)]].map(Channel::unit);
        // Equal channels keep their number to the last bit.
        let v = if p.len() < 3 || (r == g && g == b) {
            r
        } else {
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        if p.len().is_multiple_of(2) {
            let alpha = p[p.len() - 1].unit();
            v * alpha + (1.0 - alpha)
        } else {
            v
        }
    };
    pixels.chunks_exact(channels).map(level).collect()
}
