//! The squared distance from every node to the element that the sweeps found.

use super::elements::square;
use super::sweep::{Lane, column_stride};
use super::{Lattice, Pieces};

/// Rows and columns of a tile: the lane of the x axis is stored across the rows, and
/// fetched by two cache lines at a time.
const ROWS: usize = 32;
const COLUMNS: usize = 128;

/// Signs from the field, magnitudes from the elements.
pub(super) struct Finish<'a> {
    pub lattice: &'a Lattice,
    pub pieces: &'a Pieces,
    /// Finds along y and z, and along x.
    pub lanes: &'a [Lane; 2],
    /// Squared distance where no element is known (cells).
    pub far: f64,
    /// Squared distance below which `far` is written, for others to measure (cells).
    pub near: f64,
}

impl Finish<'_> {
    /// Replaces values by squared distances in rows from `first` on (of all planes, one after another).
    pub(super) fn run(&self, first: usize, values: &mut [f64]) {
        let [_, ny, nx] = self.lattice.shape;
        let (mut row, mut rest) = (first, values);
        while !rest.is_empty() {
            // A tile lies within one plane.
            let j = row % ny;
            let rows = ROWS.min(ny - j).min(rest.len() / nx);
            let (tile, after) = rest.split_at_mut(rows * nx);
            self.tile_row(row / ny, j, tile);
            (row, rest) = (row + rows, after);
        }
    }

    /// Up to `ROWS` rows from `j0` on, tile by tile.
    fn tile_row(&self, k: usize, j0: usize, values: &mut [f64]) {
        let nx = self.lattice.shape[2];
        let rows = values.len() / nx;
        let arch = pulp::Arch::new();
        let mut tile =
            Tile { elements: [[0; COLUMNS]; ROWS], columns: [([0; ROWS], [0.0; ROWS]); COLUMNS] };
        for i0 in (0..nx).step_by(COLUMNS) {
            let columns = COLUMNS.min(nx - i0);
            let size = [rows, columns];
            arch.dispatch(Choose { finish: self, tile: &mut tile, first: [k, j0, i0], size });
            for (r, elements) in tile.elements[..rows].iter().enumerate() {
                let values = &mut values[r * nx + i0..][..columns];
                let elements = &elements[..columns];
                if elements.iter().all(|&number| number == 0) {
                    values.iter_mut().for_each(|value| *value = signed(*value, self.far));
                } else if self.lattice.plane() {
                    let first = [j0 + r, i0];
                    arch.dispatch(Squares { finish: self, elements, first, values });
                } else {
                    self.in_space([k, j0 + r, i0], elements, values);
                }
            }
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

    fn in_space(&self, [k, j, i0]: [usize; 3], elements: &[u32], values: &mut [f64]) {
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

/// Elements of the nodes of a tile, and the finds along x that they are chosen from.
struct Tile {
    elements: [[u32; COLUMNS]; ROWS],
    columns: [([u32; ROWS], [f32; ROWS]); COLUMNS],
}

/// Of the finds along y and z and those along x the nearer.
struct Choose<'a, 'b> {
    finish: &'a Finish<'b>,
    tile: &'a mut Tile,
    first: [usize; 3],
    /// Rows and columns.
    size: [usize; 2],
}

impl pulp::NullaryFnOnce for Choose<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { finish: Finish { lattice, lanes: [yz, x], .. }, tile, first, size } = self;
        let ([nz, ny, nx], [k, j0, i0], [rows, columns]) = (lattice.shape, first, size);
        let Tile { elements, columns: turned } = tile;
        let stride = column_stride(ny);
        // Far apart in memory: nothing but loads, so that many are under way at once.
        for (c, turned) in turned[..columns].iter_mut().enumerate() {
            let first = ((i0 + c) * nz + k) * stride + j0;
            let (e, d) = (&x.element[first..][..rows], &x.distance[first..][..rows]);
            if rows == ROWS {
                turned.0.copy_from_slice(&e[..ROWS]);
                turned.1.copy_from_slice(&d[..ROWS]);
            } else {
                turned.0[..rows].copy_from_slice(e);
                turned.1[..rows].copy_from_slice(d);
            }
        }
        for (r, elements) in elements[..rows].iter_mut().enumerate() {
            let n = (k * ny + j0 + r) * nx + i0;
            let straight = yz.element[n..][..columns].iter().zip(&yz.distance[n..][..columns]);
            for ((element, turned), (&se, &sd)) in elements.iter_mut().zip(&*turned).zip(straight) {
                // No branch: which axis knows better is hard to predict.
                let closer = u32::from(turned.1[r] < sd).wrapping_neg();
                *element = (turned.0[r] & closer) | (se & !closer);
            }
        }
    }
}

/// The squared distances of a stretch of plane values.
struct Squares<'a, 'b> {
    finish: &'a Finish<'b>,
    elements: &'a [u32],
    /// Node of the first value.
    first: [usize; 2],
    values: &'a mut [f64],
}

impl pulp::NullaryFnOnce for Squares<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { finish, elements, first: [j, i0], values } = self;
        let (far, near) = (finish.far, finish.near);
        // Elements as each node sees them: across, along, curvature, extent.
        let mut seen = [[0.0; COLUMNS]; 4];
        let [across, along, curvature, extent] = &mut seen;
        for (c, &number) in elements.iter().enumerate().take(COLUMNS) {
            let e = &finish.pieces.elements[number as usize];
            let [x, y, _] = finish.offset([0, j, i0 + c], e.point);
            across[c] = x * e.normal[0] + y * e.normal[1];
            along[c] = y * e.normal[0] - x * e.normal[1];
            curvature[c] = e.curvature;
            extent[c] = e.overlap;
        }
        for (c, value) in values.iter_mut().enumerate().take(COLUMNS) {
            let found = square(across[c], along[c], curvature[c], extent[c]);
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
            // The root of all: a root under a condition does not fill wide registers.
            let root = if found < square { found } else { square }.sqrt();
            let root = if found < square { root } else { self.far };
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
