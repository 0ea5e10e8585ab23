//! Plane slices of fields, magnified, shrunk, contoured.

use super::colormap::catmull_rom;
use solvers::Field;

/// A plane array, row 0 at the top.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Slice {
    pub(crate) nx: usize,
    pub(crate) ny: usize,
    /// Row-major, `ny` rows.
    pub(crate) values: Vec<f64>,
    /// Node distance (length).
    pub(crate) spacing: f64,
    /// Unit of lengths: `cells` where the field's spacing is 1.
    pub(crate) unit: &'static str,
    /// Names of the horizontal and the vertical axis.
    pub(crate) axes: [&'static str; 2],
    /// Label and step of the rows, if they are not places.
    pub(crate) rows: Option<(&'static str, f64)>,
    /// Where a solid was cut: `z = 12`; empty in the plane.
    pub(crate) at: String,
}

/// `cells` where the node distance is 1, else `length`.
pub(crate) fn unit(spacing: f64) -> &'static str {
    if spacing == 1.0 { "cells" } else { "length" }
}

/// The field itself in 1D and 2D; its middle slices across z, y and x in 3D.
pub(crate) fn middle(field: &Field) -> Vec<Slice> {
    let grid = field.grid();
    let ([nz, ny, nx], spacing) = (grid.shape(), grid.spacing());
    let unit = unit(spacing);
    if grid.dim() < 3 {
        let values = field.as_slice().to_vec();
        let (axes, at) = (["x", "y"], String::new());
        return vec![Slice { nx, ny, values, spacing, unit, axes, rows: None, at }];
    }
    let cut = |[nx, ny]: [usize; 2],
               axes,
               (across, n): (&str, usize),
               value: &dyn Fn(usize, usize) -> f64| Slice {
        nx,
        ny,
        values: (0..ny).flat_map(|j| (0..nx).map(move |i| value(j, i))).collect(),
        spacing,
        unit,
        axes,
        rows: None,
        at: format!("{across} = {}", n as f64 * spacing),
    };
    let [k, j, i] = [nz / 2, ny / 2, nx / 2];
    vec![
        cut([nx, ny], ["x", "y"], ("z", k), &|y, x| field.at(k, y, x)),
        cut([nx, nz], ["x", "z"], ("y", j), &|z, x| field.at(z, j, x)),
        cut([ny, nz], ["y", "z"], ("x", i), &|z, y| field.at(z, y, i)),
    ]
}

impl Slice {
    /// Means of blocks of `times` x `times` cells, cut blocks at the far ends included.
    pub(crate) fn shrink(self, times: usize) -> Self {
        if times <= 1 {
            return self;
        }
        let (nx, ny) = (self.nx.div_ceil(times), self.ny.div_ceil(times));
        let mut values = Vec::with_capacity(nx * ny);
        for j in 0..ny {
            for i in 0..nx {
                let (x1, y1) = ((i * times + times).min(self.nx), (j * times + times).min(self.ny));
                let mut sum = 0.0;
                for y in j * times..y1 {
                    sum +=
                        self.values[y * self.nx + i * times..y * self.nx + x1].iter().sum::<f64>();
                }
                values.push(sum / ((x1 - i * times) * (y1 - j * times)) as f64);
            }
        }
        let rows = self.rows.map(|(label, step)| (label, step * times as f64));
        Self { nx, ny, values, spacing: self.spacing * times as f64, rows, ..self }
    }

    /// Interpolates to `times` x `times` samples a cell, Catmull-Rom, replicated border.
    pub(crate) fn magnify(&self, times: usize) -> Self {
        let across = stretch(&self.values, self.nx, times);
        let nx = self.nx * times;
        let turned = transpose(&across, nx);
        let values = transpose(&stretch(&turned, self.ny, times), self.ny * times);
        let spacing = self.spacing / times as f64;
        Self { nx, ny: self.ny * times, values, spacing, at: self.at.clone(), ..*self }
    }

    /// Share of each sample's square in which a level-set function is not negative: the
    /// plane through the value, with slopes by central differences, over the square.
    pub(crate) fn outside(&self) -> Vec<f64> {
        let (nx, ny) = (self.nx, self.ny);
        let at = |j: usize, i: usize| self.values[j * nx + i];
        let mut shares = Vec::with_capacity(nx * ny);
        for j in 0..ny {
            let (up, down) = (j.saturating_sub(1), (j + 1).min(ny - 1));
            for i in 0..nx {
                let (left, right) = (i.saturating_sub(1), (i + 1).min(nx - 1));
                let gx = (at(j, right) - at(j, left)) / (right - left).max(1) as f64;
                let gy = (at(down, i) - at(up, i)) / (down - up).max(1) as f64;
                // f64::MIN_POSITIVE: 0 / 0 on a plateau at zero counts as outside.
                let slope = (gx.abs() + gy.abs()).max(f64::MIN_POSITIVE);
                shares.push(half_plane(at(j, i) / slope, gx.abs() / slope));
            }
        }
        shares
    }

    /// Where the values change sign, by marching squares with linear interpolation:
    /// segments between `[x, y]` in cells, cell (0, 0) at the origin. The border is
    /// replicated by half a cell, to the edge of the picture.
    pub(crate) fn zero_segments(&self) -> Vec<[[f64; 2]; 2]> {
        let mut segments = Vec::new();
        for j in 0..=self.ny {
            for i in 0..=self.nx {
                self.square([j, i], &mut segments);
            }
        }
        segments
    }

    /// Segments in the square with far corner `(j, i)`.
    fn square(&self, [j, i]: [usize; 2], segments: &mut Vec<[[f64; 2]; 2]>) {
        let rows = [j.saturating_sub(1), j.min(self.ny - 1)];
        let columns = [i.saturating_sub(1), i.min(self.nx - 1)];
        let end = |n: usize, count: usize| (n as f64).clamp(0.0, count as f64) - 0.5;
        // Nodes at whole numbers; the replicated border at -1/2 and n - 1/2.
        let ys = [
            if j == 0 { -0.5 } else { rows[0] as f64 },
            if j == self.ny { end(j, self.ny) } else { j as f64 },
        ];
        let xs = [
            if i == 0 { -0.5 } else { columns[0] as f64 },
            if i == self.nx { end(i, self.nx) } else { i as f64 },
        ];
        // Corners around the square.
        let corners = [(0, 0), (0, 1), (1, 1), (1, 0)];
        let v = corners.map(|(a, b)| self.values[rows[a] * self.nx + columns[b]]);
        if v.iter().all(|v| *v < 0.0) || v.iter().all(|v| *v >= 0.0) || v.iter().any(|v| v.is_nan())
        {
            return;
        }
        let mut crossings = [[0.0; 2]; 4];
        let mut count = 0;
        for n in 0..4 {
            let m = (n + 1) % 4;
            if (v[n] < 0.0) != (v[m] < 0.0) {
                let t = v[n] / (v[n] - v[m]);
                let ((a, b), (c, d)) = (corners[n], corners[m]);
                crossings[count] = [xs[b] + t * (xs[d] - xs[b]), ys[a] + t * (ys[c] - ys[a])];
                count += 1;
            }
        }
        let [p, q, r, s] = crossings;
        match count {
            2 => segments.push([p, q]),
            // A saddle: the middle's sign decides which corners are cut off.
            4 if (v.iter().sum::<f64>() < 0.0) == (v[0] < 0.0) => segments.extend([[p, q], [r, s]]),
            4 => segments.extend([[q, r], [s, p]]),
            _ => {}
        }
    }
}

/// Share of the unit square where `u x + (1 - u) y + d >= 0`, square centred on 0, u in [0, 1].
fn half_plane(d: f64, u: f64) -> f64 {
    // The sum of two uniform variables of widths u and 1 - u: a trapezoid, integrated.
    let (a, b) = (u.max(1.0 - u), u.min(1.0 - u));
    let x = d.abs();
    let part = if x >= 0.5 {
        0.5
    } else if x <= 0.5 * (a - b) {
        x / a
    } else {
        0.5 - (0.5 - x) * (0.5 - x) / (2.0 * a * b)
    };
    if d.is_nan() { 1.0 } else { 0.5 + part.copysign(d) }
}

/// Interpolates each row of `nx` values to `nx * times`.
fn stretch(values: &[f64], nx: usize, times: usize) -> Vec<f64> {
    if times == 1 {
        return values.to_vec();
    }
    // Weights of four cells in a row for each of the samples in a cell, and the first of the four.
    let phases: Vec<(usize, [f64; 4])> = (0..times)
        .map(|n| {
            let x = (n as f64 + 0.5) / times as f64 - 0.5;
            let (first, f) = if x < 0.0 { (0, x + 1.0) } else { (1, x) };
            let unit = |m: usize| std::array::from_fn(|k| if k == m { 1.0 } else { 0.0 });
            (first, std::array::from_fn(|m| catmull_rom(unit(m), f)))
        })
        .collect();
    let mut wide = Vec::with_capacity(values.len() * times);
    let mut padded = Vec::with_capacity(nx + 4);
    for row in values.chunks_exact(nx) {
        padded.clear();
        padded.extend([row[0]; 2]);
        padded.extend(row);
        padded.extend([row[nx - 1]; 2]);
        for cells in padded.windows(5) {
            wide.extend(phases.iter().map(|&(first, w)| {
                let p = &cells[first..first + 4];
                w[0] * p[0] + w[1] * p[1] + w[2] * p[2] + w[3] * p[3]
            }));
        }
    }
    wide
}

/// Columns of an array of rows of `nx` as rows.
fn transpose(values: &[f64], nx: usize) -> Vec<f64> {
    let ny = values.len() / nx;
    let mut turned = vec![0.0; values.len()];
    for (j, row) in values.chunks_exact(nx).enumerate() {
        for (i, &v) in row.iter().enumerate() {
            turned[i * ny + j] = v;
        }
    }
    turned
}

#[cfg(test)]
mod tests {
    use super::*;
    use solvers::Grid;
    use std::f64::consts::PI;

    fn disc(n: usize, radius: f64) -> Slice {
        let grid = Grid::new(&[n, n], 1.0).unwrap();
        let c = grid.center();
        middle(&Field::from_fn(grid, |[x, y, _]| (x - c[0]).hypot(y - c[1]) - radius)).remove(0)
    }

    #[test]
    fn ink_keeps_the_area_of_a_disc() {
        let outside = disc(40, 13.3).magnify(6).outside();
        let area = outside.iter().map(|v| 1.0 - v).sum::<f64>() / 36.0;
        let exact = PI * 13.3 * 13.3;
        // Cubic interpolation of a distance function near a circle of 13 cells: third order.
        assert!((area - exact).abs() < 2e-4 * exact, "{area} {exact}");
    }

    #[test]
    fn the_zero_line_is_a_circle_and_closes() {
        let segments = disc(40, 13.3).zero_segments();
        let length: f64 = segments.iter().map(|[p, q]| (p[0] - q[0]).hypot(p[1] - q[1])).sum();
        // Chords of an inscribed polygon with sides of a cell: relative 1 / (24 r^2).
        assert!((length - 2.0 * PI * 13.3).abs() < 0.05, "{length}");
        for [p, q] in &segments {
            for point in [p, q] {
                let r = (point[0] - 19.5).hypot(point[1] - 19.5);
                assert!((r - 13.3).abs() < 0.02, "{point:?}");
            }
        }
    }

    #[test]
    fn a_line_across_the_picture_reaches_both_edges() {
        let grid = Grid::new(&[5, 7], 1.0).unwrap();
        let slice = middle(&Field::from_fn(grid, |[x, _, _]| x - 2.25)).remove(0);
        let segments = slice.zero_segments();
        let ys: Vec<f64> = segments.iter().flatten().map(|p| p[1]).collect();
        assert_eq!(ys.iter().copied().fold(9.0, f64::min), -0.5);
        assert_eq!(ys.iter().copied().fold(-9.0, f64::max), 4.5);
        assert!(segments.iter().flatten().all(|p| (p[0] - 2.25).abs() < 1e-12));
    }

    #[test]
    fn shares_of_a_square_are_exact() {
        // A diagonal through the middle, axis-parallel, a corner cut off: area 1/8 . (1/2)^2 ...
        assert_eq!(half_plane(0.0, 0.5), 0.5);
        assert_eq!(half_plane(0.25, 1.0), 0.75);
        assert!((half_plane(-0.25, 0.5) - 0.125).abs() < 1e-15);
        assert_eq!(half_plane(7.0, 0.3), 1.0);
    }

    #[test]
    fn shrinking_averages() {
        let grid = Grid::new(&[3, 5], 1.0).unwrap();
        let slice = middle(&Field::from_fn(grid, |[x, y, _]| x + 10.0 * y)).remove(0).shrink(2);
        assert_eq!((slice.nx, slice.ny), (3, 2));
        assert_eq!(slice.values, [5.5, 7.5, 9.0, 20.5, 22.5, 24.0]);
    }
}
