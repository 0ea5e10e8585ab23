//! The family of curves that turns distances in the map into memberships.

use nalgebra::{Matrix2, Vector2};

/// Parameters `(a, b)` of `1 / (1 + a x^(2 b))` nearest, at 300 distances x up to
/// `3 spread`, to 1 below `min_dist` and `exp(-(x - min_dist) / spread)` above
/// (Levenberg-Marquardt).
pub(super) fn fit(spread: f64, min_dist: f64) -> [f64; 2] {
    let samples: Vec<[f64; 2]> = (0..300)
        .map(|k| {
            let x = 3.0 * spread * f64::from(k) / 299.0;
            [x, if x < min_dist { 1.0 } else { libm::exp(-(x - min_dist) / spread) }]
        })
        .collect();
    let residual = |[a, b]: [f64; 2], [x, y]: [f64; 2]| 1.0 / (1.0 + a * libm::pow(x, 2.0 * b)) - y;
    let error = |p| samples.iter().map(|&s| residual(p, s) * residual(p, s)).sum::<f64>();
    let (mut best, mut damping) = ([1.0, 1.0], 1e-3);
    let mut least = error(best);
    while damping < 1e12 {
        let (mut normal, mut gradient) = (Matrix2::zeros(), Vector2::zeros());
        for &[x, y] in samples.iter().filter(|[x, _]| *x > 0.0) {
            let power = libm::pow(x, 2.0 * best[1]);
            let value = 1.0 / (1.0 + best[0] * power);
            let slope = -value * value * power;
            let row = Vector2::new(slope, 2.0 * best[0] * slope * libm::log(x));
            normal += row * row.transpose();
            gradient += row * (value - y);
        }
        let damped = normal + Matrix2::from_diagonal(&(normal.diagonal() * damping));
        let Some(step) = damped.lu().solve(&gradient) else { break };
        let next = [best[0] - step[0], best[1] - step[1]];
        let found = error(next);
        if found < least {
            (best, least, damping) = (next, found, damping * 0.1);
        } else {
            damping *= 10.0;
        }
    }
    best
}
