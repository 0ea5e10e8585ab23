//! The density and its derivatives along a row.

use super::local::{Constants, FIELDS, Invariants, Jet, Weights, derivatives, invariants};
use super::local::{root, s_weight, sharp_root, smooth_density};
use super::rows::{CHUNK, Near, PAD};
use solvers::Float;

/// Kinds of densities, for each of which the kernel is compiled.
pub(super) const UNIFORM: u8 = 0;
/// Coefficients vary, or there is an orientation.
pub(super) const GENERAL: u8 = 1;

/// Weights of a row.
#[derive(Clone, Copy)]
pub(super) enum RowWeights<'a, T> {
    /// The same at all voxels, without orientation.
    Uniform(Weights<T>),
    /// c1 to c6, mu and theta along z, y, x: padded rows.
    Fields([&'a [[T; CHUNK]]; 10]),
}

impl<T: Float> RowWeights<'_, T> {
    #[inline(always)]
    fn at<const KIND: u8>(&self, j: usize, i: usize) -> Weights<T> {
        match self {
            RowWeights::Uniform(weights) if KIND == UNIFORM => *weights,
            RowWeights::Fields(f) if KIND == GENERAL => Weights {
                c: [f[0][j][i], f[1][j][i], f[2][j][i], f[3][j][i], f[4][j][i], f[5][j][i]],
                mu: f[6][j][i],
                theta: [f[7][j][i], f[8][j][i], f[9][j][i]],
            },
            _ => Weights::default(),
        }
    }
}

/// Chunks that go through the three stages together. One chunk has a chain of some 400 cycles
/// of roots, quotients and polynomials; the short loops of the stages let the processor
/// work on several at once.
const BLOCK: usize = 4;

/// What the first stage leaves to the others.
const KEPT: usize = 18;

/// What the stages leave of a chunk, each number at the start of a vector.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Lanes<T, const N: usize>([[T; CHUNK]; N]);

/// What the stages leave to each other of a block of chunks.
#[derive(Clone, Debug)]
pub(super) struct Stages<T> {
    kept: [Lanes<T, KEPT>; BLOCK],
    roots: [Lanes<T, 2>; BLOCK],
}

impl<T: Float> Stages<T> {
    pub(super) fn new() -> Self {
        let zeros = [T::from_f64(0.0); CHUNK];
        Self { kept: [Lanes([zeros; KEPT]); BLOCK], roots: [Lanes([zeros; 2]); BLOCK] }
    }
}

/// Densities of a row of `e.len()` chunks into `e`, and their derivatives into `out`,
/// [`FIELDS`] padded rows. What is written behind the last voxel is not part of the row.
#[inline(always)]
pub(super) fn row<T: Float, const KIND: u8>(
    near: &Near<'_, T>,
    weights: &RowWeights<'_, T>,
    k: &Constants<T>,
    stages: &mut Stages<T>,
    e: &mut [[T; CHUNK]],
    out: &mut [T],
) {
    let Stages { kept, roots } = stages;
    let count = e.len();
    for first in (0..count).step_by(BLOCK) {
        let block = BLOCK.min(count - first);
        for b in 0..block {
            let d =
                measure::<T, KIND>(near, weights, k, first + b, &mut kept[b].0, &mut e[first + b]);
            roots[b].0[0] = d;
        }
        for roots in &mut roots[..block] {
            take_roots(k, &mut roots.0);
        }
        for b in 0..block {
            let u = &near.plane[1].here[first + b];
            let e = &mut e[first + b];
            differentiate::<T, KIND>(weights, k, first + b, (u, &kept[b].0, &roots[b].0), e, out);
        }
    }
}

/// First stage: invariants of chunk `j`; returns D, and the density without its part of S.
#[inline(always)]
fn measure<T: Float, const KIND: u8>(
    near: &Near<'_, T>,
    weights: &RowWeights<'_, T>,
    k: &Constants<T>,
    j: usize,
    kept: &mut [[T; CHUNK]; KEPT],
    e: &mut [T; CHUNK],
) -> [T; CHUNK] {
    let zero = T::from_f64(0.0);
    let [north, center, south] = &near.plane;
    let (below, above) = (&near.below, &near.above);
    let [bn, bs, an, as_] = near.corners;
    let (nw, nn, ne) = (&north.west[j], &north.here[j], &north.east[j]);
    let (cw, cc, ce) = (&center.west[j], &center.here[j], &center.east[j]);
    let (sw, ss, se) = (&south.west[j], &south.here[j], &south.east[j]);
    let (bw, bc, be) = (&below.west[j], &below.here[j], &below.east[j]);
    let (aw, ac, ae) = (&above.west[j], &above.here[j], &above.east[j]);
    let (bn, bs, an, as_) = (&bn[j], &bs[j], &an[j], &as_[j]);
    let (mut density, mut d) = ([zero; CHUNK], [zero; CHUNK]);
    for i in 0..CHUNK {
        let two = cc[i] + cc[i];
        let jet = Jet {
            u: cc[i],
            g: [(ac[i] - bc[i]) * k.first, (ss[i] - nn[i]) * k.first, (ce[i] - cw[i]) * k.first],
            h: [
                ((ac[i] + bc[i]) - two) * k.second,
                ((ss[i] + nn[i]) - two) * k.second,
                ((ce[i] + cw[i]) - two) * k.second,
                ((as_[i] - an[i]) - (bs[i] - bn[i])) * k.mixed,
                ((ae[i] - aw[i]) - (be[i] - bw[i])) * k.mixed,
                ((se[i] - sw[i]) - (ne[i] - nw[i])) * k.mixed,
            ],
        };
        let weights = weights.at::<KIND>(j, i);
        let local = invariants(&jet, k);
        let theta = weights.theta;
        let along = (theta[0] * jet.g[0] + theta[1] * jet.g[1]) + theta[2] * jet.g[2];
        let smooth = smooth_density(&local, &weights);
        density[i] = if KIND == GENERAL { smooth + weights.mu * (along * along) } else { smooth };
        d[i] = local.d;
        let Invariants { n, inverse_n, m, hm, normal, w, trace, .. } = local;
        let all = [
            n, inverse_n, m[0], m[1], m[2], hm[0], hm[1], hm[2], normal, w, trace, jet.h[0],
            jet.h[1], jet.h[2], jet.h[3], jet.h[4], jet.h[5], along,
        ];
        for v in 0..if KIND == GENERAL { KEPT } else { KEPT - 1 } {
            kept[v][i] = all[v];
        }
    }
    *e = density;
    d
}

/// Second stage: D into S and dS/dD.
#[inline(always)]
fn take_roots<T: Float>(k: &Constants<T>, roots: &mut [[T; CHUNK]; 2]) {
    let zero = T::from_f64(0.0);
    let d = roots[0];
    let (mut s, mut ds) = ([zero; CHUNK], [zero; CHUNK]);
    let near = d.iter().fold(false, |near, d| near | (d.abs() < k.sharp));
    if near {
        for i in 0..CHUNK {
            (s[i], ds[i]) = root(d[i], k);
        }
    } else {
        for i in 0..CHUNK {
            (s[i], ds[i]) = sharp_root(d[i], k);
        }
    }
    *roots = [s, ds];
}

/// Third stage: the rest of the density, and its derivatives.
#[inline(always)]
fn differentiate<T: Float, const KIND: u8>(
    weights: &RowWeights<'_, T>,
    k: &Constants<T>,
    j: usize,
    (u, kept, roots): (&[T; CHUNK], &[[T; CHUNK]; KEPT], &[[T; CHUNK]; 2]),
    e: &mut [T; CHUNK],
    out: &mut [T],
) {
    let zero = T::from_f64(0.0);
    let stride = out.len() / FIELDS;
    let mut results = [[zero; CHUNK]; FIELDS];
    let mut density = *e;
    for i in 0..CHUNK {
        let weights = weights.at::<KIND>(j, i);
        let local = Invariants {
            n: kept[0][i],
            inverse_n: kept[1][i],
            m: [kept[2][i], kept[3][i], kept[4][i]],
            hm: [kept[5][i], kept[6][i], kept[7][i]],
            normal: kept[8][i],
            w: kept[9][i],
            trace: kept[10][i],
            ..Invariants::default()
        };
        let h = [kept[11][i], kept[12][i], kept[13][i], kept[14][i], kept[15][i], kept[16][i]];
        let (s, ds) = (roots[0][i], roots[1][i]);
        density[i] = density[i] + s_weight(&local, &weights) * s;
        let mut fields = derivatives(u[i], &h, &local, (s, ds), &weights, k);
        if KIND == GENERAL {
            let along = kept[17][i];
            let push = (along + along) * weights.mu;
            fields[6] = fields[6] + push * weights.theta[0];
            fields[7] = fields[7] + push * weights.theta[1];
            fields[8] = fields[8] + push * weights.theta[2];
        }
        for f in 0..FIELDS {
            results[f][i] = fields[f];
        }
    }
    *e = density;
    for f in 0..FIELDS {
        out[f * stride + PAD + j * CHUNK..][..CHUNK].copy_from_slice(&results[f]);
    }
}
