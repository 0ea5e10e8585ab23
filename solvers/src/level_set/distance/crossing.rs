//! Where phi crosses 0 on the edges of the grid, with normal and curvature there.

use super::Lattice;
use super::elements::{Element, Shape};

/// Half-length of a patch in space (cells). No point of a flat surface is farther than
/// half a cell's diagonal, sqrt(3) / 2, from a crossing with a grid edge.
const EXTENT: f64 = 0.9;

/// Largest curvature of a patch in space (1/cell): a bend tighter than a cell is not resolved.
const MAX_CURVATURE: f64 = 1.0;

/// A crossing of a grid edge in the plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    /// Row and column of the edge's first node.
    pub node: [u32; 2],
    /// Whether the edge runs along y.
    pub upright: bool,
    /// Whether phi is smooth enough here for normal and curvature to mean something.
    pub smooth: bool,
    /// Place on the edge, in [0, 1].
    pub r: f64,
    /// Unit vector towards phi > 0.
    pub normal: [f64; 2],
    pub curvature: f64,
}

/// Whether four equidistant values come from a smooth function rather than the
/// neighbourhood of a kink: third differences below .6 of the first (a sine of 8 cells
/// has .586, a distance's ridge between the nodes up to 2, a mask 2) or .75 of the second.
///
/// A kink at r between the middle nodes has |1 - 2 r|, one beside them 1. Limits of .5, .6
/// and .75 leave errors of .446, .314 and .263 cell in the worst of 12 fields of waves down to
/// 8 cells: next to their extrema the other differences are small.
pub(super) fn smooth(f: &[f64; 4]) -> bool {
    let (below, above) = (f[0] - 2.0 * f[1] + f[2], f[1] - 2.0 * f[2] + f[3]);
    let scale = (0.6 * (f[2] - f[1]).abs()).max(0.75 * (below.abs() + above.abs()));
    (above - below).abs() <= scale
}

/// Where phi crosses 0 on the edge between the middle two of four equidistant values, in
/// [0, 1], and whether the values are smooth.
///
/// The cubic through all four values where they are [`smooth`]; next to a kink the parabola with the smaller of
/// the two second differences, as Min & Gibou 2007, eq. (12), which cannot overshoot.
pub(super) fn crossing(f: [f64; 4]) -> (f64, bool) {
    let slope = f[2] - f[1];
    let (below, above) = (f[0] - 2.0 * f[1] + f[2], f[1] - 2.0 * f[2] + f[3]);
    let linear = f[1] / (f[1] - f[2]);
    let even = smooth(&f);
    let (second, third) = if even {
        (below, above - below)
    } else if below * above <= 0.0 {
        return (linear, false);
    } else {
        (if below.abs() < above.abs() { below } else { above }, 0.0)
    };
    // p(r) = f1 + slope r + second r (r - 1) / 2 + third (r + 1) r (r - 1) / 6.
    let (bow, cubic) = (0.5 * second, third / 6.0);
    let (mut low, mut high) = (0.0, 1.0);
    let mut r = linear;
    for _ in 0..8 {
        let value = f[1] + r * (slope + (r - 1.0) * (bow + cubic * (r + 1.0)));
        let rate = slope + bow * (2.0 * r - 1.0) + cubic * (3.0 * r * r - 1.0);
        let step = value / rate;
        // Newton's steps square their size: the next would be below 1e-14.
        if step.abs() < 1e-7 {
            r = (r - step).clamp(0.0, 1.0);
            break;
        }
        if (value < 0.0) == (f[1] < 0.0) {
            low = r;
        } else {
            high = r;
        }
        let next = r - step;
        r = if next >= low && next <= high { next } else { 0.5 * (low + high) };
    }
    (r, even)
}

/// Values, first and second derivatives of the four cubic Lagrange polynomials of nodes -1, 0, 1, 2.
pub(super) fn lagrange(r: f64) -> [[f64; 4]; 3] {
    let (m, p, q) = (r - 1.0, r + 1.0, r - 2.0);
    let sixth = 1.0 / 6.0;
    [
        [-r * m * q * sixth, p * m * q * 0.5, -p * r * q * 0.5, p * r * m * sixth],
        [
            -(3.0 * r * r - 6.0 * r + 2.0) * sixth,
            (3.0 * r * r - 4.0 * r - 1.0) * 0.5,
            -(3.0 * r * r - 2.0 * r - 2.0) * 0.5,
            (3.0 * r * r - 1.0) * sixth,
        ],
        [1.0 - r, 3.0 * r - 2.0, 1.0 - 3.0 * r, r],
    ]
}

#[inline(always)]
pub(super) fn dot(w: &[f64; 4], f: &[f64; 4]) -> f64 {
    w[0] * f[0] + w[1] * f[1] + w[2] * f[2] + w[3] * f[3]
}

/// The crossing of the edge from node `(j, i)` of a plane.
pub(super) fn in_plane(
    phi: &[f64],
    lattice: &Lattice,
    [j, i]: [usize; 2],
    upright: bool,
) -> Crossing {
    let [_, ny, nx] = lattice.shape;
    let (along, across) = if upright { (nx, 1) } else { (1, nx) };
    let n = j * nx + i;
    let inner = j > 0 && i > 0 && j + 2 < ny && i + 2 < nx;
    let line = |side: isize| -> [f64; 4] {
        if inner {
            let first = (n - along).wrapping_add_signed(side * across as isize);
            return [
                phi[first],
                phi[first + along],
                phi[first + 2 * along],
                phi[first + 3 * along],
            ];
        }
        std::array::from_fn(|m| {
            let (a, b) = (m as isize - 1, side);
            let (dj, di) = if upright { (a, b) } else { (b, a) };
            lattice.value(phi, [0, j as isize + dj, i as isize + di])
        })
    };
    let [low, middle, high] = [line(-1), line(0), line(1)];
    let (r, smooth) = crossing(lattice.limited(
        middle,
        if upright { j } else { i },
        if upright { ny } else { nx },
    ));
    let [w, w1, w2] = lagrange(r);
    let mut difference = [0.0; 4];
    let mut second = [0.0; 4];
    for m in 0..4 {
        difference[m] = 0.5 * (high[m] - low[m]);
        second[m] = high[m] - 2.0 * middle[m] + low[m];
    }
    let (ga, gb) = (dot(&w1, &middle), dot(&w, &difference));
    let (haa, hbb, hab) = (dot(&w2, &middle), dot(&w, &second), dot(&w1, &difference));
    let square = ga * ga + gb * gb;
    let length = square.sqrt();
    let rise = middle[2] - middle[1];
    let mut found = Crossing {
        node: [j as u32, i as u32],
        upright,
        smooth: smooth && ga * rise > 0.0 && length.is_normal(),
        r,
        normal: [0.0; 2],
        curvature: 0.0,
    };
    let (mut a, mut b) = (rise.signum(), 0.0);
    if found.smooth {
        (a, b) = (ga / length, gb / length);
        found.curvature = (haa * b * b - 2.0 * hab * a * b + hbb * a * a) / length;
    }
    found.normal = if upright { [b, a] } else { [a, b] };
    found
}

/// The patch where phi crosses 0 between `node` and its successor along `axis` (0 is z, 2 is x).
pub(super) fn in_space(
    phi: &[f64],
    lattice: &Lattice,
    node: [usize; 3],
    axis: usize,
) -> (Element, Shape) {
    let (b, c) = ((axis + 2) % 3, (axis + 1) % 3);
    let line = |q: isize, s: isize| -> [f64; 4] {
        std::array::from_fn(|m| {
            let mut at = node.map(|c| c as isize);
            at[axis] += m as isize - 1;
            at[b] += q;
            at[c] += s;
            lattice.value(phi, at)
        })
    };
    let middle = line(0, 0);
    let (r, _) = crossing(lattice.limited(middle, node[axis], lattice.shape[axis]));
    let [w, w1, w2] = lagrange(r);
    let mut gradient = [0.0; 3];
    let mut hessian = [[0.0; 3]; 3];
    gradient[axis] = dot(&w1, &middle);
    hessian[axis][axis] = dot(&w2, &middle);
    let mut transverse = |t: usize, low: [f64; 4], high: [f64; 4]| {
        let (mut difference, mut second) = ([0.0; 4], [0.0; 4]);
        for m in 0..4 {
            difference[m] = 0.5 * (high[m] - low[m]);
            second[m] = high[m] - 2.0 * middle[m] + low[m];
        }
        gradient[t] = dot(&w, &difference);
        hessian[t][t] = dot(&w, &second);
        hessian[axis][t] = dot(&w1, &difference);
        hessian[t][axis] = hessian[axis][t];
    };
    if lattice.shape[b] > 1 {
        transverse(b, line(-1, 0), line(1, 0));
    }
    if lattice.shape[c] > 1 {
        transverse(c, line(0, -1), line(0, 1));
    }
    if lattice.shape[b] > 1 && lattice.shape[c] > 1 {
        let corner = [line(-1, -1), line(1, 1), line(-1, 1), line(1, -1)];
        let mixed = |m: usize| 0.25 * (corner[0][m] + corner[1][m] - corner[2][m] - corner[3][m]);
        hessian[b][c] = dot(&w, &std::array::from_fn(mixed));
        hessian[c][b] = hessian[b][c];
    }
    let mut point = node.map(|i| i as f64);
    point[axis] += r;
    point.reverse();
    let rise = middle[2] - middle[1];
    let (mut element, shape) = bent(gradient, hessian, gradient[axis] * rise > 0.0);
    if element.normal == [0.0; 3] {
        element.normal[2 - axis] = rise.signum();
    }
    element.point = point;
    (element, shape)
}

/// Normal and bends from derivatives ordered z, y, x; none if `trusted` is false.
fn bent(gradient: [f64; 3], hessian: [[f64; 3]; 3], trusted: bool) -> (Element, Shape) {
    let normal = [0.0; 3];
    let mut element =
        Element { normal, extent: EXTENT, overlap: EXTENT, ..Element::point([0.0; 3]) };
    let length = gradient.iter().map(|g| g * g).sum::<f64>().sqrt();
    if !trusted || !length.is_normal() {
        return (element, [0.0; 6]);
    }
    let n = [gradient[2] / length, gradient[1] / length, gradient[0] / length];
    element.normal = n;
    // S = P H P / |grad phi| with P = 1 - n n^T.
    let h = |p: usize, q: usize| hessian[2 - p][2 - q] / length;
    let hn: [f64; 3] = std::array::from_fn(|p| h(p, 0) * n[0] + h(p, 1) * n[1] + h(p, 2) * n[2]);
    let nhn = hn[0] * n[0] + hn[1] * n[1] + hn[2] * n[2];
    let s = |p: usize, q: usize| h(p, q) - n[p] * hn[q] - hn[p] * n[q] + n[p] * n[q] * nhn;
    let mut shape = [s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(0, 2), s(1, 2)];
    let square = shape[..3].iter().map(|v| v * v).sum::<f64>()
        + 2.0 * shape[3..].iter().map(|v| v * v).sum::<f64>();
    if square > MAX_CURVATURE * MAX_CURVATURE {
        shape = shape.map(|v| v * MAX_CURVATURE / square.sqrt());
    }
    (element, shape)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubic_crossings_are_exact() {
        // A cubic smooth enough at -1, 0, 1, 2 not to be taken for a kink.
        let f = |x: f64| (x - 0.3) * (x + 5.0) * (x - 6.0);
        assert!((crossing([-1.0, 0.0, 1.0, 2.0].map(f)).0 - 0.3).abs() < 1e-12);
        // Halfway between differing nodes of a mask, whatever stands beside them.
        for (a, b) in [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
            assert_eq!(crossing([a, -1.0, 1.0, b]), (0.5, false));
        }
    }
}
