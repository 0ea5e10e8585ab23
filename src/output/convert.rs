//! Fields from one file format to another.

use super::{csv, npy, save, vti};
use crate::input;
use anyhow::{Context as _, Result, bail};
use ndarray::ArrayD;
use solvers::Field;
use std::{io::Write, path::Path};

/// Converts a field between files, by the extension of `output`: `.npy`, `.npz`, `.csv`,
/// `.vti` or `.png`; the input may be any of those and the other images that
/// [`input::load_field`] reads. Returns a sentence on what was written.
///
/// A PNG is grey, 0 black. Values in [0, 1] keep their meaning (8 bits where all are
/// multiples of 1/255, else 16 bits); other values are scaled so that the least is black
/// and the greatest white.
///
/// # Errors
/// If the input cannot be read, the extension is unknown, a field of three axes is to
/// become a PNG or CSV, or NaN a PNG; `output` is not touched then.
pub fn convert(input: &Path, output: &Path) -> Result<String> {
    let extension = output.extension().and_then(|e| e.to_str()).unwrap_or("").to_lowercase();
    if !["npy", "npz", "csv", "vti", "png"].contains(&extension.as_str()) {
        bail!(
            "cannot write `{}`: unknown extension; wanted is .npy, .npz, .csv, .vti or .png",
            output.display()
        );
    }
    let values = input::load_array(input, input::LIMIT)?;
    let mut note = String::new();
    save(output, |out| {
        match extension.as_str() {
            "npy" => npy::write(&values.view(), out)?,
            "npz" => npy::write_npz(&[("values", values.view())], out)?,
            "csv" => csv::write_grid(&values.view(), out)?,
            "vti" => vti::write(&[("values", &Field::from_array(values.clone(), 1.0)?)], out)?,
            _ => note = write_grey(&values, out)?,
        }
        Ok(())
    })?;
    let shape: Vec<String> = values.shape().iter().map(usize::to_string).collect();
    Ok(format!("{}: {} values{note}", output.display(), shape.join(" x ")))
}

/// Writes a grey PNG and tells how values became grey levels; see [`convert`].
fn write_grey(values: &ArrayD<f64>, out: &mut impl Write) -> Result<String> {
    let (ny, nx) = match *values.shape() {
        [nx] => (1, nx),
        [ny, nx] => (ny, nx),
        _ => bail!("shape {:?} is no picture; wanted are 1 or 2 axes", values.shape()),
    };
    input::check_finite(values)?;
    let (low, high) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &v| (a.min(v), b.max(v)));
    let grey = low >= 0.0 && high <= 1.0;
    let bytes = grey && values.iter().all(|v| (v * 255.0).round() / 255.0 == *v);
    let (origin, width) = match (grey, high > low) {
        (true, _) => (0.0, 1.0),
        (_, true) => (low, high - low),
        _ => (low, 1.0),
    };
    let level = |v: &f64, top: f64| ((v - origin) / width * top).round();
    let size = |n: usize| u32::try_from(n).context("the picture is too wide for a PNG");
    let mut encoder = png::Encoder::new(out, size(nx)?, size(ny)?);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(if bytes { png::BitDepth::Eight } else { png::BitDepth::Sixteen });
    let data: Vec<u8> = match bytes {
        true => values.iter().map(|v| level(v, 255.0) as u8).collect(),
        false => values.iter().flat_map(|v| (level(v, 65535.0) as u16).to_be_bytes()).collect(),
    };
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&data)?;
    writer.finish()?;
    let depth = if bytes { 8 } else { 16 };
    Ok(match grey {
        true => format!(", [0, 1] as {depth}-bit grey"),
        false => format!(", {low} (black) to {high} (white) as {depth}-bit grey"),
    })
}
