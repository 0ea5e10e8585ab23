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
/// The nearest of evenly spaced points, then Newton steps on the derivative of
/// the squared distance.
pub(super) fn flower(p: [f64; 3], radius: f64, amplitude: f64, lobes: usize) -> f64 {
    let k = lobes as f64;
    let (x, y) = (p[0], p[1]);
    let curve = |theta: f64| {
        let (s, c) = theta.sin_cos();
        let (ks, kc) = (k * theta).sin_cos();
        let r = radius * (1.0 + amplitude * kc);
        let (r1, r2) = (-radius * amplitude * k * ks, -radius * amplitude * k * k * kc);
        let point = [r * c - x, r * s - y];
        let rate = [r1 * c - r * s, r1 * s + r * c];
        let bend = [(r2 - r) * c - 2.0 * r1 * s, (r2 - r) * s + 2.0 * r1 * c];
        (point, rate, bend)
    };
    let square = |theta: f64| {
        let ([dx, dy], _, _) = curve(theta);
        dx * dx + dy * dy
    };
    let count = 16 * lobes + 16;
    let step = TAU / count as f64;
    let samples: f64 = (0..count)
        .map(|m| m as f64 * step)
        .min_by(|a, b| square(*a).total_cmp(&square(*b)))
        .unwrap_or(0.0);
    let mut theta = samples;
    let mut best = square(theta);
    for _ in 0..20 {
        let (d, rate, bend) = curve(theta);
        let slope = d[0] * rate[0] + d[1] * rate[1];
        let second = rate[0] * rate[0] + rate[1] * rate[1] + d[0] * bend[0] + d[1] * bend[1];
        let change = if second > 0.0 { -slope / second } else { -slope.signum() * 0.25 * step };
        let next = theta + change.clamp(-step, step);
        let found = square(next);
        if found >= best {
            break;
        }
        (theta, best) = (next, found);
    }
    let here = radius * (1.0 + amplitude * (k * y.atan2(x)).cos());
    if x.hypot(y) < here { -best.sqrt() } else { best.sqrt() }
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
