//! The fuzzy graph of neighbours.

use ndarray::ArrayView2;
use std::collections::BTreeMap;

/// Least scale of a point's surroundings, as a part of the mean distance.
const LEAST_SCALE: f64 = 1e-3;

/// An edge `(i, j)` and its membership in (0, 1].
pub(super) type Edge = (u32, u32, f64);

/// The memberships `p + q - p q`, where p is how near j is to i in units of i's
/// surroundings, and q the same seen from j; in the order of (i, j), both ways.
pub(super) fn fuzzy_graph(distances: ArrayView2<'_, f64>, neighbors: usize) -> Vec<Edge> {
    let mut directed = BTreeMap::new();
    let mean = distances.mean().unwrap_or(0.0);
    for (i, row) in distances.rows().into_iter().enumerate() {
        let mut near: Vec<(f64, u32)> = row.iter().zip(0..).map(|(&d, j)| (d, j)).collect();
        // The point itself comes first, also among points at its place.
        near.sort_by(|a, b| {
            a.0.total_cmp(&b.0).then((a.1 != i as u32).cmp(&(b.1 != i as u32)).then(a.1.cmp(&b.1)))
        });
        near.truncate(neighbors);
        let (rho, sigma) = surroundings(&near, mean);
        for &(d, j) in &near[1..] {
            let p = if d <= rho || sigma == 0.0 { 1.0 } else { libm::exp(-(d - rho) / sigma) };
            directed.insert((i as u32, j), p);
        }
    }
    let mut union = BTreeMap::new();
    for (&(i, j), &p) in &directed {
        let q = directed.get(&(j, i)).copied().unwrap_or(0.0);
        union.insert((i, j), p + q - p * q);
        union.insert((j, i), p + q - p * q);
    }
    union.into_iter().filter(|e| e.1 > 0.0).map(|((i, j), p)| (i, j, p)).collect()
}

/// Distance rho to the nearest other point, and the scale sigma at which
/// `sum over neighbours of exp(-(d - rho) / sigma) = log2(number of neighbours)`.
fn surroundings(near: &[(f64, u32)], mean_of_all: f64) -> (f64, f64) {
    let target = libm::log2(near.len() as f64);
    let rho = near.iter().map(|n| n.0).find(|&d| d > 0.0).unwrap_or(0.0);
    let (mut low, mut high, mut sigma) = (0.0, f64::INFINITY, 1.0);
    for _ in 0..64 {
        let membership = |d: f64| if d > rho { libm::exp(-(d - rho) / sigma) } else { 1.0 };
        let sum: f64 = near[1..].iter().map(|n| membership(n.0)).sum();
        if (sum - target).abs() < 1e-5 {
            break;
        }
        if sum > target {
            high = sigma;
        } else {
            low = sigma;
        }
        sigma = if high == f64::INFINITY { 2.0 * sigma } else { 0.5 * (low + high) };
    }
    let mean = near.iter().map(|n| n.0).sum::<f64>() / near.len() as f64;
    let least = LEAST_SCALE * if rho > 0.0 { mean } else { mean_of_all };
    (rho, sigma.max(least))
}
