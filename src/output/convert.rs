//! Fields, meshes and outlines from one file format to another.

use super::{csv, dxf, glb, mesh, mrc, nifti, npy, nrrd, save, svg, tiff, volume::Volume, vti};
use crate::input;
use anyhow::{Context as _, Result, bail, ensure};
use ndarray::ArrayD;
use std::{io::Write, path::Path};

/// Endings of the files that hold fields, meshes and outlines.
const FIELDS: [&str; 11] =
    ["npy", "npz", "csv", "vti", "nrrd", "nii", "nii.gz", "mrc", "tif", "tiff", "png"];
const MESHES: [&str; 4] = ["ply", "stl", "obj", "glb"];
const OUTLINES: [&str; 2] = ["dxf", "svg"];

/// Converts a field, mesh or outline between files, by the ending of `output`; a field also
/// becomes a mesh, of its surface at 0 (or half way between its least and greatest value) with
/// the inside below. Returns a sentence on what was written.
///
/// Fields: `.npy`, `.npz`, `.csv`, `.vti`, `.nrrd`, `.nii`, `.nii.gz`, `.mrc`, `.tif` or
/// `.png`; the input may be any of those and the other images that [`input::load_field`] reads.
/// Spacing and origin are kept where both formats have them. A PNG is grey, 0 black. Values in
/// [0, 1] keep their meaning (8 bits where all are multiples of 1/255, else 16 bits); other
/// values are scaled so that the least is black and the greatest white.
///
/// Meshes: `.ply`, `.stl`, `.obj`, `.glb`. Outlines: a `.csv` of lines becomes `.dxf` or
/// `.svg`.
///
/// # Errors
/// If the input cannot be read, the ending is unknown or of another kind than the input, a
/// field of three axes is to become a PNG or CSV, or NaN a PNG; `output` is not touched then.
pub fn convert(input: &Path, output: &Path) -> Result<String> {
    let ending = ending(output);
    let known = |endings: &[&str]| endings.contains(&ending.as_str());
    if !known(&FIELDS) && !known(&MESHES) && !known(&OUTLINES) {
        bail!(
            "cannot write `{}`: unknown extension; wanted is .{}",
            output.display(),
            [&FIELDS[..], &MESHES, &OUTLINES].concat().join(", .")
        );
    }
    if known(&OUTLINES) {
        return convert_lines(input, output, &ending);
    }
    if let Some(mesh) = input::load_mesh(input)? {
        ensure!(
            known(&MESHES),
            "`{}` is a mesh, which `{}` cannot hold",
            input.display(),
            output.display()
        );
        return write_mesh(&mesh, output, &ending);
    }
    if known(&MESHES) {
        let surface = input::load_surface(input, None, false, solvers::isosurface::Caps::Closed)?;
        return write_mesh(&surface.mesh, output, &ending);
    }
    let volume = input::load_volume(input, input::LIMIT)?;
    let mut note = String::new();
    save(output, |out| {
        match ending.as_str() {
            "npy" => npy::write(&volume.values.view(), out)?,
            "npz" => npy::write_npz(&[("values", volume.values.view())], out)?,
            "csv" => csv::write_grid(&volume.values.view(), out)?,
            "vti" => vti::write_volume(&volume, out)?,
            "nrrd" => nrrd::write(&volume, out)?,
            "nii" => nifti::write(&volume, out)?,
            "nii.gz" => nifti::write_gz(&volume, out)?,
            "mrc" => mrc::write(&volume, out)?,
            "tif" | "tiff" => tiff::write(&volume, out)?,
            _ => note = write_grey(&volume.values, out)?,
        }
        Ok(())
    })?;
    Ok(format!("{}: {} values{note}", output.display(), shape(&volume)))
}

fn shape(volume: &Volume) -> String {
    let shape: Vec<String> = volume.values.shape().iter().map(usize::to_string).collect();
    shape.join(" x ")
}

/// What follows the last point of a file name, in lower case; `nii.gz` is one ending.
fn ending(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    if name.ends_with(".nii.gz") {
        return "nii.gz".into();
    }
    name.rsplit_once('.').map_or_else(String::new, |(_, ending)| ending.into())
}

fn write_mesh(mesh: &solvers::mesh::TriangleMesh, output: &Path, ending: &str) -> Result<String> {
    save(output, |out| match ending {
        "ply" => mesh::write_ply(mesh, out),
        "stl" => mesh::write_stl(mesh, out),
        "obj" => mesh::write_obj(mesh, out),
        _ => glb::write(mesh, &[], out),
    })?;
    let count = mesh.triangles.len();
    Ok(format!("{}: {count} triangles", output.display()))
}

/// Lines end at the picture's upper left corner and their own lower right one.
fn convert_lines(input: &Path, output: &Path, ending: &str) -> Result<String> {
    let (lines, _) = input::load_lines(input)?;
    let most = |axis: usize| {
        let all = lines.iter().flat_map(|l| &l.points).map(|p| p[axis]);
        all.fold(0.0, f64::max)
    };
    let size = [most(0), most(1)];
    save(output, |out| match ending {
        "dxf" => dxf::write(&lines, size[1], dxf::Unit::default(), out),
        _ => svg::write_svg(&lines, size, svg::Style::default(), out),
    })?;
    Ok(format!("{}: {} lines", output.display(), lines.len()))
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
