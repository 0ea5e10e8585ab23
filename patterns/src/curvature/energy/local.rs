//! The energy density at one voxel and its derivatives.
//!
//! | symbol  | code       | meaning                                                  |
//! |---------|------------|----------------------------------------------------------|
//! | g       | `g`        | gradient of u, central differences                       |
//! | eps H   | `h`        | Hessian of u times eps                                   |
//! | m       | `m`        | g / n, with n = sqrt(g^2 + xi^2)                         |
//! | W'/eps  | `w`        | (u^3 - u) / eps                                          |
//! | T       | `trace`    | w - tr(eps H), trace of M                                |
//! | M       | `square`   | squared norm of M = (W'/eps) m m - eps H                 |
//! | N       | `normal`   | m . (eps H) m                                            |
//! | D, S    | `s`        | D = 2 M - T^2, S = sqrt(softplus(D))                     |
//!
//! `kappa_1,2 = (T +- S) / (2 eps n)`. Song 2021, eqs. (15) to (20); the softplus in place of
//! the positive part and where xi enters are the published program's.

use solvers::Float;

/// Numbers that are the same at all voxels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Constants<T> {
    /// 1 / (2 dx).
    pub(super) first: T,
    /// eps / dx^2 and a quarter of it.
    pub(super) second: T,
    pub(super) mixed: T,
    pub(super) inverse_eps: T,
    /// xi^2, 1/length^2.
    pub(super) xi2: T,
    /// Width xi' of the softplus, its inverse, and the distance beyond which it is the
    /// positive part to rounding.
    pub(super) width: T,
    pub(super) inverse_width: T,
    pub(super) sharp: T,
    /// Factors of the gradient with respect to u: dx^3 times `first`, `second`, `mixed`
    /// and `inverse_eps`.
    pub(super) to_first: T,
    pub(super) to_second: T,
    pub(super) to_mixed: T,
    pub(super) to_well: T,
}

/// Coefficients of the density at a voxel: of M, T S, T^2, n T, n S, n^2, and of
/// (theta . g)^2 with theta.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Weights<T> {
    pub(super) c: [T; 6],
    pub(super) mu: T,
    /// Along z, y, x.
    pub(super) theta: [T; 3],
}

/// What a voxel and its neighbours hold: u, its gradient (z, y, x), and eps times its Hessian
/// (zz, yy, xx, zy, zx, yx).
#[derive(Clone, Copy, Debug)]
pub(super) struct Jet<T> {
    pub(super) u: T,
    pub(super) g: [T; 3],
    pub(super) h: [T; 6],
}

/// Derivatives of the density with respect to the Hessian (zz, yy, xx, and the pairs zy, zx,
/// yx, each counted once), the gradient (z, y, x), and u where no neighbour is involved.
pub(super) const FIELDS: usize = 10;

/// Invariants of a jet.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Invariants<T> {
    /// g . g.
    pub(super) q: T,
    pub(super) n: T,
    pub(super) inverse_n: T,
    pub(super) m: [T; 3],
    /// (eps H) m.
    pub(super) hm: [T; 3],
    pub(super) normal: T,
    pub(super) w: T,
    pub(super) trace: T,
    pub(super) square: T,
    /// 2 M - T^2.
    pub(super) d: T,
}

#[inline(always)]
pub(super) fn invariants<T: Float>(jet: &Jet<T>, k: &Constants<T>) -> Invariants<T> {
    let one = T::from_f64(1.0);
    let Jet { u, g: [gz, gy, gx], h: [hzz, hyy, hxx, hzy, hzx, hyx] } = *jet;
    let q = (gz * gz + gy * gy) + gx * gx;
    let n = (q + k.xi2).sqrt();
    let inverse_n = one / n;
    let m = [gz * inverse_n, gy * inverse_n, gx * inverse_n];
    let hm = [
        (hzz * m[0] + hzy * m[1]) + hzx * m[2],
        (hzy * m[0] + hyy * m[1]) + hyx * m[2],
        (hzx * m[0] + hyx * m[1]) + hxx * m[2],
    ];
    let normal = (hm[0] * m[0] + hm[1] * m[1]) + hm[2] * m[2];
    let w = (u * u - one) * u * k.inverse_eps;
    let trace = w - ((hzz + hyy) + hxx);
    let off = (hzy * hzy + hzx * hzx) + hyx * hyx;
    let square =
        ((hzz * hzz + hyy * hyy) + hxx * hxx) + ((off + off) + w * (w - (normal + normal)));
    let d = (square + square) - trace * trace;
    Invariants { q, n, inverse_n, m, hm, normal, w, trace, square, d }
}

/// `S` and `dS/dD`, from the softplus of width xi' (plus xi') of D.
#[inline(always)]
pub(super) fn root<T: Float>(d: T, k: &Constants<T>) -> (T, T) {
    let [zero, half, one] = [0.0, 0.5, 1.0].map(T::from_f64);
    let x = d.abs() * k.inverse_width;
    let cut = T::from_f64(T::NEGLIGIBLE);
    let y = T::exp_negative(if x < cut { x } else { cut });
    let positive = if d > zero { d } else { zero };
    let s = ((k.width + positive) + k.width * T::ln_one_plus(y)).sqrt();
    let slope = if d > zero { half } else { half * y };
    (s, slope / ((one + y) * s))
}

/// The same farther than `sharp` from 0, where the softplus is the positive part.
#[inline(always)]
pub(super) fn sharp_root<T: Float>(d: T, k: &Constants<T>) -> (T, T) {
    let [zero, half] = [0.0, 0.5].map(T::from_f64);
    let s = (k.width + if d > zero { d } else { zero }).sqrt();
    (s, (if d > zero { half } else { zero }) / s)
}

/// The density without the part `s_weight() S`, and without the factor dx^3.
#[inline(always)]
pub(super) fn smooth_density<T: Float>(i: &Invariants<T>, weights: &Weights<T>) -> T {
    let [c1, _, c3, c4, _, c6] = weights.c;
    (c1 * i.square + c6 * i.q) + i.trace * (c3 * i.trace + c4 * i.n)
}

/// Derivative of the density with respect to S.
#[inline(always)]
pub(super) fn s_weight<T: Float>(i: &Invariants<T>, weights: &Weights<T>) -> T {
    weights.c[1] * i.trace + weights.c[4] * i.n
}

/// Derivatives of the density, given [`root`]; of `i`, `q`, `square` and `d` are not used.
#[inline(always)]
pub(super) fn derivatives<T: Float>(
    u: T,
    h: &[T; 6],
    i: &Invariants<T>,
    (s, ds): (T, T),
    weights: &Weights<T>,
    k: &Constants<T>,
) -> [T; FIELDS] {
    let [one, two, three] = [1.0, 2.0, 3.0].map(T::from_f64);
    let [c1, c2, c3, c4, c5, c6] = weights.c;
    let Invariants { n, inverse_n, m, hm, normal, w, trace, .. } = *i;
    let e_d = s_weight(i, weights) * ds;
    let e_m = two * (c1 + two * e_d);
    let e_t = (c2 * s + c4 * n) + two * trace * (c3 - e_d);
    let e_normal = -(w * e_m);
    let e_w = e_m * (w - normal) + e_t;
    let mixed = e_m + e_m;
    let along = two * e_normal * inverse_n;
    let slope = ((c4 * trace + c5 * s) + two * c6 * n) - along * normal;
    let em = [e_normal * m[0], e_normal * m[1], two * e_normal * m[2]];
    [
        (e_m * h[0] - e_t) + em[0] * m[0],
        (e_m * h[1] - e_t) + em[1] * m[1],
        (e_m * h[2] - e_t) + (e_normal * m[2]) * m[2],
        mixed * h[3] + (em[0] + em[0]) * m[1],
        mixed * h[4] + em[2] * m[0],
        mixed * h[5] + em[2] * m[1],
        along * hm[0] + slope * m[0],
        along * hm[1] + slope * m[1],
        along * hm[2] + slope * m[2],
        e_w * (three * (u * u) - one) * k.to_well,
    ]
}
