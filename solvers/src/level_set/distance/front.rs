//! What the nodes of a row or plane know of the elements, passed on in wide registers.

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

    /// Clears what row `b` knew two steps ago, and its padding.
    pub(super) fn forget(&mut self, b: usize, width: usize, reach: f32) {
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
    pub(super) fn pull<const P: bool, const S: bool>(
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
    pub(super) fn trim(&mut self, b: usize, width: usize) {
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

    /// Keeps in the lane's row what row `b` knows better.
    pub(super) fn keep(&self, b: usize, width: usize, element: &mut [u32], distance: &mut [f32]) {
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
