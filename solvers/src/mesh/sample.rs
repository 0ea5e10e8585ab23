//! Fields seen at the triangles of a mesh.

use super::TriangleMesh;
use crate::random::{stream, uniform};
use crate::{Boundary, Error, Field, Result};
use rayon::prelude::*;

/// Values of `F` fields at the triangles of a mesh, and how much each counts.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceSamples<const F: usize> {
    /// The fields' values at the triangles' barycentres.
    pub values: Vec<[f64; F]>,
    /// Areas of the triangles (length^2), or parts of their sum.
    pub weights: Vec<f64>,
}

impl TriangleMesh {
    /// The fields, linearly interpolated at the barycentres of all triangles of at least
    /// `least_area` (length^2; 1e-4 of a grid cell's face leaves out the slivers of an
    /// isosurface), weighted by area. Vertices are in the fields' coordinates: node
    /// `(k, j, i)` at `[i h, j h, k h]`; beyond the nodes values are those of `boundary`.
    ///
    /// # Errors
    /// If the fields' shapes differ, or a triangle has no such vertex.
    pub fn sample<const F: usize>(
        &self,
        fields: [&Field; F],
        boundary: Boundary,
        least_area: f64,
    ) -> Result<SurfaceSamples<F>> {
        for field in fields.iter().skip(1) {
            field.check_shape("field", fields[0].grid())?;
        }
        let count = self.vertices.len();
        if let Some(&bad) = self.triangles.iter().flatten().find(|&&v| v as usize >= count) {
            let range = format!("[0, {count})");
            return Err(Error::out_of_range("corner of a triangle", f64::from(bad), &range));
        }
        let one = |t: usize| {
            let corners = self.triangles[t].map(|v| self.vertices[v as usize]);
            let center = [0, 1, 2].map(|m| corners.iter().map(|c| c[m]).sum::<f64>() / 3.0);
            let area = 0.5 * super::norm(self.double_normal(t));
            (fields.map(|field| interpolate(field, boundary, center)), area)
        };
        // All of them, whose number is known, straight to their places: large meshes fit once.
        let (mut values, mut weights) = (Vec::new(), Vec::new());
        let all = (0..self.triangles.len()).into_par_iter().map(one);
        all.unzip_into_vecs(&mut values, &mut weights);
        let mut large = weights.iter().map(|&area| area >= least_area);
        values.retain(|_| large.next().unwrap_or(false));
        weights.retain(|&area| area >= least_area);
        Ok(SurfaceSamples { values, weights })
    }
}

impl<const F: usize> SurfaceSamples<F> {
    /// At most `count` of the samples, drawn uniformly without repetition, in their order,
    /// with weights that add up to 1.
    pub fn subsample(&self, count: usize, seed: u64) -> Self {
        let n = self.values.len();
        let mut chosen: Vec<usize> = (0..n).collect();
        if count < n {
            let mut random = stream(seed, "surface subsample", 0);
            for k in 0..count {
                chosen.swap(k, k + (uniform(&mut random) * (n - k) as f64) as usize);
            }
            chosen.truncate(count);
            chosen.sort_unstable();
        }
        let total: f64 = chosen.iter().map(|&k| self.weights[k]).sum();
        Self {
            values: chosen.iter().map(|&k| self.values[k]).collect(),
            weights: chosen.iter().map(|&k| self.weights[k] / total).collect(),
        }
    }
}

/// Linear interpolation at `[x, y, z]` (length).
fn interpolate(field: &Field, boundary: Boundary, position: [f64; 3]) -> f64 {
    let grid = field.grid();
    // Of each axis (z, y, x) two nodes and the part of the second.
    let axes: [_; 3] = std::array::from_fn(|axis| {
        let n = grid.shape()[axis];
        let x = position[2 - axis] / grid.spacing();
        let low = match boundary {
            Boundary::Periodic | Boundary::Neumann => x.floor(),
            // The line through the two outermost nodes goes on.
            Boundary::Extrapolate => x.floor().clamp(0.0, n.saturating_sub(2) as f64),
        };
        let nodes = [0, 1].map(|step| boundary.wrap(low as isize + step, n));
        (nodes, x - low)
    });
    let [(ks, z), (js, y), (is, x)] = axes;
    let mix = |t: f64, [a, b]: [f64; 2]| if a == b { a } else { a + t * (b - a) };
    mix(z, ks.map(|k| mix(y, js.map(|j| mix(x, is.map(|i| field.at(k, j, i)))))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Grid;
    use std::f64::consts::TAU;

    /// A soup of triangles around random centres.
    fn soup(count: usize, low: f64, high: f64) -> TriangleMesh {
        let mut s = stream(1, "soup", 0);
        let mut mesh = TriangleMesh::default();
        for t in 0..count as u32 {
            let center = [0; 3].map(|_| low + (high - low) * uniform(&mut s));
            for _ in 0..3 {
                mesh.vertices.push(center.map(|c| c + 0.1 * (uniform(&mut s) - 0.5)));
            }
            mesh.triangles.push([3 * t, 3 * t + 1, 3 * t + 2]);
        }
        mesh
    }

    fn center(mesh: &TriangleMesh, t: usize) -> [f64; 3] {
        let corners = mesh.triangles[t].map(|v| mesh.vertices[v as usize]);
        [0, 1, 2].map(|m| corners.iter().map(|c| c[m]).sum::<f64>() / 3.0)
    }

    #[test]
    fn linear_fields_are_exact_also_beyond_the_nodes() {
        let grid = Grid::new(&[9, 7, 8], 0.5).unwrap();
        let linear = |[x, y, z]: [f64; 3]| 1.0 + 2.0 * x - 3.0 * y + 0.5 * z;
        let [a, b] = [1.0, -2.0].map(|c| Field::from_fn(grid, |p| c * linear(p)));
        let mesh = soup(200, -0.2, 3.2);
        let found = mesh.sample([&a, &b], Boundary::Extrapolate, 0.0).unwrap();
        assert!((found.weights.iter().sum::<f64>() / mesh.area() - 1.0).abs() < 1e-12);
        for (t, [a, b]) in found.values.iter().enumerate() {
            let exact = linear(center(&mesh, t));
            assert!((a - exact).abs() < 1e-12 && (b + 2.0 * exact).abs() < 1e-12);
        }
    }

    /// The error of linear interpolation is h^2/8 times the second derivatives' sum.
    #[test]
    fn periodic_fields_repeat() {
        let n = 64;
        let h = 1.0 / n as f64;
        let wave = |[x, y, z]: [f64; 3]| libm::cos(TAU * x) * libm::sin(TAU * (y + z));
        let field = Field::from_fn(Grid::new(&[n; 3], h).unwrap(), wave);
        let mesh = soup(300, -0.4, 1.6);
        let found = mesh.sample([&field], Boundary::Periodic, 0.0).unwrap();
        for (t, [v]) in found.values.iter().enumerate() {
            let error = (v - wave(center(&mesh, t))).abs();
            assert!(error < 3.0 * TAU * TAU * h * h / 8.0, "{error}");
        }
    }

    #[test]
    fn mirrored_fields_are_flat_beyond_the_nodes() {
        let field = Field::from_fn(Grid::new(&[3, 3, 3], 1.0).unwrap(), |[x, ..]| x);
        let at = |x| interpolate(&field, Boundary::Neumann, [x, -0.4, 2.4]);
        assert_eq!([at(-0.5), at(-0.1), at(2.0), at(2.5)], [0.0, 0.0, 2.0, 2.0]);
        assert!((at(1.25) - 1.25).abs() < 1e-15);
    }

    #[test]
    fn slivers_and_bad_corners() {
        let mut mesh = soup(5, 0.0, 1.0);
        let field = Field::constant(Grid::new(&[4, 4, 4], 0.5).unwrap(), 1.0);
        mesh.vertices[4] = mesh.vertices[3];
        let found = mesh.sample([&field], Boundary::Neumann, 1e-9).unwrap();
        assert_eq!(found.values.len(), 4);
        let other = Field::constant(Grid::new(&[4, 4], 0.5).unwrap(), 1.0);
        assert!(mesh.sample([&field, &other], Boundary::Neumann, 0.0).is_err());
        mesh.triangles[0][0] = 99;
        assert!(mesh.sample([&field], Boundary::Neumann, 0.0).is_err());
    }

    #[test]
    fn subsamples_are_fair_and_repeat() {
        let n = 2000;
        let values = (0..n).map(|k| [f64::from(k)]).collect();
        let all = SurfaceSamples { values, weights: vec![3.0; 2000] };
        let part = all.subsample(500, 7);
        assert_eq!(part, all.subsample(500, 7));
        assert_ne!(part, all.subsample(500, 8));
        // Ascending, hence without repetition.
        assert!(part.values.len() == 500 && part.values.is_sorted_by(|a, b| a < b));
        assert!((part.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let mean = part.values.iter().map(|v| v[0]).sum::<f64>() / 500.0;
        // Five standard errors of the mean of 500 out of 2000 numbers.
        assert!((mean - 999.5).abs() < 5.0 * (2000.0_f64.powi(2) / 12.0 / 500.0 * 0.75).sqrt());
        assert_eq!(all.subsample(5000, 0).values, all.values);
    }
}
