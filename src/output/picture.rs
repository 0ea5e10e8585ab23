//! Pictures of fields: false colour with axes and a colour bar, or ink on paper.
//!
//! Row 0 of a field is at the top, as in images; y grows downwards.

use super::{
    axes,
    canvas::Canvas,
    colormap::{Colormap, Rgb},
    font::{self, Hang},
    plot,
    slice::{self, Slice},
};
use anyhow::Result;
use patterns::{Axis, Colors, Image, Mark, Plot, Series, Stroke};
use std::io::Write;

/// How a picture is drawn.
#[derive(Clone, Debug, Default)]
pub struct Style {
    /// Heading; none for ink.
    pub title: Option<String>,
    /// Colormap; `None`: that of the image's colours.
    pub map: Option<Colormap>,
}

/// Sides up to this many pixels are reached by magnifying.
const SIDE: usize = 560;
/// The same for the sum of the widths of a solid's three slices.
const SIDE_THREE: usize = 900;
/// Larger fields are shrunk to this many pixels.
const LARGEST: usize = 4096;
/// Size of tick labels, axis labels and title, pixels.
const TEXT: [f64; 3] = [18.0, 19.0, 22.0];
/// Space between things, pixels.
const GAP: usize = 10;
/// Width of the colour bar, pixels.
const BAR: usize = 22;
const BLACK: Rgb = [0; 3];
const WHITE: Rgb = [255; 3];

/// Writes a picture of a field as PNG; see [`draw`].
///
/// # Errors
/// If `out` fails.
pub fn write_png(image: &Image, style: &Style, out: &mut impl Write) -> Result<()> {
    draw(image, style)?.write_png(out)
}

/// Writes ink with straight lines on top as PNG, with a margin of paper for lines that leave
/// the field.
///
/// # Errors
/// If `out` fails.
pub fn write_drawing(image: &Image, strokes: &[Stroke], out: &mut impl Write) -> Result<()> {
    let panel = slice::middle(&image.field).swap_remove(0);
    let times = (SIDE / panel.nx.max(panel.ny)).max(1);
    let inner = ink(&[panel], &[], times, image.range);
    let cells = |axis: usize| strokes.iter().flat_map(move |s| s.ends.map(|end| end[axis]));
    let beyond = |axis: usize, side: usize| {
        let last = side as f64 / times as f64;
        let farthest = cells(axis).map(|v| (-v).max(v - last)).fold(0.0, f64::max);
        (farthest * times as f64).ceil() as usize + GAP
    };
    let [w, h] = inner.size();
    let margin = [beyond(0, w), beyond(1, h)];
    let mut canvas = Canvas::new(w + 2 * margin[0], h + 2 * margin[1]);
    for (y, row) in inner.pixels().chunks_exact(3 * w).enumerate() {
        canvas.row_mut(margin[0], margin[1] + y, w).copy_from_slice(row);
    }
    outline(&mut canvas, [margin[0], margin[1], margin[0] + w, margin[1] + h]);
    for stroke in strokes {
        let pixel = |end: [f64; 2]| [0, 1].map(|n| margin[n] as f64 + end[n] * times as f64);
        canvas.stroke(&[stroke.ends.map(pixel)], 2.4, stroke.color);
    }
    canvas.write_png(out)
}

/// Draws a field: false colours in axes, with a colour bar and the zero line of
/// `image.contour`; ink without any of these. A solid is shown by its three middle slices,
/// a line by a plot.
///
/// Small fields are magnified by a whole number, to at least 280 pixels.
///
/// # Errors
/// If the font fails.
pub fn draw(image: &Image, style: &Style) -> Result<Canvas> {
    if image.field.grid().dim() == 1 && image.colors != Colors::Ink {
        return plot::draw(&as_plot(image, style));
    }
    let mut panels = slice::middle(&image.field);
    if let [panel] = &mut panels[..] {
        panel.rows = image.rows;
    }
    let lines = image.contour.as_ref().map(slice::middle).unwrap_or_default();
    let (wanted, longest) = if panels.len() > 1 {
        (SIDE_THREE, panels.iter().map(|p| p.nx).sum())
    } else {
        (SIDE, panels[0].nx.max(panels[0].ny))
    };
    let shrink = longest.div_ceil(LARGEST);
    let times = (wanted / longest).max(1);
    let shrunk = |slices: Vec<Slice>| slices.into_iter().map(|s| s.shrink(shrink)).collect();
    let (panels, lines): (Vec<Slice>, Vec<Slice>) = (shrunk(panels), shrunk(lines));
    if image.colors == Colors::Ink {
        return Ok(ink(&panels, &lines, times, image.range));
    }
    false_color(image, style, (&panels, &lines), times)
}

/// Values at the ends of the colormap: as given, or from the data; a diverging map is
/// centred on zero.
pub(crate) fn color_range(image: &Image) -> [f64; 2] {
    if let Some(range) = image.range.filter(|&r| axes::is_range(r, false)) {
        return range;
    }
    let [low, high] = axes::data_range(image.field.as_slice().iter().copied(), false);
    match image.colors {
        Colors::Diverging => {
            let end = low.abs().max(high.abs());
            [-end, end]
        }
        _ => [low, high],
    }
}

/// A field on a line, as a curve.
fn as_plot(image: &Image, style: &Style) -> Plot {
    let h = image.field.grid().spacing();
    let points = image.field.as_slice().iter().enumerate().map(|(i, &v)| [i as f64 * h, v]);
    let mut y = Axis::linear(&image.label);
    y.range = image.range;
    Plot {
        name: image.name.clone(),
        title: style.title.clone().unwrap_or_default(),
        x: Axis::linear(&format!("x ({})", slice::unit(h))),
        y,
        series: vec![Series {
            label: image.label.clone(),
            points: points.collect(),
            mark: Mark::Line,
        }],
    }
}

/// Black where phi < 0 (with anti-aliased edges) or the field is low.
fn ink(panels: &[Slice], phi: &[Slice], times: usize, range: Option<[f64; 2]>) -> Canvas {
    let all = || panels.iter().flat_map(|p| p.values.iter().copied());
    let [low, high] = range
        .filter(|&r| axes::is_range(r, false))
        .unwrap_or_else(|| axes::data_range(all(), false));
    let width = panels.iter().map(|p| p.nx * times + GAP).sum::<usize>() - GAP;
    let height = panels.iter().map(|p| p.ny * times).max().unwrap_or(1);
    let mut canvas = Canvas::new(width, height);
    let mut x0 = 0;
    for (n, panel) in panels.iter().enumerate() {
        let paper: Vec<f64> = match phi.get(n) {
            Some(phi) => phi.magnify(times).outside(),
            None => {
                let smooth = panel.magnify(times).values;
                smooth.iter().map(|v| (v - low) / (high - low)).collect()
            }
        };
        let nx = panel.nx * times;
        for (y, row) in paper.chunks_exact(nx).enumerate() {
            for (pixel, v) in canvas.row_mut(x0, y, nx).chunks_exact_mut(3).zip(row) {
                pixel.fill((255.0 * v).round().clamp(0.0, 255.0) as u8);
            }
        }
        x0 += nx + GAP;
    }
    canvas
}

/// Panels side by side in axes, and a colour bar.
fn false_color(
    image: &Image,
    style: &Style,
    (panels, lines): (&[Slice], &[Slice]),
    times: usize,
) -> Result<Canvas> {
    let map = style.map.unwrap_or(Colormap::of(image.colors));
    let range = color_range(image);
    let inner = panels.iter().map(|p| p.ny * times).max().unwrap_or(1).max(160);
    let bar_ticks = axes::ticks(range, (inner / 60).max(4));
    let left: Vec<usize> = panels.iter().map(|p| left_axis(p, times).1).collect();
    let head = |text: &str| if text.is_empty() { 0 } else { TEXT[2] as usize + GAP };
    let title = style.title.as_deref().unwrap_or("");
    let subtitles = panels.iter().any(|p| !p.at.is_empty());
    let top = GAP + head(title) + if subtitles { head("-") } else { 0 };
    let bar_labels = widest(bar_ticks.iter().map(|(_, label)| label.as_str()));
    let panels_width: usize =
        panels.iter().zip(&left).map(|(p, l)| l + p.nx * times + 2 * GAP).sum();
    let bar_x = panels_width + GAP / 2;
    let width = bar_x + BAR + GAP + bar_labels + GAP + TEXT[1] as usize + GAP;
    let bottom = 2 * GAP + TEXT[0] as usize + TEXT[1] as usize + 4;
    // A label longer than the bar is high needs room as well.
    let need = font::width(&image.label, TEXT[1]) as usize + 2 * GAP;
    let mut canvas = Canvas::new(width, (top + inner + bottom).max(need));
    // The middle of a diverging map is light.
    let line_colors = match image.colors {
        Colors::Diverging => [BLACK, WHITE],
        _ => [WHITE, BLACK],
    };
    let mut x0 = 0;
    for (n, (panel, left)) in panels.iter().zip(&left).enumerate() {
        x0 += left;
        draw_cells(&mut canvas, panel, [x0, top], times, (map, range));
        if let Some(phi) = lines.get(n) {
            draw_contour(&mut canvas, phi, [x0, top], times, line_colors);
        }
        draw_frame(&mut canvas, panel, [x0, top], times)?;
        x0 += panel.nx * times + 2 * GAP;
    }
    if !title.is_empty() {
        let middle = 0.5 * (left[0] + panels_width) as f64;
        canvas.text(title, [middle, GAP as f64], TEXT[2], Hang::Below)?;
    }
    let bar = [bar_x, top, bar_x + BAR, top + inner];
    draw_bar(&mut canvas, bar, (map, range), &bar_ticks)?;
    let label_x = (width - GAP) as f64 - 0.5 * TEXT[1];
    let label_y = (top as f64 + 0.5 * inner as f64).max(0.5 * need as f64);
    canvas.text(&image.label, [label_x, label_y], TEXT[1], Hang::Upwards)?;
    Ok(canvas)
}

/// Ticks of an axis of `count` cells of size `step`, `apart` pixels from each other; no
/// fractions of cells.
fn cell_ticks(
    panel: &Slice,
    (count, step): (usize, f64),
    times: usize,
    apart: usize,
) -> Vec<(f64, String)> {
    let most = if panel.unit == "cells" { count.saturating_sub(1).max(1) } else { 8 };
    let wanted = (count * times / apart).clamp(2, 8).min(most);
    axes::ticks([0.0, (count - 1) as f64 * step], wanted)
}

/// From one row to the next.
fn down_step(panel: &Slice) -> f64 {
    panel.rows.map_or(panel.spacing, |(_, step)| step)
}

/// Ticks of the vertical axis, and the room that it takes.
fn left_axis(panel: &Slice, times: usize) -> (Vec<(f64, String)>, usize) {
    let ticks = cell_ticks(panel, (panel.ny, down_step(panel)), times, 60);
    let labels = widest(ticks.iter().map(|(_, label)| label.as_str()));
    (ticks, 3 * GAP + TEXT[1] as usize + labels)
}

/// Greatest width of tick labels in pixels.
fn widest<'a>(labels: impl Iterator<Item = &'a str>) -> usize {
    labels.map(|label| font::width(label, TEXT[0]).ceil() as usize).max().unwrap_or(0)
}

/// Each cell as a square of `times` pixels.
fn draw_cells(
    canvas: &mut Canvas,
    panel: &Slice,
    [x0, y0]: [usize; 2],
    times: usize,
    (map, [low, high]): (Colormap, [f64; 2]),
) {
    let nx = panel.nx * times;
    let mut line = vec![0; 3 * nx];
    for (j, row) in panel.values.chunks_exact(panel.nx).enumerate() {
        for (cell, &v) in line.chunks_exact_mut(3 * times).zip(row) {
            let color = map.color((v - low) / (high - low));
            cell.chunks_exact_mut(3).for_each(|pixel| pixel.copy_from_slice(&color));
        }
        for y in 0..times {
            canvas.row_mut(x0, y0 + j * times + y, nx).copy_from_slice(&line);
        }
    }
}

/// The zero line with a rim, so that it shows on every colour.
fn draw_contour(
    canvas: &mut Canvas,
    phi: &Slice,
    [x0, y0]: [usize; 2],
    times: usize,
    [line, rim]: [Rgb; 2],
) {
    let pixel = |p: [f64; 2]| {
        [x0 as f64 + (p[0] + 0.5) * times as f64, y0 as f64 + (p[1] + 0.5) * times as f64]
    };
    let segments: Vec<_> = phi.zero_segments().into_iter().map(|s| s.map(pixel)).collect();
    canvas.stroke(&segments, 3.4, rim);
    canvas.stroke(&segments, 1.6, line);
}

/// Frame, ticks and labels of a panel.
fn draw_frame(
    canvas: &mut Canvas,
    panel: &Slice,
    [x0, y0]: [usize; 2],
    times: usize,
) -> Result<()> {
    let (ticks, left) = left_axis(panel, times);
    let (x1, y1) = (x0 + panel.nx * times, y0 + panel.ny * times);
    outline(canvas, [x0, y0, x1, y1]);
    let [fx, fy] = [x0 as f64, y0 as f64];
    let place = |v: f64, step: f64| (v / step + 0.5) * times as f64;
    for (v, label) in cell_ticks(panel, (panel.nx, panel.spacing), times, 80) {
        let x = fx + place(v, panel.spacing);
        canvas.fill([x as usize, y1 + 1, x as usize + 1, y1 + 7], BLACK);
        canvas.text(&label, [x, (y1 + GAP + 1) as f64], TEXT[0], Hang::Below)?;
    }
    for (v, label) in ticks {
        let y = fy + place(v, down_step(panel));
        canvas.fill([x0 - 7, y as usize, x0 - 1, y as usize + 1], BLACK);
        canvas.text(&label, [(x0 - GAP) as f64, y], TEXT[0], Hang::Left)?;
    }
    let [middle_x, middle_y] = [0.5 * (x0 + x1) as f64, 0.5 * (y0 + y1) as f64];
    let below = (y1 + 2 * GAP) as f64 + TEXT[0];
    let [across, mut down] = panel.axes.map(|axis| format!("{axis} ({})", panel.unit));
    if let Some((label, _)) = panel.rows {
        down = label.into();
    }
    canvas.text(&across, [middle_x, below], TEXT[1], Hang::Below)?;
    let beside = (x0 - left + GAP) as f64 + 0.5 * TEXT[1];
    // A label longer than its axis starts where the axis does.
    let down_y = middle_y.max(0.5 * font::width(&down, TEXT[1]) + 2.0);
    canvas.text(&down, [beside, down_y], TEXT[1], Hang::Upwards)?;
    if !panel.at.is_empty() {
        canvas.text(&panel.at, [middle_x, fy - TEXT[2]], TEXT[1], Hang::Below)?;
    }
    Ok(())
}

/// A frame of one pixel around `[x0, x1) x [y0, y1)`.
fn outline(canvas: &mut Canvas, [x0, y0, x1, y1]: [usize; 4]) {
    canvas.fill([x0 - 1, y0 - 1, x1 + 1, y0], BLACK);
    canvas.fill([x0 - 1, y1, x1 + 1, y1 + 1], BLACK);
    canvas.fill([x0 - 1, y0, x0, y1], BLACK);
    canvas.fill([x1, y0, x1 + 1, y1], BLACK);
}

/// The colour bar and its numbers.
pub(super) fn draw_bar(
    canvas: &mut Canvas,
    [x0, y0, x1, y1]: [usize; 4],
    (map, [low, high]): (Colormap, [f64; 2]),
    ticks: &[(f64, String)],
) -> Result<()> {
    canvas.color_bar([x0, y0, x1, y1], map);
    outline(canvas, [x0, y0, x1, y1]);
    for (v, label) in ticks {
        let y = y1 as f64 - 0.5 - (v - low) / (high - low) * (y1 - y0 - 1) as f64;
        canvas.fill([x1 + 1, y as usize, x1 + 6, y as usize + 1], BLACK);
        canvas.text(label, [(x1 + GAP) as f64, y], TEXT[0], Hang::Right)?;
    }
    Ok(())
}
