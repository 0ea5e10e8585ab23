//! One stage of a time step over the whole grid.
#![allow(
    clippy::needless_range_loop,
    reason = "rows side by side share one index; zips would hide the stencil"
)]

use super::{
    Order, Scheme,
    band::Band,
    curvature,
    ghost::{Padded, Row},
    rows,
    speed::Parts,
    upwind, weno,
};
use crate::Grid;
use std::ops::Range;

/// Everything that a stage reads.
pub(super) struct Stage<'a> {
    pub(super) grid: Grid,
    pub(super) scheme: &'a Scheme,
    /// The state u whose rate is taken.
    pub(super) padded: &'a Padded,
    pub(super) parts: Parts<'a>,
    pub(super) band: Option<&'a Band>,
    /// phi at the start of the step.
    pub(super) start: &'a [f64],
    /// `next = weights[0] start + weights[1] (u + dt rate(u))`.
    pub(super) weights: [f64; 2],
    pub(super) dt: f64,
}

/// A piece of a stage: some rows of the next state.
struct Piece<'a> {
    stage: &'a Stage<'a>,
    first: usize,
    next: &'a mut [f64],
}

impl Stage<'_> {
    /// Writes the next state; false if some value is not finite.
    pub(super) fn run(&self, next: &mut [f64]) -> bool {
        let arch = pulp::Arch::new();
        let parallel = match self.scheme.order {
            Order::First => rows::LIGHT,
            Order::Weno5 => rows::HEAVY,
        };
        rows::all(next, self.grid.shape()[2], parallel, |first, next| {
            arch.dispatch(Piece { stage: self, first, next })
        })
    }

    #[inline(always)]
    fn piece<const DIM: usize>(&self, first: usize, next: &mut [f64]) -> bool {
        let nx = self.grid.shape()[2];
        let mut finite = true;
        for (row, next) in next.chunks_exact_mut(nx).enumerate() {
            let row = first + row;
            let all = 0..nx;
            let intervals = self.band.map_or(std::slice::from_ref(&all), |band| band.row(row));
            for nodes in intervals {
                let view = self.padded.row(row, nodes.clone());
                let here = row * nx + nodes.start..row * nx + nodes.end;
                let next = &mut next[nodes.clone()];
                self.rate::<DIM>(view, here.clone(), next);
                finite &= self.combine(view, &self.start[here], next);
            }
        }
        finite
    }

    /// Writes dphi/dt at the nodes `here` (flat indices), which `view` shows.
    #[inline(always)]
    fn rate<const DIM: usize>(&self, view: Row<'_>, here: Range<usize>, rate: &mut [f64]) {
        let per_h = 1.0 / self.grid.spacing();
        let floor = self.scheme.gradient_floor.unwrap_or(0.0);
        let order = self.scheme.order;
        match (self.parts.normal, order) {
            (None, _) => rate.fill(0.0),
            (Some(beta), Order::First) => {
                upwind::normal::<DIM>(view, &beta[here.clone()], (per_h, floor), rate);
            }
            (Some(beta), Order::Weno5) => {
                weno::normal(view, DIM, &beta[here.clone()], (per_h, floor), rate);
            }
        }
        if let Some(velocity) = self.parts.velocity {
            for (axis, v) in velocity[..DIM].iter().enumerate() {
                match order {
                    Order::First => upwind::velocity(view, axis, &v[here.clone()], per_h, rate),
                    Order::Weno5 => weno::velocity(view, axis, &v[here.clone()], per_h, rate),
                }
            }
        }
        if let Some(b) = self.parts.curvature
            && DIM > 1
        {
            curvature::add::<DIM>(view, &b[here], per_h, rate);
        }
    }

    /// Turns the rates in `next` into the next state; false if some value is not finite.
    #[inline(always)]
    fn combine(&self, view: Row<'_>, start: &[f64], next: &mut [f64]) -> bool {
        let n = next.len();
        let (start, now) = (&start[..n], &view.along(0, 0)[..n]);
        let ([a, b], dt) = (self.weights, self.dt);
        let clip = self.scheme.clip.unwrap_or(f64::INFINITY);
        // Exponent bits all ones: NaN or infinite. Integers reduce in vectors, booleans do not.
        const EXPONENT: u64 = 0x7ff << 52;
        let mut bad = 0;
        for i in 0..n {
            let value = a * start[i] + b * (now[i] + dt * next[i]);
            bad |= u64::from(value.to_bits() & EXPONENT == EXPONENT);
            let value = if value > clip { clip } else { value };
            next[i] = if value < -clip { -clip } else { value };
        }
        bad == 0
    }
}

impl pulp::WithSimd for Piece<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> bool {
        match self.stage.grid.dim() {
            1 => self.stage.piece::<1>(self.first, self.next),
            2 => self.stage.piece::<2>(self.first, self.next),
            _ => self.stage.piece::<3>(self.first, self.next),
        }
    }
}

/// Greatest `S / h + 2 dim b / h^2` (1/time), whose inverse is the largest stable time
/// step; `S = sqrt(dim) |beta| + |vx| + |vy| + |vz|` bounds the sum over the axes of
/// the characteristic speeds (Osher & Fedkiw 2003, eqs (3.10), (4.7) and (6.10)).
pub(super) fn fastest(grid: Grid, parts: Parts<'_>, band: Option<&Band>) -> f64 {
    let arch = pulp::Arch::new();
    let dim = grid.dim();
    let per_h = 1.0 / grid.spacing();
    let scales = [(dim as f64).sqrt() * per_h, per_h, 2.0 * dim as f64 * per_h * per_h];
    let piece = |first: usize, len: usize| {
        let nodes = first..first + len;
        arch.dispatch(
            #[inline(always)]
            || greatest_rate(parts, dim, nodes, scales),
        )
    };
    match band {
        None => rows::greatest(grid.len(), piece),
        Some(band) => {
            let nx = grid.shape()[2];
            let intervals = band.rows().flat_map(|(row, list)| list.iter().map(move |r| (row, r)));
            intervals.fold(0.0, |m: f64, (row, r)| m.max(piece(row * nx + r.start, r.len())))
        }
    }
}

#[inline(always)]
fn greatest_rate(
    parts: Parts<'_>,
    dim: usize,
    nodes: Range<usize>,
    [normal, velocity, curvature]: [f64; 3],
) -> f64 {
    // Lanes of their own, since a maximum of floats in one variable is not vectorised.
    const LANES: usize = 64;
    let mut greatest = [0.0; LANES];
    for start in nodes.clone().step_by(LANES) {
        let block = start..nodes.end.min(start + LANES);
        let mut rate = [0.0; LANES];
        let mut add = |values: &[f64], scale: f64| {
            for (rate, value) in rate.iter_mut().zip(&values[block.clone()]) {
                *rate += scale * value.abs();
            }
        };
        if let Some(beta) = parts.normal {
            add(beta, normal);
        }
        for v in parts.velocity.iter().flat_map(|v| &v[..dim]) {
            add(v, velocity);
        }
        if let Some(b) = parts.curvature.filter(|_| dim > 1) {
            add(b, curvature);
        }
        for (greatest, rate) in greatest.iter_mut().zip(rate) {
            *greatest = upwind::max(rate, *greatest);
        }
    }
    greatest.iter().fold(0.0, |a, &b| a.max(b))
}
