//! Area and perimeter, volume and surface of the linear reconstruction.

use crate::isosurface::{Frame, Samples, Visit, cut, march};
use crate::{Boundary, Field};

/// (area, perimeter) of `phi < 0`, or their likes in one and three axes.
pub(super) fn content(phi: &Field, boundary: Boundary) -> (f64, f64) {
    let samples = Samples::new(phi, 0.0, Frame::whole_domain(boundary), 0.0);
    match phi.grid().dim() {
        1 => on_line(&samples),
        2 => in_plane(&samples),
        _ => {
            let mut sums = Sums { samples: &samples, volume: 0.0, area: 0.0 };
            march(&samples, &mut sums);
            (sums.volume, sums.area)
        }
    }
}

fn on_line(samples: &Samples) -> (f64, f64) {
    let (mut length, mut ends) = (0.0, 0.0);
    for (v, x) in samples.values.windows(2).zip(samples.coordinates[2].windows(2)) {
        let part = match (v[0] < 0.0, v[1] < 0.0) {
            (true, true) => 1.0,
            (false, false) => 0.0,
            (true, false) => v[0] / (v[0] - v[1]),
            (false, true) => v[1] / (v[1] - v[0]),
        };
        length += part * (x[1] - x[0]);
        ends += if (v[0] < 0.0) == (v[1] < 0.0) { 0.0 } else { 1.0 };
    }
    (length, ends)
}

fn in_plane(samples: &Samples) -> (f64, f64) {
    let [_, ny, nx] = samples.shape;
    let [_, y, x] = &samples.coordinates;
    let (mut area, mut perimeter) = (0.0, 0.0);
    for j in 0..ny - 1 {
        let low = &samples.values[j * nx..][..nx];
        let high = &samples.values[(j + 1) * nx..][..nx];
        // Sums row by row lose fewer digits.
        let (mut row_area, mut row_perimeter) = (0.0, 0.0);
        for i in 0..nx - 1 {
            let v = [low[i], low[i + 1], high[i + 1], high[i]];
            let count = v.iter().filter(|&&v| v < 0.0).count();
            if count == 0 {
                continue;
            }
            let size = [x[i + 1] - x[i], y[j + 1] - y[j]];
            let (part, length) = if count == 4 { (1.0, 0.0) } else { in_square(v, size) };
            row_area += part * size[0] * size[1];
            row_perimeter += length;
        }
        area += row_area;
        perimeter += row_perimeter;
    }
    (area, perimeter)
}

/// Inside fraction of a cut rectangle and the length of the contour in it.
fn in_square(v: [f64; 4], size: [f64; 2]) -> (f64, f64) {
    const CORNERS: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let crossing = |m: usize| {
        let (p, q) = (CORNERS[m], CORNERS[(m + 1) % 4]);
        let t = v[m] / (v[m] - v[(m + 1) % 4]);
        [p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])]
    };
    let cut = cut(v);
    let mut length = 0.0;
    let mut twice = 0.0;
    for &(from, to) in &cut.segments[..cut.count] {
        let (p, q) = (crossing(from), crossing(to));
        length += ((q[0] - p[0]) * size[0]).hypot((q[1] - p[1]) * size[1]);
        if cut.apart {
            // The triangle cut off at corner `from`.
            let o = CORNERS[from];
            twice += ((p[0] - o[0]) * (q[1] - o[1]) - (q[0] - o[0]) * (p[1] - o[1])).abs();
        }
    }
    if cut.apart {
        return (0.5 * twice, length);
    }
    // All inside corners and crossings, counter-clockwise, bound one polygon.
    let mut points = [[0.0; 2]; 8];
    let mut n = 0;
    for m in 0..4 {
        if v[m] < 0.0 {
            points[n] = CORNERS[m];
            n += 1;
        }
        if (v[m] < 0.0) != (v[(m + 1) % 4] < 0.0) {
            points[n] = crossing(m);
            n += 1;
        }
    }
    let area = (0..n).map(|m| {
        let (p, q) = (points[m], points[(m + 1) % n]);
        p[0] * q[1] - q[0] * p[1]
    });
    (0.5 * area.sum::<f64>(), length)
}

struct Sums<'a> {
    samples: &'a Samples,
    volume: f64,
    area: f64,
}

impl Sums<'_> {
    fn box_volume(&self, corner: usize) -> f64 {
        let [_, ny, nx] = self.samples.shape;
        let (low, high) =
            (self.samples.position(corner), self.samples.position(corner + 1 + nx + nx * ny));
        (0..3).map(|m| high[m] - low[m]).product()
    }
}

impl Visit for Sums<'_> {
    fn triangle(&mut self, corners: [(usize, usize); 3]) {
        let [p, q, r] = corners.map(|(a, b)| self.samples.crossing(a, b, 0.0));
        let (a, b): ([f64; 3], [f64; 3]) =
            (std::array::from_fn(|m| q[m] - p[m]), std::array::from_fn(|m| r[m] - p[m]));
        let normal =
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        self.area += 0.5 * normal.iter().map(|c| c * c).sum::<f64>().sqrt();
    }

    fn part(&mut self, fraction: f64, box_corner: usize) {
        self.volume += fraction * self.box_volume(box_corner) / 6.0;
    }

    fn full(&mut self, box_corner: usize) {
        self.volume += self.box_volume(box_corner);
    }
}
