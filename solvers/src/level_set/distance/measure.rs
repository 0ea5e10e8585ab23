//! The distance from every node to its nearest piece.

use super::sweep::Lane;
use super::{Lattice, Pieces};
use rayon::prelude::*;

/// Rows and columns of a tile: the lane of the x axis is stored across the rows.
const ROWS: usize = 16;
const COLUMNS: usize = 64;

/// The last step: signs from the field, magnitudes from the pieces.
pub(super) struct Finish<'a> {
    pub lattice: &'a Lattice,
    pub pieces: &'a Pieces,
    /// Finds stored `[z][y][x]` and `[x][z][y]`.
    pub lanes: &'a [Lane; 2],
    /// Magnitude where no piece is known (cells).
    pub far: f64,
    /// Whether pieces follow each other along lines by their numbers.
    pub chained: bool,
    /// Length of a cell.
    pub spacing: f64,
}

/// Pieces of the nodes in a stretch of a row, component by component.
struct Stretch {
    w: [[f64; COLUMNS]; 3],
    normal: [[f64; COLUMNS]; 3],
    curvature: [f64; COLUMNS],
    extent: [f64; COLUMNS],
}

impl Finish<'_> {
    /// Replaces all values.
    pub(super) fn run(&self, phi: &mut [f64], parallel: bool) {
        let [_, ny, nx] = self.lattice.shape;
        for (k, plane) in phi.chunks_mut(ny * nx).enumerate() {
            if parallel {
                let blocks = plane.par_chunks_mut(ROWS * nx).enumerate();
                blocks.for_each(|(block, values)| self.block(k, block * ROWS, values));
            } else {
                let blocks = plane.chunks_mut(ROWS * nx).enumerate();
                blocks.for_each(|(block, values)| self.block(k, block * ROWS, values));
            }
        }
    }

    /// Rows from `j0` on, tile by tile.
    fn block(&self, k: usize, j0: usize, values: &mut [f64]) {
        let [nz, ny, nx] = self.lattice.shape;
        let [yz, x] = self.lanes;
        let rows = values.len() / nx;
        let arch = pulp::Arch::new();
        let mut elements = [[0_u32; COLUMNS]; ROWS];
        let mut turned = [([0_u32; ROWS], [0.0_f32; ROWS]); COLUMNS];
        let mut stretch = Stretch {
            w: [[0.0; COLUMNS]; 3],
            normal: [[0.0; COLUMNS]; 3],
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
            for (r, elements) in elements[..rows].iter_mut().enumerate() {
                if self.chained {
                    self.descend([k, j0 + r, i0], &mut elements[..columns]);
                }
                let values = &mut values[r * nx + i0..][..columns];
                if elements[..columns].iter().all(|&number| number == 0) {
                    let far = self.far * self.spacing;
                    values.iter_mut().for_each(|value| *value = signed(*value, far));
                } else if nz > 1 {
                    self.in_space([k, j0 + r, i0], elements, values);
                } else {
                    self.gather([k, j0 + r, i0], &elements[..columns], &mut stretch);
                    arch.dispatch(Distances {
                        s: &stretch,
                        values,
                        far: self.far,
                        spacing: self.spacing,
                    });
                }
            }
        }
    }

    /// Moves to the next or previous piece while that is nearer.
    fn descend(&self, [k, j, i0]: [usize; 3], elements: &mut [u32]) {
        let all = &self.pieces.elements;
        for (c, number) in elements.iter_mut().enumerate().filter(|(_, number)| **number != 0) {
            let to = |n: usize| all[n].distance(self.offset([k, j, i0 + c], all[n].point));
            let mut n = *number as usize;
            let mut nearest = to(n);
            for up in [true, false] {
                loop {
                    let next = if up { n + 1 } else { n - 1 };
                    if next == 0 || next == all.len() || to(next) >= nearest {
                        break;
                    }
                    (n, nearest) = (next, to(next));
                }
            }
            *number = n as u32;
        }
    }

    /// Collects what the distances of a stretch need.
    #[inline(always)]
    fn gather(&self, [k, j, i0]: [usize; 3], elements: &[u32], s: &mut Stretch) {
        for (c, &number) in elements.iter().enumerate() {
            let element = &self.pieces.elements[number as usize];
            let w = self.offset([k, j, i0 + c], element.point);
            for m in 0..3 {
                s.w[m][c] = w[m];
                s.normal[m][c] = element.normal[m];
            }
            s.curvature[c] = element.curvature;
            s.extent[c] = element.extent;
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
            let mut distance = self.far;
            if number != 0 {
                let element = &self.pieces.elements[number as usize];
                let w = self.offset([k, j, i0 + c], element.point);
                let shape = &self.pieces.shapes[number as usize];
                distance = element.in_space(shape, w).distance(w).min(self.far);
            }
            *value = signed(*value, distance * self.spacing);
        }
    }
}

/// The distances of a stretch of plane values.
struct Distances<'a> {
    s: &'a Stretch,
    values: &'a mut [f64],
    far: f64,
    spacing: f64,
}

impl pulp::NullaryFnOnce for Distances<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { s, values, far, spacing } = self;
        for (c, value) in values.iter_mut().enumerate().take(COLUMNS) {
            let element = super::Element {
                point: [0.0; 3],
                normal: [s.normal[0][c], s.normal[1][c], 0.0],
                curvature: s.curvature[c],
                extent: s.extent[c],
            };
            let distance = element.distance([s.w[0][c], s.w[1][c], 0.0]);
            // Unknown pieces are infinitely far: the comparison fails for inf and NaN.
            let distance = if distance < far { distance } else { far };
            *value = signed(*value, distance * spacing);
        }
    }
}

#[inline(always)]
fn signed(sign: f64, distance: f64) -> f64 {
    let outward = if sign < 0.0 { -distance } else { distance };
    if sign == 0.0 { 0.0 } else { outward }
}
