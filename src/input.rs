//! Files as fields and meshes: images, arrays and volumes, recognised by their content.

use crate::output::{
    csv, glb, mesh, mrc, nifti, npy, nrrd, tiff,
    volume::{self, Volume},
    vti,
};
use anyhow::{Context as _, Result, bail, ensure};
use image::{DynamicImage, ImageDecoder as _, ImageFormat, ImageReader};
use ndarray::{ArrayD, Dimension as _, IxDyn};
use solvers::{
    Field,
    isosurface::{self, Caps, Polyline, Surface},
    mesh::TriangleMesh,
};
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
    Nrrd,
    Nifti,
    Mrc,
    /// A TIFF of several pages.
    Stack,
    Csv,
}

/// Reads an image or array as values, all finite, shape `[ny, nx]` for images (row 0 at the top).
///
/// Images (PNG, JPEG, BMP, PNM, TIFF; any depth) become grey levels in [0, 1]: 0 is black.
/// Colours become 0.2126 R + 0.7152 G + 0.0722 B (the Rec. 709 weights) of the numbers as
/// stored, without undoing their gamma, so that grey files keep their numbers; transparency
/// shows white paper. TIFFs of floating point numbers keep them; several grey pages are a
/// volume `[pages, ny, nx]`. Arrays (NPY, NPZ with one array, CSV) and volumes (VTI with one
/// array, NRRD, NIfTI-1 or this in gzip, MRC) are taken as they are.
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
    Ok(load_volume(path, limit)?.values)
}

/// As [`load_array`], with spacing and origin if the file has them, else 1 and 0.
///
/// # Errors
/// As [`load_field`].
pub fn load_volume(path: &Path, limit: u64) -> Result<Volume> {
    // Text needs more bytes a number than f64.
    let most = limit.saturating_mul(4);
    let read = || decode(&bytes(path, "an image or an array", most)?, path, limit);
    read().with_context(|| format!("cannot read `{}`", path.display()))
}

/// The content of a file of at most `most` bytes.
fn bytes(path: &Path, wanted: &str, most: u64) -> Result<Vec<u8>> {
    let about = fs::metadata(path)?;
    ensure!(!about.is_dir(), "a folder; wanted is {wanted}");
    ensure!(about.len() <= most, "{} bytes, more than the limit of {most}", about.len());
    Ok(fs::read(path)?)
}

/// Reads a triangle mesh: PLY, STL, OBJ or GLB, by the file name's ending; `None` if the name
/// has another.
///
/// # Errors
/// With the file's name: no such file, a folder, more than [`LIMIT`] bytes, truncated or
/// corrupt content, or a vertex that is not finite.
pub fn load_mesh(path: &Path) -> Result<Option<TriangleMesh>> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase();
    if !["ply", "stl", "obj", "glb"].contains(&extension.as_str()) {
        return Ok(None);
    }
    let read = || -> Result<TriangleMesh> {
        let bytes = bytes(path, "a mesh", LIMIT)?;
        let mesh = match extension.as_str() {
            "ply" => mesh::read_ply(&bytes)?,
            "stl" => mesh::read_stl(&bytes)?,
            "glb" => glb::read(&bytes)?,
            _ => mesh::read_obj(std::str::from_utf8(&bytes).context("no text")?)?,
        };
        let bad = mesh.vertices.iter().position(|v| !v.iter().all(|c| c.is_finite()));
        ensure!(bad.is_none(), "vertex {} is not finite", bad.unwrap_or(0) + 1);
        Ok(mesh)
    };
    Ok(Some(read().with_context(|| format!("cannot read `{}`", path.display()))?))
}

/// Reads a volume and takes its surface at `level`, placed as the file tells; `None`: at 0 if
/// the values have both signs, else half way between least and greatest. The inside lies below
/// the level, or `above` it.
///
/// # Errors
/// As [`load_field`], or if the file has not three axes.
pub fn load_surface(path: &Path, level: Option<f64>, above: bool, caps: Caps) -> Result<Surface> {
    let volume = load_volume(path, LIMIT)?;
    let read = || -> Result<Surface> {
        check_finite(&volume.values)?;
        let sign = if above { -1.0 } else { 1.0 };
        let phi = Field::from_array(volume.values.mapv(|v| sign * v), 1.0)?;
        let (low, high) = phi.range();
        let middle = if low < 0.0 && high > 0.0 { 0.0 } else { 0.5 * (low + high) };
        let level = level.map_or(middle, |level| sign * level);
        let mut surface = isosurface::surface(&phi, level, caps)?;
        for v in &mut surface.mesh.vertices {
            *v = [0, 1, 2].map(|m| volume.origin[m] + volume.spacing[m] * v[m]);
        }
        Ok(surface)
    };
    read().with_context(|| format!("`{}`", path.display()))
}

/// Reads closed lines from a CSV (see [`csv::read_lines`]), and the file's bytes.
///
/// # Errors
/// With the file's name and the line: no such file, a folder, no text, more than
/// [`LIMIT`] bytes, or as [`csv::read_lines`].
pub fn load_lines(path: &Path) -> Result<(Vec<Polyline>, Vec<u8>)> {
    let read = || -> Result<_> {
        let bytes = bytes(path, "a CSV of points", LIMIT)?;
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
fn decode(bytes: &[u8], path: &Path, limit: u64) -> Result<Volume> {
    ensure!(!bytes.is_empty(), "the file is empty");
    let unpacked;
    let bytes = match bytes {
        [0x1f, 0x8b, ..] => {
            // A header and a number of 8 bytes for each of f64.
            unpacked = volume::gunzip(bytes, limit.saturating_add(1 << 16))?;
            &unpacked
        }
        _ => bytes,
    };
    let volume = match sniff(bytes, path)? {
        Format::Image(format) => Volume::new(decode_image(bytes, format, limit)?),
        Format::Npy => Volume::new(npy::read(bytes, limit)?),
        Format::Npz => Volume::new(npy::read_npz(bytes, None, limit)?),
        Format::Vti => only_array(vti::read(bytes, limit)?)?,
        Format::Nrrd => nrrd::read(bytes, limit)?,
        Format::Nifti => nifti::read(bytes, limit)?,
        Format::Mrc => mrc::read(bytes, limit)?,
        Format::Stack => tiff::read(bytes, limit)?,
        Format::Csv => Volume::new(csv::read_grid(std::str::from_utf8(bytes)?)?.into_dyn()),
    };
    ensure!(!volume.values.is_empty(), "shape {:?} holds no value", volume.values.shape());
    Ok(volume)
}

fn only_array(mut arrays: Vec<vti::Array>) -> Result<Volume> {
    if arrays.len() > 1 {
        let names: Vec<&str> = arrays.iter().map(|a| a.name.as_str()).collect();
        bail!("{} arrays ({}), one is wanted", arrays.len(), names.join(", "));
    }
    let array = arrays.pop().context("no array")?;
    Ok(Volume { values: array.values, spacing: array.spacing, origin: array.origin })
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
        if tiff::pages(bytes) > 1 { Format::Stack } else { Format::Image(ImageFormat::Tiff) }
    } else if starts(nrrd::MAGIC) {
        Format::Nrrd
    } else if nifti::is_nifti(bytes) {
        Format::Nifti
    } else if mrc::is_mrc(bytes) {
        Format::Mrc
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
            "{claim}: it begins with `{head}`; wanted is PNG, JPEG, BMP, PNM, TIFF, NPY, NPZ, VTI, NRRD, NIfTI, MRC or CSV"
        );
    }
    Ok(found)
}

/// Whether a name of this extension promises something else than text.
fn known(extension: &str) -> bool {
    const KNOWN: [&str; 18] = [
        "png", "jpg", "jpeg", "bmp", "pnm", "pbm", "pgm", "ppm", "tif", "tiff", "npy", "npz",
        "vti", "nrrd", "nii", "gz", "mrc", "map",
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
