//! From what a run shows to the files of its output folder.

use crate::output::{csv, dxf, glb, mesh, npy, picture, plot, surface, svg, vti};
use anyhow::{Context as _, Result};
use patterns::{Artifact, Colors, Image, Plot, Surface};
use rayon::prelude::*;

/// A file in memory: its name and its bytes.
pub type NamedBytes = (String, Vec<u8>);

/// The files of all artifacts, in their order; artifacts are encoded in parallel.
///
/// # Errors
/// If an artifact cannot be drawn.
pub fn encode_all(artifacts: &[Artifact]) -> Result<Vec<NamedBytes>> {
    let files: Result<Vec<Vec<NamedBytes>>> = artifacts.par_iter().map(encode).collect();
    Ok(files?.into_iter().flatten().collect())
}

fn encode(artifact: &Artifact) -> Result<Vec<NamedBytes>> {
    match artifact {
        Artifact::Image(image) => encode_image(image),
        Artifact::Drawing { image, strokes } => {
            let write = |out: &mut Vec<u8>| picture::write_drawing(image, strokes, out);
            Ok(vec![bytes(&image.name, "png", write)?])
        }
        Artifact::Contour { name, lines, size } => {
            let style = svg::Style::default();
            let mut files = vec![
                bytes(name, "svg", |out| svg::write_svg(lines, *size, style, out))?,
                bytes(name, "csv", |out| csv::write_lines(lines, out))?,
            ];
            if name == "outline" {
                let unit = dxf::Unit::default();
                files.push(bytes(name, "dxf", |out| dxf::write(lines, size[1], unit, out))?);
            }
            Ok(files)
        }
        Artifact::Mesh { name, mesh } => {
            let (name, mesh) = (name.clone(), mesh.clone());
            encode_surface(&Surface { name, mesh, ..Surface::default() })
        }
        Artifact::Surface(surface) => encode_surface(surface),
        Artifact::Plot(plot) => encode_plot(plot),
        Artifact::Table { name, columns } => {
            Ok(vec![bytes(name, "csv", |out| csv::write_table(columns, out))?])
        }
        _ => Ok(Vec::new()),
    }
}

/// A picture; the numbers too, unless it is only ink on paper.
fn encode_image(image: &Image) -> Result<Vec<NamedBytes>> {
    let (name, style) = (&image.name, picture::Style::default());
    let mut files = vec![bytes(name, "png", |out| picture::write_png(image, &style, out))?];
    if image.colors != Colors::Ink {
        let field = &image.field;
        let values = field.view().into_dyn();
        let values = values.into_shape_with_order(field.grid().axes().to_vec())?;
        files.push(bytes(name, "npy", |out| npy::write(&values, out))?);
        files.push(bytes(name, "vti", |out| vti::write(&[(name, field)], out))?);
    }
    Ok(files)
}

/// A surface as picture, for other programs, and as a film if one is wanted.
fn encode_surface(surface: &Surface) -> Result<Vec<NamedBytes>> {
    let (name, mesh) = (&surface.name, &surface.mesh);
    let look = surface::Look::default();
    let mut files = vec![
        bytes(name, "png", |out| surface::draw(surface, &look)?.write_png(out))?,
        bytes(name, "ply", |out| mesh::write_ply(mesh, out))?,
        bytes(name, "stl", |out| mesh::write_stl(mesh, out))?,
        bytes(name, "obj", |out| mesh::write_obj(mesh, out))?,
        bytes(name, "glb", |out| glb::write(mesh, &surface::colors(surface), out))?,
    ];
    if surface.turntable > 0 {
        files.push(bytes(name, "gif", |out| surface::write_turntable(surface, &look, out))?);
    }
    Ok(files)
}

/// A plot as picture and drawing, and its points, one row each.
fn encode_plot(plot: &Plot) -> Result<Vec<NamedBytes>> {
    let points = plot.series.iter().enumerate();
    let rows: Vec<(f64, [f64; 2])> =
        points.flat_map(|(n, s)| s.points.iter().map(move |&p| (n as f64, p))).collect();
    let columns = vec![
        ("series".to_owned(), rows.iter().map(|r| r.0).collect()),
        (plot.x.label.clone(), rows.iter().map(|r| r.1[0]).collect()),
        (plot.y.label.clone(), rows.iter().map(|r| r.1[1]).collect()),
    ];
    let name = &plot.name;
    Ok(vec![
        bytes(name, "png", |out| plot::write_png(plot, out))?,
        bytes(name, "svg", |out| plot::write_svg(plot, out))?,
        bytes(name, "csv", |out| csv::write_table(&columns, out))?,
    ])
}

fn bytes(
    name: &str,
    extension: &str,
    write: impl FnOnce(&mut Vec<u8>) -> Result<()>,
) -> Result<NamedBytes> {
    let (file, mut bytes) = (format!("{name}.{extension}"), Vec::new());
    write(&mut bytes).with_context(|| format!("cannot draw `{file}`"))?;
    Ok((file, bytes))
}
