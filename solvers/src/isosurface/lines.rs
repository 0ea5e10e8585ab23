//! Marching squares.

use super::samples::fraction;
use super::{Frame, Polyline, Samples};
use crate::Field;

/// The line segments in a square, from edge to edge, with the inside on their left.
///
/// Corners and edges count counter-clockwise: corners (0, 0), (1, 0), (1, 1),
/// (0, 1); edge m runs from corner m to corner m + 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cut {
    pub segments: [(usize, usize); 2],
    pub count: usize,
    /// Whether two opposite inside corners are cut off each by itself.
    pub apart: bool,
}

/// Cuts a square with values `v` at its corners.
///
/// Two opposite inside corners are joined if the bilinear interpolant is below 0
/// at its saddle (asymptotic decider, Nielson & Hamann 1991).
pub(crate) fn cut(v: [f64; 4]) -> Cut {
    let inside = v.map(|v| v < 0.0);
    let next = |m: usize| (m + 1) % 4;
    let mut leave = [0; 2];
    let mut enter = [0; 2];
    let (mut left, mut entered) = (0, 0);
    for m in 0..4 {
        match (inside[m], inside[next(m)]) {
            (true, false) => {
                leave[left] = m;
                left += 1;
            }
            (false, true) => {
                enter[entered] = m;
                entered += 1;
            }
            _ => {}
        }
    }
    if left < 2 {
        return Cut { segments: [(leave[0], enter[0]), (0, 0)], count: left, apart: false };
    }
    // All four edges are cut: an inside corner m is entered on edge m - 1 and left on edge m.
    let first = if inside[0] { 0 } else { 1 };
    let (p, q) = (v[first], v[first + 2]);
    let (r, s) = (v[next(first)], v[(first + 3) % 4]);
    // Saddle value (p q - r s) / (p + q - r - s), where the denominator is below 0.
    let joined = r.is_finite() && s.is_finite() && p * q - r * s > 0.0;
    let before = |m: usize| (m + 3) % 4;
    let segments = if joined {
        [(first, next(first)), (next(next(first)), before(first))]
    } else {
        [(first, before(first)), (first + 2, next(first))]
    };
    Cut { segments, count: 2, apart: !joined }
}

/// Level lines of a plane field, ended at the outermost nodes; the inside `phi < level` on the left.
///
/// Marching squares with linear interpolation on the edges. Open lines come
/// first, each in the order of its first cell. Of a field in space the lines of
/// its first plane; a field on a line has none.
pub fn contour_lines(phi: &Field, level: f64) -> Vec<Polyline> {
    join(&Samples::new(phi, level, Frame::Nodes, 0.0))
}

/// Borders of the regions `phi < level`, closed along the border of the grid, half a cell
/// beyond the outermost nodes. Their areas sum up to the area of `phi < level`.
pub fn closed_contours(phi: &Field, level: f64) -> Vec<Polyline> {
    join(&Samples::new(phi, level, Frame::Capped, 0.0))
}

const NONE: u32 = u32::MAX;

/// Segments of all squares, joined where they share an edge.
fn join(samples: &Samples) -> Vec<Polyline> {
    let [_, ny, nx] = samples.shape;
    // Edge 2 n runs from node n along x, edge 2 n + 1 along y.
    let mut next = vec![NONE; 2 * nx * ny];
    let mut reached = vec![false; 2 * nx * ny];
    let mut starts = Vec::new();
    for j in 0..ny.saturating_sub(1) {
        let low = &samples.values[j * nx..][..nx];
        let high = &samples.values[(j + 1) * nx..][..nx];
        for i in 0..nx.saturating_sub(1) {
            let v = [low[i], low[i + 1], high[i + 1], high[i]];
            let sign = v[0] < 0.0;
            if v[1..].iter().all(|&v| (v < 0.0) == sign) {
                continue;
            }
            let n = j * nx + i;
            let edge = [2 * n, 2 * (n + 1) + 1, 2 * (n + nx), 2 * n + 1];
            let cut = cut(v);
            for &(from, to) in &cut.segments[..cut.count] {
                next[edge[from]] = edge[to] as u32;
                reached[edge[to]] = true;
                starts.push(edge[from]);
            }
        }
    }
    let mut lines = Vec::new();
    for &start in starts.iter().filter(|&&e| !reached[e]) {
        lines.push(follow(samples, &mut next, start, false));
    }
    for &start in &starts {
        if next[start] != NONE {
            lines.push(follow(samples, &mut next, start, true));
        }
    }
    lines
}

/// Takes the line from edge `start` out of `next`.
fn follow(samples: &Samples, next: &mut [u32], start: usize, closed: bool) -> Polyline {
    let mut points = vec![point(samples, start)];
    let mut edge = start;
    loop {
        let following = std::mem::replace(&mut next[edge], NONE);
        if following == NONE || following as usize == start {
            break;
        }
        edge = following as usize;
        let p = point(samples, edge);
        if points.last() != Some(&p) {
            points.push(p);
        }
    }
    if closed && points.len() > 1 && points.first() == points.last() {
        points.pop();
    }
    Polyline { points, closed }
}

/// Where the level crosses an edge.
fn point(samples: &Samples, edge: usize) -> [f64; 2] {
    let nx = samples.shape[2];
    let n = edge / 2;
    let (j, i) = (n / nx, n % nx);
    let (dj, di) = (edge % 2, 1 - edge % 2);
    let t = fraction(samples.values[n], samples.values[n + dj * nx + di]);
    let [_, y, x] = &samples.coordinates;
    [x[i] + t * (x[i + di] - x[i]), y[j] + t * (y[j + dj] - y[j])]
}
