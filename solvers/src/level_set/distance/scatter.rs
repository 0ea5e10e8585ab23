//! Distances of all nodes within some reach of each element: the nearest exactly.

use super::elements::{Element, square};
use super::{Lattice, Pieces};

/// Rows of a bin of elements, and of a chunk of work.
pub(super) const ROWS: usize = 32;

/// Nodes measured at once.
const LANES: usize = 4;

/// Numbers of the elements, sorted by the bin of their row.
#[derive(Default)]
pub(super) struct Bins {
    start: Vec<u32>,
    order: Vec<u32>,
}

impl Bins {
    /// Sorts the elements of a plane.
    pub(super) fn fill(&mut self, pieces: &Pieces, lattice: &Lattice) {
        let bins = lattice.shape[1].div_ceil(ROWS);
        let bin = |e: &Element| (e.point[1].max(0.0) as usize / ROWS).min(bins - 1);
        self.start.clear();
        self.start.resize(bins + 2, 0);
        let elements = &pieces.elements[1..];
        elements.iter().for_each(|e| self.start[bin(e) + 2] += 1);
        (2..bins + 2).for_each(|m| self.start[m] += self.start[m - 1]);
        self.order.resize(elements.len(), 0);
        for (number, element) in elements.iter().enumerate() {
            let slot = &mut self.start[bin(element) + 1];
            self.order[*slot as usize] = number as u32 + 1;
            *slot += 1;
        }
    }

    fn of(&self, bin: usize) -> &[u32] {
        &self.order[self.start[bin] as usize..self.start[bin + 1] as usize]
    }
}

/// Lowers signed squared distances in the rows from `first` on to those of the
/// elements that are nearer, for all nodes up to `reach` away (and some beyond).
pub(super) struct Scatter<'a> {
    pub lattice: &'a Lattice,
    pub elements: &'a [Element],
    pub bins: &'a Bins,
    pub reach: f64,
    pub first: usize,
    pub values: &'a mut [f64],
}

impl pulp::NullaryFnOnce for Scatter<'_> {
    type Output = bool;

    /// Whether any element was near.
    #[inline(always)]
    fn call(self) -> bool {
        let [_, ny, nx] = self.lattice.shape;
        let rows = self.values.len() / nx;
        let images: &[f64] = if self.lattice.periodic { &[0.0, -1.0, 1.0] } else { &[0.0] };
        let mut any = false;
        for &turn in images {
            let shift = turn * ny as f64;
            // Elements stand out of their bin by a cell at most.
            let low = self.first as f64 - self.reach - 1.0 - shift;
            let high = (self.first + rows) as f64 + self.reach + 1.0 - shift;
            if high < 0.0 || low > ny as f64 {
                continue;
            }
            let last = (high as usize / ROWS + 1).min(ny.div_ceil(ROWS));
            for bin in low.max(0.0) as usize / ROWS..last {
                for &number in self.bins.of(bin) {
                    let element = &self.elements[number as usize];
                    let strip = Strip::new(element, self.reach);
                    for &around in images {
                        let point =
                            [element.point[0] + around * nx as f64, element.point[1] + shift];
                        any |= lower(element, &strip, point, self.first, nx, self.values);
                    }
                }
            }
        }
        any
    }
}

/// The rectangle around an element, along its normal and tangent, in which its foot points' nodes lie
/// up to some reach; the nodes of a row within it and within a circle's square.
struct Strip {
    /// Largest offset of a node along x and y.
    out: [f64; 2],
    /// For the tangent and the normal: the sides' shift along x from row to row, and half
    /// the distance of two sides along x.
    sides: [[f64; 2]; 2],
}

impl Strip {
    #[inline(always)]
    fn new(e: &Element, reach: f64) -> Self {
        // No division by 0; a shift this large does not limit any row.
        let [x, y] = [e.normal[0], e.normal[1]].map(|n| if n.abs() < 1e-9 { 1e-9 } else { n });
        // The ends stand this far from the middle.
        let depth = 0.5 * e.curvature.abs() * e.extent * e.extent;
        let across = reach + depth;
        let wide = e.extent + (e.fan * across).min(reach);
        let (dx, dy) = (x.abs(), y.abs());
        let square = [dy * e.extent + dx * depth + reach, dx * e.extent + dy * depth + reach];
        let turned = [dy * wide + dx * across, dx * wide + dy * across];
        let out = [square[0].min(turned[0]), square[1].min(turned[1])];
        Self { out, sides: [[x / y, wide / dy], [-y / x, across / dx]] }
    }

    /// Offsets along x between which nodes of a row `dy` above the middle are wanted.
    #[inline(always)]
    fn row(&self, dy: f64) -> [f64; 2] {
        let [[a, wide_a], [b, wide_b]] = self.sides;
        let (a, b) = (a * dy, b * dy);
        let larger = |a: f64, b: f64| if a > b { a } else { b };
        let smaller = |a: f64, b: f64| if a < b { a } else { b };
        [
            larger(-self.out[0], larger(a - wide_a, b - wide_b)),
            smaller(self.out[0], smaller(a + wide_a, b + wide_b)),
        ]
    }
}

/// Lowers the values around one element, whose middle is `point`.
#[inline(always)]
fn lower(
    e: &Element,
    strip: &Strip,
    point: [f64; 2],
    first: usize,
    nx: usize,
    values: &mut [f64],
) -> bool {
    let rows = values.len() / nx;
    let (n, k, extent) = (e.normal, e.curvature, e.extent);
    let y = point[1] - first as f64;
    let (low, high) = ((y - strip.out[1]).ceil(), (y + strip.out[1]).floor());
    let [left, right] = [point[0] - strip.out[0], point[0] + strip.out[0]];
    if high < 0.0 || low >= rows as f64 || right < 0.0 || left >= nx as f64 {
        return false;
    }
    let (low, high) = (low.max(0.0) as usize, (high as usize + 1).min(rows));
    for row in low..high {
        let dy = row as f64 - y;
        let [left, right] = strip.row(dy).map(|dx| point[0] + dx);
        let (left, right) =
            (left.ceil().max(0.0) as usize, (right.floor() + 1.0).max(0.0) as usize);
        let right = right.min(nx);
        if left >= right {
            continue;
        }
        // Whole groups of lanes; farther nodes take no harm.
        let width = (right - left).next_multiple_of(LANES).min(nx);
        let left = left.min(nx - width);
        let dx = left as f64 - point[0];
        let (a, t) = (dx * n[0] + dy * n[1], dy * n[0] - dx * n[1]);
        let mut groups = values[row * nx + left..][..width].chunks_exact_mut(LANES);
        let mut c = 0.0;
        for group in &mut groups {
            for (m, value) in group.iter_mut().enumerate() {
                let x = c + m as f64;
                *value = nearer(*value, square(a + x * n[0], t - x * n[1], k, extent));
            }
            c += LANES as f64;
        }
        for (m, value) in groups.into_remainder().iter_mut().enumerate() {
            let x = c + m as f64;
            *value = nearer(*value, square(a + x * n[0], t - x * n[1], k, extent));
        }
    }
    true
}

#[inline(always)]
fn nearer(value: f64, square: f64) -> f64 {
    let signed = if value < 0.0 { -square } else { square };
    if square < value.abs() { signed } else { value }
}
