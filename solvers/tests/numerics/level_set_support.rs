//! What the level-set tests share: contours and areas read from phi.

use solvers::level_set::{LevelSet, Order, Scheme, Speed};
use solvers::{Boundary, Field, Grid};

/// A unit square or cube of `n` cells a side.
pub(crate) fn unit(dim: usize, n: usize) -> Grid {
    Grid::new(&vec![n + 1; dim], 1.0 / n as f64).unwrap()
}

/// The scheme of an order with linear continuation at the border, which leaves a cone a cone.
pub(crate) fn scheme(order: Order) -> Scheme {
    Scheme { order, boundary: Boundary::Extrapolate, ..Scheme::default() }
}

/// Runs from `phi` to time `t`; the time steps divide it evenly at the end.
pub(crate) fn run(phi: Field, scheme: Scheme, speed: &mut dyn Speed, t: f64) -> Field {
    let mut front = LevelSet::new(phi, scheme).unwrap();
    // Rounding of t: a rest below 1e-12 would be a step of nothing.
    while t - front.time() > 1e-12 * t {
        front.advance(speed, t - front.time()).unwrap();
    }
    front.phi().clone()
}

/// How the position of the front on a grid edge is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Read {
    /// By linear interpolation between two nodes, second order.
    Linear,
    /// By the less curved of the two parabolas through three nodes, third order also
    /// next to a kink (linear next to the border).
    Eno,
}

/// Positions of the front on all grid edges.
pub(crate) fn contour(phi: &Field, read: Read) -> Vec<[f64; 3]> {
    let (grid, values) = (phi.grid(), phi.as_slice());
    let mut points = Vec::new();
    for axis in 3 - grid.dim()..3 {
        let (count, stride) = (grid.shape()[axis], grid.strides()[axis]);
        for n in 0..values.len() {
            let i = grid.node(n)[axis];
            if i + 1 == count || (values[n] < 0.0) == (values[n + stride] < 0.0) {
                continue;
            }
            let (a, b) = (values[n], values[n + stride]);
            let mut t = a / (a - b);
            if read == Read::Eno && i > 0 && i + 2 < count {
                let bends =
                    [values[n - stride] - 2.0 * a + b, a - 2.0 * b + values[n + 2 * stride]];
                t = parabola_root(a, b, bends);
            }
            let mut point = grid.position(n);
            point[2 - axis] += t * grid.spacing();
            points.push(point);
        }
    }
    points
}

/// The root in (0, 1) of a parabola with values a and b at 0 and 1, by bisection.
fn parabola_root(a: f64, b: f64, bends: [f64; 2]) -> f64 {
    let bend = if bends[0].abs() < bends[1].abs() { bends[0] } else { bends[1] };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let t = 0.5 * (low + high);
        let value = a + t * (b - a) + 0.5 * bend * t * (t - 1.0);
        if (value < 0.0) == (a < 0.0) { low = t } else { high = t }
    }
    low
}

/// Greatest |exact(point)| over the contour, in node distances; `exact` is the true signed distance.
pub(crate) fn contour_error(phi: &Field, read: Read, exact: impl Fn([f64; 3]) -> f64) -> f64 {
    let points = contour(phi, read);
    assert!(!points.is_empty(), "the front has vanished");
    points.into_iter().map(|p| exact(p).abs()).fold(0.0, f64::max) / phi.grid().spacing()
}

/// Mean and standard deviation of the distance between the contour and `center`.
pub(crate) fn radius(phi: &Field, center: [f64; 3]) -> (f64, f64) {
    let points = contour(phi, Read::Eno);
    let r = points.iter().map(|p| distance(*p, center));
    let n = points.len() as f64;
    let mean = r.clone().sum::<f64>() / n;
    (mean, (r.map(|r| (r - mean).powi(2)).sum::<f64>() / n).sqrt())
}

pub(crate) fn distance(p: [f64; 3], q: [f64; 3]) -> f64 {
    (0..3).map(|a| (p[a] - q[a]).powi(2)).sum::<f64>().sqrt()
}

/// Area of `phi < 0` in 2D, phi linear on the triangles of both ways to halve each cell.
pub(crate) fn area(phi: &Field) -> f64 {
    let [_, ny, nx] = phi.grid().shape();
    let mut sum = 0.0;
    for j in 0..ny - 1 {
        for i in 0..nx - 1 {
            let [a, b, c, d] =
                [(j, i), (j, i + 1), (j + 1, i + 1), (j + 1, i)].map(|(j, i)| phi.at(0, j, i));
            sum +=
                [[a, b, c], [a, c, d], [a, b, d], [b, c, d]].map(inside).iter().sum::<f64>() / 4.0;
        }
    }
    sum * phi.grid().cell_volume()
}

/// Fraction of a triangle in which a linear function with these corner values is negative.
fn inside(mut corners: [f64; 3]) -> f64 {
    corners.sort_by(f64::total_cmp);
    let [a, b, c] = corners;
    match corners.iter().filter(|v| **v < 0.0).count() {
        0 => 0.0,
        1 => a * a / ((b - a) * (c - a)),
        2 => 1.0 - c * c / ((c - a) * (c - b)),
        _ => 1.0,
    }
}
