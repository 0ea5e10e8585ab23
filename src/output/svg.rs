//! Contours as SVG paths.

use anyhow::Result;
use solvers::isosurface::Polyline;
use std::io::Write;

/// How contours are drawn as SVG.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Style {
    /// Width of a line around the black regions, in the unit of the points; open lines
    /// are drawn with this width too, or 0.5 % of the picture's smaller side if it is 0.
    pub outline: f64,
}

/// Draws `lines` as ink: one path, closed lines filled black by the even-odd rule (a line
/// within a line is a hole), open lines stroked.
///
/// `size` is width and height of the picture in the unit of the points (cells or length);
/// y grows downwards, as in images. Numbers keep 1e-4 of the picture's larger side / 100.
///
/// # Errors
/// If `out` fails.
pub fn write_svg(
    lines: &[Polyline],
    size: [f64; 2],
    style: Style,
    out: &mut impl Write,
) -> Result<()> {
    let unit = 1e-6 * size[0].max(size[1]);
    let number = |v: f64| short(v, unit);
    let [w, h] = size.map(number);
    // On a screen: 800 pixels for the larger side.
    let pixels = size.map(|v| (800.0 * v / size[0].max(size[1])).round());
    writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\" viewBox=\"0 0 {w} {h}\">",
        pixels[0], pixels[1]
    )?;
    writeln!(out, "<rect width=\"{w}\" height=\"{h}\" fill=\"white\"/>")?;
    let path = |line: &Polyline| {
        let mut text = String::new();
        for (n, p) in line.points.iter().enumerate() {
            text += if n == 0 {
                "M"
            } else if n == 1 {
                "L"
            } else {
                " "
            };
            text += &format!("{} {}", number(p[0]), number(p[1]));
        }
        if line.closed { text + "Z" } else { text }
    };
    let drawn =
        |l: &&Polyline| l.points.len() >= 2 && l.points.iter().flatten().all(|v| v.is_finite());
    let closed: Vec<String> = lines.iter().filter(drawn).filter(|l| l.closed).map(path).collect();
    if !closed.is_empty() {
        let outline = match style.outline > 0.0 {
            true => format!(
                " stroke=\"black\" stroke-width=\"{}\" stroke-linejoin=\"round\"",
                number(style.outline)
            ),
            false => String::new(),
        };
        let paths = closed.join("\n");
        writeln!(out, "<path fill=\"black\" fill-rule=\"evenodd\"{outline} d=\"{paths}\"/>")?;
    }
    let width = if style.outline > 0.0 { style.outline } else { 0.005 * size[0].min(size[1]) };
    for line in lines.iter().filter(drawn).filter(|l| !l.closed) {
        let width = number(width);
        writeln!(
            out,
            "<path fill=\"none\" stroke=\"black\" stroke-width=\"{width}\" d=\"{}\"/>",
            path(line)
        )?;
    }
    Ok(writeln!(out, "</svg>")?)
}

/// `v` with as many decimals as `unit` has, without trailing zeros.
fn short(v: f64, unit: f64) -> String {
    let decimals = (-unit.log10()).ceil().clamp(0.0, 12.0) as usize;
    let text = format!("{v:.decimals$}");
    let text =
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".into() } else { text.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn svg(lines: &[Polyline], style: Style) -> String {
        let mut out = Vec::new();
        write_svg(lines, [80.0, 40.0], style, &mut out).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn contours_become_short_paths() {
        let square = Polyline {
            points: vec![[1.0, 2.0], [3.25, 2.0], [3.25, 4.123_456_789], [-1e-12, 4.0]],
            closed: true,
        };
        let open = Polyline { points: vec![[0.0, 0.0], [5.5, 5.0]], closed: false };
        let bad = Polyline { points: vec![[0.0, f64::NAN], [5.5, 5.0]], closed: true };
        let text = svg(&[square, open, bad], Style::default());
        assert!(text.contains("viewBox=\"0 0 80 40\""), "{text}");
        assert!(text.contains("d=\"M1 2L3.25 2 3.25 4.12346 0 4Z\""), "{text}");
        assert!(text.contains("stroke-width=\"0.2\" d=\"M0 0L5.5 5\""), "{text}");
        assert!(!text.contains("NaN"), "{text}");
    }
}
