//! Contours as DXF polylines, for CAD and laser cutters.

use anyhow::Result;
use solvers::isosurface::Polyline;
use std::io::Write;

/// Unit of a drawing's numbers (`$INSUNITS`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Unit {
    /// None: cells.
    #[default]
    None = 0,
    /// Millimetres.
    Millimetre = 4,
    /// Metres.
    Metre = 6,
}

/// Writes `lines` as DXF R12 polylines on layer 0; closed ones are marked as such. y grows
/// upwards there, so that `height` (of the picture, in the unit of the points) turns it around.
/// Lines of fewer than two points, or with points that are not finite, are left out.
///
/// # Errors
/// If `out` fails.
pub fn write(lines: &[Polyline], height: f64, unit: Unit, out: &mut impl Write) -> Result<()> {
    let drawn =
        |l: &&Polyline| l.points.len() >= 2 && l.points.iter().flatten().all(|v| v.is_finite());
    let lines: Vec<&Polyline> = lines.iter().filter(drawn).collect();
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for [x, y] in lines.iter().flat_map(|l| &l.points) {
        let p = [*x, height - y];
        low = [0, 1].map(|n| low[n].min(p[n]));
        high = [0, 1].map(|n| high[n].max(p[n]));
    }
    write!(out, "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n")?;
    write!(out, "9\n$INSUNITS\n70\n{}\n", unit as u8)?;
    if !lines.is_empty() {
        write!(out, "9\n$EXTMIN\n10\n{}\n20\n{}\n30\n0\n", low[0], low[1])?;
        write!(out, "9\n$EXTMAX\n10\n{}\n20\n{}\n30\n0\n", high[0], high[1])?;
    }
    write!(out, "0\nENDSEC\n0\nSECTION\n2\nENTITIES\n")?;
    for line in lines {
        // 66: vertices follow; 70: 1 where the line is closed.
        write!(
            out,
            "0\nPOLYLINE\n8\n0\n66\n1\n10\n0\n20\n0\n30\n0\n70\n{}\n",
            u8::from(line.closed)
        )?;
        for [x, y] in &line.points {
            write!(out, "0\nVERTEX\n8\n0\n10\n{x}\n20\n{}\n30\n0\n", height - y)?;
        }
        write!(out, "0\nSEQEND\n8\n0\n")?;
    }
    Ok(write!(out, "0\nENDSEC\n0\nEOF\n")?)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers after a group code within polylines.
    fn values(text: &str, code: &str) -> Vec<f64> {
        let entities = text.split("ENTITIES\n").nth(1).unwrap();
        let words: Vec<&str> = entities.split("VERTEX\n8\n0\n").skip(1).collect();
        let of = |part: &&str| {
            let lines: Vec<&str> = part.lines().collect();
            let pair = lines.chunks(2).find(|pair| pair[0] == code).unwrap();
            pair[1].parse().unwrap()
        };
        words.iter().map(of).collect()
    }

    #[test]
    fn the_drawing_is_turned_around_and_keeps_its_points() {
        let points = vec![[1.0, 2.0], [3.0, 2.5], [1.0 / 3.0, 7.0]];
        let bad = Polyline { points: vec![[f64::NAN; 2]; 3], closed: true };
        let open = Polyline { points: points.clone(), closed: false };
        let closed = Polyline { points, closed: true };
        let mut out = Vec::new();
        write(&[closed, bad, open], 40.0, Unit::Millimetre, &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert_eq!(values(&text, "10"), [1.0, 3.0, 1.0 / 3.0, 1.0, 3.0, 1.0 / 3.0]);
        assert_eq!(values(&text, "20"), [38.0, 37.5, 33.0, 38.0, 37.5, 33.0]);
        let closed = |flag| text.matches(&format!("\n70\n{flag}\n0\nVERTEX")).count();
        assert_eq!((closed(1), closed(0)), (1, 1));
        assert!(text.contains("$INSUNITS\n70\n4\n") && text.ends_with("0\nENDSEC\n0\nEOF\n"));
        assert!(text.contains("$EXTMIN\n10\n0.3333333333333333\n20\n33\n"), "{text}");
        // Group codes and values alternate.
        assert!(text.lines().step_by(2).all(|code| code.parse::<u16>().is_ok()));
    }
}
