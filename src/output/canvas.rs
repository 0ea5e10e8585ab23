//! A picture in memory: colours, anti-aliased lines, text.

use super::{
    colormap::{Colormap, Rgb},
    font::{self, Hang},
};
use anyhow::{Result, anyhow};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
    text_anchor::{HPos, VPos},
};
use std::{convert::Infallible, io::Write};

/// 8-bit sRGB pixels, row 0 at the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Canvas {
    width: usize,
    height: usize,
    pixels: Vec<u8>,
    /// Scratch of [`Self::stroke`]: how much of each pixel the line covers, 0 outside a call.
    coverage: Vec<f32>,
}

impl Canvas {
    /// A white picture.
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, height, pixels: vec![255; 3 * width * height], coverage: Vec::new() }
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// The pixels, RGB, row 0 at the top.
    pub fn pixels(&self) -> &[u8] {
        &self.pixels
    }

    /// The `count` pixels of row `y` that begin at `x`.
    pub(crate) fn row_mut(&mut self, x: usize, y: usize, count: usize) -> &mut [u8] {
        let at = 3 * (y * self.width + x);
        &mut self.pixels[at..at + 3 * count]
    }

    /// Mixes `color` into a pixel by `alpha` in [0, 1].
    fn blend(&mut self, x: usize, y: usize, color: Rgb, alpha: f64) {
        for (old, new) in self.row_mut(x, y, 1).iter_mut().zip(color) {
            *old = (f64::from(*old) + alpha * (f64::from(new) - f64::from(*old))).round() as u8;
        }
    }

    /// Fills the pixels `[x0, x1) x [y0, y1)`, cut at the border.
    pub(crate) fn fill(&mut self, [x0, y0, x1, y1]: [usize; 4], color: Rgb) {
        let (x1, y1) = (x1.min(self.width), y1.min(self.height));
        for y in y0..y1 {
            for pixel in self.row_mut(x0.min(x1), y, x1.saturating_sub(x0)).chunks_exact_mut(3) {
                pixel.copy_from_slice(&color);
            }
        }
    }

    /// Draws segments `[[x, y], [x, y]]` (pixels; integers are pixel corners) as one
    /// round-ended line of `width` pixels: where segments overlap nothing darkens.
    pub(crate) fn stroke(&mut self, segments: &[[[f64; 2]; 2]], width: f64, color: Rgb) {
        let size = [self.width, self.height];
        if self.coverage.is_empty() {
            self.coverage = vec![0.0; self.width * self.height];
        }
        let mut touched = [usize::MAX, usize::MAX, 0, 0];
        for &segment in segments {
            cover(&mut self.coverage, size, segment, width, &mut touched);
        }
        for y in touched[1]..touched[3] {
            for x in touched[0]..touched[2] {
                let alpha = std::mem::take(&mut self.coverage[y * self.width + x]);
                if alpha > 0.0 {
                    self.blend(x, y, color, f64::from(alpha));
                }
            }
        }
    }

    /// Draws a text of `size` pixels at `at`.
    ///
    /// # Errors
    /// If the font fails.
    pub(crate) fn text(&mut self, text: &str, at: [f64; 2], size: f64, hang: Hang) -> Result<()> {
        let style = font::style(size, [0; 3], hang);
        self.draw_text(text, &style, (at[0].round() as i32, at[1].round() as i32))
            .map_err(|error| anyhow!("drawing the text `{text}`: {error}"))
    }

    /// Writes a PNG.
    ///
    /// # Errors
    /// If `out` fails.
    pub fn write_png(&self, out: &mut impl Write) -> Result<()> {
        let mut encoder = png::Encoder::new(out, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Fast);
        // Magnified cells repeat the row above.
        encoder.set_filter(png::Filter::Up);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.pixels)?;
        Ok(writer.finish()?)
    }

    /// The low end of `map` at the bottom of `[x0, x1) x [y0, y1)`, the high end at its top.
    pub(crate) fn color_bar(&mut self, [x0, y0, x1, y1]: [usize; 4], map: Colormap) {
        for y in y0..y1 {
            let t = 1.0 - (y - y0) as f64 / (y1 - y0).max(2).saturating_sub(1) as f64;
            self.fill([x0, y, x1, y + 1], map.color(t));
        }
    }
}

/// Raises `coverage` to what a segment of `width` pixels covers, and `touched`
/// (`[x0, y0, x1, y1)`) around it.
///
/// The coverage of a pixel is taken as that of a half plane: width / 2 + 1/2 - distance
/// of its middle, in [0, 1].
fn cover(
    coverage: &mut [f32],
    [nx, ny]: [usize; 2],
    [a, b]: [[f64; 2]; 2],
    width: f64,
    touched: &mut [usize; 4],
) {
    if !a.iter().chain(&b).all(|v| v.is_finite()) {
        return;
    }
    let radius = 0.5 * width + 0.5;
    let low = |p: f64, q: f64| (p.min(q) - radius).floor().max(0.0) as usize;
    let high = |p: f64, q: f64, n: usize| ((p.max(q) + radius).ceil().max(0.0) as usize).min(n);
    let [x0, y0] = [low(a[0], b[0]), low(a[1], b[1])];
    let [x1, y1] = [high(a[0], b[0], nx), high(a[1], b[1], ny)];
    if x0 >= x1 || y0 >= y1 {
        return;
    }
    *touched = [touched[0].min(x0), touched[1].min(y0), touched[2].max(x1), touched[3].max(y1)];
    let d = [b[0] - a[0], b[1] - a[1]];
    let length2 = d[0] * d[0] + d[1] * d[1];
    // A point has no direction: t = 0.
    let inverse = if length2 > 0.0 { 1.0 / length2 } else { 0.0 };
    let darkest = width.min(1.0);
    for y in y0..y1 {
        let py = y as f64 + 0.5 - a[1];
        // The part of the row that the segment, widened by its radius, can reach.
        let (from, to) = if d[1].abs() * 4.0 > d[0].abs() {
            let reach = radius * (length2.sqrt() / d[1].abs());
            let x = a[0] + (py / d[1]).clamp(0.0, 1.0) * d[0];
            let (u, v) = (x - reach - radius, x + reach + radius);
            ((u.floor().max(x0 as f64)) as usize, (v.ceil().min(x1 as f64)).max(0.0) as usize)
        } else {
            (x0, x1)
        };
        let Some(row) = coverage.get_mut(y * nx + from..y * nx + to.max(from)) else { continue };
        for (x, old) in row.iter_mut().enumerate() {
            let px = (from + x) as f64 + 0.5 - a[0];
            let t = ((px * d[0] + py * d[1]) * inverse).clamp(0.0, 1.0);
            let (u, v) = (px - t * d[0], py - t * d[1]);
            let part = (radius - (u * u + v * v).sqrt()).clamp(0.0, darkest) as f32;
            *old = old.max(part);
        }
    }
}

/// How much of each pixel of a picture a line covers, in [0, 1]; see [`Canvas::stroke`].
pub(crate) fn coverage(size: [usize; 2], segments: &[[[f64; 2]; 2]], width: f64) -> Vec<f32> {
    let mut coverage = vec![0.0; size[0] * size[1]];
    let mut touched = [usize::MAX, usize::MAX, 0, 0];
    for &segment in segments {
        cover(&mut coverage, size, segment, width, &mut touched);
    }
    coverage
}

/// A path as the segments that join its points.
pub(crate) fn segments(points: &[[f64; 2]]) -> Vec<[[f64; 2]; 2]> {
    points.windows(2).map(|pair| [pair[0], pair[1]]).collect()
}

fn rgb(color: BackendColor) -> Rgb {
    [color.rgb.0, color.rgb.1, color.rgb.2]
}

fn middle((x, y): BackendCoord) -> [f64; 2] {
    [f64::from(x) + 0.5, f64::from(y) + 0.5]
}

/// What plotters draws on: as its own bitmap backend, with anti-aliased lines of any width.
impl DrawingBackend for Canvas {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        (self.width as u32, self.height as u32)
    }

    fn ensure_prepared(&mut self) -> Result<(), DrawingErrorKind<Infallible>> {
        Ok(())
    }

    fn present(&mut self) -> Result<(), DrawingErrorKind<Infallible>> {
        Ok(())
    }

    fn draw_pixel(
        &mut self,
        (x, y): BackendCoord,
        color: BackendColor,
    ) -> Result<(), DrawingErrorKind<Infallible>> {
        if let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y))
            && x < self.width
            && y < self.height
        {
            self.blend(x, y, rgb(color), color.alpha);
        }
        Ok(())
    }

    fn draw_line<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
    ) -> Result<(), DrawingErrorKind<Infallible>> {
        self.draw_path([from, to], style)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Result<(), DrawingErrorKind<Infallible>> {
        let points: Vec<_> = path.into_iter().map(middle).collect();
        self.stroke(&segments(&points), f64::from(style.stroke_width()), rgb(style.color()));
        Ok(())
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        (x0, y0): BackendCoord,
        (x1, y1): BackendCoord,
        style: &S,
        fill: bool,
    ) -> Result<(), DrawingErrorKind<Infallible>> {
        if !fill {
            return self.draw_path([(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)], style);
        }
        let corner = |v: i32| usize::try_from(v).unwrap_or(0);
        self.fill([corner(x0), corner(y0), corner(x1), corner(y1)], rgb(style.color()));
        Ok(())
    }

    /// As the default, but centred on the height of capitals, where that centres on
    /// a line that no letter of this font is symmetric about.
    fn draw_text<T: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &T,
        pos: BackendCoord,
    ) -> Result<(), DrawingErrorKind<Infallible>> {
        /// plotters puts the baseline half a size below the top.
        const BASELINE: f64 = 0.5;
        /// Height of capitals: 0.729 em (DejaVu Sans) of size / 1.164 (ascent + descent).
        const CAPITALS: f64 = 0.626;
        let failed = |error| DrawingErrorKind::FontError(Box::new(error));
        let ((left, _), (right, _)) = style.layout_box(text).map_err(failed)?;
        let dx = match style.anchor().h_pos {
            HPos::Left => 0,
            HPos::Center => (left - right) / 2,
            HPos::Right => left - right,
        };
        let part = match style.anchor().v_pos {
            VPos::Top => CAPITALS,
            VPos::Center => 0.5 * CAPITALS,
            VPos::Bottom => 0.0,
        };
        let dy = ((part - BASELINE) * style.size()).round() as i32;
        let turn = style.transform();
        let drawn = style.draw(text, (0, 0), |x, y, color| {
            let (x, y) = turn.transform(x + dx, y + dy);
            self.draw_pixel((pos.0 + x, pos.1 + y), color)
        });
        drawn.map_err(failed)?
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        center: BackendCoord,
        radius: u32,
        style: &S,
        _fill: bool,
    ) -> Result<(), DrawingErrorKind<Infallible>> {
        let middle = middle(center);
        self.stroke(&[[middle, middle]], 2.0 * f64::from(radius), rgb(style.color()));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stroke_covers_its_area() {
        // Darkness of a line of length 80 and width 3: 240 and two half discs, pi 1.5^2.
        let mut canvas = Canvas::new(120, 120);
        for (a, b) in [([20.0, 60.0], [100.0, 60.0]), ([20.3, 36.2], [84.3, 84.2])] {
            canvas.fill([0, 0, 120, 120], [255; 3]);
            canvas.stroke(&[[a, b]], 3.0, [0; 3]);
            let dark: f64 =
                canvas.pixels.iter().map(|&v| 1.0 - f64::from(v) / 255.0).sum::<f64>() / 3.0;
            let exact = 240.0 + std::f64::consts::PI * 2.25;
            assert!((dark - exact).abs() < 0.02 * exact, "{dark} {exact}");
            assert!(canvas.coverage.iter().all(|&c| c == 0.0));
        }
    }

    #[test]
    fn lines_that_leave_the_picture_are_cut() {
        let mut canvas = Canvas::new(20, 10);
        canvas.stroke(
            &[[[-50.0, -50.0], [70.0, 60.0]], [[5.0, f64::NAN], [6.0, 7.0]]],
            2.0,
            [0; 3],
        );
        canvas.stroke(&[[[-50.0, 5.0], [-40.0, 5.0]]], 2.0, [0; 3]);
        assert!(canvas.pixels.contains(&0));
    }
}
