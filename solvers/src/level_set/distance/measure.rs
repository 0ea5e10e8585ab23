//! The squared distance from every node to the element that the sweeps found.

use super::elements::square;
use super::sweep::Lane;
use super::{Lattice, Pieces};

/// Rows and columns of a tile: the lane of the x axis is stored across the rows.
const ROWS: usize = 16;
const COLUMNS: usize = 64;

/// Signs from the field, magnitudes from the elements.
pub(super) struct Finish<'a> {
    pub lattice: &'a Lattice,
    pub pieces: &'a Pieces,
    /// Finds stored `[z][y][x]` and `[x][z][y]`.
    pub lanes: &'a [Lane; 2],
    /// Squared distance where no element is known (cells).
    pub far: f64,
    /// Squared distance below which `far` is written, for others to measure (cells).
    pub near: f64,
}

/// Elements of the nodes in a stretch of a row, as each node sees them.
struct Stretch {
    across: [f64; COLUMNS],
    along: [f64; COLUMNS],
    curvature: [f64; COLUMNS],
    extent: [f64; COLUMNS],
}

impl Finish<'_> {
    /// Replaces values by squared distances in rows from `first` on (of all planes, one after another).
    pub(super) fn run(&self, first: usize, values: &mut [f64]) {
        let [_, ny, nx] = self.lattice.shape;
        let (mut row, mut rest) = (first, values);
        while !rest.is_empty() {
            // A tile lies within one plane.
            let rows = ROWS.min(ny - row % ny).min(rest.len() / nx);
            let (tile, after) = rest.split_at_mut(rows * nx);
            self.tile_row(row / ny, row % ny, tile);
            (row, rest) = (row + rows, after);
        }
    }

    /// Up to `ROWS` rows from `j0` on, tile by tile.
    fn tile_row(&self, k: usize, j0: usize, values: &mut [f64]) {
        let [nz, ny, nx] = self.lattice.shape;
        let [yz, x] = self.lanes;
        let rows = values.len() / nx;
        let arch = pulp::Arch::new();
        let mut elements = [[0_u32; COLUMNS]; ROWS];
        let mut turned = [([0_u32; ROWS], [0.0_f32; ROWS]); COLUMNS];
        let mut stretch = Stretch {
            across: [0.0; COLUMNS],
            along: [0.0; COLUMNS],
            curvature: [0.0; COLUMNS],
            extent: [0.0; COLUMNS],
        };
        for i0 in (0..nx).step_by(COLUMNS) {
            let columns = COLUMNS.min(nx - i0);
            for (c, turned) in turned.iter_mut().enumerate().take(columns) {
                let first = ((i0 + c) * nz + k) * ny + j0;
                turned.0[..rows].copy_from_slice(&x.element[first..][..rows]);
                turned.1[..rows].copy_from_slice(&x.distance[first..][..rows]);
            }
            for (r, elements) in elements.iter_mut().enumerate().take(rows) {
                let n = (k * ny + j0 + r) * nx + i0;
                let straight = yz.element[n..][..columns].iter().zip(&yz.distance[n..]);
                for ((element, turned), (&other, &shorter)) in
                    elements.iter_mut().zip(&turned).zip(straight)
                {
                    let found = turned.0[r];
                    *element = if turned.1[r] < shorter { found } else { other };
                }
            }
            for (r, elements) in elements[..rows].iter().enumerate() {
                let values = &mut values[r * nx + i0..][..columns];
                if elements[..columns].iter().all(|&number| number == 0) {
                    values.iter_mut().for_each(|value| *value = signed(*value, self.far));
                } else if self.lattice.plane() {
                    self.gather([j0 + r, i0], &elements[..columns], &mut stretch);
                    let (far, near) = (self.far, self.near);
                    arch.dispatch(Squares { s: &stretch, values, far, near });
                } else {
                    self.in_space([k, j0 + r, i0], elements, values);
                }
            }
        }
    }

    fn gather(&self, [j, i0]: [usize; 2], elements: &[u32], s: &mut Stretch) {
        for (c, &number) in elements.iter().enumerate() {
            let e = &self.pieces.elements[number as usize];
            let [x, y, _] = self.offset([0, j, i0 + c], e.point);
            s.across[c] = x * e.normal[0] + y * e.normal[1];
            s.along[c] = y * e.normal[0] - x * e.normal[1];
            s.curvature[c] = e.curvature;
            s.extent[c] = e.overlap;
        }
    }

    /// From a point to a node, the short way round a period.
    #[inline(always)]
    fn offset(&self, [k, j, i]: [usize; 3], point: [f64; 3]) -> [f64; 3] {
        let mut w = [i as f64 - point[0], j as f64 - point[1], k as f64 - point[2]];
        if self.lattice.periodic {
            for (w, period) in w.iter_mut().zip(self.lattice.period) {
                let period = f64::from(period);
                *w -= period * (*w / period).round();
            }
        }
        w
    }

    fn in_space(&self, [k, j, i0]: [usize; 3], elements: &[u32; COLUMNS], values: &mut [f64]) {
        for (c, (value, &number)) in values.iter_mut().zip(elements).enumerate() {
            let mut found = self.far;
            if number != 0 {
                let element = &self.pieces.elements[number as usize];
                let w = self.offset([k, j, i0 + c], element.point);
                let shape = &self.pieces.shapes[number as usize];
                found = element.square_in_space(shape, w).min(self.far);
            }
            *value = signed(*value, found);
        }
    }
}

/// The squared distances of a stretch of plane values.
struct Squares<'a> {
    s: &'a Stretch,
    values: &'a mut [f64],
    far: f64,
    near: f64,
}

impl pulp::NullaryFnOnce for Squares<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { s, values, far, near } = self;
        for (c, value) in values.iter_mut().enumerate().take(COLUMNS) {
            let found = square(s.across[c], s.along[c], s.curvature[c], s.extent[c]);
            // Unknown elements are infinitely far: the comparison fails for inf and NaN.
            let known = (found < far) & (found >= near);
            *value = signed(*value, if known { found } else { far });
        }
    }
}

/// `magnitude` with the sign of a value; 0 for 0.
#[inline(always)]
pub(super) fn signed(sign: f64, magnitude: f64) -> f64 {
    let outward = if sign < 0.0 { -magnitude } else { magnitude };
    if sign == 0.0 { 0.0 } else { outward }
}

/// Replaces values by `square` with their signs.
pub(super) struct Fill<'a> {
    pub values: &'a mut [f64],
    pub square: f64,
}

impl pulp::NullaryFnOnce for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.values.iter_mut().for_each(|value| *value = signed(*value, self.square));
    }
}

/// Replaces signed squares (cells) by lengths; `far` stands for itself.
pub(super) struct Roots<'a> {
    pub values: &'a mut [f64],
    /// Largest magnitude (cells).
    pub far: f64,
    pub spacing: f64,
}

impl pulp::NullaryFnOnce for Roots<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        const GROUP: usize = 16;
        let square = self.far * self.far;
        let replace = |value: &mut f64| {
            let found = value.abs();
            let root = if found < square { found.sqrt() } else { self.far };
            *value = signed(*value, root * self.spacing);
        };
        let mut groups = self.values.chunks_exact_mut(GROUP);
        for group in &mut groups {
            // Most of a narrow band's grid lies beyond it: roots cost as much as all the rest.
            if group.iter().fold(false, |any, v| any | (v.abs() < square)) {
                group.iter_mut().for_each(replace);
            } else {
                let far = self.far * self.spacing;
                group.iter_mut().for_each(|value| *value = signed(*value, far));
            }
        }
        groups.into_remainder().iter_mut().for_each(replace);
    }
}
