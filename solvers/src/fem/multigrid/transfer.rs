//! Between two levels: bilinear or trilinear interpolation P, and its transpose.

use super::bands::{Bands, Part};
use super::lattice::{Layout, SLACK};

/// `P` and `P^T` between a lattice and the next coarser one.
#[derive(Clone, Debug)]
pub(super) struct Transfer {
    fine: Layout,
    coarse: Layout,
    fine_bands: Bands,
    coarse_bands: Bands,
    /// A row of nodes for each band.
    work: Vec<Vec<f32>>,
}

impl Transfer {
    pub(super) fn new(fine: Layout, coarse: Layout) -> Self {
        let bands = |layout: &Layout| Bands::new(layout.rows(), 1, layout.row_len());
        let (fine_bands, coarse_bands) = (bands(&fine), bands(&coarse));
        let work =
            vec![vec![0.0; fine.row_len() + SLACK]; fine_bands.count.max(coarse_bands.count)];
        Self { fine, coarse, fine_bands, coarse_bands, work }
    }

    /// `b = P^T r`.
    pub(super) fn restrict(&mut self, r: &[f32], b: &mut [f32]) {
        let Self { fine, coarse, coarse_bands: bands, work, .. } = self;
        let (fine_len, coarse_len) = (fine.row_len(), coarse.row_len());
        let [rz, ry, rx] = fine.lattice.ratios();
        let [planes, lines, _] = fine.lattice.nodes();
        let parts = (bands.part(b, coarse_len), Part::one_each(work));
        bands.each(parts, |band, (b, work)| {
            let sum = &mut work.data[0];
            for (row, b) in bands.range(band).zip(b.data.chunks_exact_mut(coarse_len)) {
                sum.fill(0.0);
                for (k, wz) in sources(row / coarse.lines(), rz, planes) {
                    for (j, wy) in sources(row % coarse.lines(), ry, lines) {
                        let from = &r[(k * lines + j) * fine_len..][..fine_len];
                        add_row(wz * wy, from, &mut sum[..fine_len]);
                    }
                }
                for c in 0..fine.components {
                    let to = &mut b[coarse.span(c)];
                    restrict_row(&sum[c * fine.stride..], rx, to);
                }
            }
        });
    }

    /// `x += P e`; `fix(row, x's row)` may change it.
    pub(super) fn prolong(
        &mut self,
        e: &[f32],
        x: &mut [f32],
        fix: impl Fn(usize, &mut [f32]) + Sync,
    ) {
        let Self { fine, coarse, fine_bands: bands, work, .. } = self;
        let (fine_len, coarse_len) = (fine.row_len(), coarse.row_len());
        let [rz, ry, rx] = fine.lattice.ratios();
        let parts = (bands.part(x, fine_len), Part::one_each(work));
        bands.each(parts, |band, (x, work)| {
            // A coarse row is not longer than a fine one.
            let sum = &mut work.data[0][..coarse_len];
            for (row, x) in bands.range(band).zip(x.data.chunks_exact_mut(fine_len)) {
                sum.fill(0.0);
                for (k, wz) in targets(row / fine.lines(), rz) {
                    for (j, wy) in targets(row % fine.lines(), ry) {
                        let from = &e[(k * coarse.lines() + j) * coarse_len..][..coarse_len];
                        add_row(wz * wy, from, sum);
                    }
                }
                for c in 0..fine.components {
                    prolong_row(&sum[coarse.span(c)], rx, &mut x[fine.span(c)]);
                }
                fix(row, x);
            }
        });
    }
}

/// Fine indices below `count` with weight in coarse index `i`, and their weights.
fn sources(i: usize, ratio: usize, count: usize) -> impl Iterator<Item = (usize, f32)> {
    let middle = ratio * i;
    let sides = [middle.checked_sub(1), Some(middle + 1)].into_iter().flatten();
    let sides = sides.filter(move |_| ratio == 2).map(|i| (i, 0.5));
    sides.chain([(middle, 1.0)]).filter(move |&(i, _)| i < count)
}

/// Coarse indices that fine index `i` is interpolated from, and their weights.
fn targets(i: usize, ratio: usize) -> impl Iterator<Item = (usize, f32)> {
    let odd = ratio == 2 && i % 2 == 1;
    let weight = if odd { 0.5 } else { 1.0 };
    [(i / ratio, weight), (i / ratio + 1, weight)].into_iter().take(1 + usize::from(odd))
}

fn add_row(weight: f32, from: &[f32], sum: &mut [f32]) {
    for (sum, value) in sum.iter_mut().zip(from) {
        *sum += weight * value;
    }
}

/// `from` begins with the ghost before the first node.
fn restrict_row(from: &[f32], ratio: usize, to: &mut [f32]) {
    if ratio == 1 {
        return to.copy_from_slice(&from[1..=to.len()]);
    }
    for (to, near) in to.iter_mut().zip(from.windows(3).step_by(2)) {
        *to = near[1] + 0.5 * (near[0] + near[2]);
    }
}

fn prolong_row(from: &[f32], ratio: usize, to: &mut [f32]) {
    if ratio == 1 {
        return add_row(1.0, from, to);
    }
    for (to, near) in to.chunks_mut(2).zip(from.windows(2)) {
        to[0] += near[0];
        if let Some(odd) = to.get_mut(1) {
            *odd += 0.5 * (near[0] + near[1]);
        }
    }
    // With an even number of elements the last node is a coarse one.
    if to.len() % 2 == 1 {
        to[to.len() - 1] += from[from.len() - 1];
    }
}
