//! Meshes as volumes.

use super::TriangleMesh;
use crate::{Error, Field, Grid, Result};

/// Rays through a voxel along each of y and z.
const RAYS: usize = 2;

impl TriangleMesh {
    /// The part of each voxel that lies inside a closed mesh, in [0, 1]: exact along x, from
    /// 2 x 2 rays across. Voxel `(k, j, i)` is the cube of the grid's spacing around
    /// `origin + [i, j, k] h`; what lies beyond the grid is left out.
    ///
    /// Inside is where a ray has crossed the surface an odd number of times, so that the sense
    /// of the triangles does not matter. A ray through an edge between two triangles crosses one
    /// of them; one that only touches the outline may count as inside or outside.
    ///
    /// # Errors
    /// If the mesh is not closed once equal corners are one, or a corner is not finite.
    pub fn occupancy(&self, grid: Grid, origin: [f64; 3]) -> Result<Field> {
        let mesh = self.weld();
        if let Some(bad) = mesh.vertices.iter().flatten().find(|c| !c.is_finite()) {
            return Err(Error::out_of_range("coordinate of a vertex", *bad, "(-inf, inf)"));
        }
        if !mesh.is_closed() {
            return Err(Error::Invalid("a mesh with holes has no inside".into()));
        }
        let ([nz, ny, nx], h) = (grid.shape(), grid.spacing());
        let columns = ny * RAYS;
        let mut crossings = mesh.crossings([columns, nz * RAYS], origin, h / RAYS as f64);
        crossings.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let mut field = Field::constant(grid, 0.0);
        let values = field.as_mut_slice();
        for ray in crossings.chunk_by(|a, b| a.0 == b.0) {
            let (j, k) = (ray[0].0 % columns / RAYS, ray[0].0 / columns / RAYS);
            let row = &mut values[(k * ny + j) * nx..][..nx];
            for pair in ray.chunks_exact(2) {
                // In voxels from the lower face of the first.
                let [from, to] = [pair[0].1, pair[1].1]
                    .map(|x| ((x - origin[0]) / h + 0.5).clamp(0.0, nx as f64));
                let first = from as usize;
                for (i, v) in row.iter_mut().enumerate().take(to.ceil() as usize).skip(first) {
                    let inside = to.min(i as f64 + 1.0) - from.max(i as f64);
                    *v += inside / (RAYS * RAYS) as f64;
                }
            }
        }
        Ok(field)
    }

    /// Where rays along x meet triangles: number of the ray, x. The `count` rays along y and z
    /// are `step` apart, the first of them in the middle of its part of a voxel.
    fn crossings(&self, count: [usize; 2], origin: [f64; 3], step: f64) -> Vec<(usize, f64)> {
        let first = [1, 2].map(|m| origin[m] - 0.5 * step * (RAYS as f64 - 1.0));
        let mut crossings = Vec::new();
        for corners in &self.triangles {
            let [a, b, c] = corners.map(|v| self.vertices[v as usize]);
            let reach = |m: usize| {
                let low = a[m + 1].min(b[m + 1]).min(c[m + 1]);
                let high = a[m + 1].max(b[m + 1]).max(c[m + 1]);
                let from = ((low - first[m]) / step).ceil().max(0.0) as usize;
                let to = ((high - first[m]) / step).floor() + 1.0;
                from..(to.max(0.0) as usize).min(count[m])
            };
            for k in reach(1) {
                for j in reach(0) {
                    let ray = [first[0] + j as f64 * step, first[1] + k as f64 * step];
                    let sides = [[0, 1], [1, 2], [2, 0]]
                        .map(|[from, to]| self.side([corners[from], corners[to]], ray));
                    let inside = sides.iter().all(|s| s.0) || sides.iter().all(|s| !s.0);
                    let total: f64 = sides.iter().map(|s| s.1).sum();
                    if inside && total != 0.0 {
                        // The side opposite to a corner is its weight.
                        let x = (sides[1].1 * a[0] + sides[2].1 * b[0] + sides[0].1 * c[0]) / total;
                        crossings.push((k * count[0] + j, x));
                    }
                }
            }
        }
        crossings
    }

    /// On which side of an edge, seen along x, a ray passes, and twice the area between them.
    /// Both triangles at an edge see the same number, so that none or both take the ray.
    fn side(&self, [from, to]: [u32; 2], ray: [f64; 2]) -> (bool, f64) {
        let [a, b] = [from.min(to), from.max(to)].map(|v| self.vertices[v as usize]);
        let area = (b[1] - a[1]) * (ray[1] - a[2]) - (b[2] - a[2]) * (ray[0] - a[1]);
        let left = area >= 0.0;
        if from < to { (left, area) } else { (!left, -area) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::isosurface::{self, Caps};

    fn total(field: &Field) -> f64 {
        field.as_slice().iter().sum::<f64>() * field.grid().spacing().powi(3)
    }

    #[test]
    fn a_box_fills_its_voxels() {
        // Faces on those of voxels and between them, none along a ray.
        let corner = |n: u32| {
            let bit = |m: u32| f64::from(n >> m & 1);
            [0.3 + 2.4 * bit(0), 0.5 + 2.0 * bit(1), 0.3 + 1.5 * bit(2)]
        };
        let quads =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let mesh = TriangleMesh {
            vertices: (0..8).map(corner).collect(),
            triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        };
        let grid = Grid::new(&[4, 4, 4], 1.0).unwrap();
        let field = mesh.occupancy(grid, [0.0; 3]).unwrap();
        assert!((total(&field) - 2.4 * 2.0 * 1.5).abs() < 1e-12, "{}", total(&field));
        // Voxel (1, 1, 1) is whole; (1, 1, 0) begins at x = 0.3, its end is at 0.5.
        assert_eq!(field.as_slice()[(4 + 1) * 4 + 1], 1.0);
        assert!((field.as_slice()[(4 + 1) * 4] - 0.2).abs() < 1e-12);
    }

    #[test]
    fn a_sphere_has_its_volume_and_an_open_mesh_no_inside() {
        let grid = Grid::new(&[40, 44, 48], 0.05).unwrap();
        let far = |p: [f64; 3]| {
            ((p[0] - 1.2).powi(2) + (p[1] - 1.1).powi(2) + (p[2] - 1.0).powi(2)).sqrt() - 0.8
        };
        let surface = isosurface::surface(&Field::from_fn(grid, far), 0.0, Caps::Open).unwrap();
        let field = surface.mesh.occupancy(grid, [0.0; 3]).unwrap();
        let volume = surface.mesh.volume();
        // Rays sample the cross-sections: errors of second order in their distance.
        assert!((total(&field) / volume - 1.0).abs() < 1e-3, "{} {volume}", total(&field));
        let mut open = surface.mesh;
        open.triangles.pop();
        assert!(open.occupancy(grid, [0.0; 3]).is_err());
    }
}
