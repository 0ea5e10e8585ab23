//! The energy and its gradient on a slab of planes.
//!
//! Plane by plane and row by row, derivatives of the density are computed into three rows
//! that stay in the first-level cache, and are gathered from there into the gradient's own
//! plane and the two next to it. A slab recomputes the planes next to it, so that slabs
//! need nothing of each other; a voxel's sums are always taken in the same order, so that
//! any slabs give the same bytes.

use super::Edges;
use super::assemble::{assemble, assemble_at};
use super::local::{Constants, FIELDS, Weights};
use super::row::{RowWeights, row};
use super::rows::{Along, CHUNK, Near, PAD, chunks, stride};
use solvers::Float;

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
    planes: Vec<T>,
    /// Derivatives in three rows, and a row of zeros.
    slots: [Vec<T>; 4],
    /// Contributions of a row to three planes.
    parts: [Vec<T>; 3],
    energy: Vec<[T; CHUNK]>,
    weights: Vec<T>,
}

impl<T: Float> Work<T> {
    pub(super) fn new([_, ny, nx]: [usize; 3], general: bool) -> Self {
        let (zero, stride) = (T::from_f64(0.0), stride(nx));
        Self {
            planes: vec![zero; 3 * (ny + 2) * stride],
            slots: std::array::from_fn(|_| vec![zero; FIELDS * stride]),
            parts: std::array::from_fn(|_| vec![zero; stride]),
            energy: vec![[zero; CHUNK]; nx.div_ceil(CHUNK)],
            weights: vec![zero; if general { WEIGHTS * stride } else { 0 }],
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
        let halo = isize::from(!gradient.is_empty());
        energies.fill(0.0);
        if halo == 1 {
            gradient[..plane].fill(T::from_f64(0.0));
        }
        for near in [start - halo - 1, start - halo] {
            self.load(near, work);
        }
        for k in start - halo..end + halo {
            self.load(k + 1, work);
            if halo == 1 && k >= start && k + 1 < end {
                let next = (k + 1 - start) as usize;
                gradient[next * plane..][..plane].fill(T::from_f64(0.0));
            }
            if self.edges != Edges::Periodic && !bounds.contains(&k) {
                continue;
            }
            // Contributions that leave the box fall on the plane they were copied from.
            let target = |k: isize| {
                let k = if self.edges == Edges::Periodic { k } else { k.clamp(0, nz as isize - 1) };
                (k >= start && k < end).then(|| (k - start) as usize * plane)
            };
            let targets =
                if halo == 1 { [target(k), target(k + 1), target(k - 1)] } else { [None; 3] };
            let energy = self.plane::<KIND>(k, targets, gradient, work);
            if k >= start && k < end {
                energies[(k - start) as usize] = energy;
            }
        }
    }

    /// One plane: returns the sum of its densities.
    #[inline(always)]
    fn plane<const KIND: u8>(
        &self,
        k: isize,
        targets: [Option<usize>; 3],
        gradient: &mut [T],
        work: &mut Work<T>,
    ) -> f64 {
        let [_, ny, nx] = self.shape;
        let rows = self.edges.energy_range(ny);
        let periodic = self.edges == Edges::Periodic;
        let wanted = !gradient.is_empty();
        let mut sum = 0.0;
        // Row j is gathered when row j + 1 is there.
        let last = ny as isize + isize::from(!periodic);
        for j in -1..=last {
            let inside = (0..ny as isize).contains(&j);
            if rows.contains(&j) || (periodic && wanted) {
                self.derivatives::<KIND>(k, j, work);
                if inside {
                    sum += self.row_sum(&work.energy);
                }
            }
            let gathered = j - 1;
            if !wanted || gathered < if periodic { 0 } else { -1 } {
                continue;
            }
            self.gather(gathered, work);
            let row = gathered.clamp(0, ny as isize - 1) as usize * nx;
            for (target, part) in targets.iter().zip(&work.parts) {
                if let Some(first) = target {
                    let sums = &mut gradient[first + row..][..nx];
                    for (sum, &part) in sums.iter_mut().zip(&part[PAD..]) {
                        *sum = *sum + part;
                    }
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
        let Work { planes, slots, energy, weights, .. } = work;
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
                row::<T, KIND>(&near, &weights, &self.k, energy, slot);
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
                row::<T, KIND>(&near, &weights, &self.k, energy, slot);
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
