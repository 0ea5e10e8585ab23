//! The product of the finest level, without a matrix.

use super::bands::Bands;
use super::constraints::Constraints;
use super::element::{Element, Row, force_len};
use super::lattice::{Layout, SLACK};
use super::real::Real;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// `K = sum_e E_e Ke` over the elements of a lattice.
#[derive(Clone, Debug)]
pub(super) struct Fine<T> {
    pub layout: Layout,
    element: Element<T>,
    /// Per row of elements as long as a component of a row of nodes, element i at place i + 1.
    stiffness: Vec<T>,
    constraints: Arc<Constraints>,
}

/// Work space of a band of rows.
#[derive(Clone, Debug)]
pub(super) struct Work<T> {
    /// Forces of the row of elements before a row of nodes, and of the one behind it.
    before: Vec<T>,
    behind: Vec<T>,
    /// Forces of the plane of elements before a plane of nodes, row by row.
    carry: Vec<T>,
    /// The product's row, components [`Layout::wide`] apart.
    pub product: Vec<T>,
}

impl<T: Real> Work<T> {
    pub(super) fn new(layout: &Layout) -> Self {
        let zeros = |len| vec![T::default(); len];
        let forces = force_len(layout);
        let carry = if layout.lattice.dim() == 3 { layout.lines() * layout.row_len() } else { 0 };
        Self {
            before: zeros(forces),
            behind: zeros(forces),
            carry: zeros(carry),
            product: zeros(layout.components * layout.wide()),
        }
    }

    /// Work space of a level with stencils.
    pub(super) fn of_stencil(layout: &Layout) -> Self {
        let product = vec![T::default(); layout.components * layout.wide()];
        Self { before: Vec::new(), behind: Vec::new(), carry: Vec::new(), product }
    }
}

impl<T: Real> Fine<T> {
    pub(super) fn new(layout: Layout, ke: &[f64], constraints: Arc<Constraints>) -> Self {
        let dim = layout.lattice.dim();
        let [nz, ny, _] = layout.lattice.elements();
        let stiffness = vec![T::default(); nz * ny * layout.stride + SLACK];
        Self { layout, element: Element::new(ke, dim, layout.components), stiffness, constraints }
    }

    pub(super) fn set_constraints(&mut self, constraints: Arc<Constraints>) {
        self.constraints = constraints;
    }

    /// Takes over the stiffness of each element, times `scale` and at least `smallest`.
    pub(super) fn set_stiffness(&mut self, stiffness: &[f64], scale: f64, smallest: f64) {
        let nx = self.layout.lattice.elements()[2];
        let rows = self.stiffness.chunks_exact_mut(self.layout.stride);
        for (row, values) in rows.zip(stiffness.chunks_exact(nx)) {
            for (slot, value) in row[1..].iter_mut().zip(values) {
                *slot = T::from_f64((value * scale).max(smallest));
            }
        }
    }

    /// Bands for the product: planes in 3D, since a band repeats the work of the row or
    /// plane of elements before it.
    pub(super) fn bands(layout: &Layout) -> Bands {
        let unit = if layout.lattice.dim() == 3 { layout.lines() } else { 1 };
        Bands::new(layout.rows(), unit, layout.row_len())
    }

    /// Calls `each(row, that row of K x)` for a band of rows of nodes, in order.
    pub(super) fn product(
        &self,
        x: &[T],
        rows: Range<usize>,
        work: &mut Work<T>,
        mut each: impl FnMut(usize, &mut [T]),
    ) {
        if self.layout.lattice.dim() == 2 {
            return self.plane(0, rows, x, work, &mut each);
        }
        let lines = self.layout.lines();
        let (first, end) = (rows.start / lines, rows.end / lines);
        work.carry.fill(T::default());
        if first > 0 {
            self.plane(first - 1, 0..lines, x, work, &mut |_, _| ());
        }
        for k in first..end {
            self.plane(k, 0..lines, x, work, &mut each);
        }
    }

    /// The rows of nodes `lines` of plane `k`, finished by the elements behind them.
    fn plane(
        &self,
        k: usize,
        lines: Range<usize>,
        x: &[T],
        work: &mut Work<T>,
        each: &mut impl FnMut(usize, &mut [T]),
    ) {
        let layout = &self.layout;
        let row_len = layout.row_len();
        self.forces(k, lines.start.checked_sub(1), x, &mut work.before);
        for j in lines {
            self.forces(k, Some(j), x, &mut work.behind);
            let sums = Sums {
                layout,
                before: &work.before,
                behind: &work.behind,
                product: &mut work.product,
                carry: work.carry.get_mut(j * row_len..(j + 1) * row_len),
            };
            pulp::Arch::new().dispatch(
                #[inline(always)]
                || sums.run(),
            );
            let row = k * layout.lines() + j;
            self.constrain(row, &x[row * row_len..], &mut work.product);
            each(row, &mut work.product);
            std::mem::swap(&mut work.before, &mut work.behind);
        }
    }

    /// Adds the springs' forces, and removes those on fixed unknowns.
    fn constrain(&self, row: usize, x: &[T], product: &mut [T]) {
        let slack = |place: usize| place / self.layout.stride * SLACK;
        for &(place, stiffness) in self.constraints.springs.row(row) {
            let place = place as usize;
            let sum = &mut product[place + slack(place)];
            *sum = *sum + T::from_f64(stiffness) * x[place];
        }
        for &place in self.constraints.fixed.row(row) {
            product[place as usize + slack(place as usize)] = T::default();
        }
    }

    /// Writes 1 / diagonal, 0 where an unknown is fixed.
    pub(super) fn inverse_diagonal(&self, ke: &[f64], inverse: &mut [f32]) {
        let layout = &self.layout;
        let n = layout.lattice.corners() * layout.components;
        // Beyond the last row there may be room for another.
        let rows = inverse.par_chunks_exact_mut(layout.row_len()).take(layout.rows()).enumerate();
        rows.for_each_init(
            || vec![0.0; layout.row_len()],
            |sums, (row, inverse)| {
                sums.fill(0.0);
                for (entry, own) in ke.iter().step_by(n + 1).enumerate() {
                    let (a, c) = (entry / layout.components, entry % layout.components);
                    self.add_row(row, a, *own, &mut sums[layout.span(c)]);
                }
                for &(place, stiffness) in self.constraints.springs.row(row) {
                    sums[place as usize] += stiffness;
                }
                for &place in self.constraints.fixed.row(row) {
                    sums[place as usize] = 0.0;
                }
                for (inverse, sum) in inverse.iter_mut().zip(&*sums) {
                    *inverse = if *sum > 0.0 { (1.0 / sum) as f32 } else { 0.0 };
                }
            },
        );
    }

    /// Adds `factor E` of the elements whose corner `a` lies in a row of nodes.
    fn add_row(&self, row: usize, a: usize, factor: f64, sums: &mut [f64]) {
        let (layout, [planes, lines, nx]) = (&self.layout, self.layout.lattice.elements());
        let k = (row / layout.lines()).checked_sub(a >> 2 & 1);
        let j = (row % layout.lines()).checked_sub(a >> 1 & 1);
        if let (Some(k), Some(j)) = (k, j)
            && k < planes
            && j < lines
        {
            let stiffness = &self.stiffness[(k * lines + j) * layout.stride + 1..][..nx];
            for (sum, stiffness) in sums[a & 1..].iter_mut().zip(stiffness) {
                *sum += factor * stiffness.to_f64();
            }
        }
    }

    /// Forces of row `j` of elements in plane `k`: 0 if there is none.
    fn forces(&self, k: usize, j: Option<usize>, x: &[T], forces: &mut [T]) {
        let layout = &self.layout;
        let (lines, row_len) = (layout.lines(), layout.row_len());
        let [planes, rows, _] = layout.lattice.elements();
        let Some(j) = j.filter(|&j| j < rows && k < planes) else {
            return forces.fill(T::default());
        };
        let last = layout.rows() - 1;
        // In 2D there are no rows behind, and none are read.
        let row = |dk: usize, dj: usize| &x[((k + dk) * lines + j + dj).min(last) * row_len..];
        Row {
            element: &self.element,
            layout,
            nodes: [row(0, 0), row(0, 1), row(1, 0), row(1, 1)],
            stiffness: &self.stiffness[(k * rows + j) * layout.stride..],
            forces,
        }
        .apply();
    }
}

/// Adds the forces on one row of nodes.
struct Sums<'a, T> {
    layout: &'a Layout,
    before: &'a [T],
    behind: &'a [T],
    product: &'a mut [T],
    carry: Option<&'a mut [T]>,
}

impl<T: Real> Sums<'_, T> {
    #[inline(always)]
    fn run(self) {
        let Self { layout, before, behind, product, mut carry } = self;
        let (nodes, wide) = (layout.lattice.nodes()[2], layout.wide());
        for c in 0..layout.components {
            let pair = |forces, line| pair(layout, forces, line, c);
            let product = &mut product[c * wide + 1..][..nodes];
            match &mut carry {
                None => add(pair(before, 1), pair(behind, 0), product),
                Some(carry) => {
                    let carry = &mut carry[layout.span(c)];
                    add_carried(pair(before, 1), pair(behind, 0), carry, product);
                    add(pair(before, 3), pair(behind, 2), carry);
                }
            }
        }
    }
}

/// Forces of the elements right and left of the nodes of `line` (y in bit 0, z in bit 1) of
/// a row of elements.
#[inline(always)]
fn pair<'a, T>(layout: &Layout, forces: &'a [T], line: usize, c: usize) -> [&'a [T]; 2] {
    let (nodes, wide) = (layout.lattice.nodes()[2], layout.wide());
    let first = (line * layout.components + c) * 2 * wide + 1;
    [&forces[first..][..nodes], &forces[first + wide..][..nodes]]
}

#[inline(always)]
fn add<T: Real>([a, b]: [&[T]; 2], [c, d]: [&[T]; 2], out: &mut [T]) {
    let n = out.len();
    let (a, b, c, d) = (&a[..n], &b[..n], &c[..n], &d[..n]);
    for i in 0..n {
        out[i] = (a[i] + b[i]) + (c[i] + d[i]);
    }
}

#[inline(always)]
fn add_carried<T: Real>([a, b]: [&[T]; 2], [c, d]: [&[T]; 2], carry: &[T], out: &mut [T]) {
    let n = out.len();
    let (a, b, c, d, carry) = (&a[..n], &b[..n], &c[..n], &d[..n], &carry[..n]);
    for i in 0..n {
        out[i] = ((a[i] + b[i]) + (c[i] + d[i])) + carry[i];
    }
}
