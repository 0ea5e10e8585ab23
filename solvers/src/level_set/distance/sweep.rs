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
    pub(super) fn new(nodes: usize) -> Self {
        Self {
            element: vec![0; nodes],
            distance: vec![0.0; nodes],
            fronts: [Front::default(), Front::default()],
            order: Vec::new(),
            start: Vec::new(),
        }
    }
}

/// What the nodes of one row or plane know: element, its position, its squared distance.
#[derive(Default)]
struct Front {
    element: Vec<u32>,
    distance: Vec<f32>,
    /// Positions along the axis of travel, the slow and the fast axis of the front.
    at: [Vec<f32>; 3],
    /// For each row the range of padded positions outside which nothing is known.
    known: Vec<(usize, usize)>,
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
            // The lane of the x axis is stored [x][z][y].
            2 => [sizes[1] * sizes[2], sizes[2]],
            _ => [lattice.strides[axes[0]], lattice.strides[axes[1]]],
        };
        Self { axes, sizes, strides }
    }
}

impl Sites<'_> {
    /// Fills `lane` with the finds along x, stored `[x][z][y]`.
    pub(super) fn sweep_x(&self, lane: &mut Lane) {
        self.forget(lane);
        self.sweep_axis(lane, 2);
    }

    /// Fills `lane` with the finds along y and z, stored `[z][y][x]`.
    pub(super) fn sweep_yz(&self, lane: &mut Lane) {
        self.forget(lane);
        (0..2).filter(|&axis| self.lattice.shape[axis] > 1).for_each(|a| self.sweep_axis(lane, a));
    }

    fn forget(&self, lane: &mut Lane) {
        lane.element.fill(0);
        lane.distance.fill(self.reach);
    }

    fn sweep_axis(&self, lane: &mut Lane, travel: usize) {
        let axes = Axes::new(self.lattice, travel);
        self.sort_seeds(lane, travel);
        for rising in [true, false] {
            match (self.lattice.periodic, axes.sizes[1] > 1) {
                (false, false) => self.run::<false, false>(lane, &axes, rising),
                (false, true) => self.run::<false, true>(lane, &axes, rising),
                (true, false) => self.run::<true, false>(lane, &axes, rising),
                (true, true) => self.run::<true, true>(lane, &axes, rising),
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
    fn run<const P: bool, const S: bool>(&self, lane: &mut Lane, axes: &Axes, rising: bool) {
        let [na, nb, nc] = axes.sizes;
        let width = nc + 2;
        lane.fronts.iter_mut().for_each(|front| front.reset(nb, width, self.reach));
        let period = axes.axes.map(|a| self.lattice.period[2 - a]);
        // A periodic way is half a period long at most.
        let steps = if P { na + na / 2 + 1 } else { na };
        for step in 0..steps {
            let a = if rising { step % na } else { na - 1 - step % na };
            let [before, front] = &mut lane.fronts;
            for b in 0..nb {
                front.forget(b, width, self.reach);
                let place = [a as f32, b as f32];
                if S && (P || b > 0) {
                    front.pull::<P, S>(before, [b, (b + nb - 1) % nb, width], place, period);
                }
                front.pull::<P, S>(before, [b, b, width], place, period);
                if S && (P || b + 1 < nb) {
                    front.pull::<P, S>(before, [b, (b + 1) % nb, width], place, period);
                }
            }
            let seeds = lane.start[a] as usize..lane.start[a + 1] as usize;
            for seed in &lane.order[seeds] {
                self.plant::<P>(front, axes, seed, period);
            }
            for b in 0..nb {
                front.trim(b, width);
                if P {
                    front.close(b, width);
                }
                let row = a * axes.strides[0] + b * axes.strides[1];
                front.keep(
                    b,
                    width,
                    &mut lane.element[row..][..nc],
                    &mut lane.distance[row..][..nc],
                );
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

/// Distance along an axis, the short way round a period.
#[inline(always)]
fn apart<const P: bool>(w: f32, period: f32) -> f32 {
    if P {
        let w = w.abs();
        if w > 0.5 * period { period - w } else { w }
    } else {
        w
    }
}

impl Front {
    fn reset(&mut self, rows: usize, width: usize, reach: f32) {
        self.element.clear();
        self.element.resize(rows * width, 0);
        self.distance.clear();
        self.distance.resize(rows * width, reach);
        for at in &mut self.at {
            at.clear();
            at.resize(rows * width, f32::INFINITY);
        }
        self.known.clear();
        self.known.resize(rows, (usize::MAX, 0));
    }

    /// Clears what row `b` knew two steps ago, and its padding.
    fn forget(&mut self, b: usize, width: usize, reach: f32) {
        let (low, high) = self.known[b];
        let row = b * width;
        let ranges =
            [(row, row + 1), (row + low.min(high), row + high), (row + width - 1, row + width)];
        for (low, high) in ranges {
            self.element[low..high].fill(0);
            self.distance[low..high].fill(reach);
            self.at.iter_mut().for_each(|at| at[low..high].fill(f32::INFINITY));
        }
        self.known[b] = (usize::MAX, 0);
    }

    /// Offers row `from` of the previous front, and its neighbours one to the side, to row `b`.
    fn pull<const P: bool, const S: bool>(
        &mut self,
        before: &Self,
        [b, from, width]: [usize; 3],
        place: [f32; 2],
        period: [f32; 3],
    ) {
        let (low, high) = before.known[from];
        if low >= high {
            return;
        }
        // Padded positions that some known node touches.
        let (low, high) = ((low - 1).max(1), (high + 1).min(width - 1));
        let known = &mut self.known[b];
        *known = (known.0.min(low), known.1.max(high));
        let target = b * width + low..b * width + high;
        let source = from * width + low - 1..from * width + high + 1;
        let [ta, tb, tc] = &mut self.at;
        let [sa, sb, sc] = &before.at;
        pulp::Arch::new().dispatch(Pull::<P, S> {
            first: (low - 1) as i32,
            place,
            period,
            source: (
                &before.element[source.clone()],
                [&sa[source.clone()], &sb[source.clone()], &sc[source]],
            ),
            target: (
                &mut self.element[target.clone()],
                &mut self.distance[target.clone()],
                [&mut ta[target.clone()], &mut tb[target.clone()], &mut tc[target]],
            ),
        });
    }

    /// Narrows the known range of row `b`: near a band's edge nodes fall out of reach.
    fn trim(&mut self, b: usize, width: usize) {
        let (mut low, mut high) = self.known[b];
        while low < high && self.element[b * width + low] == 0 {
            low += 1;
        }
        while high > low && self.element[b * width + high - 1] == 0 {
            high -= 1;
        }
        self.known[b] = if low < high { (low, high) } else { (usize::MAX, 0) };
    }

    /// Copies the ends of row `b` into its padding: the row repeats itself.
    fn close(&mut self, b: usize, width: usize) {
        let first = b * width;
        for (to, from) in [(0, width - 2), (width - 1, 1)] {
            self.element[first + to] = self.element[first + from];
            self.distance[first + to] = self.distance[first + from];
            self.at.iter_mut().for_each(|at| at[first + to] = at[first + from]);
            if self.element[first + to] != 0 {
                let (low, high) = &mut self.known[b];
                let seam = to.clamp(1, width - 2);
                (*low, *high) = ((*low).min(seam), (*high).max(seam + 1));
            }
        }
    }

    /// Keeps in the lane's row what row `b` knows better.
    fn keep(&self, b: usize, width: usize, element: &mut [u32], distance: &mut [f32]) {
        let (low, high) = self.known[b];
        if low >= high {
            return;
        }
        let n = high - low;
        let (se, sd) =
            (&self.element[b * width + low..][..n], &self.distance[b * width + low..][..n]);
        let (te, td) = (&mut element[low - 1..][..n], &mut distance[low - 1..][..n]);
        pulp::Arch::new().dispatch(Keep { se, sd, te, td });
    }
}

/// The inner loop of [`Front::pull`]: `n` targets, `n + 2` sources that start one before them.
struct Pull<'a, const P: bool, const S: bool> {
    /// Place of the first target on the fast axis.
    first: i32,
    place: [f32; 2],
    period: [f32; 3],
    source: (&'a [u32], [&'a [f32]; 3]),
    target: (&'a mut [u32], &'a mut [f32], [&'a mut [f32]; 3]),
}

impl<const P: bool, const S: bool> pulp::NullaryFnOnce for Pull<'_, P, S> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { first, place, period, source: (se, [sa, sb, sc]), target } = self;
        let (te, td, [ta, tb, tc]) = target;
        let n = te.len();
        for side in [1, 0, 2] {
            let (se, sa, sb, sc) =
                (&se[side..][..n], &sa[side..][..n], &sb[side..][..n], &sc[side..][..n]);
            offer::<P, S>(te, td, ta, tb, tc, se, sa, sb, sc, first, place, period);
        }
    }
}

/// Offers each target one source. Arguments of their own, not fields of a struct,
/// tell the compiler that the slices do not overlap, so that it fills wide registers.
#[inline(always)]
#[allow(clippy::too_many_arguments, reason = "see above")]
fn offer<const P: bool, const S: bool>(
    te: &mut [u32],
    td: &mut [f32],
    ta: &mut [f32],
    tb: &mut [f32],
    tc: &mut [f32],
    se: &[u32],
    sa: &[f32],
    sb: &[f32],
    sc: &[f32],
    first: i32,
    place: [f32; 2],
    period: [f32; 3],
) {
    let n = te.len();
    let (td, ta, tb, tc) = (&mut td[..n], &mut ta[..n], &mut tb[..n], &mut tc[..n]);
    let (se, sa, sb, sc) = (&se[..n], &sa[..n], &sb[..n], &sc[..n]);
    for i in 0..n {
        let (e, a, c) = (se[i], sa[i], sc[i]);
        let wa = apart::<P>(place[0] - a, period[0]);
        let wc = apart::<P>((first + i as i32) as f32 - c, period[2]);
        let mut d = wa * wa + wc * wc;
        if S {
            let wb = apart::<P>(place[1] - sb[i], period[1]);
            d += wb * wb;
        }
        let (old_d, old_e, old_a, old_c) = (td[i], te[i], ta[i], tc[i]);
        let closer = d < old_d;
        td[i] = if closer { d } else { old_d };
        te[i] = if closer { e } else { old_e };
        ta[i] = if closer { a } else { old_a };
        tc[i] = if closer { c } else { old_c };
        if S {
            let (b, old_b) = (sb[i], tb[i]);
            tb[i] = if closer { b } else { old_b };
        }
    }
}

/// The inner loop of [`Front::keep`].
struct Keep<'a> {
    se: &'a [u32],
    sd: &'a [f32],
    te: &'a mut [u32],
    td: &'a mut [f32],
}

impl pulp::NullaryFnOnce for Keep<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let n = self.se.len();
        let (se, sd) = (&self.se[..n], &self.sd[..n]);
        let (te, td) = (&mut self.te[..n], &mut self.td[..n]);
        for i in 0..n {
            let (e, d) = (se[i], sd[i]);
            let (old_e, old_d) = (te[i], td[i]);
            let closer = d < old_d;
            td[i] = if closer { d } else { old_d };
            te[i] = if closer { e } else { old_e };
        }
    }
}
