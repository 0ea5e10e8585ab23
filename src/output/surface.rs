//! Pictures of surfaces, with a colour bar where they show a quantity, and films around them.

use super::{
    animation, axes,
    canvas::Canvas,
    colormap::{Colormap, Rgb},
    font::{self, Hang},
    picture,
};
use crate::render::{
    BEIGE, DARK, LINE, Lighting, PAPER, Paint, Part, Picture, Stage, View, shapes,
};
use anyhow::Result;
use patterns::{Colors, Surface, SurfaceValues};
use solvers::mesh::Clustered;
use std::{io::Write, path::Path};

/// Triangles above which a coarser mesh is drawn: pictures have fewer pixels, and a ray tracer
/// holds 200 bytes for each.
const MOST: usize = 1_500_000;
/// Area of a cell of the coarser mesh, in areas of the triangles that shall be left.
const SHARE: f64 = 2.0;

/// How a surface is looked at.
#[derive(Clone, Debug)]
pub struct Look {
    /// From where.
    pub view: View,
    /// In which light.
    pub light: Lighting,
    /// Side of the picture, pixels.
    pub size: usize,
}

impl Default for Look {
    fn default() -> Self {
        Self { view: View::default(), light: Lighting::default(), size: 900 }
    }
}

/// Side of a film, as part of a picture's.
const FILM: f64 = 0.5;
/// Size of tick labels and of the label, pixels.
const TEXT: [f64; 2] = [18.0, 19.0];
/// Thickness of the lines of a frame, as part of the box's diagonal.
const THIN: f64 = 0.0022;

/// A colour for each vertex of a surface that shows a quantity; else none.
pub fn colors(surface: &Surface) -> Vec<Rgb> {
    surface.values.as_ref().map_or_else(Vec::new, |values| {
        let (map, [low, high]) = scale(values);
        values.values.iter().map(|v| map.color((v - low) / (high - low))).collect()
    })
}

fn scale(values: &SurfaceValues) -> (Colormap, [f64; 2]) {
    let given = values.range.filter(|&r| axes::is_range(r, false));
    let range = given.unwrap_or_else(|| {
        let [low, high] = axes::data_range(values.values.iter().copied(), false);
        let end = low.abs().max(high.abs());
        if values.colors == Colors::Diverging { [-end, end] } else { [low, high] }
    });
    (Colormap::of(values.colors), range)
}

/// The colours of some of a surface's vertices, or of some of its triangles.
fn paint(
    surface: &Surface,
    vertices: impl Iterator<Item = u32>,
    triangles: impl Iterator<Item = u32>,
) -> Paint {
    let colors = colors(surface);
    if colors.len() == surface.mesh.vertices.len() && !colors.is_empty() {
        Paint::Vertices(vertices.map(|n| colors[n as usize]).collect())
    } else if surface.caps.len() == surface.mesh.triangles.len() {
        let color = |n: u32| if surface.caps[n as usize] { DARK } else { BEIGE };
        Paint::Triangles(triangles.map(color).collect())
    } else {
        Paint::Plain(BEIGE)
    }
}

/// What there is to render.
fn stage(surface: &Surface, look: &Look) -> Stage {
    let mut parts = vec![if surface.mesh.triangles.len() > MOST {
        let cell = (SHARE * surface.mesh.area() / MOST as f64).sqrt();
        let Clustered { mesh, vertices, triangles } = surface.mesh.clustered(cell);
        let paint = paint(surface, vertices.into_iter(), triangles.into_iter());
        Part { mesh, paint, inside: DARK }
    } else {
        let mesh = surface.mesh.clone();
        let paint = paint(surface, 0..mesh.vertices.len() as u32, 0..mesh.triangles.len() as u32);
        Part { mesh, paint, inside: DARK }
    }];
    parts.extend(surface.marks.iter().map(|(mesh, color)| Part::new(mesh.clone(), *color)));
    if let Some([low, high]) = surface.frame {
        let diagonal = (0..3).map(|m| (high[m] - low[m]).powi(2)).sum::<f64>().sqrt();
        parts.push(Part::new(shapes::frame(low, high, THIN * diagonal), LINE));
    }
    Stage::new(&parts, look.view.up)
}

/// Draws a surface; a quantity on it gets a colour bar.
///
/// # Errors
/// If the font fails.
pub fn draw(surface: &Surface, look: &Look) -> Result<Canvas> {
    let picture = stage(surface, look).draw(&look.view, &look.light, [look.size; 2]);
    let Some(values) = &surface.values else { return Ok(canvas(&picture, 0)) };
    let (map, range) = scale(values);
    let ticks = axes::ticks(range, 6);
    let labels = ticks.iter().map(|(_, label)| font::width(label, TEXT[0]).ceil() as usize);
    let room = 22 + 10 + labels.max().unwrap_or(0) + 10 + TEXT[1] as usize + 20;
    let mut canvas = canvas(&picture, room);
    let [w, h] = [look.size, look.size];
    let top = h / 5;
    picture::draw_bar(&mut canvas, [w, top, w + 22, h - top], (map, range), &ticks)?;
    let at = [(w + room - 12) as f64 - 0.5 * TEXT[1], 0.5 * h as f64];
    canvas.text(&values.label, at, TEXT[1], Hang::Upwards)?;
    Ok(canvas)
}

/// Writes a film around a surface as GIF, half as large as the picture.
///
/// # Errors
/// If `out` fails.
pub fn write_turntable(surface: &Surface, look: &Look, out: &mut impl Write) -> Result<()> {
    write_film(surface, look, Path::new("turntable.gif"), out)
}

/// Writes a film of `surface.turntable` pictures around a surface as GIF or APNG, by the
/// extension of `path`.
///
/// # Errors
/// As [`animation::write_pictures`].
pub fn write_film(surface: &Surface, look: &Look, path: &Path, out: &mut impl Write) -> Result<()> {
    let size = [(look.size as f64 * FILM).ceil() as usize; 2];
    let pictures = stage(surface, look).turn(&look.view, &look.light, size, surface.turntable);
    animation::write_pictures(&pictures, path, out)
}

/// A picture with room for a colour bar beside it.
fn canvas(picture: &Picture, room: usize) -> Canvas {
    let [w, h] = picture.size;
    let mut canvas = Canvas::new(w + room, h);
    canvas.fill([w, 0, w + room, h], PAPER);
    for (y, row) in picture.pixels.chunks_exact(w).enumerate() {
        canvas.row_mut(0, y, w).copy_from_slice(row.as_flattened());
    }
    canvas
}
