//! Pieces of a reconstructed contour: one second-order patch per crossed grid edge.
//!
//! Everything here is in units of the node distance h.

use super::Lattice;

/// Half-length of a patch (cells). Crossings of a straight line with the grid
/// edges lie at most a cell's diagonal apart, so 0.75 > sqrt(2) / 2 leaves no gap.
const EXTENT: f64 = 0.75;

/// Largest curvature kept (1/cell): a bend tighter than a cell is not resolved.
const MAX_CURVATURE: f64 = 1.0;

/// A patch of the contour: a point, its normal, its curvature and how far it reaches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Element {
    pub point: [f64; 3],
    /// Unit vector towards phi > 0, or zero for a lone point.
    pub normal: [f64; 3],
    /// Curvature div(n) in the plane; see [`Element::in_space`].
    pub curvature: f64,
    /// Half-length along the contour; beyond it the end point counts.
    pub extent: f64,
}

/// Symmetric tensor `[xx, yy, zz, xy, xz, yz]`, the derivative of the normal along the surface.
pub(super) type Shape = [f64; 6];

impl Element {
    /// A point without direction.
    pub(super) fn point(point: [f64; 3]) -> Self {
        Self { point, normal: [0.0; 3], curvature: 0.0, extent: 0.0 }
    }

    /// This patch with the curvature that it has towards `w`, from the tensor of its bends.
    #[inline(always)]
    pub(super) fn in_space(&self, s: &Shape, w: [f64; 3]) -> Self {
        let [x, y, z] = w;
        let bend = s[0] * x * x
            + s[1] * y * y
            + s[2] * z * z
            + 2.0 * (s[3] * x * y + s[4] * x * z + s[5] * y * z);
        let a = x * self.normal[0] + y * self.normal[1] + z * self.normal[2];
        let tt = x * x + y * y + z * z - a * a;
        Self { curvature: if tt > 1e-12 { bend / tt } else { 0.0 }, ..*self }
    }

    /// Distance from the patch to a node at `w = node - point`.
    ///
    /// With a = w.n and t^2 = |w|^2 - a^2 the distance to the osculating circle is
    /// `(k |w|^2 + 2 a) / (1 + sqrt(1 + 2 a k + k^2 |w|^2))`, regular at k = 0; a
    /// foot point beyond the extent is replaced by the end of the patch.
    #[inline(always)]
    pub(super) fn distance(&self, w: [f64; 3]) -> f64 {
        let n = self.normal;
        let (k, extent) = (self.curvature, self.extent);
        let a = w[0] * n[0] + w[1] * n[1] + w[2] * n[2];
        let ww = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
        let tt = ww - a * a;
        let tt = if tt > 0.0 { tt } else { 0.0 };
        let reach = extent * (1.0 + k * a);
        let square = 1.0 + 2.0 * a * k + k * k * ww;
        let root = (if square > 0.0 { square } else { 0.0 }).sqrt();
        let arc = ((k * ww + 2.0 * a) / (1.0 + root)).abs();
        let along = tt.sqrt() - extent;
        let across = a + 0.5 * k * extent * extent;
        let end = (along * along + across * across).sqrt();
        if (reach >= 0.0) & (tt <= reach * reach) { arc } else { end }
    }
}

/// Where phi crosses 0 on the edge between the middle two of four equidistant values, in [0, 1].
///
/// The cubic through all four values where it bends evenly; next to a kink (second
/// differences that disagree by over half the slope) the parabola with the smaller of
/// the two second differences, as Min & Gibou 2007, eq. (12), which cannot overshoot.
pub(super) fn crossing(f: [f64; 4]) -> f64 {
    let slope = f[2] - f[1];
    let (below, above) = (f[0] - 2.0 * f[1] + f[2], f[1] - 2.0 * f[2] + f[3]);
    let linear = f[1] / (f[1] - f[2]);
    let (second, third) = if (above - below).abs() <= 0.5 * slope.abs() {
        (below, above - below)
    } else if below * above <= 0.0 {
        return linear;
    } else {
        (if below.abs() < above.abs() { below } else { above }, 0.0)
    };
    // p(r) = f1 + slope r + second r (r - 1) / 2 + third (r + 1) r (r - 1) / 6.
    let (mut low, mut high) = (0.0, 1.0);
    let mut r = linear;
    for _ in 0..8 {
        let (bow, cubic) = (0.5 * second, third / 6.0);
        let value = f[1] + r * (slope + (r - 1.0) * (bow + cubic * (r + 1.0)));
        let rate = slope + bow * (2.0 * r - 1.0) + cubic * (3.0 * r * r - 1.0);
        if (value < 0.0) == (f[1] < 0.0) {
            low = r;
        } else {
            high = r;
        }
        let mut next = r - value / rate;
        if !(next >= low && next <= high) {
            next = 0.5 * (low + high);
        }
        if (next - r).abs() < 1e-12 {
            return next;
        }
        r = next;
    }
    r
}

/// Values, first and second derivatives of the four cubic Lagrange polynomials of nodes -1, 0, 1, 2.
fn lagrange(r: f64) -> [[f64; 4]; 3] {
    let (m, p, q) = (r - 1.0, r + 1.0, r - 2.0);
    [
        [-r * m * q / 6.0, p * m * q / 2.0, -p * r * q / 2.0, p * r * m / 6.0],
        [
            -(3.0 * r * r - 6.0 * r + 2.0) / 6.0,
            (3.0 * r * r - 4.0 * r - 1.0) / 2.0,
            -(3.0 * r * r - 2.0 * r - 2.0) / 2.0,
            (3.0 * r * r - 1.0) / 6.0,
        ],
        [1.0 - r, 3.0 * r - 2.0, 1.0 - 3.0 * r, r],
    ]
}

fn dot(w: &[f64; 4], f: &[f64; 4]) -> f64 {
    w[0] * f[0] + w[1] * f[1] + w[2] * f[2] + w[3] * f[3]
}

/// Index offsets of the nodes `first..first + N` from node coordinate `c` along `axis`.
fn offsets<const N: usize>(lattice: &Lattice, axis: usize, c: usize, first: isize) -> [usize; N] {
    let (n, stride) = (lattice.shape[axis], lattice.strides[axis]);
    let start = c as isize + first;
    std::array::from_fn(|m| {
        let i = start + m as isize;
        let inside = if i >= 0 && i < n as isize { i as usize } else { lattice.wrap(i, n) };
        inside * stride
    })
}

/// The patch where phi crosses 0 between `node` and its successor along `axis` (0 is z, 2 is x).
pub(super) fn on_edge(
    phi: &[f64],
    lattice: &Lattice,
    node: [usize; 3],
    axis: usize,
) -> (Element, Shape) {
    let (b, c) = ((axis + 2) % 3, (axis + 1) % 3);
    let along: [usize; 4] = offsets(lattice, axis, node[axis], -1);
    let across: [usize; 3] = offsets(lattice, b, node[b], -1);
    let over: [usize; 3] = offsets(lattice, c, node[c], -1);
    let line = |q: usize, s: usize| {
        // Written out: `map` is not always compiled into the loop.
        let o = across[q] + over[s];
        [phi[along[0] + o], phi[along[1] + o], phi[along[2] + o], phi[along[3] + o]]
    };
    let middle = line(1, 1);
    let r = crossing(middle);
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
        transverse(b, line(0, 1), line(2, 1));
    }
    if lattice.shape[c] > 1 {
        transverse(c, line(1, 0), line(1, 2));
    }
    if lattice.shape[b] > 1 && lattice.shape[c] > 1 {
        let corner = [line(0, 0), line(2, 2), line(0, 2), line(2, 0)];
        let mixed = |m: usize| 0.25 * (corner[0][m] + corner[1][m] - corner[2][m] - corner[3][m]);
        hessian[b][c] = dot(&w, &std::array::from_fn(mixed));
        hessian[c][b] = hessian[b][c];
    }
    let mut point = node.map(|i| i as f64);
    point[axis] += r;
    point.reverse();
    let rising = gradient[axis] * (middle[2] - middle[1]) > 0.0;
    let (mut element, shape) = bent(gradient, hessian, rising);
    if !rising {
        element.normal[2 - axis] = (middle[2] - middle[1]).signum();
    }
    element.point = point;
    (element, shape)
}

/// Normal and curvature from derivatives ordered z, y, x; flat if `trusted` is false.
fn bent(gradient: [f64; 3], hessian: [[f64; 3]; 3], trusted: bool) -> (Element, Shape) {
    let mut element = Element { extent: EXTENT, ..Element::point([0.0; 3]) };
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
    element.curvature = (shape[0] + shape[1] + shape[2]).clamp(-MAX_CURVATURE, MAX_CURVATURE);
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
        // (x - .3)(x + 2)(x - 4) at -1, 0, 1, 2.
        let f = |x: f64| (x - 0.3) * (x + 2.0) * (x - 4.0);
        assert!((crossing([-1.0, 0.0, 1.0, 2.0].map(f)) - 0.3).abs() < 1e-12);
        // Halfway between differing nodes of a mask, whatever stands beside them.
        for (a, b) in [(-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
            assert_eq!(crossing([a, -1.0, 1.0, b]), 0.5);
        }
    }

    #[test]
    fn a_circle_patch_measures_the_circle() {
        // Radius 4 around the origin, seen from inside and outside, off to the side.
        let patch = Element {
            point: [4.0, 0.0, 0.0],
            normal: [1.0, 0.0, 0.0],
            curvature: 0.25,
            extent: EXTENT,
        };
        for (x, y) in [(6.0_f64, 0.7_f64), (2.0, 0.3), (4.0, 0.5)] {
            let exact = (x.hypot(y) - 4.0).abs();
            let found = patch.distance([x - 4.0, y, 0.0]);
            assert!((found - exact).abs() < 1e-14, "{found} {exact}");
        }
    }
}
