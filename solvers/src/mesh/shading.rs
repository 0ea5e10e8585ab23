//! What a picture of a mesh needs: shared corners and normals that know creases.

use super::{TriangleMesh, dot, unit};
use rayon::slice::ParallelSliceMut;

impl TriangleMesh {
    /// For each vertex the first one at the same place that a triangle uses; 0 for unused ones.
    pub fn first_at_place(&self) -> Vec<u32> {
        let mut order: Vec<u32> = self.triangles.as_flattened().to_vec();
        order.par_sort_unstable();
        order.dedup();
        // -0 is 0.
        let key = |v: u32| self.vertices[v as usize].map(|c| (c + 0.0).to_bits());
        order.par_sort_unstable_by_key(|&v| (key(v), v));
        let mut first = vec![0; self.vertices.len()];
        for same in order.chunk_by(|&a, &b| key(a) == key(b)) {
            same.iter().for_each(|&v| first[v as usize] = same[0]);
        }
        first
    }

    /// The same triangles with equal corners shared; vertices keep the order of their first
    /// use, unused ones are dropped, and triangles that have a corner twice too.
    #[must_use]
    pub fn weld(&self) -> Self {
        let first = self.first_at_place();
        let mut mesh = Self::default();
        let mut number = vec![u32::MAX; self.vertices.len()];
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|v| first[v as usize]);
            if a == b || b == c || c == a {
                continue;
            }
            mesh.triangles.push([a, b, c].map(|v| {
                let new = &mut number[v as usize];
                if *new == u32::MAX {
                    *new = mesh.vertices.len() as u32;
                    mesh.vertices.push(self.vertices[v as usize]);
                }
                *new
            }));
        }
        mesh
    }

    /// Unit normals at the three corners of each triangle: averages by area of the triangles
    /// around the vertex that are within `crease` (radians) of it; zero without area.
    pub fn corner_normals(&self, crease: f64) -> Vec<[[f64; 3]; 3]> {
        let normals: Vec<[f64; 3]> =
            (0..self.triangles.len()).map(|t| self.double_normal(t)).collect();
        let units: Vec<[f64; 3]> = normals.iter().map(|&n| unit(n)).collect();
        let least = crease.cos();
        let mut start = vec![0_u32; self.vertices.len() + 1];
        self.triangles.as_flattened().iter().for_each(|&v| start[v as usize + 1] += 1);
        (0..self.vertices.len()).for_each(|v| start[v + 1] += start[v]);
        let mut around = vec![0_u32; 3 * self.triangles.len()];
        let mut filled = start.clone();
        for (t, triangle) in self.triangles.iter().enumerate() {
            for &v in triangle {
                around[filled[v as usize] as usize] = t as u32;
                filled[v as usize] += 1;
            }
        }
        let corner = |t: usize, v: u32| {
            let range = start[v as usize] as usize..start[v as usize + 1] as usize;
            let mut sum = [0.0; 3];
            for &other in &around[range] {
                if dot(units[t], units[other as usize]) >= least {
                    (0..3).for_each(|m| sum[m] += normals[other as usize][m]);
                }
            }
            unit(sum)
        };
        self.triangles.iter().enumerate().map(|(t, c)| c.map(|v| corner(t, v))).collect()
    }
}
