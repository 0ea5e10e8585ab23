//! What the nodes of a row or plane know of the elements, passed on in wide registers.

/// Nodes this far (cells) outside the cone of a direction still pass on what they know. The
/// way to a node keeps its distance from the cone's edge up to a cell, and an
/// element may be a cell away from the nodes that know it from the start.
const SLACK: f32 = 2.0;

/// What the nodes of one row or plane know: element, its position, its squared distance.
#[derive(Default)]
pub(super) struct Front {
    pub element: Vec<u32>,
    pub distance: Vec<f32>,
    /// Positions along the axis of travel, the slow and the fast axis of the front.
    pub at: [Vec<f32>; 3],
    /// For each row the range of padded positions outside which nothing is known.
    pub known: Vec<(usize, usize)>,
}

/// Distance along an axis, the short way round a period.
#[inline(always)]
pub(super) fn apart<const P: bool>(w: f32, period: f32) -> f32 {
    if P {
        let w = w.abs();
        if w > 0.5 * period { period - w } else { w }
    } else {
        w
    }
}

impl Front {
    pub(super) fn reset(&mut self, rows: usize, width: usize, reach: f32) {
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

    /// Clears what row `b` knew two steps ago, up to the range `[low, high)`, and its padding.
    fn forget(&mut self, b: usize, width: usize, reach: f32, [low, high]: [usize; 2]) {
        let (first, last) = self.known[b];
        self.clear(b * width..b * width + 1, reach);
        self.clear((b + 1) * width - 1..(b + 1) * width, reach);
        if first < last {
            self.clear(b * width + first..b * width + low.clamp(first, last), reach);
            self.clear(b * width + high.clamp(first, last)..b * width + last, reach);
        }
        self.known[b] = (usize::MAX, 0);
    }

    fn clear(&mut self, range: std::ops::Range<usize>, reach: f32) {
        self.element[range.clone()].fill(0);
        self.distance[range.clone()].fill(reach);
        self.at.iter_mut().for_each(|at| at[range.clone()].fill(f32::INFINITY));
    }

    /// Offers the rows `from` of the previous front, and their neighbours one to the side,
    /// to row `b`, which forgets what it knew. `S`: several rows; else one.
    pub(super) fn pull<const P: bool, const S: bool>(
        &mut self,
        before: &Self,
        [b, width]: [usize; 2],
        from: impl Iterator<Item = usize>,
        step: &Step,
    ) {
        if S {
            self.forget(b, width, step.reach, [0, 0]);
        }
        for from in from {
            let (low, high) = before.known[from];
            // Padded positions that some known node touches.
            let [low, high] = match low < high {
                true => [(low - 1).max(1), (high + 1).min(width - 1)],
                false => [0, 0],
            };
            if !S {
                self.forget(b, width, step.reach, [low, high]);
            }
            if low >= high {
                continue;
            }
            let known = &mut self.known[b];
            *known = (known.0.min(low), known.1.max(high));
            let target = b * width + low..b * width + high;
            let source = from * width + low - 1..from * width + high + 1;
            let [ta, tb, tc] = &mut self.at;
            let [sa, sb, sc] = &before.at;
            pulp::Arch::new().dispatch(Pull::<P, S> {
                first: (low - 1) as i32,
                place: [step.place, b as f32],
                step,
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
    }

    /// Narrows the known range of row `b` to nodes within reach and, but for [`SLACK`], within
    /// the cone of the direction: the others learn of their elements from other directions.
    pub(super) fn trim<const P: bool>(&mut self, b: usize, width: usize, step: &Step) {
        let (mut low, mut high) = self.known[b];
        let useless = |front: &Self, m: usize| {
            let n = b * width + m;
            let ahead = apart::<P>(step.place - front.at[0][n], step.period[0]).abs();
            let aside = apart::<P>((m - 1) as f32 - front.at[2][n], step.period[2]).abs();
            // Unknown elements are infinitely far, which makes NaN.
            front.element[n] == 0 || aside > ahead + SLACK
        };
        while low < high && useless(self, low) {
            self.clear(b * width + low..b * width + low + 1, step.reach);
            low += 1;
        }
        while high > low && useless(self, high - 1) {
            high -= 1;
            self.clear(b * width + high..b * width + high + 1, step.reach);
        }
        self.known[b] = if low < high { (low, high) } else { (usize::MAX, 0) };
    }

    /// Copies the ends of row `b` into its padding: the row repeats itself.
    pub(super) fn close(&mut self, b: usize, width: usize) {
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

    /// Keeps in the lane's row what row `b` knows better, or all of it if the lane is `fresh`.
    pub(super) fn keep(
        &self,
        b: usize,
        width: usize,
        fresh: bool,
        (element, distance): (&mut [u32], &mut [f32]),
    ) {
        let (se, sd) = (&self.element[b * width..][..width], &self.distance[b * width..][..width]);
        let (low, high) = self.known[b];
        if fresh {
            element.copy_from_slice(&se[1..width - 1]);
            distance.copy_from_slice(&sd[1..width - 1]);
        } else if low < high {
            let lane = low - 1..high - 1;
            let (te, td) = (&mut element[lane.clone()], &mut distance[lane]);
            pulp::Arch::new().dispatch(Keep { se: &se[low..high], sd: &sd[low..high], te, td });
        }
    }
}

/// What all nodes of a step share.
pub(super) struct Step {
    /// Place on the axis of travel.
    pub place: f32,
    /// Along the axis of travel, the slow and the fast axis of the front.
    pub period: [f32; 3],
    /// Squared distance at which nothing is known.
    pub reach: f32,
}

/// The inner loop of [`Front::pull`]: `n` targets, `n + 2` sources that start one before them.
struct Pull<'a, const P: bool, const S: bool> {
    /// Place of the first target on the fast axis.
    first: i32,
    /// On the axis of travel and the slow one.
    place: [f32; 2],
    step: &'a Step,
    source: (&'a [u32], [&'a [f32]; 3]),
    target: (&'a mut [u32], &'a mut [f32], [&'a mut [f32]; 3]),
}

impl<const P: bool, const S: bool> pulp::NullaryFnOnce for Pull<'_, P, S> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { first, place, step, source: (se, [sa, sb, sc]), target } = self;
        let (te, td, [ta, tb, tc]) = target;
        offer::<P, S>(te, td, ta, tb, tc, se, sa, sb, sc, first, place, step);
    }
}

/// Offers each target the source before it and that one's neighbours. `S`: the targets
/// know something already. Arguments of their own, not fields of a struct,
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
    step: &Step,
) {
    let (period, reach) = (step.period, step.reach);
    let n = te.len();
    let (td, ta, tb, tc) = (&mut td[..n], &mut ta[..n], &mut tb[..n], &mut tc[..n]);
    let ahead = Row { e: &se[1..][..n], a: &sa[1..][..n], b: &sb[1..][..n], c: &sc[1..][..n] };
    let left = Row { e: &se[..n], a: &sa[..n], b: &sb[..n], c: &sc[..n] };
    let right = Row { e: &se[2..][..n], a: &sa[2..][..n], b: &sb[2..][..n], c: &sc[2..][..n] };
    for i in 0..n {
        let at = [place[0], place[1], (first + i as i32) as f32];
        let known = match S {
            true => Site { d: td[i], e: te[i], a: ta[i], b: tb[i], c: tc[i] },
            false => Site { d: reach, e: 0, a: f32::INFINITY, b: 0.0, c: f32::INFINITY },
        };
        let candidates = [
            ahead.site::<P, S>(i, at, period),
            left.site::<P, S>(i, at, period),
            right.site::<P, S>(i, at, period),
        ];
        let best = known.or(candidates[0]).or(candidates[1]).or(candidates[2]);
        (td[i], te[i], ta[i], tc[i]) = (best.d, best.e, best.a, best.c);
        if S {
            tb[i] = best.b;
        }
    }
}

/// Elements of a stretch of nodes, and where they sit.
struct Row<'a> {
    e: &'a [u32],
    a: &'a [f32],
    b: &'a [f32],
    c: &'a [f32],
}

/// An element, its squared distance and position.
#[derive(Clone, Copy)]
struct Site {
    d: f32,
    e: u32,
    a: f32,
    b: f32,
    c: f32,
}

impl Row<'_> {
    /// The element of node `i`, as seen from `at`.
    #[inline(always)]
    fn site<const P: bool, const S: bool>(&self, i: usize, at: [f32; 3], period: [f32; 3]) -> Site {
        let (e, a, c) = (self.e[i], self.a[i], self.c[i]);
        let b = if S { self.b[i] } else { 0.0 };
        let wa = apart::<P>(at[0] - a, period[0]);
        let wc = apart::<P>(at[2] - c, period[2]);
        let wb = if S { apart::<P>(at[1] - b, period[1]) } else { 0.0 };
        Site { d: wa * wa + wc * wc + wb * wb, e, a, b, c }
    }
}

impl Site {
    /// The nearer of two.
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        let closer = other.d < self.d;
        Self {
            d: if closer { other.d } else { self.d },
            e: if closer { other.e } else { self.e },
            a: if closer { other.a } else { self.a },
            b: if closer { other.b } else { self.b },
            c: if closer { other.c } else { self.c },
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

    /// Bit masks: a value that may stay as it is would be compiled to a branch.
    #[inline(always)]
    fn call(self) {
        let Self { se, sd, te, td } = self;
        let n = se.len();
        let (sd, te, td) = (&sd[..n], &mut te[..n], &mut td[..n]);
        for i in 0..n {
            let closer = u32::from(sd[i] < td[i]).wrapping_neg();
            te[i] = (se[i] & closer) | (te[i] & !closer);
            td[i] = if sd[i] < td[i] { sd[i] } else { td[i] };
        }
    }
}
