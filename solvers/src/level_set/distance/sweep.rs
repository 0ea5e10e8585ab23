//! Nearest contour element of every node, in linear time.
//!
//! Element numbers travel from row to row (from plane to plane in space): a
//! node takes over a neighbour's element if that lies closer. The straight way
//! from a node to its element rises or falls, never both, so one lane of rising
//! and one of falling rows find it independently, on two threads (Danielsson
//! 1980, sequential vector distances, with sub-cell sites). Most neighbours
//! share their element, which costs one comparison of integers.

use super::Lattice;

/// Where elements sit and which nodes know them from the start.
pub(super) struct Sites<'a> {
    pub lattice: &'a Lattice,
    /// `[x, y, z, _]` in cells; number 0 means none. Single precision picks the
    /// element only: an error of 1e-7 of the distance, never of the contour.
    pub points: &'a [[f32; 4]],
    /// (node, element), sorted by row.
    pub seeds: &'a [(u32, u32)],
    /// First seed of each row, and their number.
    pub row_start: &'a [u32],
    /// Elements at this squared distance or farther are not passed on.
    pub reach: f32,
}

/// Best element so far and its squared distance, one padding node at each end of a row.
#[derive(Default)]
pub(super) struct Lane {
    pub element: Vec<u32>,
    pub distance: Vec<f32>,
}

impl Lane {
    pub(super) fn new(lattice: &Lattice) -> Self {
        let n = lattice.rows() * (lattice.shape[2] + 2);
        Self { element: vec![0; n], distance: vec![0.0; n] }
    }
}

struct Row {
    y: f32,
    z: f32,
}

impl Sites<'_> {
    /// Fills `lane` from the first row to the last, or back.
    pub(super) fn sweep(&self, lane: &mut Lane, rising: bool) {
        match (self.lattice.periodic, self.lattice.shape[0] > 1) {
            (false, false) => self.sweep_plane::<false>(lane, 0, rising, true),
            (true, false) => self.sweep_plane::<true>(lane, 0, rising, true),
            (false, true) => self.sweep_space::<false>(lane, rising),
            (true, true) => self.sweep_space::<true>(lane, rising),
        }
    }

    fn sweep_space<const P: bool>(&self, lane: &mut Lane, rising: bool) {
        let [nz, ny, nx] = self.lattice.shape;
        let width = nx + 2;
        for step in 0..rounds::<P>(nz) {
            let k = if rising { step % nz } else { nz - 1 - step % nz };
            if step < nz {
                (0..ny).for_each(|j| self.start_row(lane, k * ny + j));
            }
            let before = match (rising, step) {
                (_, 0) => None,
                (true, _) => Some((k + nz - 1) % nz),
                (false, _) => Some((k + 1) % nz),
            };
            for j in 0..if before.is_some() { ny } else { 0 } {
                for other in -1..=1 {
                    let row = j as isize + other;
                    if !P && !(0..ny as isize).contains(&row) {
                        continue;
                    }
                    let row = row.rem_euclid(ny as isize) as usize;
                    let from = before.unwrap_or(k) * ny + row;
                    self.pull::<P>(lane, width, from, k * ny + j);
                }
            }
            self.sweep_plane::<P>(lane, k, true, false);
            self.sweep_plane::<P>(lane, k, false, false);
        }
    }

    /// Rows of plane `k` up or down; `fresh` rows start from their seeds.
    fn sweep_plane<const P: bool>(&self, lane: &mut Lane, k: usize, rising: bool, fresh: bool) {
        let [_, ny, nx] = self.lattice.shape;
        let width = nx + 2;
        for step in 0..rounds::<P>(ny) {
            let at = |s: usize| k * ny + if rising { s % ny } else { ny - 1 - s % ny };
            if fresh && step < ny {
                self.start_row(lane, at(step));
            }
            if step > 0 {
                self.pull::<P>(lane, width, at(step - 1), at(step));
            }
            self.run_row::<P>(lane, width, at(step));
        }
    }

    /// Forgets row `row` and writes its seeds.
    fn start_row(&self, lane: &mut Lane, row: usize) {
        let nx = self.lattice.shape[2];
        let first = row * (nx + 2);
        lane.element[first..first + nx + 2].fill(0);
        lane.distance[first..first + nx + 2].fill(self.reach);
        let place = self.row(row);
        let seeds = self.row_start[row] as usize..self.row_start[row + 1] as usize;
        for &(node, element) in &self.seeds[seeds] {
            let i = node as usize - row * nx;
            // Seeds are near: no wrap is shorter than half a period, except across the seam.
            let d = self.squared::<true>(element, i as f32, &place);
            if d < lane.distance[first + 1 + i] {
                lane.distance[first + 1 + i] = d;
                lane.element[first + 1 + i] = element;
            }
        }
    }

    fn row(&self, row: usize) -> Row {
        let ny = self.lattice.shape[1];
        Row { y: (row % ny) as f32, z: (row / ny) as f32 }
    }

    /// Offers the three neighbours of row `from` to each node of row `to`.
    #[inline(always)]
    fn pull<const P: bool>(&self, lane: &mut Lane, width: usize, from: usize, to: usize) {
        let place = self.row(to);
        let (low, high) = (from.min(to), from.max(to));
        let (head, tail) = lane.element.split_at_mut(high * width);
        let (first, second) = (&mut head[low * width..][..width], &mut tail[..width]);
        let (source, target): (&[u32], &mut [u32]) =
            if from < to { (first, second) } else { (second, first) };
        if from == to {
            return;
        }
        let distance = &mut lane.distance[to * width..][..width];
        let inner = target[1..width - 1].iter_mut().zip(&mut distance[1..width - 1]);
        for (i, ((element, d), near)) in inner.zip(source.windows(3)).enumerate() {
            self.offer::<P>(near[1], element, d, i as f32, &place);
            self.offer::<P>(near[0], element, d, i as f32, &place);
            self.offer::<P>(near[2], element, d, i as f32, &place);
        }
    }

    /// Passes elements along a row, right and left, and refreshes its padding.
    #[inline(always)]
    fn run_row<const P: bool>(&self, lane: &mut Lane, width: usize, row: usize) {
        let place = self.row(row);
        let element = &mut lane.element[row * width..][..width];
        let distance = &mut lane.distance[row * width..][..width];
        let nx = width - 2;
        for _ in 0..if P { 2 } else { 1 } {
            let mut last = if P { element[nx] } else { 0 };
            for (i, (e, d)) in element[1..=nx].iter_mut().zip(&mut distance[1..=nx]).enumerate() {
                self.offer::<P>(last, e, d, i as f32, &place);
                last = *e;
            }
            let mut last = if P { element[1] } else { 0 };
            let inner = element[1..=nx].iter_mut().zip(&mut distance[1..=nx]).enumerate();
            for (i, (e, d)) in inner.rev() {
                self.offer::<P>(last, e, d, i as f32, &place);
                last = *e;
            }
        }
        if P {
            element[0] = element[nx];
            element[width - 1] = element[1];
        }
    }

    #[inline(always)]
    fn offer<const P: bool>(&self, new: u32, old: &mut u32, d: &mut f32, x: f32, row: &Row) {
        if new != *old {
            let found = self.squared::<P>(new, x, row);
            if found < *d {
                *d = found;
                *old = new;
            }
        }
    }

    /// Squared distance; infinite for element 0, whose point is infinitely far.
    #[inline(always)]
    fn squared<const P: bool>(&self, element: u32, x: f32, row: &Row) -> f32 {
        let [px, py, pz, _] = self.points[element as usize];
        let mut w = [x - px, row.y - py, row.z - pz];
        if P {
            for (w, period) in w.iter_mut().zip(self.lattice.period) {
                let apart = w.abs();
                *w = if apart > 0.5 * period { period - apart } else { apart };
            }
        }
        w[0] * w[0] + w[1] * w[1] + w[2] * w[2]
    }
}

/// Rows to visit: a periodic way crosses the seam at most once and is at most half a period long.
fn rounds<const P: bool>(n: usize) -> usize {
    if P { n + n / 2 + 1 } else { n }
}
