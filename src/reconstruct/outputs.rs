//! The files of a reconstruction.

use super::{Report, answer};
use crate::{artifact, figure::sheet, output::canvas::Canvas};
use anyhow::Result;
use image::{GrayImage, ImageFormat};
use patterns::{
    Artifact, Axis, Colors, Image, Mark, Plot, Series,
    disocclusion::{normalize, scores::Score},
};
use solvers::{
    Field, Grid,
    isosurface::{Polyline, closed_contours},
};
use std::io::Cursor;

/// Pictures on the sheet are magnified to about this many pixels.
const PANEL: usize = 400;

/// Colour of the contour on the overlay, and of what is hidden there.
const CONTOUR: [u8; 3] = [213, 94, 0];
const HIDDEN: [u8; 3] = [86, 180, 233];

/// Ink of the whole picture at its own size: what is seen, and in the hole the likeliest sample,
/// which has the statistics of the pattern as a mean over samples has not.
pub(super) fn whole(report: &Report) -> Vec<bool> {
    let source = &report.source;
    let filled = |n: usize| report.filled.picture()[work_pixel(report, n)];
    let seen = match source.factor {
        1 => None,
        _ => normalize(&source.picture, &source.visible).ok(),
    };
    let ink = seen.as_ref().map_or(&report.normal.ink, |normal| &normal.ink);
    (0..ink.len()).map(|n| if source.visible[n] { ink[n] } else { filled(n) }).collect()
}

/// The pixel of the working size under a pixel of the picture.
fn work_pixel(report: &Report, n: usize) -> usize {
    let [_, nx] = report.source.shape();
    let [my, mx] = report.normal.shape;
    let factor = report.source.factor;
    (n / nx / factor).min(my - 1) * mx + (n % nx / factor).min(mx - 1)
}

/// Names and bytes of all files but `run.json`.
pub(super) fn encode(report: &Report) -> Result<Vec<(String, Vec<u8>)>> {
    let source = &report.source;
    let shape = source.shape();
    let ink = whole(report);
    let (low, high) = source.picture.range();
    let level = |v: f64| (255.0 * (v - low) / (high - low)).round() as u8;
    // What is under a mask that was given is not looked at, so it is not shown.
    let shown = |n: usize| source.detected.is_some() || source.visible[n];
    let pixels = source.picture.as_slice().iter().enumerate();
    let occluded: Vec<u8> = pixels.map(|(n, &v)| if shown(n) { level(v) } else { 128 }).collect();
    let mask: Vec<u8> = source.visible.iter().map(|&seen| if seen { 0 } else { 255 }).collect();
    let black =
        |ink: &[bool]| -> Vec<u8> { ink.iter().map(|&i| if i { 0 } else { 255 }).collect() };
    let confidence: Vec<f64> =
        (0..ink.len())
            .map(|n| {
                if source.visible[n] {
                    1.0
                } else {
                    report.filled.confidence[work_pixel(report, n)]
                }
            })
            .collect();
    let lines = contour(report);
    let overlay = overlay(&occluded, report, &lines)?;
    let shades: Vec<u8> = confidence.iter().map(|c| (255.0 * c).round() as u8).collect();
    let mut panels = vec![
        ("seen".to_owned(), magnified(&occluded, shape)?),
        ("hidden (white)".to_owned(), magnified(&mask, shape)?),
        ("reconstructed".to_owned(), magnified(&black(&ink), shape)?),
        ("confidence (0 black, 1 white)".to_owned(), magnified(&shades, shape)?),
        ("overlay".to_owned(), overlay.clone()),
    ];
    if let Some(truth) = &source.truth {
        panels.push(("truth".to_owned(), magnified(&black(truth), shape)?));
    }
    let rows: Vec<_> = panels.chunks(3).map(<[_]>::to_vec).collect();
    let mut files = vec![
        ("occluded.png".to_owned(), png(&occluded, shape)?),
        ("mask.png".to_owned(), png(&mask, shape)?),
        ("reconstructed.png".to_owned(), png(&black(&ink), shape)?),
        ("overlay.png".to_owned(), overlay),
        ("sheet.png".to_owned(), sheet::encode(&rows, None)?),
        ("candidates.csv".to_owned(), answer::csv(report).into_bytes()),
    ];
    if let Some(truth) = &source.truth {
        files.push(("truth.png".to_owned(), png(&black(truth), shape)?));
    }
    for (n, sample) in report.filled.samples.iter().enumerate().skip(1) {
        let at = |n: usize| match source.visible[n] {
            true => ink[n],
            false => sample[work_pixel(report, n)],
        };
        let whole: Vec<bool> = (0..ink.len()).map(at).collect();
        files.push((format!("sample-{}.png", n + 1), png(&black(&whole), shape)?));
    }
    let size = [shape[1] as f64, shape[0] as f64];
    let mut artifacts = vec![
        Artifact::Image(Image {
            name: "confidence".into(),
            field: Field::from_vec(Grid::new(&shape, 1.0)?, confidence)?,
            label: "confidence (1)".into(),
            colors: Colors::Sequential,
            range: Some([0.0, 1.0]),
            contour: None,
            rows: None,
        }),
        Artifact::Contour { name: "contour".into(), lines, size },
    ];
    artifacts.extend(plots(&report.scores));
    files.extend(artifact::encode_all(&artifacts)?);
    Ok(files)
}

/// Closed borders of the ink, in pixels from the upper left corner.
fn contour(report: &Report) -> Vec<Polyline> {
    let mut lines = closed_contours(&report.filled.contour, 0.0);
    // Nodes are the middles of pixels.
    let factor = report.source.factor as f64;
    lines.iter_mut().flat_map(|l| &mut l.points).flatten().for_each(|v| *v = factor * (*v + 0.5));
    lines
}

/// The picture with what is hidden tinted and the contour on top.
fn overlay(grey: &[u8], report: &Report, lines: &[Polyline]) -> Result<Vec<u8>> {
    let [ny, nx] = report.source.shape();
    let times = times([ny, nx]);
    let mut canvas = Canvas::new(nx * times, ny * times);
    for y in 0..ny * times {
        let row = canvas.row_mut(0, y, nx * times);
        for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
            let n = y / times * nx + x / times;
            let light = u16::from(grey[n]);
            for (out, tint) in pixel.iter_mut().zip(HIDDEN) {
                *out = match report.source.visible[n] {
                    true => light as u8,
                    false => ((light + 3 * u16::from(tint)) / 4) as u8,
                };
            }
        }
    }
    let segments: Vec<[[f64; 2]; 2]> = lines
        .iter()
        .flat_map(|line| line.sides())
        .map(|(a, b)| [a, b].map(|p| p.map(|v| v * times as f64)))
        .collect();
    canvas.stroke(&segments, 2.0, CONTOUR);
    let mut bytes = Vec::new();
    canvas.write_png(&mut bytes)?;
    Ok(bytes)
}

fn times([ny, nx]: [usize; 2]) -> usize {
    (PANEL / ny.max(nx)).max(1)
}

/// Grey levels as PNG, a pixel each.
fn png(grey: &[u8], [ny, nx]: [usize; 2]) -> Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    let picture = GrayImage::from_raw(nx as u32, ny as u32, grey.to_vec())
        .ok_or_else(|| anyhow::anyhow!("{} pixels are not {nx} x {ny}", grey.len()))?;
    picture.write_to(&mut bytes, ImageFormat::Png)?;
    Ok(bytes.into_inner())
}

/// Grey levels as PNG, some pixels each.
fn magnified(grey: &[u8], [ny, nx]: [usize; 2]) -> Result<Vec<u8>> {
    let times = times([ny, nx]);
    let width = nx * times;
    let at = |n: usize| grey[n / width / times * nx + n % width / times];
    let large: Vec<u8> = (0..ny * times * width).map(at).collect();
    png(&large, [ny * times, width])
}

/// The scores against the iteration of the class's own run.
fn plots(scores: &[Score]) -> Vec<Artifact> {
    if scores.is_empty() {
        return Vec::new();
    }
    let series = |label: &str, value: &dyn Fn(&Score) -> f64| Series {
        label: label.into(),
        points: scores.iter().map(|s| [s.iteration as f64, value(s)]).collect(),
        mark: Mark::Line,
    };
    let plot = |name: &str, title: &str, y: &str, series: Vec<Series>| {
        Artifact::Plot(Plot {
            name: name.into(),
            title: title.into(),
            x: Axis::linear("iteration"),
            y: Axis::linear(y),
            series,
        })
    };
    vec![
        plot(
            "scores",
            "The paper's score of the model that was found",
            "sum of products (pixels)",
            vec![series("sum of products", &|s| s.sum_of_products)],
        ),
        plot(
            "scores-normalized",
            "Agreement with what is seen",
            "score (1)",
            vec![
                series("correlation", &|s| s.correlation),
                series("mean squared error", &|s| s.mean_squared_error),
            ],
        ),
    ]
}
