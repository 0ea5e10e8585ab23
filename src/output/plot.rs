//! Plots: curves in axes, as PNG and SVG from one drawing.

use super::{
    axes,
    canvas::{self, Canvas},
    colormap::Rgb,
    font::{self, Hang},
};
use anyhow::{Result, anyhow};
use patterns::{Axis, Mark, Plot, Series};
use plotters::{
    prelude::{Color, DrawingBackend, RGBColor, SVGBackend},
    style::ShapeStyle,
};
use std::io::Write;

/// Width and height in pixels, for screens of high resolution.
const SIZE: [u32; 2] = [1280, 880];
/// Size of tick labels, axis labels and title, pixels.
const TEXT: [f64; 3] = [29.0, 31.0, 35.0];
/// Space between things, pixels.
const GAP: f64 = 16.0;
/// Length of the sample of a curve in the legend, pixels.
const SAMPLE: f64 = 56.0;
/// Okabe and Ito 2008, "Color universal design", without the yellow that fades on white.
pub(super) const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];
const GRID: RGBColor = RGBColor(225, 225, 225);
/// Frames of axes.
pub(super) const FRAME: Rgb = [90; 3];

/// Colour of the `n`-th thing.
pub(super) fn color(n: usize) -> Rgb {
    let RGBColor(r, g, b) = COLORS[n % COLORS.len()];
    [r, g, b]
}

/// A rectangle `[left, top, right, bottom]` in pixels.
type Box4 = [f64; 4];

/// Draws a plot as PNG.
///
/// # Errors
/// If `out` or the font fails.
pub fn write_png(plot: &Plot, out: &mut impl Write) -> Result<()> {
    draw(plot)?.write_png(out)
}

/// Draws a plot as SVG.
///
/// # Errors
/// If `out` or the font fails.
pub fn write_svg(plot: &Plot, out: &mut impl Write) -> Result<()> {
    let mut text = String::new();
    {
        let mut backend = SVGBackend::with_string(&mut text, (SIZE[0], SIZE[1]));
        Pen(&mut backend).plot(plot)?;
        backend.present().map_err(|error| anyhow!("drawing a plot: {error}"))?;
    }
    Ok(out.write_all(text.as_bytes())?)
}

/// Draws a plot as pixels.
///
/// # Errors
/// If the font fails.
pub fn draw(plot: &Plot) -> Result<Canvas> {
    let mut canvas = Canvas::new(SIZE[0] as usize, SIZE[1] as usize);
    Pen(&mut canvas).plot(plot)?;
    Ok(canvas)
}

/// An axis with its limits and the pixels that they lie at.
struct Scale {
    range: [f64; 2],
    log: bool,
    pixels: [f64; 2],
}

impl Scale {
    /// Limits as the axis demands, or those of the data and a little more.
    fn range(axis: &Axis, data: impl Iterator<Item = f64>) -> [f64; 2] {
        if let Some(range) = axis.range.filter(|&r| axes::is_range(r, axis.log)) {
            return range;
        }
        let [low, high] = axes::data_range(data, axis.log);
        if axis.log {
            let margin = (high / low).powf(0.04);
            return [low / margin, high * margin];
        }
        axes::with_margin([low, high])
    }

    /// Pixel of a value; NaN where the axis has no place for it.
    fn pixel(&self, v: f64) -> f64 {
        let [low, high] = self.range;
        let t = match self.log {
            true if v <= 0.0 => f64::NAN,
            true => (v / low).ln() / (high / low).ln(),
            false => (v - low) / (high - low),
        };
        // Far outside the picture is far enough: larger numbers lose their digits.
        self.pixels[0] + t.clamp(-1e4, 1e4) * (self.pixels[1] - self.pixels[0])
    }

    fn ticks(&self) -> Vec<(f64, String)> {
        let count = ((self.pixels[1] - self.pixels[0]).abs() / 130.0) as usize;
        match self.log {
            true => axes::log_ticks(self.range, count),
            false => axes::ticks(self.range, count),
        }
    }
}

/// A backend of plotters that draws a curve as finely as it can.
trait Paper: DrawingBackend {
    /// Draws a path; its points are pixels, whose corners lie at whole numbers and a half.
    fn curve(&mut self, points: &[[f64; 2]], style: ShapeStyle) -> Result<()>;
}

impl Paper for Canvas {
    fn curve(&mut self, points: &[[f64; 2]], style: ShapeStyle) -> Result<()> {
        let points: Vec<_> = points.iter().map(|p| p.map(|v| v + 0.5)).collect();
        let (r, g, b) = style.color.rgb();
        self.stroke(&canvas::segments(&points), f64::from(style.stroke_width), [r, g, b]);
        Ok(())
    }
}

impl Paper for SVGBackend<'_> {
    /// plotters' SVG knows whole pixels only.
    fn curve(&mut self, points: &[[f64; 2]], style: ShapeStyle) -> Result<()> {
        let points = points.iter().map(|&p| round(p));
        self.draw_path(points, &style).map_err(|error| anyhow!("drawing a line: {error}"))
    }
}

/// Draws on a backend of plotters.
struct Pen<'a, B: Paper>(&'a mut B);

fn stroke(color: RGBColor, width: u32) -> ShapeStyle {
    color.stroke_width(width)
}

fn round([x, y]: [f64; 2]) -> (i32, i32) {
    (x.round() as i32, y.round() as i32)
}

impl<B: Paper> Pen<'_, B> {
    fn plot(&mut self, plot: &Plot) -> Result<()> {
        let xs = || plot.series.iter().flat_map(|s| s.points.iter().map(|p| p[0]));
        let shown = |s: &&Series| s.mark != Mark::Vertical;
        let ys = || plot.series.iter().filter(shown).flat_map(|s| s.points.iter().map(|p| p[1]));
        let ranges = [Scale::range(&plot.x, xs()), Scale::range(&plot.y, ys())];
        let names: Vec<&Series> = match plot.series.len() {
            0 | 1 => Vec::new(),
            _ => plot.series.iter().collect(),
        };
        let legend = legend_size(&names);
        let (mut x, mut y) = scales(plot, ranges, 0.0);
        let mut place = corner(plot, &x, &y, legend);
        if place.is_none() {
            (x, y) = scales(plot, ranges, legend[0] + GAP);
            place = Some([x.pixels[1] + GAP, y.pixels[1]]);
        }
        self.rect([0.0, 0.0, f64::from(SIZE[0]), f64::from(SIZE[1])], RGBColor(255, 255, 255))?;
        self.axes(plot, &x, &y)?;
        for (n, series) in plot.series.iter().enumerate() {
            self.series(series, COLORS[n % COLORS.len()], &x, &y)?;
        }
        self.frame(&x, &y)?;
        match place {
            Some(place) if !names.is_empty() => self.legend(&names, place, legend),
            _ => Ok(()),
        }
    }

    /// Grid lines, tick labels, axis labels and title.
    fn axes(&mut self, plot: &Plot, x: &Scale, y: &Scale) -> Result<()> {
        let ([left, right], [bottom, top]) = (x.pixels, y.pixels);
        for (v, label) in x.ticks() {
            let at = x.pixel(v).round();
            self.path(&[[at, bottom], [at, top]], stroke(GRID, 1))?;
            self.text(&label, [at, bottom + 0.7 * GAP], TEXT[0], Hang::Below)?;
        }
        let mut widest = 0.0_f64;
        for (v, label) in y.ticks() {
            let at = y.pixel(v).round();
            self.path(&[[left, at], [right, at]], stroke(GRID, 1))?;
            self.text(&label, [left - 0.7 * GAP, at], TEXT[0], Hang::Left)?;
            widest = widest.max(font::width(&label, TEXT[0]));
        }
        let middle = [0.5 * (left + right), 0.5 * (top + bottom)];
        let below = bottom + 1.4 * GAP + TEXT[0];
        self.text(&plot.x.label, [middle[0], below], TEXT[1], Hang::Below)?;
        let beside = left - widest - 1.7 * GAP - 0.5 * TEXT[1];
        self.text(&plot.y.label, [beside, middle[1]], TEXT[1], Hang::Upwards)?;
        self.text(&plot.title, [middle[0], GAP], TEXT[2], Hang::Below)
    }

    fn series(&mut self, series: &Series, color: RGBColor, x: &Scale, y: &Scale) -> Result<()> {
        let ([left, right], [bottom, top]) = (x.pixels, y.pixels);
        let clip = [left, top, right, bottom];
        let points: Vec<[f64; 2]> =
            series.points.iter().map(|p| [x.pixel(p[0]), y.pixel(p[1])]).collect();
        match series.mark {
            Mark::Dots => {
                let radius = if points.len() > 2000 { 3 } else { 6 };
                for &p in points.iter().filter(|&&p| holds(clip, p)) {
                    self.dot(p, radius, color)?;
                }
            }
            Mark::Vertical => {
                for p in points.iter().filter(|p| (left..=right).contains(&p[0])) {
                    self.dashes(&[[p[0], bottom], [p[0], top]], color, [14.0, 8.0])?;
                }
            }
            Mark::Line | Mark::Dashed => {
                for run in runs(&points, clip) {
                    match run.as_slice() {
                        [lone] => self.dot(*lone, 4, color)?,
                        line if series.mark == Mark::Dashed => {
                            self.dashes(line, color, [18.0, 12.0])?;
                        }
                        line => self.path(line, stroke(color, 3))?,
                    }
                }
            }
            _ => return Err(anyhow!("plots have no mark {:?}", series.mark)),
        }
        Ok(())
    }

    /// Dashes `[on, off]` pixels long along a path.
    fn dashes(&mut self, path: &[[f64; 2]], color: RGBColor, [on, off]: [f64; 2]) -> Result<()> {
        let (mut drawn, mut left) = (true, on);
        let mut dash = vec![path[0]];
        for pair in path.windows(2) {
            let length = (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
            let mut done = 0.0;
            while length - done > left {
                done += left;
                let t = done / length;
                let p = [0, 1].map(|c| pair[0][c] + t * (pair[1][c] - pair[0][c]));
                dash.push(p);
                if drawn {
                    self.path(&dash, stroke(color, 3))?;
                }
                dash = vec![p];
                drawn = !drawn;
                left = if drawn { on } else { off };
            }
            left -= length - done;
            dash.push(pair[1]);
        }
        if drawn { self.path(&dash, stroke(color, 3)) } else { Ok(()) }
    }

    fn frame(&mut self, x: &Scale, y: &Scale) -> Result<()> {
        let ([left, right], [bottom, top]) = (x.pixels, y.pixels);
        let corners = [[left, top], [right, top], [right, bottom], [left, bottom], [left, top]];
        let [r, g, b] = FRAME;
        self.path(&corners, stroke(RGBColor(r, g, b), 2))
    }

    /// A box with a sample and the name of each curve, its corner at `place`.
    fn legend(&mut self, names: &[&Series], [left, top]: [f64; 2], [w, h]: [f64; 2]) -> Result<()> {
        self.rect([left, top, left + w, top + h], RGBColor(255, 255, 255))?;
        let corners = [[0.0, 0.0], [w, 0.0], [w, h], [0.0, h], [0.0, 0.0]];
        self.path(&corners.map(|[x, y]| [left + x, top + y]), stroke(GRID, 2))?;
        for (n, series) in names.iter().enumerate() {
            let color = COLORS[n % COLORS.len()];
            let y = top + 0.5 * GAP + (n as f64 + 0.5) * line_height();
            let [from, to] = [[left + GAP, y], [left + GAP + SAMPLE, y]];
            match series.mark {
                Mark::Dots => self.dot([left + GAP + 0.5 * SAMPLE, y], 6, color)?,
                Mark::Dashed => self.dashes(&[from, to], color, [18.0, 12.0])?,
                Mark::Vertical => self.dashes(&[from, to], color, [14.0, 8.0])?,
                _ => self.path(&[from, to], stroke(color, 3))?,
            }
            let at = [left + 1.6 * GAP + SAMPLE, y];
            self.text(&series.label, at, TEXT[0], Hang::Right)?;
        }
        Ok(())
    }

    fn path(&mut self, points: &[[f64; 2]], style: ShapeStyle) -> Result<()> {
        self.0.curve(points, style)
    }

    fn rect(&mut self, [left, top, right, bottom]: Box4, color: RGBColor) -> Result<()> {
        self.0
            .draw_rect(round([left, top]), round([right, bottom]), &color.filled(), true)
            .map_err(|error| anyhow!("filling a box: {error}"))
    }

    fn dot(&mut self, at: [f64; 2], radius: u32, color: RGBColor) -> Result<()> {
        self.0
            .draw_circle(round(at), radius, &color.filled(), true)
            .map_err(|error| anyhow!("drawing a dot: {error}"))
    }

    fn text(&mut self, text: &str, at: [f64; 2], size: f64, hang: Hang) -> Result<()> {
        self.0
            .draw_text(text, &font::style(size, [0; 3], hang), round(at))
            .map_err(|error| anyhow!("drawing the text `{text}`: {error}"))
    }
}

/// Pixel positions of the axes; `outside` pixels are kept free on the right.
fn scales(plot: &Plot, [x_range, y_range]: [[f64; 2]; 2], outside: f64) -> (Scale, Scale) {
    let [width, height] = SIZE.map(f64::from);
    let top = if plot.title.is_empty() { 1.5 * GAP } else { 2.0 * GAP + TEXT[2] };
    let bottom = height - 2.4 * GAP - TEXT[0] - TEXT[1];
    let y = Scale { range: y_range, log: plot.y.log, pixels: [bottom.round(), top.round()] };
    let labels = y.ticks().into_iter().map(|(_, label)| font::width(&label, TEXT[0]));
    let left = labels.fold(0.0, f64::max) + TEXT[1] + 2.7 * GAP;
    // The last label of the horizontal axis may reach half its width beyond it.
    let right = width - outside - 3.0 * GAP;
    (Scale { range: x_range, log: plot.x.log, pixels: [left.round(), right.round()] }, y)
}

fn line_height() -> f64 {
    1.15 * TEXT[0]
}

/// Width and height of the legend.
fn legend_size(names: &[&Series]) -> [f64; 2] {
    let widest = names.iter().map(|s| font::width(&s.label, TEXT[0])).fold(0.0, f64::max);
    // Beyond 45 % of the picture a name is cut rather than the axes squeezed out.
    let width = (SAMPLE + 2.6 * GAP + widest).min(0.45 * f64::from(SIZE[0]));
    [width, names.len() as f64 * line_height() + GAP]
}

/// The corner where the legend covers no data, if there is one: its top left point.
fn corner(plot: &Plot, x: &Scale, y: &Scale, [w, h]: [f64; 2]) -> Option<[f64; 2]> {
    let ([left, right], [bottom, top]) = (x.pixels, y.pixels);
    let (l, r) = (left + GAP, right - GAP - w);
    let (t, b) = (top + GAP, bottom - GAP - h);
    let free = |&[cx, cy]: &[f64; 2]| {
        let area = [cx - 6.0, cy - 6.0, cx + w + 6.0, cy + h + 6.0];
        plot.series.iter().all(|series| {
            let pixel = |p: &[f64; 2]| [x.pixel(p[0]), y.pixel(p[1])];
            let points: Vec<_> = series.points.iter().map(pixel).collect();
            match series.mark {
                Mark::Vertical => points.iter().all(|p| p[0] < area[0] || p[0] > area[2]),
                Mark::Dots => !points.iter().any(|&p| holds(area, p)),
                _ => runs(&points, area).is_empty(),
            }
        })
    };
    if r < l || b < t {
        return None;
    }
    [[r, t], [l, t], [r, b], [l, b]].into_iter().find(free)
}

fn holds([left, top, right, bottom]: Box4, [x, y]: [f64; 2]) -> bool {
    (left..=right).contains(&x) && (top..=bottom).contains(&y)
}

/// The parts of a path inside a box, broken at points that are not finite.
fn runs(points: &[[f64; 2]], area: Box4) -> Vec<Vec<[f64; 2]>> {
    let mut runs: Vec<Vec<[f64; 2]>> = Vec::new();
    let finite = |p: [f64; 2]| p[0].is_finite() && p[1].is_finite();
    for n in 0..points.len() {
        let lone = |m: usize| points.get(m).is_none_or(|&p| !finite(p));
        if finite(points[n]) && lone(n.wrapping_sub(1)) && lone(n + 1) && holds(area, points[n]) {
            runs.push(vec![points[n]]);
        }
        let Some(&next) = points.get(n + 1) else { break };
        if !finite(points[n]) || !finite(next) {
            continue;
        }
        if let Some([a, b]) = clip([points[n], next], area) {
            match runs.last_mut() {
                Some(run) if n > 0 && run.last() == Some(&a) => run.push(b),
                _ => runs.push(vec![a, b]),
            }
        }
    }
    runs
}

/// The part of a segment inside a box (Liang and Barsky 1984).
fn clip([a, b]: [[f64; 2]; 2], [left, top, right, bottom]: Box4) -> Option<[[f64; 2]; 2]> {
    let d = [b[0] - a[0], b[1] - a[1]];
    let (mut t0, mut t1) = (0.0_f64, 1.0_f64);
    let edges =
        [(-d[0], a[0] - left), (d[0], right - a[0]), (-d[1], a[1] - top), (d[1], bottom - a[1])];
    for (p, q) in edges {
        if p == 0.0 && q < 0.0 {
            return None;
        } else if p < 0.0 {
            t0 = t0.max(q / p);
        } else if p > 0.0 {
            t1 = t1.min(q / p);
        }
    }
    let at = |t: f64| {
        if t == 0.0 {
            a
        } else if t == 1.0 {
            b
        } else {
            [a[0] + t * d[0], a[1] + t * d[1]]
        }
    };
    (t0 <= t1).then(|| [at(t0), at(t1)])
}
