//! Reinitialization: back to a signed distance without moving the front.
#![allow(
    clippy::needless_range_loop,
    reason = "rows side by side share one index; zips would hide the stencil"
)]

use super::{
    ghost::{Padded, Row},
    rows,
    upwind::max,
};
use crate::{Boundary, Field, Grid};
use std::ops::Range;

/// Relaxes `phi` towards the signed distance from its own front `phi = 0` by
/// `iterations` steps of `dphi/dtau = sign(phi_0) (1 - |grad phi|)`, `dtau = h/2`.
///
/// Phi is a distance within `iterations / 2` node distances of the front afterwards.
/// Second order in the distance next to the front. The front stays where it was
/// however many iterations follow: differences across it reach to the point where
/// phi_0 crosses the grid line (the sub-cell fix of Russo & Smereka 2000, J. Comput.
/// Phys. 163:51), in the ENO2 form of Min 2010, J. Comput. Phys. 229:2764, eqs (11)
/// and (14), with crossings from cubic interpolation.
pub fn reinitialize(phi: &mut Field, iterations: usize, boundary: Boundary) {
    let grid = phi.grid();
    let mut padded = Padded::new(grid, 2, boundary);
    padded.load(phi.as_slice());
    let start = phi.as_slice().to_vec();
    let near = Near::find(grid, &padded, &start);
    let arch = pulp::Arch::new();
    for _ in 0..iterations {
        padded.load(phi.as_slice());
        rows::all(phi.as_mut_slice(), grid.shape()[2], rows::HEAVY, |first, next| {
            let (padded, near, start) = (&padded, &near, start.as_slice());
            arch.dispatch(Piece { grid, padded, near, start, first, next });
            true
        });
    }
}

/// The nodes next to the front, row by row.
struct Near {
    nodes: Vec<NearNode>,
    /// Where each row starts in `nodes`, one more than rows.
    offsets: Vec<usize>,
}

struct NearNode {
    i: usize,
    /// Distance to the front (node distances) towards lower and higher indices
    /// along x, y, z; infinite where the front does not cross that edge.
    crossings: [[f64; 2]; 3],
}

impl Near {
    fn find(grid: Grid, padded: &Padded, start: &[f64]) -> Self {
        let nx = grid.shape()[2];
        let mut near = Self { nodes: Vec::new(), offsets: vec![0] };
        for row in 0..start.len() / nx {
            let view = padded.row(row, 0..nx);
            let lines: [[&[f64]; 5]; 3] = std::array::from_fn(|axis| {
                let axis = axis.min(grid.dim() - 1);
                std::array::from_fn(|k| view.along(axis, k as isize - 2))
            });
            for i in 0..nx {
                let crossings = [0, 1, 2].map(|axis| {
                    if axis >= grid.dim() {
                        return [f64::INFINITY; 2];
                    }
                    let [a, b, c, d, e] = lines[axis].map(|line| line[i]);
                    [[d, c, b, a], [b, c, d, e]].map(crossing)
                });
                let crossed = crossings.as_flattened().iter().any(|s| s.is_finite());
                if crossed || lines[0][2][i] == 0.0 {
                    near.nodes.push(NearNode { i, crossings });
                }
            }
            near.offsets.push(near.nodes.len());
        }
        near
    }

    fn row(&self, row: usize) -> &[NearNode] {
        &self.nodes[self.offsets[row]..self.offsets[row + 1]]
    }
}

/// Where phi crosses zero between the middle two of four equally spaced values, in
/// node distances from the second, by their cubic; infinite if it does not.
fn crossing([p, q, r, s]: [f64; 4]) -> f64 {
    if q == 0.0 || (q < 0.0) == (r < 0.0) && r != 0.0 {
        return f64::INFINITY;
    }
    // Newton's form at the nodes 0, 1, -1, 2.
    let second = 0.5 * (r - 2.0 * q + p);
    let third = (s - 3.0 * r + 3.0 * q - p) / 6.0;
    let cubic = |t: f64| q + t * (r - q + (t - 1.0) * (second + (t + 1.0) * third));
    let (mut low, mut high) = (0.0, 1.0);
    // Each of the steps halves the interval at least; 50 reach the last bit.
    let mut t = q / (q - r);
    for _ in 0..50 {
        let value = cubic(t);
        if (value < 0.0) == (q < 0.0) {
            low = t;
        } else {
            high = t;
        }
        let slope = r - q + (2.0 * t - 1.0) * second + (3.0 * t * t - 1.0) * third;
        let newton = t - value / slope;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - t).abs() < 1e-15 {
            break;
        }
        t = next;
    }
    t
}

/// Rows of one iteration.
struct Piece<'a> {
    grid: Grid,
    padded: &'a Padded,
    near: &'a Near,
    start: &'a [f64],
    first: usize,
    next: &'a mut [f64],
}

impl pulp::WithSimd for Piece<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let (nx, h) = (self.grid.shape()[2], self.grid.spacing());
        for (row, next) in self.next.chunks_exact_mut(nx).enumerate() {
            let row = self.first + row;
            let start = &self.start[row * nx..(row + 1) * nx];
            let nodes: Range<usize> = 0..nx;
            let view = self.padded.row(row, nodes);
            match self.grid.dim() {
                1 => relax::<1>(view, start, h, next),
                2 => relax::<2>(view, start, h, next),
                _ => relax::<3>(view, start, h, next),
            }
            for node in self.near.row(row) {
                next[node.i] = relax_near(view, self.grid.dim(), node, start[node.i], h);
            }
        }
    }
}

/// The lesser in magnitude of two curvatures of one sign, else zero.
#[inline(always)]
fn minmod(a: f64, b: f64) -> f64 {
    let least = if a.abs() < b.abs() { a } else { b };
    if a * b > 0.0 { least } else { 0.0 }
}

/// `next = phi - dtau sign(phi_0) (|grad phi| - 1)` with ENO2 differences.
#[inline(always)]
fn relax<const DIM: usize>(view: Row<'_>, start: &[f64], h: f64, next: &mut [f64]) {
    let n = view.len();
    let (start, next) = (&start[..n], &mut next[..n]);
    let lines: [[&[f64]; 5]; DIM] =
        std::array::from_fn(|axis| std::array::from_fn(|k| &view.along(axis, k as isize - 2)[..n]));
    for i in 0..n {
        let sign = 1.0_f64.copysign(start[i]);
        let mut square = 0.0;
        for line in &lines {
            let [back, ahead] = one_sided(line.map(|line| line[i]), [f64::INFINITY; 2]);
            let slope = max(max(sign * back, -sign * ahead), 0.0);
            square += slope * slope;
        }
        next[i] = lines[0][2][i] - 0.5 * sign * (square.sqrt() - h);
    }
}

/// One-sided differences of second order, times h, from five values along a line.
/// If the front crosses the next edge, they end at the crossing.
#[inline(always)]
fn one_sided([a, b, c, d, e]: [f64; 5], [low, high]: [f64; 2]) -> [f64; 2] {
    let middle = b - 2.0 * c + d;
    let bend_back = 0.5 * minmod(middle, a - 2.0 * b + c);
    let bend_ahead = 0.5 * minmod(middle, c - 2.0 * d + e);
    let back = if low < 2.0 { c / low + low * bend_back } else { c - b + bend_back };
    let ahead = if high < 2.0 { -c / high - high * bend_ahead } else { d - c - bend_ahead };
    [back, ahead]
}

/// As [`relax`] next to the front, with a time step that the distance to it allows.
#[inline(always)]
fn relax_near(view: Row<'_>, dim: usize, node: &NearNode, start: f64, h: f64) -> f64 {
    let phi = view.along(0, 0)[node.i];
    let closest = node.crossings.as_flattened().iter().fold(1.0, |s: f64, &c| s.min(c));
    // A node on the front stays there.
    if start == 0.0 || closest < 1e-12 {
        return start;
    }
    let sign = 1.0_f64.copysign(start);
    let mut square = 0.0;
    for axis in 0..dim {
        let line: [f64; 5] = std::array::from_fn(|k| view.along(axis, k as isize - 2)[node.i]);
        let [back, ahead] = one_sided(line, node.crossings[axis]);
        let slope = max(max(sign * back, -sign * ahead), 0.0);
        square += slope * slope;
    }
    phi - 0.5 * closest * sign * (square.sqrt() - h)
}
