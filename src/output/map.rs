//! Things laid out in the plane, with pictures of some of them around: PNG and SVG from one list
//! of shapes.

use super::{
    axes,
    canvas::Canvas,
    colormap::Rgb,
    font::{self, Hang},
    plot,
    surface::{self, Look},
};
use anyhow::Result;
use base64::{Engine as _, engine::general_purpose::STANDARD};
use patterns::{Map, MapPoint};
use rayon::prelude::*;
use std::{collections::BTreeMap, fmt::Write as _, io::Write};

/// Side of a picture, pixels.
const SIDE: usize = 170;
/// Pictures in the upper and the lower row, and in the columns between them.
const SLOTS: [usize; 2] = [10, 5];
/// Space between things, pixels.
const GAP: usize = 10;
/// Size of tick labels, of the legend and of the title, pixels.
const TEXT: [f64; 3] = [22.0, 24.0, 32.0];
/// Height of the title and of the legend with their space, pixels.
const BANDS: [usize; 2] = [58, 46];
/// Room for tick labels and the label of an axis, pixels.
const AXIS: f64 = 84.0;
/// Radius of a point, pixels.
const RADIUS: f64 = 5.0;
const LEADER: Rgb = [150, 150, 150];
const LONE: Rgb = [0, 0, 0];

/// Writes a map as PNG.
///
/// # Errors
/// If `out` or the font fails.
pub fn write_png(map: &Map, out: &mut impl Write) -> Result<()> {
    let sheet = Sheet::new(map)?;
    let [w, h] = Sheet::SIZE;
    let mut canvas = Canvas::new(w, h);
    for mark in &sheet.marks {
        match mark {
            Mark::Line(ends, width, color) => canvas.stroke(&[*ends], *width, *color),
            Mark::Dot { at, radius, color, .. } => {
                canvas.stroke(&[[*at, *at]], 2.0 * radius, *color);
            }
            Mark::Text(text, at, size, hang) => canvas.text(text, *at, *size, *hang)?,
            Mark::Picture { picture, left, top, .. } => {
                let [pw, ph] = picture.size();
                for (y, row) in picture.pixels().chunks_exact(3 * pw).enumerate().take(ph) {
                    canvas.row_mut(*left, top + y, pw).copy_from_slice(row);
                }
            }
        }
    }
    canvas.write_png(out)
}

/// Writes a map as SVG: what a point is shows under the pointer.
///
/// # Errors
/// If `out` or the font fails.
pub fn write_svg(map: &Map, out: &mut impl Write) -> Result<()> {
    let sheet = Sheet::new(map)?;
    let [w, h] = Sheet::SIZE;
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" \
         viewBox=\"0 0 {w} {h}\" font-family=\"DejaVu Sans, sans-serif\">\n\
         <rect width=\"{w}\" height=\"{h}\" fill=\"white\"/>\n"
    );
    for mark in &sheet.marks {
        match mark {
            Mark::Line([a, b], width, color) => writeln!(
                text,
                "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"{}\" \
                 stroke-width=\"{width}\"/>",
                a[0],
                a[1],
                b[0],
                b[1],
                hex(*color)
            )?,
            Mark::Dot { at, radius, color, caption } => writeln!(
                text,
                "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{radius}\" fill=\"{}\">{}</circle>",
                at[0],
                at[1],
                hex(*color),
                title(caption)
            )?,
            Mark::Text(words, at, size, hang) => svg_text(&mut text, words, *at, *size, *hang)?,
            Mark::Picture { picture, left, top, caption } => {
                let mut png = Vec::new();
                picture.write_png(&mut png)?;
                let [pw, ph] = picture.size();
                writeln!(
                    text,
                    "<image x=\"{left}\" y=\"{top}\" width=\"{pw}\" height=\"{ph}\" \
                     href=\"data:image/png;base64,{}\">{}</image>",
                    STANDARD.encode(png),
                    title(caption)
                )?;
            }
        }
    }
    text += "</svg>\n";
    Ok(out.write_all(text.as_bytes())?)
}

/// What is drawn, in pixels from the upper left corner.
enum Mark {
    Line([[f64; 2]; 2], f64, Rgb),
    Dot { at: [f64; 2], radius: f64, color: Rgb, caption: String },
    Text(String, [f64; 2], f64, Hang),
    Picture { picture: Canvas, left: usize, top: usize, caption: String },
}

struct Sheet {
    marks: Vec<Mark>,
}

impl Sheet {
    /// Width and height, pixels.
    const SIZE: [usize; 2] =
        [SLOTS[0] * (SIDE + GAP) + GAP, BANDS[0] + (SLOTS[1] + 2) * (SIDE + GAP) + GAP + BANDS[1]];

    fn new(map: &Map) -> Result<Self> {
        let mut sheet = Self { marks: Vec::new() };
        let [w, _] = Self::SIZE;
        sheet.text(&map.title, [0.5 * w as f64, 14.0], TEXT[2], Hang::Below);
        let frame = frame();
        let scale = Scale::new(&map.points, frame);
        sheet.axes(map, frame, &scale);
        let shown: Vec<&MapPoint> = map.points.iter().filter(|p| p.surface.is_some()).collect();
        let places: Vec<[f64; 2]> = shown.iter().map(|p| scale.place(p.position)).collect();
        let slots = assign(&places, &slots());
        for (place, slot) in places.iter().zip(&slots) {
            let middle = [0, 1].map(|c| slot[c] as f64 + 0.5 * SIDE as f64);
            sheet.line([middle, *place], 1.5, LEADER);
        }
        for point in &map.points {
            let (at, color) = (scale.place(point.position), color(point.group));
            let radius = if point.surface.is_some() { 1.7 * RADIUS } else { RADIUS };
            sheet.marks.push(Mark::Dot { at, radius, color, caption: point.caption.clone() });
        }
        let look = Look { size: SIDE, ..Look::default() };
        let pictures: Result<Vec<Option<Canvas>>> = shown
            .par_iter()
            .map(|p| p.surface.as_ref().map(|s| surface::draw(s, &look)).transpose())
            .collect();
        for ((picture, point), [left, top]) in pictures?.into_iter().zip(&shown).zip(slots) {
            let Some(picture) = picture else { continue };
            let caption = point.caption.clone();
            sheet.marks.push(Mark::Picture { picture, left, top, caption });
            sheet.border([left, top], color(point.group));
        }
        sheet.legend(&map.points);
        Ok(sheet)
    }

    fn line(&mut self, ends: [[f64; 2]; 2], width: f64, color: Rgb) {
        self.marks.push(Mark::Line(ends, width, color));
    }

    fn text(&mut self, text: &str, at: [f64; 2], size: f64, hang: Hang) {
        self.marks.push(Mark::Text(text.into(), at, size, hang));
    }

    fn border(&mut self, [left, top]: [usize; 2], color: Rgb) {
        let [x, y] = [left as f64, top as f64];
        let side = SIDE as f64;
        let corners = [[x, y], [x + side, y], [x + side, y + side], [x, y + side], [x, y]];
        for pair in corners.windows(2) {
            self.line([pair[0], pair[1]], 3.0, color);
        }
    }

    /// Frame, ticks and labels.
    fn axes(&mut self, map: &Map, [left, top, right, bottom]: [f64; 4], scale: &Scale) {
        let corners = [[left, top], [right, top], [right, bottom], [left, bottom], [left, top]];
        for pair in corners.windows(2) {
            self.line([pair[0], pair[1]], 2.0, plot::FRAME);
        }
        for (v, label) in axes::ticks(scale.ranges[0], 7) {
            let x = scale.place([v, 0.0])[0];
            self.line([[x, bottom], [x, bottom + 7.0]], 2.0, plot::FRAME);
            self.text(&label, [x, bottom + 12.0], TEXT[0], Hang::Below);
        }
        for (v, label) in axes::ticks(scale.ranges[1], 5) {
            let y = scale.place([0.0, v])[1];
            self.line([[left - 7.0, y], [left, y]], 2.0, plot::FRAME);
            self.text(&label, [left - 12.0, y], TEXT[0], Hang::Left);
        }
        let middle = [0.5 * (left + right), 0.5 * (top + bottom)];
        self.text(&map.axes[0], [middle[0], bottom + 44.0], TEXT[1], Hang::Below);
        self.text(&map.axes[1], [left - AXIS + 18.0, middle[1]], TEXT[1], Hang::Upwards);
    }

    /// The groups and how many there are of each, below everything.
    fn legend(&mut self, points: &[MapPoint]) {
        let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
        for point in points {
            *counts.entry(point.group.unwrap_or(usize::MAX)).or_default() += 1;
        }
        let [w, h] = Self::SIZE.map(|n| n as f64);
        let (mut x, y) = (3.0 * GAP as f64, h - 0.5 * BANDS[1] as f64);
        for (group, count) in counts {
            let group = (group != usize::MAX).then_some(group);
            let name = group.map_or("no cluster".into(), |g| format!("cluster {}", g + 1));
            let label = format!("{name} ({count})");
            let wide = font::width(&label, TEXT[1]);
            if x + wide + 30.0 > w {
                self.text("...", [x, y], TEXT[1], Hang::Right);
                return;
            }
            let (radius, color) = (1.5 * RADIUS, color(group));
            self.marks.push(Mark::Dot { at: [x, y], radius, color, caption: label.clone() });
            self.text(&label, [x + 16.0, y], TEXT[1], Hang::Right);
            x += wide + 48.0;
        }
    }
}

/// Left, top, right and bottom of the axes.
fn frame() -> [f64; 4] {
    let [w, h] = Sheet::SIZE;
    let room = SIDE + 3 * GAP;
    let [left, top] = [room as f64 + AXIS, (BANDS[0] + room) as f64];
    [left, top, (w - room) as f64, (h - BANDS[1] - room) as f64 - AXIS]
}

/// From the map to pixels, both axes alike: distances in the map are what counts.
struct Scale {
    ranges: [[f64; 2]; 2],
    frame: [f64; 4],
}

impl Scale {
    fn new(points: &[MapPoint], frame: [f64; 4]) -> Self {
        let pixels = [frame[2] - frame[0], frame[3] - frame[1]];
        let data = [0, 1].map(|c| axes::data_range(points.iter().map(|p| p.position[c]), false));
        // A pixel in units of the map, as the tighter axis allows.
        let pixel = [0, 1].map(|c| 1.08 * (data[c][1] - data[c][0]) / pixels[c]);
        let pixel = pixel[0].max(pixel[1]);
        let ranges = [0, 1].map(|c| {
            let (middle, half) = (0.5 * (data[c][0] + data[c][1]), 0.5 * pixel * pixels[c]);
            [middle - half, middle + half]
        });
        Self { ranges, frame }
    }

    fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [left, top, right, bottom] = self.frame;
        let part = |v: f64, [low, high]: [f64; 2]| (v - low) / (high - low);
        let [u, v] = [part(x, self.ranges[0]), part(y, self.ranges[1])];
        [left + u * (right - left), bottom + v * (top - bottom)]
    }
}

/// Upper left corners of the places for pictures, clockwise from the upper left.
fn slots() -> Vec<[usize; 2]> {
    let [across, down] = SLOTS;
    let at = |column: usize, row: usize| {
        [GAP + column * (SIDE + GAP), BANDS[0] + GAP + row * (SIDE + GAP)]
    };
    let upper = (0..across).map(|c| at(c, 0));
    let right = (0..down).map(|r| at(across - 1, r + 1));
    let lower = (0..across).rev().map(|c| at(c, down + 1));
    let left = (0..down).rev().map(|r| at(0, r + 1));
    upper.chain(right).chain(lower).chain(left).collect()
}

/// A slot for each place: in the order of their angles around the middle of all places, so that
/// few lines cross, turned so that the lines are short.
fn assign(places: &[[f64; 2]], slots: &[[usize; 2]]) -> Vec<[usize; 2]> {
    let n = places.len().min(slots.len());
    if n == 0 {
        return Vec::new();
    }
    let even: Vec<[usize; 2]> = (0..n).map(|k| slots[k * slots.len() / n]).collect();
    let middle = [0, 1].map(|c| places.iter().map(|p| p[c]).sum::<f64>() / places.len() as f64);
    let angle = |p: [f64; 2]| (p[1] - middle[1]).atan2(p[0] - middle[0]);
    let center = |s: [usize; 2]| s.map(|v| v as f64 + 0.5 * SIDE as f64);
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| angle(places[a]).total_cmp(&angle(places[b])));
    let length = |turn: usize| -> f64 {
        let pair = |(k, &p): (usize, &usize)| {
            let slot = center(even[(k + turn) % n]);
            (places[p][0] - slot[0]).hypot(places[p][1] - slot[1])
        };
        order.iter().enumerate().map(pair).sum()
    };
    let turn = (0..n).min_by(|&a, &b| length(a).total_cmp(&length(b))).unwrap_or(0);
    let mut assigned = vec![[0; 2]; n];
    for (k, &p) in order.iter().enumerate() {
        assigned[p] = even[(k + turn) % n];
    }
    assigned
}

fn color(group: Option<usize>) -> Rgb {
    group.map_or(LONE, |g| plot::color(g % (plot::COLORS.len() - 1)))
}

fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn title(caption: &str) -> String {
    format!("<title>{}</title>", escaped(caption))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

fn svg_text(out: &mut String, words: &str, [x, y]: [f64; 2], size: f64, hang: Hang) -> Result<()> {
    // Capitals are .73 of the size of SVG's fonts, which is 1.164 times smaller than ours.
    let size = size / 1.164;
    let (anchor, rise, turn) = match hang {
        Hang::Below => ("middle", 0.73, false),
        Hang::Left => ("end", 0.365, false),
        Hang::Right => ("start", 0.365, false),
        Hang::Upwards => ("middle", 0.365, true),
    };
    let y = if turn { y } else { y + rise * size };
    let rotate =
        if turn { format!(" transform=\"rotate(-90 {x:.1} {y:.1})\"") } else { String::new() };
    writeln!(
        out,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size:.1}\" text-anchor=\"{anchor}\"{rotate}>{}</text>",
        escaped(words)
    )?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(x: f64, y: f64, group: Option<usize>) -> MapPoint {
        let surface = (x > 0.5).then(|| patterns::Surface {
            mesh: crate::render::shapes::frame([0.0; 3], [1.0; 3], 0.1),
            ..patterns::Surface::default()
        });
        MapPoint { position: [x, y], group, caption: format!("a < {x}"), surface }
    }

    #[test]
    fn a_map_shows_every_point_with_its_caption() {
        let map = Map {
            name: "map".into(),
            title: "a map".into(),
            axes: ["x (1)".into(), "y (1)".into()],
            points: vec![point(0.0, 0.0, None), point(1.0, 2.0, Some(0)), point(0.2, 1.0, Some(1))],
        };
        let mut svg = Vec::new();
        write_svg(&map, &mut svg).unwrap();
        let svg = String::from_utf8(svg).unwrap();
        assert_eq!(svg.matches("<title>a &lt; ").count(), 4, "3 points and a picture");
        assert_eq!(svg.matches("data:image/png;base64,").count(), 1);
        let mut png = Vec::new();
        write_png(&map, &mut png).unwrap();
        let picture = image::load_from_memory(&png).unwrap().to_rgb8();
        let first = plot::color(0);
        let marked = picture.pixels().filter(|p| p.0 == first).count();
        assert!(marked > 200, "{marked} pixels of the first group's point and border");
    }

    #[test]
    fn pictures_get_places_of_their_own() {
        let places: Vec<[f64; 2]> = (0..30)
            .map(|k| [900.0 + 40.0 * f64::from(k % 7), 700.0 + 13.0 * f64::from(k)])
            .collect();
        let mut assigned = assign(&places, &slots());
        assigned.sort_unstable();
        assigned.dedup();
        assert_eq!(assigned.len(), 30);
    }
}
