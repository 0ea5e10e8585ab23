//! The energy and its gradient on a slab of planes.
//!
//! Plane by plane and row by row, derivatives of the density are computed into three rows
//! that stay in the first-level cache, and are gathered from there into the gradient's own
//! plane and the two next to it. What falls on planes of other slabs is kept aside until all
//! are done ([`join`]); a voxel's sum is always own + plane above + plane below, so that any
//! slabs give the same bytes.

use super::Edges;
use super::assemble::{assemble, assemble_at};
use super::local::{Constants, FIELDS, Weights};
use super::row::{RowWeights, Stages, row};
use super::rows::{Along, CHUNK, Near, PAD, chunks, stride};
use solvers::{Aligned, Float};

/// Number of rows of weights: c1 to c6, mu, theta.
pub(super) const WEIGHTS: usize = 10;

/// Where the weights come from.
#[derive(Clone, Debug)]
pub(super) enum Source<T> {
    /// The same at all voxels, without orientation.
    Uniform(Weights<T>),
    /// One number each, or a value at each voxel.
    Fields(Vec<Spread<T>>),
}

/// One number, or a value at each voxel.
#[derive(Clone, Debug)]
pub(super) enum Spread<T> {
    Number(T),
    Map(Vec<T>),
}

/// Where contributions of a plane go: to the gradient from a number on, or to one of
/// [`Work::aside`].
#[derive(Clone, Copy)]
enum Target {
    Gradient(usize),
    Aside(usize),
}

/// Numbers in [`Work::aside`] of contributions to the planes before and behind the slab.
const BEFORE: usize = 3;
const BEHIND: usize = 4;
/// Number of those to the plane before within a slab.
const WITHIN: usize = 5;

/// Number in [`Work::aside`] of what plane `k - 1` contributes to plane `k`.
fn turn(k: isize) -> usize {
    k.rem_euclid(3) as usize
}

/// Adds what slabs of `planes` planes kept aside for each other.
pub(super) fn join<T: Float>(
    work: &[Work<T>],
    edges: Edges,
    [planes, plane]: [usize; 2],
    gradient: &mut [T],
) {
    let last = work.len() - 1;
    let periodic = edges == Edges::Periodic;
    for (index, gradient) in gradient.chunks_mut(planes * plane).enumerate() {
        let count = gradient.len() / plane;
        let end = &mut gradient[(count - 1) * plane..];
        if periodic || index < last {
            add(end, &work[if index < last { index + 1 } else { 0 }].aside[BEFORE]);
        }
        if count > 1 {
            let k = index * planes + count - 1;
            add(end, &work[index].aside[turn(k as isize)]);
        }
        if periodic || index > 0 {
            let before = if index > 0 { index - 1 } else { last };
            add(&mut gradient[..plane], &work[before].aside[BEHIND]);
        }
    }
}

#[inline(always)]
fn add<T: Float>(sums: &mut [T], terms: &[T]) {
    for (sum, &term) in sums.iter_mut().zip(terms) {
        *sum = *sum + term;
    }
}

/// What all slabs share.
pub(super) struct Job<'a, T> {
    pub(super) shape: [usize; 3],
    pub(super) edges: Edges,
    pub(super) k: Constants<T>,
    pub(super) source: &'a Source<T>,
    pub(super) u: &'a [T],
}

/// Buffers of one slab.
#[derive(Clone, Debug)]
pub(super) struct Work<T> {
    /// Three planes of u, padded on all sides.
    planes: Aligned<T>,
    /// Derivatives in three rows, and a row of zeros.
    slots: [Aligned<T>; 4],
    /// Contributions of a row to three planes.
    parts: [Aligned<T>; 3],
    /// Contributions that wait: in turn those of a plane to the next one, added last; those to
    /// the planes before and behind the slab; those to the plane before, where rows beyond the
    /// faces fall on the outer rows too and must be added up as other slabs add them.
    aside: [Aligned<T>; 6],
    energy: Vec<[T; CHUNK]>,
    stages: Box<Stages<T>>,
    weights: Aligned<T>,
}

impl<T: Float> Work<T> {
    pub(super) fn new([_, ny, nx]: [usize; 3], general: bool) -> Self {
        let (zero, stride) = (T::from_f64(0.0), stride(nx));
        Self {
            planes: Aligned::new(3 * (ny + 2) * stride, zero),
            slots: std::array::from_fn(|_| Aligned::new(FIELDS * stride, zero)),
            parts: std::array::from_fn(|_| Aligned::new(stride, zero)),
            aside: std::array::from_fn(|_| Aligned::default()),
            energy: vec![[zero; CHUNK]; nx.div_ceil(CHUNK)],
            stages: Box::new(Stages::new()),
            weights: Aligned::new(if general { WEIGHTS * stride } else { 0 }, zero),
        }
    }
}

impl<T: Float> Job<'_, T> {
    /// Densities of the planes from `first` on, one sum each into `energies`, and the
    /// gradient of these planes into `gradient`, unless it is empty.
    #[inline(always)]
    pub(super) fn run<const KIND: u8>(
        &self,
        first: usize,
        energies: &mut [f64],
        gradient: &mut [T],
        work: &mut Work<T>,
    ) {
        let [nz, ny, nx] = self.shape;
        let (start, end) = (first as isize, (first + energies.len()) as isize);
        let plane = ny * nx;
        let bounds = self.edges.energy_range(nz);
        let (periodic, wanted) = (self.edges == Edges::Periodic, !gradient.is_empty());
        let zero = T::from_f64(0.0);
        energies.fill(0.0);
        if wanted {
            for aside in &mut work.aside {
                if aside.len() == plane {
                    aside.fill(zero);
                } else {
                    *aside = Aligned::new(plane, zero);
                }
            }
        }
        for near in [start - 1, start] {
            self.load(near, work);
        }
        for k in start..end {
            self.load(k + 1, work);
            let own = (k - start) as usize * plane;
            let mut targets = None;
            if wanted {
                // In a periodic box the first contributions to these are stored, not added.
                if !periodic {
                    gradient[own..][..plane].fill(zero);
                    work.aside[turn(k + 1)].fill(zero);
                    work.aside[WITHIN].fill(zero);
                }
                // Contributions that leave the box fall on the plane they were copied from.
                let above = match k + 1 {
                    next if !periodic && next == nz as isize => Target::Gradient(own),
                    next if next < end => Target::Aside(turn(next)),
                    _ => Target::Aside(BEHIND),
                };
                let below = match k {
                    0 if !periodic => Target::Gradient(own),
                    _ if k == start => Target::Aside(BEFORE),
                    _ if periodic => Target::Gradient(own - plane),
                    _ => Target::Aside(WITHIN),
                };
                targets = Some([Target::Gradient(own), above, below]);
            }
            if periodic || bounds.contains(&k) {
                energies[(k - start) as usize] = self.plane::<KIND>(k, targets, gradient, work);
            }
            if wanted && k > start {
                let before = &mut gradient[own - plane..][..plane];
                if !periodic {
                    add(before, &work.aside[WITHIN]);
                }
                if k > start + 1 {
                    add(before, &work.aside[turn(k - 1)]);
                }
            }
        }
    }

    /// One plane: returns the sum of its densities.
    #[inline(always)]
    fn plane<const KIND: u8>(
        &self,
        k: isize,
        targets: Option<[Target; 3]>,
        gradient: &mut [T],
        work: &mut Work<T>,
    ) -> f64 {
        let [_, ny, nx] = self.shape;
        let rows = self.edges.energy_range(ny);
        let periodic = self.edges == Edges::Periodic;
        let mut sum = 0.0;
        // Row j is gathered when row j + 1 is there.
        let last = ny as isize + isize::from(!periodic);
        for j in -1..=last {
            let inside = (0..ny as isize).contains(&j);
            if rows.contains(&j) || (periodic && targets.is_some()) {
                self.derivatives::<KIND>(k, j, work);
                if inside {
                    sum += self.row_sum(&work.energy);
                }
            }
            let gathered = j - 1;
            let Some(targets) = targets else { continue };
            if gathered < if periodic { 0 } else { -1 } {
                continue;
            }
            self.gather(gathered, work);
            let row = gathered.clamp(0, ny as isize - 1) as usize * nx;
            for (place, (target, part)) in targets.iter().zip(&work.parts).enumerate() {
                let (sums, added) = match *target {
                    Target::Gradient(first) => {
                        (&mut gradient[first + row..][..nx], !periodic || place > 0)
                    }
                    Target::Aside(n) => (&mut work.aside[n][row..][..nx], !periodic),
                };
                let part = &part[PAD..][..nx];
                if added {
                    add(sums, part);
                } else {
                    sums.copy_from_slice(part);
                }
            }
        }
        sum
    }

    /// Derivatives of the density in row `j` of plane `k` into the row's slot.
    #[inline(always)]
    fn derivatives<const KIND: u8>(&self, k: isize, j: isize, work: &mut Work<T>) {
        let [nz, ny, nx] = self.shape;
        let stride = stride(nx);
        let count = nx.div_ceil(CHUNK);
        // Rows -1 and ny are copies of ghost rows, whose own neighbours are not there.
        let inside = if self.edges == Edges::Periodic { j.rem_euclid(ny as isize) } else { j };
        let Work { planes, slots, energy, weights, stages, .. } = work;
        let at = |k: isize, j: isize| {
            let plane = (k + 3).rem_euclid(3) as usize;
            &planes[(plane * (ny + 2) + (j + 1) as usize) * stride..][..stride]
        };
        let near = Near {
            plane: [-1, 0, 1].map(|step| Along::new(at(k, inside + step), count)),
            below: Along::new(at(k - 1, inside), count),
            above: Along::new(at(k + 1, inside), count),
            corners: [
                chunks(at(k - 1, inside - 1), 0, count),
                chunks(at(k - 1, inside + 1), 0, count),
                chunks(at(k + 1, inside - 1), 0, count),
                chunks(at(k + 1, inside + 1), 0, count),
            ],
        };
        let slot = &mut slots[(j + 3).rem_euclid(3) as usize];
        match self.source {
            Source::Uniform(uniform) => {
                let weights = RowWeights::Uniform(*uniform);
                row::<T, KIND>(&near, &weights, &self.k, stages, energy, slot);
            }
            Source::Fields(fields) => {
                let line = k.rem_euclid(nz as isize) as usize * ny + inside as usize;
                for (row, field) in weights.chunks_exact_mut(stride).zip(fields) {
                    match field {
                        Spread::Number(value) => row.fill(*value),
                        Spread::Map(values) => {
                            row[PAD..PAD + nx].copy_from_slice(&values[line * nx..][..nx]);
                        }
                    }
                }
                let mut rows: [&[[T; CHUNK]]; WEIGHTS] = [&[]; WEIGHTS];
                for (rows, row) in rows.iter_mut().zip(weights.chunks_exact(stride)) {
                    *rows = chunks(row, 0, count);
                }
                let weights = RowWeights::Fields(rows);
                row::<T, KIND>(&near, &weights, &self.k, stages, energy, slot);
            }
        }
        self.fill_ghosts(slot);
    }

    /// Derivatives beyond a row's ends: the other end's, or none.
    #[inline(always)]
    fn fill_ghosts(&self, slot: &mut [T]) {
        let nx = self.shape[2];
        for row in slot.chunks_exact_mut(stride(nx)) {
            if self.edges == Edges::Periodic {
                row[PAD - 1] = row[PAD + nx - 1];
                row[PAD + nx] = row[PAD];
            } else {
                let range = self.edges.energy_range(nx);
                let (low, high) = (range.start as usize, range.end as usize);
                row[PAD - 2..PAD + low].fill(T::from_f64(0.0));
                row[PAD + high..PAD + nx + 2].fill(T::from_f64(0.0));
            }
        }
    }

    /// Contributions of row `j`, or of what falls on ghost row `j`, into the three parts.
    #[inline(always)]
    fn gather(&self, j: isize, work: &mut Work<T>) {
        let [_, ny, nx] = self.shape;
        let rows = self.edges.energy_range(ny);
        let Work { slots, parts, .. } = work;
        let slot = |j: isize| {
            let there = self.edges == Edges::Periodic || rows.contains(&j);
            &slots[if there { (j + 3).rem_euclid(3) as usize } else { 3 }][..]
        };
        let near = [slot(j - 1), slot(j), slot(j + 1)];
        let [own, above, below] = parts;
        assemble(&near, &self.k, nx.div_ceil(CHUNK), [own, above, below]);
        if self.edges != Edges::Periodic {
            for (ghost, inside) in [(PAD - 1, PAD), (PAD + nx, PAD + nx - 1)] {
                let values = assemble_at(&near, &self.k, ghost);
                for (part, value) in parts.iter_mut().zip(values) {
                    part[inside] = part[inside] + value;
                }
            }
        }
    }

    /// Sum of a row's densities, in 16 lanes.
    #[inline(always)]
    fn row_sum(&self, energy: &[[T; CHUNK]]) -> f64 {
        let nx = self.shape[2];
        let range = self.edges.energy_range(nx);
        let (low, high) = (range.start as usize, range.end as usize);
        let mut lanes = [0.0; CHUNK];
        for (j, chunk) in energy.iter().enumerate() {
            let first = j * CHUNK;
            if first >= low && first + CHUNK <= high {
                for i in 0..CHUNK {
                    lanes[i] += chunk[i].to_f64();
                }
            } else {
                for i in low.max(first)..high.min(first + CHUNK) {
                    lanes[i - first] += chunk[i - first].to_f64();
                }
            }
        }
        lanes.iter().sum()
    }

    /// Copies plane `k` of u, or what stands for it beyond the box, with its ghosts.
    #[inline(always)]
    fn load(&self, k: isize, work: &mut Work<T>) {
        let [nz, ny, nx] = self.shape;
        let stride = stride(nx);
        let source = self.edges.inside(k, nz) * ny;
        let slot = (k + 3).rem_euclid(3) as usize * (ny + 2);
        let rows = work.planes[slot * stride..][..(ny + 2) * stride].chunks_exact_mut(stride);
        for (j, row) in (-1_isize..).zip(rows) {
            let line = source + self.edges.inside(j, ny);
            row[PAD..PAD + nx].copy_from_slice(&self.u[line * nx..][..nx]);
            row[PAD - 1] = row[PAD + self.edges.inside(-1, nx)];
            row[PAD + nx] = row[PAD + self.edges.inside(nx as isize, nx)];
        }
    }
}
