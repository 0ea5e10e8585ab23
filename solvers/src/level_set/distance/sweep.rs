//! Nearest contour element of every node, in linear time.
//!
//! Element numbers travel from row to row (in space: from plane to plane), up
//! and down every axis: a node takes over the nearest of the elements that its 3
//! (9) predecessors know. The straight way from a node to its element lies in
//! one of the axes' cones of 45 degrees, so that each direction can run by itself
//! and the nearest of all finds is kept (Danielsson 1980; Schneider, Kraus &
//! Westermann 2009, with sub-cell sites). No step depends on its left or right
//! neighbour, so rows are worked on in wide registers.

use super::Lattice;
use super::front::{Front, Step, apart};

/// Where elements sit and which nodes know them from the start.
pub(super) struct Sites<'a> {
    pub lattice: &'a Lattice,
    /// `[x, y, z]` in cells; number 0 means none and is infinitely far. Single
    /// precision picks the element only: an error of 1e-7 of the distance.
    pub points: &'a [[f32; 3]],
    pub seeds: &'a [Seed],
    /// Elements at this squared distance or farther are not passed on.
    pub reach: f32,
}

/// A node `[k, j, i]` and an element that it knows from the start.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seed {
    pub node: [u32; 3],
    pub element: u32,
}

/// Finds of some directions: for each node the best element and its squared distance.
pub(super) struct Lane {
    pub element: Vec<u32>,
    pub distance: Vec<f32>,
    fronts: [Front; 2],
    order: Vec<Seed>,
    start: Vec<u32>,
}

impl Lane {
    /// For the finds along x, or along y and z.
    pub(super) fn new(lattice: &Lattice, along_x: bool) -> Self {
        let [nz, ny, nx] = lattice.shape;
        let nodes = if along_x { nz * column_stride(ny) * nx } else { nz * ny * nx };
        Self {
            element: vec![0; nodes],
            distance: vec![0.0; nodes],
            fronts: [Front::default(), Front::default()],
            order: Vec::new(),
            start: Vec::new(),
        }
    }
}

/// Distance between the columns of a plane in the lane of the x axis: an odd number of
/// cache lines, as caches keep few places that are a power of two apart.
pub(super) fn column_stride(ny: usize) -> usize {
    const LINE: usize = 16;
    (ny.div_ceil(LINE) | 1) * LINE
}

/// Order of the axes in a direction of travel, and where a front's rows lie in the lane.
struct Axes {
    /// Travel, slow and fast axis; 0 is z, 2 is x.
    axes: [usize; 3],
    sizes: [usize; 3],
    /// Distance in the lane between rows along the travel and the slow axis.
    strides: [usize; 2],
}

impl Axes {
    fn new(lattice: &Lattice, travel: usize) -> Self {
        let axes = [[0, 1, 2], [1, 0, 2], [2, 0, 1]][travel];
        let sizes = axes.map(|a| lattice.shape[a]);
        let strides = match travel {
            2 => [sizes[1] * column_stride(sizes[2]), column_stride(sizes[2])],
            _ => [lattice.strides[axes[0]], lattice.strides[axes[1]]],
        };
        Self { axes, sizes, strides }
    }
}

impl Sites<'_> {
    /// Fills `lane` with the finds along x, stored `[x][z][y]` with [`column_stride`].
    pub(super) fn sweep_x(&self, lane: &mut Lane) {
        self.sweep_axis(lane, 2, true);
    }

    /// Fills `lane` with the finds along y and z, stored `[z][y][x]`.
    pub(super) fn sweep_yz(&self, lane: &mut Lane) {
        let mut fresh = true;
        for axis in (0..2).filter(|&axis| self.lattice.shape[axis] > 1) {
            self.sweep_axis(lane, axis, fresh);
            fresh = false;
        }
        if fresh {
            lane.element.fill(0);
            lane.distance.fill(self.reach);
        }
    }

    /// Both directions of an axis; a `fresh` lane is written anew.
    fn sweep_axis(&self, lane: &mut Lane, travel: usize, fresh: bool) {
        let axes = Axes::new(self.lattice, travel);
        self.sort_seeds(lane, travel);
        for rising in [true, false] {
            let fresh = fresh && rising;
            match (self.lattice.periodic, axes.sizes[1] > 1) {
                (false, false) => self.run::<false, false>(lane, &axes, rising, fresh),
                (false, true) => self.run::<false, true>(lane, &axes, rising, fresh),
                (true, false) => self.run::<true, false>(lane, &axes, rising, fresh),
                (true, true) => self.run::<true, true>(lane, &axes, rising, fresh),
            }
        }
    }

    /// Sorts the seeds by their place on the axis of travel, those of one place in their order.
    fn sort_seeds(&self, lane: &mut Lane, travel: usize) {
        let n = self.lattice.shape[travel];
        let place = |seed: &Seed| seed.node[travel] as usize;
        lane.start.clear();
        lane.start.resize(n + 2, 0);
        self.seeds.iter().for_each(|seed| lane.start[place(seed) + 2] += 1);
        (2..n + 2).for_each(|m| lane.start[m] += lane.start[m - 1]);
        lane.order.resize(self.seeds.len(), Seed::default());
        for seed in self.seeds {
            let slot = &mut lane.start[place(seed) + 1];
            lane.order[*slot as usize] = *seed;
            *slot += 1;
        }
    }

    /// One direction. `P`: periodic; `S`: fronts are planes, not rows.
    fn run<const P: bool, const S: bool>(
        &self,
        lane: &mut Lane,
        axes: &Axes,
        rising: bool,
        fresh: bool,
    ) {
        let [na, nb, nc] = axes.sizes;
        let width = nc + 2;
        lane.fronts.iter_mut().for_each(|front| front.reset(nb, width, self.reach));
        let period = axes.axes.map(|a| self.lattice.period[2 - a]);
        // A periodic way is half a period long at most.
        let steps = if P { na + na / 2 + 1 } else { na };
        for number in 0..steps {
            let a = if rising { number % na } else { na - 1 - number % na };
            let step = Step { place: a as f32, period, reach: self.reach };
            let [before, front] = &mut lane.fronts;
            for b in 0..nb {
                let beside = [
                    b.checked_sub(1).or(P.then_some(nb - 1)),
                    if b + 1 < nb { Some(b + 1) } else { P.then_some(0) },
                ];
                let [low, high] = beside.map(|b| b.filter(|_| S));
                let from = low.into_iter().chain([b]).chain(high);
                front.pull::<P, S>(before, [b, width], from, &step);
            }
            let seeds = lane.start[a] as usize..lane.start[a + 1] as usize;
            for seed in &lane.order[seeds] {
                self.plant::<P>(front, axes, seed, period);
            }
            for b in 0..nb {
                front.trim::<P>(b, width, &step);
                if P {
                    front.close(b, width);
                }
                let row = a * axes.strides[0] + b * axes.strides[1];
                let to = (&mut lane.element[row..][..nc], &mut lane.distance[row..][..nc]);
                front.keep(b, width, fresh && number < na, to);
            }
            lane.fronts.swap(0, 1);
        }
    }

    /// Tells a node of the front about an element.
    fn plant<const P: bool>(&self, front: &mut Front, axes: &Axes, seed: &Seed, period: [f32; 3]) {
        let element = seed.element;
        let all = self.points[element as usize];
        let [p, q, r] = axes.axes;
        let place = [seed.node[p] as usize, seed.node[q] as usize, seed.node[r] as usize];
        let point = [all[2 - p], all[2 - q], all[2 - r]];
        let mut d = 0.0;
        for m in 0..3 {
            let w = apart::<P>(place[m] as f32 - point[m], period[m]);
            d += w * w;
        }
        let n = place[1] * (axes.sizes[2] + 2) + place[2] + 1;
        if d < front.distance[n] {
            front.distance[n] = d;
            front.element[n] = element;
            (0..3).for_each(|m| front.at[m][n] = point[m]);
            let (low, high) = &mut front.known[place[1]];
            (*low, *high) = ((*low).min(place[2] + 1), (*high).max(place[2] + 2));
        }
    }
}
