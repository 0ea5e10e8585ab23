//! Ellipses and ellipsoids, the smooth star, Zalesak's disk.

use std::f64::consts::TAU;

/// Signed distance to the ellipsoid of semi-axes `radii` around the origin.
///
/// The foot point is `e_i^2 p_i / (t + e_i^2)` for the largest root t of
/// `sum (e_i p_i / (t + e_i^2))^2 = 1` (Eberly 2013, "Distance from a point to an
/// ellipse, an ellipsoid or a hyperellipsoid"), found by bisection to the last bit.
pub(super) fn ellipsoid(p: [f64; 3], radii: &[f64]) -> f64 {
    let n = radii.len();
    let smallest = radii.iter().copied().fold(f64::INFINITY, f64::min);
    // A point on a plane of symmetry may have two feet; a hair beside it has one.
    let tiny = 1e-14 * radii.iter().copied().fold(0.0, f64::max);
    let p: [f64; 3] = p.map(|c| c.abs().max(tiny));
    let level = |t: f64| {
        (0..n).map(|m| (radii[m] * p[m] / (t + radii[m] * radii[m])).powi(2)).sum::<f64>() - 1.0
    };
    let square = smallest * smallest;
    let reach = (0..n).map(|m| (radii[m] * p[m]).powi(2)).sum::<f64>().sqrt();
    // The root lies where the smallest axis alone gives 1, or above.
    let least = (0..n).filter(|&m| radii[m] == smallest).map(|m| p[m]).fold(0.0, f64::max);
    let (mut low, mut high) = (smallest * least - square, reach - square);
    high = high.max(low);
    loop {
        let t = 0.5 * (low + high);
        if t <= low || t >= high {
            break;
        }
        if level(t) > 0.0 {
            low = t;
        } else {
            high = t;
        }
    }
    let t = 0.5 * (low + high);
    let apart = (0..n).map(|m| (p[m] * t / (t + radii[m] * radii[m])).powi(2)).sum::<f64>().sqrt();
    let inside = (0..n).map(|m| (p[m] / radii[m]).powi(2)).sum::<f64>() < 1.0;
    if inside { -apart } else { apart }
}

/// Signed distance to r(theta) = radius (1 + amplitude cos(lobes theta)).
///
/// Each minimum among evenly spaced points is refined by Newton's method on the
/// derivative of the squared distance, kept between the neighbouring points.
pub(super) fn flower(p: [f64; 3], radius: f64, amplitude: f64, lobes: usize) -> f64 {
    let k = lobes as f64;
    let (x, y) = (p[0], p[1]);
    // Half the squared distance to the curve at theta, and two derivatives.
    let half_square = |theta: f64| {
        let (s, c) = theta.sin_cos();
        let (ks, kc) = (k * theta).sin_cos();
        let r = radius * (1.0 + amplitude * kc);
        let (r1, r2) = (-radius * amplitude * k * ks, -radius * amplitude * k * k * kc);
        let d = [r * c - x, r * s - y];
        let rate = [r1 * c - r * s, r1 * s + r * c];
        let bend = [(r2 - r) * c - 2.0 * r1 * s, (r2 - r) * s + 2.0 * r1 * c];
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        [0.5 * dot(d, d), dot(d, rate), dot(rate, rate) + dot(d, bend)]
    };
    let step = TAU / (16 * lobes + 16) as f64;
    let sample = |m: usize| half_square(m as f64 * step)[0];
    let mut best = f64::INFINITY;
    let (mut before, mut here) = (sample(0), sample(1));
    for m in 1..=16 * lobes + 16 {
        let after = sample(m + 1);
        if here <= before && here <= after {
            let theta = m as f64 * step;
            best = best.min(refine(half_square, theta - step, theta + step));
        }
        (before, here) = (here, after);
    }
    let rim = radius * (1.0 + amplitude * (k * y.atan2(x)).cos());
    let distance = (2.0 * best).sqrt();
    if x.hypot(y) < rim { -distance } else { distance }
}

/// Least value of `f = [value, slope, second derivative]` between `low` and `high`.
fn refine(f: impl Fn(f64) -> [f64; 3], mut low: f64, mut high: f64) -> f64 {
    let mut theta = 0.5 * (low + high);
    let mut best = f64::INFINITY;
    for _ in 0..60 {
        let [value, slope, second] = f(theta);
        best = best.min(value);
        if slope > 0.0 {
            high = theta;
        } else {
            low = theta;
        }
        let newton = theta - slope / second;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - theta).abs() < 1e-15 {
            break;
        }
        theta = next;
    }
    best
}

/// Signed distance to a disk with a slot that enters from below.
pub(super) fn zalesak(p: [f64; 3], radius: f64, width: f64, length: f64) -> f64 {
    let (x, y) = (p[0].abs(), p[1]);
    let half = 0.5 * width;
    let top = length - radius;
    let bottom = -(radius * radius - half * half).sqrt();
    // The slot may be so short and wide that its corners lie below the disk's rim.
    let top = top.max(bottom);
    let r = x.hypot(y);
    let in_slot = x < half && y < top;
    // The rim ends where the slot's side leaves it.
    let on_rim = !(x * -bottom < half * -y && y < 0.0);
    let rim = if on_rim { (r - radius).abs() } else { (x - half).hypot(y - bottom) };
    let flat = |q: [f64; 2]| [q[0], q[1], 0.0];
    let side = super::polygon::to_segment([x, y, 0.0], flat([half, bottom]), flat([half, top]));
    let lid = super::polygon::to_segment([x, y, 0.0], flat([0.0, top]), flat([half, top]));
    let distance = rim.min(side).min(lid);
    if r < radius && !in_slot { -distance } else { distance }
}
