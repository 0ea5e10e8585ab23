//! Several pictures with their captions on one sheet.

use crate::output::{canvas::Canvas, font::Hang};
use anyhow::{Context as _, Result};
use image::{
    RgbImage,
    imageops::{FilterType, resize},
};

/// Space around a panel, pixels.
const GAP: usize = 16;
/// Size of a caption, pixels.
const TEXT: f64 = 20.0;
/// Height of a caption with its space, pixels.
const CAPTION: usize = 34;

/// Puts rows of PNG pictures, each with its caption below, on one PNG; all of them `width` pixels
/// wide, or as they are, small ones magnified by whole times.
///
/// # Errors
/// If a picture is no PNG, or the font fails.
pub(crate) fn encode(rows: &[Vec<(String, Vec<u8>)>], width: Option<u32>) -> Result<Vec<u8>> {
    let decode = |(title, png): &(String, Vec<u8>)| -> Result<(String, RgbImage)> {
        let picture = image::load_from_memory(png).with_context(|| format!("panel `{title}`"))?;
        Ok((title.clone(), scaled(picture.to_rgb8(), width)))
    };
    let rows: Result<Vec<Vec<_>>> =
        rows.iter().map(|row| row.iter().map(decode).collect()).collect();
    let mut rows = rows?;
    let all = || rows.iter().flatten();
    let columns = rows.iter().map(Vec::len).max().unwrap_or(1);
    let width = all().map(|(_, p)| p.width() as usize).max().unwrap_or(1);
    let height = all().map(|(_, p)| p.height() as usize).max().unwrap_or(1);
    let caption = if all().any(|(title, _)| !title.is_empty()) { CAPTION } else { 0 };
    for (_, picture) in rows.iter_mut().flatten() {
        *picture = magnified(std::mem::take(picture), width, height);
    }
    // Every row is as high as its highest panel.
    let tallest = |row: &Vec<(String, RgbImage)>| {
        row.iter().map(|(_, p)| p.height() as usize).max().unwrap_or(1)
    };
    let heights: Vec<usize> = rows.iter().map(tallest).collect();
    let height: usize = heights.iter().map(|h| h + caption + GAP).sum();
    let mut sheet = Canvas::new(GAP + columns * (width + GAP), GAP + height);
    let mut top = GAP;
    for (row, height) in rows.iter().zip(heights) {
        for (n, (title, picture)) in row.iter().enumerate() {
            let left = GAP + n * (width + GAP);
            let (w, h) = (picture.width() as usize, picture.height() as usize);
            let (x, y) = (left + (width - w) / 2, top + height - h);
            for (line, pixels) in picture.as_raw().chunks_exact(3 * w).enumerate() {
                sheet.row_mut(x, y + line, w).copy_from_slice(pixels);
            }
            if !title.is_empty() {
                let at = [(left + width / 2) as f64, (top + height + 8) as f64];
                sheet.text(title, at, TEXT, Hang::Below)?;
            }
        }
        top += height + caption + GAP;
    }
    let mut bytes = Vec::new();
    sheet.write_png(&mut bytes)?;
    Ok(bytes)
}

/// A picture of another width, of the same proportions.
fn scaled(picture: RgbImage, width: Option<u32>) -> RgbImage {
    let Some(width) = width.filter(|&w| w != picture.width()) else { return picture };
    let height = f64::from(picture.height()) * f64::from(width) / f64::from(picture.width());
    resize(&picture, width, (height.round() as u32).max(1), FilterType::CatmullRom)
}

/// A picture by whole times as large as fits into a panel.
fn magnified(picture: RgbImage, width: usize, height: usize) -> RgbImage {
    let (w, h) = picture.dimensions();
    let times = (width as u32 / w).min(height as u32 / h);
    match times {
        0 | 1 => picture,
        _ => {
            RgbImage::from_fn(w * times, h * times, |x, y| *picture.get_pixel(x / times, y / times))
        }
    }
}
