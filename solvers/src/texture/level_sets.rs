//! Area, perimeter, Euler number and curvature of the level sets of a smoothed picture.

use super::{Masked, smooth::smooth_ink};

/// Share of the Gaussian's weight that must be visible for a smoothed value to count.
const LEAST_COVER: f64 = 0.6;

/// Minkowski densities of a level set.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Densities {
    /// Area over the area seen.
    pub area: f64,
    /// Perimeter over the area seen (1/pixel).
    pub perimeter: f64,
    /// Euler number (parts minus holes) over the area seen (1/pixel^2); squares that two
    /// corners of the set share count half as joined, so that the complement has its negative.
    pub euler: f64,
}

/// A picture smoothed, where enough of it is visible.
#[derive(Clone, Debug)]
pub struct LevelSets {
    shape: [usize; 2],
    values: Vec<f64>,
    seen: Vec<bool>,
}

impl LevelSets {
    /// The picture under a Gaussian of width `sigma` (pixels).
    pub fn new(picture: &Masked<'_>, sigma: f64) -> Self {
        let (values, cover) = smooth_ink(picture, sigma);
        // At the picture's border half of the weight is missing, in its corners three quarters.
        let seen = cover.iter().map(|&cover| cover >= LEAST_COVER).collect();
        Self { shape: picture.shape, values, seen }
    }

    /// Smoothed values and whether they count.
    pub(super) fn parts(&self) -> (&[f64], &[bool]) {
        (&self.values, &self.seen)
    }

    /// The squares of four pixels that all count, as `[n00, n01, n10, n11]`.
    fn squares(&self) -> impl Iterator<Item = [usize; 4]> {
        let [ny, nx] = self.shape;
        (0..ny.saturating_sub(1))
            .flat_map(move |j| (0..nx.saturating_sub(1)).map(move |i| j * nx + i))
            .map(move |n| [n, n + 1, n + nx, n + nx + 1])
            .filter(|corners| corners.iter().all(|&n| self.seen[n]))
    }

    /// Densities of the set above `level`, from squares of four pixels: the border runs
    /// straight between the points where the interpolated edges cross the level.
    pub fn densities(&self, level: f64) -> Densities {
        let (mut count, mut area, mut perimeter, mut euler) = (0.0, 0.0, 0.0, 0.0);
        for corners in self.squares() {
            let v = corners.map(|n| self.values[n] - level);
            let inside = v.iter().filter(|&&v| v > 0.0).count();
            count += 1.0;
            area += inside as f64 / 4.0;
            perimeter += border_length(v);
            euler += match inside {
                1 => 0.25,
                3 => -0.25,
                _ => 0.0,
            };
        }
        let count = f64::max(count, 1.0);
        Densities { area: area / count, perimeter: perimeter / count, euler: euler / count }
    }

    /// Quantiles `shares` of the curvature (1/pixel, positive around ink) along the border at
    /// `level`, each square weighted by the length of border in it; zeros without a border.
    pub fn curvature(&self, level: f64, shares: &[f64]) -> Vec<f64> {
        let [_, nx] = self.shape;
        let mut found: Vec<(f64, f64)> = Vec::new();
        for corners in self.squares() {
            let length = border_length(corners.map(|n| self.values[n] - level));
            if length == 0.0 {
                continue;
            }
            let bends = corners.iter().filter_map(|&n| self.bend(n, nx));
            let (sum, count) = bends.fold((0.0, 0.0), |(sum, count), b| (sum + b, count + 1.0));
            if count > 0.0 {
                found.push((sum / count, length));
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let total: f64 = found.iter().map(|f| f.1).sum();
        let quantile = |&share: &f64| {
            let mut passed = 0.0;
            let at = found.iter().find(|f| {
                passed += f.1;
                passed >= share * total
            });
            at.map_or(0.0, |f| f.0)
        };
        shares.iter().map(quantile).collect()
    }

    /// Curvature `-div(grad u / |grad u|)` at a pixel, by central differences.
    fn bend(&self, n: usize, nx: usize) -> Option<f64> {
        let u = &self.values;
        let around = [n.checked_sub(nx + 1)?, n - nx, n - nx + 1, n - 1, n + 1, n + nx - 1, n + nx];
        let last = n + nx + 1;
        let inside = !n.is_multiple_of(nx) && n % nx + 1 < nx && last < u.len();
        if !inside || !around.iter().all(|&m| self.seen[m]) || !self.seen[last] {
            return None;
        }
        let (x, y) = (0.5 * (u[n + 1] - u[n - 1]), 0.5 * (u[n + nx] - u[n - nx]));
        let (xx, yy) = (u[n + 1] - 2.0 * u[n] + u[n - 1], u[n + nx] - 2.0 * u[n] + u[n - nx]);
        let xy = 0.25 * (u[last] + u[n - nx - 1] - u[n - nx + 1] - u[n + nx - 1]);
        let slope = x * x + y * y;
        (slope > 1e-8).then(|| -(xx * y * y - 2.0 * x * y * xy + yy * x * x) / slope.powf(1.5))
    }
}

/// Length of the zero line of the values at a unit square's corners `[v00, v01, v10, v11]`.
fn border_length(v: [f64; 4]) -> f64 {
    // Edges by their corners, and where they lie: top, bottom, left, right.
    const EDGES: [(usize, usize); 4] = [(0, 1), (2, 3), (0, 2), (1, 3)];
    let mut points = [[0.0; 2]; 4];
    let mut count = 0;
    for (edge, &(a, b)) in EDGES.iter().enumerate() {
        if (v[a] > 0.0) != (v[b] > 0.0) {
            let t = v[a] / (v[a] - v[b]);
            points[count] = match edge {
                0 => [t, 0.0],
                1 => [t, 1.0],
                2 => [0.0, t],
                _ => [1.0, t],
            };
            count += 1;
        }
    }
    let distance = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    match count {
        2 => distance(points[0], points[1]),
        // A saddle: the shorter of the two ways to join its four points.
        4 => {
            let one = distance(points[0], points[2]) + distance(points[1], points[3]);
            let other = distance(points[0], points[3]) + distance(points[1], points[2]);
            one.min(other)
        }
        _ => 0.0,
    }
}
