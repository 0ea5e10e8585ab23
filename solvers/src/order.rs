//! Observed order of convergence, for tests and for the README table.

/// Least-squares slope p of log error = -p log n over the resolutions `n`.
pub fn observed_order(n: &[usize], error: impl Fn(usize) -> f64) -> f64 {
    let points: Vec<(f64, f64)> = n.iter().map(|&n| ((n as f64).ln(), error(n).ln())).collect();
    let count = points.len() as f64;
    let mean_x = points.iter().map(|p| p.0).sum::<f64>() / count;
    let mean_y = points.iter().map(|p| p.1).sum::<f64>() / count;
    let xy: f64 = points.iter().map(|p| (p.0 - mean_x) * (p.1 - mean_y)).sum();
    let xx: f64 = points.iter().map(|p| (p.0 - mean_x).powi(2)).sum();
    -xy / xx
}

#[cfg(test)]
mod tests {
    #[test]
    fn slope_of_a_power_law() {
        let order = super::observed_order(&[8, 16, 32], |n| 3.0 * (n as f64).powi(-2));
        assert!((order - 2.0).abs() < 1e-12);
    }
}
